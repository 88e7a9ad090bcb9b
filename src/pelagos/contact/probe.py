"""Contact of a hull with everything that rays can hit: seabed, walls, piles, other bodies.

Probes are short rays from the hull's inside to points of its surface. A probe that meets something before its end is
pushed back: a spring and a damper along the surface's normal, and Coulomb friction across it. Springs as stiff as stone
on a light vehicle would make an explicit step explode, so the wrench is that of the *end* of the step: contact forces
are linear in the velocity after the step, which leaves one symmetric 6 x 6 system for each vehicle (linearly implicit
Euler; D. Baraff and A. Witkin, "Large steps in cloth simulation", SIGGRAPH 1998, Eqs. 4-6, doi 10.1145/280814.280821,
applied to a rigid body). It is stable for any stiffness, mass and step; of a spring k on a mass m it leaves
k / (1 + h^2 k / m).

Friction is Coulomb's at the end of the step: a contact sticks, at a speed that nobody sees, where that takes no more
than the coefficient times the normal force, and slides against that force where it takes more. Handed the velocity
that the vehicle would have after the step without contact, a hull at rest on a slope stays where it is.

Rays look ahead by the way of one step and a half, so that contact begins before the surface is passed. What is thinner
than the gaps between probes (a wire, a rail) can come between them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final, NamedTuple

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.contact.solve import solve_symmetric
from pelagos.jit import Array
from pelagos.math.so3 import rotate, rotate_back
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Rays

if TYPE_CHECKING:
    from pelagos.world.material import MaterialTables

_HOLD: Final = 1e5  # a sticking contact damps so many times as much as would stop the vehicle's mass within a step
_LEAST_SLIP: Final = 1e-9  # [m/s]
_SOFT: Final = 0.002  # [m], depth over which the damper sets in
_AHEAD: Final = 0.002  # [m], look-ahead of a hull at rest


@jit.struct
class HullProbes:
    """The probes of one kind of vehicle: a Dr.Jit struct.

    Attributes:
        start: `Array3f64` (p), inside the hull, body FLU [m].
        direction: `Array3f64` (p), unit vectors, body FLU.
        length: `Float64` (p), from start to the surface [m].
        mass: `Float64` (36), mass matrix with added mass, about the body's origin, FLU, row by row [kg, kg m, kg m^2].
        grip: `Float64` (1), factor on a surface's friction: 1 for a bare hull, near 0 on wheels that roll freely.
    """

    start: Array
    direction: Array
    length: Array
    mass: Array
    grip: Array


@jit.struct
class _Listed:
    """The active probes of each vehicle, so that a solution goes over a few contacts and not over all probes."""

    lane: Array  # UInt32 (n p): from first[v] on, the lanes of vehicle v's active probes
    first: Array  # UInt32 (n)
    count: Array  # UInt32 (n)


@jit.struct
class _Touches:
    """Contact of each probe, `n p` lanes, in the body frame FLU."""

    active: Array  # Bool: will be in contact at the end of the step
    depth: Array  # [m], negative while the surface lies ahead
    normal: Array  # unit, from the surface towards the hull
    point: Array  # of contact [m]
    slip: Array  # velocity of the hull's point relative to the surface [m/s]
    stiffness: Array  # [N/m]
    damping: Array  # [N s/m]
    friction: Array


def hull_probes(
    starts: NDArray[np.float64], vectors: NDArray[np.float64], mass: NDArray[np.float64], grip: float = 1.0
) -> HullProbes:
    """Probes for the device.

    Args:
        starts: `(p, 3)` points inside the hull, body FLU [m].
        vectors: `(p, 3)` from there to the hull's surface [m].
        mass: `(6, 6)` symmetric mass matrix, added mass included, about the body's origin, FLU.
        grip: factor on a surface's friction.
    """
    length = np.linalg.norm(vectors, axis=1)
    made = HullProbes(
        start=jit.Array3f64(np.ascontiguousarray(starts.T)),
        direction=jit.Array3f64(np.ascontiguousarray((vectors / length[:, None]).T)),
        length=jit.Float64(length),
        mass=jit.Float64(np.ascontiguousarray((mass + mass.T) / 2).ravel()),
        grip=jit.Float64(grip),
    )
    jit.align(made)
    return made


def probe_wrench(
    caster: Caster,
    materials: MaterialTables,
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
    """Force and moment of all contacts over the coming step.

    Args:
        caster: the world, see `Caster`.
        materials: rows as the scene's materials.
        probes: of the vehicle.
        position: `Array3f64` (n) of the body's origin, world NWU [m].
        attitude: `Array4f64` (n), (w, x, y, z), FLU to NWU.
        velocity, angular_velocity: `Array3f64` (n), body FLU [m/s], [rad/s].
        own: `UInt32` (n) row of the moving-body table that is the hull itself, `NO_BODY` for none.
        copy: `UInt32` (n) row of the fleet axis.
        h: `Float64` (1) the step [s].

    Returns:
        Force [N] and moment about the body's origin [N m], `Array3f64` (n), body FLU, constant over the step.
    """
    hulls = _Hulls(position, attitude, velocity, angular_velocity, own, copy)
    touches = _touch(caster, materials, probes, hulls, h)
    dr.eval(touches)  # one kernel: each array that is gathered below would else repeat the cast
    listed = _list_active(touches.active, dr.width(probes.length))
    contacts = (touches, probes, listed)
    pushed = _solve(*contacts, h)
    held = _solve(*contacts, h, pushed, _held)
    slid = _solve(*contacts, h, held, _first_slide)
    acceleration = _solve(*contacts, h, slid, _slide)
    row = [sum((_mass(probes, i, j) * acceleration[j] for j in range(6)), jit.Float64(0)) for i in range(6)]
    return jit.Array3f64(*row[:3]), jit.Array3f64(*row[3:])


class _Hulls(NamedTuple):
    """Vehicles, see `probe_wrench`."""

    position: Array
    attitude: Array
    velocity: Array
    angular_velocity: Array
    own: Array
    copy: Array


def _touch(caster: Caster, materials: MaterialTables, probes: HullProbes, hulls: _Hulls, h: Array) -> _Touches:
    """Cast every probe of every vehicle: lane = vehicle * p + probe."""
    count = dr.width(probes.length)
    lane = dr.arange(jit.UInt32, dr.width(hulls.copy) * count)
    vehicle = lane // count
    probe = lane - vehicle * count
    p = dr.gather(jit.Array3f64, hulls.position, vehicle)
    q = dr.gather(jit.Array4f64, hulls.attitude, vehicle)
    v = dr.gather(jit.Array3f64, hulls.velocity, vehicle)
    w = dr.gather(jit.Array3f64, hulls.angular_velocity, vehicle)
    start = dr.gather(jit.Array3f64, probes.start, probe)
    along = dr.gather(jit.Array3f64, probes.direction, probe)
    length = dr.gather(jit.Float64, probes.length, probe)
    fastest = dr.norm(v) + dr.norm(w) * dr.norm(start + length * along)
    ahead = _AHEAD + 1.5 * h * fastest
    rays = Rays(
        origin=p + rotate(q, start),
        direction=jit.Array3f(rotate(q, along)),
        max_range=jit.Float(length + ahead),
        copy=dr.gather(jit.UInt32, hulls.copy, vehicle),
        own=dr.gather(jit.UInt32, hulls.own, vehicle),
    )
    hits = caster.cast(rays)
    normal = rotate_back(q, jit.Array3f64(hits.normal))
    reach = dr.select(hits.valid, jit.Float64(hits.t), length)
    point = start + reach * along
    depth = (reach - length) * dr.dot(along, normal)
    slip = v + dr.cross(w, point) - rotate_back(q, jit.Array3f64(hits.velocity))
    stiffness, damping, friction = (
        jit.Float64(dr.gather(jit.Float, table, hits.material, hits.valid))
        for table in (materials.stiffness, materials.damping, materials.friction)
    )
    friction *= dr.gather(jit.Float64, probes.grip, jit.UInt32(0))
    # soft ground hardens before it reaches the probe's start: what comes fast must not come through
    squeeze = dr.clip(depth / length, 0.0, 1.0)
    surge_mass = dr.gather(jit.Float64, probes.mass, jit.UInt32(0))
    stiffness += surge_mass / (h * h) * squeeze * squeeze
    closing = -dr.dot(slip, normal)
    damping = damping * dr.clip((depth + h * closing) / _SOFT, 0.0, 1.0) + surge_mass / h * squeeze
    return _Touches(
        active=hits.valid & (stiffness * (depth + h * closing) + damping * closing > 0),
        depth=depth,
        normal=normal,
        point=point,
        slip=slip,
        stiffness=stiffness,
        damping=damping,
        friction=friction,
    )


def _list_active(active: Array, block: int) -> _Listed:
    lanes = dr.width(active)
    here = dr.select(active, jit.UInt32(1), jit.UInt32(0))
    lane = dr.arange(jit.UInt32, lanes)
    rank = dr.block_prefix_sum(here, block, exclusive=True)
    out = dr.zeros(jit.UInt32, lanes)
    dr.scatter(out, lane, lane - lane % block + rank, active)
    first = dr.arange(jit.UInt32, lanes // block) * block
    last = first + (block - 1)
    return _Listed(out, first, dr.gather(jit.UInt32, rank, last) + dr.gather(jit.UInt32, here, last))


@jit.struct
class _Sideways:
    """Friction of one contact, as a solution before tells it."""

    limit: Array  # [N], of Coulomb
    before: Array  # [m/s], slip without contact
    after: Array  # [m/s], slip after the step by the solution before
    hold: Array  # [N s/m], damping of a contact that sticks


def _held(s: _Sideways) -> Array:
    """Damping across of a contact that sticks, whatever it takes [N s/m]."""
    return s.hold


def _first_slide(s: _Sideways) -> Array:
    """Damping across, where all contacts stick in the solution before.

    One contact, of mass m sideways, took the force f = m before / h to hold. Where that is beyond the limit it goes on
    at before (1 - limit / f), against the limit.
    """
    taken = s.hold * s.after
    slip = s.before * (1.0 - s.limit / dr.maximum(taken, s.limit + 1e-30))
    return dr.select(taken <= s.limit, s.hold, dr.minimum(s.limit / dr.maximum(slip, _LEAST_SLIP), s.hold))


def _slide(s: _Sideways) -> Array:
    """Damping across that gives the limit at the slip of the solution before, and no more than holds."""
    return dr.minimum(s.limit / dr.maximum(s.after, _LEAST_SLIP), s.hold)


def _solve(
    touches: _Touches,
    probes: HullProbes,
    listed: _Listed,
    h: Array,
    guess: list[Array] | None = None,
    friction: Callable[[_Sideways], Array] | None = None,
) -> list[Array]:
    """Acceleration (6) that the contacts give: (M + h S) a = b.

    With G = [1, -r x], which takes body velocities to that of the contact point at r, S sums G^T D G over the contacts
    and b sums G^T (n k depth - D slip), where D = (h k + c) n n^T + d (1 - n n^T). The damping across d is what
    `friction` makes of `guess`, a solution before; without it there is none.
    """
    surge_mass = dr.gather(jit.Float64, probes.mass, jit.UInt32(0))
    hold = _HOLD * surge_mass / h

    def body(k: Array, *sums: Array) -> tuple[Array, ...]:
        s, b = list(sums[:21]), list(sums[21:])
        at = dr.gather(jit.UInt32, listed.lane, listed.first + k)
        n = dr.gather(jit.Array3f64, touches.normal, at)
        r = dr.gather(jit.Array3f64, touches.point, at)
        slip = dr.gather(jit.Array3f64, touches.slip, at)
        depth = dr.gather(jit.Float64, touches.depth, at)
        spring = dr.gather(jit.Float64, touches.stiffness, at)
        along = h * spring + dr.gather(jit.Float64, touches.damping, at)
        approach = dr.dot(n, slip)
        push = (spring * depth - along * approach) * n
        if guess is not None and friction is not None:
            gained = h * (jit.Array3f64(*guess[:3]) + dr.cross(jit.Array3f64(*guess[3:]), r))
            rise = dr.dot(n, gained)
            normal_force = dr.maximum(spring * depth - along * (approach + rise), 0.0)
            sideways = slip - approach * n
            limit = dr.gather(jit.Float64, touches.friction, at) * normal_force
            across = friction(
                _Sideways(limit, dr.norm(sideways), dr.norm(sideways + gained - rise * n), jit.Float64(hold))
            )
            push -= across * sideways
            along -= across
            for place, value in _gram(r):
                s[place] = s[place] + across * value
        g = [*n, *dr.cross(r, n)]  # G^T n
        for i in range(6):
            scaled = along * g[i]
            for j in range(i + 1):
                s[_place(i, j)] = dr.fma(scaled, g[j], s[_place(i, j)])
        wrench = [*push, *dr.cross(r, push)]
        return (k + 1, *s, *(total + part for total, part in zip(b, wrench, strict=True)))

    n = dr.width(listed.count)
    zeros = [dr.zeros(jit.Float64, n) for _ in range(27)]
    state = (dr.zeros(jit.UInt32, n), *zeros)
    sums = dr.while_loop(state, lambda k, *_: k < listed.count, body, mode="symbolic")[1:]
    lower = [[_mass(probes, i, j) + h * sums[_place(i, j)] for j in range(i + 1)] for i in range(6)]
    return solve_symmetric(lower, list(sums[21:]))


def _place(i: int, j: int) -> int:
    """Place of row i, column j of a lower triangle in a row-by-row list."""
    return i * (i + 1) // 2 + j


def _gram(r: Array) -> list[tuple[int, Array]]:
    """The non-zero elements of G^T G, G = [1, -r x], by their place in the lower triangle."""
    x, y, z = r
    return [
        (_place(0, 0), 1.0), (_place(1, 1), 1.0), (_place(2, 2), 1.0),
        (_place(3, 1), -z), (_place(3, 2), y), (_place(4, 0), z),
        (_place(4, 2), -x), (_place(5, 0), -y), (_place(5, 1), x),
        (_place(3, 3), y * y + z * z), (_place(4, 4), x * x + z * z), (_place(5, 5), x * x + y * y),
        (_place(4, 3), -x * y), (_place(5, 3), -x * z), (_place(5, 4), -y * z),
    ]  # fmt: skip


def _mass(probes: HullProbes, i: int, j: int) -> Array:
    return dr.gather(jit.Float64, probes.mass, jit.UInt32(6 * i + j))
