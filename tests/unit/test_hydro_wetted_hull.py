"""Pressure on triangles that the surface cuts, against their clipped polygons; and solvers of six equations."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos import jit
from pelagos.hydro.algebra import inverse3, norm, solve_blocks
from pelagos.hydro.wetted_hull import wetted_load


def integrals(corners: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Force, moment and area of a triangle `(3, 3)` under a linear pressure `(3,)`, by the middles of its edges."""
    normal = 0.5 * np.cross(corners[1] - corners[0], corners[2] - corners[0])
    force, moment = np.zeros(3), np.zeros(3)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        push = -0.5 * (values[i] + values[j]) * normal / 3
        force, moment = force + push, moment + np.cross(0.5 * (corners[i] + corners[j]), push)
    return force, moment, float(np.linalg.norm(normal))


def clipped(corners: np.ndarray, depth: np.ndarray, head: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """The same of the part whose depth, linear too, is above 0."""
    polygon = []
    for i in range(3):
        j = (i + 1) % 3
        if depth[i] > 0:
            polygon.append((corners[i], head[i]))
        if (depth[i] > 0) != (depth[j] > 0):
            s = depth[i] / (depth[i] - depth[j])
            polygon.append((corners[i] + s * (corners[j] - corners[i]), head[i] + s * (head[j] - head[i])))
    force, moment, area = np.zeros(3), np.zeros(3), 0.0
    for k in range(1, len(polygon) - 1):
        part = [polygon[n] for n in (0, k, k + 1)]
        f, m, a = integrals(np.array([p for p, _ in part]), np.array([h for _, h in part]))
        force, moment, area = force + f, moment + m, area + a
    return force, moment, area


def test_triangles_are_pushed_on_their_wet_part() -> None:
    """Any corner alone below or above the surface, all, or none; heads that are not the depth, as in waves."""
    rng, n = np.random.default_rng(4), 96
    corners, head = rng.normal(size=(n, 3, 3)), rng.normal(size=(n, 3))
    signs = np.array([[(k >> bit) % 2 * 2 - 1 for bit in range(3)] for k in range(n)])
    depth = signs * rng.uniform(0.05, 1.0, (n, 3))
    given = [jit.Array3f64(*(np.ascontiguousarray(corners[:, k, i]) for i in range(3))) for k in range(3)]
    lanes = lambda table: tuple(jit.Float64(np.ascontiguousarray(table[:, k])) for k in range(3))
    found = wetted_load((given[0], given[1], given[2]), lanes(depth), lanes(head))
    expected = [clipped(*row) for row in zip(corners, depth, head, strict=True)]
    assert pytest.approx(np.array([f for f, _, _ in expected]), abs=1e-12) == np.array(found.force).T
    assert pytest.approx(np.array([m for _, m, _ in expected]), abs=1e-12) == np.array(found.moment).T
    assert np.array(found.area) == pytest.approx(np.array([a for _, _, a in expected]), abs=1e-12)


@pytest.mark.parametrize("arrays", [False, True])
def test_six_equations_by_blocks_equal_lapack(arrays: bool) -> None:
    """Of a matrix that is not symmetric, with zeros, as numbers of the program or as data."""
    rng = np.random.default_rng(6)
    m = rng.normal(size=(6, 6)) + 6 * np.eye(6)
    m[0, 4] = m[5, 2] = m[3, 3] = m[1, 0] = 0.0
    m[3, 5] += 5.0
    m[5, 3] -= 5.0
    b = rng.normal(size=6)
    wrap = (lambda x: jit.Float64(float(x))) if arrays else float
    found = solve_blocks([[wrap(x) for x in row] for row in m], [wrap(x) for x in b])
    assert [float(jit.Float64(x)[0]) for x in found] == pytest.approx(np.linalg.solve(m, b).tolist(), rel=1e-9)
    block = [[wrap(x) for x in row[:3]] for row in m[:3]]
    inverse = [[float(jit.Float64(x)[0]) for x in row] for row in inverse3(block)]
    assert np.array(inverse) == pytest.approx(np.linalg.inv(m[:3, :3]), rel=1e-9)


def test_a_length_is_a_number_where_its_vector_is() -> None:
    assert norm([3.0, -4.0, 12.0]) == 13.0
    assert norm([0.0, 0.0, 0.0]) == 0.0
    lengths = np.array(norm([jit.Float64([3.0, 0.0]), jit.Float64([-4.0, 0.0]), 0.0]))
    assert lengths == pytest.approx([5.0, 0.0])
