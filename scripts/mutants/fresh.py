"""Mistakes that nobody listed: drawn at random from formulas or decisions of the source, with the tests near them."""

from __future__ import annotations

import ast
import json
import math
import random
import re
from collections import Counter, defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from by_line import tests_by_line
from decisions import decisions
from mutant import LISTS, ROOT, SOURCES, Mutant, read_list, read_mutants

LAYERS = (
    "acoustics", "contact", "hydro", "manoeuvres", "math", "messages", "navigation", "ocean", "optics", "raycast",
    "sensors", "sim", "vehicles", "world",
)  # fmt: skip
"""Where formulas live."""
DECIDING = (*LAYERS, "bridges", "cli", "compat", "config", "datasets", "envs", "identification")
"""Where it is decided what is done and what is refused; not what a picture or a page looks like."""
DECORATION = re.compile(r"(memory|chunk|bytes?_|_bytes|budget|warn\w*\()", re.IGNORECASE)
"""Lines about portions of memory or what people are told: a mistake there changes no number."""
FOLDERS = ("unit", "verification", "cross_code", "contracts", "compat")
KNOWN = {
    "company": ("acoustics", "contact", "navigation", "sensors", "sim"),
    "configs": ("config",),
    "doors": ("bridges", "messages"),
    "episodes": ("envs",),
    "sensors": ("acoustics", "optics", "raycast", "sensors", "world", "ocean"),
    "vehicles": ("contact", "hydro", "navigation", "sim", "vehicles", "ocean"),
    "worlds": ("ocean", "raycast", "world"),
}
"""Layers whose numbers `tests/contracts/test_known_*.py` hold."""
MEANT = 4  # letters of a name that is looked for
MOST_CALLERS = 4
MOST_TESTS = 6  # files of one trial
OTHER = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*")}
TWIN = {"sin": "cos", "cos": "sin", "minimum": "maximum", "maximum": "minimum", "sinh": "cosh", "cosh": "sinh"}


def draw(seed: int, count: int, *, of_decisions: bool = False) -> list[Mutant]:
    """About `count` mutants, more from layers with more formulas; the same for the same source and seed.

    Of decisions instead of formulas where that is asked for.
    """
    layers, kind = (DECIDING, decisions) if of_decisions else (LAYERS, mistakes)
    rng = random.Random(seed)
    named = _Tests()
    found: dict[str, list[tuple[str, str, str]]] = defaultdict(list)
    for layer in layers:
        for path in sorted((SOURCES / layer).rglob("*.py")):
            file = path.relative_to(SOURCES).as_posix()
            found[layer] += [(file, text, mutation) for text, mutation in kind(path.read_text())]
    whole = sum(math.sqrt(len(entries)) for entries in found.values())
    drawn = []
    for layer, entries in found.items():
        for file, text, mutation in rng.sample(entries, min(len(entries), round(count * len(entries) ** 0.5 / whole))):
            drawn.append(Mutant(layer, file, text, mutation, named.of(file, text)))
    rng.shuffle(drawn)
    return [m for m in drawn if m.tests]


def with_tests(path: Path) -> list[Mutant]:
    """Mutants of somebody's list that names no tests, each with those that are near; of one that fits no more, none."""
    named = _Tests()
    return [m if m.tests or not _fits(m) else replace(m, tests=named.of(m.file, m.text)) for m in read_list(path)]


def _fits(mutant: Mutant) -> bool:
    """Whether its text stands once in its file."""
    path = SOURCES / mutant.file
    return path.is_file() and path.read_text().count(mutant.text) == 1


def mistakes(source: str) -> Iterator[tuple[str, str]]:
    """Lines that stand once in the source, each with one sign, factor, index, axis or function changed."""
    lines = source.splitlines()
    for function in (n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.FunctionDef) and not _words(n)):
        for node in (n for statement in function.body for n in _formulas(statement)):
            line = lines[node.lineno - 1]
            text, indent = line.strip(), len(line) - len(line.lstrip())
            if node.lineno != node.end_lineno or source.count(text) != 1 or DECORATION.search(text):
                continue
            start, end = node.col_offset - indent, (node.end_col_offset or 0) - indent
            old = text.encode()[start:end].decode()
            new = _changed(node, old)
            if new not in (None, old):
                yield text, (text.encode()[:start] + str(new).encode() + text.encode()[end:]).decode()


def _words(function: ast.FunctionDef) -> bool:
    """A function that answers with text, or is for people who print: its numbers are no formula."""
    told = function.returns is not None and ast.unparse(function.returns) in ("str", "str | None", "Iterator[str]")
    return told or function.name.startswith(("__repr", "_repr", "__str", "explain"))


def _formulas(node: ast.AST) -> Iterator[ast.expr]:
    """Expressions of a statement, but for types, what is raised or asserted, and texts."""
    if isinstance(node, (ast.Raise, ast.Assert, ast.JoinedStr, ast.FunctionDef, ast.ClassDef)):
        return  # functions within functions are walked on their own
    if isinstance(node, ast.expr):
        yield node
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns"):
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from _formulas(child)


