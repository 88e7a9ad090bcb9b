"""Parts of the loads on floating hulls, each by another way: sums over pairs of waves, exact memory, whole matrices."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.errors import InputError
from pelagos.hydro.forward_speed import section_motion
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.vehicles import forward_speed, seakeeping
from pelagos.vehicles.drift import DriftConfig, compile_drift
from pelagos.vehicles.forward_speed import CutOff, ForwardSpeed, compile_forward_speed
from pelagos.vehicles.heading_table import HeadingTable
from pelagos.vehicles.inertia import CoriolisConfig
from pelagos.vehicles.radiation_kernels import Kernel, momentum, remember, states
from pelagos.vehicles.seakeeping import Seakeeping, upright

Values = NDArray[np.float64]
OMEGA: Final = [0.4, 1.0, 1.3, 2.2]
HEADINGS: Final = [0.0, 45.0, 90.0, 135.0, 180.0]
MATRIX: Final = np.random.default_rng(1).uniform(1.0, 9.0, (6, 6)) + np.diag([40.0, 50, 60, 70, 80, 90])
ADDED: Final = (MATRIX + MATRIX.T) / 2


def plain(values: Any) -> Values:
    return np.array([float(np.array(v).ravel()[0]) for v in values])


def at_table(values: Values, omega: float, bearing_deg: float) -> Values:
    """Of the nearest of 384 even frequencies from nothing at zero to the last, linear between headings."""
    step = OMEGA[-1] / 383
    w = min(round(omega / step), 383) * step
    known = np.concatenate([np.zeros((1, *values.shape[1:])), values])
    rows = np.array([[np.interp(w, [0.0, *OMEGA], known[:, j, k]) for k in range(known.shape[2])]
                     for j in range(known.shape[1])])  # fmt: skip
    bearing = abs((bearing_deg + 180) % 360 - 180)
    return np.array([np.interp(bearing, HEADINGS, rows[:, k]) for k in range(rows.shape[1])])


def test_a_table_gives_the_nearest_frequency_and_is_linear_in_heading() -> None:
    """Two parts of three numbers in each of three layers; below, between and beyond its frequencies, to either side."""
    values = np.random.default_rng(7).normal(size=(4, 5, 18))
    table = HeadingTable.even(OMEGA, values, layers=3)
    omega = [0.1, 0.41, 1.17, 2.19, 2.7, 9.0, 1.6, 0.0]
    bearing = [20.0, -70.0, 110.0, -178.0, 180.0, 33.0, 0.0, 91.0]
    layer = [0, 1, 2, 0, 1, 2, 1, 0]
    size, turn = np.linspace(0.2, 7.0, 8), np.radians(bearing)
    heading = [jit.Float64(size * np.cos(turn)), jit.Float64(size * np.sin(turn))]
    found = table.at(table.on_device(), jit.Float64(omega), heading, jit.UInt32(layer))
    rows = np.concatenate([part.numpy() for part in found]).T
    for row, w, at, k in zip(rows, omega, bearing, layer, strict=True):
        np.testing.assert_allclose(row, at_table(values, w, at)[6 * k : 6 * k + 6], atol=1e-9)


def test_pairs_of_waves_drift_a_hull_by_the_mean_of_their_coefficients() -> None:
    """sum over i, j of (D_i + D_j) / 2 a_i a_j cos(p_i - p_j), less what the pressure does of itself; waves of three
    frequencies from both sides, at two hulls that look elsewhere.
    """
    rng = np.random.default_rng(3)
    force, own = rng.uniform(0.5, 2.0, (4, 5, 3)), rng.uniform(0.1, 0.3, (4, 5, 3))
    drift = compile_drift(DriftConfig.model_validate(
        {"omega_radps": OMEGA, "heading_deg": HEADINGS, "force": force.tolist(), "own": own.tolist()}
    ))  # fmt: skip
    waves = [(0.8, 35.0, 0.7, 20.0), (1.2, 260.0, 0.4, -75.0), (2.0, 140.0, 0.25, 160.0)]
    sea = [
        {"type": "regular", "height_m": 2 * a, "period_s": 2 * np.pi / w, "towards_deg": d, "phase_deg": p}
        for w, d, a, p in waves
    ]
    water = build_ocean(OceanConfig.model_validate({"waves": sea, "waves_depth_m": None}), seed=1).waves
    hulls = [(7.0, -11.0, 25.0, 3.0), (-40.0, 15.0, 200.0, 8.5)]
    x, y, compass, t = (np.array(column) for column in zip(*hulls, strict=True))
    turn = np.radians(compass)
    device = [jit.Float64(v) for v in (x, y, np.cos(turn), np.sin(turn), t)]
    found = drift.push(water, drift.rows.on_device(), *device[:2], (device[2], device[3]), device[4])
    for k in range(2):
        amplitude, phase, each = [], [], []
        for w, d, a, p in waves:
            north, east = math.cos(math.radians(d)), math.sin(math.radians(d))
            amplitude.append(a)
            phase.append(w**2 / 9.81 * (x[k] * north - y[k] * east) - w * t[k] + math.radians(p))
            side = np.sign(math.sin(math.radians(d - compass[k])))
            each.append(at_table(force - own, w, d - compass[k]) * [1.0, side, side])
        expected = sum(
            (each[i] + each[j]) / 2 * amplitude[i] * amplitude[j] * math.cos(phase[i] - phase[j])
            for i in range(3) for j in range(3)
        )  # fmt: skip
        np.testing.assert_allclose([np.array(f)[k] for f in found], expected, rtol=0.01, atol=0.005)


def _kernels(count: int, seed: int) -> tuple[Kernel, ...]:
    """Of two poles each, between unlike directions."""
    rng = np.random.default_rng(seed)
    places = [(2, 1), (0, 2), (1, 1)] if count == 3 else [(2, 4), (5, 1), (4, 2)]
    return tuple(
        Kernel(row, column, (complex(-rng.uniform(0.2, 1), 0.0), complex(-rng.uniform(0.2, 1), rng.uniform(1, 2))),
               (complex(rng.uniform(5, 9), 0.0), complex(*rng.uniform(-9, 9, 2))))
        for row, column in places
    )  # fmt: skip


def test_memory_is_the_integral_of_exponentials_and_its_force_that_in_the_steps_middle() -> None:
    """sum over steps of weight v_k (e^{p (t - t_k)} - e^{p (t - t_k - h)}) / p; the momentum is weight / p of it."""
    rng, h = np.random.default_rng(4), 0.13
    kernels, velocities = _kernels(6, 8), rng.normal(size=(7, 6))
    memory: list[Any] = [0.0] * states(kernels)
    for v in velocities:
        before = memory
        memory, wrench = remember(kernels, before, list(v), h)
    expected, held = np.zeros(6), np.zeros(6)
    for kernel in kernels:
        for pole, weight in zip(kernel.poles, kernel.weights, strict=True):
            ends = [
                sum(v[kernel.column] * (np.exp(pole * (n - k) * h) - np.exp(pole * (n - k - 1) * h)) / pole
                    for k, v in enumerate(velocities[:n])) for n in (6, 7)
            ]  # fmt: skip
            expected[kernel.row] -= (weight * np.mean(ends)).real
            held[kernel.row] += (weight / pole * np.mean(ends)).real
    np.testing.assert_allclose(plain(wrench), expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(plain(momentum(kernels, before, memory)), held, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("astern", [True, False])
@pytest.mark.parametrize("speed", [1.7, -0.9])
@pytest.mark.parametrize("rest", ["upright", "yaws", "transom"])
def test_speed_takes_the_momentum_that_goes_along(rest: str, speed: float, astern: bool) -> None:
    """U P3 in pitch and -U P2 in yaw of the memory and of what waves take from A nu; a transom loses U times its own,
    ahead only. With a table of zero speed, astern all of it is off, and U A(inf) nu in pitch with it.
    """
    rng = np.random.default_rng(12)
    nu, velocity, radiated = rng.normal(size=6), rng.normal(size=6), rng.normal(size=6)
    section, kernels = rng.normal(size=(3, 3)), _kernels(3, 5)
    before, after = rng.normal(size=states(kernels)), rng.normal(size=states(kernels))
    cut = CutOff(section_motion(-1.4).tolist(), section.tolist(), kernels)
    ahead = ForwardSpeed(
        added=ADDED.tolist(), upright=MATRIX.T.tolist() if rest == "upright" else None, yaws=rest == "yaws",
        transom=cut if rest == "transom" else None, astern=astern,
    )  # fmt: skip
    flow: Any = SimpleNamespace(nu_c=nu.tolist(), seaway=SimpleNamespace(speed=speed, velocity=velocity.tolist()))
    found = plain(ahead.load(flow, radiated.tolist(), before.tolist(), after.tolist()))
    counted = speed if astern else max(speed, 0.0)
    beyond = ADDED @ (velocity - nu) + radiated
    expected = np.zeros(6)
    expected[4] = counted * beyond[2]
    if not astern:
        expected[4] += max(-speed, 0.0) * (ADDED @ nu)[2]
    if rest == "yaws":
        expected[5] = -counted * beyond[1]
    if rest == "upright":
        p = MATRIX.T @ nu
        expected[2] -= np.cross(nu[3:], p[:3])[2]
        expected[4] -= (np.cross(nu[:3], p[:3]) + np.cross(nu[3:], p[3:]))[1]
    if rest == "transom":
        motion = section_motion(-1.4)
        lost = section @ motion @ velocity + plain(momentum(kernels, before.tolist(), after.tolist(), count=3))
        expected -= max(speed, 0.0) * motion.T @ lost
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def _speeds(coriolis: dict[str, Any], **found: Any) -> ForwardSpeed | None:
    coefficients = SimpleNamespace(**{"transom": None, "omega_radps": OMEGA, "diffraction": None, **found})
    config: Any = SimpleNamespace(forward_speed="strip", coefficients=coefficients)
    body: Any = SimpleNamespace(rigid=MATRIX, density=1020.0)
    return compile_forward_speed(config, body, CoriolisConfig.model_validate(coriolis), ADDED.tolist())


def test_what_speed_adds_follows_from_the_coriolis_forces_that_a_model_has(monkeypatch: pytest.MonkeyPatch) -> None:
    whole, bare, tank = _speeds({}), _speeds({"rigid": "none"}), _speeds({"without": [[6, 1], [1, 2]]})
    assert whole is not None
    assert bare is not None
    assert tank is not None
    assert (whole.upright, whole.yaws, bare.yaws, tank.upright, tank.yaws) == (None, True, False, None, False)
    np.testing.assert_allclose(bare.upright, MATRIX + ADDED)
    assert _speeds({"without": [[2, 1]]}).yaws  # type: ignore[union-attr]
    assert (whole.astern, _speeds({}, diffraction=1).astern) == (True, False)  # type: ignore[union-attr]
    for row in (3, 4, 5):
        with pytest.raises(InputError, match="without takes"):
            _speeds({"without": [[1, 1], [row, 2]]})
    monkeypatch.setattr(forward_speed, "fitted_kernels", lambda omega, damping: (omega, damping))
    damping = np.random.default_rng(2).uniform(1, 2, (4, 3, 3))
    cut = SimpleNamespace(position_x_m=-2.5, added_mass_infinite=ADDED[:3, :3], damping=damping)
    transom = _speeds({}, transom=cut).transom  # type: ignore[union-attr]
    assert transom is not None
    np.testing.assert_allclose(transom.motion, section_motion(-2.5))
    np.testing.assert_allclose(transom.added, 1020.0 * ADDED[:3, :3])
    np.testing.assert_allclose(transom.kernels[0], OMEGA)
    np.testing.assert_allclose(transom.kernels[1], 1020.0 * damping)


TILT: Final = Rotation.from_euler("ZYX", [2.1, -0.3, 0.4])
REST: Final = np.array([3.0, -2.0, 7.0, 5.0, -4.0, 1.0])


class Stub:
    """Drift and diffraction that are always the same, and remember what they were asked."""

    def __init__(self, found: list[float]) -> None:
        self.found, self.asked = found, ()

    def push(self, *asked: Any, **more: Any) -> list[float]:
        self.asked = (*asked[1:], more)
        return self.found


def hull(monkeypatch: pytest.MonkeyPatch, **more: Any) -> tuple[Seakeeping, list[Any]]:
    """A hull whose pressure is given, and what was asked of the pressure."""
    asked: list[Any] = []

    def pressure(waves: Any, table: Any, level: Any, depth: Any, active: Any = None) -> Any:
        asked.append((waves, plain(np.array([[float(np.array(v)[0]) for v in row] for row in level]).ravel()),
                      float(np.array(depth)[0]), active))  # fmt: skip
        return [jit.Float64(v) for v in (0.3, -0.2, -1.5)], [jit.Float64(v) for v in (0.5, 0.7, -0.4)]

    monkeypatch.setattr(seakeeping, "hull_pressure", pressure)
    mesh: Any = np.zeros((0, 3))
    made = Seakeeping(
        vertices=mesh, faces=mesh, plane=None, density=1010.0, gravity=9.7, rest=REST.tolist(),  # type: ignore[arg-type]
        weight=15000.0, center_of_gravity=[0.2, -0.1, -0.35], added=ADDED.tolist(), stiffness=mesh,
        kernels=_kernels(6, 3), drift=None,
    )  # fmt: skip
    return replace(made, **more), asked


@pytest.mark.parametrize("tide", [None, 0.6])
@pytest.mark.parametrize("scatters", [False, True])
def test_the_load_is_that_of_pressure_weight_drift_and_water(
    monkeypatch: pytest.MonkeyPatch, tide: float | None, scatters: bool
) -> None:
    """Pressure by the water's own weight at the hull, drift and diffraction by its density, along the heading."""
    drift, scattered = Stub([4.0, -6.0, 9.0]), Stub([1.0, 2.0, -3.0, -4.0, 5.0, 6.0])
    diffraction = scattered if scatters else None
    made, asked = hull(monkeypatch, drift=drift, diffraction=diffraction)
    places = []

    def density(place: Any, t: Any) -> Any:
        places.append(np.concatenate([plain(place), plain([t])]))
        return jit.Float64(1031.0)

    level = None if tide is None else SimpleNamespace(level=lambda t: tide * t)
    ocean = SimpleNamespace(density=density, tide=level, sea=lambda n: n)
    turn = TILT.as_matrix()
    rotation = [[jit.Float64(float(c)) for c in row] for row in turn]
    position = [jit.Float64(v) for v in (12.0, -5.0, 0.25)]
    water = np.array([0.1, -0.2, 0.3, 0.04, -0.05, 0.06])
    table: Any = SimpleNamespace(drift="d", diffraction="s")
    t, speed = jit.Float64(2.5), jit.Float64(1.3)
    waves: Any = object()
    found = plain(made.load(ocean, waves, position, rotation, water.tolist(), t, table, speed=speed))
    level_body = Rotation.from_euler("Z", 2.1).as_matrix().T @ turn  # body axes to axes along the heading
    down = 15000.0 * turn[2]
    expected = 1031.0 * 9.7 * np.array([0.3, -0.2, -1.5, 0.5, 0.7, -0.4]) - REST
    expected += np.concatenate([down, np.cross([0.2, -0.1, -0.35], down)])
    expected += 1031.0 * np.concatenate([level_body.T @ [4.0, -6.0, 0.0], level_body.T @ [0.0, 0.0, 9.0]])
    if scatters:
        expected += 1031.0 * np.concatenate([level_body.T @ [1.0, 2.0, -3.0], level_body.T @ [-4.0, 5.0, 6.0]])
    else:
        expected += ADDED @ water
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-6)
    assert asked[0][0] is waves
    np.testing.assert_allclose(asked[0][1], level_body.ravel(), atol=1e-12)
    assert asked[0][2] == pytest.approx(0.25 + (tide or 0.0) * 2.5)
    np.testing.assert_allclose(places[0], [12.0, 5.0, -0.25, 2.5])
    compass = [math.cos(2.1), math.sin(2.1)]
    np.testing.assert_allclose(plain([*drift.asked[1:3], *drift.asked[3]]), [12.0, 5.0, *compass])
    assert drift.asked[0] == "d"
    if scatters:
        assert scattered.asked[0] == "s"
        np.testing.assert_allclose(plain([*scattered.asked[1], *scattered.asked[2]]), [12.0, 5.0, *compass])
        assert scattered.asked[-1]["speed"] is speed


