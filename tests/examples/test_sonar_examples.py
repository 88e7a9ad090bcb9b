"""The sonar examples run."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow
def test_gallery_draws_every_sonar(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["sonar_gallery.py", "--out", str(tmp_path), "--quick"])
    runpy.run_path(str(EXAMPLES / "sonar_gallery.py"), run_name="__main__")
    assert {p.stem for p in tmp_path.glob("*.png")} == {
        "imaging", "multibeam", "sidescan", "singlebeam", "water", "scanning", "profiling", "aperture",
        "doppler", "dam", "wreck",
    }  # fmt: skip
