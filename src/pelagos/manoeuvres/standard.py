"""Standard manoeuvres: runs of a vehicle in calm water, and their numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from pelagos.errors import InputError, LookupFailed
from pelagos.manoeuvres.approach import approach, first_speed, with_actuator
from pelagos.manoeuvres.calm_run import CalmRun
from pelagos.manoeuvres.measures import Measure, decay_measures, stop_measures, turning_measures, zigzag_measures
from pelagos.manoeuvres.orders import Orders, check
from pelagos.manoeuvres.trial import Trial
from pelagos.vehicles.actuators.mmg import MmgShipConfig
from pelagos.vehicles.model import Model
from pelagos.vehicles.vehicle import Vehicle

_RUN_UP_S: Final = 600.0  # at most
_RUN_UP_UNDER_WATER_S: Final = 5.0  # nobody is at the helm: it pitches and turns later on
_STEADY_S: Final = 10.0  # straight ahead before the helm is laid
_STOPPED_HZ: Final = 1e-3  # revolutions of an engine that is stopped: a key that must be positive
_LAST: Final = 0.1  # share of a time that was given, over which its rate is the mean
_SPAN: Final = 4.0  # lengths run between two looks at a rate that settles
_HELMS: Final = (1.0, 0.5, 0.25, 0.1, 0.05, 0.025)  # of a spiral's largest: close together where a loop is
_WAYS: Final = (("astern", "ahead"), ("to port", "to starboard"), ("up", "down"))
_ALONG, _ACROSS, _UPRIGHT = _WAYS
_HALF: Final = 0.5  # share of its push with which a thruster counts as one along the hull
PUSHING: Final = ("thruster", "force_thruster", "curve_thruster", "t200")
"""Types of actuators with a thrust at their limits, which `bollard` tells and `stop` sets astern."""
_TOLD: Final = 0.01  # share of a thrust: a smaller loss in a jet is not told


def _under_way(vehicle: Mapping[str, Any], orders: Orders) -> tuple[CalmRun, float]:
    """A run at the speed of its approach [m/s], and that speed."""
    begin = approach(vehicle, orders)
    return CalmRun(begin.vehicle, begin.speed, revolutions=begin.revolutions, depth=orders.depth_m), begin.speed


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
    down = [most * share for share in (*_HELMS, 0.0, *(-h for h in reversed(_HELMS)))]
    rates: list[float] = []
    for angle in (*down, *down[::-1]):
        run.command[helm] = math.radians(angle)
        if orders.seconds is None:
            rates.append(run.settled_rate(_SPAN * run.length / speed))
        else:
            run.go(orders.seconds)
            rates.append(run.mean_yaw_rate(_LAST * orders.seconds))
    port, starboard = rates[: len(down)], rates[len(down) :][::-1]
    found = [
        Measure(f"yaw rate at {a:+g} deg of helm, sweep to port", rate, "deg/s")
        for a, rate in zip(down, port, strict=True)
    ]
    back = list(zip(down, starboard, strict=True))[:-1]  # the last steady turn to port is the first back
    found += [Measure(f"yaw rate at {a:+g} deg of helm, sweep back", rate, "deg/s") for a, rate in back]
    apart = np.abs(np.subtract(port, starboard)[:-1])  # at the last helm it turned once
    widest = int(np.argmax(apart))
    found.append(Measure(f"height of the loop, at {down[widest]:+g} deg", float(apart[widest]), "deg/s"))
    trial = run.done("spiral", f"helm {most:g} to -{most:g} deg and back at {speed:.4g} m/s", found, [])
    return replace(trial, steady=np.stack([[*down, *down[::-1]], rates], axis=1))


def stop(vehicle: Mapping[str, Any], orders: Orders) -> Trial:
    """From its largest speed, or what thrusters make if that is less, or at once from the ordered one: thrusters along
    the hull full astern until the speed is 0.
    """
    ordered = None if orders.speed_m_s is None else first_speed(Vehicle.from_dict(vehicle), orders)
    run = CalmRun(vehicle, ordered or 0.0, depth=orders.depth_m)
    low, ahead = {}, []
    parts: list[Any] = list(run.vehicle.model.actuators.values())
    for k, actuator in enumerate(parts):
        if hasattr(actuator, "thrust_limits") and _way(actuator) is _ALONG:
            low[k] = actuator.lag.low if actuator.effect[0] > 0 else actuator.lag.high
            ahead.append((k, actuator.lag.high if actuator.effect[0] > 0 else actuator.lag.low))
    if not low:
        raise InputError(_without_thruster(run.vehicle, "stop", " that push along its hull"))
    if ordered is None:
        for k, command in ahead:
            run.command[k] = command
        top = run.vehicle.config.envelope.top_mps or math.inf
        run.go(
            orders.seconds or (_RUN_UP_S if run.floats else _RUN_UP_UNDER_WATER_S),
            until=lambda: run.now.ahead >= top or run.holds_speed(),
        )
    began = run.now
    for k, command in low.items():
        run.command[k] = command
    if not run.go(orders.seconds or 600.0, until=lambda: run.now.ahead <= 0):
        raise InputError("it did not come to a stop: run it longer (--seconds)")
    t = run.track()
    north, east = t.position[t.time >= began.time, :2].T
    found = [
        *stop_measures(north, east, heading_deg=math.degrees(began.yaw), length_m=run.length),
        Measure("stopping time", float(t.time[-1] - began.time), "s"),
        Measure("speed before", began.ahead, "m/s"),
    ]
    return run.done("stop", "full astern", found, [began.time])


def decay(vehicle: Mapping[str, Any], orders: Orders) -> Trial:
    """Free roll from a heel of 10 deg, from rest; an engine of fixed revolutions is stopped."""
    run = CalmRun(_stopped(vehicle), depth=orders.depth_m)
    angle = math.radians(orders.angle_deg or 10.0)
    run.sim.set_state("it", attitude=np.array([[math.cos(angle / 2), math.sin(angle / 2), 0.0, 0.0]]))
    run.rows.clear()
    run.keep()
    run.go(orders.seconds or 60.0 * math.sqrt(max(1.0, run.length / 20)))
    t = run.track()
    return run.done("decay", f"from {math.degrees(angle):g} deg of heel", decay_measures(t.time, t.attitude[:, 0]), [])


def bollard(vehicle: Mapping[str, Any], orders: Orders) -> Trial:
    """The pull of each thruster at its limits, the vehicle held, and what the jets of others take; no run."""
    run = CalmRun(vehicle, held=True)
    found = []
    for name, actuator in run.vehicle.model.actuators.items():
        if hasattr(actuator, "thrust_limits"):
            against, along = way = _way(actuator)
            turned = 1.0 if _ways(actuator) == way else -1.0  # it pushes against that way at its upper limit
            felt = turned * _felt(actuator)
            least, most = sorted(felt * float(limit) + 0.0 for limit in actuator.thrust_limits)  # 0, not -0
            found += [Measure(f"{name}, {along}", most, "N"), Measure(f"{name}, {against}", least, "N")]
    if not found:
        raise InputError(_without_thruster(run.vehicle, "bollard"))
    return run.done("bollard", "still water", found + _jet_losses(run.vehicle.model), [])


def _without_thruster(vehicle: Vehicle, manoeuvre: str, how: str = "") -> str:
    """Complaint that no actuator of a vehicle is one for a manoeuvre: what it has, and what would do."""
    by_type: dict[str, list[str]] = {}
    for name, config in vehicle.config.actuators.items():
        if config is not None:
            by_type.setdefault(config.type, []).append(name)
    own = "; ".join(f"{', '.join(names)} of the type {kind}" for kind, names in by_type.items()) or "none"
    return (
        f"{vehicle.name} has no actuators for {manoeuvre}, which takes those of the types {', '.join(PUSHING)}{how}; "
        f"its own: {own}"
    )


def _way(actuator: Any) -> tuple[str, str]:
    """Of the three ways of `_WAYS`, that of a thruster's push: along the hull where half of it or more is."""
    x, y, z = (abs(float(push)) for push in actuator.effect[:3])
    return _ALONG if x > _HALF * math.hypot(x, y, z) else _ACROSS if y >= z else _UPRIGHT


