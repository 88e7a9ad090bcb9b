"""Mistakes in what a source decides: an operand of a condition dropped, a second branch never taken, a limit off by
one, an option not handed on.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator

Text = Callable[[ast.AST], str]

SWAPPED = {"any": "all", "all": "any", "min": "max", "max": "min"}
LOOKS = {
    "strict", "dtype", "copy", "markup", "style", "color", "fill", "width", "linewidth", "fontsize", "font", "alpha",
    "zorder", "detail",
}  # fmt: skip
"""Options that change neither a number nor a decision: how a thing looks, what type it has already."""
DRAWN = ("axes", "figure", "draw", "plt", "out", "ax", "fig", "np")
INCLUSIVE = {ast.Lt: ("<", "<="), ast.LtE: ("<=", "<"), ast.Gt: (">", ">="), ast.GtE: (">=", ">")}


def decisions(source: str) -> Iterator[tuple[str, str]]:
    """Lines that stand once in the source, each with one decision of it taken wrongly."""
    lines = source.splitlines()
    for node in _of_functions(ast.parse(source)):
        line = lines[node.lineno - 1]
        text, indent = line.strip(), len(line) - len(line.lstrip())
        if node.lineno != node.end_lineno or source.count(text) != 1:
            continue
        start, end = node.col_offset - indent, (node.end_col_offset or 0) - indent
        encoded = text.encode()
        for new in _mistaken(node, lambda part: ast.get_source_segment(source, part) or ""):
            changed = (encoded[:start] + new.encode() + encoded[end:]).decode()
            if changed != text:
                yield text, changed


def _of_functions(tree: ast.Module) -> Iterator[ast.expr]:
    """Expressions within functions, but for types, decorators and what is raised."""
    for function in (n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)):
        waiting: list[ast.AST] = list(function.body)
        while waiting:
            node = waiting.pop(0)
            if isinstance(node, (ast.Raise, ast.Assert, ast.JoinedStr, ast.FunctionDef, ast.ClassDef)):
                continue  # functions within functions are walked on their own
            if isinstance(node, ast.expr):
                yield node
            fields = (value for name, value in ast.iter_fields(node) if name not in ("annotation", "returns"))
            waiting += [
                c for value in fields for c in (value if isinstance(value, list) else [value]) if isinstance(c, ast.AST)
            ]


def _mistaken(node: ast.expr, text: Text) -> Iterator[str]:
    """The expression with a mistake in it; none where no kind of mistake fits."""
    match node:
        case ast.BoolOp(op=op, values=values):
            word = " and " if isinstance(op, ast.And) else " or "
            for dropped in range(len(values)):
                yield "(" + word.join(f"({text(v)})" for k, v in enumerate(values) if k != dropped) + ")"
        case ast.IfExp(body=body, orelse=other):
            yield f"({text(body)})"
            yield f"({text(other)})"
        case ast.Compare(left=left, ops=[op], comparators=[ast.Constant(value=int()) as limit]) if (
            type(op) in INCLUSIVE
        ):
            yield f"{text(left)} {INCLUSIVE[type(op)][1]} {text(limit)}"
        case ast.Call(func=ast.Name(id=name), args=args) if name in SWAPPED and (
            len(args) > 1 or name in ("any", "all")
        ):
            yield SWAPPED[name] + text(node)[len(name) :]
            if name in ("min", "max") and len(args) > 1:
                yield from (f"({text(a)})" for a in args)
        case ast.Call(keywords=[*_, ast.keyword(arg=str())] as keywords) if text(node.func).split(".")[0] not in DRAWN:
            for keyword in (k for k in keywords if k.arg and k.arg not in LOOKS):
                kept = [text(part) for part in [*node.args, *keywords] if part is not keyword]
                yield f"{text(node.func)}({', '.join(kept)})"
