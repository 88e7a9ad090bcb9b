"""A vehicle as the view draws it: the hull, and the fins and propellers that turn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.colours import display
from pelagos.math.frames import flip_yz_np
from pelagos.vehicles.vehicle import Vehicle
from pelagos.world.material import material

_BLADES: Final = 3
_SLOWED: Final = 0.12  # of a propeller's true turns, so that the eye can follow them


@dataclass(frozen=True)
class Turning:
    """A part that turns about an axis.

    Attributes:
        vertices, faces: about the axis's foot [m].
        foot: `(3,)` in the body's frame FLU [m].
        axis: `(3,)` unit vector, FLU.
        actuator: place of its state among the vehicle's.
        spins: it goes round with the shaft; else it is deflected by the state [rad].
        colour: sRGB 0 .. 255.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    foot: NDArray[np.float64]
    axis: NDArray[np.float64]
    actuator: int
    spins: bool
    colour: tuple[int, int, int]

    def attitude(self, turned: float) -> NDArray[np.float64]:
        """Quaternion of the part after it has turned by an angle [rad]."""
        return np.array([math.cos(turned / 2), *(math.sin(turned / 2) * self.axis)])


@dataclass(frozen=True)
class HullPart:
    """Part of the hull that does not turn, of one colour."""

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    colour: tuple[int, int, int]


@dataclass(frozen=True)
class Model3d:
    """A vehicle in parts; `length` [m]."""

    still: Sequence[HullPart]
    turning: Sequence[Turning]
    length: float

    def turned(self, states: NDArray[np.float64], before: NDArray[np.float64], dt_s: float) -> NDArray[np.float64]:
        """`(parts,)` angles [rad] after a time, from the actuators' states."""
        out = np.array(before, dtype=np.float64)
        for i, part in enumerate(self.turning):
            state = float(states[part.actuator]) if part.actuator < len(states) else 0.0
            out[i] = (out[i] + _SLOWED * state * dt_s) % (2 * math.pi) if part.spins else state
        return out


def model_3d(vehicle: Vehicle) -> Model3d:
    """The parts of a vehicle, from its hull and its actuators."""
    config: Any = vehicle.config
    hull = config.hull
    names = tuple(vehicle.actuator_names)
    still: list[HullPart] = []
    turning: list[Turning] = []
    meshes = list(hull.meshes())
    fins = list(getattr(hull, "fins", ()))
    for number, mesh in enumerate(meshes):
        colour = colour_of(mesh.material or vehicle.materials[0])
        moved = None
        if fins and 1 <= number <= len(fins):
            moved = _fin(fins[number - 1], config.actuators, names)
        elif fins and number > len(fins):
            moved = _shaft(mesh.vertices, config.actuators, names)
        if moved is None:
            still.append(HullPart(mesh.vertices.astype(np.float32), mesh.faces, colour))
        else:
            foot, axis, actuator, spins = moved
            turning.append(
                Turning((mesh.vertices - foot).astype(np.float32), mesh.faces, foot, axis, actuator, spins, colour)
            )
    turning += _thrusters(config.actuators, names)
    points = np.concatenate([m.vertices for m in meshes])
    return Model3d(_joined(still), turning, float(np.ptp(points[:, 0])))


def colour_of(name: str) -> tuple[int, int, int]:
    """The colour of a material on a screen."""
    red, green, blue = np.round(255 * display(material(name).albedo)).astype(int)
    return int(red), int(green), int(blue)


def _joined(parts: Sequence[HullPart]) -> list[HullPart]:
    """Parts of one colour as one."""
    found = []
    for colour in dict.fromkeys(p.colour for p in parts):
        same = [p for p in parts if p.colour == colour]
        starts = np.cumsum([0] + [len(p.vertices) for p in same[:-1]])
        faces = np.concatenate([p.faces + np.uint32(s) for p, s in zip(same, starts, strict=True)])
        found.append(HullPart(np.concatenate([p.vertices for p in same]), faces, colour))
    return found


def _fin(shape: Any, actuators: Any, names: Sequence[str]) -> Any:
    """Foot, axis, actuator of a fin; None where no actuator moves it."""
    out = shape.outward
    for number, name in enumerate(names):
        config = actuators[name]
        if config.type != "fin":
            continue
        angle = math.radians(config.angle_deg)
        axis = np.array([0.0, -math.cos(angle), -math.sin(angle)])  # FRD angles in FLU
        if abs(float(axis @ out)) > math.cos(math.radians(20)) and abs(config.x_m - shape.x_m) < 0.5:
            return np.array([shape.x_m, 0.0, 0.0]), axis, number, False
    return None


def _shaft(vertices: NDArray[np.float64], actuators: Any, names: Sequence[str]) -> Any:
    for number, name in enumerate(names):
        if actuators[name].type in ("propeller", "thruster"):
            foot = np.array([float(vertices[:, 0].mean()), 0.0, 0.0])
            return foot, np.array([1.0, 0.0, 0.0]), number, True
    return None


def _thrusters(actuators: Any, names: Sequence[str]) -> list[Turning]:
    """Blades where thrusters stand on the hull; a shaft's own propeller is part of the hull."""
    made = []
    for number, name in enumerate(names):
        config = actuators[name]
        place, direction = getattr(config, "position_m", None), getattr(config, "direction", None)
        if place is None or direction is None:
            continue
        axis = flip_yz_np(np.asarray(direction, dtype=np.float64))
        axis = axis / np.linalg.norm(axis)
        vertices, faces = _blades(axis, 0.5 * float(getattr(config, "diameter_m", 0.1)))
        foot = flip_yz_np(np.asarray(place, dtype=np.float64))
        made.append(Turning(vertices, faces, foot, axis, number, True, (38, 42, 48)))
    return made


def _blades(axis: NDArray[np.float64], radius: float) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Twisted plates about an axis."""
    side = np.cross(axis, [0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    up = np.cross(axis, side)
    vertices: list[NDArray[np.float64]] = []
    faces: list[list[int]] = []
    for k in range(_BLADES):
        angle = 2 * math.pi * k / _BLADES
        out, round_ = math.cos(angle) * side + math.sin(angle) * up, -math.sin(angle) * side + math.cos(angle) * up
        chord = 0.35 * radius * (0.8 * round_ + 0.5 * axis)
        first = len(vertices)
        vertices += [
            0.1 * radius * out - chord / 2,
            0.1 * radius * out + chord / 2,
            radius * out + chord,
            radius * out - chord,
        ]
        faces += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return np.array(vertices, dtype=np.float32), np.array(faces, dtype=np.uint32)
