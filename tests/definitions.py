"""Modules, classes and functions of source files, each file parsed once for all tests that look at them."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

_KINDS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")


@dataclass(frozen=True)
class Definition:
    """A function or class: its name and docstring, its lines, and how many parameters need no name (None: a class)."""

    name: str
    words: str
    lines: int
    positional: int | None


@dataclass(frozen=True)
class Module:
    """A file: its docstring, its lines, and all that is defined in it, at any depth."""

    words: str
    lines: int
    definitions: tuple[Definition, ...]


@cache
def module(file: Path) -> Module:
    """What a file defines."""
    text = file.read_text(encoding="utf-8")
    tree = ast.parse(text)
    found = tuple(map(_described, _defined(tree)))
    return Module(ast.get_docstring(tree) or "", text.count("\n"), found)


def _defined(node: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef]:
    """Functions and classes: statements alone are looked through, as no expression holds one."""
    for block in _BLOCKS:
        children = getattr(node, block, ())
        for child in children if isinstance(children, list) else ():  # a lambda's body is an expression
            if isinstance(child, _KINDS):
                yield child
            yield from _defined(child)


def _described(node: ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) -> Definition:
    assert node.end_lineno is not None
    positional = None
    if not isinstance(node, ast.ClassDef):
        positional = len([a for a in (*node.args.posonlyargs, *node.args.args) if a.arg not in ("self", "cls")])
    lines = node.end_lineno - node.lineno + 1
    return Definition(node.name, ast.get_docstring(node) or "", lines, positional)
