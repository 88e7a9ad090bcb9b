"""What an estimator makes of the sensors aboard: figures of errors, and each reading with its noise, lever and turn."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.config.navigation import EkfNavigation
from pelagos.math.constants import GRAVITY
from pelagos.math.geodesy import GeoOrigin
from pelagos.navigation import measurement
from pelagos.navigation.error_state import Lanes
from pelagos.sensors.comms.lbl import LblConfig
from pelagos.sensors.comms.usbl import UsblConfig
from pelagos.sensors.navigation.depth import DepthConfig
from pelagos.sensors.navigation.gps import GpsConfig
from pelagos.sensors.navigation.imu import ImuConfig
from pelagos.sensors.navigation.magnetometer import MagnetometerConfig
from pelagos.sensors.sonar.dvl import DvlConfig
from pelagos.sim.estimator import Estimator, _inertial_noise, _slow_noise, _start_std
from pelagos.sim.state import AgentState

MARKOV = 0.664 / 0.617  # Allan deviations: of flicker noise by its bias instability, and the peak of a unit process
IMU = ImuConfig(
    rate_hz=50, position_m=(0.3, -0.2, 0.1), orientation_deg=(10, -20, 30), accelerometer_noise_density=0.011,
    accelerometer_bias_instability=0.003, accelerometer_random_walk=2e-4, accelerometer_bias_std=0.04,
    accelerometer_scale_std=0.0053, gyroscope_noise_density=0.0021, gyroscope_bias_instability=1.7e-3,
    gyroscope_random_walk=1.3e-4, gyroscope_bias_std=0.0009, gyroscope_scale_std=0.0031, misalignment_std=0.0047,
    bias_correlation_time_s=70.0,
)  # fmt: skip
PLACES: dict[str, Any] = {"position_m": (0.7, -0.4, 0.2), "orientation_deg": (20, -35, 130)}
SOFT = np.array([[1.1, 0.2, -0.1], [0.05, 0.9, 0.15], [-0.2, 0.1, 1.2]])
HARD = np.array([3e-6, -5e-6, 2e-6])
SENSORS: dict[str, Any] = {
    "imu": IMU,
    "dvl": DvlConfig(rate_hz=5, noise_mps=0.02, beam_azimuth_deg=(40.0, 130.0, -140.0, -45.0), **PLACES),
    "gps": GpsConfig(rate_hz=4, noise_density=0.3, horizontal_std_m=1.3, vertical_std_m=2.9, correlation_time_s=210.0,
                     **PLACES),
    "second": GpsConfig(rate_hz=1, noise_density=0.7, horizontal_std_m=9.0, correlation_time_s=30.0),
    "depth": DepthConfig(rate_hz=10, noise_density=0.04, resolution_m=0.3, bias_std_m=0.3, drift_m=0.4, **PLACES),
    "compass": MagnetometerConfig(rate_hz=10, noise_density=2e-7, resolution_t=1.5e-6, bias_std_t=6e-7,
                                  soft_iron=tuple(SOFT.ravel()), hard_iron_t=tuple(HARD), **PLACES),
    "asks": LblConfig(turnaround_error_s=4e-4, transponders={
        "a": {"position_m": (31.0, -22.0, -17.0)}, "other": {"position_m": (1.0, 2.0, 3.0), "agent": "b"},
        "c": {"position_m": (-40.0, 9.0, -12.0)}}, **PLACES),
    "listens": LblConfig(one_way=True, turnaround_error_s=4e-4, transponders={"a": {"position_m": (3.0, -2.0, -17.0)}},
                         **PLACES),
    "usbl": UsblConfig(**PLACES),
}  # fmt: skip
KEYS = EkfNavigation(
    start_position_std_m=0.7, start_velocity_std_mps=0.3, start_level_std_deg=0.4, start_heading_std_deg=3.0,
    surface_std_m=0.06, range_std_m=0.35, bearing_std_deg=2.5, gate=13.0,
    beacons={"dock": (45.0, -30.0, -14.0), "buoy.usbl": (-20.0, 15.0, -2.0)},
)  # fmt: skip
LEVER = np.array([0.4, -0.2, 0.1])
"""From the inertial unit to the others."""
TURN = Rotation.from_euler("ZYX", [130, -35, 20], degrees=True).as_matrix()


@pytest.fixture
def aboard() -> Estimator:
    """Of two copies; its filter has nothing zero, and nothing equal."""

    def modem(kind: str) -> Any:
        return SimpleNamespace(config=SimpleNamespace(type=kind))

    def models(sensors: dict[str, Any]) -> dict[str, Any]:
        return {name: SimpleNamespace(config=c, period=2 if name == "imu" else 20) for name, c in sensors.items()}

    own: Any = SimpleNamespace(name="a", sensors=models(SENSORS))
    others = [SimpleNamespace(name="dock", sensors={"depth": modem("depth"), "modem": modem("modem")}),
              SimpleNamespace(name="buoy", sensors={"modem": modem("modem"), "usbl": modem("usbl")})]  # fmt: skip
    model: Any = SimpleNamespace(
        n=2, seed=3, first_environment=1, clock=SimpleNamespace(dt_ns=10_000_000), agents={a.name: a for a in others},
        world=SimpleNamespace(origin=GeoOrigin(44.3, 9.2)),
        scenario=SimpleNamespace(where=lambda *path: ".".join(path)),
    )  # fmt: skip
    rng = np.random.default_rng(4)
    attitude = rng.normal(size=(2, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    v = rng.normal(size=(6, 2, 3))
    state = AgentState(v[0], attitude, v[1], v[2], v[3], v[4], np.empty((2, 0)))
    made = Estimator(KEYS, own, model, state)
    made.lanes.rate, made.lanes.slow = v[5], rng.normal(size=(2, 7)) * [1, 1, 1, 0.1, 1e-6, 1e-6, 1e-6]
    return made


def heard(name: str, data: Any, **more: Any) -> Any:
    """Readings at two ticks, of which the second is to be fused: its lanes are the last two."""
    data = np.array(data, dtype=float)
    return {"name": name, "ticks": [20, 40], "data": np.concatenate([9 + data, data]), "valid": np.ones(4, bool),
            "extra": None} | {k: np.concatenate([np.full_like(v, 7), v]) for k, v in more.items()}  # fmt: skip


@pytest.fixture
def fused(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    found: list[Any] = []
    monkeypatch.setattr(Lanes, "update", lambda self, *given: found.append((*given, len(self.position))))
    return found


def compare(told: Any, expected: Any, noise: Any, valid: Any) -> None:
    for one, other in zip(told[:2], expected, strict=True):
        use = np.array(valid)
        np.testing.assert_allclose(one[use], other[use], rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(told[2], np.broadcast_to(noise, told[2].shape), rtol=1e-9, atol=1e-20)
    assert told[3].tolist() == list(valid)
    assert told[4] == 13.0


def test_figures_of_an_inertial_unit() -> None:
    """A Gauss-Markov process of deviation s and correlation time T wanders, at first, as a walk of s sqrt(2 / T)."""
    made = _inertial_noise(IMU)
    assert (made.force, made.rate) == (0.011, 0.0021)
    force, rate = MARKOV * 0.003 * math.sqrt(2 / 70), MARKOV * 1.7e-3 * math.sqrt(2 / 70)
    assert made.force_walk == pytest.approx(math.hypot(2e-4, force), rel=1e-3)
    assert made.rate_walk == pytest.approx(math.hypot(1.3e-4, rate), rel=1e-3)
    assert (made.force_scale, made.force_alignment, made.scale, made.alignment) == (0.0053, 0.0047, 0.0031, 0.0047)


def test_slow_errors_are_those_of_the_first_of_a_kind() -> None:
    made = _slow_noise(SENSORS)
    assert made.std == pytest.approx((1.3, 1.3, 2.9, 0.5, 6e-7, 6e-7, 6e-7))
    assert made.time_s[:3] == (210.0,) * 3
    assert min(made.time_s[3:]) >= 1e8
    assert _slow_noise({"imu": IMU}).std == (0.0,) * 7


def test_errors_at_the_start() -> None:
    """Level, gravity is taken wrong by misalignment on both axes across it, and by the scale along it."""
    slow = _slow_noise(SENSORS)
    std = _start_std(KEYS, IMU, slow)
    assert std[:9] == pytest.approx([0.7] * 3 + [0.3] * 3 + [math.radians(0.4)] * 2 + [math.radians(3.0)])
    assert std[9:12] == pytest.approx([math.hypot(0.0009, MARKOV * 1.7e-3)] * 3, rel=1e-3)
    wander = math.hypot(0.04, MARKOV * 0.003)
    across, along = math.hypot(wander, 0.0047 * GRAVITY), math.hypot(wander, 0.0053 * GRAVITY)
    assert std[12:15] == pytest.approx([across, across, along], rel=1e-4)
    assert std[15:].tolist() == list(slow.std)


def test_the_filter_begins_at_the_unit_with_errors_of_its_own(aboard: Estimator) -> None:
    """Position and velocity of the unit; from many copies' draws, their deviations."""
    rng = np.random.default_rng(8)
    n = 4000
    aboard._n = n
    turn = Rotation.random(n, random_state=2)
    x, y, z, w = turn.as_quat().T
    place, velocity, spin = rng.normal(size=(3, n, 3))
    state = AgentState(place, np.stack([w, x, y, z], axis=1), velocity, spin, spin, spin, np.empty((n, 0)))
    model: Any = SimpleNamespace(seed=5, first_environment=2)
    std = np.arange(1.0, 23.0) / 20
    lanes = aboard._start(state, std, model, "a")
    lever = np.array(IMU.position_m)
    found = Rotation.from_quat(lanes.attitude[:, [1, 2, 3, 0]])
    errors = np.concatenate([place + turn.apply(lever) - lanes.position,
                             turn.apply(velocity + np.cross(spin, lever)) - lanes.velocity,
                             (found.inv() * turn).as_rotvec()], axis=1)  # fmt: skip
    np.testing.assert_allclose(errors.std(axis=0), std[:9], rtol=5 / math.sqrt(2 * n))
    assert np.abs(np.corrcoef(errors.T) - np.eye(9)).max() < 5 / math.sqrt(n)
    one = aboard._start(state, std, SimpleNamespace(seed=5, first_environment=3), "a")  # type: ignore[arg-type]
    np.testing.assert_allclose(
        (place + turn.apply(lever) - one.position)[:-1], errors[1:, :3], atol=1e-9
    )  # a copy's draw goes by its index in the world
    other = aboard._start(state, std, model, "b")  # nothing in common: a difference has 1 / sqrt(2) of each
    assert (
        np.abs(np.corrcoef((other.position - lanes.position).T, errors[:, :3].T)[:3, 3:].diagonal() - 0.7).max() < 0.1
    )


