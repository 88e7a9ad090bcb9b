"""Pages of the Python interface, one a package, from signatures and docstrings read by griffe."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any, Final

import griffe
import house

ROOT: Final = Path(__file__).parents[2]
_MACHINERY: Final = (
    "picture",
    "ping",
    "scan",
    "sample",
    "link",
    "keys",
    "kinds",
    "generate",
    "shape",
    "terms",
    "cases",
)


def write(folder: Path) -> None:
    """One page for each package of the house, and an index with the public names."""
    folder.mkdir(parents=True, exist_ok=True)
    whole = griffe.load("pelagos", search_paths=[str(ROOT / "src")], docstring_parser="google")
    packages = [p for row in house.layers() for p in row]
    for name in packages:
        (folder / f"{name}.md").write_text("\n".join(page(name, whole[name])), encoding="utf-8")
    (folder / "index.md").write_text("\n".join(index(packages, whole)), encoding="utf-8")


def index(packages: list[str], whole: Any) -> list[str]:
    """The public face, and a tree of packages in the order of the layers."""
    lines = ["# Python interface", "", "Names of `import pelagos as pl`:", "", "| name | |", "|---|---|"]
    import pelagos

    for name in pelagos.__all__:
        if name in pelagos._HOMES:
            home = pelagos._HOMES[name].removeprefix("pelagos.")
            package = home.split(".")[0]
            first = _first(whole[f"{home}.{name}"])
            lines.append(f"| [`pl.{name}`]({package}.md#{anchor(home, name)}) | {first.replace('|', ' ')} |")
    lines += [
        "",
        "Packages, by layer; each imports only from those that follow.",
        "",
        "```{toctree}",
        ":maxdepth: 1",
        "",
    ]
    return [*lines, *packages, "```", ""]


def page(name: str, package: Any) -> list[str]:
    """All public classes and functions of a package, module by module."""
    lines = [f"# {name}", "", _text(package), ""]
    for module in modules(package):
        path = module.path.removeprefix("pelagos.")
        members = [m for m in module.members.values() if _shown(m, module)]
        if not members and not module.docstring:
            continue
        room = any(part in _MACHINERY for part in path.split(".")[1:])
        lines += [f"({module_anchor(path)})=", "", f"## {path.removeprefix(f'{name}.')}", ""]
        lines += [f"{_text(module)}{' *(machinery)*' if room else ''}", ""]
        for member in members:
            lines += [f"({anchor(path, member.name)})=", ""]
            lines += described(member, 3)
    return lines


def modules(package: Any) -> Iterator[Any]:
    """A package's modules in the order of their names: its own first, then those of its rooms, machinery last."""
    yield package
    inner = [m for m in package.members.values() if not m.is_alias and m.is_module]
    for member in sorted(inner, key=lambda m: (m.is_init_module, m.name in _MACHINERY, m.name)):
        yield from modules(member)


def described(thing: Any, level: int) -> list[str]:
    """A heading, the signature, and the docstring; of a class also its methods."""
    lines = [f"{'#' * level} {_plain(thing.name)}", "", "```python", _signature(thing), "```", "", _text(thing), ""]
    lines += _sections(thing)
    if thing.is_class:
        fields = [a for a in thing.attributes.values() if a.docstring and not a.name.startswith("_") and not a.is_alias]
        if fields:
            lines += ["| field | default | |", "|---|---|---|"]
            lines += [f"| `{a.name}` | {_default(a)} | {_cell(a.docstring.value)} |" for a in fields]
            lines.append("")
        for method in thing.functions.values():
            if not method.name.startswith("_") and not method.is_alias and method.docstring:
                lines += ["```python", _signature(method), "```", "", _text(method), "", *_sections(method)]
    return lines


def anchor(path: str, name: str) -> str:
    """The target of a name in the site."""
    kind = "class" if name[:1].isupper() else "function"
    return f"{kind}-{path}-{name}".replace(".", "-").replace("_", "-").lower()


def module_anchor(path: str) -> str:
    """The target of a module in the site."""
    return f"module-{path}".replace(".", "-").replace("_", "-").lower()


def _shown(member: Any, module: Any) -> bool:
    if member.is_alias or member.name.startswith("_"):
        return False
    return bool((member.is_class or member.is_function) and member.docstring)


def _signature(thing: Any) -> str:
    if thing.is_class:
        bases = ", ".join(str(b) for b in thing.bases)
        return f"class {thing.name}({bases})" if bases else f"class {thing.name}"
    shown = []
    star = False
    for p in thing.parameters:
        if p.name in ("self", "cls"):
            continue
        if p.kind is griffe.ParameterKind.keyword_only and not star:
            shown.append("*")
            star = True
        mark = {griffe.ParameterKind.var_positional: "*", griffe.ParameterKind.var_keyword: "**"}.get(p.kind, "")
        star = star or mark == "*"
        text = f"{mark}{p.name}" + (f": {p.annotation}" if p.annotation else "")
        shown.append(text + (f" = {p.default}" if p.default is not None and not mark else ""))
    whole = f"def {thing.name}({', '.join(shown)}) -> {thing.returns}"
    if len(whole) <= 100:
        return whole
    return f"def {thing.name}(\n    " + ",\n    ".join(shown) + f",\n) -> {thing.returns}"


def _parsed(thing: Any) -> list[Any]:
    return list(thing.docstring.parsed) if thing.docstring else []


def _text(thing: Any) -> str:
    """The running text of a docstring as Markdown."""
    found = [s.value for s in _parsed(thing) if s.kind is griffe.DocstringSectionKind.text]
    return "\n\n".join(_markdown(t) for t in found)


def _sections(thing: Any) -> list[str]:
    """Lists of arguments, attributes, results and errors."""
    kinds = {
        griffe.DocstringSectionKind.parameters: "Arguments",
        griffe.DocstringSectionKind.attributes: "Attributes",
        griffe.DocstringSectionKind.returns: "Returns",
        griffe.DocstringSectionKind.raises: "Raises",
    }
    lines: list[str] = []
    for section in _parsed(thing):
        if section.kind not in kinds:
            continue
        lines += [f"**{kinds[section.kind]}**", ""]
        for item in section.value:
            name = getattr(item, "name", "") or str(getattr(item, "annotation", "") or "")
            words = _markdown(item.description).replace("\n", " ")
            lines.append(
                f"* `{name}`: {words}"
                if name and section.kind is not griffe.DocstringSectionKind.returns
                else f"* {words}"
            )
        lines.append("")
    return lines


def _markdown(text: str) -> str:
    """Docstrings as they are, with what Markdown would read as markup outside of code made plain."""
    parts = re.split(r"(`[^`]*`)", text)
    for k in range(0, len(parts), 2):
        parts[k] = re.sub(r"([*_<>\[\]{}$|\\])", r"\\\1", parts[k])
    return "".join(parts)


def _first(thing: Any) -> str:
    return _text(thing).split("\n")[0]


def _cell(text: str) -> str:
    return _markdown(" ".join(text.split()))


def _default(attribute: Any) -> str:
    value = attribute.value
    if value is None:
        return ""
    for argument in getattr(value, "arguments", ()):
        if getattr(argument, "name", "") == "default":
            return f"`{escape(str(argument.value), quote=False)}`".replace("|", " or ")
    text = str(value)
    return "" if text.startswith("Field(") or len(text) > 40 else f"`{text}`".replace("|", " or ")


def _plain(name: str) -> str:
    return name.replace("_", r"\_")
