"""Cells of a sonar's image, beam by bin, with their ranges and gains."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import drjit as dr

from pelagos import jit
from pelagos.acoustics.spreading import time_varied_gain
from pelagos.jit import Array
from pelagos.sensors.sonar.ping.aperture import Facing
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.medium import Medium
from pelagos.sensors.sonar.ping.ping_spec import PingSpec


@jit.struct
class Cells:
    """Cells of an image, one lane each: a Dr.Jit struct.

    Attributes:
        ping, beam, bin: `Int32`.
        distance: `Float`, middle of the bin [m].
        raised: `Float`, intensity gain 30 log r + 2 a r.
        gain: `Float`, `raised` over the size of what a sample hears: from intensity re the
            source level at 1 m to the strength of an even bottom.
        heard: `Float`, see `Constants`.
    """

    ping: Array
    beam: Array
    bin: Array
    distance: Array
    raised: Array
    gain: Array
    heard: Array | None = None


@jit.struct
class Constants:
    """Constants of a ping: a Dr.Jit struct.

    Attributes:
        steering, pulse: weights, see `amplitude_weights` and `spread_pulse`.
        noise: power, see `noise_power`.
        seed: of the roughness.
        order: see `Walk`.
        facing: see `Facing`.
        elements: of the receive array; None where their signals are not given.
        boost: by beam, over a point's energy in the field that which a sample and a beam hear of it as a whole.
        cell: what levels are calibrated to, sector times bin width [rad m].
        heard: by beam, over the energy of a cell that of an even bottom in what a sample hears: the equivalent width of
            the beam and of the pulse over those of the cell.
    """

    steering: Array
    pulse: Array
    noise: Array
    seed: Array
    order: Array
    cell: Array
    heard: Array
    facing: Facing
    boost: Array
    elements: Any = None


def middle(spec: PingSpec, bin_: Array) -> Array:
    """Middle of a range bin [m]."""
    return spec.range_min_m + (jit.Float(bin_) + 0.5) * spec.bin_width_m


def cell_of(layout: Layout, spec: PingSpec, cells: Cells) -> Array:
    """Row of cells in a table of pings by beams by bins."""
    bin_ = dr.clip(cells.bin, 0, spec.bins - 1)
    return jit.UInt32((cells.ping * layout.beams + cells.beam) * spec.bins + bin_)


def cells_at(spec: PingSpec, medium: Medium, constants: Constants, ping: Array, beam: Array, bin_: Array) -> Cells:
    """Cells with their ranges and gains."""
    distance = middle(spec, bin_)
    loss = dr.gather(jit.Float, medium.absorption, jit.UInt32(ping))
    raised = time_varied_gain(distance, loss, spreading=30.0)
    return cells_of_beam(Cells(ping, beam, bin_, distance, raised, raised), constants, beam)


def cells_of_beam(cells: Cells, constants: Constants, beam: Array) -> Cells:
    """The same cells of another beam."""
    row = dr.minimum(jit.UInt32(beam), dr.width(constants.heard) - 1)
    heard = dr.gather(jit.Float, constants.heard, row)
    size = heard * constants.cell
    return replace(cells, beam=beam, heard=heard, gain=cells.raised / size)
