"""What an identification refuses, and the turns that few records take."""

from __future__ import annotations

import gzip
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest
from pydantic import BaseModel

import pelagos as pl
from pelagos.errors import InputError, ScenarioError, SimulationError
from pelagos.identification import fit, load_plan, read_record
from pelagos.identification.clock import clock_of
from pelagos.identification.constants import numbers_of, with_numbers
from pelagos.identification.depth import deep_model
from pelagos.identification.excitation import refuse_unexcited
from pelagos.identification.fit import _narrowed, _searched, open_loop
from pelagos.identification.noise import fit_beams
from pelagos.identification.own_run import completed
from pelagos.identification.parameters import Family, Parameter, parameters_of
from pelagos.identification.plan import ColumnConfig
from pelagos.identification.plausibility import _explained
from pelagos.identification.problem import Problem, Target, target
from pelagos.identification.recording import read_recording
from pelagos.identification.search import _improve, search
from pelagos.identification.shots import Shooter, Shots
from pelagos.identification.steps import finite_substeps, step_shift
from pelagos.vehicles.build import build_model

fitting = sys.modules["pelagos.identification.fit"]  # the package has a function of that name
PLAN = {"columns": {"north": "x"}, "commands": {}}


def clock(stamps, **column):
    return clock_of(np.asarray(stamps), ColumnConfig(column="t", **column), "data")


def test_stamps_that_are_no_numbers_or_too_far_apart_are_refused():
    stamps = np.arange(12.0)
    stamps[[4, 9]] = np.nan, np.inf
    with pytest.raises(InputError, match=r"^data: the time of row 5 is not a number$"):
        clock(stamps)
    assert clock(60.0 * np.arange(12)).step_s == 60
    with pytest.raises(
        InputError, match=r"rows are 60\.01 s apart; is the time in ms, us or ns\? Give time: .unit: ms"
    ):
        clock(60.01 * np.arange(12))
    assert clock(60.01 * np.arange(12), unit="ms").step_s == pytest.approx(0.06001)


def test_a_step_that_is_no_round_number_is_that_of_the_whole_record():
    """0.1 s / pi: six digits of it, or of its rate, are off by 1e-8 s a row and more, 1e-4 s at the end."""
    step = 0.1 / np.pi
    found = clock(step * np.arange(10_000)).step_s
    assert found == pytest.approx(step, rel=1e-12)
    assert found != float(f"{step:.6g}")


@dataclass
class Part:
    size: float
    rows: tuple[float, ...]
    table: np.ndarray


class Keys(BaseModel):
    gain: float
    name: str = "a"


def test_numbers_of_a_model_are_found_and_replaced_at_their_places():
    model = {
        "part": Part(2.0, (3.0, 4.0), np.array([[5.0, 6.0]])),
        "keys": [Keys(gain=7.0), None, True],
        "n": np.arange(2),
    }
    assert dict(numbers_of(model)) == {
        ("part", "size"): 2.0, ("part", "rows", 0): 3.0, ("part", "rows", 1): 4.0,
        ("part", "table", "[0]"): 5.0, ("part", "table", "[1]"): 6.0, ("keys", 0, "gain"): 7.0,
    }  # fmt: skip
    new = with_numbers(model, {("part", "rows", 1): -4.0, ("keys", 0, "gain"): "array", ("part", "size"): 0.5})
    assert (new["part"].size, new["part"].rows, new["keys"][0].gain) == (0.5, (3.0, -4.0), "array")
    assert (new["keys"][0].name, new["keys"][1:], new["part"].table) == ("a", [None, True], model["part"].table)
    assert (model["part"].rows, model["keys"][0].gain) == ((3.0, 4.0), 7.0)


