"""The sonar examples run."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow
def test_elements_are_beamformed(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["beamform_elements.py", "--out", str(tmp_path / "beams.png")])
    runpy.run_path(str(EXAMPLES / "beamform_elements.py"), run_name="__main__")
    assert "72 elements; delay and sum with the device's weights is -2" in capsys.readouterr().out
    assert (tmp_path / "beams.png").stat().st_size > 100_000


@pytest.mark.slow
def test_water_columns_are_drawn(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["sonar_water_columns.py", "--out", str(tmp_path / "columns.png")])
    runpy.run_path(str(EXAMPLES / "sonar_water_columns.py"), run_name="__main__")
    assert (tmp_path / "columns.png").stat().st_size > 100_000


@pytest.mark.slow
def test_gallery_draws_every_sonar(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["sonar_gallery.py", "--out", str(tmp_path), "--quick"])
    runpy.run_path(str(EXAMPLES / "sonar_gallery.py"), run_name="__main__")
    assert {p.stem for p in tmp_path.glob("*.png")} == {
        "imaging", "multibeam", "sidescan", "singlebeam", "water", "scanning", "profiling", "aperture",
        "doppler", "dam", "wreck",
    }  # fmt: skip
