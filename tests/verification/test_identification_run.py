"""A vehicle from the recording of its own run, and the error of a fit's steps against another program's motion."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import InputError, LookupFailed, PelagosWarning, ScenarioError
from pelagos.identification import fit, load_plan, read_record
from pelagos.identification.fit import open_loop
from pelagos.identification.own_run import COLUMNS
from pelagos.identification.run_steps import RunSteps
from pelagos.sim.replay import Recording

TOPIC = "/usv0/actuator_commands"
TRUE = {"X_u": 16.0, "N_r": 15.0, "lag": 0.35}
THRUSTER = {"type": "force_thruster", "low_n": -60, "high_n": 60}
PATHS = {
    "X_u": {"path": "terms.damping.diagonal.0"},
    "N_r": {"path": "terms.damping.diagonal.5"},
    "lag": {"path": ["actuators.port.time_constant_s", "actuators.starboard.time_constant_s"]},
}


def boat(values: dict) -> dict:
    """A boat of three degrees of freedom with two thrusters aft."""
    sides = {"port": [-0.5, -0.35, 0], "starboard": [-0.5, 0.35, 0]}
    return {
        "type": "custom", "length_m": 1.6, "beam_m": 0.9, "height_m": 0.5, "density_kg_m3": 1000,
        "mass": {"type": "explicit", "mass_kg": 55, "inertia_kg_m2": [5, 12, 14], "center_of_gravity_m": [0, 0, 0]},
        "added_mass": {"type": "diagonal", "diagonal": [6, 40, 60, 2, 8, 9]},
        "terms": {
            "hydrostatics": {"type": "hydrostatic", "heave_n_m": 6000, "roll_n_m": 200, "pitch_n_m": 500},
            "damping": {"type": "linear_damping", "diagonal": [values["X_u"], 60, 300, 40, 80, values["N_r"]]},
            "drag": {"type": "quadratic_damping", "diagonal": [22, 90, 0, 0, 0, 20]},
        },
        "actuators": {
            n: {**THRUSTER, "time_constant_s": values["lag"], "position_m": p, "direction": [1, 0, 0]}
            for n, p in sides.items()
        },
        "modes": {
            "actuators": {"type": "actuators"},
            "wrench": {"type": "wrench"},
        },
        "default_mode": "actuators",
    }  # fmt: skip


def recorded(path, *, seconds=30.0, record=None, n=1, tick_rate_hz=50, vehicle=None):
    """A run of the boat under random commands, changed each 2 s."""
    agent = {"vehicle": vehicle or boat(TRUE), "control": "actuators", "start": {"position_m": [0, 0, 0]}}
    sim = pl.Simulation.load(
        {"name": "run", "tick_rate_hz": tick_rate_hz, "world": {"type": "flat", "depth_m": 20},
         "agents": {"usv0": agent}, "record": record or {"commands": True}}, n=n,
    )  # fmt: skip
    sim.reset(seed=1)
    random, told = np.random.default_rng(3), []
    with sim.recording(path):
        for _ in range(int(seconds / 2)):
            told.append(random.uniform(-20, 60, 2))
            sim.command({"usv0": told[-1]})
            sim.step(ticks=2 * tick_rate_hz)
    return np.array(told)


def commands_of(path, topic=TOPIC):
    """Times [s] and commands of a recording."""
    messages = list(Recording(path).messages(topic))
    return np.array([m.t_ns * 1e-9 for m in messages]), np.array([m.message.data for m in messages])


def test_commands_are_recorded_at_the_times_from_which_they_act(tmp_path):
    told = recorded(tmp_path / "run.mcap", seconds=6)
    times, values = commands_of(tmp_path / "run.mcap")
    np.testing.assert_allclose(times, np.arange(300) / 50, atol=1e-12)  # none for the end, from which nothing acts yet
    np.testing.assert_array_equal(values, np.repeat(told, 100, axis=0))
    recording = Recording(tmp_path / "run.mcap")
    (dimension,) = recording.message(TOPIC, 0).message.layout.dim
    assert (dimension.label, dimension.size) == ("port [N], starboard [N]", 2)
    about = recording.channels[TOPIC].about
    assert (about["actuators"], about["units"], about["acts"]) == ("port starboard", "N N", "from this time on")


def test_the_other_messages_are_those_of_a_recording_without_commands(tmp_path):
    recorded(tmp_path / "with.mcap", seconds=2)
    recorded(tmp_path / "without.mcap", seconds=2, record={"commands": False})
    made, plain = Recording(tmp_path / "with.mcap"), Recording(tmp_path / "without.mcap")
    assert TOPIC not in plain.channels
    assert set(made.topics()) - set(plain.topics()) == {TOPIC}
    for topic in plain.topics():
        assert [(m.t_ns, m.raw) for m in made.messages(topic)] == [(m.t_ns, m.raw) for m in plain.messages(topic)]


def test_commands_of_copies_and_of_control_laws(tmp_path):
    """Two copies of a steered vehicle: its fins and propeller, which no caller commands; in one block."""
    agent = {"vehicle": "remus100", "command": [8, 0.7, 1200], "start": {"position_m": [0, 0, -5]}}
    scenario = {"tick_rate_hz": 100, "world": {"type": "flat", "depth_m": 30}, "agents": {"auv0": agent},
                "record": {"commands": True, "state_rate_hz": 20}}  # fmt: skip
    orders = {"auv0": np.array([[8.0, 0.7, 1200.0], [6.0, -0.5, 1000.0]])}
    whole = pl.Simulation.load(scenario, n=2)
    whole.command(orders)
    whole.run(1.0, record=tmp_path / "whole.mcap")
    scenario["record"]["state_rate_hz"] = 100
    single = pl.Simulation.load(scenario, n=2)
    single.command(orders)
    with single.recording(tmp_path / "single.mcap"):
        for _ in range(100):
            single.step()
    ends = []
    for copy in range(2):
        topic = f"/env{copy}/auv0/actuator_commands"
        times, values = commands_of(tmp_path / "whole.mcap", topic)
        _, every = commands_of(tmp_path / "single.mcap", topic)
        np.testing.assert_allclose(times, np.arange(20) / 20)
        np.testing.assert_array_equal(values, every[::5])
        assert (np.ptp(every, axis=0) > 0).sum() >= 2
        ends.append(values[-1])
    assert (ends[0] != ends[1]).any()


def test_a_mode_that_moves_the_body_itself_has_no_commands(tmp_path):
    sim = pl.Simulation.load(
        {"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 20}, "record": {"commands": True},
         "agents": {"usv0": {"vehicle": boat(TRUE), "control": "wrench", "start": {"position_m": [0, 0, 0]}}}},
    )  # fmt: skip
    sim.run(0.2, record=tmp_path / "run.mcap")
    _, values = commands_of(tmp_path / "run.mcap")
    assert values.shape == (10, 2)
    assert np.isnan(values).all()
    plan = load_plan({}, recording=tmp_path / "run.mcap", agent="usv0")
    with pytest.raises(InputError, match=r"'/usv0/actuator_commands\.port' is empty or not a number in every row"):
        read_record(tmp_path / "run.mcap", plan)


@pytest.mark.slow  # 4 s
def test_a_vehicle_is_found_again_from_its_own_recording(tmp_path):
    """Within its intervals with noise on the recorded motion, and to 1e-7 without, where the search ends."""
    recorded(tmp_path / "run.mcap", seconds=40, tick_rate_hz=20)
    told = {"segment_s": 4, "fit_to": ["u", "v", "r"], "parameters": PATHS, "bootstrap": 0}
    plan = load_plan(told, recording=tmp_path / "run.mcap", agent="usv0")
    assert (plan.integrator, plan.substeps) == ("conservative", 1)
    record = read_record(tmp_path / "run.mcap", plan, ("port", "starboard"))
    assert record.runs[0][0] == 0
    assert plan.actuators_from == "rest"
    start = boat({"X_u": 11.0, "N_r": 21.0, "lag": 0.5})
    for e in fit(start, record, plan).estimates:
        assert e.value == pytest.approx(TRUE[e.parameter.name], rel=1e-7)
    random = np.random.default_rng(2)
    measured = {n: x + random.normal(0, 0.006, len(x)) for n, x in record.measured.items() if n in plan.fit_to}
    made = fit(start, replace(record, measured={**record.measured, **measured}), plan)
    for e in made.estimates:
        true = TRUE[e.parameter.name]
        assert abs(e.value - true) < e.high - e.low, e.parameter.name  # four standard deviations
        assert e.high - e.low < 0.2 * true
    assert not made.doubts


@pytest.mark.slow  # 40 s
def test_slow_actuators_are_found_again(tmp_path):
    """Thrusters that take 2 s, from a prior of 1.5 s: shots begin as far off as a hundred-thousandth, once the fit is
    made again with the time constant that it found."""
    true = {**TRUE, "lag": 2.0}
    recorded(tmp_path / "run.mcap", seconds=40, vehicle=boat(true))
    told = {"segment_s": 4, "fit_to": ["u", "v", "r"], "parameters": PATHS, "bootstrap": 0}
    plan = load_plan(told, recording=tmp_path / "run.mcap", agent="usv0")
    record = read_record(tmp_path / "run.mcap", plan)
    made = fit(boat({"X_u": 11.0, "N_r": 21.0, "lag": 1.5}), record, plan)
    for e in made.estimates:
        assert e.value == pytest.approx(true[e.parameter.name], rel=5e-5)
    assert made.simulated[1].preroll.max() * record.step_s == pytest.approx(2.0 * np.log(1e5), rel=0.01)
    assert not made.doubts


def test_a_recording_that_begins_within_a_run_has_actuators_that_are_not_known(tmp_path):
    agent = {"vehicle": boat({**TRUE, "lag": 0.1}), "control": "actuators", "start": {"position_m": [0, 0, 0]}}
    sim = pl.Simulation.load({"tick_rate_hz": 20, "world": {"type": "flat", "depth_m": 20}, "agents": {"usv0": agent},
                              "record": {"commands": True, "state_rate_hz": 20}})  # fmt: skip
    sim.command({"usv0": [30.0, 10.0]})
    sim.step(ticks=20)
    with sim.recording(tmp_path / "run.mcap"):
        sim.step(ticks=160)
    plan = load_plan({"segment_s": 2}, recording=tmp_path / "run.mcap", agent="usv0")
    assert plan.actuators_from == "unknown"
    score, _, shots = open_loop(boat({**TRUE, "lag": 0.1}), read_record(tmp_path / "run.mcap", plan), plan)
    assert shots.starts[0] == 60  # 3 s
    assert max(score.rms.values()) < 2e-5  # the first step's middle: h^3/2 of 1 m/s^3 times 0.3 rad/s
    for key, found in (("unknown", "unknown"), ("commands", "commands")):
        asked = load_plan({"actuators_from": key}, recording=tmp_path / "run.mcap", agent="usv0")
        assert asked.actuators_from == found


def test_a_vehicle_is_found_again_from_motion_told_twice_a_second(tmp_path):
    """Steps of the fit are the run's ticks, 0.1 s, also where the motion is recorded at every fifth: found again to
    1e-4, where the search ends."""
    recorded(tmp_path / "run.mcap", tick_rate_hz=10, record={"commands": True, "state_rate_hz": 2})
    told = {"segment_s": 4, "fit_to": ["u", "v", "r"], "parameters": PATHS, "bootstrap": 0}
    plan = load_plan(told, recording=tmp_path / "run.mcap", agent="usv0")
    record = read_record(tmp_path / "run.mcap", plan, ("port", "starboard"))
    assert record.step_s / plan.substeps == pytest.approx(0.1, rel=1e-12)
    for e in fit(boat({"X_u": 14.0, "N_r": 18.0, "lag": 0.4}), record, plan).estimates:
        assert e.value == pytest.approx(TRUE[e.parameter.name], rel=1e-4)


NAMED = {"columns": {n: {"column": f"/usv0/truth.{f}", "scale": s} for n, (f, s, _) in COLUMNS.items() if n in "uvr"}}


@pytest.mark.parametrize(("integrator", "told"), [
    ("semi_implicit", {}), ("runge_kutta", {}), ("conservative", NAMED), ("semi_implicit", NAMED),
])  # fmt: skip
def test_a_fit_takes_the_steps_of_the_run_that_was_recorded_and_not_its_vehicles(tmp_path, integrator, told):
    """Ticks of 0.1 s, a third of the thrusters' lag, by a way that the fitted vehicle (conservative) has not, for true
    motion and for columns that a plan names: found again to 1e-6, where other steps were up to 7 % off."""
    made_by = {**boat(TRUE), "integrator": integrator}
    recorded(tmp_path / "run.mcap", tick_rate_hz=10, record={"commands": True, "state_rate_hz": 10}, vehicle=made_by)
    plan = load_plan({"segment_s": 4, "fit_to": ["u", "v", "r"], "parameters": PATHS, "bootstrap": 0, **told},
                     recording=tmp_path / "run.mcap", agent="usv0")  # fmt: skip
    record = read_record(tmp_path / "run.mcap", plan, ("port", "starboard"))
    assert record.run == RunSteps(integrator, pytest.approx(0.1, rel=1e-12))
    made = fit(boat({"X_u": 14.0, "N_r": 18.0, "lag": 0.4}), record, plan)
    for e in made.estimates:
        assert e.value == pytest.approx(TRUE[e.parameter.name], rel=1e-6)
        assert e.step_shift == 0
    assert (made.plan.integrator, made.plan.substeps) == (integrator, 1)
    assert made.vehicle["integrator"] == "conservative"
    if told:
        own, other = (
            max(open_loop(boat(TRUE), record, p)[0].rms.values())
            for p in (plan, plan.model_copy(update={"integrator": "runge_kutta", "substeps": 1}))
        )
        assert own < 1e-4  # a shot's first step does not know the acceleration before it
        assert other > 1e-3


def test_other_steps_than_those_of_the_run_are_doubted_by_what_they_shift(tmp_path):
    """-H^-1 J^T W e with e the difference of both motions: of first order in the shift, so within a third of what the
    parameters are off."""
    recorded(tmp_path / "run.mcap", tick_rate_hz=10, record={"commands": True, "state_rate_hz": 10})
    told = {
        "segment_s": 4, "fit_to": ["u", "v", "r"], "parameters": PATHS, "bootstrap": 0, "loss": "squares",
        "integrator": "runge_kutta",
    }  # fmt: skip
    plan = load_plan(told, recording=tmp_path / "run.mcap", agent="usv0")
    record = read_record(tmp_path / "run.mcap", plan, ("port", "starboard"))
    said = (
        r"the run was made in steps of 100 ms \(conservative\), the fit in steps of 100 ms \(runge_kutta\), which "
        r"shifts X_u by .*: give integrator: conservative, step_s: 0\.1 and substeps: 1$"
    )
    with pytest.warns(PelagosWarning, match=said):
        made = fit(boat({"X_u": 14.0, "N_r": 18.0, "lag": 0.4}), record, plan)
    (doubt,) = (text for text in made.doubts if text.startswith("the run was made"))
    shifts = dict(re.findall(r"(\w+) by ([+-][\d.e-]+)", doubt))
    assert {"X_u", "N_r"} <= shifts.keys()
    for e in made.estimates:
        if e.parameter.name in shifts:
            off = e.value - TRUE[e.parameter.name]
            assert float(shifts[e.parameter.name]) == pytest.approx(off, rel=0.3)


def test_steps_of_a_run_that_shift_nothing_are_not_doubted(tmp_path):
    """Ticks of 5 ms, 20 between two rows that have noise: the fit takes its own steps, and says nothing."""
    recorded(tmp_path / "run.mcap", tick_rate_hz=200, record={"commands": True, "state_rate_hz": 10})
    told = {"segment_s": 4, "fit_to": ["u", "v", "r"], "parameters": PATHS, "bootstrap": 0, **NAMED}
    plan = load_plan(told, recording=tmp_path / "run.mcap", agent="usv0")
    record = read_record(tmp_path / "run.mcap", plan, ("port", "starboard"))
    random = np.random.default_rng(2)
    noisy = {n: x + random.normal(0, 0.006, len(x)) for n, x in record.measured.items()}
    made = fit(boat({"X_u": 14.0, "N_r": 18.0, "lag": 0.4}), replace(record, measured=noisy), plan)
    assert (made.plan.integrator, made.plan.substeps, made.substeps) == (None, None, 1)
    assert made.doubts == ()


def test_a_plan_that_changes_the_vehicles_steps_has_its_own(tmp_path):
    """The number of substeps is the run's all the same: its doubt, if there is one, names both."""
    recorded(tmp_path / "run.mcap", seconds=4, tick_rate_hz=10, record={"commands": True, "state_rate_hz": 5})
    told = {"vehicle": {"integrator": "semi_implicit"}}
    plan = load_plan(told, recording=tmp_path / "run.mcap", agent="usv0")
    assert (plan.integrator, plan.substeps) == ("vehicle", 2)