def test_a_bottom_velocity_is_as_sure_as_its_beams(aboard: Estimator, fused: list[Any]) -> None:
    """Of a velocity of least squares (B^T B)^-1 B^T S B (B^T B)^-1; a beam that says nothing counts ten times."""
    c = SENSORS["dvl"]
    sigma = np.array([[0.01, 0.03, 0.02, 0.05], [0.04, np.nan, 0.01, 0.02]])
    data = [[0.4, -0.3, 0.1], [-0.2, 0.6, 0.3]]
    aboard._fuse(heard("dvl", data, extra=sigma), 1)
    back = np.linalg.inv(c.beams.T @ c.beams) @ c.beams.T
    used = np.where(np.isfinite(sigma), sigma, 0.2)
    noise = [back @ np.diag(s**2) @ back.T + 1e-8 * np.eye(3) for s in used]
    compare(fused[0], measurement.bottom_velocity(aboard.lanes, np.array(data), LEVER, TURN), noise, [True, True])


def test_readings_that_are_invalid_or_no_numbers_are_left_out(aboard: Estimator, fused: list[Any]) -> None:
    one = heard("dvl", [[0.4, -0.3, 0.1], [-0.2, np.nan, 0.3]], extra=np.full((2, 4), 0.1))
    aboard._fuse(one, 1)
    one["valid"][:] = [True, True, False, True]
    aboard._fuse(one, 1)
    aboard._fuse(one, 0)
    assert [told[3].tolist() for told in fused] == [[True, False], [False, False], [True, False]]


