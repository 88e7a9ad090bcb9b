"""Speed ahead in waves: strip theory's coefficients out of the time domain, and motions against their closed form."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.hydro.coriolis import coriolis_force
from pelagos.hydro.forward_speed import SLOPE, Transom, at_speed, scattered_at_speed
from pelagos.math import so3
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.vehicles.afloat_config import AfloatConfig
from pelagos.vehicles.diffraction import DiffractionConfig, compile_diffraction
from pelagos.vehicles.flow import Flow, Seaway
from pelagos.vehicles.integrate import Rigid

RHO, G, LENGTH = 1025.0, 9.81, 160.93
TABLE = json.loads((files("pelagos.vehicles.catalogue") / "mariner_strips.bem.json").read_text(encoding="utf-8"))
TABLE["added_mass_infinite"][0][0] = 0.0  # strip theory has none; the simulator adds the moments of its momentum
RNG = np.random.default_rng(11)


def ship(*, diffraction: bool, **more: Any) -> pl.Vehicle:
    """The Mariner's hull and coefficients with nothing else: no propeller, no rudder, no damping but of waves."""
    radiation = {k: v for k, v in TABLE.items() if diffraction or k != "diffraction"} | more
    return pl.Vehicle.from_dict({
        "type": "custom", "density_kg_m3": RHO, "length_m": LENGTH, "beam_m": 23.17, "height_m": 15.0,
        "mass": {"type": "explicit", "mass_kg": 1.7045e7, "inertia_kg_m2": [1.05e9, 2.1e10, 2.1e10],
                 "center_of_gravity_m": [0.0, 0.0, -0.6]},
        "added_mass": {"type": "none"},
        "terms": {"hydrostatics": {"type": "hydrostatic", "heave_n_m": 2.7e7, "roll_n_m": 2e8, "pitch_n_m": 3.5e10}},
        "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators",
        "afloat": {"radiation": radiation, "restoring": "hull", "forward_speed": "strip",
                   "hulls": [{"length_m": LENGTH, "beam_m": 23.17, "freeboard_m": 9.0,
                              "waterplane_coefficient": 0.72, "section_coefficient": 0.7556}]},
    })  # fmt: skip


def harmonic(values: np.ndarray, t: np.ndarray, omega: float) -> np.ndarray:
    """Complex amplitudes (k) of exp(i omega t) in rows of `(times, k)`."""
    basis = np.stack([np.ones_like(t), np.cos(omega * t), np.sin(omega * t)], axis=-1)
    found = np.linalg.lstsq(basis, values, rcond=None)[0]
    return found[1] - 1j * found[2]


def played(step: Any, state: Any, *, steps: int, late: int, shape: tuple[int, int]) -> np.ndarray:
    """Values `(late, *shape)`, by quantity and lane, of the last of all `state, values = step(state, i)`: one loop on
    the device.
    """
    out, lane = dr.zeros(jit.Float64, late * shape[0] * shape[1]), dr.arange(jit.UInt32, shape[1])

    def body(i: Any, state: Any) -> Any:
        state, values = step(state, i)
        row = (i - (steps - late)) * shape[0]
        for k, value in enumerate(values):
            dr.scatter(out, jit.Float64(value), (row + k) * shape[1] + lane, i >= steps - late)
        return i + 1, state

    begun = dr.zeros(jit.UInt32, shape[1]), state
    dr.eval(dr.while_loop(begun, lambda i, state: i < steps, body, mode="symbolic"))
    return np.array(out).reshape(late, *shape)


TRANSOM = {
    "position_x_m": -71.0, "added_mass_infinite": [[40.0, 0.0, -55.0], [0.0, 90.0, 0.0], [-55.0, 0.0, 310.0]],
    "damping": [[[w * np.exp(-w) * 30, 0.0, w * np.exp(-w) * 4], [0.0, 50 * w * np.exp(-1.2 * w), 0.0],
                 [w * np.exp(-w) * 4, 0.0, 90 * w * np.exp(-w)]] for w in TABLE["omega_radps"]],
}  # fmt: skip


