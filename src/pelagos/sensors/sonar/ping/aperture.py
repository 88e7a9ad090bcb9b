"""Apertures of a sonar's beams in any direction: for echoes from other directions than rays were cast into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.beam_pattern import line, line_length, shaded_line
from pelagos.acoustics.element_array import ElementLine
from pelagos.jit import Array

BEHIND: Final = 1e-3  # of what would be heard in front, one way, behind an array's baffle; assumed


@jit.struct
class Facing:
    """Directions of beams, one row a beam, in the sensor frame: a Dr.Jit struct.

    Attributes:
        axis, side, up: `Array3f`, unit vectors: of the beam, along both edges of its aperture.
    """

    axis: Array
    side: Array
    up: Array


@dataclass(frozen=True)
class Aperture:
    """The patterns of a sonar's beams.

    Attributes:
        axis, side, up: `(beams, 3)`, see `Facing`.
        side_length, up_length: of the edges [wavelengths].
        shading: of the array along `side`.
        steered: the receiver alone has the pattern along `side`, an array whose beams are steered; else both ways have.
        round: beams are cones, as wide any way as along `up`.
        ways: 2 where transmitter and receiver have the pattern along `up`, 1 where one of them is wide.
        floor: one-way power where the ideal pattern along `up` has nulls and beyond.
        transmit: the elements along `up` that send, where they have errors; None: they have none.
    """

    axis: NDArray[np.float64]
    side: NDArray[np.float64]
    up: NDArray[np.float64]
    side_length: float
    up_length: float
    shading: str = "uniform"
    steered: bool = False
    round: bool = False
    ways: int = 2
    floor: float = 0.0
    transmit: ElementLine | None = None

    def __post_init__(self) -> None:
        frames = np.stack(np.broadcast_arrays(self.axis, self.side, self.up), axis=-2)  # (beams, 3, 3)
        off = np.abs(frames @ frames.swapaxes(-1, -2) - np.eye(3))
        if self.steered:  # the array's edge stays where it is
            off[..., 0, 1] = off[..., 1, 0] = 0.0
        assert (off < 1e-6).all(), "unit vectors at right angles"

    def facing(self) -> Facing:
        """Directions on the device."""
        vectors = (np.broadcast_to(v, self.axis.shape).T for v in (self.axis, self.side, self.up))
        return Facing(*(jit.Array3f(np.ascontiguousarray(v, dtype=np.float32)) for v in vectors))

    def one_way_up(self, facing: Facing, beam: Array, direction: Array) -> Array:
        """One-way power pattern along `up`, all round where beams are cones, at directions in the sensor frame.

        Without a floor it is the same before and behind; the baffle is not in it.
        """
        axis, _, up = (dr.gather(jit.Array3f, v, beam) for v in (facing.axis, facing.side, facing.up))
        ahead = dr.dot(axis, direction)
        sine = dr.sqrt(dr.maximum(1.0 - ahead * ahead, 0.0)) if self.round else dr.dot(up, direction)
        power = dr.square(line(sine, self.up_length))
        if self.floor > 0.0:
            return dr.select(ahead > 0.0, power + self.floor, self.floor) * (1.0 / (1.0 + self.floor))
        return power

    def all_ways_up(self, facing: Facing, beam: Array, direction: Array) -> Array:
        """Power pattern along `up` of all `ways` together, see `one_way_up`."""
        power = self.one_way_up(facing, beam, direction)
        if self.transmit is None:
            return power**self.ways
        line, sine = self.transmit, dr.dot(dr.gather(jit.Array3f, facing.up, beam), direction)
        channels = np.ones(line.count) if line.channels is None else line.channels
        real, imaginary = jit.Float(0), jit.Float(0)
        for place, factor in zip(line.places.tolist(), (line.weights * channels).tolist(), strict=True):
            s, c = dr.sincos(2.0 * dr.pi * place * sine)
            real, imaginary = real + factor.real * c - factor.imag * s, imaginary + factor.real * s + factor.imag * c
        return power * (dr.square(real) + dr.square(imaginary))

    def side_amplitude(self, facing: Facing, beam: Array, direction: Array) -> Array:
        """Amplitude pattern along `side`, both ways together, at directions in the sensor frame."""
        if self.round:
            return jit.Float(1)
        axis, side = (dr.gather(jit.Array3f, v, beam) for v in (facing.axis, facing.side))
        offset = dr.dot(side, direction - axis)
        pattern = shaded_line(offset, self.side_length, self.shading)
        return pattern if self.steered else pattern * dr.abs(pattern)


Row = NDArray[np.float64]


def one_beam(axis: Sequence[float], side: Sequence[float], up: Sequence[float]) -> tuple[Row, Row, Row]:
    """The vectors of a single beam as rows."""
    return np.array([axis], dtype=np.float64), np.array([side], dtype=np.float64), np.array([up], dtype=np.float64)


def round_aperture(axes: NDArray[np.float64], width: float) -> Aperture:
    """Cones of a half-power width [rad] about axes `(beams, 3)`, both ways."""
    least = np.eye(3)[np.abs(axes).argmin(axis=-1)]
    side = np.cross(least, axes)
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    length = line_length(width)
    return Aperture(axes, side, np.cross(axes, side), length, length, round=True)
