"""What holds for every navigation sensor: shapes, streams, frozen calls."""

from types import SimpleNamespace

import numpy as np
import pytest

from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.navigation.depth import Depth
from pelagos.sensors.navigation.gps import Gps
from pelagos.sensors.navigation.imu import Imu
from pelagos.sensors.navigation.magnetometer import Magnetometer
from pelagos.sensors.navigation.pose import Pose
from pelagos.sensors.navigation.velocity import Velocity
from pelagos.sensors.recorded import Program
from pelagos.sensors.sensor import SensorContext

DT = 5_000_000
SENSORS = {"imu": Imu, "depth": Depth, "gps": Gps, "magnetometer": Magnetometer, "pose": Pose, "velocity": Velocity}
SHAPES = {"imu": (6,), "depth": (), "gps": (3,), "magnetometer": (3,), "pose": (7,), "velocity": (3,)}


@pytest.fixture(scope="module")
def context() -> SensorContext:
    world = SimpleNamespace(origin=GeoOrigin(45.0, 13.0))
    ocean = build_ocean(OceanConfig(), world)
    return SensorContext("auv0.x", 1, DT, None, world, ocean, np.zeros(1, np.uint32))


def motion(ticks, environments=(0,), z=0.5):
    """A body that turns as it goes, above the water so that all sensors work."""
    t = np.repeat(np.asarray(ticks) * DT * 1e-9, len(environments))
    zero = 0 * t
    return lanes(
        ticks,
        dt_ns=DT,
        environments=environments,
        position=np.stack([t, -t, z + zero], -1),
        attitude=np.stack([np.cos(t / 4), zero, zero, np.sin(t / 4)], -1),
        velocity=(1.0, 0.2, 0.0),
        angular_velocity=(0.0, 0.0, 0.5),
        acceleration=(0.1, 0.0, 0.0),
    )


def fields(measurement) -> dict[str, np.ndarray]:
    found = {"data": measurement.data, "truth": measurement.truth, **measurement.extras}
    return found if measurement.valid is None else {**found, "valid": measurement.valid}


def assert_same(one: dict, other: dict) -> None:
    assert one.keys() == other.keys()
    for name in one:
        assert np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f"), name


@pytest.mark.parametrize("name", SENSORS)
def test_shapes_and_finite_numbers(name: str, context: SensorContext) -> None:
    cls = SENSORS[name]
    read = fields(cls(cls.Config(), context).sense(motion(range(4), (0, 1, 2))))
    assert read["data"].shape == read["truth"].shape == (12, *SHAPES[name])
    assert all(len(x) == 12 and np.isfinite(x).all() for x in read.values())


@pytest.mark.parametrize("name", SENSORS)
def test_step_by_step_equals_block(name: str, context: SensorContext) -> None:
    cls = SENSORS[name]
    sensor = cls(cls.Config(), context)
    block = fields(sensor.sense(motion(range(200, 213))))
    steps = [fields(sensor.sense(motion([tick]))) for tick in range(200, 213)]
    assert_same(block, {k: np.concatenate([s[k] for s in steps]) for k in block})


@pytest.mark.parametrize("name", SENSORS)
def test_copy_of_a_fleet_equals_a_run_alone(name: str, context: SensorContext) -> None:
    cls = SENSORS[name]
    sensor = cls(cls.Config(), context)
    fleet = fields(sensor.sense(motion(range(40, 43), range(64))))
    alone = fields(cls(cls.Config(), context).sense(motion(range(40, 43))))
    assert_same({k: v[::64] for k, v in fleet.items()}, alone)
    if name not in ("pose", "velocity"):
        rows = fleet["data"].reshape(3, 64, -1)[0, :, 0]
        assert len(np.unique(rows)) > 10  # rounding may make some equal


@pytest.mark.parametrize("name", SENSORS)
def test_frozen_equals_plain(name: str, context: SensorContext) -> None:
    cls = SENSORS[name]
    sensor = cls(cls.Config(), context)
    sensor.sense(motion(range(5)))
    frozen = fields(sensor.sense(motion(range(70, 75))))
    plain = cls(cls.Config(), context)
    plain._program = Program(plain._kernel, record=lambda kernel: kernel)
    assert_same(frozen, fields(plain.sense(motion(range(70, 75)))))


@pytest.mark.parametrize("name", ["imu", "depth", "gps", "magnetometer"])
def test_seed_and_path_name_the_noise(name: str, context: SensorContext) -> None:
    from dataclasses import replace

    cls = SENSORS[name]
    read = [
        cls(cls.Config(), c).sense(motion(range(8))).data
        for c in (context, replace(context, seed=1), replace(context, seed=2), replace(context, path="auv1.x"))
    ]
    assert np.array_equal(read[0], read[1])
    assert not np.array_equal(read[0], read[2])
    assert not np.array_equal(read[0], read[3])


@pytest.mark.parametrize("name", SENSORS)
def test_configuration_refuses_what_it_does_not_know(name: str) -> None:
    config = SENSORS[name].Config
    assert config.model_validate_json(config().model_dump_json()) == config()
    with pytest.raises(ValueError, match="rate"):
        config(rate=5)
    with pytest.raises(ValueError, match=r"greater than or equal to 0\.000001"):
        config(rate_hz=0)


@pytest.mark.parametrize("name", SENSORS)
def test_says_what_it_is(name: str) -> None:
    assert 10 < len(SENSORS[name].TITLE) < 90
    assert isinstance(SENSORS[name].SOURCES, tuple)
