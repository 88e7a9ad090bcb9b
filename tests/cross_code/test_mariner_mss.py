"""Trials of the mariner against Fossen's equations of it, run by a program of its own.

Figures: `mariner.m` of the MSS toolbox (github.com/cybergalactic/MSS, 736a3d1; MIT), its derivatives and its Euler
steps of 0.1 s (zig-zags: 0.02 s) written out in NumPy, from 7.7175 m/s with 10 s before the helm is laid; advance,
transfer and diameters from the place and course at that moment, in lengths of 160.93 m (MSC.137(76)). "speed" is the
published model; in "service_speed" forces go by the service speed, as in our default.
"""

from __future__ import annotations

import pytest

from pelagos.manoeuvres import run_manoeuvre
from pelagos.manoeuvres.orders import Orders

TURNS = {
    # scale, helm [deg]: advance, transfer, tactical diameter [L], time to 90 and to 180 deg [s]
    ("speed", 15): (4.6533, 3.4353, 7.9129, 144.25, 299.76),
    ("speed", -15): (5.1328, 3.7328, 8.5153, 158.00, 322.95),
    ("speed", 35): (3.5316, 2.6084, 6.3942, 115.84, 257.95),
    ("speed", -35): (3.7312, 2.7302, 6.6517, 122.10, 268.88),
    ("service_speed", 15): (4.4625, 3.0822, 6.9158, 134.83, 267.70),
    ("service_speed", -15): (4.9317, 3.3691, 7.5086, 148.28, 290.80),
    ("service_speed", 35): (3.2495, 2.0927, 4.9609, 101.57, 211.33),
    ("service_speed", -35): (3.4311, 2.1915, 5.1779, 107.15, 221.15),
}
ZIGZAGS = {
    # scale, first helm [deg], 20/20, the heading looked at every 0.1 s: overshoots [deg], period [s]
    ("speed", 20): (7.875, 6.373, 7.215, 6.271, 217.9),
    ("speed", -20): (6.778, 7.299, 6.279, 7.195, 217.4),
    ("service_speed", 20): (7.843, 6.621, 7.554, 6.573, 192.9),
    ("service_speed", -20): (6.746, 7.633, 6.573, 7.574, 192.7),
}
QUICK = (("service_speed", 35), ("speed", -35))


def values(scale: str, name: str, orders: Orders) -> dict[str, float]:
    """Numbers of a trial by name."""
    vehicle = {"type": "mariner", "actuators": {"rudder": {"scale": scale}}}
    return {m.name: m.value for m in run_manoeuvre(vehicle, name, orders).measures}


@pytest.mark.parametrize(
    "case", [case if case in QUICK else pytest.param(case, marks=pytest.mark.slow) for case in TURNS]
)
def test_turning_circles_are_those_of_the_independent_program(case: tuple[str, int]) -> None:
    """Its steps of 0.1 s are off by 0.12 % of the advance (steps of 0.02 s: 3.5279 for 3.5316); ours may be as far."""
    scale, helm = case
    found = values(scale, "turning", Orders(rudder_deg=helm, seconds=1.1 * TURNS[case][-1]))
    names = ("advance", "transfer", "tactical diameter", "time to 90 deg", "time to 180 deg")
    assert [found[name] for name in names] == pytest.approx(TURNS[case], rel=2.5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("case", ZIGZAGS)
def test_zigzags_are_those_of_the_independent_program(case: tuple[str, int]) -> None:
    """A tick of 0.1 s at up to 0.7 deg/s is 0.07 deg: the helm may be reversed one later, and the rudder's state of one
    tick acts in the next; the period begins and ends with a reversal, after three others."""
    scale, helm = case
    found = values(scale, "zigzag", Orders(rudder_deg=helm, angle_deg=20.0))
    overshoots = [found[f"{word} overshoot"] for word in ("first", "second", "third", "fourth")]
    assert overshoots == pytest.approx(ZIGZAGS[case][:4], abs=0.14)
    assert found["period"] == pytest.approx(ZIGZAGS[case][4], abs=0.5)
