"""Home and the order of the pages."""

from __future__ import annotations

from pathlib import Path
from typing import Final

HOME: Final = """\
# Pelagos

Pelagos simulates underwater and surface vehicles with their sonars, cameras and navigation sensors on a laptop's CPU.
Everything is one vectorised program: **vehicles are batches of states, and everything that looks at the world, or
touches it, is a ray.** Every physical function cites its source and is tested against numbers that somebody else
published: the list is [Checks](checks.md); beside recordings of real vehicles and seas it stands in [Proof](proof.md).

![A survey of a harbour: camera, imaging sonar and multibeam map](images/harbour.png)

::::{{grid}} 1 2 3 3
:gutter: 2

:::{{grid-item-card}} Start
:link: getting_started
:link-type: doc
Install, first run, first scenario, first loop in Python: from zero to a picture in five minutes.
:::
:::{{grid-item-card}} Follow a number
:link: follow/index
:link-type: doc
From a line of YAML to a number: the files that a reading of each instrument really passes.
:::
:::{{grid-item-card}} Instruments
:link: cards/instruments
:link-type: doc
A card for each: picture, outputs with shapes and units, sources, proof, ROS message.
:::
:::{{grid-item-card}} Vehicles
:link: cards/vehicles
:link-type: doc
Every number of every vehicle, with its source.
:::
:::{{grid-item-card}} Worlds
:link: cards/worlds
:link-type: doc
Harbours, real seabeds, generated ground, ground of any size.
:::
:::{{grid-item-card}} Scenario
:link: scenario/index
:link-type: doc
Every key of a scenario file, one page a component.
:::
:::{{grid-item-card}} Conventions
:link: conventions
:link-type: doc
Frames, signs and shapes, beside those of Fossen, HoloOcean, ROS and Gazebo; symbols; words.
:::
:::{{grid-item-card}} Theory
:link: theory/index
:link-type: doc
Each equation with its source, its limits and its file.
:::
:::{{grid-item-card}} Proof
:link: proof
:link-type: doc
Simulated beside recorded vehicles, devices and seas; and [every numeric check](checks.md).
:::
:::{{grid-item-card}} Write your own
:link: write_a_sensor
:link-type: doc
A sensor in NumPy, in rays or in Dr.Jit; [recipes](CONTRIBUTING.md) for vehicles and worlds.
:::
:::{{grid-item-card}} Python interface
:link: api/index
:link-type: doc
Every public name, by layer.
:::
:::{{grid-item-card}} Benchmarks
:link: benchmarks
:link-type: doc
Speed beside peers and limits, [as measured](benchmarks_results.md).
:::
::::

## The house

Each layer imports only from those below. A box leads to its package.

```{{raw}} html
{house}
```
"""

PARTS: Final = {
    "Start": (
        "From nothing to a first mission.", ["getting_started", "simulation", "view", "command_line", "recording"]
    ),
    "Use": (
        "What can be simulated, and how to ask for it.",
        ["vehicles", "vehicles_envelopes", "missions", "missions_legs", "sensors_navigation", "sonars", "cameras",
         "communication", "worlds", "worlds_large", "ocean", "swarms", "fit", "manoeuvres"],
    ),
    "Connect": (
        "The stack, the learner, the pilot at a screen.",
        ["bridges", "holoocean", "learning", "datasets"],
    ),
    "Cards": (
        "Instruments, vehicles, worlds and devices at a glance, and the way of each instrument's number.",
        ["cards/instruments", "cards/vehicles", "cards/worlds", "cards/devices", "follow/index"],
    ),
    "Scenario": ("Every key of a scenario file.", ["scenario/index"]),
    "Know": (
        "Conventions, equations, evidence, speed.",
        ["conventions", "theory/index", "proof", "checks", "benchmarks", "benchmarks_results"],
    ),
    "Build on it": (
        "Sensors of your own, the Python interface, the house.",
        ["write_a_sensor", "api/index", "ARCHITECTURE", "CONTRIBUTING", "SECURITY", "CHANGELOG"],
    ),
}  # fmt: skip
_INNER: Final = ("api/", "scenario/", "follow/", "cards/", "vehicles/", "theory/")


def write(source: Path) -> None:
    """Write the home page, and a page for each part with a tree of those that stand in the folder."""
    pages = {str(p.relative_to(source).with_suffix("")) for p in source.rglob("*.md")} - {"index"}
    _with_catalogue(source, pages)
    parts: dict[str, tuple[str, list[str]]] = {}
    for caption, (words, names) in PARTS.items():
        parts[caption] = words, [n for stem in names for n in _with_pages(stem, pages)]
    placed = {n for _, names in parts.values() for n in names}
    rest = sorted(n for n in pages - placed if not n.startswith(_INNER))
    if rest:
        parts["More"] = "Further pages.", rest
    (source / "parts").mkdir(exist_ok=True)
    files = []
    for caption, (words, names) in parts.items():
        file = f"parts/{caption.lower().replace(' ', '_')}"
        up = [f"../{n}" for n in names]
        tree = ["```{toctree}", ":maxdepth: 2", "", *up, "```", ""]
        (source / f"{file}.md").write_text("\n".join([f"# {caption}", "", words, "", *tree]), encoding="utf-8")
        files.append(file)
    home = HOME.format(house=(source / "house.svg").read_text(encoding="utf-8"))
    tree = ["", "```{toctree}", ":hidden:", ":maxdepth: 2", "", *files, "```", ""]
    (source / "index.md").write_text(home + "\n".join(tree), encoding="utf-8")


def _with_catalogue(source: Path, pages: set[str]) -> None:
    """Hang the pages of vehicles below the page about them."""
    names = sorted(n for n in pages if n.startswith("vehicles/"))
    page = source / "vehicles.md"
    tree = ["", "```{toctree}", ":hidden:", "", *names, "```", ""]
    page.write_text(page.read_text(encoding="utf-8") + "\n".join(tree), encoding="utf-8")


def _with_pages(stem: str, pages: set[str]) -> list[str]:
    """A page, and the bridges' pages after theirs."""
    own = [stem] if stem in pages else []
    return own + sorted(n for n in pages if stem == "bridges" and n.startswith("bridges_"))
