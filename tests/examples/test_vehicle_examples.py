"""The vehicles' examples run and find what they promise."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

import pelagos as pl

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow
def test_identify_damping():
    found = runpy.run_path(str(EXAMPLES / "vehicle_identify_damping.py"))
    assert found["main"]() == pytest.approx(found["TRUE"], rel=0.08)


def test_identify_damping_descends(capsys):
    runpy.run_path(str(EXAMPLES / "vehicle_identify_damping.py"))["main"](iterations=20)
    errors = [float(line.split()[-1]) for line in capsys.readouterr().out.splitlines() if line.startswith("iteration")]
    assert len(errors) == 2
    assert np.diff(errors)[0] < 0


@pytest.mark.slow  # 4 s; strip theory has tests of its own
def test_seakeeping_at_speed(tmp_path):
    """Waves of 0.45, 1.6 and 6 ship lengths: long ones carry the ship, and speed heaves it more in head seas."""
    found = runpy.run_path(str(EXAMPLES / "seakeeping_at_speed.py"))["main"](tmp_path, points=3)
    assert (tmp_path / "seakeeping_at_speed.png").stat().st_size > 10_000
    for (sea, _), rows in found.items():
        assert rows[-1, 0] == pytest.approx(1.0, abs=0.05)
        assert rows[-1, 2] == pytest.approx(0.0 if sea == "beam" else 1.0, abs=0.05)
    assert found["head", "15 kn"][1, 0] > found["head", "0 kn"][1, 0] + 0.05


@pytest.mark.slow
def test_fit_usv():
    """Four standard deviations: the made-up run is another program's (`Simulation`) than the fit's."""
    found = runpy.run_path(str(EXAMPLES / "fit_usv.py"))
    made = found["main"]()
    for name, key in (("surge", "surge_kg_s"), ("yaw", "yaw_s")):
        estimate = next(e for e in made.estimates if e.parameter.name == name)
        assert abs(estimate.value - found["TRUE"][key]) < 4 * (estimate.high - estimate.low) / 3.92


def test_numpy_dynamics(monkeypatch):
    """At rest the line is longer than paid out by buoyancy over stiffness, 0.5 m, above an anchor at 10 m."""
    monkeypatch.syspath_prepend(str(EXAMPLES))
    import vehicle_numpy_dynamics

    assert vehicle_numpy_dynamics.main(60.0) == pytest.approx([6.5, 3.5], abs=0.03)


@pytest.mark.slow  # 6 s; the losses have tests of their own
def test_thruster_losses(tmp_path, capsys, monkeypatch):
    """At 2 m/s an open disc of 30 N and 12 cm, v0 = 1.137 m/s: t^3 + 1.759 t = 1; 4 D behind 1 - 0.8^(4^(2/3))."""
    monkeypatch.setattr("sys.argv", ["", str(tmp_path / "losses.png")])
    runpy.run_path(str(EXAMPLES / "vehicle_thruster_losses.py"))["main"]()
    said = capsys.readouterr().out
    assert "'open disc': 0.5," in said
    assert "'0 deg': 0.43," in said
    assert (tmp_path / "losses.png").stat().st_size > 10_000


@pytest.mark.slow
def test_near_bottom(tmp_path):
    """The bottom holds back what the hull's buoyancy lifts off it."""
    found = runpy.run_path(str(EXAMPLES / "vehicle_near_bottom.py"))["main"](str(tmp_path / "near.png"))
    assert found[0] < found[1] - 0.01
    assert (tmp_path / "near.png").stat().st_size > 10_000


@pytest.mark.slow  # 6 s; so has flooding
def test_flooding(tmp_path):
    """Boyle's law leaves V0 p0/p of the air: 4 l x (1 - 10.07/(10.07 + 60)) = 3.4 l on the bottom at 60 m."""
    found = runpy.run_path(str(EXAMPLES / "vehicle_flooding.py"))["main"](str(tmp_path / "flooding.png"))
    sinks, dropped, vented = (depth[-1] for depth in found.values())
    assert sinks > 59.0
    assert dropped < 0.5
    assert vented < 0.5
    assert (tmp_path / "flooding.png").stat().st_size > 10_000


@pytest.mark.slow  # half a minute to compile two ships
def test_quay_passing():
    """In a minute the ship that feels the quay is drawn nearer and turns its bow away; the other goes straight."""
    sim = pl.Simulation.load(EXAMPLES / "quay_passing.yaml")
    sim.step(ticks=600)
    drawn, straight = sim.state["drawn"], sim.state["straight"]
    assert drawn.position[0, 1] > -58
    assert drawn.attitude[0, 3] < -2e-3  # clockwise seen from above
    assert straight.position[0, 1] == pytest.approx(59, abs=1e-6)
