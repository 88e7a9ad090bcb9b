"""Contact of a hull with whatever stands or moves around it, by short rays from its spine to its skin.

A ray that hits before it reaches the skin tells how deep, and which way out. The force is a damped spring along the
surface's normal and Coulomb friction across it. Stiffness and damping follow the mass that a probe feels and the time
step, so that contact is as hard as an explicit step can carry, and never explodes:

    spring k <= KAPPA m / h^2,   damper c <= 2 ZETA sqrt(k m),   friction <= SLIP m |v_t| / h

with m = 1 / (n^T J M^-1 J^T n), the effective mass at the probe (Featherstone, Rigid Body Dynamics Algorithms, 2008,
Section 11.7), and all three shared out among the probes that touch. Soft ground hardens towards that limit as the spine
comes near, so that nothing sinks through it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import rotate, rotate_back
from pelagos.raycast.caster import cast
from pelagos.raycast.rays import Rays
from pelagos.raycast.scene import Tables

KAPPA: Final = 0.2  # stable below 4 without damping (semi-implicit Euler)
ZETA: Final = 0.5
SLIP: Final = 0.3  # share of the sliding momentum that friction may take in one step
FULL_AT: Final = 0.002  # [m], depth from which a probe counts fully among those that touch
CREEP: Final = 0.01  # [m/s], sliding slower than this meets less than the whole friction
VALUES: Final = 7  # weight, force (3), moment (3) of one probe


@dataclass
class HullProbes:
    """The probes of one kind of hull, a Dr.Jit struct with a lane a probe.

    Attributes:
        start: `Array3f64`, on the spine, body FLU [m].
        vector: `Array3f64`, from there to the skin [m].
        mass: `Float64`, effective mass along the probe [kg].
    """

    start: Array
    vector: Array
    mass: Array


def hull_probes(
    starts: NDArray[np.float64], vectors: NDArray[np.float64], mass_matrix: NDArray[np.float64]
) -> HullProbes:
    """Probes on the device: `(p, 3)` starts and vectors, body FLU [m]; `(6, 6)` mass and added mass, body FLU."""
    inverse = np.linalg.inv(mass_matrix)
    along = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    row = np.concatenate([along, np.cross(starts + vectors, along)], axis=1)
    mass = 1.0 / np.einsum("pi,ij,pj->p", row, inverse, row)
    found = HullProbes(
        jit.Array3f64(np.ascontiguousarray(starts.T)),
        jit.Array3f64(np.ascontiguousarray(vectors.T)),
        jit.Float64(mass),
    )
    dr.make_opaque(found)
    return found


def probe_wrench(
    static: Any,
    moving: Any,
    tables: Tables,
    materials: Any,
    probes: HullProbes,
    *,
    position: Array,
    attitude: Array,
    velocity: Array,
    angular_velocity: Array,
    own: Array,
    copy: Array,
    h: Array,
) -> tuple[Array, Array]:
    """Force [N] and moment about the body's origin [N m] on `n` hulls, body FLU, `Array3f64`.

    Args:
        static, moving, tables: where rays are cast, see `raycast.cast`.
        materials: table with `friction`, `stiffness`, `damping` by material row.
        probes: of the hull.
        position, attitude: `Array3f64` NWU, `Array4f64` FLU to NWU, `n` lanes.
        velocity, angular_velocity: `Array3f64`, body FLU.
        own, copy: `UInt32`, see `Rays`.
        h: the time step [s], `Float64`.
    """
    n, p = dr.width(copy), dr.width(probes.mass)
    lane = dr.arange(jit.UInt32, n * p)
    hull, probe = lane // p, lane % p
    q = dr.gather(jit.Array4f64, attitude, hull)
    start, vector = dr.gather(jit.Array3f64, probes.start, probe), dr.gather(jit.Array3f64, probes.vector, probe)
    length = dr.norm(vector)
    rays = Rays(
        origin=dr.gather(jit.Array3f64, position, hull) + rotate(q, start),
        direction=jit.Array3f(rotate(q, vector / length)),
        max_range=jit.Float(length),
        copy=dr.gather(jit.UInt32, copy, hull),
        own=dr.gather(jit.UInt32, own, hull),
    )
    hits = cast(static, moving, tables, rays)
    point = start + vector
    out = dr.gather(jit.Array3f64, velocity, hull)
    out += dr.cross(dr.gather(jit.Array3f64, angular_velocity, hull), point)
    slip = rotate(q, out) - jit.Array3f64(hits.velocity)
    depth = dr.maximum(length - jit.Float64(hits.t), 0.0)
    mass = dr.gather(jit.Float64, probes.mass, probe)
    push = _push(hits, materials, depth, length, slip, mass, h)
    weight = dr.select(hits.valid, dr.minimum(depth / FULL_AT, 1.0), 0.0)
    force = rotate_back(q, dr.select(hits.valid, weight * push, 0.0))
    return _gathered(weight, force, dr.cross(point, force), n=n, p=p)


def _push(hits: Any, materials: Any, depth: Array, length: Array, slip: Array, mass: Array, h: Array) -> Array:
    """What one probe would feel if it touched alone, world NWU [N]."""
    f64 = jit.Float64

    def of(column: Array) -> Array:
        return f64(dr.gather(jit.Float, column, hits.material, hits.valid))

    hardest = KAPPA * mass / (h * h)
    softness = dr.minimum(of(materials.stiffness), hardest)
    stiffness = softness + (hardest - softness) * (depth / length) ** 2
    damping = dr.minimum(of(materials.damping), 2 * ZETA * dr.sqrt(stiffness * mass))
    normal = jit.Array3f64(hits.normal)
    leaving = dr.dot(slip, normal)
    press = dr.maximum(stiffness * depth - damping * leaving, 0.0)
    across = slip - leaving * normal
    grip = dr.minimum(of(materials.friction) * press / (dr.norm(across) + CREEP), SLIP * mass / h)
    return press * normal - grip * across


def _gathered(weight: Array, force: Array, moment: Array, *, n: int, p: int) -> tuple[Array, Array]:
    """Sums over the probes of each hull, in their order: the same bytes on any number of threads."""
    packed = dr.zeros(jit.Float64, n * p * VALUES)
    at = dr.arange(jit.UInt32, n * p) * VALUES
    for k, value in enumerate((weight, *force, *moment)):
        dr.scatter(packed, value, at + k)
    dr.eval(packed)
    first = dr.arange(jit.UInt32, n) * (p * VALUES)

    def more(i: Array, *sums: Array) -> Any:
        return i < p

    def add(i: Array, *sums: Array) -> tuple[Array, ...]:
        row = first + i * VALUES
        return i + 1, *(s + dr.gather(jit.Float64, packed, row + k) for k, s in enumerate(sums))

    start = (dr.zeros(jit.UInt32, n), *(dr.zeros(jit.Float64, n) for _ in range(VALUES)))
    _, touching, *sums = dr.while_loop(start, more, add, mode="symbolic")
    share = 1 / dr.maximum(touching, 1.0)
    return jit.Array3f64(sums[0:3]) * share, jit.Array3f64(sums[3:6]) * share
