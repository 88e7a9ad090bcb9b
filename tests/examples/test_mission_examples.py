"""The missions' examples end where they say."""

from __future__ import annotations

from pathlib import Path

import pytest

import pelagos as pl

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow
def test_rov_mission_ends_on_the_seabed():
    sim = pl.Simulation.load(EXAMPLES / "rov_mission.yaml")
    assert sim.run().ended == "missions"
    assert sim.state["rov"].position[0, 2] == pytest.approx(-11.85, abs=0.15)
