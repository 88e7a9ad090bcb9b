"""Nomoto's yaw in a table and below it: steady turns in closed form, and the similarity of slow ships."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos import Vehicle, jit
from pelagos.hydro.nomoto import Nomoto, yaw_acceleration

SHIP = Nomoto((4.0, 6.0, 9.0), (0.1, 0.16, 0.2), (30.0, 25.0, 20.0), (0.4, 0.7, 0.3), 1.2)


def yaw(u: float, r: float, helm: float) -> float:
    return float(np.array(yaw_acceleration(SHIP, jit.Float64(u), jit.Float64(r), jit.Float64(helm)))[0])


@pytest.mark.parametrize("r", [0.04, -0.07])
def test_a_steady_turn_is_the_root_of_the_cubic(r):
    """K delta = n1 r + n3 r^3 with the constants half-way between two speeds of the table."""
    helm = (1.2 * r + 0.5 * r**3) / 0.18
    assert yaw(7.5, r, helm) == pytest.approx(0.0, abs=1e-15)
    assert yaw(7.5, r, helm + 0.1) == pytest.approx(0.18 * 0.1 / 22.5, rel=1e-12)


@pytest.mark.parametrize(("helm", "share"), [(0.3, 0.5), (-0.2, 0.8)])
def test_a_slow_ship_goes_the_same_way_slower(helm, share):
    """Below the table r scales with the speed and r_dot with its square: K L/U, T U/L and n3 (U/L)^2 are the same."""
    assert yaw(4.0 * share, 0.05 * share, helm) == pytest.approx(share**2 * yaw(4.0, 0.05, helm), rel=1e-12)


def test_beyond_the_table_and_astern():
    assert yaw(12.0, 0.03, 0.2) == yaw(9.0, 0.03, 0.2)
    assert yaw(-2.0, 0.0, 0.3) == 0.0
    assert yaw(-2.0, 0.05, 0.3) < 0


@pytest.mark.parametrize(("changed", "message"), [
    ({"speeds_m_s": [6.0, 6.0, 12.0]}, "speeds_m_s must rise"),
    ({"time_s": [20.0, 27.0]}, "time_s has 2 values, speeds_m_s 3"),
])  # fmt: skip
def test_tables_that_do_not_fit_are_refused(changed, message):
    from pelagos.errors import ScenarioError

    with pytest.raises(ScenarioError, match=message):
        Vehicle.from_catalogue("frigate", actuators={"rudder": changed})
