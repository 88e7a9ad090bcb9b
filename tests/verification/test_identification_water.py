"""Water of a fit: the motion is that of a run, near the surface, over the ground, in layers and in a current."""

from __future__ import annotations

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.errors import InputError, PelagosWarning
from pelagos.identification import fit, load_plan, read_record
from pelagos.identification.doubts import doubts_of_water
from pelagos.identification.fit import open_loop
from pelagos.identification.parameters import Family, parameters_of
from pelagos.identification.preroll import doubts_of_preroll, longer_preroll, preroll_of, settling_s
from pelagos.identification.problem import cut_shots, moved, shots_at
from pelagos.identification.shots import Shots, shooter_of
from pelagos.identification.water import depth_told, doubts_of_vary, water_of
from pelagos.math.either import either
from pelagos.vehicles.nearby import level_ground

BOAT = {
    "type": "custom", "length_m": 1.6, "beam_m": 0.9, "height_m": 0.5, "density_kg_m3": 1000,
    "mass": {"type": "explicit", "mass_kg": 55, "inertia_kg_m2": [5, 12, 14], "center_of_gravity_m": [0, 0, 0]},
    "added_mass": {"type": "diagonal", "diagonal": [6, 40, 60, 2, 8, 9]},
    "terms": {
        "hydrostatics": {"type": "hydrostatic", "heave_n_m": 6000, "roll_n_m": 200, "pitch_n_m": 500},
        "damping": {"type": "linear_damping", "diagonal": [16, 60, 300, 40, 80, 15]},
        "drag": {"type": "quadratic_damping", "diagonal": [22, 90, 0, 0, 0, 20]},
    },
    "actuators": {
        n: {"type": "force_thruster", "low_n": -60, "high_n": 60, "time_constant_s": 0.2, "diameter_m": 0.22,
            "position_m": [-0.5, y, 0.03], "direction": [1, 0, 0]}
        for n, y in (("port", -0.35), ("starboard", 0.35))
    },
    "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators",
}  # fmt: skip
DIVER = {
    "type": "custom", "length_m": 1.6, "beam_m": 0.3, "height_m": 0.3, "density_kg_m3": 1025,
    "mass": {"type": "explicit", "mass_kg": 70, "volume_m3": 0.0686, "inertia_kg_m2": [1, 12, 12.5],
             "center_of_gravity_m": [0, 0, 0.02], "center_of_buoyancy_m": [0, 0, 0]},
    "added_mass": {"type": "diagonal", "diagonal": [4, 60, 60, 0.3, 8, 8]},
    "terms": {
        "weight": {"type": "submerged"}, "ground": {"type": "boundary"},
        "damping": {"type": "linear_damping", "diagonal": [6, 40, 50, 4, 20, 20]},
        "drag": {"type": "quadratic_damping", "diagonal": [8, 120, 120, 1, 30, 30]},
    },
    "actuators": {
        "port": {"type": "force_thruster", "low_n": -40, "high_n": 40, "time_constant_s": 0.2,
                 "position_m": [-0.7, -0.2, 0.05], "direction": [1, 0, 0.1], "diameter_m": 0.2},
        "starboard": {"type": "force_thruster", "low_n": -40, "high_n": 40, "time_constant_s": 0.2,
                      "position_m": [-0.7, 0.2, -0.05], "direction": [1, 0, -0.05], "diameter_m": 0.2},
    },
    "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators",
}  # fmt: skip
TORPEDO = {
    **DIVER, "current_rotation": "heading",
    "actuators": {
        **DIVER["actuators"],
        "port": {"type": "propeller", "diameter_m": 0.2, "thrust_deduction": 0.1, "wake_fraction": 0.2, "KT_0": 0.4,
                 "KT_limit": 0.1, "KQ_0": 0.05, "KQ_limit": 0.01, "J_limit": 0.8, "advance_from": "ground",
                 "limit_rpm": 600, "time_constant_s": 0.2},
    },
}  # fmt: skip
LAYERS = {"temperature_c": {"depth_m": [0, 4, 8, 30], "value": [20, 18, 9, 7]}}
CURRENT = {"currents": [{"type": "uniform", "speed_mps": 0.3, "towards_deg": 130}]}


