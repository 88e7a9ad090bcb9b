"""Numbers of the sea that stand in tables, by second ways: periods of tides, sea states, foam, plankton."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos import jit
from pelagos.ocean.analytic_current import TIDE_PERIOD_H, JetCurrentConfig
from pelagos.ocean.biology import patches, plankton_column, step_column
from pelagos.ocean.config import OceanConfig, site_of
from pelagos.ocean.site import Site
from pelagos.ocean.spectrum import SEA_STATES
from pelagos.ocean.waves import Waves

RATES = {"T": 15.0, "s": 0.54901653, "h": 0.04106864, "p": 0.00464183}
"""Of the mean sun's hour angle, and of the mean longitudes of moon, sun and perigee [deg/h]."""
ARGUMENTS = {
    "M2": (2, -2, 2, 0), "S2": (2, 0, 0, 0), "N2": (2, -3, 2, 1), "K2": (2, 0, 2, 0), "K1": (1, 0, 1, 0),
    "O1": (1, -2, 1, 0), "P1": (1, 0, -1, 0), "Q1": (1, -3, 1, 1), "M4": (4, -4, 4, 0), "S1": (1, 0, 0, 0),
}  # fmt: skip
"""Multiples of these that make a constituent's argument (Schureman 1958, Table 2)."""


def test_periods_of_tides_follow_from_sun_and_moon() -> None:
    assert set(TIDE_PERIOD_H) == set(ARGUMENTS)
    for name, multiples in ARGUMENTS.items():
        speed = sum(k * rate for k, rate in zip(multiples, RATES.values(), strict=True))
        assert TIDE_PERIOD_H[name] == pytest.approx(360.0 / speed, rel=5e-7), name


def test_heights_of_sea_states_are_amid_their_classes() -> None:
    """WMO Code 3700 [m]; the peak periods rise with the height (Faltinsen 1990, Table 2.2)."""
    edges = [0.0, 0.0, 0.1, 0.5, 1.25, 2.5, 4.0, 6.0, 9.0, 14.0]
    for state in range(1, 9):
        assert SEA_STATES[state][0] == pytest.approx(0.5 * (edges[state] + edges[state + 1]), abs=0.006), state
    assert SEA_STATES[0][0] == 0.0
    assert SEA_STATES[9][0] == edges[9]
    assert [SEA_STATES[k][1] for k in range(2, 10)] == [7.5, 7.5, 8.8, 9.7, 12.4, 15.0, 16.4, 20.0]


class Falling(Waves):
    """A surface that falls at some of gravity, by time."""

    def _falling(self, x: Any, y: Any, t: Any) -> Any:
        return jit.Float64(np.interp(np.array(t), self.at_times, self.falls))


@pytest.mark.parametrize(
    ("since", "white"),
    [(0.0, 1.0), (0.3, 0.4 + 0.0), (1.5, 0.6), (2.2, 0.0), (4.0, 0.35), (4.7, 0.0), (9.0, 0.0), (-0.5, 0.0)],
)  # fmt: skip
def test_foam_is_left_for_some_seconds_behind_a_crest(since: float, white: float) -> None:
    """The limit is 0.4 g; a crest falls at 0.6 g at t = 20 s for an instant, and less within 0.5 s of it, 0.2 g at
    0.4 s: white from 0.32 g to 0.5 g. Behind it 0.6 of that are left after 1.5 s, and 0.35 after 4 s."""
    sea = Falling.__new__(Falling)
    sea.limit = jit.Float64(0.4)
    sea.at_times, sea.falls = np.array([0.0, 19.6, 20.0, 20.4, 90.0]), np.array([0.0, 0.2, 0.6, 0.2, 0.0])
    found = float(np.array(sea.foam(jit.Float64(0.0), jit.Float64(0.0), jit.Float64(20.0 + since)))[0])
    if since == 0.3:
        white = 0.0  # 0.6 - 0.4 0.3/0.4 = 0.3 g: below 0.32 g
    assert found == pytest.approx(white, abs=1e-9)


def test_a_crest_near_its_limit_is_white_in_part() -> None:
    """0.45 g of 0.4 g: (1.125 - 0.8)/(1.25 - 0.8)."""
    sea = Falling.__new__(Falling)
    sea.limit = jit.Float64(0.4)
    sea.at_times, sea.falls = np.array([0.0, 19.9, 20.0, 20.1, 90.0]), np.array([0.0, 0.0, 0.45, 0.0, 0.0])
    found = float(np.array(sea.foam(jit.Float64(0.0), jit.Float64(0.0), jit.Float64(20.0)))[0])
    assert found == pytest.approx(0.325 / 0.45)


