"""Comparison of Pelagos with recordings: writes `docs/proof.md` and its pictures.

    python scripts/proof [--data FOLDER] [--only NAME ...]

FOLDER holds the recordings, a folder for each origin (each chapter says which). Without it the chapters with small
tables are made, and the others are named as not made.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from page import Chapter, written

ROOT = Path(__file__).parents[2]
CHAPTERS = ("cybership", "gliders", "sea", "water")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, help="folder of the recordings")
    parser.add_argument("--only", nargs="*", choices=CHAPTERS, help="chapters; the page is then printed, not written")
    chosen = parser.parse_args()
    if chosen.data is not None and not chosen.data.is_dir():
        parser.error(f"--data {chosen.data}: no such folder")
    made: list[Chapter] = []
    absent: list[str] = []
    for name in chosen.only or CHAPTERS:
        module = importlib.import_module(name)
        needs = getattr(module, "NEEDS", None)
        if needs is not None and (chosen.data is None or not (chosen.data / needs).is_dir()):
            where = "no folder was named (--data)" if chosen.data is None else f"{chosen.data} has no {needs}"
            absent.append(f"{name}: its recordings are absent: {where}. Origin: {module.SOURCE}")
            continue
        print(f"{name} ...", flush=True)
        made.append(module.chapter(chosen.data))
    pictures = ROOT / "docs" / "images"
    text = written(made, absent, _scratch() if chosen.only else pictures)
    if chosen.only:
        print(text)
    else:
        (ROOT / "docs" / "proof.md").write_text(text, encoding="utf-8")
    return 0


def _scratch() -> Path:
    made = ROOT / "build"
    made.mkdir(exist_ok=True)
    return made


if __name__ == "__main__":
    sys.exit(main())
