"""Runs of a vehicle through a standard manoeuvre in calm water."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError, LookupFailed, ScenarioError
from pelagos.manoeuvres.approach import RUDDERS, approach, first_speed, with_actuator
from pelagos.manoeuvres.measures import (
    FULL_HELM,
    Measure,
    decay_measures,
    stop_measures,
    turning_measures,
    zigzag_measures,
)
from pelagos.manoeuvres.orders import Orders, check
from pelagos.sim.simulation import Simulation
from pelagos.vehicles.actuators.mmg import MmgShipConfig
from pelagos.vehicles.model import Model
from pelagos.vehicles.vehicle import Vehicle

_RATE_HZ: Final = (100, 10)  # of those under water, small and with strong thrusters, and of those that float
_RUN_UP_S: Final = (5.0, 60.0)  # under water nobody is at the helm: it pitches and turns later on
_DEEP: Final = 10.0  # lengths: the surface is far from those that do not float
_STEADY_S: Final = 10.0  # straight ahead before the helm is laid
_SPIN_UP: Final = 10.0  # time constants of an engine, until its revolutions are within 5e-5 of the order
_STOPPED_HZ: Final = 1e-3  # revolutions of an engine that is stopped: a key that must be positive
_WAY: Final = 20.0  # lengths of depth below
_SPAN: Final = 4.0  # lengths run between two looks at a rate that settles
_SETTLED: Final = 0.005  # share of the largest rate by which it then still changes
_SPANS: Final = 40  # looks at most
_ROUNDED: Final = 1e-6  # deg: limits are kept in rad
_MODE: Final = "each_actuator_of_the_trial"  # the control mode that is added for it
_ROOM: Final = 400.0  # lengths of ground, either way, where its depth counts
_TOLD: Final = 0.01  # share of a thrust: a smaller loss in a jet is not told


@dataclass(frozen=True)
class Track:
    """Record of a trial: time [s], position NED `(n, 3)` [m], attitude roll, pitch, heading (unwrapped) `(n, 3)` [rad],
    velocity in body axes FRD `(n, 3)` [m/s], rates FRD `(n, 3)` [rad/s], commands `(n, k)`.
    """

    time: NDArray[np.float64]
    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]
    rates: NDArray[np.float64]
    commands: NDArray[np.float64]


@dataclass(frozen=True)
class Trial:
    """A manoeuvre that was run: its name, what was ordered, the ship's size, the track, its numbers, when the helm was
    ordered [s], a spiral's steady states `(n, 2)` in the order of the run: helm [deg], yaw rate [deg/s]; the rudder's
    column of the track's commands; the vehicle's variant.
    """

    name: str
    ordered: str
    vehicle: str
    length_m: float
    beam_m: float
    track: Track
    measures: list[Measure]
    switched_s: NDArray[np.float64]
    steady: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    rudder: int = 0
    variant: str | None = None

    @property
    def title(self) -> str:
        """One line: vehicle and variant, manoeuvre, what was ordered."""
        variant = "" if self.variant is None else f", variant {self.variant}"
        return f"{self.vehicle}{variant}: {self.name}, {self.ordered}"


class _Run:
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
        self.rate_hz = _RATE_HZ[self.floats]
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
        self._keep()

    def _checked(self, depth: float | None) -> float | None:
        """The depth of the water [m].

        Raises:
            InputError: a vehicle that feels it is told none, or one that does not feel it is told one.
        """
        feels = self.floats and self.vehicle.model.feels_planes
        if feels and depth is None:
            raise InputError(f"{self.vehicle.name} feels the depth of its water here: give it (--depth)")
        if depth is not None and not feels:
            raise InputError(
                f"--depth {depth:g}: nothing of {self.vehicle.name} depends on the depth of its water; kvlcc2 and "
                "tanker have a variant for it, shallow, and other ships may have its terms (docs/vehicles.md)"
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

    def _keep(self) -> None:
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

    def go(self, seconds: float, *, until: Callable[[], bool] = lambda: False) -> bool:
        """Run, and whether `until` came true."""
        for _ in range(round(seconds * self.rate_hz)):
            self.sim.step({"it": self.command})
            self._keep()
            if until():
                return True
        return False

    def track(self) -> Track:
        """Everything so far."""
        table = np.array(self.rows)
        attitude = table[:, 4:7].copy()
        attitude[:, 2] = np.unwrap(attitude[:, 2])
        return Track(table[:, 0], table[:, 1:4], attitude, table[:, 7:10], table[:, 10:13], table[:, 13:])

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
            "what it can do is decay, and with thrusters bollard"
        )

    def done(self, name: str, ordered: str, measures: list[Measure], switched: list[float]) -> Trial:
        """The trial."""
        beam, parts = self.vehicle.config.beam, self.vehicle.model.actuators.values()
        rudder = next((k for k, actuator in enumerate(parts) if isinstance(actuator, RUDDERS)), 0)
        return Trial(
            name,
            ordered if self.depth is None else f"{ordered} in {self.depth:g} m of water",
            self.vehicle.name,
            self.length,
            beam,
            self.track(),
            measures,
            np.array(switched),
            rudder=rudder,
            variant=self.vehicle.config.variant,
        )

    def settled_rate(self, span_s: float) -> float:
        """Yaw rate [deg/s] once it no longer changes from one span to the next.

        Raises:
            InputError: it never settles.
        """
        last = max(1, round(0.25 * span_s * self.rate_hz))
        largest = max(abs(math.degrees(row[12])) for row in self.rows)
        before = math.inf
        for _ in range(_SPANS):
            self.go(span_s)
            now = float(np.degrees(np.mean([row[12] for row in self.rows[-last:]])))
            if abs(now - before) <= _SETTLED * max(largest, abs(now)):
                return now
            before = now
        raise InputError(
            f"the yaw rate did not settle in {_SPANS * span_s:g} s: give the time at each helm (--seconds)"
        )


def _under_way(vehicle: Mapping[str, Any], orders: Orders) -> tuple[_Run, float]:
    """A run at the speed of its approach [m/s], and that speed."""
    begin = approach(vehicle, orders)
    return _Run(begin.vehicle, begin.speed, revolutions=begin.revolutions, depth=orders.depth_m), begin.speed


def _stopped(vehicle: Mapping[str, Any]) -> Mapping[str, Any]:
    """The same vehicle, of which no propeller turns by itself: it would gather way, and lift damps roll."""
    for name, config in Vehicle.from_dict(vehicle).config.actuators.items():
        if isinstance(config, MmgShipConfig):
            vehicle = with_actuator(vehicle, name, {"revolutions_hz": _STOPPED_HZ})
    return vehicle


def turning(vehicle: Mapping[str, Any], orders: Orders) -> Trial:
    """A turning circle at full helm (35 deg), through 540 deg."""
    run, speed = _under_way(vehicle, orders)
    rudder = orders.rudder_deg or run.full_helm()
    helm = run.helm(rudder)
    run.go(_STEADY_S)
    ordered = run.seconds
    run.command[helm] = math.radians(rudder)
    limit = orders.seconds or 60 * run.length / speed
    run.go(limit, until=lambda: abs(run.heading_deg) > 540)
    t = run.track()
    found = turning_measures(
        t.time, t.position[:, 0], t.position[:, 1], np.degrees(t.attitude[:, 2]), ordered_s=ordered,
        length_m=run.length, limited=abs(rudder) >= run.full_helm(),
    )  # fmt: skip
    return run.done("turning", f"helm {rudder:g} deg at {speed:.4g} m/s", found, [ordered])


def zigzag(vehicle: Mapping[str, Any], orders: Orders) -> Trial:
    """A zig-zag: the helm is reversed whenever the heading has reached the angle; five times."""
    run, speed = _under_way(vehicle, orders)
    rudder = abs(orders.rudder_deg or 10.0)
    angle = orders.angle_deg or rudder
    first = math.copysign(1.0, orders.rudder_deg or 1.0)
    helm = run.helm(rudder)
    run.go(_STEADY_S)
    ordered, side = run.seconds, first
    switched: list[float] = []
    limit = orders.seconds or 60 * run.length / speed
    for _ in range(5):
        run.command[helm] = math.radians(side * rudder)
        here = side
        if not run.go(limit, until=lambda here=here: here * run.heading_deg >= angle):  # type: ignore[misc]
            raise InputError(
                f"the heading never reached {side * angle:g} deg with {rudder:g} deg of helm in {limit:g} s"
            )
        switched.append(run.seconds)
        side = -side
    t = run.track()
    within = (t.time >= ordered) & (t.time <= switched[0])
    way = float(np.hypot(*np.diff(t.position[within, :2], axis=0).T).sum()) / run.length
    found = zigzag_measures(
        t.time, np.degrees(t.attitude[:, 2]), np.array(switched), rudder_deg=rudder, angle_deg=angle,
        length_m=run.length, speed_m_s=speed, run_lengths=way,
    )  # fmt: skip
    return run.done("zigzag", f"{rudder:g}/{angle:g} at {speed:.4g} m/s", found, [ordered, *switched])


def spiral(vehicle: Mapping[str, Any], orders: Orders) -> Trial:
    """Dieudonne's spiral: steady turns from helm to starboard over 0 to port and back; a loop shows instability.

    Yaw rates are positive to starboard, whichever way the helm is swept.
    """
    run, speed = _under_way(vehicle, orders)
    most = abs(orders.rudder_deg or 20.0)
    helm = run.helm(most)
    down = [most * s for s in (1, 0.5, 0.25, 0.1, 0, -0.1, -0.25, -0.5, -1)]
    rates: list[float] = []
    for angle in (*down, *down[::-1]):
        run.command[helm] = math.radians(angle)
        if orders.seconds is None:
            rates.append(run.settled_rate(_SPAN * run.length / speed))
        else:
            run.go(orders.seconds)
            last = max(1, round(0.1 * orders.seconds * run.rate_hz))
            rates.append(float(np.degrees(np.mean([row[12] for row in run.rows[-last:]]))))
    port, starboard = rates[: len(down)], rates[len(down) :][::-1]
    found = [
        Measure(f"yaw rate at {a:+g} deg of helm, sweep to port", rate, "deg/s")
        for a, rate in zip(down, port, strict=True)
    ]
    back = list(zip(down, starboard, strict=True))[:-1]  # the last steady turn to port is the first back
    found += [Measure(f"yaw rate at {a:+g} deg of helm, sweep back", rate, "deg/s") for a, rate in back]
    found.append(Measure("height of the loop at 0 deg", abs(port[4] - starboard[4]), "deg/s"))
    trial = run.done("spiral", f"helm {most:g} to -{most:g} deg and back at {speed:.4g} m/s", found, [])
    return replace(trial, steady=np.stack([[*down, *down[::-1]], rates], axis=1))


def stop(vehicle: Mapping[str, Any], orders: Orders) -> Trial:
    """From full speed, or at once from the ordered one, thrusters along the hull full astern until the speed is 0."""
    run = _Run(vehicle, first_speed(Vehicle.from_dict(vehicle), orders), depth=orders.depth_m)
    low, ahead = {}, []
    for k, actuator in enumerate(run.vehicle.model.actuators.values()):
        if hasattr(actuator, "thrust_limits") and hasattr(actuator, "effect") and abs(float(actuator.effect[0])) > 0.5:
            low[k] = actuator.lag.low if actuator.effect[0] > 0 else actuator.lag.high
            ahead.append((k, actuator.lag.high if actuator.effect[0] > 0 else actuator.lag.low))
    if not low:
        raise InputError(f"{run.vehicle.name} has no thruster along its hull that can be set astern")
    if orders.speed_m_s is None:
        for k, command in ahead:
            run.command[k] = command
        run.go(orders.seconds or _RUN_UP_S[run.floats])
    began = run.rows[-1].copy()
    for k, command in low.items():
        run.command[k] = command
    if not run.go(orders.seconds or 600.0, until=lambda: bool(run.rows[-1][7] <= 0)):
        raise InputError("it did not come to a stop: run it longer (--seconds)")
    end = run.rows[-1]
    north, east = np.array([r[1:3] for r in run.rows if r[0] >= began[0]]).T
    found = [
        *stop_measures(north, east, heading_deg=math.degrees(began[6]), length_m=run.length),
        Measure("stopping time", float(end[0] - began[0]), "s"),
        Measure("speed before", float(began[7]), "m/s"),
    ]
    return run.done("stop", "full astern", found, [float(began[0])])


def decay(vehicle: Mapping[str, Any], orders: Orders) -> Trial:
    """Free roll from a heel of 10 deg, from rest; an engine of fixed revolutions is stopped."""
    run = _Run(_stopped(vehicle), depth=orders.depth_m)
    angle = math.radians(orders.angle_deg or 10.0)
    run.sim.set_state("it", attitude=np.array([[math.cos(angle / 2), math.sin(angle / 2), 0.0, 0.0]]))
    run.rows.clear()
    run._keep()
    run.go(orders.seconds or 60.0 * math.sqrt(max(1.0, run.length / 20)))
    t = run.track()
    return run.done("decay", f"from {math.degrees(angle):g} deg of heel", decay_measures(t.time, t.attitude[:, 0]), [])


def bollard(vehicle: Mapping[str, Any], orders: Orders) -> Trial:
    """The pull of each thruster at its limits, the vehicle held, and what the jets of others take; no run."""
    run = _Run(vehicle, held=True)
    found = []
    for name, actuator in run.vehicle.model.actuators.items():
        if hasattr(actuator, "thrust_limits"):
            astern, ahead = (float(limit) * _felt(actuator) for limit in actuator.thrust_limits)
            found += [Measure(f"{name}, ahead", ahead, "N"), Measure(f"{name}, astern", astern, "N")]
    if not found:
        raise InputError(f"{run.vehicle.name} has no thruster")
    return run.done("bollard", "still water", found + _jet_losses(run.vehicle.model), [])


def _felt(actuator: Any) -> float:
    """Share of a thruster's thrust that its hull leaves."""
    inflow = getattr(actuator, "inflow", None)
    return 1.0 if inflow is None else 1.0 - inflow.deduction


