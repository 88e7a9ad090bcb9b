"""Clumps of what drifts in the water: few scatterers in a resolution cell, which go with the current."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.acoustics.gamma_texture import gamma_table, gamma_texture
from pelagos.acoustics.speckle import facet_word, lattice_word, scramble
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32
from pelagos.math.so3 import rotate
from pelagos.sensors.sonar.ping.aperture import Facing
from pelagos.sensors.sonar.ping.fan import Lanes
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.medium import spread
from pelagos.sensors.sonar.ping.ping_spec import PingSpec

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

_SECOND: Final = 0x5BD1E995


@dataclass(frozen=True)
class Adrift:
    """Scatterers of an ocean at times t [s], by lane."""

    crowd: Crowd
    ocean: Ocean
    t: Array


@jit.struct
class Crowd:
    """Scatterers that a sample hears, a Dr.Jit struct.

    Attributes:
        count: `Float` by beam, in a resolution cell at 1 m: it grows with the square of the range.
        table: see `gamma_table`.
    """

    count: Array
    table: Array


@jit.struct
class Clumps:
    """A lattice of drifting cells as deep as the pulse resolves, a Dr.Jit struct.

    Attributes:
        word: `UInt32` by ping, of the cell that the sonar is in.
        inside: `Array3f` by ping, its place in that cell [cells].
        direction: `Array3f` by ping and beam, world frame [cells/m].
        crowd: see `Crowd`.
    """

    word: Array
    inside: Array
    direction: Array
    crowd: Crowd


def crowd(spec: PingSpec, layout: Layout) -> Crowd | None:
    """Scatterers of a sonar's cells: beam width by fan height by depth of the pulse; None where there are many."""
    if spec.volume_scatterers is None:
        return None
    cell = layout.heard_parts * (layout.sector * layout.vertical_width * spec.equivalent_m)
    made = Crowd(jit.Float((cell * spec.volume_scatterers).astype(np.float32)), jit.Float(gamma_table()))
    jit.align(made)
    return made


def clumps(spec: PingSpec, layout: Layout, lanes: Lanes, facing: Facing, adrift: Adrift) -> Clumps:
    """The lattice by lane, as it has gone with the current at the sonar since t = 0."""
    beams, size, t = layout.beams, spec.equivalent_m, adrift.t
    place = lanes.position - adrift.ocean.current(lanes.position, t, lanes.copy) * t
    cells = place * (1.0 / size)
    whole = dr.floor(cells)
    row = dr.arange(jit.UInt32, dr.width(lanes.position) * beams)
    axis = dr.gather(jit.Array3f, facing.axis, row % beams)
    direction = rotate(spread(jit.Array4f(lanes.attitude), row // beams), axis) * (1.0 / size)
    word = lattice_word(whole, jit.UInt32(spec.roughness_seed) ^ _SECOND)
    made = Clumps(word, jit.Array3f(cells - whole), direction, adrift.crowd)
    dr.eval(made.word, made.inside, made.direction)
    return made


def clumped(found: Clumps, ping: Array, beam: Array, distance: Array, beams: int) -> Array:
    """Factor on the mean intensity of the water's echo, of mean one; `ping` and `beam` `Int32`."""
    lane, near = jit.UInt32(ping), jit.UInt32(dr.minimum(beam, beams - 1))
    way = dr.gather(jit.Array3f, found.direction, lane * beams + near) * distance
    cell = dr.floor(dr.gather(jit.Array3f, found.inside, lane) + way)
    word = facet_word(dr.gather(jit.UInt32, found.word, lane), cell)
    score = normal_pair32(word, scramble(word ^ _SECOND))[0]
    shape = dr.gather(jit.Float, found.crowd.count, near) * dr.square(distance)
    return gamma_texture(found.crowd.table, shape, score)
