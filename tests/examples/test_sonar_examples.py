"""The sonar examples run."""

from __future__ import annotations

import re
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


@pytest.mark.slow
def test_two_apertures_measure_heights(tmp_path, monkeypatch, capsys):
    """A box 0.40 m high on flat ground: heights repeat by 1.6 m, and 36 looks of coherence 0.7 leave 0.06 m to each."""
    monkeypatch.setattr(sys, "argv", ["sonar_interferometry.py", "--out", str(tmp_path / "heights.png")])
    runpy.run_path(str(EXAMPLES / "sonar_interferometry.py"), run_name="__main__")
    number = r"([-+]?\d+\.\d+)"
    told = capsys.readouterr().out
    straight, known = map(float, re.search(rf"{number} as if straight, {number}", told).groups())
    ground, spread = map(float, re.search(rf"flat ground at {number} m, within {number}", told).groups())
    top = float(re.search(rf"high, at {number} m", told).group(1))
    assert known > straight + 0.1
    assert abs(ground) < 0.02
    assert spread < 0.08
    assert top == pytest.approx(0.40, abs=0.05)


@pytest.mark.slow
def test_a_mosaic_is_laid(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["sonar_mosaic.py", "--out", str(tmp_path / "mosaic.png"), "--quick"])
    runpy.run_path(str(EXAMPLES / "sonar_mosaic.py"), run_name="__main__")
    assert "pings on 4 lines" in capsys.readouterr().out
    assert (tmp_path / "mosaic.png").stat().st_size > 100_000