@pytest.mark.parametrize(("change", "said"), [
    ({"scale": "log"}, "plan: parameters.K: its prior is 0: give another prior, or scale: linear with a spread"),
    ({"scale": "linear"}, ""),
    ({"scale": "log", "prior": 0.5}, ""),
    ({"path": "mass_kg", "scale": "log"}, ""),
    ({"path": "mass_kg", "scale": "log", "prior": 0}, "its prior is 0"),
    ({"path": "current.east", "scale": "log"}, ""),
])  # fmt: skip
def test_a_logarithm_needs_a_prior_that_is_not_zero(change, said):
    plan = load_plan({**PLAN, "parameters": {"K": {"path": "lift", **change}}})
    data = {"lift": 0.0, "mass_kg": 20.0}
    if said:
        with pytest.raises(InputError, match=said):
            parameters_of(plan.parameters, data)
        return
    (found,) = parameters_of(plan.parameters, data)
    assert found.logarithmic == (change["scale"] == "log" and found.prior != 0)


def family_of(name: str, **paths: str) -> Family:
    data = pl.Vehicle.from_catalogue(name).config.model_dump(mode="python")
    plan = load_plan({**PLAN, "parameters": {key: {"path": path} for key, path in paths.items()}})
    return Family(data, parameters_of(plan.parameters, data))


def test_values_that_no_vehicle_has_are_named():
    family = family_of("bluerov2_heavy", K="mass.inertia_kg_m2.2", m="mass.mass_kg")
    said = r"plan: parameters: no vehicle has K 1\.2, m 13\.5: .*principal moments .*triangle inequality.*; give bounds"
    with pytest.raises(ScenarioError, match=said):
        family.config_at([np.log(1.2), np.log(13.5)])
    assert family.config_at([np.log(0.3), np.log(13)]).mass.inertia_kg_m2[2] == pytest.approx(0.3)


def test_parameters_that_are_more_than_numbers_of_the_model_are_refused():
    with pytest.raises(InputError, match=r"plan: parameters.m: it goes into a table, which has no gradient"):
        family_of("kvlcc2", m="mass.mass_kg")
    parameter = Parameter("K", ("lift",), (1.0,), 2.0, 1.0, -np.inf, np.inf, False)
    family = Family.__new__(Family)
    family.parameters = family._inside = [parameter]
    for kinds, said in (((2.0, None), "K: it changes the kind of the model"), ((2.0, 2.0), "K: nothing in .* depends")):
        family.model, family.model_at = {"lift": kinds[0]}, lambda at, kinds=kinds: {"lift": kinds[1]}
        with pytest.raises(InputError, match=f"plan: parameters.{said}"):
            family._find_places([2.0])
    family.model_at = lambda at: {"lift": at[0]}
    assert family._find_places([2.0]) == [("lift",)]


def test_a_vehicle_without_a_surface_has_no_motion_below_it():
    """In the air, with a part that works while it is out of the water, or never out of it."""
    model = build_model(pl.Vehicle.from_catalogue("bluerov2_heavy").config)
    deep = deep_model(model)
    assert model.wetting is not None
    assert deep is not None
    assert deep.wetting is None
    assert deep_model(deep) is None
    assert deep_model(build_model(pl.Vehicle.from_catalogue("quadrotor").config)) is None
    airy = SimpleNamespace(keeps="dry")
    assert deep_model(replace(model, terms={**model.terms, "drag": airy})) is None
    (name, _first), *_ = model.actuators.items()
    assert deep_model(replace(model, actuators={name: SimpleNamespace(site=airy)})) is None


@pytest.mark.parametrize(("change", "said"), [
    ({"fit_to": ["nroth"]}, r"fit_to: unknown coordinate 'nroth' \(did you mean 'north'\?\)"),
    ({"fit_to": ["north", "nu"]}, "fit_to: unknown coordinate 'nu'"),
])  # fmt: skip
def test_only_coordinates_are_fitted_to(change, said):
    with pytest.raises(ScenarioError, match=said):
        load_plan({**PLAN, **change})


def test_a_plan_is_a_mapping(tmp_path):
    path = tmp_path / "plan.yaml"
    path.write_text("- columns\n- commands\n")
    with pytest.raises(ScenarioError, match=r"plan\.yaml: must be a mapping of keys$"):
        load_plan(path)


