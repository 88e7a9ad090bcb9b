"""Paths in layered water and between boundaries against closed forms and published arrivals."""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, trapezoid

from cases import slow
from pelagos import jit
from pelagos.acoustics.eigenrays import eigenrays
from pelagos.acoustics.image_sources import paths
from pelagos.acoustics.refraction import (
    LEVELS,
    Profile,
    arc,
    depart,
    displacements,
    entered,
    excess_at,
    path_end,
    profile_from,
    reduced_range,
)
from pelagos.acoustics.section import Section


def profile(speed, *, lowest=-100.0, highest=100.0):
    """One row: `speed` is a function of the height [m]."""
    height = np.linspace(lowest, highest, LEVELS)
    here = float(speed(0.0))
    return profile_from(
        jit.Float((speed(height) - here).astype(np.float32)),
        *(jit.Float([float(v)]) for v in (here, lowest, height[1] - height[0])),
    )


def follow(water, angle, reach, *, arcs):
    """Distance, height, angle, and reduced range of a ray at the ends of its arcs."""
    ray = depart(water, jit.UInt32(0), jit.Float(0), jit.Float(math.sin(angle)))
    x, found = 0.0, []
    for _ in range(arcs):
        ray, chord = arc(water, ray, jit.Float(reach / arcs))
        x += chord.length[0] * chord.cosine[0]
        found.append((x, ray.height[0], math.atan2(ray.sine[0], ray.cosine[0])))
    return np.array(found)


def test_a_profile_is_summed_in_three_kernels_however_many_its_levels():
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        profile(lambda z: 1500.0 + 0.017 * z)
        dr.kernel_history_clear()
        profile(lambda z: 1480.0 - 0.3 * z)
        assert len(dr.kernel_history([dr.KernelType.JIT])) <= 3


@pytest.mark.parametrize("degrees", [0.0, 5.0, -20.0, 70.0])
@pytest.mark.parametrize("gradient", [0.017, -0.3])
def test_arcs_in_a_linear_gradient_are_one_circle(gradient, degrees):
    """Centre at the height where the speed would be zero, z = -c/g, radius c/(g cos theta): all ends lie on it."""
    water = profile(lambda z: 1500.0 + gradient * z)
    angle = math.radians(degrees)
    found = follow(water, angle, 90.0, arcs=5)
    radius = 1500.0 / (gradient * math.cos(angle))  # signed: the centre is above where sound is slower upwards
    x0, z0 = radius * math.sin(angle), -radius * math.cos(angle)
    assert np.hypot(found[:, 0] - x0, found[:, 1] - z0) == pytest.approx(abs(radius), abs=2e-3)
    assert found[:, 2] == pytest.approx(np.arcsin((x0 - found[:, 0]) / radius), abs=2e-5)


def thermocline(z):
    """A warm layer above: 12 m/s over 20 m, about 20 m below the sonar."""
    return 1490.0 + 6.0 * np.tanh((z + 20.0) / 8.0)


@pytest.mark.parametrize("degrees", [-8.0, -30.0, -80.0])
def test_snells_law_holds_through_layers(degrees):
    """cos(theta)/c is the same at the end of each arc, whatever lies between; single precision."""
    found = follow(profile(thermocline), math.radians(degrees), 80.0, arcs=4)
    height = np.linspace(-100, 100, LEVELS)
    speed, here = np.interp(found[:, 1], height, thermocline(height)), np.interp(0.0, height, thermocline(height))
    assert np.cos(found[:, 2]) / speed == pytest.approx(math.cos(math.radians(degrees)) / here, rel=1e-5)