def test_a_recording_without_commands_says_how_to_have_them(tmp_path):
    recorded(tmp_path / "run.mcap", seconds=2, record={"commands": False})
    with pytest.raises(InputError, match=r"holds no commands to the actuators of usv0: .* --set record\.commands=true"):
        load_plan({}, recording=tmp_path / "run.mcap", agent="usv0")
    with pytest.raises(LookupFailed, match=r"agent 'usv9' .*usv0"):
        load_plan({}, recording=tmp_path / "run.mcap", agent="usv9")
    recorded(tmp_path / "told.mcap", seconds=2)
    plan = load_plan({"commands": {"port": f"{TOPIC}.prot"}}, recording=tmp_path / "told.mcap", agent="usv0")
    with pytest.raises(LookupFailed, match=r"number 'prot' .did you mean 'port'"):
        read_record(tmp_path / "told.mcap", plan)


def test_a_plan_for_a_table_names_its_columns():
    with pytest.raises(ScenarioError, match="columns: name at least one"):
        load_plan({"commands": {}})
    with pytest.raises(ScenarioError, match="commands: name the column of each actuator"):
        load_plan({"columns": {"heading": "psi"}})
    with pytest.raises(ScenarioError, match="a scale of 0 makes every row 0"):
        load_plan({"columns": {"heading": {"column": "psi", "scale": 0}}, "commands": {}})
    with pytest.raises(ScenarioError, match="integrator: runge_kutta here, but conservative under vehicle"):
        load_plan({"columns": {"heading": "psi"}, "commands": {}, "integrator": "runge_kutta",
                   "vehicle": {"integrator": "conservative"}})  # fmt: skip


