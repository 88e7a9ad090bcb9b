"""Build the documentation's site: assemble the pages, make those that follow from the program, and run Sphinx.

    python scripts/site [--output build/site] [--quick]

`--quick` leaves out what needs the simulator: pictures of readings and walks through the code.
"""

from __future__ import annotations

import argparse
import logging
import re
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import api
import cards
import contents
import house
import proof
import scenario

ROOT = Path(__file__).parents[2]
BESIDE = ("ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")
WIDE = ("conventions.md", "benchmarks_results.md")  # pages of wide tables
WITHOUT_CONTENTS = "---\nhtml_theme.sidebar_secondary.remove: true\n---\n\n"
DOORS = ("sensor_numpy.py", "sensor_rays.py", "sensor_drjit.py")  # examples that their page shows in full
_LINK = re.compile(r"\]\((?!https?:|#|mailto:)([^)\s]+)\)")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "site", help="folder of the pages")
    parser.add_argument("--quick", action="store_true", help="without pictures of readings and walks")
    chosen = parser.parse_args()
    logging.getLogger("griffe").setLevel(logging.ERROR)  # of docstrings that describe two arguments in one line
    source = ROOT / "build" / "site_source"
    shutil.rmtree(source, ignore_errors=True)
    assemble(source)
    house.write(source)
    scenario.write(source / "scenario")
    cards.write(source, simulate=not chosen.quick)
    proof.write(source)
    api.write(source / "api")
    contents.write(source)
    from sphinx.cmd.build import build_main

    failed = build_main(
        ["-q", "-W", "--keep-going", "-c", str(ROOT / "docs" / "site"), str(source), str(chosen.output)]
    )
    if not failed:
        print(f"the site is {chosen.output / 'index.html'}")
    return failed


def assemble(source: Path) -> None:
    """Copy the hand-written pages, and those beside the README, with links as they are in the site."""
    shutil.copytree(ROOT / "docs", source, ignore=shutil.ignore_patterns("site", "scenario.md"))
    for name in BESIDE:
        (source / name).write_text((ROOT / name).read_text(encoding="utf-8"), encoding="utf-8")
    (source / "benchmarks_results.md").write_text(
        (ROOT / "bench" / "RESULTS.md").read_text(encoding="utf-8"), encoding="utf-8"
    )
    for page in source.rglob("*.md"):
        text = page.read_text(encoding="utf-8")
        linked = _LINK.sub(lambda m, page=page: f"]({target(m[1], page, source)})", text)  # type: ignore[misc]
        wide = page.parent.name == "theory" or page.name in WIDE
        page.write_text((WITHOUT_CONTENTS if wide else "") + linked, encoding="utf-8")
    with (source / "write_a_sensor.md").open("a", encoding="utf-8") as page:
        for name in DOORS:
            page.write(f"\n## {name}\n\n```{{literalinclude}} files/{name}\n:language: python\n```\n")


def target(link: str, page: Path, source: Path) -> str:
    """A link of the repository as one of the site: pages beside the README stand beside the others here."""
    path, mark, anchor = link.partition("#")
    up = "../" * len(page.relative_to(source).parent.parts)
    name = path.removeprefix("../").removeprefix("../")
    if name in BESIDE:
        return f"{up}{name}{mark}{anchor}"
    if page.name in BESIDE and name.startswith("docs/"):
        name = name.removeprefix("docs/")
    if name.endswith("bench/RESULTS.md"):
        return f"{up}benchmarks_results.md{mark}{anchor}"
    if name == "scenario.md":
        return f"{up}scenario/{anchor.lower()}.md" if anchor in scenario.pages() else f"{up}scenario/index.md"
    if path.startswith("../examples/"):  # a file to download
        (source / "files").mkdir(exist_ok=True)
        shutil.copy(ROOT / path.removeprefix("../"), source / "files")
        return f"{up}files/{Path(path).name}"
    return f"{name if page.name in BESIDE else path}{mark}{anchor}"


if __name__ == "__main__":
    sys.exit(main())
