"""Makes the samples of shards: one simulation, whose world changes from shard to shard."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.datasets.distribution import stream
from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.pose import GROUND, PoseSource, SampledPose
from pelagos.datasets.sample import Sample, Thing
from pelagos.errors import InputError, MountWarning
from pelagos.math.so3 import rotate_np
from pelagos.sensors.camera.picture.annotations import boxes
from pelagos.sensors.camera.picture.boxes_3d import Box3d
from pelagos.sensors.camera.picture.camera_rays import ViewConfig, view_intrinsics
from pelagos.sensors.sensor import Reading, SensorConfig
from pelagos.sim.simulation import Simulation
from pelagos.world.label import LABELS


class Maker:
    """Samples of any shard of a plan; keeps the simulation from one to the next."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._sim: Simulation | None = None
        self._world = -1
        self._last: tuple[Mapping[str, Reading], int] = {}, 0
        self._lanewise: dict[str, frozenset[str]] = {}
        self._space: dict[int, Box3d] = {}  # of this world: nothing moves, since no time passes
        self.classes = classes_of(plan)

    @property
    def simulation(self) -> Simulation:
        """In the world of the last shard."""
        assert self._sim is not None
        return self._sim

    def prepare(self, shard: Shard) -> None:
        """Go into the world of a shard."""
        self._in_world(shard.world)

    def last_readings(self) -> dict[str, Reading]:
        """The readings of the sample that came last, as those of a fleet of one."""
        readings, lane = self._last
        return {name: self._alone(name, reading, lane) for name, reading in readings.items()}

    def _alone(self, name: str, reading: Reading, lane: int) -> Reading:
        if name not in self._lanewise:  # extras that have lanes, and no tables: those whose size follows the poses
            assert self._sim is not None
            rig, batch = self.plan.rig, self.plan.config.batch
            other = self._sim.observe(rig.agent, np.tile([0.0, 0.0, -1.0], (batch + 1, 1)), sensors=[name])[name]
            grown = (k for k, v in other.extras.items() if np.shape(v)[:1] != np.shape(reading.extras[k])[:1])
            self._lanewise[name] = frozenset(grown)
        one = slice(lane, lane + 1)
        extras = {k: v[one] if k in self._lanewise[name] else v for k, v in reading.extras.items()}
        return replace(
            reading, data=reading.data[one], truth=reading.truth[one], valid=reading.valid[one], extras=extras
        )

    def samples(self, shard: Shard) -> Iterator[Sample]:
        """The samples of a shard, in order; the same whatever was made before.

        Raises:
            InputError: a world that cannot be built, or without free places.
        """
        sim, plan = self._in_world(shard.world), self.plan
        keys, size = plan.config.poses, plan.config.batch
        mount = self._config(plan.rig.aim)
        try:
            source = PoseSource(keys, sim.world, (mount.position_m, mount.q_body_sensor))
            numbers = range(shard.first, shard.first + shard.count)
            poses = [source.draw(stream(plan.config.seed, "pose", index)) for index in numbers]
        except InputError as error:
            raise InputError(
                f"world {shard.world} (seed {plan.values(shard.world).get('world.seed')}): {error}"
            ) from None
        batches = -(-plan.config.shard_size // size)
        for number in range(-(-shard.count // size)):
            part = poses[number * size : (number + 1) * size]
            readings = self._observe(sim, part, episode=shard.index * batches + number)
            for lane, pose in enumerate(part):
                self._last = readings, lane
                yield self._sample(shard, shard.first + number * size + lane, pose, lane, readings)

    def _in_world(self, world: int) -> Simulation:
        values = self.plan.rig.follow(self.plan.values(world))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MountWarning)  # it waits in the air
            if self._sim is None:
                self._sim = Simulation.load(self.plan.rig.scenario, overrides=values, trust=True)
            elif world != self._world and values:
                self._world = -1
                self._sim.load_world(overrides=values)
        if world != self._world:
            self._space = self._sim.boxes_3d()
        self._world = world
        return self._sim

    def _observe(self, sim: Simulation, poses: list[SampledPose], *, episode: int) -> dict[str, Reading]:
        """Always of `batch` poses, so that one kernel serves all."""
        lanes = [*poses, *[poses[-1]] * (self.plan.config.batch - len(poses))]
        places, attitudes = np.stack([p.position for p in lanes]), np.stack([p.attitude for p in lanes])
        rig = self.plan.rig
        return sim.observe(rig.agent, places, attitudes, sensors=rig.sensors, episode=episode)

    def _config(self, sensor: str) -> SensorConfig:
        assert self._sim is not None
        found: SensorConfig = self._sim.model.agents[self.plan.rig.agent].sensors[sensor].config
        return found

    def _sample(
        self, shard: Shard, index: int, pose: SampledPose, lane: int, readings: Mapping[str, Reading]
    ) -> Sample:
        arrays = {name: np.array(reading.data[lane]) for name, reading in readings.items()}
        about = {
            "drawn": self.plan.values(shard.world),
            "valid": {name: bool(reading.valid[lane]) for name, reading in readings.items()},
            "calibration": {name: self._calibration(name) for name in readings},
        }
        kind = self.plan.config.image_format
        return Sample(index, shard.world, shard.split, pose, arrays, self._things(arrays), about, kind)

    def _things(self, arrays: Mapping[str, NDArray[Any]]) -> list[Thing]:
        labels = self.plan.rig.labels
        if "instance" not in labels:
            return []
        instances = arrays[labels["instance"]]
        space = self._space
        label_of = np.zeros(int(instances.max()) + 1, dtype=np.uint8)
        for instance, box in space.items():
            if instance < len(label_of):
                label_of[instance] = box.label
        found = []
        for box_seen in boxes(instances, label_of[instances], least_area=self.plan.config.least_area_px):
            if box_seen.label in self.classes:
                number, name = self.classes[box_seen.label]
                found.append(Thing(box_seen, number, name, space.get(box_seen.instance)))
        return found

    def _calibration(self, sensor: str) -> dict[str, Any]:
        config = self._config(sensor)
        told: dict[str, Any] = {
            "type": config.type,
            "position_m": list(config.position_m),
            "attitude_wxyz": list(config.q_body_sensor),
        }
        if isinstance(config, ViewConfig):
            told |= {"width_px": config.width_px, "height_px": config.height_px, "lens": config.lens}
            told |= {"matrix": view_intrinsics(config).matrix().tolist(), "distortion": list(config.distortion)}
        else:
            plain = config.model_dump(mode="json")
            told |= {k: v for k, v in plain.items() if k in _GEOMETRY and v is not None}
        return told


_GEOMETRY = ("beams", "bins", "range_min_m", "range_max_m", "horizontal_aperture_deg", "vertical_beamwidth_deg")


def classes_of(plan: Plan) -> dict[int, tuple[int, str]]:
    """Class number and name by label: those asked for in their order, or all labels of objects by number."""
    user: dict[str, int] = dict(getattr(plan.scenario.world, "labels", {}) or {})
    known = {name: label.number for name, label in LABELS.items()} | user
    names = plan.config.classes or tuple(n for n in sorted(known, key=lambda n: known[n]) if n not in GROUND)
    return {known[name]: (number, name) for number, name in enumerate(names)}


def camera_pose(sample: Sample, sensor: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Place `(3,)` world NWU [m] and rotation matrix `(3, 3)`, sensor to world, of a sensor in a sample."""
    told = sample.about["calibration"][sensor]
    body = np.broadcast_to(sample.pose.attitude, (3, 4))
    mount = rotate_np(np.broadcast_to(np.array(told["attitude_wxyz"]), (3, 4)), np.eye(3))
    turn = rotate_np(body, mount).T
    at = rotate_np(sample.pose.attitude[None], np.array(told["position_m"])[None])[0]
    return sample.pose.position + at, turn