def _ways(actuator: Any) -> tuple[str, str]:
    """Words for the push of a thruster at its lower and at its upper limit."""
    way = _way(actuator)
    return way if float(actuator.effect[_WAYS.index(way)]) > 0 else way[::-1]


def _felt(actuator: Any) -> float:
    """Share of a thruster's thrust that its hull leaves."""
    inflow = getattr(actuator, "inflow", None)
    return 1.0 if inflow is None else 1.0 - inflow.deduction


def _jet_losses(model: Model) -> list[Measure]:
    """Thrust that a jet takes from a thruster, both at a limit, where it takes a hundredth or more."""
    found = []
    for jet in model.interaction.jets if model.interaction is not None else ():
        pair = [model.actuators[name] for name in (jet.source, jet.target)]
        limits = [actuator.thrust_limits for actuator in pair]  # type: ignore[attr-defined]
        for i, there in enumerate(_ways(pair[0])):
            for k, here in enumerate(_ways(pair[1])):
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
        orders: helm, angle, speed, time, depth of the water.

    Raises:
        LookupFailed: no such manoeuvre.
        InputError: the vehicle cannot do it, or did not get far enough; an order that it does not take.
    """
    if name not in MANOEUVRES:
        raise LookupFailed("manoeuvre", name, MANOEUVRES)
    check(name, orders or Orders())
    return MANOEUVRES[name](vehicle, orders or Orders())
