"""Linear and quadratic damping."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pelagos.hydro import damping, frame
from pelagos.hydro.algebra import Matrix, Vector, is_zero, mul
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, PartConfig, Positive, Six, Three, numbers


class LinearDampingConfig(PartConfig):
    """-D nu_r, D as published."""

    type: Literal["linear_damping"]
    diagonal: Six
    """Positive: -Xu, -Yv, -Zw [kg/s], -Kp, -Mq, -Nr [kg m^2/s]."""
    off_diagonal: dict[str, float] = Field(default_factory=dict)
    """Further entries of D by row and column from 1, such as "26" [kg m/s]."""
    low_speed_decay_s_m: NonNegative = 0.0
    """Surge and sway damping fade with exp(-decay U_r) [s/m]."""

    def build(self, body: Body) -> LinearDamping:
        """The term."""
        matrix = np.diag(np.array(self.diagonal, dtype=np.float64))
        for place, value in self.off_diagonal.items():
            matrix[int(place[0]) - 1, int(place[1]) - 1] = value
        return LinearDamping(numbers(matrix), self.low_speed_decay_s_m)


class TimeConstantDampingConfig(PartConfig):
    """Linear damping from time constants and damping ratios, as Fossen's programs for the REMUS 100 and the torpedo."""

    type: Literal["time_constant_damping"]
    surge_s: Positive
    """[s]"""
    sway_s: Positive
    """[s]"""
    heave_s: Positive
    """[s]"""
    roll_ratio: NonNegative
    """[-]"""
    pitch_ratio: NonNegative
    """[-]"""
    yaw_s: Positive
    """[s]"""
    low_speed_decay_s_m: NonNegative = 0.0
    """Surge and sway damping fade with exp(-decay U_r) [s/m]."""

    def build(self, body: Body) -> LinearDamping:
        """The term; natural frequencies of roll and pitch follow from weight, metacentric height and M."""
        m = np.diag(body.mass_matrix)
        frequency = np.sqrt(body.weight * body.metacentric_height / m[3:5])
        diagonal = [
            m[0] / self.surge_s,
            m[1] / self.sway_s,
            m[2] / self.heave_s,
            2 * self.roll_ratio * frequency[0] * m[3],
            2 * self.pitch_ratio * frequency[1] * m[4],
            m[5] / self.yaw_s,
        ]
        return LinearDamping(numbers(np.diag(diagonal)), self.low_speed_decay_s_m)


@dataclass(frozen=True)
class LinearDamping:
    """matrix: D `(6, 6)`; decay: [s/m]."""

    matrix: Matrix
    decay: Array

    def wrench(self, flow: Flow) -> Vector:
        """-D nu_r (6)."""
        load = damping.linear_damping(self.matrix, flow.nu_r)
        if is_zero(self.decay):
            return load
        fade = damping.low_speed_fade(self.decay, flow.nu_r)
        return [mul(fade, load[0]), mul(fade, load[1]), *load[2:]]


class QuadraticDampingConfig(PartConfig):
    """-d |nu_r| nu_r on each axis, or by the speed of the flow from any side."""

    type: Literal["quadratic_damping"]
    diagonal: Six
    """Positive: -X|u|u, -Y|v|v, -Z|w|w [kg/m], -K|p|p, -M|q|q, -N|r|r [kg m^2]."""
    oblique: Literal["axes", "frame"] = "axes"
    """In a flow that is along no axis each axis by itself, or as an open frame of small members has it, each by the
    speed of the flow that it meets. Along one axis, and on turning alone, both are the diagonal."""
    size_m: tuple[Positive, Positive, Positive] | None = None
    """Of the frame: length, beam and height [m]; left out: the hull's."""
    center_m: Three = (0.0, 0.0, 0.0)
    """Of the frame's drag, FRD from the origin [m]."""

    @model_validator(mode="after")
    def _used(self) -> Self:
        if self.oblique == "axes" and (self.size_m is not None or any(self.center_m)):
            raise ValueError("size_m and center_m are those of a frame: give oblique: frame")
        if self.oblique == "frame" and min(self.diagonal) < 0:
            raise ValueError(f"diagonal: a frame's drag is 0 or more on each axis, not {min(self.diagonal):g}")
        return self

    def build(self, body: Body) -> QuadraticDamping | FrameDrag:
        """The term."""
        if self.oblique == "axes":
            return QuadraticDamping(list(self.diagonal))
        size = self.size_m or (body.length, body.beam, body.height)
        places, rest = frame.frame_places(self.diagonal[:3], self.diagonal[3:], size)
        return FrameDrag(list(self.diagonal[:3]), rest, places, list(self.center_m))


@dataclass(frozen=True)
class QuadraticDamping:
    """diagonal: (6)."""

    diagonal: Vector

    def wrench(self, flow: Flow) -> Vector:
        """-d |nu_r| nu_r (6)."""
        return damping.quadratic_damping(self.diagonal, flow.nu_r)


class CubicDampingConfig(PartConfig):
    """-d nu^3 on each axis, as series of towing tests have it beside linear and quadratic damping."""

    type: Literal["cubic_damping"]
    diagonal: Six
    """Positive: -Xuuu, -Yvvv, -Zwww [kg s/m^2], -Kppp, -Mqqq, -Nrrr [kg m^2 s]."""

    def build(self, body: Body) -> CubicDamping:
        """The term."""
        return CubicDamping(list(self.diagonal))


@dataclass(frozen=True)
class CubicDamping:
    """diagonal: (6)."""

    diagonal: Vector

    def wrench(self, flow: Flow) -> Vector:
        """-d nu_r^3 (6)."""
        return [mul(-1.0, mul(d, v * v * v)) for d, v in zip(self.diagonal, flow.nu_r, strict=True)]


@dataclass(frozen=True)
class FrameDrag:
    """quadratic (3) [kg/m], rest (3) [kg m^2], places `(6, 3)`, center (3) [m]: see `hydro.frame.frame_drag`."""

    quadratic: Vector
    rest: Vector
    places: Matrix
    center: Vector

    def wrench(self, flow: Flow) -> Vector:
        """Drag (6)."""
        return frame.frame_drag(self.quadratic, self.rest, self.places, self.center, flow.nu_r)