def test_a_fit_needs_parameters_that_the_record_tells_of():
    plan = load_plan(PLAN)
    record = read_record({"t": 0.1 * np.arange(50), "x": 0.3 * np.arange(50.0) ** 1.5}, plan)
    with pytest.raises(InputError, match=r"plan: parameters: name at least one, such as terms\.damping\.diagonal\.0: "):
        fit("otter", record, plan)
    with pytest.raises(InputError, match=r"outside: current\.nroth is none of current\.north, current\.east, offset\."):
        open_loop(pl.Vehicle.from_catalogue("otter").config, record, plan, {"current.east": 0.1, "current.nroth": 0.2})
    part = lambda name, told, felt=True: SimpleNamespace(
        parameter=SimpleNamespace(name=name), told=told, felt=felt, identified=told > 0.5
    )
    _narrowed((part("a", 0.2), part("b", 0.6)))
    said = r"too little excitation: .* half of its spread \(a 20 %, b 0 %, without influence\); record a motion"
    with pytest.raises(InputError, match=said):
        _narrowed((part("a", 0.2), part("b", 0.0, felt=False)))


def test_substeps_double_while_they_shift_what_the_data_says(monkeypatch):
    """An eighth of the interval is too much; a shift falls with the step: by 2 to the power of the order, here 1."""
    begun, told = [], []

    def found(problem, shots, *, iterations, tell, at=None):
        begun.append((problem.shooter.substeps, shots, at))
        return SimpleNamespace(at=np.array([problem.shooter.substeps, 0.0]), shots=f"{shots}'")

    def searched(**plan):
        begun.clear(), told.clear()
        shooter = SimpleNamespace(substeps=1)
        shooter.divide = lambda n: setattr(shooter, "substeps", n)
        keys = {"iterations": 5, "bootstrap": 0, "integrator": None, "substeps": None, **plan}
        problem = SimpleNamespace(plan=SimpleNamespace(**keys), shooter=shooter,
                                  family=SimpleNamespace(data={"integrator": "conservative"}))  # fmt: skip
        return _searched(problem, "shots", told.append)[2]

    monkeypatch.setattr(fitting, "search", found)
    monkeypatch.setattr(fitting, "certainty", lambda *_, **__: SimpleNamespace(fisher=np.array([0.1, 9.0])))
    large = fitting.SHARE * 1.959964 * 0.1  # of the interval's half
    monkeypatch.setattr(fitting, "step_shift", lambda p, *_: np.array([-3.9 * large / p.shooter.substeps, 0.0]))
    assert searched() == pytest.approx([-3.9 * large / 4, 0])
    assert told == ["2 substeps", "4 substeps"]
    assert [(n, s) for n, s, _ in begun] == [(1, "shots"), (2, "shots'"), (4, "shots''")]
    assert [None if at is None else at[0] for *_, at in begun] == [None, 1, 2]
    assert searched(substeps=1) == pytest.approx([-3.9 * large, 0])
    assert searched(substeps=1, integrator="vehicle") == pytest.approx([0, 0])
    assert told == []
    monkeypatch.setattr(fitting, "step_shift", lambda p, *_: np.array([-1e9, 0.0]))
    searched()
    assert told[-1] == f"{fitting.MOST} substeps"


def test_beams_of_a_log_are_four_of_one_length_and_enough():
    beams = np.random.default_rng(2).normal(size=(4, 200))
    with pytest.raises(InputError, match=r"four beams with as many pings each, not \[200, 200, 200\]"):
        fit_beams(list(beams[:3]))
    with pytest.raises(InputError, match=r"as many pings each, not \[200, 200, 200, 199\]"):
        fit_beams([*beams[:3], beams[3, :-1]])
    beams[2, 17] = np.nan
    with pytest.raises(InputError, match=r"^199 pings have all four beams: give 200 or more$"):
        fit_beams(list(beams))


def test_a_plan_that_names_all_needs_no_recording():
    whole = {"columns": {"north": "x"}, "commands": {}}
    assert completed(whole, Path("no_such.mcap"), "auv0") == whole
    for part in ({"columns": {"north": "x"}}, {"columns": {}, "commands": {}}):
        with pytest.raises(pl.PelagosError, match=r"no_such\.mcap"):
            completed(part, Path("no_such.mcap"), "auv0")


