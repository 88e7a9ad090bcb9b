"""The three doors for a sensor of one's own: their examples run, and keep the rules that built-in sensors keep."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from pelagos import jit
from pelagos.cli.explain import explain_sensor
from pelagos.config import registry
from pelagos.errors import CommandError, KernelError
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.noise import NumpyNoise
from pelagos.sensors.ray_sensor import RaySensor
from pelagos.sensors.sensor import Measurement, SensorConfig, SensorContext
from pelagos.sensors.sensor_check import check_sensor

EXAMPLES = Path(__file__).parents[2] / "examples"
DOORS = {
    "sensor_numpy.py": ("Plumb", r"^\[1[56]\.\d+.*\] for \[16\. 16\."),
    "sensor_rays.py": ("Alarm", r"m for 12\.4\d\d m, echo after 16\.\d+ ms"),
    "sensor_drjit.py": ("TurnRate", r"^mean 0\.(300|299|301)\d* rad/s, standard deviation 0\.0(099|10[01])"),
}


@pytest.mark.parametrize("name", DOORS)
def test_it_runs_and_reads_what_it_should(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    import re

    runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    said = capsys.readouterr().out
    assert re.search(DOORS[name][1], said), said


@pytest.mark.parametrize("name", DOORS)
def test_it_reads_the_same_in_blocks_and_one_by_one(name: str) -> None:
    made = runpy.run_path(str(EXAMPLES / name))
    cls = made[DOORS[name][0]]
    sensor = cls(cls.Config(), SensorContext.alone("a.b", copies=2, seed=3))
    place = {"position": (3.0, -2.0, -4.0), "angular_velocity": (0.1, -0.2, 0.3), "environments": (0, 1)}
    block = sensor.sense(lanes(range(3), dt_ns=10_000_000, **place))
    single = [sensor.sense(lanes([k], dt_ns=10_000_000, **place)) for k in range(3)]
    assert block.data.tobytes() == np.concatenate([one.data for one in single]).tobytes()
    assert block.truth.tobytes() == np.concatenate([one.truth for one in single]).tobytes()


@pytest.mark.parametrize("name", DOORS)
def test_it_passes_the_check_that_authors_have(name: str) -> None:
    check_sensor(runpy.run_path(str(EXAMPLES / name))[DOORS[name][0]])


class Wrong:
    """A sensor of which subclasses break one rule each."""

    Config = SensorConfig

    def __init__(self, config: SensorConfig, context: SensorContext) -> None:
        self.last: float | None = None
        self.random = np.random.default_rng(context.seed)


class LowPass(Wrong):
    def sense(self, motion):
        out = []
        for value in np.array(motion.tick, dtype=float):
            self.last = value if self.last is None else 0.5 * (self.last + value)
            out.append(self.last)
        return Measurement(np.array(out), np.array(out))


class OwnGenerator(Wrong):
    def sense(self, motion):
        truth = np.array(motion.position)[2]
        return Measurement(truth + self.random.normal(size=truth.shape), truth)


class Transposed(Wrong):
    def sense(self, motion):
        return Measurement(np.array(motion.position), np.array(motion.position))


class NothingThere(Wrong):
    def sense(self, motion):
        return Measurement(np.full(len(motion.tick), np.nan), np.zeros(len(motion.tick)))


@pytest.mark.parametrize(
    ("kind", "told"),
    [
        (LowPass, r"LowPass, asked tick by tick: 'data' of tick \d is .* keeps nothing from reading to reading"),
        (OwnGenerator, r"OwnGenerator, asked tick by tick: 'data' of tick 3 is"),
        (Transposed, r"Transposed.sense: 'data' is \(3, 6\); it has 6 lanes as its first axis"),
        (NothingThere, r"NothingThere.sense: data of valid lanes are not finite.*MAY_LACK"),
    ],
)
def test_the_check_names_the_rule_that_a_sensor_breaks(kind: type, told: str) -> None:
    with pytest.raises(KernelError, match=told):
        check_sensor(kind, SensorConfig(type="wrong", rate_hz=10))


class Ahead(RaySensor):
    """Two rays ahead and down, over a flat bottom."""

    Config = SensorConfig
    found = staticmethod(lambda hits, rays: {"data": hits.t})

    def pattern(self, config):
        return [[1.0, 0.0, -1.0], [1.0, 0.2, -1.0]]

    def reach(self, config):
        return 40.0

    def read(self, hits, medium, draw, rays):
        return self.found(hits, rays)


@pytest.mark.parametrize(
    ("found", "told"),
    [
        (lambda hits, rays: {"data": hits.t}, r"Ahead.read returns results by name, at least 'data' and 'truth'"),
        (lambda hits, rays: None, r"Ahead.read returns results by name.*NoneType"),
        (lambda hits, rays: {"data": hits.t, "truth": hits.t}, r"'data' has 6 values for 3 lanes of 2 rays: make one"),
    ],
)
def test_a_pattern_of_rays_is_told_what_its_reading_lacks(found, told: str) -> None:
    kind = type("Ahead", (Ahead,), {"found": staticmethod(found)})
    sensor = kind(SensorConfig(type="x", rate_hz=10), SensorContext.alone(world={"type": "flat", "depth_m": 20.0}))
    with pytest.raises(KernelError, match=told):
        sensor.sense(lanes(range(3), dt_ns=10_000_000, position=(3.0, -2.0, -4.0)))


def test_constants_of_a_pattern_of_rays_are_spread_over_its_lanes() -> None:
    kind = type("Ahead", (Ahead,), {"found": lambda *_: {"data": jit.Float64(2.5), "truth": jit.Array3f(1, -2, 3)}})
    sensor = kind(SensorConfig(type="x", rate_hz=10), SensorContext.alone())
    found = sensor.sense(lanes(range(3), dt_ns=10_000_000, position=(3.0, -2.0, -4.0)))
    np.testing.assert_array_equal(found.data, [2.5, 2.5, 2.5])
    np.testing.assert_array_equal(found.truth, [[1, -2, 3]] * 3)


def test_two_sensors_of_a_type_have_their_own_numpy_noise() -> None:
    motion = lanes(range(4), dt_ns=10_000_000, environments=(0, 1))
    one, other = (NumpyNoise(3, path).normals(motion, 2) for path in ("auv0.left", "auv0.right"))
    assert one.shape == (8, 2)
    assert len(np.unique([*one.ravel(), *other.ravel()])) == 32


def test_rows_of_motion_and_rays_that_do_not_fit_the_lanes_are_refused() -> None:
    with pytest.raises(CommandError, match=r"motion of 2 lanes takes rows \(3,\) or \(2, 3\), not \(3, 2\)"):
        lanes(range(2), dt_ns=10_000_000, position=np.zeros((3, 2)))
    motion = lanes(range(2), dt_ns=10_000_000)
    with pytest.raises(CommandError, match=r"origins \(3, 2\) .* for 2 lanes; both are \(2, 3\)"):
        SensorContext.alone().cast(motion, np.zeros((3, 2)), np.ones((3, 2)))


class BareConfig(SensorConfig):
    type: Literal["bare"] = "bare"
    rate_hz: float = 10.0


class Bare:
    """Depth, from a class that has what the page asks for and nothing more."""

    Config = BareConfig

    def __init__(self, config: BareConfig, context: SensorContext) -> None:
        pass

    def sense(self, motion):
        depth = -np.array(motion.position)[2]
        return Measurement(depth, depth)


def test_explain_shows_a_sensor_that_has_only_what_the_page_asks_for(monkeypatch, tmp_path, capsys) -> None:
    found = {"bare": registry.Entry("sensor", "bare", f"{__name__}:Bare", "bare")}
    monkeypatch.setattr(registry, "_plugins", lambda kind: found if kind == "sensor" else {})
    file = tmp_path / "s.yaml"
    agent = "{vehicle: remus100, start: {depth_m: 5}, sensors: {it: {type: bare}}}"
    file.write_text(f"world: {{type: flat, depth_m: 20}}\nagents:\n  auv0: {agent}\n", encoding="utf-8")
    explain_sensor(file, [], "auv0.it", at_s=0.0)
    assert "Bare.sense" in capsys.readouterr().out