def test_forced_motion_gives_the_coefficients_of_strip_theory() -> None:
    """Lanes: each direction at five speeds, astern too, and two frequencies. What memory, A(inf) and its Coriolis
    forces push is analysed for added mass and damping of motions along axes that do not turn. A velocity is held over a
    step of h and the force is taken in its middle: (omega h)^2 / 8 of it, 2e-4; transients have died to 1e-4 by then.
    """
    sea = ship(diffraction=False, transom=TRANSOM).model.sea
    assert sea is not None
    assert sea.ahead is not None
    assert sea.ahead.transom is not None
    lanes = np.meshgrid([1, 2, 3, 4, 5], [-3.0, 0.0, 2.0, 5.0, 7.7], [0.45, 0.9])
    columns, speeds, omegas = (a.ravel() for a in lanes)
    moved = np.zeros((6, len(columns)), complex)
    moved[columns, np.arange(len(columns))] = 1j * omegas
    moved[2] += np.where(columns == 4, speeds, 0.0)
    moved[1] -= np.where(columns == 5, speeds, 0.0)
    moved *= 1e-3
    h, steps, late = 0.04, 5000, round(8 * np.pi / 0.45 / 0.04)  # whole periods of both
    re, im = ([jit.Float64(np.ascontiguousarray(row)) for row in part] for part in (moved.real, moved.imag))
    u, turn = jit.Float64(speeds), jit.Float64(omegas)

    def step(memory: list[Any], i: Any) -> Any:
        s, c = dr.sincos(turn * (i + 0.5) * h)
        own = [a * c - b * s for a, b in zip(re, im, strict=True)]
        past = [u, *own[1:]]
        new, wrench = sea.remember(memory, own, h)
        flow = Flow([0 * u] * 3, 0 * u, np.eye(3).tolist(), past, past, [0.0] * 6, seaway=Seaway([0.0] * 6, past, u))
        ahead = sea.load_at_speed(memory, new, flow)
        turning = coriolis_force(sea.added, past)
        return new, [jit.Float64(a + b - c + 0 * u) for a, b, c in zip(wrench, ahead, turning, strict=True)]

    memory: list[Any] = [dr.zeros(jit.Float64, len(speeds)) for _ in range(sea.memory)]
    kept = played(step, memory, steps=steps, late=late, shape=(6, len(speeds)))
    t = (np.arange(steps - late, steps) + 0.5) * h
    infinite, cut = np.array(sea.added), sea.ahead.transom
    size = np.array([1.0, 1.0, 1.0, 23.0, LENGTH, LENGTH])
    for lane, (column, speed, omega) in enumerate(zip(columns, speeds, map(float, omegas), strict=True)):
        end = Transom(-71.0, momentum_of(cut.kernels, np.array(cut.added), omega))
        forces = harmonic(kept[:, :, lane], t, omega) - infinite @ moved[:, lane] * 1j * omega
        whole = momentum_of(sea.kernels, infinite, omega)
        added, damping = at_speed(whole.real, -omega * whole.imag, omega, float(speed), end)
        expected = 1e-3 * (omega**2 * added - 1j * omega * damping)[:, column]
        assert forces / size == pytest.approx(expected / size, abs=1e-3 * np.abs(expected / size).max())


def test_a_transom_counts_ahead_only() -> None:
    """Astern the hull's other end trails, which is not given: at_speed with a transom is that without it."""
    added, damping = (m + m.T for m in RNG.uniform(1, 3, (2, 6, 6)))
    end = Transom(-2.0, RNG.normal(size=(3, 3)) + 1j)
    astern = at_speed(added, damping, 0.7, -2.0, end)
    assert np.array(astern) == pytest.approx(np.array(at_speed(added, damping, 0.7, -2.0)), abs=1e-12)
    ahead, pointed = at_speed(added, damping, 0.7, 2.0, end)[0], at_speed(added, damping, 0.7, 2.0)[0]
    assert np.abs(ahead - pointed)[1:, 1:].max() > 0.1


