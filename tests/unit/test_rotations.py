"""Rotations against SciPy's, by unequal angles of both signs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.math import so3
from pelagos.math.rotation import apply, conjugate, from_vector, product, skew, to_vector

ANGLES = [(0.3, -0.5, 1.1), (-1.2, 0.7, -2.4)]


def quaternion(rotation: Rotation) -> np.ndarray:
    """w first."""
    return np.roll(rotation.as_quat(), 1, axis=-1)


def numbers(values) -> np.ndarray:
    return np.array([np.array(v)[0] for v in values])


@pytest.mark.parametrize("angles", ANGLES)
def test_euler_angles_are_turns_about_z_then_y_then_x(angles) -> None:
    found = numbers(so3.from_euler(*(jit.Float64(a) for a in angles)))
    expected = quaternion(Rotation.from_euler("ZYX", angles[::-1]))
    assert found * np.sign(found[0]) == pytest.approx(expected * np.sign(expected[0]), abs=1e-12)


@pytest.mark.parametrize("angles", ANGLES)
def test_vectors_are_turned_there_and_back(angles) -> None:
    rotation, vector = Rotation.from_euler("ZYX", angles), np.array([1.3, -0.4, 2.2])
    q = quaternion(rotation)
    there, back = rotation.apply(vector), rotation.inv().apply(vector)
    on_device = jit.Array4f64(*q.tolist()), jit.Array3f64(*vector.tolist())
    assert numbers(so3.rotate(*on_device)) == pytest.approx(there, abs=1e-12)
    assert numbers(so3.rotate_back(*on_device)) == pytest.approx(back, abs=1e-12)
    assert so3.rotate_np(np.tile(q, (2, 1)), np.stack([vector, -vector])) == pytest.approx(np.stack([there, -there]))


@pytest.mark.parametrize("h", [0.7, 1e-7, -0.4])
def test_a_body_that_turns_at_a_constant_rate(h: float) -> None:
    start, rate = Rotation.from_euler("ZYX", ANGLES[0]), np.array([0.8, -1.7, 0.5])
    found = numbers(
        so3.integrate(jit.Array4f64(*quaternion(start).tolist()), jit.Array3f64(*rate.tolist()), jit.Float64(h))
    )
    expected = quaternion(start * Rotation.from_rotvec(h * rate))
    assert found * np.sign(found[0]) == pytest.approx(expected * np.sign(expected[0]), abs=1e-12)


def test_matrices_and_angles_of_many_quaternions() -> None:
    """Of `(2, 3, 4)`, one alone, and plain numbers; the yaw of a bow that points up is still one."""
    turns = Rotation.from_euler("ZYX", np.random.default_rng(3).uniform([-3.1, -1.5, -3.1], [3.1, 1.5, 3.1], (6, 3)))
    q = quaternion(turns).reshape(2, 3, 4)
    matrices, angles = turns.as_matrix().reshape(2, 3, 3, 3), turns.as_euler("ZYX")[:, ::-1].reshape(2, 3, 3)
    assert so3.matrix_np(q) == pytest.approx(matrices, abs=1e-12)
    assert so3.matrix_np(q[1, 2]) == pytest.approx(matrices[1, 2], abs=1e-12)
    assert np.array(so3.matrix(q[1, 0].tolist())) == pytest.approx(matrices[1, 0], abs=1e-12)
    assert so3.euler_np(q) == pytest.approx(angles, abs=1e-12)
    assert so3.euler_np(q[0, 1]) == pytest.approx(angles[0, 1], abs=1e-12)
    assert so3.yaw_np(q) == pytest.approx(angles[..., 2], abs=1e-12)
    vectors = np.random.default_rng(4).normal(size=(2, 3, 3))
    assert so3.rotate_np(q, vectors) == pytest.approx(np.einsum("abij,abj->abi", matrices, vectors), abs=1e-12)
    assert so3.euler_np(np.array([1.0, 0.0, 1.0 + 1e-16, 0.0]) / np.sqrt(2))[1] == pytest.approx(np.pi / 2)


def test_rotations_of_many_lanes_are_those_of_scipy() -> None:
    """Products, turns about vectors and back the short way round, large, small and none, of either sign of w."""
    turns = np.array([[0.4, -0.9, 1.3], [-2.1, 0.6, -1.4], [3e-13, -2e-13, 1e-13], [0.0, 0.0, 0.0], [2.9, 2.0, -1.1]])
    expected = Rotation.from_rotvec(turns)
    q = from_vector(turns)
    np.testing.assert_allclose(Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_matrix(), expected.as_matrix(), atol=1e-15)
    np.testing.assert_allclose(to_vector(q), expected.as_rotvec(), rtol=1e-12, atol=1e-20)
    np.testing.assert_allclose(to_vector(-q), expected.as_rotvec(), rtol=1e-12, atol=1e-20)
    both = product(q, q[[1, 0, 4, 2, 3]])
    other = expected * Rotation.from_quat(q[[1, 0, 4, 2, 3]][:, [1, 2, 3, 0]])
    np.testing.assert_allclose(Rotation.from_quat(both[:, [1, 2, 3, 0]]).as_matrix(), other.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(product(q, conjugate(q)), np.tile([1.0, 0, 0, 0], (5, 1)), atol=1e-15)
    vectors = np.random.default_rng(3).normal(size=(5, 3))
    np.testing.assert_allclose(apply(skew(turns), vectors), np.cross(turns, vectors), atol=1e-14)
    np.testing.assert_allclose(apply(expected.as_matrix(), vectors), expected.apply(vectors), atol=1e-14)
    np.testing.assert_allclose(apply(expected.as_matrix()[1], vectors), expected[1].apply(vectors), atol=1e-14)
