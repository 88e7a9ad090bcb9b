"""Scripted paths: where a moving body is at a time, and how it moves. Functions of simulation time and nothing else."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Final, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, model_validator

from pelagos.config.described import Described

Vector: TypeAlias = NDArray[np.float64]

_MODEL: Final = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
_PER_LEG: Final = 24  # points of the table of a curve, between two way-points


@dataclass(frozen=True)
class PathPose:
    """Pose of a body, and its motion.

    Attributes:
        position: `(3,)` world NWU [m].
        attitude: `(4,)` (w, x, y, z), body FLU to world.
        velocity: `(3,)` of its origin, world frame [m/s].
        angular_velocity: `(3,)` world frame [rad/s].
    """

    position: Vector
    attitude: Vector
    velocity: Vector
    angular_velocity: Vector


class CirclePath(Described):
    """Round and round a place at constant speed, bow ahead."""

    model_config = _MODEL

    kind: Literal["circle"] = "circle"
    """The kind of path."""
    centre_m: tuple[float, float, float]
    """Middle x, y and height z of the circle [m]."""
    radius_m: float = Field(gt=0)
    """Radius [m]."""
    speed_mps: float = Field(gt=0)
    """Speed along the circle [m/s]."""
    phase_deg: float = 0.0
    """Where it is at time 0, from x towards y [deg]."""
    clockwise: bool = False
    """Whether it turns to starboard, seen from above."""

    @property
    def fastest_mps(self) -> float:
        """No point of the path is passed faster [m/s]."""
        return self.speed_mps

    def pose(self, t: float) -> PathPose:
        """The pose at time t [s]."""
        sense = -1.0 if self.clockwise else 1.0
        rate = sense * self.speed_mps / self.radius_m
        angle = math.radians(self.phase_deg) + rate * t
        c, s = math.cos(angle), math.sin(angle)
        position = np.array(self.centre_m) + self.radius_m * np.array([c, s, 0.0])
        velocity = self.speed_mps * sense * np.array([-s, c, 0.0])
        return PathPose(position, _yawed(angle + sense * math.pi / 2), velocity, np.array([0.0, 0.0, rate]))


class WaypointPath(Described):
    """A smooth curve through points at constant speed, bow ahead, upright: ships that pass, schools that travel."""

    model_config = _MODEL

    kind: Literal["waypoints"] = "waypoints"
    """The kind of path."""
    points_m: tuple[tuple[float, float, float], ...] = Field(min_length=2)
    """Points x, y, z [m] that the curve runs through."""
    speed_mps: float = Field(gt=0)
    """Speed along the curve [m/s]."""
    start_s: float = 0.0
    """Time at which it leaves the first point [s]; it waits there until then."""
    at_end: Literal["stop", "again", "loop"] = "stop"
    """At the last point: stop there, begin again at the first point, or close the curve and go round."""

    @model_validator(mode="after")
    def _moves(self) -> Self:
        ends = np.array(self.points_m)
        if (np.linalg.norm(np.diff(ends, axis=0), axis=1) < 1e-6).any():
            raise ValueError("two points that follow each other are the same")
        if self.at_end == "loop" and (len(ends) < 3 or np.linalg.norm(ends[0] - ends[-1]) < 1e-6):
            raise ValueError("a loop needs three points or more, the first not given again at the end")
        return self

    @property
    def fastest_mps(self) -> float:
        """No point of the path is passed faster [m/s]."""
        return self.speed_mps

    @cached_property
    def _table(self) -> tuple[Vector, Vector, Vector]:
        """Way along the curve `(k,)` [m], points `(k, 3)` [m] and headings `(k,)`, unwrapped [rad]."""
        from scipy.interpolate import CubicSpline

        ends = np.array([*self.points_m, *(self.points_m[:1] if self.at_end == "loop" else ())])
        chord = np.concatenate([[0.0], np.cumsum(np.sqrt(np.linalg.norm(np.diff(ends, axis=0), axis=1)))])
        curve = CubicSpline(chord, ends, bc_type="periodic" if self.at_end == "loop" else "natural")
        at = np.interp(
            np.linspace(0, len(ends) - 1, _PER_LEG * (len(ends) - 1) + 1), np.arange(len(ends), dtype=np.float64), chord
        )
        points, tangent = curve(at), curve(at, 1)
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        return along, points, np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))

    def pose(self, t: float) -> PathPose:
        """The pose at time t [s]."""
        along, points, heading = self._table
        way = self.speed_mps * (t - self.start_s)
        moving = way >= 0 and (self.at_end != "stop" or way < along[-1])
        way = way % along[-1] if self.at_end != "stop" and way >= 0 else min(max(way, 0.0), float(along[-1]))
        k = min(int(np.searchsorted(along, way, side="right")) - 1, len(along) - 2)
        share = (way - along[k]) / (along[k + 1] - along[k])
        position = points[k] + share * (points[k + 1] - points[k])
        yaw = heading[k] + share * (heading[k + 1] - heading[k])
        rate = self.speed_mps / (along[k + 1] - along[k]) if moving else 0.0
        spin = np.array([0.0, 0.0, rate * (heading[k + 1] - heading[k])])
        return PathPose(position, _yawed(float(yaw)), rate * (points[k + 1] - points[k]), spin)


class SwingPath(Described):
    """To and fro about a level axis through a place, like a pendulum: chains, hoses, buoys on their moorings."""

    model_config = _MODEL

    kind: Literal["swing"] = "swing"
    """The kind of path."""
    at_m: tuple[float, float, float]
    """Place of the body's origin, which does not move [m]."""
    amplitude_deg: float = Field(gt=0, le=90)
    """Greatest angle from upright [deg]."""
    period_s: float = Field(gt=0)
    """Time of a swing to and fro [s]."""
    towards_deg: float = 0.0
    """Heading of the plane that it swings in, from x towards y [deg]."""
    phase_deg: float = 0.0
    """Phase at time 0, where 0 is upright [deg]."""

    @property
    def fastest_mps(self) -> float:
        """The origin stays; the sphere about it holds every position of the body [m/s]."""
        return 0.0

    def pose(self, t: float) -> PathPose:
        """The pose at time t [s]."""
        turn = 2 * math.pi / self.period_s
        phase = turn * t + math.radians(self.phase_deg)
        most = math.radians(self.amplitude_deg)
        angle, rate = most * math.sin(phase), most * turn * math.cos(phase)
        towards = math.radians(self.towards_deg)
        axis = np.array([-math.sin(towards), math.cos(towards), 0.0])  # leans the upper end towards the heading
        attitude = np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)])
        return PathPose(np.array(self.at_m), attitude, np.zeros(3), rate * axis)