@pytest.mark.parametrize("speed", [0.8, 3.1])
def test_timman_and_newman(speed: float) -> None:
    """R. Timman and J. N. Newman, J. Ship Research 5:34 (1962): a hull ahead and astern, rows for columns."""
    added, damping = (m + m.T for m in RNG.uniform(1, 3, (2, 6, 6)))
    ahead, astern = np.array(at_speed(added, damping, 1.1, speed)), np.array(at_speed(added, damping, 1.1, -speed))
    assert ahead == pytest.approx(astern.swapaxes(1, 2), rel=1e-12)
    assert np.abs(ahead[0] - ahead[0].T)[2, 4] > 0.1
    assert at_speed(added, damping, 1.1, 0.0)[0] == pytest.approx(added, rel=1e-15)


def test_table_1_of_stf() -> None:
    """Salvesen, Tuck and Faltinsen 1970, Table 1 and its lateral part, for a section a + b / (i w) at x."""
    added, damping = (m + m.T for m in RNG.uniform(1, 3, (2, 6, 6)))
    w, u, x, a, b = 1.3, 2.1, -4.0, 0.7, 0.4
    end = Transom(x, np.diag([0.0, a + b / (1j * w), 0.0]))
    found, damped = at_speed(added, damping, w, u, end)
    r, s = u / w**2, u**2 / w**2
    assert found[2, 2] == pytest.approx(added[2, 2] - r * b)
    assert damped[2, 2] == pytest.approx(damping[2, 2] + u * a)
    assert found[2, 4] == pytest.approx(added[2, 4] - r * damping[2, 2] + r * x * b - s * a)
    assert damped[2, 4] == pytest.approx(damping[2, 4] + u * added[2, 2] - u * x * a - s * b)
    assert found[4, 2] == pytest.approx(added[4, 2] + r * damping[2, 2] + r * x * b)
    assert damped[4, 2] == pytest.approx(damping[4, 2] - u * added[2, 2] - u * x * a)
    assert found[4, 4] == pytest.approx(added[4, 4] + s * added[2, 2] - r * x**2 * b + s * x * a)
    assert damped[4, 4] == pytest.approx(damping[4, 4] + s * damping[2, 2] + u * x**2 * a + s * x * b)
    found, damped = at_speed(added, damping, w, u)
    assert found[1, 5] == pytest.approx(added[1, 5] + r * damping[1, 1])
    assert damped[1, 5] == pytest.approx(damping[1, 5] - u * added[1, 1])
    assert found[5, 1] == pytest.approx(added[5, 1] - r * damping[1, 1])
    assert damped[5, 1] == pytest.approx(damping[5, 1] + u * added[1, 1])
    assert found[5, 5] == pytest.approx(added[5, 5] + s * added[1, 1])
    assert damped[5, 5] == pytest.approx(damping[5, 5] + s * damping[1, 1])
    assert (found[3, 5], damped[3, 5]) == pytest.approx(
        (added[3, 5] + r * damping[3, 1], damping[3, 5] - u * added[3, 1])
    )


def test_exciting_forces_of_stf() -> None:
    """STF 1970, equations 35 to 38, the part h of sections at x, and of a transom at x_A; and their lateral kin:
    F3 = sum h3 + U/(i w) h3A, F5 = -sum (x h3 + U/(i w) h3) - U/(i w) x_A h3A, F6 = sum (x h2 + U/(i w) h2) + ...
    """
    w, u, end = 1.3, 2.1, -4.0
    x = np.array([-3.0, -1.0, 2.5])
    h2, h3 = (RNG.normal(size=3) + 1j * RNG.normal(size=3) for _ in range(2))
    a2, a3 = (complex(*RNG.normal(size=2)) for _ in range(2))
    lag = u / (1j * w)
    force = np.array([0, h2.sum(), h3.sum(), 0, -(x * h3).sum(), (x * h2).sum()])
    found = scattered_at_speed(force, force / (1j * w), u, (end, np.array([a2, a3, 0]) / (1j * w)))
    assert found[1] == pytest.approx(h2.sum() + lag * a2)
    assert found[2] == pytest.approx(h3.sum() + lag * a3)
    assert found[4] == pytest.approx(-(x * h3 + lag * h3).sum() - lag * end * a3)
    assert found[5] == pytest.approx((x * h2 + lag * h2).sum() + lag * end * a2)
    astern = scattered_at_speed(force, force / (1j * w), -u, (end, np.array([a2, a3, 0])))
    assert astern == pytest.approx(scattered_at_speed(force, force / (1j * w), -u))


