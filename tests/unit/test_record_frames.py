"""Transforms of all agents on /tf: in order of time, however a run is cut into blocks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.sim.record import Recorder
from pelagos.sim.record_frames import Frames
from pelagos.sim.replay import Recording
from pelagos.sim.resume import keep, last_checkpoint, resumed_recorder
from pelagos.sim.run_log import open_recorder


def messages(recording: Recording) -> dict[str, list[tuple[int, bytes]]]:
    return {topic: [(m.t_ns, m.raw) for m in recording.messages(topic)] for topic in recording.channels}


def fleet(groups: str) -> dict[str, Any]:
    """A boat, eleven vehicles, whose names have two lengths, and a body that moves by itself."""
    start = {"position_m": [3.0, -4.0], "depth_m": 5.0, "speed_mps": 1.2, "spacing_m": [30.0, 25.0]}
    return {
        "seed": 4,
        "tick_rate_hz": 50,
        "world": {"type": "flat", "depth_m": 25.0},
        "agents": {
            "boat": {"vehicle": "otter", "start": {"position_m": [-20.0, 9.0]}},
            "auv": {
                "count": 11, "vehicle": "remus100", "start": start,
                "sensors": {"depth": {"type": "depth", "rate_hz": 10}},
            },
        },
        "record": {"state_rate_hz": 10, "groups": groups},
    }  # fmt: skip


@pytest.mark.parametrize("groups", ["by_member", "together"])
def test_a_resumed_run_has_the_messages_of_a_whole_one_in_their_order(groups: str, tmp_path: Path) -> None:
    """Cut at a time that is no end of a block of the whole run."""
    whole, parts = tmp_path / "whole.mcap", tmp_path / "parts.mcap"
    pl.Simulation.load(fleet(groups), n=2).run(1.2, record=whole)
    sim = pl.Simulation.load(fleet(groups), n=2)
    with open_recorder(parts, sim) as recorder:
        sim.run(0.7, record=recorder)
        keep(sim, recorder, tmp_path)
    sim = pl.Simulation.load(fleet(groups), n=2)
    sim.restore(last_checkpoint(tmp_path))
    with resumed_recorder(parts, sim) as recorder:
        sim.run(0.5, record=recorder)
    expected = messages(Recording(whole))
    assert messages(Recording(parts)) == expected
    times = [t_ns for t_ns, _ in expected["/tf"]]
    assert times == [100_000_000 * k for k in range(13) for _ in range(2 * 12)]


def motion(place: float, ticks: int) -> list[np.ndarray]:
    """Of two copies that stand at `place`, and at its negative, along every axis."""
    at = np.array([place, -place])[None, :, None] * np.ones((ticks, 2, 3))
    return [at, np.tile([1.0, 0.0, 0.0, 0.0], (ticks, 2, 1)), 0 * at, 0 * at]


def test_transforms_of_blocks_and_of_single_times_are_written_time_by_time(tmp_path: Path) -> None:
    """Copies and agents follow each other at one time as they were written; a time for itself ends what was kept."""
    t_ns = np.array([3, 5, 9]) * 1_000_000
    with Recorder(tmp_path / "a.mcap", "", 3, {"boat": {}, "a": {}}, None, (1.0, 2.0), 10, copies=2) as r:
        r.add_mover("seal", {"mover": "seal"})
        r.write_mover_block("seal", t_ns[1:2], *(part[:, 0] for part in motion(40.0, 1)))
        r.write_truth_block("boat", t_ns, *motion(10.0, 3))
        r.write_truth_block("a", t_ns[1:], *motion(20.0, 2))
        r.write_truth("boat", 11_000_000, *(part[0] for part in motion(30.0, 1)))
    found = [(m.t_ns // 1_000_000, m.message.transforms[0]) for m in Recording(tmp_path / "a.mcap").messages("/tf")]
    boat, a = ["env0/boat/base_link", "env1/boat/base_link"], ["env0/a/base_link", "env1/a/base_link"]
    named = [(3, boat), (5, ["movers/seal", *boat, *a]), (9, [*boat, *a]), (11, boat)]
    assert [(t, one.child_frame_id) for t, one in found] == [(t, name) for t, names in named for name in names]
    heights = [one.transform.translation.z for _, one in found]
    assert heights == [10, -10, 40, 10, -10, 20, -20, 10, -10, 20, -20, 30, -30]


def test_kept_messages_of_several_sizes_come_in_pieces_of_one() -> None:
    frames = Frames()
    assert list(frames.ordered()) == []
    frames.keep(np.array([2, 4]), np.array([[1, 2, 3], [4, 5, 6]], np.uint8))
    frames.keep(np.array([], np.int64), np.zeros((0, 9), np.uint8))
    frames.keep(np.array([1, 2]), np.array([[7], [8]], np.uint8))
    frames.keep(np.array([4]), np.array([[9, 9, 9]], np.uint8))
    pieces = [(t.tolist(), rows.tolist()) for t, rows in frames.ordered()]
    assert pieces == [([1], [[7]]), ([2], [[1, 2, 3]]), ([2], [[8]]), ([4, 4], [[4, 5, 6], [9, 9, 9]])]
    assert list(frames.ordered()) == []