def independent(seconds: float = 56.0, *, noise: float = 1.0) -> dict:
    """The boat in NumPy: surge, sway and yaw about its centre of gravity, Runge and Kutta's steps of 10 ms, a 35th of
    the shortest time constant: exact to 1e-8.

    T. I. Fossen, "Handbook of Marine Craft Hydrodynamics and Motion Control", 2nd ed., Wiley 2021, Section 6.5.
    """
    random, rows = np.random.default_rng(4), []
    step, spacing = 1e-2, 0.1
    masses = np.array([55 + 6.0, 55 + 40.0, 14 + 9.0])

    def slope(x, told):
        heading, (u, v, r), thrusts = x[2], x[3:6], x[6:8]
        force = np.array([thrusts.sum(), 0.0, 0.35 * (thrusts[0] - thrusts[1])])
        drag = np.array([TRUE["X_u"] + 22 * abs(u), 60 + 90 * abs(v), TRUE["N_r"] + 20 * abs(r)]) * x[3:6]
        turning = np.array([-masses[1] * v * r, masses[0] * u * r, (masses[1] - masses[0]) * u * v])
        way = [np.cos(heading) * u - np.sin(heading) * v, np.sin(heading) * u + np.cos(heading) * v, r]
        return np.concatenate([way, (force - drag - turning) / masses, (told - thrusts) / TRUE["lag"]])

    x = np.zeros(8)
    for k in range(round(seconds / spacing) + 1):
        if k % 30 == 0:
            told = random.uniform(-16, 40, 2)
        off = noise * random.normal(0, [0.01, 0.01, 0.003])
        rows.append([k * spacing, *(x[:3] + off), *told])
        for _ in range(round(spacing / step)):
            a = slope(x, told)
            b = slope(x + step / 2 * a, told)
            c = slope(x + step / 2 * b, told)
            x = x + step / 6 * (a + 2 * b + 2 * c + slope(x + step * c, told))
    return dict(zip(("t", "x", "y", "psi", "port", "starboard"), np.array(rows).T, strict=True))