@pytest.mark.parametrize(("diffraction", "headings"), [(True, [180.0, 125.0, -40.0]), (False, [180.0, 25.0])])
def test_motion_in_waves_is_the_closed_form(diffraction: bool, headings: list[float]) -> None:
    """Lanes: headings of the wave at speeds ahead and astern, where a table ends at zero and radiation too. Springs
    in surge, sway and yaw keep the hull about its course. Excitation is what the simulator itself gives a hull that is
    held at that speed, so that the response is (-w^2 (M + A(U)) + i w B(U) + C)^-1 of it, w of encounter. Steps of
    0.02 s of the first order: w h / 2, 1 %, of a response that resonance may double, against the largest of the
    hull's points; the wave is 0.4 m high, so that the wet part is that at rest: 2 %.
    """
    vehicle = ship(diffraction=diffraction)
    speeds = [-3.0, 0.0, 3.0, 7.0] if diffraction else [-3.0, 4.0, 7.0]
    angle, u = (a.ravel() for a in np.meshgrid(np.radians(headings), speeds))
    omega, high = 0.55, 0.2
    met = omega - omega**2 / G * u * np.cos(angle)
    assert np.abs(met).min() > 0.2
    ocean = sea_of(omega, high)
    held = excitation(vehicle, ocean, angle, u, np.abs(met)) / high
    moved = motion(vehicle, ocean, angle, u, np.abs(met)) / high
    sea = vehicle.model.sea
    assert sea is not None
    for lane in range(len(u)):
        w = float(abs(met[lane]))
        added, damping = radiated(sea, w, float(u[lane]))
        stiffness = sea.stiffness + np.diag(SPRINGS)
        matrix = -(w**2) * (vehicle.config.body.rigid + added) + 1j * w * (damping + np.diag(DAMPERS)) + stiffness
        expected = np.linalg.solve(matrix, held[lane])
        held_back = diffraction and u[lane] < 0  # yaw is pushed by U A(inf) times the waves' motion too: not in `held`
        arms = np.array([1.0, 1.0, 1.0, 11.0, 80.0, 0.0 if held_back else 80.0])
        assert np.abs(moved[lane] - expected) * arms == pytest.approx(
            np.zeros(6), abs=0.02 * (np.abs(expected) * arms).max()
        )
        assert np.abs(expected[4]) * 80 > 0.1


def radiated(sea: Any, w: float, u: float) -> tuple[np.ndarray, np.ndarray]:
    """Added mass and damping `(6, 6)` at w of encounter and a speed; astern of a table of scattered waves without the
    moments that momentum makes, but for that of A(inf) in yaw.
    """
    infinite = np.array(sea.added)
    whole = momentum_of(sea.kernels, infinite, w)
    if u >= 0 or sea.diffraction is None:
        return at_speed(whole.real, -w * whole.imag, w, u)
    lag = u / (1j * w)
    past = np.eye(6) + lag * SLOPE
    found = whole @ past
    found[5] += lag * (infinite @ past)[1]
    return found.real, -w * found.imag


SPRINGS = np.array([3e5, 3e5, 0.0, 0.0, 0.0, 4e9])
DAMPERS = np.array([2e6, 3e6, 0.0, 4e8, 0.0, 1.5e10])


def sea_of(omega: float, high: float) -> Any:
    """A wave towards north, deep water, still air."""
    wave = {"type": "regular", "height_m": 2 * high, "period_s": 2 * np.pi / omega, "towards_deg": 0.0}
    return build_ocean(OceanConfig.model_validate({"waves": [wave]}), seed=1)