def scenario_of(vehicle: dict, depth: float, *, ocean=None, world=None) -> dict:
    agent = {"vehicle": vehicle, "control": "actuators",
             "start": {"position_m": [0, 0, -depth], "roll_deg": 4, "heading_deg": 40}}  # fmt: skip
    return {
        "name": "run", "tick_rate_hz": 50, "world": world or {"type": "flat", "depth_m": 12}, "ocean": ocean or {},
        "agents": {"it": agent}, "record": {"commands": True},
    }  # fmt: skip


def recorded(path, scenario: dict, *, seconds: int = 16, least: float = -10.0, most: float = 30.0):
    """A run under commands at random, changed each 2 s, and its record with a plan."""
    first = next(iter(scenario["agents"]["it"]["vehicle"]["actuators"].values()))
    sizes = [10.0 if first["type"] == "propeller" else 1.0, 1.0]
    sim = pl.Simulation.load(scenario)
    sim.reset(seed=1)
    random = np.random.default_rng(3)
    with sim.recording(path):
        for _ in range(seconds // 2):
            sim.command({"it": random.uniform(least, most, 2) * sizes})
            sim.step(ticks=100)
    plan = load_plan({"segment_s": 6}, recording=path, agent="it")
    return read_record(path, plan), plan


SEAS = {
    "a boat whose propellers draw air": (BOAT, scenario_of(BOAT, 0.0)),
    "a boat in a current": (BOAT, scenario_of(BOAT, 0.0, ocean=CURRENT)),
    "a torpedo in a current, by the speed over ground": (TORPEDO, scenario_of(TORPEDO, 7.0, ocean=CURRENT)),
    "a diver half out of the water": (DIVER, scenario_of(DIVER, 0.05)),
    "a diver over the ground": (DIVER, scenario_of(DIVER, 11.5)),
    "a diver in layers of another density": (DIVER, scenario_of(DIVER, 7.0, ocean=LAYERS)),
}


@pytest.mark.parametrize("name", SEAS)
def test_a_fit_moves_a_vehicle_as_a_run_does(name, tmp_path):
    """6 s in open loop from recorded states, by the run's own steps of 20 ms.

    A run foresees the velocity in the middle of its steps by the acceleration of the last. A record has not that: a
    shot takes its first step's, another by h times a jerk of 1 m/s^3, so that this velocity is off by h^2/2 times it,
    2e-4 m/s, and the velocity after the step by h times 0.3 rad/s of that, 1.2e-6 m/s. In the water of another scenario
    the same motion is far off.
    """
    vehicle, scenario = SEAS[name]
    record, plan = recorded(tmp_path / "run.mcap", scenario)
    score, seen, _ = open_loop(vehicle, record, plan, scenario=scenario)
    assert np.abs(seen[:, 6]).max() > 0.1  # it moves
    allowed = 1.2e-6
    assert max(score.rms.values()) < allowed, score.rms
    if "draw air" not in name and "half out" not in name:
        deep = {**scenario, "ocean": {}, "world": {"type": "flat", "depth_m": 500}}
        other, _, _ = open_loop(vehicle, record, plan, scenario=deep)
        assert max(other.rms.values()) > 5e-4, other.rms


@pytest.mark.slow  # 20 s
def test_thrusters_that_the_surface_weakens_are_found_again(tmp_path):
    """Two propellers 0.12 m deep (55 kg on 6000 N/m, and 0.03 m), 1.1 radii: 15 % of their thrust and more is gone."""
    scenario = scenario_of(BOAT, 0.0)
    recorded(tmp_path / "run.mcap", scenario, seconds=24)
    keys = {"X_u": "terms.damping.diagonal.0", "N_r": "terms.damping.diagonal.5"}
    told = {
        "segment_s": 5,
        "fit_to": ["u", "r"],
        "bootstrap": 0,
        "parameters": {n: {"path": p} for n, p in keys.items()},
    }
    plan = load_plan(told, recording=tmp_path / "run.mcap", agent="it")
    start = {**BOAT, "terms": {**BOAT["terms"], "damping": {"type": "linear_damping",
             "diagonal": [12, 60, 300, 40, 80, 20]}}}  # fmt: skip
    made = fit(start, read_record(tmp_path / "run.mcap", plan), plan, scenario=scenario)
    assert made.value("X_u") == pytest.approx(16.0, rel=1e-5)
    assert made.value("N_r") == pytest.approx(15.0, rel=1e-5)
    assert not made.doubts


def test_currents_move_the_water_and_for_what_flies_the_air():
    around = water_of(None).around(pl.Vehicle.from_dict(BOAT))
    place, t = jit.Array3f64([1.0, 2.0], [3.0, 4.0], [-5.0, 60.0]), jit.Float64(7.0)
    for in_air in (False, True):
        ocean = around.in_current(jit.Float64([0.5, -2.0]), jit.Float64([0.25, 1.5]), in_air=in_air).ocean
        moves, rests = (ocean.wind, ocean.current) if in_air else (ocean.current, ocean.wind)
        np.testing.assert_allclose(np.array(moves(place, t)), [[0.5, -2.0], [-0.25, -1.5], [0, 0]], atol=1e-15)  # NWU
        assert not np.array(rests(place, t)).any()


def test_numbers_that_a_run_draws_are_warned_of():
    vary = {"agents.it.factors.mass": {"uniform": [0.9, 1.1]}, "agents.it.start.heading_deg": {"uniform": [0, 90]},
            "ocean.current_mps.0": {"uniform": [0.1, 0.2]}}  # fmt: skip
    water = water_of({**scenario_of(BOAT, 0.0), "vary": vary})
    (text,) = doubts_of_vary(water)
    assert text.startswith("vary: agents.it.factors.mass, ocean.current_mps.0: drawn anew in each run")
    assert doubts_of_vary(water_of(scenario_of(BOAT, 0.0))) == ()


def test_each_shot_has_its_own_preroll():
    """States that follow s' = (c - s)/T through the rows before a shot, from rest or the first command; by hand."""
    plan, family = family_of(BOAT, {"X_u": "terms.damping.diagonal.0"})
    random = np.random.default_rng(6)
    commands = {name: random.uniform(-50, 50, 60) for name in ("port", "starboard")}
    record = read_record({"t": 0.05 * np.arange(60), "psi": np.zeros(60), **commands}, plan)
    shooter = shooter_of(family, record)
    starts, preroll, idle = np.array([3, 17, 17, 40, 0]), np.array([3, 12, 2, 25, 0]), np.array([1, 0, 1, 0, 1]) > 0
    shots = shots_at(record, starts, 10, preroll, idle)
    numbers = [jit.Float64(v) for v in family.compiled_values([np.log(16)]).values]
    x = [jit.Float64(row) for row in shooter._start(shots)]
    found, _ = shooter._roll_actuators(shots, x, [], numbers, [], jit.Int32(starts), 1)
    left = np.exp(-0.05 / 0.2)
    for k, name in enumerate(commands):
        for lane, state in enumerate(np.array(found[19 + k])):
            first = starts[lane] - preroll[lane]
            expected = 0.0 if idle[lane] else commands[name][first]
            for row in range(first, starts[lane]):
                expected = commands[name][row] + (expected - commands[name][row]) * left
            assert state == pytest.approx(expected, abs=1e-12)


def test_first_shots_wait_for_their_actuators_or_have_them_at_rest():
    t = 0.1 * np.arange(200)
    data = {"t": t, "psi": np.sin(t), "n": t}
    told = {"columns": {"heading": "psi"}, "commands": {"port": "n"}, "segment_s": 4}
    cut = {}
    for origin in ("commands", "rest", "unknown"):
        plan = load_plan({**told, "actuators_from": origin})
        cut[origin] = cut_shots(read_record(data, plan), plan, 6.0)[0]
    assert cut["commands"].starts.tolist() == cut["rest"].starts.tolist() == [0, 40, 80, 120]
    assert cut["commands"].preroll.tolist() == [0, 40, 60, 60]
    assert not cut["commands"].idle.any()
    assert cut["rest"].idle.tolist() == [True, True, False, False]
    assert (cut["unknown"].starts.tolist(), cut["unknown"].preroll.tolist()) == ([60, 100, 140], [60, 60, 60])
    assert not cut["unknown"].idle.any()
    plan = load_plan({**told, "actuators_from": "unknown"})
    with pytest.raises(
        InputError, match=r"shorter than segment_s 4 and the 17 s before it in which actuators settle; "
    ):
        cut_shots(read_record(data, plan), plan, 17.0)
    plan = load_plan({**told, "preroll_s": 1e6})
    with pytest.raises(InputError, match=r"preroll_s: 1e\+06 s is longer than the record, 20 s; leave it out"):
        cut_shots(read_record(data, plan), plan, 1e6)


def test_a_fit_is_made_again_where_actuators_are_slower_than_its_prior():
    """A time constant of 0.2 s takes 1.8 s to a ten-thousandth, and 2.3 s to the hundred-thousandth that is asked."""
    model, told = pl.Vehicle.from_dict(BOAT).model, {"columns": {"heading": "psi"}, "commands": {}}
    plan = load_plan(told)
    assert longer_preroll(plan, 1.9, model, 100.0) is None
    assert longer_preroll(plan, 1.7, model, 100.0) == 3.0
    assert longer_preroll(plan, 1.7, model, 5.0) == 3.0
    assert longer_preroll(load_plan({**told, "preroll_s": 1.7}), 1.7, model, 100.0) is None
    unknown = load_plan({**told, "actuators_from": "unknown"})
    assert longer_preroll(unknown, 1.7, model, 6.1) == 3.0
    assert longer_preroll(unknown, 1.7, model, 5.9) is None


def family_of(vehicle: dict, keys: dict):
    plan = load_plan({"columns": {"heading": "psi"}, "commands": {n: n for n in vehicle["actuators"]}, "segment_s": 1,
                      "parameters": {n: {"path": p} for n, p in keys.items()}})  # fmt: skip
    data = {**pl.Vehicle.from_dict(vehicle).config.model_dump(mode="python"), "integrator": "runge_kutta"}
    return plan, Family(data, parameters_of(plan.parameters, data))


@pytest.mark.parametrize("depth", [0.06, 3.0])
def test_tangents_near_the_surface_are_the_slopes_of_the_motion(depth):
    """Forward mode against central differences, half out of the water, where the added mass changes, and deep."""
    keys = {"mass": "mass.mass_kg", "X_u": "terms.damping.diagonal.0", "Z_w": "added_mass.diagonal.2",
            "place": "actuators.port.position_m.2"}  # fmt: skip
    plan, family = family_of(DIVER, keys)
    t = 0.05 * np.arange(40)
    record = read_record({"t": t, "psi": 0 * t, "port": 25 + 5 * np.sin(t), "starboard": 20 + t}, plan)
    shooter = shooter_of(family, record)
    at = np.array([p.coordinate(p.prior) for p in family.parameters])
    shots = Shots(np.array([4, 10]), 20, np.array([4, 6]), np.array([[0.0, 1, depth], [2, 0, depth + 0.03]]),
                  np.array([[1.0, 0, 0, 0], [0.8, 0.0, 0.0, 0.6]]),
                  np.array([[0.5, 0.1, 0.05, 0.1, 0, 0.2], [0.3, 0.2, 0.02, 0, 0.1, -0.4]]),
                  np.array([False, True]))  # fmt: skip
    assert shooter._near(shots, family.compiled(at)) == (depth < 1)
    free = [2, 3, 4, 6, 8, 10]
    _, slopes = shooter.play(shots, family.compiled(at), free, tangents=True)
    step = 1e-5
    for k in range(len(at) + len(free)):
        ends = []
        for side in (step, -step):
            by, point = np.zeros((2, len(free))), at.copy()
            if k < len(at):
                point[k] += side
            else:
                by[:, k - len(at)] = side
            ends.append(shooter.play(moved(shots, free, by), family.compiled_values(point), free, tangents=False)[0])
        expected = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(slopes[..., k], expected, atol=2e-4 * np.abs(expected).max() + 1e-9)


def test_a_branch_has_the_tangents_of_its_own_side():
    """d/ds of x^2 c or x c^3 for dx = 1, dc = 0.5, and the same from behind."""
    x, c = jit.Float64([1.0, 3.0]), jit.Float64([3.0, -2.0])
    dr.enable_grad(x, c)
    dr.set_grad(x, 1.0)
    dr.set_grad(c, 0.5)
    (y,) = either((x, c), x < 2, lambda a, b: [a * a * b], lambda a, b: [a * b * b * b])
    np.testing.assert_allclose(np.array(dr.forward_to(y)), [2 * 3 + 0.5, -8 + 3 * 3 * 4 * 0.5])
    x, c = jit.Float64([1.0, 3.0]), jit.Float64([3.0, -2.0])
    dr.enable_grad(x, c)
    (y,) = either((x, c), x < 2, lambda a, b: [a * a * b], lambda a, b: [a * b * b * b])
    dr.backward(y)
    np.testing.assert_allclose(np.array(dr.grad(x)), [6, -8])
    np.testing.assert_allclose(np.array(dr.grad(c)), [1, 36])
    (plain,) = either((dr.detach(x), dr.detach(c)), x < 2, lambda a, b: [a * a * b], lambda a, b: [a * b * b * b])
    np.testing.assert_allclose(np.array(plain), [3, -24])


def test_level_ground_is_below_and_within_reach():
    place = [jit.Float64([1.0, 2.0, 3.0]), jit.Float64([-4.0, 5.0, 6.0]), jit.Float64([9.0, 2.0, 13.0])]
    walls = level_ground(place, jit.Float64(12.0), jit.Float64(5.0))
    point, normal = np.array(walls.points[0]), np.array(walls.normals[0])
    np.testing.assert_allclose(point[:2], [[1, 2, 3], [-4, 5, 6]])
    assert point[2, 0] == 12.0
    assert (point[2, 1:] > 1e5).all()  # too far, and beneath
    np.testing.assert_array_equal(normal.ravel()[:3].ravel(), [0, 0, -1])


def test_water_of_a_scenario_and_what_it_leaves_out():
    ocean = {
        "currents": [{"type": "uniform", "speed_mps": 0.5, "towards_deg": 30},
                     {"type": "uniform", "speed_mps": 0.2, "towards_deg": 0, "up_mps": 0.1}],
        "waves": [{"type": "regular", "height_m": 0.3, "period_s": 4}], "wind": {"speed_mps": 5},
    }  # fmt: skip
    water = water_of(scenario_of(BOAT, 0.0, ocean=ocean))
    assert water.outside() == pytest.approx({"current.north": 0.5 * np.cos(np.pi / 6), "current.east": 0.25})
    assert water.outside(in_air=True) == {}
    assert water.depth == 12
    model = pl.Vehicle.from_dict(BOAT).model
    (text,) = doubts_of_water(water, model)
    assert text.startswith("ocean.currents[1], ocean.waves: left out")
    windy = {**BOAT, "terms": {**BOAT["terms"], "air": {"type": "windage", "frontal_m2": 0.3, "lateral_m2": 0.4,
                                                        "height_m": 0.3}}}  # fmt: skip
    assert "ocean.wind: left out" in doubts_of_water(water, pl.Vehicle.from_dict(windy).model)[0]
    assert doubts_of_water(water_of(scenario_of(BOAT, 0.0)), model) == ()
    harbour = water_of(scenario_of(DIVER, 2.0, world={"type": "harbour"}))
    assert harbour.depth is None
    assert "world is of the type harbour" in doubts_of_water(harbour, pl.Vehicle.from_dict(DIVER).model)[0]


def test_a_known_current_is_the_prior_of_one_that_is_asked_for():
    plan, family = family_of(DIVER, {"current.east": "current.east"})
    outside = {"current.north": 0.1, "current.east": -0.4}
    made = Family(family.data, parameters_of(plan.parameters, family.data, outside), outside)
    (parameter,) = made.parameters
    assert (parameter.prior, parameter.logarithmic, parameter.spread) == (-0.4, False, 1.0)
    np.testing.assert_allclose(made.outside_at([0.7])[:3], [0.1, 0.7, 0.0])


@pytest.mark.parametrize(
    ("vehicle", "depths", "said"),
    [
        (DIVER, None, "submerged, and nothing says how deep"),
        (DIVER, [-3.0, -8.0], r"100 % of the rows .* above the surface \(-8 to -3 m\).* scale: -1"),
        ("quadrotor", None, r"in the air, and nothing says how high.* start: .depth: -20."),
        ("quadrotor", [30.0, 20.0], r"below the surface .20 to 30 m."),
    ],
)
def test_a_vehicle_on_the_wrong_side_of_the_surface_is_refused(vehicle, depths, said):
    columns = {"heading": "psi"} if depths is None else {"heading": "psi", "depth": "z"}
    t = 0.1 * np.arange(50)
    data = {"t": t, "psi": 0 * t, "z": np.linspace(*(depths or (0, 0)), 50)}
    record = read_record(data, load_plan({"columns": columns, "commands": {}}))
    model = (pl.Vehicle.from_catalogue(vehicle) if isinstance(vehicle, str) else pl.Vehicle.from_dict(vehicle)).model
    with pytest.raises(InputError, match=said):
        depth_told(record, model)


def test_actuators_have_as_long_as_they_take():
    """The glider's ballast 5e-4 m^3 at 2.4e-5 m^3/s, its moving mass 0.1 m at 0.005 m/s, rudder 11.5 times 0.3 s."""
    model, plan = pl.Vehicle.from_catalogue("glider").model, load_plan({"columns": {"heading": "psi"}, "commands": {}})
    found = settling_s(model)
    assert found["moving_mass"] == pytest.approx(20.0)
    assert found["buoyancy_engine"] == pytest.approx(5e-4 / 2.4e-5, rel=1e-9)
    assert found["rudder"] == pytest.approx(np.log(1e5) * 0.3)
    assert preroll_of(plan, model) == pytest.approx(5e-4 / 2.4e-5, rel=1e-9)
    assert preroll_of(plan, pl.Vehicle.from_dict(BOAT).model) == 3.0  # its thrusters take 11.5 times 0.2 s
    short = plan.model_copy(update={"preroll_s": 10.0})
    assert preroll_of(short, model) == 10.0
    (text,) = doubts_of_preroll(short, 10.0, model)
    assert text.startswith(
        "buoyancy_engine, moving_mass: up to 20.8 s from a command to within a thousandth of it, longer than the 10 s"
    )
    assert text.endswith("so that shots begin in another state: give more")
    (text,) = doubts_of_preroll(plan, 10.0, model)
    assert text.endswith("record for longer, or give actuators_from: rest or commands")
    assert doubts_of_preroll(plan, preroll_of(plan, model), model) == ()


def test_coefficients_that_a_term_keeps_as_configured_are_parameters():
    keys = {"KL": "terms.glide.lift"}
    data = pl.Vehicle.from_catalogue("glider").config.model_dump(mode="python")
    plan = load_plan({"columns": {"depth": "z"}, "commands": {}, "parameters": {"KL": {"path": keys["KL"]}}})
    family = Family(data, parameters_of(plan.parameters, data))
    assert family.places == [("terms", "glide", "config", "lift")]
    compiled = family.compiled([np.log(132.5)])
    assert compiled.values[0] == pytest.approx(132.5)
    assert compiled.slopes[0, 0] == pytest.approx(132.5)


def test_waves_of_a_scenario_are_warned_of():
    scenario = scenario_of(BOAT, 0.0, ocean={"waves": [{"type": "regular", "height_m": 0.3, "period_s": 4}]})
    plan = load_plan({"columns": {"heading": "psi"}, "commands": {n: n for n in BOAT["actuators"]},
                      "parameters": {"N": {"path": "terms.damping.diagonal.5"}}})  # fmt: skip
    t = 0.1 * np.arange(40)
    record = read_record({"t": t, "psi": 0.01 * t, "port": t, "starboard": t}, plan)
    with (
        pytest.warns(PelagosWarning, match=r"ocean\.waves: left out"),
        pytest.raises(InputError, match="longest stretch"),
    ):
        fit(BOAT, record, plan, scenario=scenario)
