"""Lanes of a trajectory: those of some rows, and copies of others."""

from __future__ import annotations

import numpy as np

from pelagos import jit
from pelagos.sim.trajectory import CHANNELS, kinematics, of_rows


def test_rows_of_a_motion_are_taken_at_every_tick() -> None:
    """Of 4 rows at 3 ticks, which follow each other tick by tick: rows 1 and 2."""
    lane = np.arange(12)
    channels = [jit.Float64(100.0 * c + lane) for c in range(CHANNELS)]
    motion = kinematics(
        channels, tick=jit.UInt32(lane // 4), t_ns=jit.UInt64(10 * (lane // 4)), age_ns=jit.UInt64(lane % 3),
        environment=jit.UInt32(50 + lane % 4), copy=jit.UInt32(lane % 4),
    )  # fmt: skip
    found = of_rows(motion, slice(1, 3), 4)
    assert np.array(found.copy).tolist() == [1, 2, 1, 2, 1, 2]
    assert np.array(found.tick).tolist() == [0, 0, 1, 1, 2, 2]
    assert np.array(found.environment).tolist() == [51, 52, 51, 52, 51, 52]
    assert np.array(found.velocity.y).tolist() == [800.0 + k for k in (1, 2, 5, 6, 9, 10)]