def pose(course: Any, ahead: Any, aside: Any, yaw: Any) -> tuple[Any, Any]:
    """Position NED and attitude of a hull on a course, ahead and aside of where it began."""
    s, c = dr.sincos(course)
    half_s, half_c = dr.sincos(0.5 * (course + yaw))
    place = [c * ahead - s * aside, s * ahead + c * aside, 0 * ahead]
    return place, jit.Array4f64(half_c, 0 * ahead, 0 * ahead, half_s)


def excitation(vehicle: pl.Vehicle, ocean: Any, angle: np.ndarray, u: np.ndarray, met: np.ndarray) -> np.ndarray:
    """Amplitudes `(lanes, 6)` of exp(i w t), w met: of the load on a hull that is held on its course at its speed."""
    sea, found, n = vehicle.model.sea, [], 32
    assert sea is not None
    t = np.arange(n) / n * 2 * np.pi / met[:, None]
    time, course, ahead = (jit.from_numpy(jit.Float64, v) for v in (t, np.repeat(-angle, n), np.repeat(u, n)))
    zero = dr.zeros(jit.Float64, n * len(u))
    place, attitude = pose(course, ahead * time, zero, zero)
    seaway = vehicle.flow(Rigid(place, attitude, [ahead, *[zero] * 5]), ocean, time).seaway
    assert seaway is not None
    loads, velocities = ([x + zero for x in v] for v in (seaway.load, seaway.velocity))
    dr.eval(loads, velocities)
    for lane, (speed, w) in enumerate(zip(u.tolist(), met.tolist(), strict=True)):
        load, velocity = (
            harmonic(np.array([np.array(x)[lane * n :][:n] for x in v]).T, t[lane], w) for v in (loads, velocities)
        )
        infinite = np.array(sea.added)
        past = np.eye(6) - speed / (1j * w) * SLOPE.T
        radiated = past @ momentum_of(sea.kernels, infinite, w) - (infinite if sea.diffraction is None else 0.0)
        found.append(load - radiated @ velocity * 1j * w)
    return np.array(found)


