"""House rules about words that a linter does not know."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from definitions import module

ROOT = Path(__file__).parents[2]
QUESTION = re.compile(r"\s*(What|Which|Where|How|Whether|Who|When|Why)\b")


def test_module_docstrings_open_with_a_noun_phrase() -> None:
    """A definition opens with a noun that a stranger understands alone, not with a relative clause."""
    files = [p for folder in ("src", "scripts", "examples") for p in (ROOT / folder).rglob("*.py")]
    assert len(files) > 400
    assert not [str(p.relative_to(ROOT)) for p in files if QUESTION.match(module(p).words)]


def test_docstrings_open_with_a_noun_phrase() -> None:
    """So do classes and functions; "whether" is how a truth value begins."""
    asked = re.compile(r"(What|Which|Where|How|Who|When|Why)\b")
    found = [
        f"{file.relative_to(ROOT)}: {definition.name}"
        for file in (ROOT / "src").rglob("*.py")
        for definition in module(file).definitions
        if asked.match(definition.words)
    ]
    assert not found


def test_every_page_of_the_documentation_can_be_reached_from_its_index() -> None:
    docs = ROOT / "docs"
    found, waiting = set(), [docs / "index.md"]
    while waiting:
        page = waiting.pop()
        found.add(page)
        for link in re.findall(r"\]\(([^)#\s]+\.md)", page.read_text(encoding="utf-8")):
            target = (page.parent / link).resolve()
            if target.exists() and target.is_relative_to(docs) and target not in found:
                waiting.append(target)
    assert not sorted(str(p.relative_to(docs)) for p in docs.rglob("*.md") if p not in found)


def test_code_that_the_theory_names_exists() -> None:
    """In a column of the theory or of the symbols, names stand behind the file that defines them."""
    pages = [*(ROOT / "docs" / "theory").glob("*.md"), ROOT / "docs" / "conventions.md"]
    rows = [line for p in pages for line in p.read_text(encoding="utf-8").splitlines() if ".py`" in line]
    assert len(rows) > 80
    missing = []
    for row in rows:
        known: set[str] | None = None
        for word in re.findall(r"`([\w/.]+)`", row.rstrip("| ").rpartition("|")[2]):
            if word.endswith(".py"):
                file = ROOT / "src" / "pelagos" / word
                known = _defined(file) if file.exists() else None
                missing += [] if file.exists() else [word]
            elif known is not None and word.partition(".")[0] not in known:
                missing.append(f"{word} in {row[:60]}")
    assert not missing


def test_sensors_tolerate_no_forged_context() -> None:
    """A sensor asks its context, ocean and configuration for what their types have; only capabilities of a class, which
    are written in capitals, may be absent."""
    tolerant = [
        f"{file.relative_to(ROOT)}:{node.lineno}"
        for file in (ROOT / "src" / "pelagos" / "sensors").rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and _tolerates(node.func.id, node.args)
    ]
    assert not tolerant


def _tolerates(function: str, arguments: list[ast.expr]) -> bool:
    """Whether a call asks for an attribute that may be absent: `hasattr`, or `getattr` with a default."""
    if function == "getattr" and len(arguments) == 3:
        return not (isinstance(arguments[1], ast.Constant) and str(arguments[1].value).isupper())
    return function == "hasattr"


def _defined(file: Path) -> set[str]:
    """Names of the functions, classes, methods and fields of a module."""
    found = {definition.name for definition in module(file).definitions}
    nodes = ast.walk(ast.parse(file.read_text(encoding="utf-8")))
    return found | {n.target.id for n in nodes if isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name)}
