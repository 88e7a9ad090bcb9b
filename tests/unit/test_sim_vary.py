"""Numbers that are drawn for every copy and episode: named by (seed, environment, episode), and felt."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import InputError

COMMAND = np.array([0.3, 0.25, 0.2, -0.1, 0.05, 0.1, -0.15, 0.2])
MASS, HEADING, NORTH = "agents.rov.factors.mass", "agents.rov.start.heading_deg", "ocean.current_mps.0"
VARY: dict[str, Any] = {
    HEADING: {"uniform": [-90, 90]},
    "agents.rov.start.position_m.1": {"normal": [3, 1]},
    "agents.rov.start.speed_mps": {"uniform": [0.1, 0.5]},
    MASS: {"uniform": [0.9, 1.1]},
    "agents.rov.factors.thrust": {"choice": [0.8, 1.2]},
    "agents.rov.factors.quadratic_damping": {"uniform": [0.5, 1.5]},
    NORTH: {"uniform": [-0.3, 0.3]},
}


def scenario(vary: dict[str, Any]) -> dict[str, Any]:
    rov = {
        "vehicle": "bluerov2_heavy",
        "control": "actuators",
        "start": {"position_m": [0, 0, -10], "pitch_deg": 5, "speed_mps": 0.25},
    }
    other = rov | {"start": {"position_m": [10, 8, -10]}}
    dvl = {"dvl": {"type": "dvl", "rate_hz": 5}}
    return {
        "world": {"type": "flat", "depth_m": 25}, "tick_rate_hz": 50,
        "agents": {"rov": rov | {"sensors": dvl}, "other": other}, "vary": vary,
    }  # fmt: skip


def load(n: int, vary: dict[str, Any] = VARY, **options: Any) -> pl.Simulation:
    return pl.Simulation.load(scenario(vary), n=n, seed=3, **options)


def moved(sim: pl.Simulation, steps: int = 4) -> list[np.ndarray]:
    for _ in range(steps):
        obs = sim.step({"rov": COMMAND, "other": COMMAND}, ticks=10)
    return [sim.state["rov"].position, sim.state["other"].position, obs["rov"]["dvl"].data]


def same(mine: list[np.ndarray], theirs: list[np.ndarray], rows: Any = slice(None)) -> None:
    for a, b in zip(mine, theirs, strict=True):
        np.testing.assert_array_equal(a[rows], b)


def test_a_copy_is_a_fleet_of_one_and_what_was_drawn_is_told() -> None:
    sim = load(3)
    drawn = sim.drawn
    assert sim.scenario.vary.keys() == drawn.keys()
    assert all(len(set(drawn[key])) == 3 for key in (HEADING, MASS, NORTH))
    np.testing.assert_allclose(np.degrees(-sim.state["rov"].euler[:, 2]), drawn[HEADING], atol=1e-9)
    np.testing.assert_allclose(np.degrees(-sim.state["rov"].euler[:, 1]), 5.0, atol=1e-9)
    np.testing.assert_array_equal(sim.state["rov"].position[:, 1], drawn["agents.rov.start.position_m.1"])
    np.testing.assert_allclose(sim.state["rov"].velocity[:, 0], drawn["agents.rov.start.speed_mps"], rtol=1e-12)
    whole = moved(sim)
    alone = load(1, environment=2)
    assert alone.drawn[MASS] == drawn[MASS][2]
    same(whole, moved(alone), [2])
    sim.reset()
    same(moved(sim), whole)


def test_partial_resets_forks_and_checkpoints() -> None:
    sim = load(3)
    moved(sim)
    kept, fork, before, first = sim.checkpoint(), sim.fork(), sim.state["rov"].position, sim.drawn
    sim.reset(where=[1])
    np.testing.assert_array_equal(sim.state["rov"].position[[0, 2]], before[[0, 2]])
    for key, values in sim.drawn.items():
        np.testing.assert_array_equal(values[[0, 2]], first[key][[0, 2]])
    second = sim.drawn[MASS][1]
    assert second != first[MASS][1]
    ahead, other = moved(sim), moved(fork)
    same(ahead[:2], [v[[0, 2]] for v in other[:2]], [0, 2])
    sim.restore(kept)
    same(moved(sim), other)
    again = load(1, environment=1)
    again.reset(episode=1)
    assert again.drawn[MASS] == second
    sim.reset(where=[1])
    assert sim.drawn[HEADING][1] == pytest.approx(np.degrees(-sim.state["rov"].euler[1, 2]), abs=1e-9)
    for mine, theirs in zip(vars(sim.state["rov"]).values(), vars(again.state["rov"]).values(), strict=True):
        np.testing.assert_array_equal(mine[1], theirs[0])


def test_factors_and_currents_act_as_they_do_alone() -> None:
    """A factor of 1 and no current change no byte; a current by `vary` is the one that `ocean.set` gives."""
    plain = moved(load(2, {}))
    same(moved(load(2, {"agents.rov.factors.thrust": {"choice": [1.0]}})), plain)
    strong = moved(load(2, {"agents.rov.factors.thrust": {"choice": [1.3]}}))
    assert (np.abs(strong[0] - plain[0]).max(axis=1) > 0.005).all()
    np.testing.assert_array_equal(strong[1], plain[1])  # the other has none
    drifting = load(2, {"ocean.current_mps.1": {"choice": [-0.2]}})
    told = load(2, {})
    told.ocean.set(current=(0.0, -0.2, 0.0))
    ahead = moved(drifting)
    same(ahead, moved(told))
    assert (ahead[0] != plain[0]).any()
    for sim in (drifting, told):
        sim.ocean.set(current=(0.1, 0.0, 0.0))
    same(moved(drifting), moved(told))


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({"agents.rov.start.heding_deg": {"uniform": [0, 1]}}, "did you mean 'agents.rov.start.heading_deg'"),
        ({"agents.rof.start.heading_deg": {"uniform": [0, 1]}}, "no 'agents.rof'; known: rov, other"),
        ({"agents.rov.factors.mas": {"uniform": [0, 1]}}, "did you mean 'mass'"),
        ({"ocean.wind.speed_mps": {"uniform": [0, 1]}}, "'ocean.wind.speed_mps' cannot differ from copy to copy"),
        ({"agents.rov.start.position_m.2": {"uniform": [-25.9, -25.5]}}, "environment 0: it cannot start there"),
    ],
)
def test_what_cannot_vary_is_told(vary: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        load(1, vary)


def sensed(vary: dict[str, Any], **options: Any) -> pl.Simulation:
    made = scenario(vary)
    made["agents"]["rov"]["sensors"] = {
        "imu": {"type": "imu", "rate_hz": 10, "position_m": [0.2, -0.1, 0.3], "orientation_deg": [2, -4, 6]},
        "depth": {"type": "depth", "rate_hz": 10, "position_m": [0.4, 0.2, -0.1]},
        "camera": {"type": "depth_camera", "rate_hz": 10, "width_px": 16, "height_px": 16},
    }
    return pl.Simulation.load(made, seed=3, **options)


def test_errors_are_scaled_by_copy() -> None:
    """Data = truth + factor times the error that the same copy has without."""
    key = "agents.rov.sensors.imu.error"
    plain, drawn = sensed({}, n=4), sensed({key: {"choice": [0.0, 0.5, 3.0]}}, n=4)
    factor = drawn.drawn[key]
    assert set(factor) > {0.0, 3.0} or set(factor) > {0.5, 3.0} or set(factor) > {0.0, 0.5}
    a, b = (sim.step(ticks=10)["rov"]["imu"] for sim in (plain, drawn))
    np.testing.assert_array_equal(a.truth, b.truth)
    np.testing.assert_allclose(b.data - b.truth, factor[:, None] * (a.data - a.truth), rtol=0, atol=1e-14)
    assert (np.abs(a.data - a.truth) > 1e-6).any(axis=1).all()


def test_mounts_are_drawn_for_an_episode_and_looked_at_in_observe() -> None:
    key = "agents.rov.sensors.depth.position_m.2"
    sim = sensed({key: {"uniform": [-0.5, 0.5]}}, n=3)
    place, level = np.array([[3.0, -2.0, -7.0]]), np.array([[1.0, 0.0, 0.0, 0.0]])
    for _ in range(2):
        for copy in range(3):
            truth = sim.observe("rov", place, level, sensors=["depth"], copy=copy)["depth"].truth
            assert float(truth.ravel()[0]) == pytest.approx(7.0 - sim.drawn[key][copy], abs=1e-12)
        before = sim.drawn[key].copy()
        sim.reset(where=[0, 1, 2])
        assert (sim.drawn[key] != before).all()


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("agents.rov.sensors.imu.position_m.3", r"did you mean 'agents\.rov\.sensors\.imu\.position_m\.[0-2]'"),
        ("agents.rov.sensors.imv.error", r"'rov' has no sensor 'imv' \(did you mean 'agents\.rov\.sensors\.imu\.'"),
        ("agents.rov.sensors.camera.error", r"of the type depth_camera, readings are not a truth and an error"),
        ("agents.rov.sensors.imu.rate_hz", r"there is no"),
    ],
)
def test_sensors_vary_in_what_can_vary(key: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        sensed({key: {"uniform": [0, 1]}})


def lit(flux: float, vary: dict[str, Any], **options: Any) -> pl.Simulation:
    lamp = {"position_m": [0.3, 0.1, 0.2], "flux_lm": flux, "color": [1.0, 0.8, 0.6]}
    laser = {"position_m": [0.2, -0.1, 0.1], "flux_lm": flux / 400}
    made = scenario(vary)
    made["ocean"] = {"sun": {"elevation_deg": -30}}
    made["agents"]["rov"] |= {"start": {"position_m": [0, 0, -23], "pitch_deg": -20}}
    made["agents"]["rov"]["sensors"] = {
        "camera": {"type": "camera", "rate_hz": 10, "width_px": 32, "height_px": 24, "lamps": [lamp], "lasers": [laser],
                   "exposure": "manual", "shutter_s": 0.02, "iso": 400},
        "dark": {"type": "camera", "rate_hz": 10, "width_px": 16, "height_px": 16},
    }  # fmt: skip
    return pl.Simulation.load(made, seed=3, **options)


def test_lamps_shine_as_they_do_where_the_scenario_writes_it() -> None:
    """Copy i is the scenario with its flux: the factor is rounded once more, so that a pixel may differ by one."""
    key = "agents.rov.sensors.camera.lamps"
    sim = lit(800.0, {key: {"choice": [0.25, 2.0]}}, n=6)
    factor, whole = sim.drawn[key], sim.step(ticks=10)["rov"]
    assert set(factor) == {0.25, 2.0}
    for i in (int(factor.argmin()), int(factor.argmax())):
        alone = lit(800.0 * factor[i], {}, n=1, environment=i).step(ticks=10)["rov"]
        off = whole["camera"].data[i].astype(int) - alone["camera"].data[0]
        assert np.abs(off).max() <= 1
        np.testing.assert_array_equal(whole["dark"].data[i], alone["dark"].data[0])
    dim, bright = (whole["camera"].truth[i].astype(float).mean() for i in (factor.argmin(), factor.argmax()))
    assert bright > 1.5 * dim > 0
    place, level = np.array([[0.0, 0.0, -23.0]]), np.array([[1.0, 0.0, 0.0, 0.0]])
    at = [sim.observe("rov", place, level, sensors=["camera"], copy=int(i)) for i in (factor.argmin(), factor.argmax())]
    seen = [float(readings["camera"].truth.mean()) for readings in at]
    assert seen[1] > 1.5 * seen[0]


@pytest.mark.parametrize(
    ("sensor", "draw", "said"),
    [
        ("dark", {"uniform": [0, 1]}, "of the type camera, no lamps or lasers are written"),
        ("camera", {"uniform": [-1, 1]}, "no less than no light"),
        ("camera", {"choice": [1, -0.5]}, "no less than no light"),
    ],
)
def test_lamps_that_cannot_shine_are_refused(sensor: str, draw: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        lit(800.0, {f"agents.rov.sensors.{sensor}.lamps": draw}, n=2)


@pytest.mark.parametrize("draw", [{"uniform": [-0.5, 2]}, {"normal": [-1, 0.1]}, {"choice": [0.5, -2]}])
def test_a_factor_of_errors_is_not_negative(draw: dict[str, Any]) -> None:
    sensors = {"depth": {"type": "depth"}}
    scenario = {"world": {"type": "flat"}, "agents": {"auv": {"vehicle": "remus100", "sensors": sensors}}}
    with pytest.raises(InputError, match="its factor is 0 or more"):
        pl.Simulation.load({**scenario, "vary": {"agents.auv.sensors.depth.error": draw}}, n=2)