def _jet_losses(model: Model) -> list[Measure]:
    """Thrust that a jet takes from a thruster, both at a limit, where it takes a hundredth or more."""
    found = []
    for jet in model.interaction.jets if model.interaction is not None else ():
        limits = [model.actuators[name].thrust_limits for name in (jet.source, jet.target)]  # type: ignore[attr-defined]
        for i, there in enumerate(("astern", "ahead")):
            for k, here in enumerate(("astern", "ahead")):
                source, target = float(limits[0][i]), float(limits[1][k])
                lost = 1 - model.interaction.left(model.actuators, jet, source=source, target=target)  # type: ignore[union-attr]
                if lost >= _TOLD:
                    name = f"{jet.target} {here}, lost in the jet of {jet.source} {there}"
                    found.append(Measure(name, 100 * lost, "%"))
    return found


MANOEUVRES: Final[dict[str, Callable[[Mapping[str, Any], Orders], Trial]]] = {
    "turning": turning, "zigzag": zigzag, "stop": stop, "spiral": spiral, "decay": decay, "bollard": bollard,
}  # fmt: skip


def run_manoeuvre(vehicle: Mapping[str, Any], name: str, orders: Orders | None = None) -> Trial:
    """Run a manoeuvre with a vehicle.

    Args:
        vehicle: as a scenario has it, such as {"type": "mariner"}.
        name: of `MANOEUVRES`.
        orders: helm, angle, speed, time.

    Raises:
        LookupFailed: no such manoeuvre.
        InputError: the vehicle cannot do it, or did not get far enough; an order that it does not take.
    """
    if name not in MANOEUVRES:
        raise LookupFailed("manoeuvre", name, MANOEUVRES)
    check(name, orders or Orders())
    return MANOEUVRES[name](vehicle, orders or Orders())