class Bag:
    """Topics of another program with the times of their messages [s]."""

    channels: ClassVar[dict] = {}
    attachments: ClassVar[dict] = {}
    metadata: ClassVar[dict] = {}

    def __init__(self, **times):
        self._times = times

    def __call__(self, path):
        return self

    def topics(self):
        return list(self._times)

    def messages(self, topic):
        for t in self._times[topic]:
            yield SimpleNamespace(t_ns=round(1e9 * t), message={"x": 2 * t, "text": "abc", "pose": {"x": 1}})


@pytest.mark.parametrize(("bag", "names", "said"), [
    (Bag(), ["a.x"], "bag: holds no topic that can be read; was it cut short.* Try pelagos recover"),
    (Bag(a=[1, 2, 3]), ["t"], "bag: the plan names no topic"),
    (Bag(a=[1, 2, 3], b=[4, 5, 6]), ["a.x", "b.x"], "one begins at 4 s, another ends at 3 s"),
    (Bag(a=[1, 2, 3], b=[3, 5, 6]), ["a.x", "b.x"], "one begins at 3 s, another ends at 3 s"),
    (Bag(a=[1, 2, 2, 3]), ["a.x"], "bag: a has a message of 2 s after one of 2 s"),
    (Bag(a=[1, 3, 2.5, 4]), ["a.x"], r"bag: a has a message of 2\.5 s after one of 3 s"),
    (Bag(a=[1, 2, 3]), ["a.text"], "bag: a.text is not a number but str; name one of its fields"),
    (Bag(a=[1, 2, 3]), ["a.pose"], "bag: a.pose is not a number but dict; name one of its fields"),
    (Bag(a=[1, 2, 3]), ["a.y"], "bag: a.y: the message has no field 'y'"),
])  # fmt: skip
def test_recordings_that_cannot_be_read_are_told(monkeypatch, bag, names, said):
    monkeypatch.setattr("pelagos.identification.recording.Recording", bag)
    with pytest.raises(InputError, match=said):
        read_recording(Path("bag"), names)


def test_two_messages_in_common_are_enough(monkeypatch):
    monkeypatch.setattr("pelagos.identification.recording.Recording", Bag(a=[1, 2, 3, 4], b=[2.5, 5]))
    columns, start = read_recording(Path("bag"), ["a.x", "b.x"])
    assert start == 1
    np.testing.assert_allclose(columns["t"], [2, 3])
    np.testing.assert_allclose(columns["a.x"], [6, 8])
    np.testing.assert_allclose(columns["b.x"], [6, 8])


@pytest.mark.parametrize(("text", "said"), [
    (b"", "needs a first line with names of columns and rows of numbers below it"),
    (b"# of a tank\nt,x\n", "needs a first line with names"),
    (b"t,x,psi,x,t\n1,2,3,4,5\n", "columns with the same name: t, x$"),
])  # fmt: skip
def test_tables_without_names_or_rows_are_refused(text, said, tmp_path):
    path = tmp_path / "run.csv"
    path.write_bytes(text)
    with pytest.raises(InputError, match=rf"run\.csv: {said}"):
        read_record(path, load_plan(PLAN))


def test_files_that_are_cut_or_none_are_refused(tmp_path):
    path = tmp_path / "run.csv.gz"
    for raw in (gzip.compress(b"t,x\n" + b"1,2\n" * 99)[:-12], b"t,x\n1,2\n"):
        path.write_bytes(raw)
        with pytest.raises(InputError, match=r"run\.csv\.gz: cannot be read: "):
            read_record(path, load_plan(PLAN))


def test_ten_rows_outside_of_drop_outs_are_enough():
    """Of a drop-out all columns have the value."""
    plan, rows = load_plan({**PLAN, "dropouts": [{"columns": ["lost", "mark"], "value": -9}]}), np.arange(30.0)
    data = {"t": 0.1 * rows, "x": rows**1.5, "mark": np.full(30, -9.0)}
    read = lambda kept: read_record({**data, "lost": np.where(rows < kept, 0.0, -9.0)}, plan).runs
    with pytest.raises(InputError, match=r"^data: only 9 rows are left outside the drop-outs of the plan$"):
        read(9)
    with pytest.raises(InputError, match="no stretch of the record is longer than 1 s, 10 steps"):
        read(10)
    assert read(12) == ((0, 12),)
    data["mark"][9:12] = 0
    assert read(9) == ((0, 12),)