def test_steps_shift_no_parameter_of_another_programs_motion():
    """First-order steps of 50 ms shift the inertia beyond its interval, as foretold; the fit's own do not."""
    plan = {
        "columns": {"north": "x", "east": "y", "heading": "psi"}, "commands": {n: n for n in ("port", "starboard")},
        "segment_s": 8, "bootstrap": 0, "parameters": {**PATHS, "N_rdot": {"path": "added_mass.diagonal.5"}},
    }  # fmt: skip
    data, start = independent(), boat({"X_u": 14.0, "N_r": 17.0, "lag": 0.4})
    true = {**TRUE, "N_rdot": 9.0}
    made = fit(start, read_record(data, load_plan(plan)), load_plan(plan))
    assert made.substeps == 1
    halves = {}
    for e in made.estimates:
        halves[e.parameter.name] = half = (e.high - e.low) / 2
        assert abs(e.value - true[e.parameter.name]) < 2 * half, e.parameter.name  # four standard deviations
        assert abs(e.step_shift) < 0.02 * half, e.parameter.name
    coarse = load_plan({**plan, "integrator": "conservative", "substeps": 2})
    with pytest.warns(PelagosWarning, match=r"the steps of 50 ms shift .*N_rdot by \+"):
        shifted = fit(start, read_record(data, coarse), coarse)
    by_name = {e.parameter.name: e for e in shifted.estimates}
    assert abs(by_name["N_rdot"].value - true["N_rdot"]) > halves["N_rdot"]
    moved = by_name["N_rdot"].value - made.value("N_rdot")
    assert by_name["N_rdot"].step_shift == pytest.approx(moved, rel=0.3)  # of first order in the shift


@pytest.mark.slow  # 10 s
def test_substeps_are_doubled_until_their_error_is_small():
    plan = load_plan({
        "columns": {"north": "x", "east": "y", "heading": "psi"}, "commands": {n: n for n in ("port", "starboard")},
        "segment_s": 8, "bootstrap": 0, "integrator": "conservative", "train": 1,
        "parameters": {"N_rdot": {"path": "added_mass.diagonal.5"}},
    })  # fmt: skip
    with pytest.warns(PelagosWarning, match="nothing is left unseen .* train 1 of 5 shots leaves none"):
        made = fit(boat(TRUE), read_record(independent(40.0, noise=30.0), plan), plan)
    (e,) = made.estimates
    assert made.substeps == 16  # with 8 it was a little more than a tenth
    share = abs(e.step_shift) / ((e.fisher[1] - e.fisher[0]) / 2)
    assert 0.03 < share < 0.1
