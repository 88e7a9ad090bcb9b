"""Comparison of Pelagos with recordings: writes `docs/proof.md` and its pictures.

    python scripts/proof [--data FOLDER] [--only NAME ...]

FOLDER holds the recordings, a folder for each origin. Without it, or where one is absent, a chapter is made of its
small tables alone.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from page import joined, section, sections

PAGE = Path(__file__).parents[2] / "docs" / "proof.md"
CHAPTERS = (
    "cybership", "kvlcc2", "roll", "flume", "gliders", "thruster", "bolt", "minerva", "dvl", "river", "sea", "water",
    "sonar",
)  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, help="folder of the recordings")
    parser.add_argument("--only", nargs="*", choices=CHAPTERS, help="chapters to make; the page's others stay")
    chosen = parser.parse_args()
    if chosen.data is not None and not chosen.data.is_dir():
        parser.error(f"--data {chosen.data}: no such folder")
    stands = sections(PAGE.read_text(encoding="utf-8")) if chosen.only and PAGE.exists() else {}
    stands.pop("Not made", None)
    parts: list[str] = []
    absent: list[str] = []
    for name in CHAPTERS:
        module = importlib.import_module(name)
        if chosen.only and name not in chosen.only:
            parts += [stands[module.TITLE]] if module.TITLE in stands else []
            continue
        if chosen.data is not None and not (chosen.data / module.FOLDER).is_dir():
            absent.append(
                f"{name}: {chosen.data} has no {module.FOLDER}; made of the small tables alone. Origin: {module.SOURCE}"
            )
        print(f"{name} ...", flush=True)
        parts.append(section(module.chapter(chosen.data), PAGE.parent / "images"))
    PAGE.write_text(joined(parts, absent), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