@pytest.mark.parametrize("pose", ["heading", "depth", "north"])
def test_a_motion_without_commands_must_resemble_itself(pose):
    """A free decay says something of parameters, noise does not; nor does anything that stands still. A coordinate of a
    pose says it alone too, such as the way in a towing tank."""
    plan, t = load_plan({"columns": {pose: "x"}, "commands": {"port": "n"}}), 0.05 * np.arange(600)
    shots = Shots(np.array([0]), 599, np.array([0]), np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), np.zeros((1, 6)),
                  np.array([False]))  # fmt: skip
    random = np.random.default_rng(4).normal(size=600)
    for x, n, enough in ((np.sin(0.5 * t), 0 * t, True), (1e-3 * random, 0 * t, False), (1e-3 * random, t, True),
                         (0 * t, t, False)):  # fmt: skip
        record = read_record({"t": t, "x": x, "n": n}, plan)
        if enough:
            refuse_unexcited(record, plan, shots)
        else:
            with pytest.raises(InputError, match="too little excitation: no command changes and no velocity differs"):
                refuse_unexcited(record, plan, shots)


def test_noise_of_slopes_that_are_not_smoothed_resembles_itself_in_the_next_row_alone():
    """Differences of white noise have the correlation -1/2 with their neighbours and none with any other."""
    plan, t = load_plan({"columns": {"u": "x"}, "commands": {"port": "n"}, "smooth_s": 0.01}), 0.05 * np.arange(600)
    x = 1e-3 * np.diff(np.random.default_rng(4).normal(size=601))
    assert np.corrcoef(x[1:], x[:-1])[0, 1] == pytest.approx(-0.5, abs=0.08)
    shots = Shots(np.array([0]), 599, np.array([0]), np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), np.zeros((1, 6)),
                  np.array([False]))  # fmt: skip
    record = read_record({"t": t, "x": x, "n": 0 * t}, plan)
    with pytest.raises(InputError, match="too little excitation"):
        refuse_unexcited(record, plan, shots)


def test_a_velocity_that_is_neither_measured_nor_a_slope_cannot_be_fitted():
    record = SimpleNamespace(values=lambda name: np.arange(9.0) if name == "north" else None)
    shots = SimpleNamespace(starts=np.array([1, 4]), steps=2)
    np.testing.assert_array_equal(target(record, shots, ("north",)).wanted[:, 0], [[1, 4], [2, 5], [3, 6]])
    with pytest.raises(InputError, match="plan: w is to be fitted, but it has no column and no pose whose slope it is"):
        target(record, shots, ("north", "w"))


def test_a_loss_is_by_squares_or_hubers_and_infinite_where_the_motion_is():
    """Huber's is half the square to 1.345 and straight with that slope beyond (P. J. Huber 1964)."""
    off = np.array([[1.0, -3.0], [np.nan, 2.0]])
    loss = lambda kind: Problem._rho(SimpleNamespace(plan=SimpleNamespace(loss=kind), huber=1.345), off)
    assert loss("squares") == pytest.approx((1 + 9 + 4) / 2)
    assert loss("huber") == pytest.approx(0.5 + 1.345 * (3 + 2 - 1.345))
    seen = np.zeros((2, 1, 1))
    problem = SimpleNamespace(
        shooter=SimpleNamespace(play=lambda *_, **__: (seen, None)), free=[],
        family=SimpleNamespace(compiled_values=lambda at: None), sigma=np.array([2.0]), prior=np.array([1.0]),
        wanted=Target(("north",), np.array([[[3.0]], [[np.nan]]])),
        precision=np.array([4.0]), hidden=[(0, 5.0, 2.5)], joined=(), _rho=lambda off: 0.5 * np.nansum(off**2),
    )  # fmt: skip
    assert Problem.loss(problem, np.array([1.5]), None)[0] == pytest.approx((1.5**2 + 4 * 0.5**2 + 2**2) / 2)
    seen[1] = np.inf  # where nothing was measured
    assert Problem.loss(problem, np.array([1.5]), None)[0] == np.inf


