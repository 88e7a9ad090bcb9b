"""Cases of a parametrised test that `make test-all` runs and `make test` leaves out: others stand for them."""

from __future__ import annotations

from typing import Any, Final

import pytest

KIN: Final = (
    "semisub", "supply", "container", "dsrv", "tanker", "kvlcc2", "mariner", "navalvessel", "bluerov2_heavy",
    "hovering_auv", "wamv", "surface_vessel", "npsauv", "couguv", "torpedo", "lrauv",
)  # fmt: skip
"""Vehicles whose kinds of modes others have too, which are in every run; see also `test_vehicle_catalogue`, where three
unequal copies of every vehicle step in every mode as each does alone."""


def slow(*values: Any) -> Any:
    """The values of one case, marked slow."""
    return pytest.param(*values, marks=pytest.mark.slow)
