"""Tables of a vehicle that a driver's call takes along when walls are near."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.sim.driver import Driver
from pelagos.vehicles.tables import Tables


@pytest.mark.parametrize("given", [Tables("of thrusters", "of the hull", None), None])
def test_walls_come_beside_the_vehicles_own_tables(given: Any) -> None:
    constants = SimpleNamespace(h=0.1, copies=2, no_wrench="none")
    here: Any = SimpleNamespace(_constants=constants, vehicle=SimpleNamespace(tables=given))
    found = Driver._beside(here, "walls")
    kept = (None, None) if given is None else ("of thrusters", "of the hull")
    assert (found.tables.thrusters, found.tables.hull, found.tables.walls) == (*kept, "walls")
    assert (found.h, found.copies, found.no_wrench) == (0.1, 2, "none")
