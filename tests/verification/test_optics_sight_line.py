"""Lines of sight through layers of murky water: against exp(-integral c ds), quadrature, and even water."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy.integrate import trapezoid

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.optics.light_field import LightField, beam_at, beam_veil, light_field, seen_through, with_column
from pelagos.optics.phase import turning_phase
from pelagos.optics.sight_line import STRETCHES, SightLines, sight_at, sums_along, waters_at
from pelagos.optics.sunlight import daylight
from pelagos.optics.suspended import sediment_scattering, with_suspended
from pelagos.optics.transport import path_length, sharp_transmission
from pelagos.optics.water import FORWARD_PEAK, WaterArrays, water_optics
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.build import build_world
from pelagos.world.generate.flat import FlatConfig

CLEAR = water_optics("IB")
SUN = daylight(math.radians(50), 0.3)
GRAM = np.array(sediment_scattering())[:, None]  # [1/m] of 1 NTU
RATE = 0.15  # of diffuse light along the line [1/m]
Profile = Callable[[Any], Any]  # turbidity [NTU] at a distance [m], of NumPy and of Dr.Jit arrays

LINEAR: Profile = lambda s: 0.3 + 0.2 * s
SLAB: Profile = lambda s: dr.select((s > 3) & (s < 5), 2.0, 0.1)


def line(
    profile: Profile, direction: tuple[float, float, float], distances: Any
) -> tuple[SightLines, LightField, WaterArrays, Any, Any]:
    """One line in murky water, asked for at several distances."""
    clear, field, d = CLEAR.arrays(), light_field(CLEAR, SUN), jit.Array3f(*(jit.Float([v]) for v in direction))

    def water_at(s: Any) -> WaterArrays:
        return with_suspended(clear, None, profile(s))

    here = water_at(jit.Float([0.0]))
    field.loss = here.absorption + here.water_scattering + (1 - FORWARD_PEAK) * here.particle_scattering
    sums = sums_along(water_at, field, here, d, RATE)
    asked = jit.Float(np.asarray(distances, dtype=np.float32))
    zero = dr.zeros(jit.UInt32, len(distances))
    lines = SightLines(sums, jit.UInt32(1), [zero] * 4, jit.Float(zero), jit.Float(zero))
    parts = (here.absorption, here.water_scattering, here.particle_scattering, here.downwelling)
    many = WaterArrays(*(v + dr.zeros(jit.Array3f, len(distances)) for v in parts))
    return lines, field, many, d + dr.zeros(jit.Array3f, len(distances)), asked


def ends() -> Any:
    """Of the stretches [m]."""
    return np.cumsum(0.15 * 1.12 ** np.arange(STRETCHES))


def optical_depth(profile: Profile, distance: float) -> Any:
    """Integral of a + 0.8 b by 20 000 steps, `(3,)`."""
    s = (np.arange(20_000) + 0.5) * (distance / 20_000)
    b = np.array(CLEAR.scattering) + GRAM[:, 0] * float(np.array(profile(jit.Float64(s))).mean())
    return (np.array(CLEAR.absorption) + 0.8 * b) * distance


def test_even_water_is_the_closed_form():
    """Sums of stretches telescope: rounding of 32 single-precision sums, 1e-4."""
    distances = [0.05, 0.15, 0.4, 1.0, 3.3, 9.0, 25.0]
    direction = (0.6, 0.48, -0.64)
    lines, field, here, d, s = line(lambda s: 1.5 + 0 * s, direction, distances)
    sight = sight_at(lines, field, here, d, RATE, s)
    depth = jit.Float(4.0)
    whole = beam_veil(field, here, depth, d, s)
    assert np.array(beam_at(field, depth) * sight.beam) == pytest.approx(np.array(whole), rel=1e-4)
    assert np.array(sight.diffuse) == pytest.approx(np.array(path_length(jit.Array3f(RATE), s)), rel=1e-4)
    assert np.array(sight.water.particle_scattering) == pytest.approx(np.array(here.particle_scattering), rel=1e-4)
    assert np.array(sight.water.downwelling) == pytest.approx(np.array(here.downwelling), rel=1e-4)


def test_a_linear_layer_takes_the_integral_of_its_attenuation():
    """T = exp(-integral c ds): the trapezoidal rule is exact at the ends of stretches; inside a stretch h a quadratic
    is taken as linear, off by c' h^2 / 8 at most, with c' = 0.8 b of 0.2 NTU/m."""
    slope = 0.8 * 0.2 * GRAM.max()
    for number in (4, 11, 20, 26):
        length = 0.15 * 1.12 ** (number + 1)
        for part in (0.0, 0.5):
            distance = ends()[number] + part * length
            lines, field, here, d, s = line(LINEAR, (1, 0, 0), [distance])
            seen = -np.array(dr.log(sharp_transmission(sight_at(lines, field, here, d, RATE, s).water, s))).ravel()
            within = slope * length**2 / 8 if part else 0.0
            assert seen == pytest.approx(optical_depth(LINEAR, distance), abs=1.01 * within + 1e-4, rel=1e-4)


def test_a_sharp_layer_is_found_to_half_a_stretch_at_each_edge():
    """A slab from 3 to 5 m, of 1.9 NTU more: half a stretch is 0.24 and 0.36 m there, (0.24 + 0.36) 0.8 b = 0.47 /m."""
    distances = np.array([2.0, 8.0, 15.0])
    lines, field, here, d, s = line(SLAB, (1, 0, 0), distances)
    seen = np.array(dr.log(sharp_transmission(sight_at(lines, field, here, d, RATE, s).water, s)))
    for k, distance in enumerate(distances):
        assert -seen[:, k] == pytest.approx(optical_depth(SLAB, distance), abs=0.47 if distance > 3 else 1e-3)
    local = np.array(waters_at(lines, here, jit.Float([1.0, 4.0, 10.0]))[1].particle_scattering)
    own = np.array(CLEAR.particle_scattering)[:, None]
    assert local == pytest.approx(own + GRAM * [0.1, 2.0, 0.1], rel=1e-3)


@pytest.mark.parametrize("direction", [(0.8, 0.0, -0.6), (0.6, 0.6, 0.529)])
def test_sunlight_turned_into_the_line_is_its_integral(direction: tuple[float, float, float]):
    """V = E(eye) integral of beta(s) e^{-integral l (1 - d_z / s_z)} ds, by quadrature; half a percent, the stretches'
    even water in place of linear, (c' h^2 / 12 of each)."""
    distances = [0.5, 2.0, 6.0, 12.0]
    lines, field, here, d, s = line(LINEAR, direction, distances)
    seen = np.array(sight_at(lines, field, here, d, RATE, s).beam)
    rise = direction[2] / float(np.array(field.below.z)[0])
    cosine = jit.Float(sum(a * float(np.array(b)[0]) for a, b in zip(direction, field.below, strict=True)))
    phase = float(np.array(turning_phase(cosine))[0])
    for k, distance in enumerate(distances):
        at = np.linspace(0, distance, 4001)
        particles = np.array(CLEAR.particle_scattering)[:, None] + GRAM * LINEAR(at)
        water = np.array(CLEAR.water_scattering)[:, None]
        loss = np.array(CLEAR.absorption)[:, None] + water + (1 - FORWARD_PEAK) * particles
        step = distance / 4000
        depth = np.concatenate([np.zeros((3, 1)), np.cumsum(0.5 * (loss[:, 1:] + loss[:, :-1]) * step, axis=1)], axis=1)
        made = (water / (4 * math.pi) + phase * particles) * np.exp(-depth * (1 - rise))
        assert seen[:, k] == pytest.approx(trapezoid(made, at, axis=1), rel=5e-3)


def test_beyond_what_a_file_holds_the_water_goes_on_as_it_was():
    """Fields with `outside: error` are not a number there."""
    lines, field, here, d, s = line(lambda s: dr.select(s > 4, dr.nan, 1.0), (1, 0, 0), [2.0, 20.0])
    found = sight_at(lines, field, here, d, RATE, s)
    assert np.array(found.water.particle_scattering) == pytest.approx(np.array(here.particle_scattering), rel=1e-4)
    assert np.isfinite(np.array(found.beam)).all()


def test_light_on_what_is_seen_through_another_layer_has_come_through_it():
    """8 m deep in clear water, the ground 4 m below in murk: the beam goes through 8 clear and 4 murky metres."""
    base, murk = CLEAR.arrays(), with_suspended(CLEAR.arrays(), None, jit.Float(2.0))
    field = with_column(light_field(CLEAR, SUN), base, base, [base] * 4, jit.Float([8.0]))
    ground = seen_through(field, base, murk, jit.Float([8.0]))
    rates = [np.array(w.absorption + w.water_scattering + 0.25 * w.particle_scattering).ravel() for w in (base, murk)]
    mu = float(np.array(field.below.z)[0])
    expected = np.array(field.beam).ravel() * np.exp(-(8 * rates[0] + 4 * rates[1]) / mu)
    assert np.array(beam_at(ground, jit.Float([12.0]))).ravel() == pytest.approx(expected, rel=1e-3)
    same = np.array(beam_at(field, jit.Float([8.0]))).ravel()
    assert np.array(beam_at(ground, jit.Float([8.0]))).ravel() == pytest.approx(same, rel=1e-3)


@pytest.mark.parametrize(("pitch_deg", "distance"), [(90.0, 6.0), (50.0, 6.0 / math.sin(math.radians(50)))])
def test_a_camera_sees_the_ground_through_the_layers_between(pitch_deg: float, distance: float):
    """14 m deep in clear water, murk from 16 to 20 m. Of a surface's light, sharp over all that arrives is
    exp(-integral of (0.8 b - b_w - b_p / 4)): linear from 0 at 15 m to 1 NTU at 17 m, then constant to the ground at
    20 m, 4 NTU m straight down. 3 % for a stretch whose profile has a bend, and for pixels off the axis."""
    world = build_world(FlatConfig(type="flat", depth_m=20))
    ocean = {"water_type": "IB", "tracers": {"turbidity": {"depth_m": [0, 15, 17, 30], "value": [0, 0, 1, 1]}}}
    made = build_ocean(OceanConfig.model_validate(ocean), world)
    context = SensorContext("auv0.camera", 1, 5_000_000, world.scene(1), world, made, np.full(1, NO_BODY, np.uint32))
    zero, u = jit.Float64([0.0]), jit.UInt32([0])
    none = jit.Array3f64(zero, zero, zero)
    motion = Kinematics(
        jit.Array3f64(zero, zero, zero - 14), jit.Array4f64(zero + 1, zero, zero, zero), none, none, none, none,
        jit.UInt64(u), u + 0, u + 0, u + 0,
    )  # fmt: skip
    config = CameraConfig(
        width_px=32, height_px=32, horizontal_fov_deg=4, orientation_deg=(0.0, pitch_deg, 0.0), exposure="manual"
    )
    found = {n: v for n, v, _ in Camera(config, context).explain(motion)}
    sharp, near, far = (
        np.asarray(found[n]).mean(axis=1)
        for n in ("sharp light", "light scattered by a few degrees", "light scattered forward")
    )
    seen = np.log(sharp / (sharp + near + far))
    slant = distance / 6.0
    particles = np.array(CLEAR.particle_scattering) * 6 + GRAM[:, 0] * 4.0
    expected = slant * (0.8 * (6 * np.array(CLEAR.water_scattering) + particles)
                        - 6 * np.array(CLEAR.water_scattering) - 0.25 * particles)  # fmt: skip
    assert -seen == pytest.approx(expected, rel=0.03)
