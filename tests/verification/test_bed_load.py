"""Grains that the current carries along the bed, and a velocity log over them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.errors import ScenarioError
from pelagos.hydro.bed_load import EXCESS, GRAVITY, grain_number, grain_speed, skin_friction, threshold

GRAINS = [0.15e-3, 0.25e-3, 0.6e-3, 1.8e-3]


def van_rijn_shields(number: float) -> float:
    """Shields' curve as van Rijn (1984) fits it, by parts of D*."""
    for last, factor, power in ((4, 0.24, -1.0), (10, 0.14, -0.64), (20, 0.04, -0.10), (150, 0.013, 0.29)):
        if number <= last:
            return factor * number**power
    return 0.055


@pytest.mark.parametrize("grain", GRAINS)
def test_number_of_a_grain_is_its_weight_over_its_drag(grain: float) -> None:
    """D*^3 is the Galilei number (s - 1) g d^3/nu^2."""
    assert grain_number(grain) ** 3 == pytest.approx(1.65 * 9.81 * grain**3 / 1.14e-6**2, rel=1e-12)


@pytest.mark.parametrize("grain", GRAINS)
def test_threshold_of_motion_is_shields_curve(grain: float) -> None:
    """Against another fit of the same curve, whose points scatter by 20 %; the friction velocity has half of that."""
    other = math.sqrt(van_rijn_shields(grain_number(grain)) * EXCESS * GRAVITY * grain)
    assert threshold(grain) == pytest.approx(other, rel=0.1)


@pytest.mark.parametrize("grain", GRAINS)
@pytest.mark.parametrize("stage", [0.4, 3.0, 20.0])
def test_speed_height_and_concentration_of_grains_make_the_transport(grain: float, stage: float) -> None:
    """Van Rijn: q = 0.053 sqrt((s - 1) g) d^1.5 T^2.1/D*^0.3 is speed times height 0.3 d D*^0.7 T^0.5 times share
    0.65 x 0.18 T/D*; his factors, rounded to two digits each, agree within 1 %."""
    number = grain_number(grain)
    speed = float(np.array(grain_speed(jit.Float64(threshold(grain) * math.sqrt(1 + stage)), grain))[0])
    height, share = 0.3 * grain * number**0.7 * stage**0.5, 0.65 * 0.18 * stage / number
    transport = 0.053 * math.sqrt(EXCESS * GRAVITY) * grain**1.5 * stage**2.1 / number**0.3
    assert speed * height * share == pytest.approx(transport, rel=0.01)


def test_grains_below_the_threshold_lie_still() -> None:
    critical = threshold(0.5e-3)
    found = np.array(grain_speed(jit.Float64([0.0, 0.5 * critical, 0.999 * critical, 1.001 * critical]), 0.5e-3))
    assert list(found[:3]) == [0.0, 0.0, 0.0]
    assert 0.0 < found[3] < 0.01


@pytest.mark.parametrize("grain", GRAINS)
def test_grains_go_as_fast_as_was_measured_over_rough_beds(grain: float) -> None:
    """At most 12.5 friction velocities, and 2.5 of them (Julien and Bounvilay, J. Hydraul. Eng. 139, 2013)."""
    friction = threshold(grain) * np.array([1.3, 2.0, 4.0])
    ratio = np.array(grain_speed(jit.Float64(friction), grain)) / friction
    assert (ratio > 2.5).all()
    assert (ratio < 12.5).all()


def test_skin_friction_is_that_of_the_logarithmic_law() -> None:
    """Drag coefficient at 1 m of sand of 0.3 mm: (0.4/ln(1 m/25 um))^2, 1.42e-3."""
    found = np.array(skin_friction(jit.Float64([1.6, 0.2]), 1.0, 0.3e-3))
    assert found**2 == pytest.approx(1.4247e-3 * np.array([1.6, 0.2]) ** 2, rel=1e-3)


def river(towards_deg: float, things: list[dict[str, object]], **keys: object) -> pl.Simulation:
    """A log over 9 m of water with a current of 1.6 m/s at the surface, 0.4 m/s about 8 m and 0.1 m/s at the bed."""
    rows = {"depth_m": [0, 7.8, 8.2, 9], "speed_mps": [1.6, 0.4, 0.4, 0.1], "towards_deg": [towards_deg] * 4}
    current = {"type": "profile", **rows}
    dvl = {"type": "dvl", "noise_mps": 0.0, "noise_relative": 0.0, "range_noise_relative": 0.0, **keys}
    auv = {"vehicle": "bluerov2", "start": {"position_m": [0, 0, -2]}, "sensors": {"it": dvl}}
    world = {"type": "flat", "depth_m": 9.0, "things": things}
    return pl.Simulation.load({"world": world, "ocean": {"currents": [current]}, "agents": {"auv": auv}})


ATTITUDE = np.array([0.9, 0.12, -0.15, 0.38]) / np.linalg.norm([0.9, 0.12, -0.15, 0.38])
VELOCITY = np.array([0.5, -0.3, 0.1])


def over_bed(sim: pl.Simulation) -> np.ndarray:
    """Velocity that a log's reading lacks, turned to the world: that of the bed."""
    reading = sim.observe("auv", (0.0, 0.0, -2.0), ATTITUDE, velocity=VELOCITY)["it"]
    assert reading.truth[0] == pytest.approx(VELOCITY, abs=1e-12)
    w, v = ATTITUDE[0], ATTITUDE[1:]
    lacks = VELOCITY - reading.data[0]
    return np.asarray(lacks + 2 * np.cross(v, np.cross(v, lacks) + w * lacks))


@pytest.mark.parametrize("towards", [70.0, 200.0])
def test_a_log_over_moving_sand_lacks_the_speed_of_its_grains(towards: float) -> None:
    """Along the current 1 m above the bed, 0.4 m/s at 8 m: whatever the vehicle's attitude, all beams see the same."""
    grain = 0.2e-3
    friction = 0.4 * 0.4 / math.log(12.0 * 1.0 / grain)
    stage = (friction / threshold(grain)) ** 2 - 1
    speed = 1.5 * math.sqrt(1.65 * 9.81 * grain) * stage**0.6
    assert speed > 0.02
    north, west = speed * math.cos(math.radians(towards)), -speed * math.sin(math.radians(towards))
    assert over_bed(river(towards, [], bed_grain_mm=0.2)) == pytest.approx([north, west, 0.0], abs=1e-5)
    assert over_bed(river(towards, [])) == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_what_stands_on_the_bed_is_not_carried_along() -> None:
    plate = {"shape": "box", "size_m": [30, 30, 0.5], "at_m": [0, 0, -8.5], "material": "steel"}
    assert over_bed(river(70.0, [plate], bed_grain_mm=0.2)) == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_two_pulses_over_a_moving_bed_are_refused() -> None:
    with pytest.raises(
        ScenarioError, match=r"iq has the pulses of a bed that lies still: leave it out, or bed_grain_mm"
    ):
        river(70.0, [], bed_grain_mm=0.2, iq=True)