def motion(vehicle: pl.Vehicle, ocean: Any, angle: np.ndarray, u: np.ndarray, met: np.ndarray) -> np.ndarray:
    """Amplitudes `(lanes, 6)` of exp(i w t), w met: of a free hull about its course."""
    h, steps = 0.04, 7500
    lanes = len(u)
    course, speed = jit.Float64(-angle), jit.Float64(u)
    zero = dr.zeros(jit.Float64, lanes)
    _, attitude = pose(course, zero, zero, zero)
    state = vehicle.initial_state(np.zeros((lanes, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (lanes, 1)))
    state.attitude, state.velocity = attitude, jit.Array3f64(speed, zero, zero)
    dr.make_opaque(state)

    def off(state: Any, course: Any, speed: Any, t: Any) -> list[Any]:
        s, c = dr.sincos(course)
        x, y, z = state.position
        m = so3.matrix(state.attitude)
        yaw = dr.atan2(c * m[1][0] - s * m[0][0], c * m[0][0] + s * m[1][0])
        ahead = c * x + s * y - speed * t
        return [ahead, c * y - s * x, z, dr.atan2(m[2][1], m[2][2]), -dr.asin(m[2][0]), yaw]

    def step(state: Any, i: Any) -> Any:
        t = jit.Float64(i) * h
        now = off(state, course, speed, t)
        rate = [state.velocity[0] - speed, state.velocity[1] + speed * now[5], 0.0, *state.angular_velocity]
        push = [-float(k) * x - float(d) * v for k, d, x, v in zip(SPRINGS, DAMPERS, now, rate, strict=True)]
        wrench = jit.Array3f64(*push[:3]), jit.Array3f64(*push[3:])
        new = vehicle.step(state, [], ocean, t, wrench, jit.Float64(h), "actuators", vehicle.tables)
        return new, off(new, course, speed, t + h)

    late = round(6 * 2 * np.pi / met.min() / h)
    values, t = played(step, state, steps=steps, late=late, shape=(6, lanes)), (np.arange(steps - late, steps) + 1) * h
    return np.array([harmonic(values[:, :, i], t, w) for i, w in enumerate(met)])


def momentum_of(kernels: Any, infinite: np.ndarray, omega: float) -> np.ndarray:
    """Added mass plus damping over (i omega) at a frequency of what the simulator computes: the kernels' transform."""
    found = np.array(infinite, complex)
    for k in kernels:
        p, w = np.array(k.poles), np.array(k.weights)
        pairs = w / (1j * omega - p) + w.conj() / (1j * omega - p.conj())
        found[k.row, k.column] += np.sum(0.5 * pairs) / (1j * omega)
    return found


@pytest.mark.parametrize("lengths", [10.0, 20.0, 40.0])
def test_long_waves_carry_the_hull_at_any_speed(lengths: float) -> None:
    """Waves of many hull lengths: heave their height, pitch their slope, and in beam seas sway the water's own motion,
    ahead, astern and at rest. The hull's length smooths (k L)^2 / 24 of it, and its inertia against w^2: 4 %.
    """
    vehicle, omega = ship(diffraction=True), float(np.sqrt(2 * np.pi * G / (lengths * LENGTH)))
    angle = np.radians([180.0, 180.0, 35.0, -90.0, 0.0, 180.0, 0.0])
    u = np.array([0.0, 7.0, 7.0, 7.0, 7.7, -3.0, -3.0])
    met = omega - omega**2 / G * u * np.cos(angle)
    held = excitation(vehicle, sea_of(omega, 0.2), angle, u, met) / 0.2
    sea, k = vehicle.model.sea, omega**2 / G
    assert sea is not None
    for lane, w in enumerate(met.tolist()):
        added, damping = radiated(sea, w, float(u[lane]))
        free = [2, 4] if abs(np.sin(angle[lane])) < 1e-6 else [1, 2, 3, 4, 5]
        matrix = -(w**2) * (vehicle.config.body.rigid + added) + 1j * w * damping + sea.stiffness
        found = np.linalg.solve(matrix[np.ix_(free, free)], held[lane][free])
        motion = dict(zip(free, np.abs(found), strict=True))
        assert motion[2] == pytest.approx(1.0, rel=0.04)
        assert motion[4] / k == pytest.approx(abs(np.cos(angle[lane])), rel=0.04, abs=0.02)
        if lane == 3:
            assert motion[1] == pytest.approx(1.0, rel=0.05)


def test_no_speed_is_zero_speed_to_the_byte() -> None:
    """Waves met, the table of diffraction and the terms of radiation, at a speed of exactly 0."""
    vehicle = ship(diffraction=True, transom=TRANSOM)
    sea, ocean = vehicle.model.sea, sea_of(0.55, 0.2)
    assert sea is not None
    assert sea.ahead is not None
    t, zero = jit.Float64([0.3, 1.7, 4.1]), dr.zeros(jit.Float64, 3)
    place, attitude = pose(jit.Float64([0.4, -1.9, 2.8]), zero + 3.0, zero - 2.0, zero)
    rotation = so3.matrix(attitude)
    one, other = (sea.waves(ocean, place, rotation, t, speed=s) for s in (None, zero))
    for a, b in zip(one.acceleration, other.acceleration, strict=True):
        assert np.array(a).tobytes() == np.array(b).tobytes()
    slow = {**TABLE["diffraction"], "speed_mps": (), "real": TABLE["diffraction"]["real"][0]}
    slow["imaginary"] = TABLE["diffraction"]["imaginary"][0]
    pushed = []
    for table in (TABLE["diffraction"], slow):
        scattered = compile_diffraction(DiffractionConfig.model_validate(table))
        rows = scattered.rows.on_device()
        heading = rotation[0][0], rotation[1][0]
        pushed.append(scattered.push(ocean.sea(3), rows, (place[0], -place[1]), heading, t, speed=zero))
    for a, b in zip(*pushed, strict=True):
        assert np.array(a).tobytes() == np.array(b).tobytes()
    assert np.abs(np.array(pushed[0][2])).max() > 0
    nu = [jit.Float64(RNG.normal(size=3)) for _ in range(6)]
    memory = [jit.Float64(RNG.normal(size=3)) for _ in range(sea.memory)]
    flow = Flow([zero] * 3, zero, np.eye(3).tolist(), nu, nu, [0.0] * 6, seaway=Seaway([0.0] * 6, nu, zero))
    found = [np.array(jit.Float64(x) + zero) for x in sea.load_at_speed(memory, memory, flow)]
    assert not np.any(found)


def test_the_mariner_heaves_as_its_mass_and_speed_demand() -> None:
    """Its equations of motion have no Coriolis forces: with speed terms, heave is pushed by (m + A33) U q and by what
    else moves in the hull's upright plane, which its derivatives of surge, sway and yaw leave out.
    """
    vehicle = pl.Vehicle.from_dict({"type": "mariner", "variant": "strips"})
    sea = vehicle.model.sea
    assert sea is not None
    zero = dr.zeros(jit.Float64, 1)
    nu = [jit.Float64(x) for x in (6.0, 0.0, 0.3, 0.0, 0.02, 0.0)]
    flow = Flow([zero] * 3, zero, np.eye(3).tolist(), nu, nu, [0.0] * 6, seaway=Seaway([0.0] * 6, nu, nu[0]))
    memory = [zero] * sea.memory
    found = np.array([float(jit.Float64(x)[0]) for x in sea.load_at_speed(memory, memory, flow)])
    mass, added = vehicle.config.body.rigid, np.array(sea.added)
    forward = mass[0, 0] + added[0, 0]
    assert found[2] == pytest.approx(forward * 6.0 * 0.02, rel=1e-9)
    lift = (mass + added)[2] @ [0, 0, 0.3, 0, 0.02, 0]
    surge = (mass + added)[0] @ [6.0, 0, 0, 0, 0.02, 0]
    assert found[4] == pytest.approx(6.0 * lift - 0.3 * surge, rel=1e-9)
    assert not found[[0, 1, 3, 5]].any()


@pytest.mark.parametrize("actuators", [True, False])
def test_heave_and_pitch_die_away_in_calm_water(actuators: bool) -> None:
    """Free motions of the Mariner from 0.6 m and 2 deg. In calm water the catalogue's damping acts: pitch goes on by
    itself and drives heave by z' = w - U pitch, so that at any speed all falls with exp(-D t / 2 M) or faster, 0.29 /s
    in heave and 0.39 /s in pitch: after 30 s to 2e-4 of what U times pitch has raised it to, below a metre.
    """
    vehicle = pl.Vehicle.from_dict(
        {"type": "mariner", "variant": "strips"}
        | (
            {}
            if actuators
            else {"actuators": {"rudder": None}, "modes": {"heading": None}, "default_mode": "actuators"}
        )
    )
    speeds, h = np.array([0.0, 7.7, -3.9]), 0.1
    angle = np.radians(2.0)
    state = vehicle.initial_state(
        np.tile([0.0, 0.0, 0.6], (3, 1)), np.tile([np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0], (3, 1))
    )
    zero = dr.zeros(jit.Float64, 3)
    state.velocity = jit.Array3f64(jit.Float64(speeds), zero, zero)
    dr.make_opaque(state)
    ocean = build_ocean(OceanConfig.model_validate({}), seed=1)

    def step(state: Any, i: Any) -> Any:
        still = dr.zeros(jit.Array3f64, 3), dr.zeros(jit.Array3f64, 3)
        command, t = [dr.zeros(jit.Float64, 3)] if actuators else [], jit.Float64(i) * h
        new = vehicle.step(state, command, ocean, t, still, jit.Float64(h), "actuators", vehicle.tables)
        return new, [new.position[2], dr.rad2deg(dr.asin(so3.matrix(new.attitude)[2][0]))]

    found = np.abs(played(step, state, steps=1200, late=1200, shape=(2, 3)))  # (steps, heave and pitch, lanes)
    assert (found[:10].max(axis=0) > np.array([[0.4], [1.5]])).all()
    assert (found.max(axis=0) < np.array([[1.0], [2.1]])).all()
    assert (found[300:].max(axis=0) < np.array([[1e-3], [1e-3]])).all()


def test_radiation_stands_for_damping_in_waves_only() -> None:
    """In a sea the term `radiated` is not among the wrenches, `damping` is; in calm water both are."""
    vehicle = pl.Vehicle.from_dict({"type": "mariner", "variant": "strips"})
    zero = dr.zeros(jit.Float64, 1)
    nu = [jit.Float64(x) for x in (6.0, 0.1, 0.3, 0.05, 0.02, -0.01)]
    calm = Flow([zero] * 3, zero, np.eye(3).tolist(), nu, nu, [0.0] * 6)
    waves = Flow([zero] * 3, zero, np.eye(3).tolist(), nu, nu, [0.0] * 6, seaway=Seaway([0.0] * 6, nu, nu[0]))
    found = vehicle.model.wrenches(calm, [zero])
    assert float(found["radiated"][2][0]) == pytest.approx(-2e7 * 0.3)
    assert float(found["radiated"][4][0]) == pytest.approx(-3e10 * 0.02)
    left = vehicle.model.wrenches(waves, [zero])
    assert "radiated" not in left
    assert float(left["damping"][3][0]) == pytest.approx(-1e8 * 0.05)


@pytest.mark.parametrize(
    ("afloat", "message"),
    [({"calm_damping": ["radiatd"]}, "calm_damping: 'radiatd' is none of the terms"),
     ({"radiation": None, "forward_speed": "none"}, "calm_damping needs radiation")],
)  # fmt: skip
def test_calm_damping_names_what_radiation_stands_for(afloat: dict[str, Any], message: str) -> None:
    with pytest.raises(pl.PelagosError, match=message):
        pl.Vehicle.from_dict({"type": "mariner", "variant": "strips", "afloat": afloat})


SPEEDS = {**TABLE["diffraction"], "speed_mps": [0.0, 2.0, 5.0, 7.0]}


@pytest.mark.parametrize(
    ("afloat", "message"),
    [
        ({"radiation": "mariner_strips"}, "need forward_speed: strip"),
        ({"radiation": {**TABLE, "diffraction": None, "transom": TRANSOM}}, "need forward_speed: strip"),
        ({"forward_speed": "strip"}, "needs radiation"),
        ({"forward_speed": "strip", "radiation": {**TABLE, "diffraction": SPEEDS}}, "evenly from 0"),
        ({"forward_speed": "strip", "radiation": {**TABLE, "transom": {**TRANSOM, "damping": TRANSOM["damping"][1:]}}},
         "must be 32 x 3 x 3"),
    ],
)  # fmt: skip
def test_nothing_is_accepted_and_ignored(afloat: dict[str, Any], message: str) -> None:
    hulls = [{"length_m": LENGTH, "beam_m": 23.17, "freeboard_m": 9.0}]
    with pytest.raises(ValueError, match=message):
        AfloatConfig.model_validate({"hulls": hulls, **afloat})


def test_diffraction_at_one_speed_does_not_do() -> None:
    slow = {**TABLE["diffraction"], "speed_mps": (), "real": TABLE["diffraction"]["real"][0]}
    slow["imaginary"] = TABLE["diffraction"]["imaginary"][0]
    hulls = [{"length_m": LENGTH, "beam_m": 23.17, "freeboard_m": 9.0}]
    with pytest.raises(ValueError, match="give speed_mps there"):
        AfloatConfig.model_validate(
            {"hulls": hulls, "forward_speed": "strip", "radiation": {**TABLE, "diffraction": slow}}
        )
    with pytest.raises(ValueError, match="real must have 3 tables"):
        DiffractionConfig.model_validate({**TABLE["diffraction"], "speed_mps": [0.0, 3.9, 7.8]})


def test_coriolis_forces_that_are_left_out() -> None:
    data = {"type": "mariner", "variant": "strips", "coriolis": {"rigid": "momentum", "without": [[5, 1]]}}
    with pytest.raises(pl.PelagosError, match=r"coriolis\.without"):
        pl.Vehicle.from_dict(data)
