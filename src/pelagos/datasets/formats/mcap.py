"""MCAP: one recording a shard, of ROS 2 messages as a run writes them; sample k of a shard is at k seconds.

Labels are in the pictures of depth, semantic and instance cameras; boxes and drawn values in the attachments of the
other formats' JSON, "samples.json".
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from pelagos.config.loader import load_scenario, to_yaml
from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.sample import Sample, as_json
from pelagos.sim.mcap_writer import CHUNK_BYTES, McapWriter
from pelagos.sim.record import Recorder
from pelagos.world.legend import legend

SAMPLE_NS: Final = 1_000_000_000


class Mcap:
    """`mcap/SPLIT/shard-000000.mcap`."""

    def __init__(self, folder: Path, plan: Plan, shard: Shard, maker: Any) -> None:
        path = folder / "mcap" / shard.split / f"{shard.name}.mcap"
        path.parent.mkdir(parents=True, exist_ok=True)
        sim, self._agent = maker.simulation, plan.rig.agent
        sensors = {self._agent: {s: m.config for s, m in sim.model.agents[self._agent].sensors.items()}}
        drawn = plan.rig.follow(plan.values(shard.world))
        scenario = load_scenario(plan.rig.scenario, overrides=drawn, trust=True)  # the same text whatever was before
        origin = (sim.world.origin.latitude, sim.world.origin.longitude)
        self._file = _ChunksBySize(path, library=f"pelagos {plan.versions['pelagos']}")
        self._recorder = Recorder(
            path, to_yaml(scenario), sim.seed, sensors, None, origin, sim.dt_ns,
            legend=legend(sim.world, sim.moving), writer=self._file,
        )  # fmt: skip
        self._maker, self._first = maker, shard.first
        self._metas: list[dict[str, Any]] = []

    def add(self, sample: Sample) -> None:
        """Write a sample."""
        t_ns = (sample.index - self._first) * SAMPLE_NS
        still = np.zeros((1, 3))
        self._recorder.write_truth(
            self._agent, t_ns, sample.pose.position[None], sample.pose.attitude[None], still, still
        )
        for sensor, reading in self._maker.last_readings().items():
            self._recorder.write(self._agent, sensor, replace(reading, t_ns=t_ns))
        self._metas.append(sample.meta)

    def close(self) -> None:
        """End the file."""
        self._file.add_attachment("samples.json", "application/json", as_json(self._metas))
        self._recorder.close()


class _ChunksBySize(McapWriter):
    """Chunks end by their size alone: a recorder also ends them by the clock on the wall."""

    def flush(self) -> None:
        """End a chunk that is large enough."""
        if self._waiting > CHUNK_BYTES:
            super().flush()


FORMAT = Mcap