def test_columns_of_life_by_hand() -> None:
    """Half way at the middle of a cline; a bell on the surface's value that fades below the light; patches by e."""
    assert step_column(41.0, surface=36.0, deep=34.0, middle_m=41.0, thickness_m=7.0) == pytest.approx(35.0)
    assert step_column(48.0, surface=36.0, deep=34.0, middle_m=41.0, thickness_m=7.0) == pytest.approx(
        36.0 - 2.0 / (1.0 + math.exp(-1.0))
    )
    found = plankton_column(np.array([75.0, 200.0]), surface=0.5, peak=2.0, peak_m=50.0, width_m=25.0)
    bell = 0.5 + 1.5 * np.exp([-0.5, -18.0])
    light = 1 / (1 + np.exp([-6.25, 0.0]))
    assert found == pytest.approx(bell * light + 0.1 * (1 - light))
    usual = plankton_column(50.0)
    assert usual == pytest.approx((1.0 - 0.1) / (1 + math.exp(-7.5)) + 0.1)
    cluster = {"position": [3.0, 4.0, 0.0], "strength": 2.0}
    assert patches([0.0, 0.0, 0.0], [cluster, {"position": [9, 9, 9]}]) == pytest.approx(2.0 * math.exp(-0.5))
    assert patches([0.0, 0.0, 0.0], [cluster | {"falloff": 0.0}, cluster | {"falloff": 0.25}]) == pytest.approx(
        2.0 * math.exp(-20.0)
    )


def test_a_jet_is_as_fast_above_the_water_as_at_its_surface() -> None:
    """speed e^(-depth/scale), and that of the surface in the spray above it; without a scale alike at all depths."""
    z = jit.Float64([3.0, 0.0, -5.0, -20.0])
    place = jit.Array3f64(0.0, 0.0, z)
    for depth, expected in ((10.0, np.exp([0.0, 0.0, -0.5, -2.0])), (None, np.ones(4))):
        jet: Any = JetCurrentConfig(speed_mps=0.7, width_m=30.0, depth_m=depth).build(Site(site_of(None, 0).origin))
        velocity = np.array(jet.velocity(place, jit.Float64(0.0)))
        assert np.broadcast_to(velocity[0], (4,)) == pytest.approx(0.7 * expected)


def test_the_site_of_an_ocean_is_its_worlds_or_amid_the_atlantic() -> None:
    """45 north, 30 west without one; else its origin, the corners of its extent, and the seed."""
    alone = site_of(None, 7)
    assert (alone.origin.latitude, alone.origin.longitude, alone.seed) == (45.0, -30.0, 7)
    assert not alone.corners.any()
    endless: Any = SimpleNamespace(origin="here", bounds=None)
    assert (site_of(endless, 8).origin, site_of(endless, 8).seed) == ("here", 8)
    world: Any = SimpleNamespace(origin="there", bounds=np.array([[-3, -2, -9], [5, 4, 1]]))
    site = site_of(world, 9)
    assert (site.origin, site.seed) == ("there", 9)
    assert site.corners.tolist() == [[-3, -2, -9], [5, 4, 1]]


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [("temperature_c", -3.1, "between -3 and 45 degC, not -3.1"), ("temperature_c", 45.1, "not 45.1"),
     ("salinity", -0.1, "between 0 and 42, not -0.1"), ("salinity", 42.1, "not 42.1"),
     ("temperature_c", [{"type": "uniform", "value": -101.0}], "between -100 and 100 degC, not -101"),
     ("salinity", [{"type": "uniform", "value": 100.5}], "not 100.5"),
     ("temperature_c", {"depth_m": [0, 9], "value": [4, 46.0]}, "not 46")],
)  # fmt: skip
def test_water_is_neither_ice_nor_brine(key: str, value: Any, said: str) -> None:
    """Components are differences too: within 100 of either sign."""
    with pytest.raises(ValueError, match=said):
        OceanConfig.model_validate({key: value})
    for fits in (-3.0, 45.0) if key == "temperature_c" else (0.0, 42.0):
        OceanConfig.model_validate({key: fits})
    OceanConfig.model_validate({key: [{"type": "uniform", "value": v} for v in (-100.0, 100.0)]})
