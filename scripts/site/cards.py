"""Cards of instruments, vehicles, worlds and devices, and a page an instrument that follows its number."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any, Final

import readings
from api import _cell as cell
from api import anchor, module_anchor

from pelagos.config import registry
from pelagos.messages.encoders import ENCODERS
from pelagos.sensors.sonar.keys.devices import DEVICES

ROOT: Final = Path(__file__).parents[2]


def write(source: Path, *, simulate: bool) -> None:
    """Write the cards, the devices and, with the simulator, the walks and pictures."""
    found = readings.all_read(source / "follow") if simulate else {}
    (source / "cards").mkdir(exist_ok=True)
    (source / "follow").mkdir(exist_ok=True)
    entries = registry.entries("sensor", plugins=False)
    lines = ["# Instruments", "", f"{len(entries)} kinds of sensors; `pelagos list sensors` names them.", ""]
    families: dict[str, list[str]] = {}
    for name, entry in entries.items():
        families.setdefault(entry.target.split(".")[2], []).append(name)
    for family, names in families.items():
        lines += [f"## {family.capitalize()}", ""]
        for name in names:
            lines += card(name, entries[name], found.get(name))
    (source / "cards" / "instruments.md").write_text("\n".join(lines), encoding="utf-8")
    (source / "cards" / "vehicles.md").write_text("\n".join(vehicles()), encoding="utf-8")
    (source / "cards" / "worlds.md").write_text("\n".join(worlds()), encoding="utf-8")
    (source / "cards" / "devices.md").write_text("\n".join(devices()), encoding="utf-8")
    index = ["# Follow a number", "", INTRODUCTION, "", "```{toctree}", ":maxdepth: 1", "", *entries, "```", ""]
    (source / "follow" / "index.md").write_text("\n".join(index), encoding="utf-8")
    for name, entry in entries.items():
        (source / "follow" / f"{name}.md").write_text("\n".join(walk(name, entry, found.get(name))), encoding="utf-8")


INTRODUCTION: Final = """\
From a line of a scenario to a number, for each instrument: the configuration, the files that one reading passes in the
order in which it enters them, and the arrays on its way. `pelagos explain SCENARIO AGENT.SENSOR` prints the same for a
scenario of yours. The files are of a reading computed without a recording: a recorded one runs no Python."""


def card(name: str, entry: Any, read: readings.Read | None) -> list[str]:
    """Picture, what a reading holds, sources, message, tests."""
    cls = entry.load()
    lines = [f"### {name.replace('_', ' ')}", ""]
    lines += [
        f"{entry.title}. `type: {name}`; [keys](../scenario/{name}.md), [follow its number](../follow/{name}.md).",
        "",
    ]
    if read is not None and read.picture:
        lines += [f"![One reading of {name}](../follow/{read.picture})", ""]
    lines += prose(inspect.cleandoc(cls.__doc__ or ""))
    if read is not None and not read.arrays:
        lines += ["In the scene of these cards, a vehicle 4 m under water in a harbour, it has nothing to say.", ""]
    elif read is not None:
        lines += ["| array | shape | type |", "|---|---|---|"]
        lines += [f"| `{a}` | {cell(str(shape))} | {kind} |" for a, shape, kind in read.arrays] + [""]
    if cls.SOURCES:
        lines += ["Sources:", "", *(f"* {cell(s)}" for s in cls.SOURCES), ""]
    encoder = ENCODERS.get(name)
    home = (
        f"{encoder.__module__.removeprefix('pelagos.')}.{encoder.__name__}" if encoder else "messages.numbers.numbers"
    )
    lines += [f"Message: `{home}`. A reading takes at most {cls.KERNELS} kernels and {cls.CASTS} casts.", ""]
    proofs = tests_of(name, cls)
    if proofs:
        lines += [f"Tests ({len(proofs)} files): " + ", ".join(f"`{p}`" for p in proofs), ""]
    return lines


def prose(text: str) -> list[str]:
    """A docstring as Markdown: paragraphs, and a bullet for each "name: words" of its lists."""
    lines: list[str] = []
    for paragraph in text.strip().split("\n\n"):
        items: list[str] = []
        for line in paragraph.split("\n"):
            named = re.match(r"(\w[\w, ]{0,30}): (.+)", line) if not line.startswith(" ") else None
            if named and (items or paragraph.startswith(named[0])) and not paragraph.startswith("Reading"):
                items.append(f"* **{named[1]}**: {cell(named[2])}")
            elif items:
                items[-1] += f" {cell(line.strip())}"
            else:
                lines.append(cell(line))
        lines += [*items, ""]
    return lines


def vehicles() -> list[str]:
    """A row for each vehicle of the catalogue, from its page."""
    lines = [
        "# Vehicles",
        "",
        "`pelagos list vehicles` names them; [Vehicles](../vehicles.md) says how to make your own.",
        "",
    ]
    lines += ["| vehicle | | length x beam x height | mass | control modes |", "|---|---|---|---|---|"]
    for page in sorted((ROOT / "docs" / "vehicles").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        about = text.split("\n\n")[1].replace("\n", " ")
        facts = dict(re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", text, re.M))
        modes = re.findall(r"^\| `(\w+)` \|", text.partition("## Control modes")[2].partition("\n## ")[0], re.M)
        size, mass = (facts.get(k, "") for k in ("length x beam x height", "mass"))
        lines.append(
            f"| [{page.stem}](../vehicles/{page.stem}.md) | {cell(about)} | {size} | {mass} | "
            f"{', '.join(f'`{m}`' for m in modes)} |"
        )
    return [*lines, ""]


def worlds() -> list[str]:
    """A card for each kind of world."""
    lines = [
        "# Worlds",
        "",
        "`pelagos list worlds` names them; [Worlds](../worlds.md) and [large ones](../worlds_large.md)",
    ]
    lines += ["show how to use them.", "", "![Kinds of generated worlds](../images/world_kinds.jpg)", ""]
    for name, entry in registry.entries("world", plugins=False).items():
        tests = tests_naming(rf"\b{entry.config.__name__}\b|type: {name}\b|\"type\": \"{name}\"")
        lines += [f"## {name}", "", f"{entry.title}. `type: {name}`; [keys](../scenario/{name}.md).", ""]
        lines += [*prose(inspect.cleandoc(entry.config.__doc__ or "")), ""]
        lines += [f"Tests ({len(tests)} files): " + ", ".join(f"`{p}`" for p in tests), ""] if tests else []
    return lines


def tests_of(name: str, cls: type) -> list[str]:
    """Test files that name a sensor's class, configuration or type."""
    return tests_naming(rf"\b({cls.__name__}|{cls.Config.__name__}|type: {name}\b|\"{name}\")")