class WanderPath(Described):
    """To and fro about a place without a repetition, bow ahead: fish that stay about a wreck."""

    model_config = _MODEL

    kind: Literal["wander"] = "wander"
    """The kind of path."""
    at_m: tuple[float, float, float]
    """Middle x, y, z [m]."""
    reach_m: tuple[float, float, float] = (5.0, 5.0, 1.0)
    """It stays within this distance of the middle along x, y, z [m]."""
    period_s: float = Field(default=40.0, gt=0)
    """Time of the slowest turn about the middle [s]."""
    seed: int = Field(default=0, ge=0)
    """Seed of its phases."""

    @cached_property
    def _waves(self) -> tuple[Vector, Vector, Vector]:
        """Amplitude, angular rate, phase, each `(3, 3)` (axis, wave)."""
        rng = np.random.Generator(np.random.PCG64(self.seed))
        share = np.array([0.6, 0.28, 0.12])
        rate = 2 * np.pi / self.period_s * np.array([1.0, 1.9, 3.3]) * rng.uniform(0.9, 1.1, (3, 3))
        return np.array(self.reach_m)[:, None] * share, rate, rng.uniform(0, 2 * np.pi, (3, 3))

    @property
    def fastest_mps(self) -> float:
        """No point of the path is passed faster [m/s]."""
        amplitude, rate, _ = self._waves
        return float(np.linalg.norm((amplitude * rate).sum(axis=1)))

    def pose(self, t: float) -> PathPose:
        """The pose at time t [s]."""
        amplitude, rate, phase = self._waves
        angle = rate * t + phase
        offset = (amplitude * np.sin(angle)).sum(axis=1)
        velocity = (amplitude * rate * np.cos(angle)).sum(axis=1)
        gain = -(amplitude * rate**2 * np.sin(angle)).sum(axis=1)
        level = max(float(velocity[0] ** 2 + velocity[1] ** 2), 1e-6)
        spin = float(velocity[0] * gain[1] - velocity[1] * gain[0]) / level
        yaw = math.atan2(velocity[1], velocity[0])
        return PathPose(np.array(self.at_m) + offset, _yawed(yaw), velocity, np.array([0.0, 0.0, spin]))


PathConfig: TypeAlias = Annotated[CirclePath | WaypointPath | SwingPath | WanderPath, Field(discriminator="kind")]
"""Any path."""


def _yawed(angle: float) -> Vector:
    return np.array([math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)])
