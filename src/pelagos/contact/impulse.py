"""Collisions of bodies with one another: impulses that are equal and opposite, and never add energy.

Bodies that touch one another, directly or through others, are solved together, at one moment's states. Impulses along
the normals are those that stop all approach at the least cost: the velocities of all bodies, measured by kinetic
energy, are projected onto the cone of velocities that separate (J. J. Moreau, "Unilateral contact and dry friction in
finite freedom dynamics", 1988, Section 4, doi 10.1007/978-3-7091-2624-0_1). Restitution goes beyond the projection by a
share e of it, which keeps the energy for e = 1 and loses it below. For e stands the closed form of two bodies that meet
by a linear spring and damper, exp(-pi z / sqrt(1 - z^2)) with z = c / (2 sqrt(k m)) and the mass m that the contact
feels (T. Schwager, T. Poeschel, Granular Matter 9, 465 (2007), Section 2, doi 10.1007/s10035-007-0065-z). Friction then
takes as much energy as it can with tangential impulses within Coulomb's discs: it sticks where that suffices.

Every impulse acts at one point on both bodies, so that momentum and angular momentum are kept to rounding whatever the
solution. Bodies are ordered by where they are: their names and their order change nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.contact.pairs import PairContacts
from pelagos.math.so3 import cross_np

_BOUNCE: Final = 0.02  # [m/s], approach below which nothing bounces
_OVERLAP: Final = 0.002  # [m] that bodies may overlap for good
_PART: Final = 0.1  # of the rest is to go in a step,
_PART_MPS: Final = 0.1  # but not faster
_SWEEPS: Final = 60  # over the contacts that slide
_STUCK: Final = 1e-14  # relative change of energy that ends the sweeps


@dataclass(frozen=True)
class Colliding:
    """Bodies that contacts are between, `(b, ...)`.

    Attributes:
        position: of their origins, world [m].
        velocity, spin: at the end of the step without contact, world [m/s], [rad/s].
        inverse_mass: `(b, 6, 6)` of mass and added mass about the origin, world; 0 for bodies that nothing moves.
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    spin: NDArray[np.float64]
    inverse_mass: NDArray[np.float64]


def collide(contacts: PairContacts, bodies: Colliding, h: float) -> NDArray[np.float64]:
    """Impulse and angular impulse about its origin of each body, world, `(b, 6)` [N s], [N m s].

    Args:
        contacts: whose rows are those of `bodies`.
        bodies: see `Colliding`.
        h: the step, within which contacts come about [s].
    """
    impulses = np.zeros((len(bodies.position), 6))
    closing = _along(contacts, bodies, contacts.normal)
    keep = (contacts.depth > 0.0) | (h * closing - contacts.depth < 0.0)
    contacts = PairContacts(*(getattr(contacts, name)[keep] for name in PairContacts.__dataclass_fields__))
    if not len(contacts.depth):
        return impulses
    rank = np.empty(len(bodies.position), dtype=np.int64)
    rank[np.lexsort(bodies.position.T[::-1])] = np.arange(len(rank))
    order = np.lexsort((rank[contacts.second], rank[contacts.first]))  # stable: probe by probe within a pair
    contacts = PairContacts(*(getattr(contacts, name)[order] for name in PairContacts.__dataclass_fields__))
    island = _islands(contacts, bodies)
    for number in np.unique(island):
        part = island == number
        own = PairContacts(*(getattr(contacts, name)[part] for name in PairContacts.__dataclass_fields__))
        _collide_island(own, bodies, rank, h, impulses)
    return impulses


def restitution(stiffness: float, damping: float, mass: float) -> float:
    """Speed after over speed before of a mass [kg] on a spring [N/m] and a damper [N s/m], see the module."""
    ratio = damping / (2.0 * math.sqrt(stiffness * mass))
    return 0.0 if ratio >= 1.0 else math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio * ratio))