@pytest.mark.parametrize("degrees", [slow(-8.0), -30.0, slow(-80.0)])
def test_arcs_follow_the_ray_that_is_integrated_numerically(degrees):
    """dx = cos, dz = sin, d theta = -cos(theta) c'/c, dt = 1/c per metre, by Runge-Kutta steps of 2 cm.

    The turn is up to 0.012 rad at the steep angles and 0.06 at 8 deg: a tenth of its square times 20 m, 0.3 and 7 mm.
    """
    height = np.linspace(-100, 100, LEVELS)
    speed = lambda z: np.interp(z, height, thermocline(height))
    slope = lambda z: (speed(z + 1e-4) - speed(z - 1e-4)) / 2e-4

    def rate(state):
        _, z, theta, _ = state
        return np.array(
            [math.cos(theta), math.sin(theta), -math.cos(theta) * slope(z) / speed(z), thermocline(0.0) / speed(z)]
        )

    state, reach, h = np.array([0.0, 0.0, math.radians(degrees), 0.0]), 80.0, 0.02
    while state[3] < reach - h:
        k1 = rate(state)
        k2 = rate(state + h / 2 * k1)
        k3 = rate(state + h / 2 * k2)
        k4 = rate(state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    state = state + (reach - state[3]) / rate(state)[3] * rate(state)
    for arcs, bound in ((4, 0.02), (8, 0.01)):
        x, z, theta = follow(profile(thermocline), math.radians(degrees), reach, arcs=arcs)[-1]
        assert math.hypot(x - state[0], z - state[1]) < bound
        assert theta == pytest.approx(state[2], abs=5e-4)
    direction = jit.Array3f(math.cos(math.radians(degrees)), 0, math.sin(math.radians(degrees)))
    end = np.array(path_end(profile(thermocline), jit.UInt32(0), direction, jit.Float(reach), arcs=16)).ravel()
    assert end == pytest.approx([state[0], 0.0, state[1]], abs=0.004)


@pytest.mark.parametrize("degrees", [-8.0, 5.0, -30.0, -80.0])
def test_arcs_of_sonars_are_the_rays_of_the_channel(degrees):
    """The ray that the channel finds to where an arc's path ends leaves at its angle and takes its time.

    Sixteen arcs over 80 m: 4 mm, which is 3 us, and over the least distance across the ray 3e-4 rad.
    """
    height = np.linspace(-100, 100, LEVELS)
    depth, speed = 100.0 - height[::-1], thermocline(height)[::-1]
    section = Section(depth[:-1], speed[:-1], np.zeros(1), np.array([500.0]))
    here, reach = float(np.interp(0.0, height, thermocline(height))), 80.0
    direction = jit.Array3f(math.cos(math.radians(degrees)), 0, math.sin(math.radians(degrees)))
    end = np.array(path_end(profile(thermocline), jit.UInt32(0), direction, jit.Float(reach), arcs=16)).ravel()
    found = eigenrays([section], np.array([100.0]), 100.0 - end[2:], end[:1])
    direct = found.take((found.surface == 0) & (found.bottom == 0))
    k = int(np.argmin(np.abs(direct.departure + math.radians(degrees))))
    assert direct.departure[k] == pytest.approx(-math.radians(degrees), abs=3e-4)
    assert direct.delay[k] == pytest.approx(reach / here, abs=3e-6)


def test_time_within_an_arc():
    """Straight up in c = c0 + g z the time to height z is ln(1 + g z/c0)/g."""
    water = profile(lambda z: 1500.0 + 2.0 * z)
    ray = depart(water, jit.UInt32(0), jit.Float(0), jit.Float(1.0))
    _, chord = arc(water, ray, jit.Float(50.0))
    assert chord.length[0] == pytest.approx((math.exp(2.0 * 50.0 / 1500.0) - 1) * 1500.0 / 2.0, rel=1e-5)
    for part in (0.25, 0.6):
        z = part * chord.length[0]
        exact = math.log(1.0 + 2.0 * z / 1500.0) / 2.0 * 1500.0
        # the next order of the slowness: (g L/c)^2/12 of L, 0.04 % where it is largest
        assert reduced_range(chord, jit.Float(part), jit.Float(50.0))[0] == pytest.approx(exact, rel=5e-4)


def test_refraction_matters_where_a_level_ray_is_displaced():
    """g R^2/(2 c) over R: 0.05 1/s over 200 m displaces by a third of a percent; a second column stands still."""
    depth = np.linspace(0, 100, 101)
    columns = np.stack([1500 - 0.05 * depth, 1500 + 0 * depth])
    found = displacements(depth, columns, 200.0)
    assert found == pytest.approx([0.05 * 200.0 / (2 * 1500.0), 0.0], rel=4e-3)


def test_pekeris_arrivals():
    """org-arl/UnderwaterAcoustics.jl: depth 20 m, source 5 m, receiver 10 m deep at 100 m; 1538.9236 m/s."""
    expected = [
        (0, 0, 100.124922, 65.061659, 2.8624), (1, 0, 101.118742, 65.707448, 8.5308),
        (0, 1, 103.077641, 66.980350, 14.0362), (1, 1, 105.948101, 68.845589, 19.2900),
        (1, 1, 109.658561, 71.256664, 24.2277), (2, 1, 114.127122, 74.160357, 28.8108),
        (1, 2, 119.268604, 77.501317, 33.0239),
    ]  # fmt: skip
    for path, (surface, bottom, length, time, angle) in zip(paths(20, 5, 10, 100, count=7), expected, strict=True):
        assert (path.surface, path.bottom) == (surface, bottom)
        assert path.length == pytest.approx(length, abs=1e-6)
        assert path.length / 1538.9236 * 1e3 == pytest.approx(time, abs=1e-5)
        assert math.degrees(path.angle) == pytest.approx(angle, abs=1e-4)


def test_paths_are_reciprocal():
    there, back = paths(30, 4, 21, 250, count=9), paths(30, 21, 4, 250, count=9)
    assert [p.length for p in there] == pytest.approx([p.length for p in back], rel=1e-12)
    assert [(p.surface, p.bottom) for p in there] == [(p.surface, p.bottom) for p in back]


def test_a_profile_is_linear_between_its_levels_and_goes_on_as_at_its_ends():
    """Its speed, gradient and integral over the height, of two rows, by the trapezoidal rule on a fine grid."""
    rng = np.random.default_rng(3)
    lowest, step = np.array([-90.0, -30.0]), np.array([2.0, 1.5])
    excess, speed = rng.normal(0.0, 2.0, (2, LEVELS)), np.array([1490.0, 1510.0])
    height = lowest[:, None] + step[:, None] * np.arange(LEVELS)
    column = np.zeros_like(excess)
    for k in range(2):
        excess[k] -= np.interp(0.0, height[k], excess[k])
        whole = cumulative_trapezoid(excess[k], height[k], initial=0.0)
        grid = np.linspace(height[k, 0], 0.0, 20001)
        column[k] = whole - trapezoid(np.interp(grid, height[k], excess[k]), grid)
    made = Profile(*(jit.Float(v.ravel().astype(np.float32)) for v in (excess, column, speed, lowest, step)))
    for k in range(2):
        asked = np.array([height[k, 0] - 7.0, height[k, 0] + 0.3, -11.7, 0.4, 21.2, height[k, -1] + 12.0])
        found = [np.array(v) for v in excess_at(made, jit.UInt32(np.full(6, k)), jit.Float(asked))]
        assert found[0] == pytest.approx(np.interp(asked, height[k], excess[k]), abs=1e-4)
        layer = np.clip(np.floor((asked - lowest[k]) / step[k]).astype(int), 0, LEVELS - 2)
        assert found[1] == pytest.approx((excess[k, layer + 1] - excess[k, layer]) / step[k], abs=1e-4)
        for z, integral in zip(asked, found[2], strict=True):
            grid = np.linspace(0.0, z, 20001)
            exact = trapezoid(np.interp(grid, height[k], excess[k]), grid)
            assert integral == pytest.approx(exact, abs=2e-3)


def test_a_ray_that_goes_on_in_other_water_keeps_its_vertical_part():
    """sin(theta)/c across a vertical boundary; what would be beyond straight up is straight up."""
    rows = [profile(lambda z, k=k: 1500.0 + 30.0 * k + 0.2 * z) for k in range(2)]
    sine = np.array([0.6, -0.3, 0.995], np.float32)
    ray = depart(rows[0], jit.UInt32([0, 0, 0]), jit.Float([40.0, -20.0, 0.0]), jit.Float(sine))
    after = entered(rows[0], ray, rows[1], jit.UInt32([0, 0, 0]))
    old, new = 1500.0 + 0.2 * np.array([40.0, -20.0, 0.0]), 1530.0 + 0.2 * np.array([40.0, -20.0, 0.0])
    expected = np.clip(sine * new / old, -1.0, 1.0)
    assert np.array(after.sine) == pytest.approx(expected, abs=1e-5)
    assert np.array(after.cosine) == pytest.approx(np.sqrt(1 - expected**2), abs=1e-3)
    assert np.array(after.slowness) == pytest.approx(np.sqrt(1 - expected**2) / new, abs=1e-6)
    assert np.array(after.height) == pytest.approx([40.0, -20.0, 0.0])
