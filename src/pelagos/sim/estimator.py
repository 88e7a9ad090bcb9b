"""Navigation by an estimator: readings of the sensors aboard into an error-state filter, between two calls of guidance.

Between readings, the inertial unit's samples are averaged; a reading is fused at the last of these samples at or before
it. Of gauges that read faster than guidance asks, the newest reading is fused.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Hashable, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.config.navigation import EkfNavigation
from pelagos.errors import LookupFailed, ScenarioError
from pelagos.math.constants import GRAVITY
from pelagos.math.rotation import Floats, apply, from_vector, product
from pelagos.math.so3 import cross_np, matrix_np
from pelagos.navigation import measurement
from pelagos.navigation.error_state import ATTITUDE, InertialNoise, Lanes, SlowNoise
from pelagos.sensors.navigation.magnetometer import earth_field_of
from pelagos.sim.guidance.aboard import Fix
from pelagos.sim.heard import Heard, heard_of, part_of, side_by_side
from pelagos.sim.model import AgentModel, Model
from pelagos.sim.navigator import renewed
from pelagos.sim.sampled import Sampled
from pelagos.sim.state import AgentState

STEP_S: Final = 0.05  # the filter goes on by at most this
AIDS: Final = ("dvl", "gps", "depth", "magnetometer", "lbl", "usbl")
EACH: Final = ("dvl", "gps", "lbl", "usbl")  # whose readings are all fused; of gauges the newest
AGE_SHARE: Final = 0.3  # of the way since a beacon's answer, by which the request's part of the round trip differs
SOUND_MPS: Final = 1500.0  # by which an error of time is one of range
MARKOV_SHARE: Final = 1.0757  # standard deviation of a Gauss-Markov process by bias instability (sensors/noise.py)
CONSTANT_S: Final = 1e9  # correlation time of an error that does not change [s]


class Estimator:
    """A navigator (see `navigator.Navigator`) for every copy of one agent.

    Attributes:
        listens: names of the sensors that it takes.
        lanes: the filter.
    """

    def __init__(self, config: EkfNavigation, agent: AgentModel, model: Model, state: AgentState) -> None:
        sensors: dict[str, Any] = {name: m.config for name, m in agent.sensors.items()}
        inertial = next((name for name, c in sensors.items() if c.type == "imu"), None)
        if inertial is None:
            where = model.scenario.where("agents", agent.name, "navigation")
            raise ScenarioError(
                f"navigation by an estimator needs an imu, which {agent.name} does not carry", where=where
            )
        self._config, self._sensors, self._inertial = config, sensors, inertial
        self.listens = frozenset(name for name, c in sensors.items() if c.type in AIDS) | {inertial}
        self._members = 1
        self._n, self._dt_s, self._period = model.n, model.clock.dt_ns * 1e-9, agent.sensors[inertial].period
        imu = sensors[inertial]
        self._lever, self._turn = np.array(imu.position_m), _turn(imu)
        self._noise, self._slow = _inertial_noise(imu), _slow_noise(sensors)
        fields = {name: c for name, c in sensors.items() if c.type == "magnetometer"}
        self._fields = {name: earth_field_of(c, model.world.origin) for name, c in fields.items()}
        self._beacons = _beacons(config, agent, model)
        self._heard: list[Heard] = []
        self._latest: dict[str, int] = {}
        self._samples = np.zeros((0, self._n, 6))
        self._first = 0
        std = _start_std(config, imu, self._slow)
        self.lanes = self._start(state, std, model, agent.name)

    def _start(self, state: AgentState, std: Floats, model: Model, name: str) -> Lanes:
        """The known start: the true one with errors of its standard deviations, drawn by seed, copy and agent."""
        lanes = Lanes.at(state.position, np.zeros((self._n, 3)), state.attitude, std)
        r = matrix_np(state.attitude)
        lanes.position = state.position + apply(r, np.broadcast_to(self._lever, (self._n, 3)))
        turning = cross_np(state.angular_velocity, np.broadcast_to(self._lever, (self._n, 3)))
        lanes.velocity = apply(r, state.velocity + turning)
        path = [model.seed, *name.encode()]
        draws = np.stack([
            np.random.Generator(np.random.Philox(np.random.SeedSequence([*path, model.first_environment + i])))
            .standard_normal(9) for i in range(self._n)
        ])  # fmt: skip
        lanes.position = lanes.position - std[0:3] * draws[:, 0:3]
        lanes.velocity = lanes.velocity - std[3:6] * draws[:, 3:6]
        lanes.attitude = product(lanes.attitude, from_vector(-std[ATTITUDE] * draws[:, 6:9]))
        return lanes

    # see `Navigator`

    @property
    def fix(self) -> Fix:
        """The newest solution, of the vehicle's origin."""
        position, _, velocity = self.motion
        x, y = matrix_np(self.lanes.attitude)[:, :2, 0].T
        return Fix(position, -np.arctan2(y, x), velocity)

    @property
    def motion(self) -> tuple[Floats, Floats, Floats]:
        """Position `(n, 3)` NWU [m], attitude `(n, 4)`, velocity `(n, 3)` NWU [m/s] of the vehicle's origin."""
        r = matrix_np(self.lanes.attitude)
        arm = np.broadcast_to(self._lever, (self._n, 3))
        turning = apply(r, cross_np(self.lanes.rate, arm))
        return self.lanes.position - apply(r, arm), self.lanes.attitude, self.lanes.velocity - turning

    @property
    def rate(self) -> Floats:
        """Angular velocity `(n, 3)` body FLU [rad/s]."""
        return self.lanes.rate

    def hear(self, sampled: Sampled) -> None:
        """Keep readings until guidance asks; those of a tick that is read again count once."""
        name, last = sampled.model.name, sampled.ticks[-1]
        if last <= self._latest.get(name, -1):
            return
        self._latest[name] = last
        heard = heard_of(sampled, self._sensors[name].type)
        if self._sensors[name].type == "usbl":
            heard["extra"] = self._answers(sampled)
        self._heard.append(heard)

    def advance(self, tick: int) -> None:
        """Go on to a tick with everything that was heard."""
        events: list[tuple[int, Heard, int]] = []
        for one in self._heard:
            if one["name"] == self._inertial:
                self._keep(one)
            else:
                events += self._due(one)
        self._heard.clear()
        for at, one, k in sorted(events, key=lambda e: e[0]):
            self._predict(at)
            self._fuse(one, k)
        self._predict(tick)

    def memory(self) -> dict[str, Any]:
        """See `Navigator.memory`."""
        kept = {"samples": self._samples, "first": self._first, "heard": self._heard, "latest": self._latest}
        return copy.deepcopy({"lanes": vars(self.lanes), **kept})

    def recall(self, memory: Mapping[str, Any]) -> None:
        """See `Navigator.recall`."""
        kept = copy.deepcopy(dict(memory))
        self.lanes = Lanes(**kept["lanes"])
        self._samples, self._first = kept["samples"], kept["first"]
        self._heard, self._latest = kept["heard"], kept["latest"]

    def renewed(self, before: Mapping[str, Any], fresh: Mapping[str, Any], where: NDArray[np.bool_]) -> dict[str, Any]:
        """See `Navigator.renewed`."""
        return {**before, "lanes": renewed(before["lanes"], fresh["lanes"], where)}

    # many agents, see `crew.Crew`

    @property
    def kind(self) -> Hashable:
        """Equal for estimators of one batch that may go on together: same configuration, and same readings heard."""
        heard = tuple((one["name"], tuple(one["ticks"])) for one in self._heard)
        return self._config.model_dump_json(), self._first, len(self._samples), tuple(self._latest.items()), heard

    @staticmethod
    def joined(parts: Sequence[Estimator]) -> Estimator:
        """One for the lanes of all, which are of one kind."""
        whole = copy.copy(parts[0])
        whole._members, whole._n = len(parts), sum(part._n for part in parts)
        whole.lanes = Lanes.joined([part.lanes for part in parts])
        whole._samples = np.concatenate([part._samples for part in parts], axis=1)
        whole._heard = [side_by_side(same) for same in zip(*(part._heard for part in parts), strict=True)]
        whole._latest = dict(parts[0]._latest)
        return whole

    def part(self, parts: Sequence[Estimator]) -> None:
        """Give the estimators that were joined their lanes."""
        for i, part in enumerate(parts):
            own = slice(i * part._n, (i + 1) * part._n)
            part.lanes = self.lanes.take(own)
            part._samples, part._first = self._samples[:, own].copy(), self._first
            part._heard = [part_of(one, own) for one in self._heard]
            part._latest = dict(self._latest)

    # between two calls

    def _answers(self, sampled: Sampled) -> Floats:
        """`(lanes, 2)`: number of the beacon that answered last, -1 for none that is known; age of its answer [s]."""
        found = np.full((len(sampled.measurement.data), 2), [-1.0, 0.0])
        names = list(self._beacons)
        for lane, packets in enumerate(sampled.measurement.extras["packets"]):
            now_s = sampled.ticks[lane // self._n] * self._dt_s
            for packet in packets:
                if packet.kind == "response" and math.isfinite(packet.range_m) and packet.sender in names:
                    found[lane] = names.index(packet.sender), now_s - 1e-9 * packet.sent_ns
        return found

    def _keep(self, one: Heard) -> None:
        """Samples of the inertial unit, in body axes."""
        values = one["data"].reshape(len(one["ticks"]), self._n, 2, 3)
        body = (values @ self._turn.T).reshape(len(values), self._n, 6)
        if not len(self._samples):
            self._first = one["ticks"][0]
        self._samples = np.concatenate([self._samples, body])

    def _due(self, one: Heard) -> list[tuple[int, Heard, int]]:
        """The readings to fuse: each of a DVL and of satellites, of gauges the newest."""
        slow = self._sensors[one["name"]].type in EACH
        last = len(one["ticks"]) - 1
        return [(one["ticks"][k], one, k) for k in (range(last + 1) if slow else [last])]

    def _predict(self, tick: int) -> None:
        """Integrate the samples up to a tick, at most `STEP_S` at a time."""
        h = self._period * self._dt_s
        most = max(1, round(STEP_S / h))
        while len(self._samples) and self._first <= tick:
            ready = min((tick - self._first) // self._period + 1, len(self._samples), most)
            mean = self._samples[:ready].mean(axis=0)
            count = ready - (self._first == 0)  # the sample at the start ends no interval
            if count > 0:
                force, rate = mean[:, :3], mean[:, 3:]
                self.lanes.predict(force, rate, count * h, self._noise, self._slow, samples=count)
            self._samples = self._samples[ready:]
            self._first += ready * self._period

    def _fuse(self, one: Heard, k: int) -> None:
        """One reading, with the noise that its sensor states."""
        c, row = self._sensors[one["name"]], slice(k * self._n, (k + 1) * self._n)
        if c.type in ("lbl", "usbl"):
            fuse = self._fuse_ranges if c.type == "lbl" else self._fuse_place
            fuse(one, c, row)
            return
        data = one["data"][row]
        valid = np.isfinite(data).all(axis=1) & one["valid"][row]
        data = np.where(valid[:, None], data, 0.0)
        lever, turn = np.array(c.position_m) - self._lever, _turn(c)
        if c.type == "dvl":
            found = measurement.bottom_velocity(self.lanes, data, lever, turn)
            noise = _dvl_noise(c, one["extra"][row])
        elif c.type == "gps":
            found = measurement.satellite_position(self.lanes, data, lever)
            white = c.noise_density * math.sqrt(c.rate_hz)
            noise = np.tile(np.diag([white**2, white**2, (1.5 * white) ** 2]) + 1e-6 * np.eye(3), (self._n, 1, 1))
        elif c.type == "depth":
            found = measurement.depth(self.lanes, data[:, 0], lever)
            white = c.noise_density**2 * c.rate_hz + c.resolution_m**2 / 12 + self._config.surface_std_m**2
            noise = np.full((self._n, 1, 1), white)
        else:
            own = apply(np.linalg.inv(np.reshape(c.soft_iron, (3, 3))), data - np.array(c.hard_iron_t))
            found = measurement.magnetic_field(self.lanes, own, self._fields[one["name"]], turn)
            white = c.noise_density**2 * c.rate_hz + c.resolution_t**2 / 12
            bent = measurement.curvature(self.lanes, self._fields[one["name"]])
            noise = (max(white, 1e-18) + bent)[:, None, None] * np.eye(3)
        self.lanes.update(*found, noise, valid, self._config.gate)

    def _fuse_ranges(self, one: Heard, c: Any, row: slice) -> None:
        """Ranges to transponders, one after the other."""
        lever, ways = np.array(c.position_m) - self._lever, 1.0 if c.one_way else 2.0
        std = math.hypot(c.turnaround_error_s * SOUND_MPS / ways, self._config.range_std_m)
        for j, transponder in enumerate(c.transponders.values()):
            if transponder.agent is not None:
                continue  # the filter knows places of the world, not those of other vehicles
            measured = one["data"][row, j]
            valid = np.isfinite(measured)
            ranges, place = np.where(valid, measured, 0.0), np.array(transponder.position_m)
            found = measurement.beacon_range(self.lanes, ranges, lever, place)
            self.lanes.update(*found, np.full((self._n, 1, 1), std**2), valid, self._config.gate)

    def _fuse_place(self, one: Heard, c: Any, row: slice) -> None:
        """Place of a beacon in the sensor's frame: range and bearing, and the way gone since the request."""
        which, age, data = one["extra"][row, 0].astype(int), one["extra"][row, 1], one["data"][row]
        valid = np.isfinite(data).all(axis=1) & (which >= 0)
        answered = valid.reshape(self._members, -1).any(axis=1)
        if answered.all():
            self._fuse_answers(self.lanes, c, data, which, age, valid)
        elif answered.any():  # whoever has no answer goes on as it would alone, to the byte
            own = np.flatnonzero(np.repeat(answered, self._n // self._members))
            lanes = self.lanes.take(own)
            self._fuse_answers(lanes, c, data[own], which[own], age[own], valid[own])
            self.lanes.put(own, lanes)

    def _fuse_answers(
        self, lanes: Lanes, c: Any, data: Floats, which: NDArray[np.int64], age: Floats, valid: NDArray[np.bool_]
    ) -> None:
        data = np.where(valid[:, None], data, 1.0)
        places = np.array(list(self._beacons.values()))[np.maximum(which, 0)]
        lever, turn = np.array(c.position_m) - self._lever, _turn(c)
        found = measurement.beacon_place(lanes, data, lever, turn, places, age)
        away = np.sqrt((data**2).sum(axis=1))
        along = data[:, :, None] * data[:, None, :] / away[:, None, None] ** 2
        turned = np.sqrt((lanes.rate**2).sum(axis=1)) * age
        across = (math.radians(self._config.bearing_std_deg) ** 2 + turned**2) * away**2
        gone = (AGE_SHARE * age) ** 2 * (lanes.velocity**2).sum(axis=1)
        noise = self._config.range_std_m**2 * along + across[:, None, None] * (np.eye(3) - along)
        noise = noise + gone[:, None, None] * np.eye(3)
        lanes.update(*found, noise, valid, self._config.gate)


def _beacons(config: EkfNavigation, agent: AgentModel, model: Model) -> dict[str, tuple[float, float, float]]:
    """Known places by "agent.modem"."""
    where = model.scenario.where("agents", agent.name, "navigation", "beacons")
    if config.beacons and all(m.config.type != "usbl" for m in agent.sensors.values()):
        raise ScenarioError(f"beacons are found by a usbl, which {agent.name} does not carry", where=where)
    modems = {
        other.name: [name for name, m in other.sensors.items() if m.config.type in ("modem", "usbl")]
        for other in model.agents.values()
    }
    known = {f"{who}.{name}": f"{who}.{name}" for who, names in modems.items() for name in names}
    known |= {who: f"{who}.{names[0]}" for who, names in modems.items() if len(names) == 1}
    for name in config.beacons:
        if name not in known:
            raise ScenarioError(str(LookupFailed("modem", name, known)), where=where)
    return {known[name]: place for name, place in config.beacons.items()}


def _turn(config: Any) -> Floats:
    """`(3, 3)` sensor vectors to body vectors."""
    return np.asarray(matrix_np(np.array(config.q_body_sensor)))


def _inertial_noise(imu: Any) -> InertialNoise:
    """The filter's figures of an inertial unit."""
    time_s = imu.bias_correlation_time_s
    walks = [
        math.hypot(k, MARKOV_SHARE * b * math.sqrt(2 / time_s))
        for k, b in (
            (imu.accelerometer_random_walk, imu.accelerometer_bias_instability),
            (imu.gyroscope_random_walk, imu.gyroscope_bias_instability),
        )
    ]
    return InertialNoise(
        force=imu.accelerometer_noise_density,
        rate=imu.gyroscope_noise_density,
        force_walk=walks[0],
        rate_walk=walks[1],
        force_scale=imu.accelerometer_scale_std,
        force_alignment=imu.misalignment_std,
        scale=imu.gyroscope_scale_std,
        alignment=imu.misalignment_std,
    )


def _slow_noise(sensors: Mapping[str, Any]) -> SlowNoise:
    """Slow errors of the first GPS, depth gauge and magnetometer."""
    first: dict[str, Any] = {}
    for c in sensors.values():
        first.setdefault(c.type, c)
    gps, gauge, compass = (first.get(t) for t in ("gps", "depth", "magnetometer"))
    satellite = (0.0, 0.0, 0.0) if gps is None else (gps.horizontal_std_m, gps.horizontal_std_m, gps.vertical_std_m)
    offset = 0.0 if gauge is None else math.hypot(gauge.bias_std_m, gauge.drift_m)
    bias = 0.0 if compass is None else compass.bias_std_t
    time_s = 1.0 if gps is None else gps.correlation_time_s
    return SlowNoise((*satellite, offset, bias, bias, bias), (*[time_s] * 3, *[CONSTANT_S] * 4))


def _start_std(config: EkfNavigation, imu: Any, slow: SlowNoise) -> Floats:
    """Standard deviations `(22,)` at the start; errors of scale and alignment of gravity count as bias."""
    level, heading = math.radians(config.start_level_std_deg), math.radians(config.start_heading_std_deg)
    wander = MARKOV_SHARE * imu.accelerometer_bias_instability
    across = math.sqrt(imu.accelerometer_bias_std**2 + wander**2 + (imu.misalignment_std * GRAVITY) ** 2)
    along = math.sqrt(imu.accelerometer_bias_std**2 + wander**2 + (imu.accelerometer_scale_std * GRAVITY) ** 2)
    turn = math.hypot(imu.gyroscope_bias_std, MARKOV_SHARE * imu.gyroscope_bias_instability)
    std = [config.start_position_std_m] * 3 + [config.start_velocity_std_mps] * 3 + [level, level, heading]
    return np.array([*std, turn, turn, turn, across, across, along, *slow.std])


def _dvl_noise(config: Any, sigma: NDArray[np.float64]) -> Floats:
    """Covariance `(n, 3, 3)` of a velocity from the standard deviation of its beams `(n, 4)` [m/s]."""
    share = np.linalg.pinv(config.beams)  # (3, 4)
    sigma = np.where(np.isfinite(sigma), sigma, 10.0 * config.noise_mps)
    return np.asarray((share * sigma[:, None, :] ** 2) @ share.T) + 1e-8 * np.eye(3)