def test_satellites_are_less_sure_of_heights(aboard: Estimator, fused: list[Any]) -> None:
    data = [[5.0, -7.0, 2.0], [-3.0, 11.0, 1.0]]
    aboard._fuse(heard("gps", data), 1)
    noise = np.diag([0.36, 0.36, 0.81]) + 1e-6 * np.eye(3)  # 0.3 m/sqrt(Hz) at 4 Hz, half as much again upwards
    compare(fused[0], measurement.satellite_position(aboard.lanes, np.array(data), LEVER), noise, [True, True])


def test_a_gauge_counts_in_steps_below_waves(aboard: Estimator, fused: list[Any]) -> None:
    aboard._fuse(heard("depth", [[4.0], [7.0]]), 1)
    noise = 0.04**2 * 10 + 0.3**2 / 12 + 0.06**2
    compare(fused[0], measurement.depth(aboard.lanes, np.array([4.0, 7.0]), LEVER), noise, [True, True])


def test_the_vehicles_own_iron_is_taken_off(aboard: Estimator, fused: list[Any]) -> None:
    field = np.array([[22e-6, -4e-6, -40e-6], [-11e-6, 19e-6, -33e-6]])
    aboard._fuse(heard("compass", field @ SOFT.T + HARD), 1)
    earth = aboard._fields["compass"]
    assert np.linalg.norm(earth) == pytest.approx(47e-6, rel=0.05)
    white = 4e-14 * 10 + 2.25e-12 / 12 + measurement.curvature(aboard.lanes, earth)
    expected = measurement.magnetic_field(aboard.lanes, field, earth, TURN)
    compare(fused[0], expected, white[:, None, None] * np.eye(3), [True, True])


