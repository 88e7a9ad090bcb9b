"""Mistakes that nobody listed: drawn at random from the formulas of the source, with the tests that import them."""

from __future__ import annotations

import ast
import math
import random
import re
from collections import defaultdict, deque
from collections.abc import Iterator, Mapping
from pathlib import Path

from mutant import ROOT, SOURCES, Mutant

LAYERS = (
    "acoustics", "contact", "hydro", "manoeuvres", "math", "messages", "navigation", "ocean", "optics", "raycast",
    "sensors", "sim", "vehicles", "world",
)  # fmt: skip
"""Where formulas live."""
FOLDERS = ("unit", "verification", "cross_code", "contracts", "compat")
MOST_TESTS = 4  # files of one trial
OTHER = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*")}
TWIN = {"sin": "cos", "cos": "sin", "minimum": "maximum", "maximum": "minimum", "sinh": "cosh", "cosh": "sinh"}


def draw(seed: int, count: int) -> list[Mutant]:
    """About `count` mutants, more from layers with more formulas; the same for the same source and seed."""
    rng = random.Random(seed)
    named = _Tests()
    found: dict[str, list[tuple[str, str, str]]] = defaultdict(list)
    for layer in LAYERS:
        for path in sorted((SOURCES / layer).rglob("*.py")):
            file = path.relative_to(SOURCES).as_posix()
            found[layer] += [(file, text, mutation) for text, mutation in mistakes(path.read_text())]
    whole = sum(math.sqrt(len(entries)) for entries in found.values())
    drawn = []
    for layer, entries in found.items():
        for file, text, mutation in rng.sample(entries, min(len(entries), round(count * len(entries) ** 0.5 / whole))):
            drawn.append(Mutant(layer, file, text, mutation, named.of(file)))
    rng.shuffle(drawn)
    return [m for m in drawn if m.tests]


def mistakes(source: str) -> Iterator[tuple[str, str]]:
    """Lines that stand once in the source, each with one sign, factor, index, axis or function changed."""
    lines = source.splitlines()
    for function in (n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.FunctionDef)):
        for node in ast.walk(function):
            if not isinstance(node, ast.expr) or node.lineno != node.end_lineno:
                continue
            line = lines[node.lineno - 1]
            text, indent = line.strip(), len(line) - len(line.lstrip())
            if source.count(text) != 1 or re.search(r"Error\(|f\"|raise ", text):
                continue
            start, end = node.col_offset - indent, (node.end_col_offset or 0) - indent
            old = text.encode()[start:end].decode()
            new = _changed(node, old)
            if new not in (None, old):
                yield text, (text.encode()[:start] + str(new).encode() + text.encode()[end:]).decode()


def _changed(node: ast.expr, old: str) -> str | None:
    """The expression with a mistake in it; None where no kind of mistake fits."""
    match node:
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OTHER and not (_text(left) or _text(right)):
            sign, other = OTHER[type(op)]
            left_end, right_start = left.end_col_offset or 0, right.col_offset
            a, b = left_end - node.col_offset, right_start - node.col_offset
            return old[:a] + old[a:b].replace(sign, other) + old[b:] if old[a:b].strip() == sign else None
        case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=2)):
            return old[: (left.end_col_offset or 0) - node.col_offset]
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
    """Which test files are near a source file: those that import it, then those that import what imports it."""

    def __init__(self) -> None:
        self.tests = [p for folder in FOLDERS for p in sorted((ROOT / "tests" / folder).glob("test_*.py"))]
        self.by_module: Mapping[str, list[str]] = self._importers(self.tests)
        self.users: Mapping[str, list[str]] = self._importers(sorted(SOURCES.rglob("*.py")))

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

    def of(self, file: str) -> tuple[str, ...]:
        """Test files, nearest first, small ones before large ones."""
        seen, chosen = {file}, dict[str, None]()
        level = deque([file])
        while level and len(chosen) < MOST_TESTS:
            modules = [_module(f) for f in level]
            near = {t for m in modules for t in self.by_module.get(m, ())}
            chosen |= dict.fromkeys(sorted(near, key=lambda t: (ROOT / t).stat().st_size))
            users = {u.removeprefix("src/pelagos/") for m in modules for u in self.users.get(m, ())}
            level = deque(sorted(users - seen))
            seen |= users
        return tuple(chosen)[:MOST_TESTS]


def _module(file: str) -> str:
    return "pelagos." + file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
