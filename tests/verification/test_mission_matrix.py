"""Every leg by every vehicle that can do it, in a current of 0.2 m/s and sea state 2, as `scripts/legs.py` flies and
judges them: each mission ends, and keeps the tolerance that it works with."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

from pelagos.vehicles.load import catalogue_names

SCRIPTS = Path(__file__).parents[2] / "scripts"


@pytest.fixture(scope="module")
def legs():
    sys.path.insert(0, str(SCRIPTS))
    yield importlib.import_module("legs")
    sys.path.remove(str(SCRIPTS))


@pytest.mark.slow
@pytest.mark.parametrize("name", catalogue_names())
def test_a_vehicle_does_every_leg_within_its_tolerance(legs, name):
    rows = list(legs.rows(name))
    assert len(rows) >= 10
    assert all(row.reached for row in rows), "\n".join(map(str, rows))


def test_a_line_that_is_missed_is_told(legs):
    """The judge itself: a dive to a depth that is never allowed for is an error of its distance."""
    vehicle = legs.pl.Vehicle.from_catalogue("bluerov2_heavy")
    family = legs.mission_mode({mode: tuple(vehicle.command_names(mode)) for mode in vehicle.modes})[1]
    trial = legs.Trial([{"type": "dive", "depth_m": 7.5}], legs.from_level(-9.0), 1.0)
    flight = legs.fly(vehicle, family, trial)
    assert flight.done
    assert trial.error(flight) == pytest.approx(1.5, abs=legs.LEVEL_TOLERANCE_M)
    assert trial.error(flight) > 0.5