@pytest.mark.parametrize(("name", "ways"), [("asks", 2.0), ("listens", 1.0)])
def test_ranges_to_fixed_transponders(aboard: Estimator, fused: list[Any], name: str, ways: float) -> None:
    """An error of time is one of range, half of it where sound goes both ways; those on vehicles do not count."""
    data = np.array([[61.0, 5.0, np.nan], [47.0, np.nan, 39.0]])[:, : 3 if name == "asks" else 1]
    aboard._fuse(heard(name, data), 1)
    noise = (4e-4 * 1500 / ways) ** 2 + 0.35**2
    fixed = [(j, t) for j, t in enumerate(SENSORS[name].transponders.values()) if t.agent is None]
    assert len(fused) == len(fixed)
    for told, (j, transponder) in zip(fused, fixed, strict=True):
        valid = np.isfinite(data[:, j])
        expected = measurement.beacon_range(
            aboard.lanes, np.where(valid, data[:, j], 0.0), LEVER, np.array(transponder.position_m)
        )
        compare(told, expected, noise, valid)


@pytest.mark.parametrize("which", [(0, 1), (1, 0), (1, -1), (-1, -1)])
def test_places_of_beacons(aboard: Estimator, fused: list[Any], which: tuple[int, int]) -> None:
    """Sure along the sight by the range, across it by the bearing and what the vehicle turned since; all by its way."""
    lanes, data = aboard.lanes, np.array([[30.0, -12.0, 5.0], [-8.0, 25.0, -14.0]])
    age = np.array([0.3, 0.7])
    aboard._fuse(heard("usbl", data, extra=np.stack([which, age], axis=1).astype(float)), 1)
    places = np.array(list(KEYS.beacons.values()))[np.maximum(which, 0)]
    valid = np.array(which) >= 0
    if not valid.any():
        assert not fused
        return
    (told,) = fused
    for one, other in zip(told[:2], measurement.beacon_place(lanes, data, LEVER, TURN, places, age), strict=True):
        np.testing.assert_allclose(one[valid], other[valid], rtol=1e-9, atol=1e-12)
    assert told[3].tolist() == valid.tolist()
    for lane in np.flatnonzero(valid):
        far = np.linalg.norm(data[lane])
        along = data[lane] / far
        aside = np.cross(along, [0.0, 0.0, 1.0])
        aside /= np.linalg.norm(aside)
        gone = (0.3 * age[lane] * np.linalg.norm(lanes.velocity[lane])) ** 2
        turned = np.linalg.norm(lanes.rate[lane]) * age[lane]
        wide = far**2 * (math.radians(2.5) ** 2 + turned**2)
        np.testing.assert_allclose(told[2][lane] @ along, (0.35**2 + gone) * along, rtol=1e-9, atol=1e-12)
        for across in (aside, np.cross(along, aside)):
            np.testing.assert_allclose(told[2][lane] @ across, (wide + gone) * across, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("who", [0, 1])
def test_of_several_agents_only_those_that_heard_an_answer_fuse_it(
    aboard: Estimator, monkeypatch: pytest.MonkeyPatch, who: int
) -> None:
    """The filter of the other one stays, to the byte; that of the first is moved."""
    seen: list[Any] = []

    def update(lanes: Lanes, h: Any, innovation: Any, *rest: Any) -> None:
        seen.append((h, innovation, rest[1].tolist()))
        lanes.position = lanes.position + 1.0

    monkeypatch.setattr(Lanes, "update", update)
    aboard.lanes = Lanes.joined([aboard.lanes, aboard.lanes.take(np.array([1, 0]))])
    aboard._members, aboard._n = 2, 4
    own, before = aboard.lanes.take(slice(2 * who, 2 * who + 2)), aboard.lanes.position.copy()
    which = np.where(np.arange(4) == 2 * who + 1, 1.0, -1.0)  # in the second copy
    data, age = np.random.default_rng(7).normal(0, 20, (4, 3)), np.array([0.3, 0.7, 0.2, 0.5])
    aboard._fuse(heard("usbl", data, extra=np.stack([which, age], axis=1)), 1)
    np.testing.assert_array_equal(aboard.lanes.position, before + (np.arange(4) // 2 == who)[:, None])
    places, mine = np.array([KEYS.beacons["buoy.usbl"]] * 2), slice(2 * who, 2 * who + 2)
    expected = measurement.beacon_place(own, data[mine], LEVER, TURN, places, age[mine])
    for found, wanted in zip(seen[0][:2], expected, strict=True):
        np.testing.assert_allclose(found[1], wanted[1], rtol=1e-9, atol=1e-12)
    assert seen[0][2] == [False, True]


def test_answers_of_known_beacons(aboard: Estimator) -> None:
    """The last known one of each copy at each tick: who, and how long ago it was sent."""

    def packet(sender: str, sent_s: float, kind: str = "response", far: float = 9.0) -> Any:
        return SimpleNamespace(sender=sender, sent_ns=round(sent_s * 1e9), kind=kind, range_m=far)

    packets: list[list[Any]] = [
        [packet("dock.modem", 0.05), packet("buoy.usbl", 0.08)],
        [packet("dock.modem", 0.12), packet("buoy.modem", 0.15), packet("buoy.usbl", 0.16, kind="data")],
        [],
        [packet("dock.modem", 0.31), packet("buoy.usbl", 0.33, far=math.inf)],
    ]
    sampled: Any = SimpleNamespace(
        ticks=range(20, 60, 20), measurement=SimpleNamespace(data=np.zeros((4, 3)), extras={"packets": packets})
    )
    np.testing.assert_allclose(aboard._answers(sampled), [[1, 0.12], [0, 0.08], [-1, 0.0], [0, 0.09]], atol=1e-12)


def test_samples_are_integrated_up_to_a_reading_and_turned_into_the_body(
    aboard: Estimator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """50 Hz at ticks of 10 ms: at most 0.05 s at a time; the sample of the start ends no interval."""
    gone: list[Any] = []
    monkeypatch.setattr(
        Lanes, "predict", lambda self, force, rate, h, noise, slow, samples: gone.append((force, rate, h, samples))
    )
    monkeypatch.setattr(Lanes, "update", lambda self, *given: gone.append("fused"))
    raw = np.random.default_rng(5).normal(size=(12, 2, 6))
    for first in (0, 6):  # in two parts
        part = raw[first : first + 6]
        aboard._heard.append({"name": "imu", "ticks": list(range(2 * first, 2 * first + 12, 2)),
                              "data": part.reshape(12, 6), "valid": np.ones(12, bool), "extra": None})  # fmt: skip
    aboard._heard.append(heard("gps", [[5.0, -7.0, 2.0], [-3.0, 11.0, 1.0]]) | {"ticks": [11, 12]})
    aboard._heard.append(heard("depth", [[4.0], [5.0]]) | {"ticks": [3, 8]})
    aboard.advance(14)
    body = Rotation.from_euler("ZYX", [30, -20, 10], degrees=True)
    turned = np.stack([body.apply(part.reshape(-1, 3)).reshape(12, 2, 3) for part in np.split(raw, 2, axis=2)])
    taken, at = [], 0
    for one in gone:
        if one == "fused":
            taken.append(at)
            continue
        force, rate, h, samples = one
        mine = slice(at, at + samples + (at == 0))
        np.testing.assert_allclose([force, rate], turned[:, mine].mean(axis=1), rtol=1e-9)
        assert h == pytest.approx(0.02 * samples)
        assert h <= 0.05
        at = mine.stop
    assert at == 8  # samples of ticks 0 to 14
    assert taken == [5, 6, 7]  # of a gauge the newest alone, after the samples of ticks 0 to 8; of satellites each
    assert len(aboard._samples) == 4
    assert aboard._first == 16


def test_a_reading_that_is_read_again_counts_once(aboard: Estimator) -> None:
    def sampled(name: str, ticks: range) -> Any:
        count = 2 * len(ticks)
        m = SimpleNamespace(data=np.zeros((count, 1)), valid=None, extras={"position": np.ones((count, 3))})
        return SimpleNamespace(model=SimpleNamespace(name=name), ticks=ticks, measurement=m)

    for name, ticks in (("depth", range(10, 40, 10)), ("depth", range(20, 40, 10)), ("gps", range(10, 20, 10)),
                        ("depth", range(40, 50, 10)), ("gps", range(10, 20, 10))):  # fmt: skip
        aboard.hear(sampled(name, ticks))
    assert [(one["name"], one["ticks"]) for one in aboard._heard] == [
        ("depth", [10, 20, 30]), ("gps", [10]), ("depth", [40])
    ]  # fmt: skip
    assert aboard._heard[1]["data"].tolist() == [[1.0] * 3] * 2  # of satellites the place


def test_the_solution_is_that_of_the_vehicles_origin(aboard: Estimator) -> None:
    lanes, lever = aboard.lanes, np.array(IMU.position_m)
    turn = Rotation.from_quat(lanes.attitude[:, [1, 2, 3, 0]])
    position, attitude, velocity = aboard.motion
    np.testing.assert_allclose(position, lanes.position - turn.apply(lever), atol=1e-12)
    np.testing.assert_allclose(velocity, lanes.velocity - turn.apply(np.cross(lanes.rate, lever)), atol=1e-12)
    assert attitude is lanes.attitude
    assert aboard.rate is lanes.rate
    x, y = turn.apply([1.0, 0.0, 0.0])[:, :2].T
    np.testing.assert_allclose(aboard.fix.heading, np.arctan2(-y, x), atol=1e-12)
    np.testing.assert_array_equal(aboard.fix.position, position)
    np.testing.assert_array_equal(aboard.fix.velocity, velocity)
