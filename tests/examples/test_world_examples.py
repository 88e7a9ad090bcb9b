"""The sheet of every kind of thing is drawn by the example that says so."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

from PIL import Image

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_gallery_draws_things_lines_movers_and_landforms(tmp_path, monkeypatch):
    kinds = ["tyre", "cable", "fish", "ripples"]
    monkeypatch.setattr(sys, "argv", ["world_gallery.py", str(tmp_path / "g.jpg"), "--samples", "1", "--only", *kinds])
    runpy.run_path(str(EXAMPLES / "world_gallery.py"), run_name="__main__")
    sheet = Image.open(tmp_path / "g.jpg").convert("L")
    for k in range(4):
        tile = sheet.crop((k * 230 + 5, 5, (k + 1) * 230 - 5, 165))
        low, high = tile.getextrema()
        assert high - low > 60  # something is in it