def test_in_still_water_a_hull_floats_in_the_density_that_it_is_made_for(monkeypatch: pytest.MonkeyPatch) -> None:
    made, asked = hull(monkeypatch)
    rotation = [[jit.Float64(float(c)) for c in row] for row in TILT.as_matrix()]
    active: Any = object()
    found = plain(made.still_load(jit.Float64(0.4), rotation, None, active))  # type: ignore[arg-type]
    down = 15000.0 * TILT.as_matrix()[2]
    expected = 1010.0 * 9.7 * np.array([0.3, -0.2, -1.5, 0.5, 0.7, -0.4]) - REST
    expected += np.concatenate([down, np.cross([0.2, -0.1, -0.35], down)])
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert asked[0][2:] == (0.4, active)
    level = np.array([[float(np.array(v)[0]) for v in row] for row in upright(rotation)])
    np.testing.assert_allclose(made.to_body(rotation, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
                               [*([1.0, 2.0, 3.0] @ level)[:, None], *([4.0, 5.0, 6.0] @ level)[:, None]])  # fmt: skip


def test_the_memory_of_a_transom_follows_that_of_the_hull(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its values are the last ones, its velocity that of its section, and its wrench is no part of the hull's."""
    rng, transom = np.random.default_rng(6), _kernels(3, 5)
    cut = CutOff(section_motion(-1.4).tolist(), ADDED[:3, :3].tolist(), transom)
    made, _ = hull(monkeypatch, ahead=ForwardSpeed(ADDED.tolist(), None, True, cut))
    before = rng.normal(size=states(made.kernels) + states(transom))
    assert made.memory == len(before)
    split, velocity = states(made.kernels), rng.normal(size=6)
    new, wrench = made.remember(before.tolist(), velocity.tolist(), 0.1)
    own, push = remember(made.kernels, before[:split].tolist(), velocity.tolist(), 0.1)
    other, _ = remember(transom, before[split:].tolist(), (section_motion(-1.4) @ velocity).tolist(), 0.1)
    np.testing.assert_allclose(plain(new), plain([*own, *other]))
    np.testing.assert_allclose(plain(wrench), plain(push))
    flow: Any = SimpleNamespace(nu_c=velocity.tolist(), seaway=SimpleNamespace(speed=2.0, velocity=[0.5] * 6))
    radiated = momentum(made.kernels, before[:split].tolist(), own)
    assert made.ahead is not None
    expected = made.ahead.load(flow, radiated, before[split:].tolist(), other)
    np.testing.assert_allclose(plain(made.load_at_speed(before.tolist(), new, flow)), plain(expected))
    still: Any = SimpleNamespace(nu_c=[1.0] * 6, seaway=None)
    assert made.load_at_speed(before.tolist(), new, still) == [0.0] * 6