def _changed(node: ast.expr, old: str) -> str | None:
    """The expression with a mistake in it; None where no kind of mistake fits."""
    match node:
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OTHER and not (_text(left) or _text(right)):
            sign, other = OTHER[type(op)]
            left_end, right_start = left.end_col_offset or 0, right.col_offset
            a, b = left_end - node.col_offset, right_start - node.col_offset
            return old[:a] + old[a:b].replace(sign, other) + old[b:] if old[a:b].strip() == sign else None
        case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=2)):
            return old[: old.rindex("**")].rstrip()
        case ast.Call(func=ast.Attribute(attr=name)) if name in TWIN:
            return old.replace(f".{name}(", f".{TWIN[name]}(", 1)
        case ast.Subscript(slice=ast.Constant(value=int(k))) if k in (0, 1) and old.endswith(f"{k}]"):
            return f"{old[:-2]}{1 - k}]"
        case ast.UnaryOp(op=ast.USub(), operand=operand) if not isinstance(operand, ast.Constant):
            return old.replace("-", "+", 1)
        case ast.Attribute(attr="x" | "y" as axis, ctx=ast.Load()):
            return old[:-1] + ("y" if axis == "x" else "x")
    return None


def _text(node: ast.expr) -> bool:
    return isinstance(node, (ast.List, ast.Tuple, ast.JoinedStr)) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str)
    )


class _Tests:
    """Which tests are near a mistake: those that ran its line, or else files by what they noticed before, by names, and
    by what imports what.
    """

    def __init__(self) -> None:
        self.by_line = tests_by_line()
        self.tests = [p for folder in FOLDERS for p in sorted((ROOT / "tests" / folder).glob("test_*.py"))]
        self.by_module: Mapping[str, list[str]] = self._importers(self.tests)
        self.users: Mapping[str, list[str]] = self._importers(sorted(SOURCES.rglob("*.py")))
        self.texts = {p.relative_to(ROOT).as_posix(): p.read_text() for p in self.tests}
        self.sources = {p.relative_to(SOURCES).as_posix(): p.read_text() for p in sorted(SOURCES.rglob("*.py"))}
        self.noticed: Mapping[str, list[str]] = self._noticed()

    @staticmethod
    def _noticed() -> dict[str, list[str]]:
        """Source files, and the test files that saw a listed mistake in each."""
        known = json.loads((LISTS.parent / "noticed.json").read_text())
        found: dict[str, list[str]] = defaultdict(list)
        for mutant in read_mutants():
            if mutant.key in known:
                found[mutant.file].append(known[mutant.key].split("::")[0])
        return found

    @staticmethod
    def _importers(paths: list[Path]) -> dict[str, list[str]]:
        """Modules of Pelagos, and the files that import each."""
        found: dict[str, list[str]] = defaultdict(list)
        for path in paths:
            for node in ast.walk(ast.parse(path.read_text())):
                names = []
                if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("pelagos"):
                    names = [str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)]
                for name in dict.fromkeys(names):
                    found[name].append(path.relative_to(ROOT).as_posix())
        return found

    def of(self, file: str, text: str) -> tuple[str, ...]:
        """Test files for a mistake in a line: those that saw one in this file before, that name the line's function,
        that are near to who calls it, and that import the file, directly or through others; small ones first.
        """
        ran = self.by_line.of(file, text) if self.by_line else ()
        if ran:
            return ran
        name = _function_of((SOURCES / file).read_text(), text)
        word = re.compile(rf"\b{name}\b") if len(name) > MEANT else None
        named = [t for t, source in self.texts.items() if word and word.search(source)]
        callers = [u for u, source in self.sources.items() if word and u != file and word.search(source)]
        seen = Counter(t for u in callers for t in self.noticed.get(u, ()))
        near = [t for u in callers[:MOST_CALLERS] for t in self.by_module.get(_module(u), ())]
        close = [*(t for t, _ in seen.most_common()), *self._small_first(near)]
        groups = [self.noticed.get(file, ()), self._small_first(named), close]
        chosen = dict.fromkeys(t for group in groups for t in tuple(group)[: MOST_TESTS // 2])
        chosen |= dict.fromkeys(self._by_import(file))
        known = [
            f"tests/contracts/test_known_{part}.py" for part, layers in KNOWN.items() if file.split("/")[0] in layers
        ]
        return (*[t for t in chosen if (ROOT / t).exists() and t not in known][:MOST_TESTS], *known)

    @staticmethod
    def _small_first(tests: Iterable[str]) -> list[str]:
        """Each once."""
        return sorted({t for t in tests if (ROOT / t).exists()}, key=lambda t: (ROOT / t).stat().st_size)

    def _by_import(self, file: str) -> list[str]:
        """Test files, nearest first."""
        seen, chosen = {file}, dict[str, None]()
        level = deque([file])
        while level and len(chosen) < MOST_TESTS:
            modules = [_module(f) for f in level]
            chosen |= dict.fromkeys(self._small_first(t for m in modules for t in self.by_module.get(m, ())))
            users = {u.removeprefix("src/pelagos/") for m in modules for u in self.users.get(m, ())}
            level = deque(sorted(users - seen))
            seen |= users
        return list(chosen)


def _function_of(source: str, text: str) -> str:
    """Name of the innermost function or property that a line stands in; empty outside."""
    at = source[: source.index(text)].count("\n") + 1
    functions = [n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.FunctionDef)]
    within = [n for n in functions if n.lineno <= at <= (n.end_lineno or 0)]
    return max(within, key=lambda n: n.lineno).name.lstrip("_") if within else ""


def _module(file: str) -> str:
    return "pelagos." + file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
