"""The current at a hull: its change along the hull and along the water's own way, in a field that is linear."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos import jit
from pelagos.vehicles.flow import rotation_from_euler
from pelagos.vehicles.stream import current_at, stream_at

GRADIENT = np.array([[0.011, -0.023, 0.031], [0.047, -0.013, -0.029], [0.017, 0.037, 0.002]])  # NWU [1/s]
STEADY, GROWTH = np.array([0.4, -0.7, 0.05]), np.array([0.003, -0.002, 0.001])  # [m/s], [m/s^2]
NED = np.diag([1.0, -1.0, -1.0])


def field() -> Any:
    def current(p: Any, t: Any) -> Any:
        rows = [sum(g * x for g, x in zip(row, p, strict=True)) for row in GRADIENT]
        return jit.Array3f64(*(c + g * t + r for c, g, r in zip(STEADY, GROWTH, rows, strict=True)))

    return SimpleNamespace(current=current, currents=[None])


def numbers(values: Any) -> np.ndarray:
    return np.array([float(np.array(v).ravel()[0]) for v in values])


@pytest.mark.parametrize("angles", [(0.3, -0.4, 0.7), (-0.2, 0.9, -2.3)])
def test_water_turns_with_the_line_along_the_hull(angles: tuple[float, float, float]) -> None:
    """omega = x cross (G x) in body axes without a part about x: (0, -w', v'); DU/Dt = dU/dt + G (U + orbital)."""
    place, t = np.array([3.0, -2.0, 5.0]), 40.0
    rotation = [[jit.Float64(x) for x in row] for row in rotation_from_euler(*(jit.Float64(a) for a in angles))]
    turn = np.array([numbers(row) for row in rotation])
    position, now = [jit.Float64(x) for x in place], jit.Float64(t)
    gradient = NED @ GRADIENT @ NED
    expected = NED @ (STEADY + GROWTH * t) + gradient @ place
    velocity = current_at(field(), position, now)
    np.testing.assert_allclose(numbers(velocity), expected, rtol=1e-12)
    orbital = np.array([0.2, 0.5, -0.3])
    found = stream_at(field(), position, rotation, 1.7, now, velocity, [jit.Float64(x) for x in orbital])
    along = turn.T @ gradient @ turn[:, 0]
    np.testing.assert_allclose(numbers(found.turning), [0.0, -along[2], along[1]], rtol=1e-9)
    carried = NED @ GROWTH + gradient @ (expected + orbital)
    np.testing.assert_allclose(numbers(found.acceleration), carried, rtol=1e-6)
