"""Approach of a trial: its speed, and the revolutions that hold it, straight ahead in calm water of its depth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError
from pelagos.manoeuvres.orders import Orders
from pelagos.vehicles.actuators.bis import BisRudder
from pelagos.vehicles.actuators.engine import ShipEngine
from pelagos.vehicles.actuators.mmg import MmgShip
from pelagos.vehicles.actuators.nomoto import NomotoShip
from pelagos.vehicles.actuators.rolling import RollingRudder
from pelagos.vehicles.actuators.ship import ShipRudder
from pelagos.vehicles.vehicle import Vehicle

Floats = NDArray[np.float64]

RUDDERS: Final = (BisRudder, MmgShip, NomotoShip, RollingRudder, ShipRudder)
"""Actuators that are a ship's rudder, with its hull and propeller."""

HELD: Final = 0.005
"""Share of its speed that a ship may gain or lose in its first length and still hold it: catalogues round."""
_STEPS: Final = 512  # revolutions tried, between which straight lines are drawn
_PARABOLA: Final = (0.5, 1.0, 1.5)  # of the revolutions: three points of a thrust that is quadratic in them


@dataclass(frozen=True)
class Approach:
    """vehicle: as a scenario has it, with the revolutions of the speed; speed [m/s]; revolutions [1/s] that engines are
    ordered, by their number among the actuators.
    """

    vehicle: Mapping[str, Any]
    speed: float
    revolutions: Mapping[int, float]


def first_speed(vehicle: Vehicle, orders: Orders) -> float:
    """Speed ordered, or the largest, or the cruising speed [m/s].

    Raises:
        InputError: more than the vehicle makes.
    """
    envelope = vehicle.config.envelope
    if orders.speed_m_s is None:
        return float(envelope.top_mps or envelope.cruise_mps)
    if envelope.top_mps is not None and orders.speed_m_s > envelope.top_mps:
        raise InputError(
            f"--speed {orders.speed_m_s:g}: {vehicle.name} makes at most {envelope.top_mps:g} m/s (envelope.top_mps)"
        )
    return orders.speed_m_s


def approach(vehicle: Mapping[str, Any], orders: Orders) -> Approach:
    """Approach at the ordered speed, with the revolutions that hold it straight ahead in calm water of the depth; in
    shallow water without an order at the speed that the service revolutions hold there.

    Raises:
        InputError: a speed that the ship does not make, or that nothing holds.
    """
    ship = Vehicle.from_dict(vehicle)
    speed = first_speed(ship, orders)
    depth = orders.depth_m if ship.model.feels_depth else None  # the run refuses one that counts for nothing
    engines = {k: a.service for k, a in enumerate(ship.model.actuators.values()) if isinstance(a, ShipEngine)}
    if not any(isinstance(a, RUDDERS) for a in ship.model.actuators.values()):
        return Approach(vehicle, speed, engines)
    states = np.zeros((1, len(ship.actuator_names)))
    for k, service in engines.items():
        states[0, k] = service
    if orders.speed_m_s is None:
        slower = speed if depth is None else _held_speed(ship, speed, states, depth)
        return Approach(vehicle, slower, engines)
    gain = float(_surge(ship, speed, states, depth)[0]) * ship.config.length_m / speed**2
    if abs(gain) <= HELD:
        return Approach(vehicle, speed, engines)
    if engines:
        return Approach(vehicle, speed, _ordered(ship, speed, states, engines, depth))
    for name, actuator in ship.model.actuators.items():
        if isinstance(actuator, MmgShip):
            if gain < 0 and depth is not None:  # in deep water the envelope says how fast it goes
                most = _held_speed(ship, speed, states, depth)
                raise InputError(f"--speed {speed:g}: {ship.name} makes at most {most:.3g} m/s in {depth:g} m of water")
            turned = [with_actuator(vehicle, name, {"revolutions_hz": x * actuator.revolutions}) for x in _PARABOLA]
            gains = [float(_surge(Vehicle.from_dict(v), speed, states, depth)[0]) for v in turned]
            held = float(np.roots(np.polyfit(_PARABOLA, gains, 2)).real.max() * actuator.revolutions)
            return Approach(with_actuator(vehicle, name, {"revolutions_hz": held}), speed, {})
    raise InputError(
        f"--speed {speed:g}: {ship.name} would {'gain' if gain > 0 else 'lose'} speed at once: its engine has one "
        f"setting; leave --speed out ({first_speed(ship, Orders()):g} m/s)"
    )


def _surge(ship: Vehicle, speed: float | Floats, states: Floats, depth: float | None) -> Floats:
    """Acceleration ahead `(n,)` [m/s^2] at a speed, or one each `(n,)`, by actuators' states `(n, k)`; depth of the
    water [m]. The ship is held level: it would sink and trim first, which its mass below the origin couples with surge.
    """
    ahead = np.zeros((len(states), 6))
    ahead[:, 0] = speed
    ground = () if depth is None else ((0.0, 0.0, -1.0, depth),)
    free = ship.accelerations(np.zeros((len(states), 6)), ahead, states, states, walls=ground)[0]
    row = ship.config.body.mass_matrix[0]
    return np.asarray(free @ row / row[0])


def _held_speed(ship: Vehicle, most: float, states: Floats, depth: float | None) -> float:
    """The largest speed up to `most` that actuators' states `(1, k)` hold [m/s]."""
    tried = most * np.linspace(1.0, 0.0, _STEPS, endpoint=False)
    gains = _surge(ship, tried, np.repeat(states, _STEPS, axis=0), depth)
    first = int(np.argmax(gains >= 0))
    return float(np.interp(0.0, gains[first - 1 : first + 1], tried[first - 1 : first + 1])) if first else most


def _ordered(
    ship: Vehicle, speed: float, states: Floats, engines: Mapping[int, float], depth: float | None
) -> dict[int, float]:
    """Revolutions of engines that hold a speed, all by the same share of their service revolutions."""
    limits = [a.lag.high / a.service for a in ship.model.actuators.values() if isinstance(a, ShipEngine)]
    shares = np.linspace(0.0, float(min(limits)), _STEPS)
    tried = np.repeat(states, _STEPS, axis=0)
    for k, service in engines.items():
        tried[:, k] = shares * service
    gains = _surge(ship, speed, tried, depth)
    if gains[-1] < 0:
        raise InputError(f"--speed {speed:g}: the engine of {ship.name} does not hold it at its largest revolutions")
    first = int(np.flatnonzero(gains >= 0)[0])
    share = float(np.interp(0.0, gains[first - 1 : first + 1], shares[first - 1 : first + 1])) if first else 0.0
    return {k: share * service for k, service in engines.items()}


def with_actuator(vehicle: Mapping[str, Any], name: str, keys: Mapping[str, Any]) -> dict[str, Any]:
    """A vehicle with other keys of an actuator."""
    actuators = dict(vehicle.get("actuators") or {})
    return {**vehicle, "actuators": actuators | {name: {**(actuators.get(name) or {}), **keys}}}
