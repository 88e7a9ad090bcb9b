"""The missions' examples end where they say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pelagos as pl

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow
def test_rov_mission_ends_on_the_seabed():
    sim = pl.Simulation.load(EXAMPLES / "rov_mission.yaml")
    assert sim.run().ended == "missions"
    assert sim.state["rov"].position[0, 2] == pytest.approx(-11.85, abs=0.15)


@pytest.mark.slow
def test_auv_navigation_comes_home_by_what_it_knows(tmp_path):
    """Known within 3 m at the start, and within the GPS's slow error after fixes: it surfaces within 8 m of where."""
    sim = pl.Simulation.load(EXAMPLES / "auv_navigation.yaml")
    assert sim.run(record=tmp_path / "a.mcap").ended == "missions"
    known = sim.stepper.missions.navigators["auv"].fix.position
    assert np.hypot(*(sim.state["auv"].position - known)[0, :2]) < 8
    assert pl.Recording(tmp_path / "a.mcap").count("/auv/navigation") > 3000
