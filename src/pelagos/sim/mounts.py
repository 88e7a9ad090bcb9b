"""Checks of sensor mounts: inside something solid, sonars in the air, antennas under water."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import MountWarning
from pelagos.math.so3 import rotate_back_np, rotate_np
from pelagos.ocean.ocean import Ocean
from pelagos.raycast.geometry import Geometry
from pelagos.sensors.sonar.ping.sounder import FACE_M
from pelagos.sim.bodies import Body
from pelagos.sim.initial import StartState
from pelagos.sim.model import Model
from pelagos.vehicles.wetness import Floating

_NEAR: Final = 0.1  # [m], distance to anything static up to which a mount is looked at closely
_SOUND: Final = "frequency_hz"  # a key of every sonar, and of nothing else


def warn_of_buried(
    model: Model, starts: Mapping[str, StartState], hulls: Mapping[str, Geometry], bodies: Sequence[Body]
) -> None:
    """Warn (`MountWarning`) of each ray sensor whose mount is inside the ground, a solid, another hull or a body, and
    of each sonar above the water.

    Args:
        model: vehicles and sensors.
        starts: where agents begin; the first copy counts.
        hulls: those that stand in the moving scene, by agent, in the body frame.
        bodies: what else moves, where it begins.
    """
    sizes = {id(g.vertices): float(np.linalg.norm(g.vertices, axis=1).max()) for g in hulls.values()}
    radius = np.array([sizes[id(g.vertices)] for g in hulls.values()])
    centres = np.array([starts[o].position[0] for o in hulls]).reshape(-1, 3)
    names = list(hulls)
    for name, agent in model.agents.items():
        seeing = [s for s in agent.sensors.values() if s.sees]
        if not seeing:
            continue
        position, attitude = starts[name].position[0], starts[name].attitude[0]
        arms = np.array([s.config.position_m for s in seeing], dtype=np.float64)
        places = position + rotate_np(np.tile(attitude, (len(arms), 1)), arms)
        near = model.world.near(places, _NEAR)
        arm = float(np.linalg.norm(arms, axis=1).max())
        around = np.flatnonzero(np.linalg.norm(centres - position, axis=1) < radius + arm)
        others = [
            (hulls[o], starts[o].position[0], starts[o].attitude[0], o) for i in around if (o := names[i]) != name
        ]
        others += [(b.geometry, b.position[0], b.attitude[0], b.name) for b in bodies]
        for sensor, place, close in zip(seeing, places, near, strict=True):
            why = model.world.inside(place) if close else None
            why = why.split(" m ", 1)[1] if why is not None else _within(place, others)
            if why is not None:
                lost = "it will see nothing but the inside of that"
            elif hasattr(sensor.config, _SOUND) and (height := _above_water(model.ocean, place)) > FACE_M:
                why, lost = f"lies {height:.2g} m above the water", "it hears nothing there"
            else:
                continue
            _warn(f"agents.{name}.sensors.{sensor.name}", sensor.config.position_m, place, why, lost)


def warn_of_wrong_side(model: Model) -> None:
    """Warn (`MountWarning`) of antennas below the water line of what floats, and instruments for water above it."""
    for name, agent in model.agents.items():
        if not isinstance(agent.vehicle.model.wetting, Floating):
            continue
        for sensor in agent.sensors.values():
            kind, up = sensor.config.STANDS, sensor.config.position_m[2]  # from the origin, which is at the water line
            if kind == "antenna" and up <= 0.0:
                why = f"{-up:g} m below the water line at rest" if up else "in the water line at rest"
                lost = "it receives nothing there"
            elif kind == "keel" and up > 0.0 and not (sensor.sees and hasattr(sensor.config, _SOUND)):
                why, lost = f"{up:g} m above the water line at rest", "it is in the air there"
            else:
                continue
            places = agent.vehicle.config.mounts
            remedy = f"give position_m a z {'above' if kind == 'antenna' else 'below'} 0"
            if kind in places:
                remedy = f"leave out position_m, or write [{', '.join(f'{c:g}' for c in places[kind])}], its {kind}"
            where = f"agents.{name}.sensors.{sensor.name}.position_m"
            warnings.warn(
                f"{where}: {agent.vehicle.config.type} has it {why}: {lost}; {remedy}", MountWarning, stacklevel=2
            )


def _above_water(ocean: Ocean, place: NDArray[np.float64]) -> float:
    """Height of a place over the mean sea and over the surface as it is at the start, whichever is less [m]."""
    if place[2] <= 0.0 or (ocean.waves is None and ocean.tide is None):
        return float(place[2])
    x, y = jit.Float64(place[0]), jit.Float64(place[1])
    return float(place[2] - max(np.array(ocean.elevation(x, y, jit.Float64(0.0)))[0], 0.0))


def _warn(where: str, arm: tuple[float, float, float], place: NDArray[np.float64], why: str, lost: str) -> None:
    x, y, z = (f"{c:.2f}" for c in place)
    forward, left, up = (f"{c:g}" for c in arm)
    warnings.warn(
        f"{where}: its mount at ({x}, {y}, {z}) m {why}: {lost}. Start the vehicle "
        f"elsewhere, or change the sensor's position_m, which is [{forward}, {left}, {up}] forward, left and up of the "
        "vehicle's origin",
        MountWarning,
        stacklevel=2,
    )


def _within(
    place: NDArray[np.float64], others: Sequence[tuple[Geometry, NDArray[np.float64], NDArray[np.float64], str]]
) -> str | None:
    """Inside which of some bodies a place is."""
    for geometry, position, attitude, name in others:
        local = rotate_back_np(attitude[None], (place - position)[None])[0]
        low, high = geometry.vertices.min(axis=0), geometry.vertices.max(axis=0)
        if (local > low).all() and (local < high).all() and winding_number(geometry, local) > 0.5:
            return f"lies inside {name}"
    return None


def winding_number(geometry: Geometry, place: NDArray[np.float64]) -> float:
    """Winding number of a closed mesh around a place: its faces' solid angles over 4 pi; overlapping parts count each.

    Source: A. Van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30, 125 (1983), doi 10.1109/TBME.1983.325207.
    """
    a, b, c = (geometry.vertices[geometry.faces[:, i]] - place for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    top = _dot(a, np.cross(b, c))
    bottom = la * lb * lc + _dot(a, b) * lc + _dot(b, c) * la + _dot(c, a) * lb
    return abs(float(np.arctan2(top, bottom).sum()) / (2.0 * math.pi))


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.einsum("ij,ij->i", a, b))
