"""Plankton and sediment in the water: published coefficients, and the light that follows them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.optics.light_field import beam_at, diffuse_irradiance, light_field, with_column
from pelagos.optics.sunlight import daylight
from pelagos.optics.suspended import plankton_absorption, plankton_scattering, sediment_scattering, with_suspended
from pelagos.optics.water import WaterOptics, kirk, water_optics
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.build import build_world
from pelagos.world.generate.flat import FlatConfig

SUN = daylight(math.radians(50), 0.3)


def test_coefficients_are_those_of_the_sources():
    """Prieur and Sathyendranath at 440 to 490 and at 530 nm, Gordon and Morel's 0.30 at 550 nm, Babin's 0.5 m^2/g."""
    red, green, blue = plankton_absorption()
    assert 0.06 * 0.75 < blue < 0.06 * 0.95
    assert green == pytest.approx(0.06 * 0.45, rel=0.1)
    assert red == pytest.approx(0.06 * 0.28, rel=0.1)
    assert plankton_scattering()[1] == pytest.approx(0.30 * 550 / 535, rel=0.01)
    assert sediment_scattering()[1] == pytest.approx(0.50 * 555 / 535, rel=0.01)


def test_powers_of_chlorophyll_and_lines_of_turbidity():
    base = water_optics("I").arrays()
    one, ten = (with_suspended(base, jit.Float(c), None) for c in (1.0, 10.0))
    ratio = np.array((ten.absorption - base.absorption) / (one.absorption - base.absorption)).ravel()
    assert ratio == pytest.approx(np.full(3, 10**0.65), rel=1e-4)
    two, four = (with_suspended(base, None, jit.Float(n)) for n in (2.0, 4.0))
    gained = [np.array(w.particle_scattering - base.particle_scattering).ravel() for w in (two, four)]
    assert gained[1] == pytest.approx(2 * gained[0], rel=1e-5)
    assert np.array(two.absorption).ravel() == pytest.approx(np.array(base.absorption).ravel())


def test_nothing_suspended_changes_nothing():
    base = water_optics("II").arrays()
    same = with_suspended(base, None, jit.Float(0.0))
    assert np.array(same.downwelling).ravel() == pytest.approx(np.array(base.downwelling).ravel(), rel=1e-5)
    field = light_field(water_optics("II"), SUN)
    local = with_column(field, base, same, [same] * 4, jit.Float(5.0))
    up, z = jit.Array3f(0, 0, 1), jit.Float(7.0)
    for light in (beam_at, lambda f, d: diffuse_irradiance(f, d, up)):
        assert np.array(light(local, z)).ravel() == pytest.approx(np.array(light(field, z)).ravel(), rel=1e-4)


@pytest.mark.parametrize("turbidity", [0.5, 2.0])
def test_murky_water_all_the_way_is_as_dark_as_if_it_had_been_solved_for(turbidity: float):
    """Irradiance on level ground, 6 m deep, against a light field of that water: the shape of the clear water's light
    and Kirk's K in place of the solution keep within 25 %."""
    clear = water_optics("IB")
    murky_particles = np.add(clear.particle_scattering, turbidity * np.array(sediment_scattering()))
    a, w = np.array(clear.absorption), np.array(clear.water_scattering)
    murky = WaterOptics("murky", clear.absorption, clear.water_scattering, tuple(murky_particles),
                        tuple(kirk(a, w, murky_particles)))  # fmt: skip
    up, z = jit.Array3f(0, 0, 1), jit.Float(6.0)

    def level(field: object) -> np.ndarray:
        return np.array(beam_at(field, z) * field.below.z + diffuse_irradiance(field, z, up)).ravel()

    here = with_suspended(clear.arrays(), None, jit.Float(turbidity))
    local = with_column(light_field(clear, SUN), clear.arrays(), here, [here] * 8, jit.Float(6.0))
    assert level(local) == pytest.approx(level(light_field(murky, SUN)), rel=0.25)


def test_a_murky_layer_takes_only_what_it_is_thick():
    """Two of eight steps are murky: the optical depth above the place is theirs and the clear steps' together."""
    base = water_optics("IB").arrays()
    murk = with_suspended(base, None, jit.Float(3.0))
    field = with_column(light_field(water_optics("IB"), SUN), base, murk, [base] * 6 + [murk] * 2, jit.Float(8.0))
    mu = float(np.array(field.below.z)[0])
    f = 0.25
    rates = [np.array(w.absorption + w.water_scattering + f * w.particle_scattering).ravel() for w in (base, murk)]
    expected = np.array(field.beam).ravel() * np.exp(-(6 * rates[0] + 2 * rates[1]) / mu)
    assert np.array(beam_at(field, jit.Float(8.0))).ravel() == pytest.approx(expected, rel=1e-3)
    surface = np.array(beam_at(field, jit.Float(0.0))).ravel()
    assert (surface <= np.array(field.beam).ravel() * 1.0001).all()  # never brighter than under the surface


def test_a_camera_in_or_over_a_murky_layer_sees_less():
    """Contrast of the ground at 20 m, with murk at 12 to 16 m: from inside and from above it, and from below."""
    world = build_world(FlatConfig(type="flat", depth_m=20))
    scene = world.scene(1)
    murk = {"depth_m": [0, 12, 13, 15, 16, 30], "value": [0, 0, 4, 4, 0, 0]}
    ocean = {"water_type": "IB", "tracers": {"turbidity": murk}}

    def veil(depth: float) -> float:
        made = build_ocean(OceanConfig.model_validate(ocean), world)
        context = SensorContext("auv0.camera", 1, 5_000_000, scene, world, made, np.full(1, NO_BODY, np.uint32))
        zero, u = jit.Float64([0.0]), jit.UInt32([0])
        none = jit.Array3f64(zero, zero, zero)
        motion = Kinematics(
            jit.Array3f64(zero, zero, zero - depth), jit.Array4f64(zero + 1, zero, zero, zero), none, none, none, none,
            jit.UInt64(u), u + 0, u + 0, u + 0,
        )  # fmt: skip
        config = CameraConfig(width_px=32, height_px=32, orientation_deg=(0.0, 90.0, 0.0), exposure="manual")
        found = {n: v for n, v, _ in Camera(config, context).explain(motion)}
        sharp, fog = (np.asarray(found[n]).mean() for n in ("sharp light", "veiling light"))
        return float(fog / (fog + sharp))

    assert veil(14.0) > 0.8
    assert veil(11.0) > 0.8
    assert veil(17.0) < 0.5
