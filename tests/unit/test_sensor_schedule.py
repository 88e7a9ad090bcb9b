"""Schedules of sensors: ticks between readings, and ranges from which an echo comes before the next ping."""

from __future__ import annotations

import re
import warnings

import pytest

import pelagos as pl
from pelagos.sensors.schedule import farthest_heard, period_ticks, slower, warn_of_ambiguity
from pelagos.sensors.sonar.altimeter import AltimeterConfig

MS = 1_000_000


@pytest.mark.parametrize(
    ("rate", "dt_ns", "period"),
    [(20.0, 50 * MS, 1), (4.0, 50 * MS, 5), (0.1, 50 * MS, 200), (30.0, 33_333_333, 1), (2.5, 33_333_333, 12),
     (200.0, 5 * MS, 1), (1 / 3, 5 * MS, 600)],
)  # fmt: skip
def test_a_rate_is_a_whole_number_of_ticks(rate: float, dt_ns: int, period: int) -> None:
    """Thirty ticks a second are of 33 333 333 ns, which is close enough."""
    assert period_ticks(rate, dt_ns) == period


@pytest.mark.parametrize(
    ("rate", "said"),
    [(25.0, "25 is faster than the tick rate of 20 Hz; nearest: 20"),
     (8.0, "8 does not divide the tick rate of 20 Hz; nearest: 6.66667 or 10"),
     (19.9, "19.9 does not divide the tick rate of 20 Hz; nearest: 10 or 20"),
     (0.30001, "0.30001 does not divide the tick rate of 20 Hz; nearest: 0.298507 or 0.30303")],
)  # fmt: skip
def test_other_rates_are_refused_with_their_nearest(rate: float, said: str) -> None:
    with pytest.raises(pl.ScenarioError, match=rf"^here: rate_hz {re.escape(said)}$"):
        period_ticks(rate, 50 * MS, where="here")


def test_an_echo_comes_before_the_next_ping_from_half_a_period_away() -> None:
    """1480/(2 5) m; and at 1500 m/s where nobody says."""
    assert farthest_heard(5.0, 1480.0) == pytest.approx(148.0)
    assert farthest_heard(3.0) == pytest.approx(250.0)


@pytest.mark.parametrize(("reach", "rate"), [(10.0, 9.0), (77.7, 9.0), (77.8, 4.5), (155.6, 3.0), (900.0, 0.75)])
def test_a_part_pings_at_the_fastest_whole_part_of_a_rate_without_ambiguity(reach: float, rate: float) -> None:
    """In water of 1400 m/s, 2 reach rate/k must be below it: at 9 Hz 77.78 m, at 4.5 Hz 155.56 m, at 0.75 Hz 933 m."""
    assert slower(9.0, reach) == pytest.approx(rate)
    assert 2 * reach * rate <= 1400.0


def test_ranges_beyond_the_next_ping_are_warned_of_where_a_scenario_asks_for_them() -> None:
    """1400 m/s: 70 m at 10 Hz; 80 m are heard at 8.75 Hz. Not of a device, nor of a default, nor below."""
    asked = AltimeterConfig(rate_hz=10.0, range_max_m=69.0)
    said = (
        "a.x: echoes from 80 m come after the next ping at 10 Hz, and are lost; ranges up to 70 m are heard, or all at "
    )
    said += "8.75 Hz"
    with pytest.warns(pl.ValidityWarning, match=f"^{re.escape(said)}$"):
        warn_of_ambiguity(asked, "a.x", 80.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_ambiguity(asked, "a.x", 69.9)
        warn_of_ambiguity(asked, "a.x", 80.0, device="known")
        warn_of_ambiguity(AltimeterConfig(rate_hz=10.0), "a.x", 80.0)
