"""Instruments that sample the water."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Literal

import gsw
import numpy as np
import pytest

from pelagos import jit
from pelagos.errors import LookupFailed
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.scene import Scene
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.ray_sensor import RaySensor
from pelagos.sensors.sensor import SensorConfig, SensorContext
from pelagos.sensors.water.ctd import Ctd
from pelagos.sensors.water.current_meter import CurrentMeter
from pelagos.sensors.water.fluorometer import Fluorometer
from pelagos.sensors.water.oxygen import Oxygen
from pelagos.sensors.water.sound_velocity import SoundVelocity
from pelagos.sensors.water.tracer import Tracer
from pelagos.sensors.water.turbidity import Turbidity

DT = 100_000_000
QUIET = {"noise_density": 0, "bias_std": 0, "drift_std": 0, "resolution": 0}
PROBES = {
    "fluorometer": Fluorometer, "oxygen": Oxygen, "turbidity": Turbidity, "sound_velocity": SoundVelocity,
    "current_meter": CurrentMeter, "ctd": Ctd, "tracer": Tracer,
}  # fmt: skip


def context(**ocean) -> SensorContext:
    config = {
        "temperature_c": {"depth_m": [0, 50], "value": [20, 10]},
        "salinity": 38.0,
        "tracers": {
            "chlorophyll": {"depth_m": [0, 20, 60], "value": [0.5, 4.0, 0.2]},
            "oxygen": 240.0,
            "turbidity": 3.0,
        },
        "currents": {"type": "uniform", "speed_mps": 0.5, "towards_deg": 90},
        **ocean,
    }
    world = SimpleNamespace(origin=GeoOrigin(45.0, 13.0))
    return SensorContext(
        "auv0.x", 3, DT, None, world, build_ocean(OceanConfig.model_validate(config), world), np.zeros(1)
    )


def make(name: str, where: SensorContext, **keys):
    if name == "tracer":
        keys.setdefault("tracer", "oxygen")
    return PROBES[name](PROBES[name].Config(**keys), where)


def at(*z, **more):
    return lanes(range(len(z)), dt_ns=DT, position=[(0, 0, v) for v in z], **more)


@pytest.mark.parametrize(
    ("name", "expected"),
    [("fluorometer", [0.5, 4.0, 2.1]), ("oxygen", [240] * 3), ("turbidity", [3] * 3), ("tracer", [240] * 3)],
)
def test_reads_its_tracer(name, expected) -> None:
    read = make(name, context(), **QUIET).sense(at(-1e-6, -20, -40))
    assert read.data == pytest.approx(expected, abs=1e-6)
    assert read.truth == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", PROBES)
def test_reads_nothing_in_the_air(name) -> None:
    read = make(name, context()).sense(at(-1.0, 0.5))
    assert read.valid.tolist() == [True, False]
    assert np.isfinite(read.data[0]).all()
    assert np.isnan(read.data[1]).all()


def test_troughs_bare_an_instrument_and_crests_cover_it() -> None:
    """Mounts 0.6 m over and under the mean level in waves of 1 m amplitude, 7 s, a few metres apart."""
    where = context(waves={"type": "regular", "height_m": 2.0, "period_s": 7.0, "towards_deg": 40.0})
    places = [(4.0 * k, -3.0 * k, z) for k in range(12) for z in (-0.6, 0.6)]
    got = make("turbidity", where, **QUIET).sense(lanes([0] * len(places), dt_ns=DT, position=places))
    x, y, z = np.array(places).T
    level = np.array(where.ocean.elevation(jit.Float64(x), jit.Float64(y), jit.Float64(0.0)))
    covered = z < level
    assert covered[z > 0].sum() > 0
    assert (~covered)[z < 0].sum() > 0
    np.testing.assert_array_equal(np.ravel(got.valid), covered)
    np.testing.assert_array_equal(np.isfinite(np.ravel(got.data)), covered)


@pytest.mark.parametrize("name", PROBES)
def test_blocks_and_fleets_give_the_same_bytes(name) -> None:
    sensor = make(name, context(), **({"noise_density": 1.0} if name == "tracer" else {}))
    block = sensor.sense(lanes(range(6), dt_ns=DT, environments=range(5), position=(0, 0, -3))).data
    alone = [sensor.sense(lanes([t], dt_ns=DT, position=(0, 0, -3))).data for t in range(6)]
    assert np.array_equal(block[::5], np.concatenate(alone))
    assert len(np.unique(block.reshape(30, -1)[:, 0])) > 3


def test_missing_tracer_is_named() -> None:
    with pytest.raises(LookupFailed, match=r"auv0\.x measures 'methane'"):
        make("tracer", context(), tracer="methane")
    with pytest.raises(LookupFailed, match="known: oxygen"):
        make("fluorometer", context(tracers={"oxygen": 1.0}))


def test_sound_velocity_is_that_of_the_water() -> None:
    read = make("sound_velocity", context(), **QUIET).sense(at(-25.0))
    p = gsw.p_from_z(-25.0, 45.0)
    sa = gsw.SA_from_SP(38.0, p, 13.0, 45.0)
    assert read.data[0] == pytest.approx(gsw.sound_speed(sa, gsw.CT_from_t(sa, 15.0, p), p), abs=0.01)


def test_ctd_gives_back_salinity_and_sound_speed() -> None:
    keys = {n: 0 for n in Ctd.Config.model_fields if n.endswith(("_density", "_std"))}
    read = make("ctd", context(), **keys).sense(at(-25.0, -40.0))
    assert read.data[0] == pytest.approx([0.1 * gsw.C_from_SP(38.0, 15.0, read.data[0, 2]), 15.0, 25.196], abs=2e-3)
    assert read.extras["salinity"] == pytest.approx([38.0, 38.0], abs=1e-9)
    speed = make("sound_velocity", context(), **QUIET).sense(at(-25.0, -40.0)).data
    assert read.extras["sound_speed"] == pytest.approx(speed, abs=0.1)  # exact against 75 terms
    noisy = make("ctd", context()).sense(at(-25.0))
    assert noisy.extras["salinity"][0] != pytest.approx(38.0, abs=1e-7)
    assert noisy.extras["salinity"][0] == pytest.approx(38.0, abs=0.01)


def test_current_meter_sees_water_minus_own_motion() -> None:
    """Heading east at 2 m/s in 0.5 m/s going east: the water comes from ahead at 1.5 m/s; with a yaw rate and a lever
    arm.
    """
    east = (np.cos(np.pi / 4), 0, 0, -np.sin(np.pi / 4))
    moving = {"attitude": east, "velocity": (2, 0, 0), "angular_velocity": (0, 0, 0.5)}
    read = make("current_meter", context(), **QUIET, position_m=(1, 0, 0)).sense(at(-5.0, **moving))
    assert read.data[0] == pytest.approx([-1.5, -0.5, 0], abs=1e-12)
    wave = {"type": "regular", "height_m": 1, "period_s": 6, "towards_deg": 90}
    still = make("current_meter", context(waves=wave, currents=()), **QUIET).sense(at(-2.0))
    k = (2 * np.pi / 6) ** 2 / 9.81
    assert still.data[0, 1] < -0.5 * 2 * np.pi / 6 * np.exp(-k * 2.6)


class Bath(RaySensor):
    """The water that a sensor of rays is told."""

    class Config(SensorConfig):
        type: Literal["bath"] = "bath"
        range_max_m: float = 5.0

    def pattern(self, config):
        return [[0.0, 0.0, -1.0], [1.0, 0.0, -0.5]]

    def read(self, hits, medium, draw, rays):
        told = {name: getattr(medium, name) for name in ("sound_speed", "temperature", "salinity")}
        return {"data": medium.depth, "truth": medium.depth, **told}


def test_rays_are_told_the_water_at_their_mount():
    """Depth is positive in the water and negative in the air; a mount above the body is less deep."""
    place = np.array([[0.0, 0.0, -12.0], [3.0, -4.0, -30.0], [1.0, 2.0, 0.4]])
    own = replace(context(), scene=Scene([]))
    motion = replace(lanes([0, 1, 2], dt_ns=DT), position=jit.Array3f64(place.T.copy()))
    seen = Bath(Bath.Config(rate_hz=5.0, position_m=(0.0, 0.0, 0.5)), own).sense(motion)
    assert seen.data == pytest.approx([11.5, 29.5, -0.9], abs=1e-6)
    assert seen.extras["temperature"] == pytest.approx(20 - 10 * np.array([11.5, 29.5, 0.0]) / 50, abs=1e-2)
    assert seen.extras["salinity"] == pytest.approx(38.0)
    bath = Bath(Bath.Config(rate_hz=5.0, position_m=(0.0, 0.0, 0.5)), own)
    told = {name: values for name, values, _ in bath.explain(motion)}
    np.testing.assert_array_equal(told["data"], seen.data)
    np.testing.assert_array_equal(told["temperature"], seen.extras["temperature"])


def test_errors_of_a_ctd_are_each_its_own() -> None:
    """White noise d sqrt(rate), new each tick, and a constant offset, of 1000 copies; salinity follows what is read."""
    std = {"conductivity": (3e-4, 2e-3), "temperature": (2e-3, 7e-3), "pressure": (0.04, 0.11)}
    keys = {f"{name}_noise_density": d for name, (d, _) in std.items()}
    keys |= {f"{name}_bias_std": b for name, (_, b) in std.items()}
    read = make("ctd", context(), rate_hz=9.0, **keys).sense(
        lanes([3, 4], dt_ns=DT, environments=range(1000), position=(0, 0, -8))
    )
    error = (read.data - read.truth).reshape(2, 1000, 3)
    spread = 4 / np.sqrt(2 * 1000)
    white, bias = np.array(list(std.values())).T
    assert (error[1] - error[0]).std(axis=0) == pytest.approx(np.sqrt(2) * 3.0 * white, rel=spread)
    assert error.std(axis=(0, 1)) == pytest.approx(np.sqrt(9 * white**2 + bias**2), rel=1.3 * spread)
    assert np.abs(np.corrcoef(error[0].T) - np.eye(3)).max() < 4 / np.sqrt(1000)
    row = read.data[5]
    assert read.extras["salinity"][5] == pytest.approx(gsw.SP_from_C(10 * row[0], row[1], row[2]), abs=1e-12)
    absolute = gsw.SA_from_SP(read.extras["salinity"][5], row[2], 13.0, 45.0)
    assert read.extras["sound_speed"][5] == pytest.approx(gsw.sound_speed_t_exact(absolute, row[1], row[2]), abs=1e-9)


def test_errors_of_a_probe_add_and_its_readings_end_at_its_limits() -> None:
    """Noise 0.2 sqrt(4), offset 0.9, drift 0.5 about 240, of 1000 copies; within 239.5 and 241, in steps of 0.25."""
    keys = {"noise_density": 0.2, "bias_std": 0.9, "drift_std": 0.5, "rate_hz": 4.0, "resolution": 0.0}
    motion = lanes([3, 4], dt_ns=DT, environments=range(1000), position=(0, 0, -8))
    error = (make("oxygen", context(), **keys).sense(motion).data - 240.0).reshape(2, 1000)
    spread = 4 / np.sqrt(2 * 1000)
    assert error[0].std() == pytest.approx(np.sqrt(0.16 + 0.81 + 0.25), rel=spread)
    assert (error[1] - error[0]).std() == pytest.approx(np.sqrt(2) * 0.4, rel=spread)
    steady = make("oxygen", context(), **keys | {"noise_density": 0.0, "bias_std": 0.0, "drift_time_s": 2.0})
    times = lanes([0, 40], dt_ns=DT, environments=range(1000), position=(0, 0, -8))
    drift = (steady.sense(times).data - 240.0).reshape(2, 1000)
    assert drift.std(axis=1) == pytest.approx([0.5, 0.5], rel=spread)
    assert np.corrcoef(drift)[0, 1] == pytest.approx(np.exp(-40 * DT * 1e-9 / 2.0), abs=4 / np.sqrt(1000))
    held = (
        make("oxygen", context(), **keys | {"resolution": 0.25, "lowest": 239.5, "highest": 241.0}).sense(motion).data
    )
    assert sorted(set(held)) == [239.5, 239.75, 240.0, 240.25, 240.5, 240.75, 241.0]
    np.testing.assert_allclose(held, np.clip(np.round((error.ravel() + 240) * 4) / 4, 239.5, 241.0))