def test_a_search_ends_where_no_step_is_better():
    """A parabola whose slope is told wrongly: no step against it lowers the loss, however much it is damped."""
    family = SimpleNamespace(parameters=[Parameter("K", ("lift",), (1.0,), 3.0, 1.0, -9.0, 9.0, False)])
    losses = []

    def loss(at, shots):
        losses.append(float(at[0]))
        return 1 + (at[0] - 2) ** 2, np.array([[[at[0] - 2]]])

    problem = SimpleNamespace(
        loss=loss, family=family, free=[], prior=np.array([3.0]), sized=lambda off: None,
        wanted=SimpleNamespace(wanted=np.zeros((1, 1, 1))), low=np.array([-9.0]), high=np.array([9.0]),
        normal=lambda at, shots: SimpleNamespace(matrix=np.array([[2.0]]), gradient=-2 * (at - 2)),
    )  # fmt: skip
    assert _improve(problem, problem.normal(np.array([3.0]), None), np.array([3.0]), None, 2.0, 1e-3) is None
    assert min(losses) > 3
    found = search(problem, None, iterations=5, at=np.array([3.0]))
    assert found.settled
    assert (found.at, found.losses) == (3, [])
    with pytest.raises(SimulationError, match="the motion is not finite with the priors: is step_s too long, or a"):
        search(replace_of(problem, loss=lambda at, shots: (np.inf, np.array([[[np.nan]]]))), None, iterations=5)


def replace_of(given: SimpleNamespace, **keys) -> SimpleNamespace:
    return SimpleNamespace(**{**vars(given), **keys})


@pytest.mark.parametrize(("first", "expected"), [(1, 1), (3, 4), (8, 8), (9, 16)])
def test_substeps_are_the_first_with_which_the_motion_is_finite(first, expected):
    family = SimpleNamespace(parameters=[], compiled_values=lambda at: None)
    shooter = SimpleNamespace(divide=lambda n: setattr(shooter, "substeps", n))
    shooter.play = lambda *_, **__: (np.array([1.0, 0.0 if shooter.substeps >= first else np.nan]), None)
    assert finite_substeps(shooter, family, None, None) == expected


def test_a_step_whose_half_is_not_finite_shifts_without_bound():
    """Only where something was measured."""
    seen = np.zeros((2, 13, 1))
    play = lambda shots, compiled, free, tangents: (seen, np.ones((2, 13, 1, 1))) if tangents else (finer, None)
    problem = SimpleNamespace(
        shooter=SimpleNamespace(substeps=1, divide=lambda n: None, play=play), free=[], sigma=np.array([2.0]),
        family=SimpleNamespace(compiled=lambda at: None, compiled_values=lambda at: None),
        wanted=Target(("north",), np.array([[[0.0]], [[np.nan]]])),
    )  # fmt: skip
    found = SimpleNamespace(at=np.array([0.3]), shots=None, normal=SimpleNamespace(matrix=np.array([[5.0]])))
    finer = np.stack([np.full((13, 1), -0.5), np.full((13, 1), np.inf)])
    np.testing.assert_allclose(step_shift(problem, found, "runge_kutta"), [0.5 * 16 / 15 / 2**2 / 5 * -1], atol=0)
    finer = finer[::-1]
    assert step_shift(problem, found, "runge_kutta") == [np.inf]


def test_actuators_that_keep_nothing_have_no_time_before_a_shot():
    x, dx = [1, 2], [3]
    assert Shooter._roll_actuators(SimpleNamespace(_kept=0), None, x, dx, None, None, None, 1) == (x, dx)


def test_a_way_that_hardly_changes_says_nothing_of_a_heading():
    """A velocity that turns with the heading is explained wholly, from a scatter of so much of its speed on."""
    heading = np.linspace(0, 6, 400)
    way = lambda turning: np.stack([1 + turning * np.cos(heading), turning * np.sin(heading)], -1)
    assert _explained(heading, way(0.8)) == pytest.approx(1)
    assert _explained(heading, way(0.01)) == 0
    assert _explained(heading[:3], way(0.8)[:3]) == 0