def tests_naming(pattern: str) -> list[str]:
    """Test files in which a pattern is found."""
    words = re.compile(pattern)
    files = sorted(p for p in (ROOT / "tests").rglob("test_*.py") if words.search(p.read_text(encoding="utf-8")))
    return [str(p.relative_to(ROOT / "tests")) for p in files]


def walk(name: str, entry: Any, read: readings.Read | None) -> list[str]:
    """The page of one instrument."""
    lines = [
        f"# {name.replace('_', ' ')}",
        "",
        f"{entry.title}.",
        "",
        "```yaml",
        f"{name}: {{type: {name}}}",
        "```",
        "",
    ]
    if read is None:
        return [*lines, "This page was built without the simulator.", ""]
    path = entry.target.split(":")[0].removeprefix("pelagos.")
    first = path.split(".")[0]
    config = entry.config
    lines += ["## 1. Its configuration", ""]
    page = f"../api/{first}.md#{anchor(config.__module__.removeprefix('pelagos.'), config.__name__)}"
    lines += [f"[{len(config.model_fields)} keys](../scenario/{name}.md), of [`{config.__name__}`]({page}).", ""]
    lines += [f"## 2. The {len(read.rooms)} files of one reading", "", "| file | functions |", "|---|---|"]
    lines += [
        f"| {page_of(room)} | {', '.join(f'`{f}`' for f in plain(names)[:12])} |" for room, names in read.rooms.items()
    ]
    lines += [
        "",
        "## 3. Its arrays",
        "",
        "| array | shape | least | mean | greatest | unit |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {cell(n)} | {cell(str(shape))} | {low} | {mean} | {high} | {cell(unit)} |"
        for n, shape, low, mean, high, unit in read.steps
    ]
    lines += [
        "",
        "## 4. Its sources",
        "",
        *(f"* {cell(s)}" for s in entry.load().SOURCES or ("none: it is the true state",)),
        "",
    ]
    if read.picture:
        lines += [f"![One reading of {name}]({read.picture})", ""]
    return lines


def page_of(room: str) -> str:
    """A file, with a link to its section of the Python interface where it has one."""
    path = room.removesuffix(".py").replace("/", ".")
    return f"[`{room}`](../api/{path.split('.')[0]}.md#{module_anchor(path)})"


def plain(names: list[str]) -> list[str]:
    """Functions without those inside of others, each once."""
    return list(dict.fromkeys(n.partition(".<locals>")[0] for n in names))


def devices() -> list[str]:
    """Sonars by their data sheets."""
    lines = [
        "# Devices",
        "",
        "Real sonars by their data sheets: `device: NAME` fills the keys that a scenario leaves out.",
        "",
    ]
    for kind, known in DEVICES.items():
        lines += [f"## {kind.replace('_', ' ')}", "", "| device | | source | assumed |", "|---|---|---|---|"]
        lines += [
            f"| `{name}` | {cell(d.title)} | {cell(d.source)} | {cell(', '.join(d.assumed))} |"
            for name, d in known.items()
        ]
        lines.append("")
    return lines
