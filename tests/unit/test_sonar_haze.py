"""The water's echo between the ranges at which it was looked at."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos import jit
from pelagos.sensors.sonar.ping.volume_echo import NODES, Haze, haze_at

NEAREST, STEP, BEAMS = 1.7, 0.4, 3


def test_it_is_linear_between_nodes_and_held_beyond_them() -> None:
    """Node k lies at nearest + k step; each beam of each ping has a line of its own."""
    ranges = NEAREST + STEP * np.arange(NODES)
    slopes = np.array([[0.3, -0.2, 0.7], [1.1, -0.6, 0.4]])
    values = slopes[:, :, None] * ranges + [[[0.5], [2.0], [-1.0]], [[4.0], [0.2], [0.9]]]
    made = Haze(jit.Float(values.ravel().astype(np.float32)), NEAREST, STEP)
    for ping, beam in ((0, 0), (0, 2), (1, 1)):
        asked = np.array([NEAREST + 0.3 * STEP, NEAREST + 7.81 * STEP, ranges[-1] - 0.25 * STEP, 0.2, ranges[-1] + 9.0])
        found = haze_at(made, jit.Int32(ping), jit.Int32(beam), jit.Float(asked.astype(np.float32)), BEAMS)
        known = np.interp(asked, ranges, values[ping, beam])
        assert np.array(found) == pytest.approx(known, rel=1e-4)  # single precision of a place among the nodes