def _along(contacts: PairContacts, bodies: Colliding, direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """`(c,)` speed of the first body's point relative to the second's."""
    return np.asarray(np.einsum("ij,ij->i", _slip(contacts, bodies), direction))


def _slip(contacts: PairContacts, bodies: Colliding) -> NDArray[np.float64]:
    """`(c, 3)` velocity of the first body's point relative to the second's."""
    parts = []
    for rows in (contacts.first, contacts.second):
        arm = contacts.point - bodies.position[rows]
        parts.append(bodies.velocity[rows] + cross_np(bodies.spin[rows], arm))
    return np.asarray(parts[0] - parts[1])


def _islands(contacts: PairContacts, bodies: Colliding) -> NDArray[np.int64]:
    """`(c,)` number of the island of each contact; bodies that nothing moves join none."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    moves = np.asarray(bodies.inverse_mass.any(axis=(1, 2)))
    both = moves[contacts.first] & moves[contacts.second]
    size = len(moves)
    link = coo_matrix((np.ones(int(both.sum())), (contacts.first[both], contacts.second[both])), shape=(size, size))
    number = connected_components(link, directed=False)[1]
    return np.asarray(np.where(moves[contacts.first], number[contacts.first], number[contacts.second]))


def _collide_island(
    contacts: PairContacts, bodies: Colliding, rank: NDArray[np.int64], h: float, impulses: NDArray[np.float64]
) -> None:
    moves = np.asarray(bodies.inverse_mass.any(axis=(1, 2)))
    rows = np.unique(np.concatenate([contacts.first, contacts.second]))
    rows = rows[np.argsort(rank[rows], kind="stable")]
    dynamic, fixed = rows[moves[rows]], rows[~moves[rows]]
    if not len(dynamic):
        return
    space = _Space(contacts, bodies, dynamic)
    start = space.start(bodies, fixed)
    along = space.response(contacts.normal)  # (6 b, c)
    approach = along.T @ start
    pressed = _stop(along, start)
    mass = 1.0 / np.maximum(np.einsum("ij,ij->j", along, along), 1e-300)
    bounce = np.array(
        [
            restitution(k, c, m) if v < -_BOUNCE else 0.0
            for k, c, m, v in zip(contacts.stiffness, contacts.damping, mass, approach, strict=True)
        ]
    )
    stopped = start + along @ pressed
    beyond = along @ (bounce * pressed)
    share = _share(stopped, beyond, float(start @ start))
    pressed = pressed * (1.0 + share * bounce)
    now = stopped + share * beyond
    pushed = _part(along, now, contacts.depth, float(start @ start), h)
    now = now + along @ pushed
    pressed = pressed + pushed
    impulse = pressed[:, None] * contacts.normal
    held = np.flatnonzero(pressed > 0.0)
    if len(held) and (contacts.friction[held] > 0.0).any():
        impulse[held] += _rub(space, contacts, held, now, contacts.friction[held] * pressed[held])
    for side, sign in ((contacts.first, 1.0), (contacts.second, -1.0)):
        arm = contacts.point - bodies.position[side]
        np.add.at(impulses, side, sign * np.concatenate([impulse, cross_np(arm, impulse)], axis=1))


class _Space:
    """Velocities of an island's bodies, scaled so that half their square is the kinetic energy."""

    def __init__(self, contacts: PairContacts, bodies: Colliding, dynamic: NDArray[np.int64]) -> None:
        self._contacts, self._bodies, self._dynamic = contacts, bodies, dynamic
        self._root = np.linalg.cholesky(bodies.inverse_mass[dynamic])  # W = C C^T

    def start(self, bodies: Colliding, fixed: NDArray[np.int64]) -> NDArray[np.float64]:
        """`(6 b,)` of the velocities without contact, as seen from the first body that nothing moves."""
        linear, spin = bodies.velocity[self._dynamic], bodies.spin[self._dynamic]
        if len(fixed):
            frame, turn = bodies.velocity[fixed[0]], bodies.spin[fixed[0]]
            arm = bodies.position[self._dynamic] - bodies.position[fixed[0]]
            linear, spin = linear - frame - cross_np(turn, arm), spin - turn
        twist = np.concatenate([linear, spin], axis=1)
        return np.asarray(np.linalg.solve(self._root, twist[..., None])[..., 0].ravel())

    def response(self, direction: NDArray[np.float64], of: NDArray[np.intp] | None = None) -> NDArray[np.float64]:
        """`(6 b, c)` what unit impulses along directions `(c, 3)` at contacts do."""
        c = self._contacts
        chosen = np.arange(len(c.depth)) if of is None else of
        place = np.full(len(self._bodies.position), -1)
        place[self._dynamic] = np.arange(len(self._dynamic))
        found = np.zeros((len(self._dynamic), 6, len(chosen)))
        for side, sign in ((c.first[chosen], 1.0), (c.second[chosen], -1.0)):
            column = np.flatnonzero(place[side] >= 0)
            at, along = place[side[column]], direction[column]
            arm = c.point[chosen[column]] - self._bodies.position[side[column]]
            wrench = sign * np.concatenate([along, cross_np(arm, along)], axis=1)
            found[at, :, column] += np.einsum("cji,cj->ci", self._root[at], wrench)
        return found.reshape(6 * len(self._dynamic), len(chosen))


def _stop(along: NDArray[np.float64], velocity: NDArray[np.float64]) -> NDArray[np.float64]:
    """Impulses, none of them pulling, after which no contact closes: a problem of least squares."""
    from scipy.optimize import nnls

    if (along.T @ velocity >= 0.0).all():
        return np.zeros(along.shape[1])
    return np.asarray(nnls(along, -velocity, maxiter=30 * max(along.shape))[0])


def _share(base: NDArray[np.float64], more: NDArray[np.float64], limit: float) -> float:
    """Share of `more`, at most 1, that may be added before the square passes `limit`."""
    a, b, c = float(more @ more), float(base @ more), float(base @ base) - limit
    if a <= 0.0 or a + 2.0 * b + c <= 0.0:
        return 1.0
    return max(0.0, min(1.0, (-b + math.sqrt(max(b * b - a * c, 0.0))) / a))


def _part(
    along: NDArray[np.float64], velocity: NDArray[np.float64], depth: NDArray[np.float64], limit: float, h: float
) -> NDArray[np.float64]:
    """Impulses that part what overlaps, as far as the energy suffices that the collision has taken."""
    wanted = np.minimum(_PART * np.maximum(depth - _OVERLAP, 0.0) / h, _PART_MPS)
    lacking = wanted - along.T @ velocity
    if not ((wanted > 0.0) & (lacking > 0.0)).any():
        return np.zeros(len(depth))
    shift = np.linalg.lstsq(along.T, wanted, rcond=None)[0]
    impulse = _stop(along, velocity - shift)
    return _share(velocity, along @ impulse, limit) * impulse


def _rub(
    space: _Space, contacts: PairContacts, held: NDArray[np.intp], velocity: NDArray[np.float64],
    limit: NDArray[np.float64],
) -> NDArray[np.float64]:  # fmt: skip
    """`(held, 3)` tangential impulses, no longer than `limit` [N s], that leave the least kinetic energy."""
    normal = contacts.normal[held]
    aside = np.where(np.abs(normal[:, :1]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    one = cross_np(normal, aside)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    two = cross_np(normal, one)
    across = np.stack([space.response(one, held), space.response(two, held)], axis=-1)  # (6 b, held, 2)
    flat = across.reshape(len(across), -1)
    impulse = np.linalg.lstsq(flat, -velocity, rcond=None)[0].reshape(-1, 2)
    if (np.linalg.norm(impulse, axis=1) > limit).any():
        impulse = _slide(across, velocity, limit)
    return np.asarray(impulse[:, :1] * one + impulse[:, 1:] * two)


def _slide(
    across: NDArray[np.float64], velocity: NDArray[np.float64], limit: NDArray[np.float64]
) -> NDArray[np.float64]:
    """`(c, 2)` impulses within discs of least energy, disc by disc: every step takes energy, any end will do."""
    count = across.shape[1]
    impulse = np.zeros((count, 2))
    parts = [np.ascontiguousarray(across[:, i]) for i in range(count)]
    stiff = [max(float(np.linalg.norm(p, 2)) ** 2, 1e-300) for p in parts]
    energy = float(velocity @ velocity)
    for _ in range(_SWEEPS):
        for i, part in enumerate(parts):
            new = impulse[i] - (part.T @ velocity) / stiff[i]
            length = math.hypot(new[0], new[1])
            if length > limit[i]:
                new *= limit[i] / length
            velocity = velocity + part @ (new - impulse[i])
            impulse[i] = new
        before, energy = energy, float(velocity @ velocity)
        if before - energy <= _STUCK * before:
            break
    return impulse
