"""Impulses between bodies: gaps and speeds from which they act, islands, friction of least energy, and what parts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from pelagos.contact.broad_phase import BoundedBodies, touching_boxes
from pelagos.contact.impulse import Colliding, _islands, _part, _share, _slide, collide, restitution
from pelagos.contact.pairs import PairContacts

H = 0.005


def contacts(first: Any, second: Any, point: Any, normal: Any, **parts: float) -> PairContacts:
    count = len(first)
    given = {"depth": 0.0, "stiffness": 2e5, "damping": 300.0, "friction": 0.0, **parts}
    full = [np.full(count, given[name], dtype=float) for name in ("depth", "stiffness", "damping", "friction")]
    place, out = (np.broadcast_to(np.asarray(v, float), (count, 3)).copy() for v in (point, normal))
    return PairContacts(np.array(first, np.int64), np.array(second, np.int64), place, out, *full)


def in_line(speeds: tuple[float, ...], masses: tuple[float, ...]) -> Colliding:
    """Bodies along x, 1 m apart, that move along it."""
    n = len(speeds)
    place, velocity = np.zeros((n, 3)), np.zeros((n, 3))
    place[:, 0], velocity[:, 0] = np.arange(n), speeds
    inverse = np.array([np.diag([1 / m] * 3 + [1.0] * 3) if np.isfinite(m) else np.zeros((6, 6)) for m in masses])
    return Colliding(place, velocity, np.zeros((n, 3)), inverse)


def speeds_after(found: PairContacts, bodies: Colliding) -> np.ndarray:
    return bodies.velocity[:, 0] + bodies.inverse_mass[:, 0, 0] * collide(found, bodies, H)[:, 0]


@pytest.mark.parametrize(("speed", "acts"), [(0.39, False), (0.41, True)])
def test_a_gap_is_closed_by_what_crosses_it_within_the_step(speed: float, acts: bool) -> None:
    """2 mm in 5 ms: from 0.4 m/s on."""
    bodies = in_line((0.1 + speed, 0.1), (2.0, 3.0))
    gap = contacts([0], [1], [0.5, 0, 0], [-1.0, 0, 0], depth=-0.002)
    assert collide(gap, bodies, H).any() == acts


@pytest.mark.parametrize("speed", [0.019, 0.021, 0.6])
def test_what_is_slow_does_not_bounce(speed: float) -> None:
    """Below 0.02 m/s bodies go on together, with the momentum of both."""
    bodies = in_line((speed, 0.0), (2.0, 3.0))
    one, other = speeds_after(contacts([0], [1], [0.5, 0, 0], [-1.0, 0, 0]), bodies)
    assert other - one == pytest.approx(restitution(2e5, 300.0, 1.2) * speed if speed > 0.02 else 0.0, abs=1e-12)
    assert 2 * one + 3 * other == pytest.approx(2 * speed)


@pytest.mark.parametrize(("depth", "apart"), [(0.001, 0.0), (0.004, 0.04), (0.012, 0.1)])
def test_what_overlaps_is_parted_slowly(depth: float, apart: float) -> None:
    """A tenth of what is beyond 2 mm in a step of 5 ms, 0.1 m/s at most, of bodies that would not bounce."""
    bodies = in_line((0.9, -0.3), (2.0, 3.0))
    one, other = speeds_after(contacts([0], [1], [0.5, 0, 0], [-1.0, 0, 0], depth=depth, damping=1e5), bodies)
    assert other - one == pytest.approx(apart, abs=1e-9)
    at_rest = in_line((0.0, 0.0), (2.0, 3.0))
    assert not collide(contacts([0], [1], [0.5, 0, 0], [-1.0, 0, 0], depth=depth), at_rest, H).any()  # by no energy


def test_bodies_are_parted_as_far_as_the_energy_goes() -> None:
    """0.02 m/s of approach, taken from 1.2 kg of both: they part no faster than they met."""
    bodies = in_line((0.012, -0.008), (2.0, 3.0))
    one, other = speeds_after(contacts([0], [1], [0.5, 0, 0], [-1.0, 0, 0], depth=0.02, damping=1e5), bodies)
    assert other - one == pytest.approx(0.02, rel=1e-6)
    along = np.array([[3.0, 0.0], [0.0, 0.5]])
    velocity = np.array([0.06, 0.3])
    free = _part(along, velocity, np.array([0.004, 0.001]), 1e9, H)
    assert free == pytest.approx([0.0, 0.0])  # the first goes at 0.18 m/s already
    free = _part(along, np.array([0.01, 0.3]), np.array([0.004, 0.001]), 1e9, H)
    assert free == pytest.approx([(0.04 - 0.03) / 9.0, 0.0], rel=1e-9)


def test_a_share_is_the_largest_that_the_energy_allows() -> None:
    rng, kinds = np.random.default_rng(3), set()
    for factor in (1.0, 1.2, 2.0, 6.0):
        for _ in range(60):
            base, more = rng.normal(size=(2, 4))
            limit = factor * float(base @ base)
            share = _share(base, more, limit)
            size = lambda s, b=base, m=more: float((b + s * m) @ (b + s * m))
            assert 0.0 <= share <= 1.0
            assert size(share) <= limit * (1 + 1e-12)
            assert share == 1.0 or size(share + 1e-3) > limit
            kinds.add(share if share in (0.0, 1.0) else 0.5)
    assert kinds == {0.0, 0.5, 1.0}
    assert _share(np.array([1.0, 0.0]), np.zeros(2), 1.0) == 1.0


def test_sliding_contacts_leave_the_least_energy() -> None:
    """Of all impulses within the discs, by another method (SLSQP); some slide, some stick."""
    rng, stuck, slid = np.random.default_rng(5), 0, 0
    for _ in range(5):
        across, velocity, limit = rng.normal(size=(12, 3, 2)), 3 * rng.normal(size=12), rng.uniform(0.05, 0.9, 3)
        found = _slide(across, velocity, limit)
        energy = lambda x, a=across, v=velocity: (
            0.5 * float(((v + np.einsum("vci,ci->v", a, x.reshape(3, 2))) ** 2).sum())
        )
        best = minimize(
            energy, np.zeros(6), method="SLSQP", options={"ftol": 1e-13, "maxiter": 300},
            constraints=[{"type": "ineq", "fun": lambda x, c=c, m=limit: m[c] ** 2 - x[2 * c] ** 2 - x[2 * c + 1] ** 2}
                         for c in range(3)],
        )  # fmt: skip
        size = np.linalg.norm(found, axis=1)
        assert (size <= limit * (1 + 1e-12)).all()
        assert energy(found.ravel()) <= best.fun + 1e-5 * energy(np.zeros(6))
        slid += (size > 0.999 * limit).sum()
        stuck += (size < 0.999 * limit).sum()
    assert min(stuck, slid) > 0


def test_bodies_that_nothing_moves_join_no_islands() -> None:
    """0-1-2 touch one after another, 3 stands still and is touched by 2, by 4 and by 5."""
    bodies = in_line((0.0,) * 6, (1.0, 2.0, 3.0, np.inf, 5.0, 6.0))
    island = _islands(contacts([1, 1, 2, 3, 3], [0, 2, 3, 4, 5], 0, [1.0, 0, 0]), bodies)
    assert island[0] == island[1] == island[2]
    assert len(set(island.tolist())) == 3


def test_a_row_of_bodies_is_stopped_at_the_least_cost() -> None:
    """A heavy one pushes two light ones before it against a wall, without bounce: all stop; and one pulls nothing."""
    bodies = in_line((1.0, 0.2, -0.3, 0.0), (9.0, 1.0, 2.0, np.inf))
    touching = contacts(
        [0, 1, 2], [1, 2, 3], [[0.5, 0, 0], [1.5, 0, 0], [2.5, 0, 0]], [-1.0, 0, 0], damping=1e6, depth=1e-4
    )
    assert speeds_after(touching, bodies) == pytest.approx([0.0] * 4, abs=1e-9)
    parting = in_line((0.3, 0.2, 0.9, 0.0), (9.0, 1.0, 2.0, 4.0))
    free = contacts([0, 1], [1, 2], [[0.5, 0, 0], [1.5, 0, 0]], [-1.0, 0, 0], damping=1e6)
    assert speeds_after(free, parting) == pytest.approx([0.29, 0.29, 0.9, 0.0], abs=1e-9)


def test_boxes_are_near_where_the_spheres_of_both_reach_them() -> None:
    """Distance of a sphere's middle to the other's turned box, as SciPy turns it, of each of both; within a margin."""
    rng, n = np.random.default_rng(7), 24
    low, high = -rng.uniform(0.1, 2.0, (n, 3)), rng.uniform(0.1, 1.0, (n, 3))
    attitude = Rotation.random(n, random_state=4).as_quat(scalar_first=True)
    bodies = BoundedBodies(
        rng.uniform(-2, 2, (n, 3)), attitude, rng.uniform(0.05, 1.0, n), low, high, np.zeros(n, np.int64)
    )
    pairs = np.stack(np.triu_indices(n, 1), -1).astype(np.int64)

    def gap(sphere: int, box: int) -> float:
        turn = Rotation.from_quat(attitude[box], scalar_first=True)
        local = turn.inv().apply(bodies.position[sphere] - bodies.position[box])
        return float(np.linalg.norm(local - np.clip(local, low[box], high[box]))) - bodies.radius[sphere]

    gaps = np.array([max(gap(i, j), gap(j, i)) for i, j in pairs])
    for margin in (0.0, 0.3):
        found = touching_boxes(bodies, pairs, margin)
        np.testing.assert_array_equal(found, gaps < margin)
        assert 0.05 < found.mean() < 0.95
