"""How actuators follow their commands: lags, limits at their three places, and rates, as documented."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from pelagos import jit
from pelagos.vehicles.actuators.lag import Clip, Lag

LOW, HIGH, H = -0.6, 0.9, 0.07
STATES, COMMANDS = (
    np.array(v)
    for v in zip(*itertools.product((-1.4, -0.6, -0.2, 0.5, 0.9, 1.3), (-2.0, -0.3, 0.2, 0.8, 3.0)), strict=True)
)


@pytest.mark.parametrize("rate", [None, 0.5])
@pytest.mark.parametrize("time", [0.0, 0.4])
@pytest.mark.parametrize("clip", ["before", "after", "force"])
def test_a_state_follows_its_command(clip: Clip, time: float, rate: float | None) -> None:
    """Exactly, e^(-h/T) of the way is left; no faster than its rate; in the end between its limits."""
    lag = Lag(time, LOW, HIGH, clip, rate)
    inside = np.clip(STATES, LOW, HIGH)
    start = inside if time and clip != "after" else STATES
    way = (COMMANDS - start) * (1 - math.exp(-H / time) if time else 1.0)
    if rate is not None:
        way = np.clip(way, -rate * H, rate * H)
    after = np.array(lag.after(jit.Float64(STATES), [], jit.Float64(COMMANDS), jit.Float64(H))[0])
    assert after == pytest.approx(np.clip(start + way, LOW, HIGH), abs=1e-12)
    host = [lag.advanced(jit.Float64(float(s)), float(c), H) for s, c in zip(STATES, COMMANDS, strict=True)]
    assert [float(jit.Float64(v)[0]) for v in host] == pytest.approx(after.tolist(), abs=1e-12)
    seen = np.array(lag.limited(jit.Float64(STATES)))
    assert seen == pytest.approx(STATES if clip == "after" else inside)


@pytest.mark.parametrize("rate", [None, 0.5])
@pytest.mark.parametrize("time", [0.0, 0.4])
@pytest.mark.parametrize("clip", ["before", "after", "force"])
def test_a_rate_brings_a_state_back_between_its_limits(clip: Clip, time: float, rate: float | None) -> None:
    """`before` and `after`: one beyond is back after 1 s, besides what it follows; `after`: no further."""
    lag = Lag(time, LOW, HIGH, clip, rate)
    start = STATES if clip == "force" else np.clip(STATES, LOW, HIGH)
    slope = (COMMANDS - start) / (time or 1.0)
    if rate is not None:
        slope = np.clip(slope, -rate, rate)
    if clip == "after":
        slope = np.where((STATES >= HIGH) & (slope > 0) | (STATES <= LOW) & (slope < 0), 0.0, slope)
    found = np.array(lag.rates(jit.Float64(STATES), [], jit.Float64(COMMANDS))[0])
    assert found == pytest.approx(start - STATES + slope, abs=1e-12)
