"""Seas and turbidity that are drawn for every copy and episode: what a copy feels and sees is what a run of its own
would, with the numbers that were drawn written into its scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.envs.fleet import FleetEnv
from pelagos.envs.tasks.station_keeping import StationKeeping
from pelagos.errors import CommandError, InputError
from pelagos.ocean.wave_system import JonswapWavesConfig, RegularWavesConfig, SeaStateWavesConfig
from pelagos.ocean.waves import Changed, Waves, waves_by_copy, waves_of

SEA: dict[str, Any] = {
    "ocean.waves.0.significant_height_m": {"uniform": [0.3, 1.5]},
    "ocean.waves.0.peak_period_s": {"uniform": [3.5, 7]},
    "ocean.waves.0.towards_deg": {"uniform": [-180, 180]},
    "ocean.waves.0.seed": {"uniform": [0, 1e6]},
    "ocean.waves.1.phase_deg": {"normal": [10, 60]},
}
WAVES = [
    {"type": "jonswap", "significant_height_m": 0.5, "peak_period_s": 5.0, "towards_deg": 40.0, "components_count": 37},
    {"type": "regular", "height_m": 0.3, "period_s": 8.0, "towards_deg": -70.0},
]
AT_S = 2.4


def scenario(vary: dict[str, Any], waves: list[dict[str, Any]] = WAVES, **ocean: Any) -> dict[str, Any]:
    boat = {
        "vehicle": "otter", "control": "actuators",
        "start": {"position_m": [6.0, -4.0], "heading_deg": 35.0, "speed_mps": 0.4},
        "sensors": {"gps": {"type": "gps", "rate_hz": 5, "position_m": [0.1, 0.2, 0.3], "antenna_height_m": 0.25}},
    }  # fmt: skip
    rov = {
        "vehicle": "bluerov2_heavy", "control": "actuators",
        "start": {"position_m": [1.0, -3.0, -2.5], "pitch_deg": 4.0},
        "sensors": {
            "depth": {"type": "depth", "rate_hz": 5},
            "ctd": {"type": "ctd", "rate_hz": 5},
            "sonar": {"type": "imaging_sonar", "rate_hz": 5, "beams": 16, "bins": 40, "range_max_m": 12.0,
                      "orientation_deg": [0, -25, 20]},
            "label": {"type": "depth_camera", "rate_hz": 5, "width_px": 16, "height_px": 16,
                      "orientation_deg": [0, -50, 30]},
        },
    }  # fmt: skip
    return {
        "world": {"type": "flat", "depth_m": 9.0}, "tick_rate_hz": 50, "ocean": {"waves": waves, **ocean},
        "agents": {"boat": boat, "rov": rov}, "vary": vary,
    }  # fmt: skip


def written(config: dict[str, Any], drawn: dict[str, np.ndarray], copy: int) -> dict[str, Any]:
    """The scenario with what was drawn for a copy in it."""
    found = {**config, "vary": {}, "ocean": {**config["ocean"]}}
    found["ocean"]["waves"] = [dict(system) for system in config["ocean"].get("waves", [])]
    for key, values in drawn.items():
        _, name, *rest = key.split(".")
        value = float(values[copy])
        if name == "waves":
            found["ocean"]["waves"][int(rest[0])][rest[1]] = round(value) if rest[1] == "seed" else value
        else:
            found["ocean"][name] = value
    return found


def run(sim: pl.Simulation) -> dict[str, np.ndarray]:
    ticks = round(AT_S * 50)
    obs = sim.step({"boat": np.array([40.0, 55.0]), "rov": np.linspace(-0.4, 0.5, 8)}, ticks=ticks)
    found = {f"{a}.{s}": r.data for a, sensors in obs.items() for s, r in sensors.items()}
    return found | {f"{a}.{k}": getattr(sim.state[a], k) for a in ("boat", "rov") for k in ("position", "velocity")}


def test_a_copy_in_its_sea_is_a_run_in_that_sea() -> None:
    config = scenario(SEA)
    fleet = pl.Simulation.load(config, n=3, seed=4)
    whole = run(fleet)
    assert np.ptp(whole["boat.position"][:, 2]) > 0.02  # the seas do differ
    assert np.ptp(whole["rov.depth"]) > 0.01
    one = run(pl.Simulation.load(config, n=1, seed=4, environment=1))
    for name, values in whole.items():
        np.testing.assert_array_equal(values[1], one[name][0], err_msg=name)
    alone = run(pl.Simulation.load(written(config, fleet.drawn, 2), n=1, seed=4, environment=2))
    for name, values in whole.items():
        # where a float starts is the same height, added up in another order; rays are of single precision
        close = 2e-6 if name in ("rov.sonar", "rov.label") else 1e-9
        np.testing.assert_allclose(alone[name][0], values[2], rtol=close, atol=close, err_msg=name)


def test_what_floats_starts_on_the_surface_of_its_copy() -> None:
    sim = pl.Simulation.load(scenario(SEA), n=4, seed=6)
    position, heading = sim.state["boat"].position, np.radians(35.0)
    size = sim.scenario.members["boat"].vehicle
    ahead, aside = np.meshgrid(np.linspace(-0.4, 0.4, 9) * size.length_m, np.linspace(-0.4, 0.4, 3) * size.beam)
    x = 6.0 + np.cos(heading) * ahead - np.sin(heading) * aside
    y = -4.0 - np.sin(heading) * ahead - np.cos(heading) * aside
    for copy in range(4):
        sea = sim.ocean.fields.elevation(
            jit.Float64(x.ravel()), jit.Float64(y.ravel()), jit.Float64(0.0), jit.UInt32(copy)
        )
        assert position[copy, 2] == pytest.approx(float(np.mean(np.array(sea))), abs=1e-12)
    assert np.ptp(position[:, 2]) > 0.02


def test_a_reset_of_some_draws_their_seas_and_leaves_the_others_alone() -> None:
    sim, other = (pl.Simulation.load(scenario(SEA), n=3, seed=4) for _ in range(2))
    first = {key: values.copy() for key, values in sim.drawn.items()}
    for s in (sim, other):
        run(s)
    sim.reset(where=[False, True, False])
    for key, values in sim.drawn.items():
        assert (values != first[key]).tolist() == [False, True, False]
    a, b = run(sim), run(other)
    for name in ("boat.position", "rov.velocity", "rov.sonar"):
        np.testing.assert_array_equal(a[name][[0, 2]], b[name][[0, 2]])
        assert (a[name][1] != b[name][1]).any()
    kept, fork = sim.checkpoint(), sim.fork()
    ahead, beside = run(sim), run(fork)
    sim.restore(kept)
    for name, values in run(sim).items():
        np.testing.assert_array_equal(values, ahead[name])
        np.testing.assert_array_equal(values, beside[name])


@pytest.mark.parametrize("depth", [None, 6.0])
def test_functions_of_a_sea_of_many_are_those_of_each(depth: float | None) -> None:
    rng = np.random.default_rng(3)
    systems = [
        JonswapWavesConfig(significant_height_m=0.8, peak_period_s=4.0, towards_deg=-70.0, components_count=21),
        RegularWavesConfig(height_m=0.4, period_s=6.0, towards_deg=120.0, phase_deg=-33.0),
        SeaStateWavesConfig(state=0),
    ]
    seas = [s.components(np.random.default_rng(k), depth) for k, s in enumerate(systems)]
    together = waves_by_copy(seas, count=40, depth=depth, wind=None)
    copy = np.array([2, 0, 1, 1, 0, 2, 0], dtype=np.uint32)
    x, y, t = rng.uniform(-60, 60, (3, len(copy)))
    z = np.array([-3.0, 0.4, -0.2, -5.0, -1.0, 0.0, -0.1])

    def asked(waves: Waves, rows: Any) -> list[np.ndarray]:
        px, py, pz, when = (jit.Float64(v[rows]) for v in (x, y, z, t))
        place = jit.Array3f64(px, py, pz)
        m = waves.motion(place, when)
        parts = [waves.elevation(px, py, when), *waves.slope(px, py, when), *waves.head(place, when), waves.drift(pz)]
        parts += [m.elevation, m.velocity, m.acceleration, m.head, waves.foam(px, py, when)]
        return [np.atleast_2d(np.array(p)) for p in parts]

    whole = asked(together.at(jit.UInt32(copy)), slice(None))
    for k, sea in enumerate(seas):
        rows = copy == k
        if not len(sea.amplitude):
            assert all(np.abs(v[:, rows]).max() == 0 for v in whole)
            continue
        for mine, theirs in zip(whole, asked(waves_of(sea, depth=depth), rows), strict=True):
            np.testing.assert_allclose(mine[:, rows], np.broadcast_to(theirs, mine[:, rows].shape), atol=1e-14)


def picture(turbidity: float | None, **options: Any) -> tuple[pl.Simulation, dict[str, np.ndarray]]:
    rov = {
        "vehicle": "bluerov2_heavy", "control": "actuators", "start": {"position_m": [0, 0, -3.0], "heading_deg": 25},
        "sensors": {
            "camera": {"type": "camera", "rate_hz": 5, "width_px": 24, "height_px": 18, "exposure": "manual",
                       "iso": 100, "orientation_deg": [0, 25, -10], "lamps": [{"position_m": [0.2, 0.1, 0.0]}]},
            "lidar": {"type": "lidar", "rate_hz": 5, "channels": 4, "points_per_second": 2000, "rotation_hz": 5,
                      "upper_fov_deg": -20, "lower_fov_deg": -80, "reflectance": True},
        },
    }  # fmt: skip
    ocean = {"water_type": "1C", "tracers": {"chlorophyll": 0.8}}
    config = {
        "world": {"type": "flat", "depth_m": 6.0}, "tick_rate_hz": 50, "agents": {"rov": rov}, "ocean": ocean,
    }  # fmt: skip
    if turbidity is None:
        config["vary"] = {"ocean.turbidity": {"uniform": [0.3, 4.0]}}
    else:
        config["ocean"] = ocean | {"turbidity": turbidity}
    sim = pl.Simulation.load(config, seed=8, **options)
    obs = sim.step({"rov": np.zeros(8)}, ticks=10)["rov"]
    return sim, {"camera": obs["camera"].data, "lidar": obs["lidar"].data, "light": obs["camera"].truth}


def test_a_copy_looks_through_its_water() -> None:
    fleet, whole = picture(None, n=3)
    drawn = fleet.drawn["ocean.turbidity"]
    steps = (drawn - 0.3) / 3.7 * 32
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)  # 33 kinds of water
    assert len(set(drawn)) == 3
    for copy in (1, 2):
        alone = picture(float(drawn[copy]), n=1, environment=copy)[1]
        for name, values in whole.items():
            np.testing.assert_array_equal(values[copy], alone[name][0], err_msg=name)
    assert len({values.tobytes() for values in whole["camera"]}) == 3


@pytest.mark.parametrize(
    ("vary", "said"),
    [
        ({"ocean.waves.2.height_m": {"uniform": [1, 2]}}, "no 'ocean.waves.2'; the scenario has 2 wave systems"),
        ({"ocean.waves.0.hight_m": {"uniform": [1, 2]}}, "no 'ocean.waves.0.hight_m'"),
        ({"ocean.waves.0.components_count": {"uniform": [1, 2]}}, "no 'ocean.waves.0.components_count'"),
        ({"ocean.waves.1.height_m": {"uniform": [-1, 2]}}, "height_m of waves of type regular cannot be -1"),
        ({"ocean.waves.0.peak_period_s": {"choice": [4, 0]}}, "peak_period_s of waves of type jonswap cannot be 0"),
        ({"ocean.turbidity": {"uniform": [-0.1, 1]}}, "a turbidity is from 0 to 1000"),
        ({"ocean.turbidity": {"choice": [1, 2000]}}, "a turbidity is from 0 to 1000"),
    ],
)
def test_what_cannot_be_drawn_is_told(vary: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said.replace("(", r"\(")):
        pl.Simulation.load(scenario(vary))


def test_tails_are_told_when_they_are_drawn() -> None:
    vary = {"ocean.waves.0.significant_height_m": {"normal": [0.1, 1.0]}}
    with pytest.raises(InputError, match=r"drawn for ocean.waves.0.significant_height_m in environment \d+: .*cannot"):
        pl.Simulation.load(scenario(vary), n=12, seed=1)


def test_what_is_drawn_is_not_set_besides(tmp_path: Path) -> None:
    sim = pl.Simulation.load(scenario(SEA | {"ocean.turbidity": {"uniform": [0.5, 1]}}), n=2)
    with pytest.raises(CommandError, match=r"draws ocean.waves.0.significant_height_m"):
        sim.ocean.set(keys={"waves": WAVES})
    with pytest.raises(CommandError, match=r"draws ocean.turbidity"):
        sim.ocean.set(turbidity=2.0)
    sim.ocean.set(keys={"weather.cloud": 0.4})


def test_light_that_carries_packets_goes_through_one_water() -> None:
    config = scenario({"ocean.turbidity": {"uniform": [0.5, 1]}})
    config["agents"]["rov"]["sensors"]["light"] = {"type": "optical_modem"}
    with pytest.raises(InputError, match=r"ocean.turbidity cannot differ from copy to copy: rov.light"):
        pl.Simulation.load(config)


def test_a_changed_sea_is_the_sea_turned_scaled_and_later() -> None:
    """Elevation and orbital motion at a place of the sea turned by a: those of the sea at the place turned back."""
    sea = waves_of(JonswapWavesConfig(significant_height_m=0.9, peak_period_s=4.5, towards_deg=25.0).components(
        np.random.default_rng(2), None
    ), depth=None)  # fmt: skip
    scale, turn, moment = np.array([0.6, 1.7, 0.0]), np.array([0.7, -2.1, 1.1]), np.array([311.0, -40.0, 5.0])
    place, t = np.array([[12.0, -7.0, 3.0], [-5.0, 9.0, 1.0], [-1.5, -0.4, -2.0]]), np.array([3.3, 8.1, 0.5])
    changed = sea.with_change(Changed(*(jit.Float64(v) for v in (scale, np.cos(turn), np.sin(turn), moment))))
    got = changed.motion(jit.Array3f64(place), jit.Float64(t), stretch=False)
    c, s = np.cos(turn), np.sin(turn)
    back = np.stack([c * place[0] + s * place[1], c * place[1] - s * place[0], place[2]])
    was = sea.motion(jit.Array3f64(back), jit.Float64(t + moment), stretch=False)
    u = np.array(was.velocity) * scale
    np.testing.assert_allclose(np.array(got.elevation), np.array(was.elevation) * scale, atol=1e-10)
    turned = np.stack([c * u[0] - s * u[1], s * u[0] + c * u[1], u[2]])
    np.testing.assert_allclose(np.array(got.velocity), turned, atol=1e-10)
    np.testing.assert_allclose(np.array(changed.height), float(sea.height[0]) * np.maximum(scale, 1e-6))


@pytest.mark.parametrize("own", [True, False])
def test_episodes_of_a_task_have_seas_of_their_own(own: bool) -> None:
    class Adrift(StationKeeping):
        def draw(self, random: pl.envs.Draws) -> pl.envs.Start:
            start = super().draw(random)
            sea = start.sea if own else pl.envs.Sea(scale=1.3, turn_rad=0.4, moment_s=50.0)
            return pl.envs.Start([2.0, -1.0, 0.0], memory={"yaw": 0.3}, current=[0.1, -0.2, 0.0], sea=sea)

    env = FleetEnv(Adrift(), 6, seed=3)
    env.reset(seed=3)
    for _ in range(30):
        env.step(np.zeros((6, 2), dtype=np.float32))
    spread = np.ptp(env.state["position"][:, 2])
    assert spread > 0.03 if own else spread == 0.0


def test_a_sea_without_waves_is_an_error() -> None:
    class Flat(StationKeeping):
        ocean = {}  # noqa: RUF012

    with pytest.raises(CommandError, match="draw gives a sea, but there are no waves"):
        FleetEnv(Flat(), 2)
