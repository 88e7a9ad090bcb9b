"""A run of one vehicle in calm water."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError, ScenarioError
from pelagos.manoeuvres.approach import HELD, RUDDERS
from pelagos.manoeuvres.measures import FULL_HELM, Measure
from pelagos.manoeuvres.trial import Track, Trial
from pelagos.sim.simulation import Simulation
from pelagos.vehicles.vehicle import Vehicle

_RATE_SMALL_HZ: Final = 100  # strong thrusters, and rolls of half a second
_RATE_SHIP_HZ: Final = 10
_SHIP_M: Final = 30.0  # least length; shorter boats roll within seconds
_DEEP: Final = 10.0  # lengths: the surface is far from those that do not float
_SPIN_UP: Final = 10.0  # time constants of an engine, until its revolutions are within 5e-5 of the order
_WAY: Final = 20.0  # lengths of depth below
_CREEPS: Final = 1e-3  # m/s, by which a length is divided at least
_SETTLED: Final = 0.001  # share of the largest rate, and of the speed, by which they then still change
_SPANS: Final = 100  # looks at most
_ROWS: Final = 16  # kept of each
_ROUNDED: Final = 1e-6  # deg: limits are kept in rad
_MODE: Final = "each_actuator_of_the_trial"  # the control mode that is added for it
_ROOM: Final = 400.0  # lengths of ground, either way, where its depth counts
_TIME, _PLACE, _ATTITUDE, _VELOCITY, _RATES = 0, slice(1, 4), slice(4, 7), slice(7, 10), slice(10, 13)
_COMMANDS: Final = 13  # and on: columns of a row
_YAW_RATE: Final = 12


@dataclass(frozen=True)
class Moment:
    """time [s]; yaw: heading from the first course [rad]; ahead: speed over the ground along the hull [m/s]."""

    time: float
    yaw: float
    ahead: float


class CalmRun:
    """One vehicle in calm water, commanded actuator by actuator."""

    def __init__(
        self, vehicle: Mapping[str, Any], speed: float = 0.0, *, revolutions: Mapping[int, float] | None = None,
        depth: float | None = None, held: bool = False,
    ) -> None:  # fmt: skip
        """`revolutions` that engines are ordered, by number; `depth` of the water [m], deep without, which counts for
        nothing where the vehicle is `held`.
        """
        self.vehicle = Vehicle.from_dict(vehicle)
        self.length = self.vehicle.config.length_m
        self.floats = bool(self.vehicle.config.body.stiffness.any())
        self.depth = None if held else self._checked(depth)
        self.rate_hz = _RATE_SHIP_HZ if self.floats and self.length >= _SHIP_M else _RATE_SMALL_HZ
        start = {"position_m": [0, 0], "depth_m": 0.0 if self.floats else _DEEP * self.length}
        modes = {**(vehicle.get("modes") or {}), _MODE: {"type": "actuators"}}
        agent = {"vehicle": {**vehicle, "modes": modes}, "control": _MODE, "start": start}
        world: dict[str, Any] = {"type": "flat", "depth_m": depth or max(20.0, _WAY * self.length)}
        if depth is not None:
            world["size_m"] = [_ROOM * self.length] * 2
        scenario = {"tick_rate_hz": self.rate_hz, "world": world, "agents": {"it": agent}}
        try:
            self.sim = Simulation.load(scenario, trust=True)  # as `from_dict` does: whoever read a file has asked
        except ScenarioError as error:
            if depth is None:
                raise
            raise InputError(f"--depth {depth:g}: {error}") from None
        self.sim.reset(seed=0)
        self.command = np.zeros(len(self.vehicle.actuator_names))
        if revolutions:
            self._start_engines(revolutions)
        self._began_ns = self.sim.time_ns
        if speed:
            self.sim.set_state("it", velocity=np.array([[speed, 0.0, 0.0]]))
        self.rows: list[NDArray[np.float64]] = []
        self._heading = 0.0  # unwrapped [rad]
        self.keep()

    def _checked(self, depth: float | None) -> float | None:
        """The depth of the water [m].

        Raises:
            InputError: a vehicle that feels it is told none, or one that does not feel it is told one.
        """
        feels = self.floats and self.vehicle.model.feels_depth
        if feels and depth is None:
            raise InputError(f"{self.vehicle.name} feels the depth of its water here: give it (--depth)")
        if depth is not None and not self.floats:
            raise InputError(
                f"--depth {depth:g}: {self.vehicle.name} is run {_DEEP:g} lengths under water; it is for what floats"
            )
        if depth is not None and not feels:
            raise InputError(
                f"--depth {depth:g}: nothing of {self.vehicle.name} depends on the depth of its water; terms "
                "of ships that do are in docs/vehicles.md"
            )
        return depth

    def _start_engines(self, revolutions: Mapping[int, float]) -> None:
        """Let engines come to their revolutions [1/s]; the ship is then put back where it began."""
        for k, ordered in revolutions.items():
            self.command[k] = ordered
        parts = list(self.vehicle.model.actuators.values())
        slowest = max(float(parts[k].lag.time_constant) for k in revolutions)
        start = self.sim.state["it"]
        position, attitude, still = start.position.copy(), start.attitude.copy(), np.zeros((1, 3))
        self.sim.step({"it": self.command})
        self.sim.run(_SPIN_UP * slowest)
        self.sim.set_state("it", position=position, attitude=attitude, velocity=still, angular_velocity=still)

    def keep(self) -> None:
        """Record the motion now."""
        state = self.sim.state["it"]
        roll, pitch, yaw = state.euler[0]
        down = np.array([1.0, -1.0, -1.0])
        self._heading += math.remainder(-yaw - self._heading, math.tau)
        self.rows.append(
            np.concatenate([
                [(self.sim.time_ns - self._began_ns) * 1e-9], state.position[0] * down, [roll, -pitch, -yaw],
                state.velocity[0] * down, state.angular_velocity[0] * down, self.command,
            ])
        )  # fmt: skip

    @property
    def heading_deg(self) -> float:
        """Unwrapped, from the first course."""
        return math.degrees(self._heading)

    @property
    def seconds(self) -> float:
        """Since the start."""
        return float(self.rows[-1][0])

    @property
    def now(self) -> Moment:
        """The last row."""
        row = self.rows[-1]
        return Moment(float(row[_TIME]), float(row[_ATTITUDE][2]), float(row[_VELOCITY][0]))

    def go(self, seconds: float, *, until: Callable[[], bool] = lambda: False) -> bool:
        """Run, and whether `until` came true."""
        for _ in range(round(seconds * self.rate_hz)):
            self.sim.step({"it": self.command})
            self.keep()
            if until():
                return True
        return False

    def holds_speed(self) -> bool:
        """True where it gained hardly any speed in its last length."""
        now = self.now.ahead
        back = math.ceil(self.length / max(now, _CREEPS) * self.rate_hz)
        return back < len(self.rows) and now - float(self.rows[-1 - back][_VELOCITY][0]) <= HELD * now

    def _go_on(self, ticks: int) -> None:
        """Run at one command, of which the end alone is kept: ten times as fast as `go`."""
        self.sim.step({"it": self.command})
        self.sim.run((ticks - 1) / self.rate_hz)
        self.keep()

    def track(self) -> Track:
        """Everything so far."""
        table = np.array(self.rows)
        attitude = table[:, _ATTITUDE].copy()
        attitude[:, 2] = np.unwrap(attitude[:, 2])
        return Track(
            table[:, _TIME], table[:, _PLACE], attitude, table[:, _VELOCITY], table[:, _RATES], table[:, _COMMANDS:]
        )

    def full_helm(self) -> float:
        """35 deg, or as much as the rudder has [deg] (MSC.137(76), 5.1.2)."""
        rudder = list(self.vehicle.model.actuators.values())[self.helm(0.0)]
        return min(FULL_HELM, math.degrees(float(rudder.lag.high)))

    def helm(self, most_deg: float) -> int:
        """Number of the rudder among the actuators.

        Raises:
            InputError: it has no rudder of the kind that ships' trials are about, or not that much helm.
        """
        for k, actuator in enumerate(self.vehicle.model.actuators.values()):
            if isinstance(actuator, RUDDERS):
                least, most = (math.degrees(float(x)) for x in (actuator.lag.low, actuator.lag.high))
                if not least - _ROUNDED <= most_deg <= most + _ROUNDED:
                    raise InputError(
                        f"--rudder {most_deg:g}: the rudder of {self.vehicle.name} goes from {least:g} to {most:g} deg"
                    )
                return k
        kinds = ", ".join(self.vehicle.actuator_names) or "none"
        raise InputError(
            f"{self.vehicle.name} has no ship's rudder (actuators: {kinds}); "
            "what it can do is decay, and with thrusters stop and bollard"
        )

    def done(self, name: str, ordered: str, measures: list[Measure], switched: list[float]) -> Trial:
        """The trial."""
        beam, parts = self.vehicle.config.beam, self.vehicle.model.actuators.values()
        rudder = next((k for k, actuator in enumerate(parts) if isinstance(actuator, RUDDERS)), 0)
        return Trial(
            name=name,
            ordered=ordered if self.depth is None else f"{ordered} in {self.depth:g} m of water",
            vehicle=self.vehicle.name,
            length_m=self.length,
            beam_m=beam,
            track=self.track(),
            measures=measures,
            switched_s=np.array(switched),
            rudder=rudder,
            variant=self.vehicle.config.variant,
        )

    def mean_yaw_rate(self, seconds: float) -> float:
        """Yaw rate over the last seconds [deg/s]."""
        last = max(1, round(seconds * self.rate_hz))
        return float(np.degrees(np.mean([row[_YAW_RATE] for row in self.rows[-last:]])))

    def settled_rate(self, span_s: float) -> float:
        """Yaw rate [deg/s] once neither it nor the speed changes from one span to the next.

        The rate alone would be taken where it passes an extreme, while the ship still loses or gains way.

        Raises:
            InputError: it never settles.
        """
        largest = max(abs(row[_YAW_RATE]) for row in self.rows)
        ticks = max(2, round(span_s * self.rate_hz / _ROWS))
        before = np.full(2, math.inf)
        for _ in range(_SPANS):
            for _ in range(_ROWS):
                self._go_on(ticks)
            last = np.array(self.rows[-_ROWS // 4 :])
            now = np.array([last[:, _YAW_RATE].mean(), np.hypot(*last[:, _VELOCITY][:, :2].T).mean()])
            if (np.abs(now - before) <= _SETTLED * np.array([max(largest, abs(now[0])), now[1]])).all():
                return math.degrees(now[0])
            before = now
        raise InputError(
            f"the yaw rate did not settle in {_SPANS * span_s:g} s: give the time at each helm (--seconds)"
        )
