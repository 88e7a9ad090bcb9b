"""Pressure of the water on the mesh of what floats, one vertex after the other and then one triangle after the other.

A lane is a vehicle: it goes through its whole mesh by itself, and keeps what it finds at the vertices in local memory,
because each of them is a corner of about six triangles.
"""

from __future__ import annotations

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.hydro.algebra import Matrix, matvec
from pelagos.hydro.wetted_hull import wetted_load
from pelagos.jit import Array
from pelagos.ocean.hull_waves import HullWaves


@jit.struct
class HullTable:
    """A closed mesh, and tables of what else pushes it.

    Attributes:
        places: `Float64`, by vertex (x, y, z), FRD [m].
        corners: `UInt32`, by triangle its three vertices.
        vertices, triangles: `UInt32` (1), how many.
        drift, diffraction: see `Drift` and `Diffraction`.
    """

    places: Array
    corners: Array
    vertices: Array
    triangles: Array
    drift: Array
    diffraction: Array


def hull_table(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], *, drift: Array, diffraction: Array
) -> HullTable:
    """A mesh, `(v, 3)` FRD [m] and `(f, 3)`, on the device."""
    table = HullTable(
        places=jit.Float64(np.ascontiguousarray(vertices, dtype=np.float64).ravel()),
        corners=jit.UInt32(faces.astype(np.uint32).ravel()),
        vertices=jit.UInt32(len(vertices)),
        triangles=jit.UInt32(len(faces)),
        drift=drift,
        diffraction=diffraction,
    )
    jit.align(table)
    return table


class StillWater:
    """The surface and the pressure where there are no waves; stands for `HullWaves`."""

    def at(self, forward: Array, starboard: Array, depth: Array) -> tuple[Array, Array]:
        """See `HullWaves.at`."""
        nothing = 0 * (forward + starboard + depth)
        return nothing, nothing


def hull_pressure(
    waves: HullWaves | StillWater, table: HullTable, level: Matrix, depth: Array, active: Array | None = None
) -> tuple[list[Array], list[Array]]:
    """Force and moment about the origin (3) per rho g, body axes [m^3], [m^4].

    Args:
        waves: at the hull.
        table: of the hull.
        level: `(3, 3)`, body axes to axes along the heading.
        depth: of the origin below the level of still water [m].
        active: lanes to compute, the others give nothing; None: all.
    """
    vertices, triangles = (
        n if active is None else dr.select(active, n, jit.UInt32(0)) for n in (table.vertices, table.triangles)
    )
    count = dr.width(table.places) // 3

    def meet(i: Array, immersion: Array, head: Array) -> tuple[Array, ...]:
        x, y, z = matvec(level, [*dr.gather(jit.Array3f64, table.places, i)])
        below = depth + z
        surface, dynamic = waves.at(x, y, below)
        immersion[i] = below + surface
        head[i] = dr.select(below > 0, below + dynamic, below + surface)
        return i + 1, immersion, head

    start = (jit.UInt32(0), *(dr.alloc_local(jit.Float64, count) for _ in range(2)))
    _, immersion, head = dr.while_loop(start, lambda i, *_: i < vertices, meet, mode="symbolic")

    def push(i: Array, immersion: Array, head: Array, *sums: Array) -> tuple[Array, ...]:
        at = dr.gather(jit.Array3u, table.corners, i)
        a, b, c = (dr.gather(jit.Array3f64, table.places, at[k]) for k in range(3))
        load = wetted_load((a, b, c), tuple(immersion[at[k]] for k in range(3)), tuple(head[at[k]] for k in range(3)))
        return i + 1, immersion, head, *(s + v for s, v in zip(sums, [*load.force, *load.moment], strict=True))

    nothing = 0 * depth
    state = (jit.UInt32(0), immersion, head, *([nothing] * 6))
    found = dr.while_loop(state, lambda i, *_: i < triangles, push, mode="symbolic")[3:]
    return list(found[:3]), list(found[3:])
