"""Records that cannot be used are refused with the place, the reason and the cure."""

from __future__ import annotations

import gzip
import re
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.errors import InputError, LookupFailed, ScenarioError
from pelagos.identification import load_plan, read_record
from pelagos.identification.clock import clock_of
from pelagos.identification.command_units import in_own_units
from pelagos.identification.coordinates import COORDINATES
from pelagos.identification.doubts import doubts_of_record
from pelagos.identification.own_run import COLUMNS
from pelagos.identification.parameters import changed, parameters_of
from pelagos.identification.plan import UNIT_SCALES, ColumnConfig, ParameterConfig
from pelagos.identification.problem import cut_shots
from pelagos.identification.recording import _field, _on
from pelagos.messages.motion import ODOMETRY, TruthEncoder
from pelagos.messages.numbers import MULTI_ARRAY, LabelledRow
from pelagos.messages.store import deserialize
from pelagos.vehicles.vehicle import Vehicle

PLAN = {"columns": {"north": "x", "heading": "psi"}, "commands": {"left_propeller": "n1"}}


def table(n: int = 200, h: float = 0.05) -> dict:
    t = 3.0 + h * np.arange(n)
    return {"t": t, "x": 0.3 * t**1.5, "psi": 0.4 * np.sin(t), "n1": np.floor(t), "gone": np.zeros(n)}


def refused(change, plan=None, match=""):
    data = table()
    change(data)
    with pytest.raises(InputError, match=match):
        read_record(data, load_plan({**PLAN, **(plan or {})}), ("left_propeller",))


def test_times_out_of_order_are_named():
    def swap(d):
        d["t"][[50, 51]] = d["t"][[51, 50]]

    refused(swap, match=r"times are not in order: row 52 has 5\.5 s after 5\.55 s \(1 such")


def test_duplicate_times_are_named():
    def double(d):
        d["t"][21] = d["t"][20]

    refused(double, match="4 s occurs twice, in rows 21 and 22")


def test_nan_is_named_with_its_row():
    def hole(d):
        d["psi"][[7, 9]] = np.nan

    refused(hole, match=r"column 'psi' has 2 cells .* row 8 \(3\.35 s\), row 10")


def test_a_gap_is_refused_or_split():
    data = {k: np.delete(v, slice(80, 120)) for k, v in table().items()}
    with pytest.raises(InputError, match=r"nothing is measured between 6\.95 and 9 s, longer than 0\.25 s \(1 such"):
        read_record(data, load_plan(PLAN))
    record = read_record(data, load_plan({**PLAN, "gaps": "split"}))
    assert record.runs == ((0, 80), (120, 200))
    assert np.isnan(record.measured["north"][80:120]).all()


def test_degrees_and_millimetres_are_noticed():
    def degrees(d):
        d["psi"] = (np.degrees(d["psi"]) * 20) % 360

    refused(degrees, match="more than a turn.*degrees\\? Give unit: deg")
    refused(lambda d: d.update(x=d["x"] * 1e8), match=r"more than any vehicle has .*wrong unit\?")
    refused(lambda d: d.update(x=d["x"] * 1e3), match=r"'x' as north: .* of its rows change by more than 60 m/s")


def test_a_tilt_beyond_its_range_is_noticed():
    tilted = {"columns": {"pitch": "x"}}
    refused(lambda d: d.update(x=2.0 * np.sin(d["t"])), tilted, match=r"more than 1\.62, the largest pitch there is")


def circle(spread: float = 1.0) -> dict:
    """A vehicle that turns to and fro, 1.2 times round, and goes where it looks but for 0.2 rad."""
    t = 0.2 * np.arange(600)
    heading = 4.0 * np.sin(0.04 * t) * spread
    north, east = np.cumsum(0.2 * np.cos(heading + 0.2)), np.cumsum(0.2 * np.sin(heading + 0.2))
    return {"t": t, "x": north, "y": east, "psi": heading, "deg": np.degrees(heading), "n1": np.floor(t)}


def test_a_vehicle_that_is_carried_along_may_turn_as_it_likes():
    """Northwards at 0.3 m/s, turning 1.1 times to and fro: in degrees its heading would be the course, by chance."""
    data = circle(0.9)
    data |= {"x": 0.3 * data["t"], "y": 0.002 * data["t"]}
    record = read_record(data, load_plan({**PLAN, "columns": {"north": "x", "east": "y", "heading": "psi"}}))
    assert np.ptp(record.values("heading")) == pytest.approx(7.2, abs=0.1)


def test_a_heading_in_degrees_is_known_by_the_way():
    """Slow turns, whose degrees as radians are rates that a vehicle may have."""
    columns = {"north": "x", "east": "y", "heading": "deg"}
    with pytest.raises(InputError, match=r"column 'deg' as heading goes along with the vehicle's way if it is in deg"):
        read_record(circle(), load_plan({**PLAN, "columns": columns}))
    said = read_record(
        circle(), load_plan({**PLAN, "columns": {**columns, "heading": {"column": "deg", "unit": "deg"}}})
    )
    radians = read_record(circle(), load_plan({**PLAN, "columns": {**columns, "heading": "psi"}}))
    np.testing.assert_allclose(said.measured["heading"], radians.measured["heading"], atol=1e-12)


def test_topics_are_read_as_they_go():
    """An angle by the short way, a command held, a hole empty; only the time that all topics have."""
    time = np.array([0.0, 1.0, 2.0, 3.0])
    t = np.array([0.5, 1.5, 2.5])
    np.testing.assert_allclose(_on(time[1:3], False, t, np.unwrap([3.1, -3.1, -3.0])), [3.14159, 3.23319], atol=2e-5)
    np.testing.assert_array_equal(_on(time, True, t, np.array([5.0, 7.0, 9.0])), [5.0, 5.0, 7.0, 9.0])
    sparse = np.array([0.0, 0.1, 0.2, 0.3, 2.0, 2.1])
    filled = _on(np.array([0.15, 1.0, 2.0]), False, sparse, sparse)
    np.testing.assert_allclose(filled, [0.15, np.nan, 2.0])


def test_a_quaternion_has_angles(tmp_path):
    turn = SimpleNamespace(w=np.cos(0.35), x=0.0, y=0.0, z=np.sin(0.35))
    message = SimpleNamespace(pose=SimpleNamespace(orientation=turn))
    assert _field(message, ["pose", "orientation", "yaw"], "/a.pose.orientation.yaw", tmp_path) == pytest.approx(0.7)
    assert _field(message, ["pose", "orientation", "z"], "/a.pose.orientation.z", tmp_path) == pytest.approx(
        np.sin(0.35)
    )
    with pytest.raises(InputError, match="the message has no field 'yaw'"):
        _field(message, ["pose", "yaw"], "/a.pose.yaw", tmp_path)


def test_unknown_names_say_the_nearest():
    with pytest.raises(LookupFailed, match=r"unknown column 'pssi'.*psi"):
        read_record(table(), load_plan({**PLAN, "columns": {"heading": "pssi"}}))
    with pytest.raises(LookupFailed, match=r"unknown actuator 'left'.*left_propeller"):
        read_record(table(), load_plan({**PLAN, "commands": {"left": "n1"}}), ("left_propeller",))
    with pytest.raises(ScenarioError, match=r"unknown coordinate 'nord'.*north"):
        load_plan({**PLAN, "columns": {"nord": "x"}})
    with pytest.raises(ScenarioError, match=r"unknown unit 'degree'.*deg"):
        load_plan({**PLAN, "columns": {"heading": {"column": "psi", "unit": "degree"}}})


def test_units_zero_scale_and_delay():
    plan = load_plan({
        **PLAN, "columns": {"heading": {"column": "deg", "unit": "deg", "scale": -1, "zero": 10, "delay_s": 0.1}},
    })  # fmt: skip
    data = {**table(), "deg": 10 - np.degrees(0.4 * np.sin(table()["t"] - 0.1))}
    record = read_record(data, plan)
    t = record.start_s + record.step_s * np.arange(len(record.measured["heading"]))
    known = np.isfinite(record.measured["heading"])
    np.testing.assert_allclose(record.measured["heading"][known][:-2], 0.4 * np.sin(t[known][:-2]), atol=1e-12)


@pytest.mark.parametrize(
    ("vehicle", "actuator", "unit", "factor"),
    [
        ("remus100", "propeller", "rpm", 1.0),
        ("remus100", "propeller", "Hz", 60.0),
        ("remus100", "propeller", "rad/s", 30 / np.pi),
        ("remus100", "propeller", "", 1.0),
        ("remus100", "rudder", "deg", np.pi / 180),
        ("tanker", "engine", "rpm", 1 / 60),
        ("otter", "left_propeller", "rpm", np.pi / 30),
    ],
)
def test_commands_come_to_the_unit_of_their_actuator(vehicle, actuator, unit, factor):
    """A minute has 60 s, a turn 2 pi rad or 360 deg."""
    model = Vehicle.from_catalogue(vehicle).model
    plan = load_plan({**PLAN, "commands": {actuator: {"column": "n1", "unit": unit, "scale": -2, "zero": 3}}})
    record = read_record(table(), plan)
    given = -2 * (np.asarray(table()["n1"]) - 3)
    assert in_own_units(record, plan, model).commands[actuator] == pytest.approx(factor * given, rel=1e-12)


@pytest.mark.parametrize(
    ("actuator", "unit", "said"),
    [
        ("propeller", "N", "of another kind than that of its commands, rpm; give rad/s, deg/s, deg/min, rpm, Hz"),
        ("rudder", "rpm", "of another kind than that of its commands, rad; give rad, deg"),
    ],
)
def test_units_of_commands_of_another_kind_are_refused(actuator, unit, said):
    plan = load_plan({**PLAN, "commands": {actuator: {"column": "n1", "unit": unit}}})
    with pytest.raises(InputError, match=re.escape(f"plan: commands.{actuator}: the unit {unit} is {said}")):
        in_own_units(read_record(table(), plan), plan, Vehicle.from_catalogue("remus100").model)


def test_commands_of_an_actuator_that_the_vehicle_has_not_are_refused():
    plan = load_plan({**PLAN, "commands": {"left_propeler": "n1"}})
    with pytest.raises(
        LookupFailed, match=r"plan: commands: unknown actuator 'left_propeler' \(did you mean 'left_prop"
    ):
        in_own_units(read_record(table(), plan), plan, Vehicle.from_catalogue("otter").model)


def test_dropouts_are_left_out_and_commands_are_held():
    data = table()
    data["psi"][60:63], data["x"][60:63] = 0, 0
    plan = load_plan({**PLAN, "dropouts": [{"columns": ["psi", "x"], "value": 0}]})
    record = read_record(data, plan)
    np.testing.assert_allclose(record.measured["heading"][60:63], 0.4 * np.sin(data["t"][60:63]), atol=2e-3)
    np.testing.assert_array_equal(record.commands["left_propeller"], np.floor(data["t"] + 1e-9))


def test_slopes_are_body_velocities():
    """A circle at 0.8 m/s with 0.25 rad/s and a drift of 0.1 rad: u, v, r known in closed form."""
    t = 0.05 * np.arange(400)
    psi = 0.25 * t + 0.4
    over = psi + 0.1
    data = {"t": t, "x": 3.2 * np.sin(over), "y": -3.2 * np.cos(over), "psi": psi, "n1": t}
    record = read_record(data, load_plan({**PLAN, "columns": {"north": "x", "east": "y", "heading": "psi"}}))
    inside = slice(20, -20)
    # a parabola over 0.65 s misses a sine's slope by (w T / 2)^2 / 10 of it at most
    np.testing.assert_allclose(record.slopes["u"][inside], 0.8 * np.cos(0.1), rtol=1e-3)
    np.testing.assert_allclose(record.slopes["v"][inside], 0.8 * np.sin(0.1), atol=1e-3)
    np.testing.assert_allclose(record.slopes["r"][inside], 0.25, rtol=1e-9)


@pytest.mark.parametrize("steps", range(3, 42))
def test_a_stretch_as_long_as_a_parabola_is_enough_and_a_shorter_one_is_none(steps):
    """A parabola of `steps` has the odd number of rows nearest to it; its slope of t^2 is 2 t in every row."""
    h, plan = 0.05, load_plan({**PLAN, "smooth_s": 0.05 * steps})
    rows = max(11, next(n for n in (steps, steps + 1) if n % 2))
    data = {k: v[:rows] for k, v in table(50).items()}
    t = data["t"] = h * np.arange(rows)
    data["psi"] = t**2 + 0.3 * t
    np.testing.assert_allclose(read_record(data, plan).slopes["r"], 2 * t + 0.3, atol=1e-9)
    with pytest.raises(InputError, match=r"no stretch of the record is longer than"):
        read_record({k: v[:-1] for k, v in data.items()}, plan)


def test_csv_names_the_line(tmp_path):
    good = "t,x,psi,n1\n" + "".join(f"{k / 20},{k},{0.01 * k},1\n" for k in range(40))
    path = tmp_path / "run.csv.gz"
    path.write_bytes(gzip.compress(good.encode()))
    assert len(read_record(path, load_plan(PLAN)).measured["north"]) == 40
    bad = tmp_path / "bad.csv"
    bad.write_text(good.replace("7,0.07,1", "seven,0.07,1"))
    with pytest.raises(InputError, match=r"bad\.csv:9: column 'x': 'seven' is not a number"):
        read_record(bad, load_plan(PLAN))
    bad.write_text(good.replace("7,0.07,1", "7,1"))
    with pytest.raises(InputError, match=r"bad\.csv:9: 3 cells, but the first line names 4"):
        read_record(bad, load_plan(PLAN))
    bad.write_text(good.replace(",", ";"))
    with pytest.raises(InputError, match=r"bad\.csv: the first line has semicolons and no comma: separate cells with"):
        read_record(bad, load_plan(PLAN))


@pytest.mark.parametrize("blank", ["", " ", "\t "])
def test_a_cell_of_blanks_is_a_missing_number(tmp_path, blank):
    text = "t,x,psi,n1\n" + "".join(f"{k / 20},{k},{0.01 * k},1\n" for k in range(40))
    path = tmp_path / "run.csv"
    path.write_text(text.replace("7,0.07,1", f"{blank},0.07,1"))
    with pytest.raises(InputError, match=r"column 'x' has 1 cell that is empty .* row 8 \(0.35 s\)"):
        read_record(path, load_plan(PLAN))


def test_columns_that_nobody_names_may_hold_text(tmp_path):
    lines = ["t,mode,x,psi,n1", *(f"{k / 20},auto,{k},{0.01 * k},{k % 3 - 1}" for k in range(40))]
    path = tmp_path / "run.csv"
    path.write_text("\n".join(lines))
    record = read_record(path, load_plan(PLAN))
    np.testing.assert_allclose(record.measured["north"], np.arange(40.0), atol=1e-12)
    np.testing.assert_array_equal(record.commands["left_propeller"], np.arange(40) % 3 - 1)
    with pytest.raises(InputError, match=r"run\.csv:2: column 'mode': 'auto' is not a number"):
        read_record(path, load_plan({**PLAN, "columns": {"north": "mode"}}))
    with pytest.raises(LookupFailed, match=r"unknown column 'pssi'.*mode, n1, psi"):
        read_record(path, load_plan({**PLAN, "columns": {"heading": "pssi"}}))


@pytest.mark.parametrize("step", [0.1, 0.05, 1 / 30])
@pytest.mark.parametrize("start", [0.0, 100.0, 1.7e9])
def test_a_record_is_the_same_whenever_it_begins(start, step):
    """A stamp since 1970 is good to 2.4e-7 s: at 0.5 m/s that is 1.2e-7 m; the grid and commands have none of it."""
    rows = 900
    since = step * np.arange(rows)
    commands = np.where(np.arange(rows) % 7 < 3, -1.5, np.arange(rows))
    data = {"t": start + since, "x": 0.5 * since - 3, "psi": 0.4 * np.sin(since), "n1": commands}
    record = read_record(data, load_plan({**PLAN, "windows_s": [[start - 1, start + since[-1] + 1]]}))
    assert record.start_s == start
    assert record.step_s == step
    assert record.runs == ((0, rows),)
    np.testing.assert_array_equal(record.commands["left_propeller"], commands)
    np.testing.assert_allclose(record.measured["north"], 0.5 * since - 3, atol=1e-6)
    np.testing.assert_allclose(record.measured["heading"], 0.4 * np.sin(since), atol=1e-6)


def test_stamps_may_be_whole_nanoseconds():
    """Rows of 1/30 s, which no whole number of nanoseconds is: the rate of 30 Hz, and the same rows at the end."""
    stamps = 1_700_000_000_000_000_000 + np.round(np.arange(9000) / 30 * 1e9).astype(np.int64)
    clock = clock_of(stamps, ColumnConfig(column="t", unit="ns"), "data")
    assert clock.step_s == 1 / 30
    assert clock.t[-1] == pytest.approx(8999 / 30, abs=1e-9)
    assert clock.say(12.35) == "1700000000+12.35"


def test_uneven_rows_have_their_median_as_a_step():
    random = np.random.default_rng(3)
    since = np.cumsum(0.1 + random.uniform(-0.01, 0.01, 301))
    clock = clock_of(50 + since, ColumnConfig(column="t"), "data")
    assert clock.step_s == round(float(np.median(np.diff(50 + since))), 9)
    assert clock.say(1.5) == f"{50 + since[0] + 1.5:.6g}"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"columns": {"north": {"column": "x", "unit": "deg"}}}, "columns.north: the unit deg is .* give m, cm, mm"),
        (
            {"columns": {"r": {"column": "x", "unit": "kn"}}},
            "columns.r: the unit kn .* give rad/s, deg/s, deg/min, rpm, Hz",
        ),
        (
            {"columns": {"u": {"column": "x", "unit": "m"}}},
            "columns.u: the unit m is .* give m/s, cm/s, mm/s, km/h, kn",
        ),
        ({"time": {"column": "t", "unit": "kn"}}, "time: the unit kn is of another kind; give s, ms, us, ns"),
        (
            {"commands": {"left_propeller": {"column": "n1", "unit": "ms"}}},
            "commands.left_propeller: the unit ms is of another kind; give m, .* N",
        ),
        ({"time": {"column": "t", "delay_s": 0.1}}, "plan: time: delay_s belongs to columns"),
        ({"windows_s": [[3, 2]]}, "plan: windows_s: 3 is not before 2"),
        ({"windows_s": [[4, 9], [0, 2], [1, 4]]}, "plan: windows_s: 1 to 4 begins before 0 to 2 ends"),
    ],
)
def test_a_plan_that_cannot_be_meant_is_refused(change, said):
    with pytest.raises(ScenarioError, match=said):
        load_plan({**PLAN, **change})


def descent(*columns: str, **change: float) -> None:
    """Read 40 s of a dive at 1.5 m/s with a pitch of some degrees and a heave, by its closed form, with columns times
    `change`: the depth's rate is -u sin(pitch) + w cos(pitch).
    """
    t = 0.05 * np.arange(800)
    pitch, w = -0.12 + 0.1 * np.sin(0.4 * t), 0.04 + 0.05 * np.cos(0.7 * t)
    ahead, rate = 1.5 * np.cos(pitch) + w * np.sin(pitch), -1.5 * np.sin(pitch) + w * np.cos(pitch)
    data = {"t": t, "u": np.full(len(t), 1.5), "w": w, "pitch": pitch, "heading": np.full(len(t), 0.7), "n1": t // 3}
    for name, velocity in {"depth": rate, "north": np.cos(0.7) * ahead, "east": np.sin(0.7) * ahead}.items():
        data[name] = 5 + np.concatenate([[0], np.cumsum(0.025 * (velocity[1:] + velocity[:-1]))])
    data = {name: x * change.get(name, 1.0) for name, x in data.items()}
    plan = {"columns": {name: name for name in columns}, "commands": {"left_propeller": "n1"}}
    read_record(data, load_plan(plan))


@pytest.mark.parametrize(
    ("columns", "by"),
    [
        ("depth pitch u w", "w"),
        ("depth pitch u", "the way ahead and the pitch"),
        ("depth pitch north east heading", "the way ahead and the pitch"),
    ],
)
@pytest.mark.parametrize(("times", "unit"), [(1.0, ""), (100.0, "cm"), (1 / 1852, "nmi")])
def test_a_depth_in_another_unit_than_the_descent_is_refused(columns, by, times, unit):
    if not unit:
        descent(*columns.split())
        return
    said = (
        f"column 'depth' as depth changes .* as fast as the vehicle descends by {by}, as if it were in {unit} and not"
    )
    with pytest.raises(InputError, match=said):
        descent(*columns.split(), depth=times)


def test_a_depth_in_feet_or_upwards_is_refused_where_heave_is_measured():
    with pytest.raises(InputError, match=r"changes 3\.2[78] times .* as if it were in ft and not in m: give unit: ft"):
        descent("depth", "pitch", "u", "w", depth=1 / 0.3048)
    with pytest.raises(InputError, match=r"falls where the vehicle descends by w \(correlation -1\.00\)"):
        descent("depth", "pitch", "u", "w", u=-1, w=-1)
    descent("depth", "pitch", "u", u=-1)  # a heave may do that
    descent("depth", "w", "north", depth=20)  # what pitches descends by its way ahead


def test_one_cell_is_one_cell():
    def hole(d):
        d["psi"][7] = np.nan

    refused(hole, match="column 'psi' has 1 cell that is empty or not a number")


class _Bag:
    """A recording since 1970 by another program: poses 30 times a second, and a command every fifth time."""

    channels: ClassVar[dict] = {}
    attachments: ClassVar[dict] = {}
    metadata: ClassVar[dict] = {}

    def __init__(self, path):
        self.stamps = 1_700_000_000_000_000_000 + np.round(np.arange(600) / 30 * 1e9).astype(np.int64)

    def topics(self):
        return ["/pose", "/thrust"]

    def messages(self, topic):
        for k, ns in enumerate(self.stamps):
            if topic == "/pose":
                yield SimpleNamespace(t_ns=int(ns), message={"x": 0.02 * k, "psi": 0.001 * k})
            elif k % 5 == 0:
                yield SimpleNamespace(t_ns=int(ns), message={"data": float(k)})


def test_a_recording_since_1970_has_its_rows(monkeypatch):
    monkeypatch.setattr("pelagos.identification.recording.Recording", _Bag)
    columns = {"columns": {"north": "/pose.x", "heading": "/pose.psi"}, "commands": {"left_propeller": "/thrust.data"}}
    record = read_record("bag.mcap", load_plan(columns))
    assert record.step_s == 1 / 30
    assert record.start_s == 1.7e9
    k = np.arange(600)
    np.testing.assert_array_equal(record.commands["left_propeller"], k - k % 5)
    np.testing.assert_allclose(record.measured["north"], 0.02 * k, atol=1e-9)  # 0.6 m/s, rounded to 1 ns
    said = r"windows_s: 0 to 20 s lies outside of the record; time goes from 1700000000\+0 to 1700000000\+19\.9667 s"
    with pytest.raises(InputError, match=said):
        read_record("bag.mcap", load_plan({**columns, "windows_s": [[0, 20]]}))


def test_unknown_keys_of_a_plan_are_told_with_the_nearest():
    with pytest.raises(ScenarioError, match=r"segments: unknown key 'segments' .did you mean 'segment_s'"):
        load_plan({**PLAN, "segments": 3})
    with pytest.raises(ScenarioError, match=r"parameters\.X\.pth: unknown key 'pth' .did you mean 'path'"):
        load_plan({**PLAN, "parameters": {"X": {"pth": "length_m"}}})


def test_a_column_without_any_number_is_told_as_a_whole():
    refused(lambda d: d.update(n1=np.full(200, np.nan)), match="column 'n1' is empty or not a number in every row")


def test_columns_of_a_run_are_north_east_down_and_forward_right_down():
    """The recorded Odometry of a pose that SciPy turns, on all axes."""
    angles, place, nu = (
        np.array([0.3, -0.2, 2.5]),
        np.array([3.0, -4.0, 5.0]),
        np.array([1.0, -0.4, 0.3, 0.2, -0.1, 0.6]),
    )
    flip = np.diag([1.0, -1.0, -1.0])
    turn = Rotation.from_matrix(flip @ Rotation.from_euler("ZYX", angles[::-1]).as_matrix() @ flip)
    raw, _ = TruthEncoder("usv0/base_link").encode(
        0, flip @ place, turn.as_quat(scalar_first=True), flip @ nu[:3], flip @ nu[3:]
    )
    message = deserialize(ODOMETRY, bytes(raw))
    expected = dict(zip(COORDINATES, [*place, *angles, *nu], strict=True))
    for name, (field, scale, zero) in COLUMNS.items():
        found = scale * (_field(message, field.split("."), field, Path("run.mcap")) - zero)
        off = found - expected[name]
        assert off - 2 * np.pi * round(off / (2 * np.pi)) == pytest.approx(0, abs=1e-12), name
    assert tuple(COLUMNS) == COORDINATES


def test_numbers_are_read_by_the_names_in_their_label():
    rows = LabelledRow(("left", "right"), ("rad/s", "")).rows(np.array([[1.5, -2.0], [3.0, 4.0]]))
    message = deserialize(MULTI_ARRAY, rows[1].tobytes())
    assert message.layout.dim[0].label == "left [rad/s], right [-]"
    assert [_field(message, [n], n, Path("a.mcap")) for n in ("left", "right")] == [3.0, 4.0]
    assert _field(message, ["data", "0"], "data.0", Path("a.mcap")) == 3.0
    with pytest.raises(LookupFailed, match=r"number 'lft' .did you mean 'left'"):
        _field(message, ["lft"], "lft", Path("a.mcap"))


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (
            lambda x: np.array(["n/a" if k == 30 else str(v) for k, v in enumerate(x)]),
            "'psi', row 31: 'n/a' is not a number",
        ),
        (lambda x: np.array([None if k == 30 else v for k, v in enumerate(x)]), r"1 cell .* row 31 "),
        (lambda x: np.array(["" if k == 4 else str(v) for k, v in enumerate(x)]), r"1 cell .* row 5 "),
        (lambda x: [*x[:-1], object()], "'psi', row 200: <object .* is not a number"),
        (lambda x: np.ma.masked_where(np.arange(len(x)) == 7, x), r"1 cell .* row 8 "),
        (lambda x: x + 0.1j, "holds complex numbers"),
        (lambda x: 0.3, "column 'psi' is 0.3: give one number a row"),
        (lambda x: np.stack([x, x], -1), r"has the shape \(200, 2\): give one number a row"),
        (lambda x: [[1.0], [2.0, 3.0]], "is no column of numbers"),
        (lambda x: x[:-3], "has 197 rows, and the time has 200"),
    ],
)
def test_columns_of_python_that_are_no_numbers_are_refused(values, said):
    refused(lambda d: d.update(psi=values(d["psi"])), match=said)


def test_text_of_python_is_read_as_that_of_a_file():
    data, plan = table(), load_plan(PLAN)
    text = {**data, "psi": np.array([f" {x!r}" for x in data["psi"].tolist()], dtype=object), "note": ["a", "b"]}
    np.testing.assert_array_equal(
        read_record(text, plan).measured["heading"], read_record(data, plan).measured["heading"]
    )


def test_what_is_no_table_is_refused():
    plan = load_plan(PLAN)
    with pytest.raises(InputError, match="give a file or columns by name, not list"):
        read_record([1.0, 2.0], plan)
    with pytest.raises(InputError, match="there are no columns"):
        read_record({}, plan)
    refused(lambda d: d.update(t=np.datetime64("2024-01-01") + d["t"].astype("timedelta64[s]")), match="holds dates")
    refused(lambda d: d.update({k: v[:1] for k, v in d.items()}), match="1 of the 10 rows")
    with pytest.raises(ScenarioError, match="must be a file or a mapping of keys, not list"):
        load_plan([1])


class Frame:
    """Like a data frame: iterates over names of columns."""

    def __init__(self, columns):
        self._columns = columns

    def keys(self):
        return self._columns.keys()

    def __iter__(self):
        return iter(self._columns)

    def __getitem__(self, name):
        return self._columns[name]


def test_a_data_frame_is_a_table():
    plan = load_plan(PLAN)
    found = read_record(Frame(table()), plan)
    np.testing.assert_array_equal(found.measured["north"], read_record(table(), plan).measured["north"])


@pytest.mark.parametrize(("key", "name"), [("columns", "heading"), ("commands", "left_propeller")])
@pytest.mark.parametrize("delay", [500, -10])
def test_a_delay_beyond_the_record_is_refused(key, name, delay):
    column = {"columns": "psi", "commands": "n1"}[key]
    plan = {key: {**PLAN[key], name: {"column": column, "delay_s": delay}}}
    said = rf"plan: {key}\.{name}: delay_s {delay} reaches beyond the record, which is 9\.95 s long"
    refused(lambda d: None, plan, match=said)


def test_a_delay_leaves_out_what_it_moves_beyond_the_record():
    """Rows 1 s late: nothing is known of the last second; commands 0.5 s early, of the first half, and 1.5 s late."""
    columns = {**PLAN["columns"], "heading": {"column": "psi", "delay_s": 1}}
    early, late = {"column": "n1", "delay_s": -0.5}, {"column": "n1", "delay_s": 1.5}
    record = read_record(table(), load_plan({"columns": columns, "commands": {"early": early}}))
    assert record.runs == ((10, 180),)
    t = table()["t"]
    np.testing.assert_allclose(record.measured["heading"][10:180], 0.4 * np.sin(t[10:180] + 1), atol=2e-4)
    np.testing.assert_array_equal(record.commands["early"][10:], np.floor(t[10:] - 0.5 + 1e-9))
    record = read_record(table(), load_plan({"columns": columns, "commands": {"early": early, "late": late}}))
    assert record.runs == ((10, 170),)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"columns": {"u": {"column": "x", "unit": "knots"}}},
         r"columns\.u: unknown unit 'knots' .did you mean 'kn'.*; give m/s, cm/s, mm/s, km/h, kn$"),
        ({"columns": {"heading": {"column": "x", "unit": "Degrees"}}},
         r"unknown unit 'Degrees' .did you mean 'deg'.*; give rad, deg$"),
        ({"time": {"column": "t", "unit": "sec"}},
         r"time: unknown unit 'sec' .did you mean 's'.*; give s, ms, us, ns, min, h$"),
        ({"commands": {"left_propeller": {"column": "n1", "unit": "RPMs"}}},
         r"commands\.left_propeller: unknown unit 'RPMs' .did you mean 'rpm'.*; give m, .*, N, kN$"),
        ({"columns": {"north": {"column": "x", "unit": "NM"}}}, "unknown unit 'NM' .did you mean 'nmi'"),
        ({"columns": {"r": {"column": "x", "unit": "°/min"}}}, "unknown unit '°/min' .did you mean 'deg/min'"),
        ({"columns": {"north": 3}}, r"columns\.north: give the name of a column, or .column, unit, .*, not 3$"),
        ({"columns": {"north": "x", "east": "x"}}, "columns.east: 'x' is columns.north already"),
        ({"columns": {"north": "t"}}, "columns.north: 't' is time already"),
        ({"commands": {"left_propeller": "x"}}, "commands.left_propeller: 'x' is columns.north already"),
        ({"fit_to": ["u", "u"]}, "fit_to: u is named twice"),
        ({"sigma": {"depth": 0.1}}, "sigma: depth is not fitted, only north, heading"),
        ({"dropouts": [{"columns": []}]}, r"dropouts\.0\.columns: "),
    ],
)  # fmt: skip
def test_units_and_columns_that_cannot_be_are_told(change, said):
    with pytest.raises(ScenarioError, match=said):
        load_plan({**PLAN, **change})


@pytest.mark.parametrize(
    ("plan", "said"),
    [
        ({"windows_s": [[4, 9], [20, 30]]},
         r"windows_s: 20 to 30 s lies outside of the record; time goes from 3 to 12\.95 s"),
        ({"windows_s": [[4, 4.1]]}, r"is longer than 0\.6 s, 12 steps of 0\.05 s"),
        ({"step_s": 1e-6}, r"step_s: 1e-06 s is too short for rows that are 0\.05 s apart; give 5e-05"),
    ],
)  # fmt: skip
def test_windows_and_steps_that_cannot_be_are_told(plan, said):
    refused(lambda d: None, plan, match=said)


def turning(n: int = 420, h: float = 0.05) -> dict:
    """A vehicle that goes where it looks, around and around, at a speed that changes."""
    t = h * np.arange(n)
    heading, speed = 0.9 * t + 0.3 * np.sin(t), 1.0 + 0.3 * np.sin(0.7 * t)
    north, east = np.cumsum(h * speed * np.cos(heading)), np.cumsum(h * speed * np.sin(heading))
    return {"t": t, "x": north, "y": east, "psi": heading, "u": speed, "r": 0.9 + 0.3 * np.cos(t)}


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({}, ""),
        ({"u": "u", "r": "r"}, ""),
        ({"u": {"column": "u", "scale": 1.3}}, ""),
        ({"u": {"column": "u", "scale": 3600 / 1852}}, "'u' as u is 1.9.* in kn and not in m/s: give unit: kn"),
        ({"u": {"column": "u", "unit": "kn"}}, "times the slope .* in m/s and not in kn: give unit: m/s"),
        ({"u": {"column": "u", "scale": -1}}, r"'u' as u goes against the slope .* scale: -1"),
        ({"r": {"column": "r", "unit": "deg/s"}}, r"as if it were in rad/s and not in deg/s"),
        ({"r": {"column": "r", "scale": -1}}, r"'r' as r goes against the slope"),
        ({"heading": {"column": "psi", "unit": "deg"}}, "if it is in radians .* and not in degrees .* unit: rad"),
    ],
)  # fmt: skip
def test_velocities_that_are_not_slopes_of_their_pose_are_told(columns, said):
    plan = load_plan({"columns": {"north": "x", "east": "y", "heading": "psi", **columns}, "commands": {}})
    if not said:
        assert read_record(turning(), plan).runs
        return
    with pytest.raises(InputError, match=said):
        read_record(turning(), plan)


def test_a_shot_of_less_than_two_steps_is_refused():
    plan = load_plan({**PLAN, "segment_s": 0.05})
    with pytest.raises(InputError, match=r"segment_s: 0\.05 s is less than 2 steps of 0\.05 s"):
        cut_shots(read_record(table(), plan), plan, 3.0)


def test_every_unit_is_its_definition():
    """A knot is a nautical mile of 1852 m in an hour; a turn is 2 pi."""
    turn = 2 * np.pi
    units = {
        "m": 1, "cm": 1e-2, "mm": 1e-3, "rad": 1, "deg": turn / 360, "m/s": 1, "cm/s": 1e-2, "mm/s": 1e-3,
        "km/h": 1000 / 3600, "kn": 1852 / 3600, "rad/s": 1, "deg/s": turn / 360, "rpm": turn / 60, "Hz": turn,
        "s": 1, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "N": 1, "": 1, "km": 1e3, "nmi": 1852, "ft": 12 * 0.0254,
        "deg/min": turn / 360 / 60, "min": 60, "h": 3600, "kN": 1e3,
    }  # fmt: skip
    assert units.keys() == UNIT_SCALES.keys()
    for unit, factor in units.items():
        assert ColumnConfig(column="x", unit=unit, scale=-2.5).factor == pytest.approx(-2.5 * factor, rel=1e-12)


def test_a_prior_is_the_vehicles_own_number_over_the_factor_of_its_path():
    """So that the vehicle with the prior is the vehicle as it was, at the first of the paths."""
    data = {"terms": {"drag": {"diagonal": [12.0, -40.0, 7.0]}}, "mass_kg": 20.0}
    paths = ("terms.drag.diagonal.1", "mass_kg", "current.east")
    given = {
        "own": ParameterConfig(path=paths[:2], factors=(-2.5, 4.0)),
        "told": ParameterConfig(path=("terms.drag.diagonal.2", "terms.drag.diagonal.0"), factors=(2.0, 3.0), prior=5.0),
        "east": ParameterConfig(path=("current.east",), factors=(-0.5,)),
    }
    found = parameters_of(given, data, {"current.east": 0.3})
    assert [p.prior for p in found] == pytest.approx([16.0, 5.0, -0.6])
    new = changed(data, found, [p.prior for p in found])
    assert new["terms"]["drag"]["diagonal"] == pytest.approx([15.0, -40.0, 10.0])
    assert new["mass_kg"] == pytest.approx(64.0)


NED = {"columns": {"north": "x", "east": "y", "heading": "psi"}, "commands": {}}


def under_way(h: float = 0.1, n: int = 400) -> dict:
    """A vehicle at 1.5 m/s that turns to and fro, from 7 m north and -9 m east on, with a tracker's noise of 5 mm."""
    random, t = np.random.default_rng(3), h * np.arange(n)
    heading = 0.8 * np.sin(0.3 * t) + 0.4
    north, east = 7 + np.cumsum(1.5 * h * np.cos(heading)), -9 + np.cumsum(1.5 * h * np.sin(heading))
    noise = 0.005 * random.normal(size=(3, n))
    speed = 1.5 + 0.2 * np.sin(t)
    return {"t": 100 + t, "x": north + noise[0], "y": east + noise[1], "psi": heading + noise[2], "u": speed + noise[0]}


@pytest.mark.parametrize("h", [0.05, 0.1, 1.0])
@pytest.mark.parametrize("size", [-50.0, 50.0])
@pytest.mark.parametrize("stays", [False, True])
def test_one_jump_of_the_position_is_told_with_row_and_time(h, size, stays):
    data = under_way(h)
    assert read_record(data, load_plan(NED)).doubts == ()
    before = data["y"].copy()
    data["y"][200 : None if stays else 201] += size
    (text,) = read_record(data, load_plan(NED)).doubts
    a, b = 100 + 199 * h, 100 + 200 * h
    if stays:
        assert text.startswith(
            f"east jumps from {before[199]:.4g} to {before[200] + size:.4g} m between rows 200 and 201"
        )
        assert f"({a:.6g} and {b:.6g} s), the only one: a fault, or a tracker that was set anew?" in text
    else:
        assert "the largest of 2, the first after row 200" in text


def test_a_jump_of_a_velocity_or_an_angle_is_told_and_whole_turns_are_none():
    data = under_way()
    data["psi"] += np.where(np.arange(400) > 300, 2 * np.pi, 0.0)
    plan = load_plan({**NED, "columns": {**NED["columns"], "u": "u"}})
    assert read_record(data, plan).doubts == ()
    data["u"][77] = -32.768
    data["psi"][90] += 1.0
    heading, u = read_record(data, plan).doubts
    assert heading.startswith("heading jumps from ")
    assert "to -32.77 m/s between rows 77 and 78 (107.6 and 107.7 s)" in u


@pytest.mark.parametrize("value", [0.0, -99.5])
@pytest.mark.parametrize("column", ["x", "y"])
def test_drop_outs_are_told_with_row_time_and_cure(value, column):
    data = under_way()
    data[column][[50, 51, 52, *range(120, 160)]] = value
    said = (
        rf"column '{column}' as .* jumps to exactly {value:g} and back, in 43 rows, the first in row 51 \(105 s\): "
        rf"drop-outs\? Name them in the plan \(dropouts: \[.columns: \[{column}\], value: {value:g}"
    )
    with pytest.raises(InputError, match=said):
        read_record(data, load_plan(NED))
    named = {**NED, "dropouts": [{"columns": [column], "value": value}], "gaps": "split"}
    assert read_record(data, load_plan(named)).doubts == ()


def test_a_fault_beyond_all_numbers_is_a_jump_and_many_are_no_wrong_unit():
    data = under_way()
    data["y"][33] = 1e9
    (text,) = read_record(data, load_plan(NED)).doubts
    assert "to 1e+09 m between rows 33 and 34" in text or "from 1e+09 to" in text
    data = under_way()
    data["x"][10:390:20] += np.random.default_rng(1).normal(size=19) * 100
    with pytest.raises(InputError, match=r"'x' as north jumps in \d+ % of its rows, too many for faults"):
        read_record(data, load_plan(NED))


def test_what_is_held_or_rounded_does_not_jump():
    """A position once a second in rows of 0.1 s, and one written to 0.1 m."""
    held = under_way()
    for name in ("x", "y"):
        held[name] = np.repeat(held[name][::10], 10)
    assert read_record(held, load_plan(NED)).doubts == ()
    anew = {**held, "x": held["x"] + np.where(np.arange(400) >= 200, 50.0, 0.0)}
    (text,) = read_record(anew, load_plan(NED)).doubts  # what is held after a jump is no drop-out
    assert "between rows 200 and 201" in text
    rounded = under_way()
    for name in ("x", "y"):
        rounded[name] = np.round(rounded[name], 1)
    assert read_record(rounded, load_plan(NED)).doubts == ()


def test_a_column_that_does_not_change_is_told():
    """But for what a vehicle of three degrees of freedom never does."""
    data = {**under_way(), "psi": np.full(400, 0.3), "roll": np.zeros(400), "pitch": np.full(400, 0.1)}
    columns = {**NED["columns"], "roll": "roll", "pitch": "pitch"}
    (text,) = doubts_of_record(read_record(data, load_plan({**NED, "columns": columns})))
    assert text.startswith(
        "heading 0.3 rad, pitch 0.1 rad: the same in all rows that are used, so that nothing excites it"
    )


@pytest.mark.parametrize("current", [(0.0, 0.0), (0.5, -0.6), (-0.2, 0.9)])
@pytest.mark.parametrize("turn", [0.7, 2.0, 30.0])
@pytest.mark.parametrize("written", ["rad", "deg"])
def test_the_unit_of_a_heading_is_known_in_a_current_too(current, turn, written):
    """1 m/s ahead and 0.8 m/s aside, with a current that is as fast, and turns of `turn` rad to either side."""
    t = 0.2 * np.arange(900)
    heading = turn * np.sin(min(0.05, 1.5 / turn) * t) + 0.6
    ahead, noise = 1 + 0.1 * np.sin(0.3 * t), 0.01 * np.random.default_rng(2).normal(size=(2, 900))
    north = np.cumsum(0.2 * (ahead * np.cos(heading) - 0.8 * np.sin(heading) + current[0])) + noise[0]
    east = np.cumsum(0.2 * (ahead * np.sin(heading) + 0.8 * np.cos(heading) + current[1])) + noise[1]
    data = {"t": t, "x": north, "y": east, "psi": np.degrees(heading) if written == "deg" else heading}
    for unit in ("rad", "deg", ""):
        plan = load_plan({**NED, "columns": {**NED["columns"], "heading": {"column": "psi", "unit": unit}}})
        if (unit or "rad") == written or (written == "deg" and unit == "" and turn < 40 / 57.3 / 2):
            assert read_record(data, plan).runs
        elif unit == "deg" or np.ptp(data["psi"]) > 40:
            with pytest.raises(InputError, match=f"degrees|unit: {written}"):
                read_record(data, plan)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"train": 1.5}, "plan: train: must be at most 1, not 1.5$"),
        ({"train": "most"}, "plan: train: expected a number, not 'most'$"),
        ({"loss": "hubr"}, r"plan: loss: 'hubr' is not allowed \(did you mean 'huber'\?\); allowed: huber, squares$"),
        ({"integrator": "rk4"}, "integrator: 'rk4' is not allowed; allowed: conservative, semi_implicit, runge_kutta,"),
        ({"segment_s": "15 s"}, r"segment_s: expected a number of seconds \[s\], not '15 s'; write 15$"),
        ({"bootstrap": 2.5}, "bootstrap: expected a whole number, not 2.5$"),
        ({"windows_s": [[1]]}, r"windows_s\.0: expected 2 values \[s\], not 1: \[1\]$"),
        ({"gaps": "fill"}, "gaps: 'fill' is not allowed; allowed: refuse, split$"),
        ({"parameters": {"X": {"path": ["a", "b"], "factors": [2]}}},
         r"parameters\.X: factors: 1 of them, but the number of paths is 2; give one each$"),
        ({"parameters": {"X": {"spread": -1}}}, r"parameters\.X\.spread: must be greater than 0, not -1$"),
        ({"dropouts": {"columns": ["x"]}}, "dropouts: expected a list, not "),
        ({"columns": {"north": {"colum": "x"}}}, "unknown key 'colum' .did you mean 'column'"),
    ],
)  # fmt: skip
def test_values_that_a_plan_cannot_have_are_told_in_words(change, said, tmp_path):
    with pytest.raises(ScenarioError, match=said) as told:
        load_plan({**PLAN, **change})
    assert "nput should" not in str(told.value)


SIGNS = "have different signs, and a log scale keeps that of the prior: leave"


@pytest.mark.parametrize(("keys", "said"), [
    ({"low": -5, "high": 4}, f"low -5 and high 4 {SIGNS} high out, give it below 0, or give scale: linear"),
    ({"low": -5, "prior": 3}, f"prior 3 and low -5 {SIGNS} low out, give it above 0, or give scale: linear"),
    ({"high": 5, "prior": -3}, f"prior -3 and high 5 {SIGNS} high out, give it below 0, or give scale: linear"),
    ({"low": 0}, "low 0 is on no log scale: leave it out, give another, or give scale: linear"),
    ({"low": -2, "high": 0}, "high 0 is on no log scale"), ({"low": 4, "high": 4}, "low 4 must be below high 4"),
    ({"low": -5, "high": -7}, "low -5 must be below high -7"),
    ({"low": -5}, ""), ({"high": 4}, ""), ({"low": 2, "high": 4, "prior": 3}, ""),
    ({"low": -4, "high": -2, "prior": -3}, ""),
])  # fmt: skip
def test_bounds_that_a_log_scale_does_not_reach_are_refused_with_their_line(keys, said, tmp_path):
    """A logarithm is of one sign and never of 0; which one it is the prior says, or where it has none the vehicle."""
    file = tmp_path / "plan.yaml"
    told = "".join(f"    {key}: {value}\n" for key, value in {"path": "lift", "scale": "log", **keys}.items())
    file.write_text(f"columns: {{north: x}}\ncommands: {{}}\nparameters:\n  X:\n{told}")
    if not said:
        assert load_plan(file).parameters["X"].scale == "log"
        return
    with pytest.raises(ScenarioError) as error:
        load_plan(file)
    assert f"plan.yaml:4: parameters.X: {said}" in str(error.value)


@pytest.mark.parametrize(("lift", "keys", "said"), [
    (3.0, {"low": -5}, f"prior 3 and low -5 {SIGNS} low out, give it above 0"),
    (3.0, {"low": -5, "high": 5}, f"prior 3 and low -5 {SIGNS}"),
    (-3.0, {"high": 5}, f"prior -3 and high 5 {SIGNS} high out, give it below 0"), (3.0, {"low": 0}, "low 0 is on no"),
    (-3.0, {"high": 0}, "high 0 is on no log scale"), (-3.0, {"low": 0}, "low 0 is on no log scale"),
    (-3.0, {"low": -5}, ""), (3.0, {"high": 5}, ""), (3.0, {"low": -5, "scale": "linear"}, ""),
    (0.0, {"low": -1, "high": 2, "path": "current.east"}, ""),
])  # fmt: skip
def test_bounds_have_the_sign_of_the_vehicles_own_number_on_a_log_scale(lift, keys, said):
    """Where no scale is given it is log; of what is known beside the vehicle, such as a current, linear."""
    plan = load_plan({**PLAN, "parameters": {"X": {"path": "lift", **keys}}})
    if not said:
        (found,) = parameters_of(plan.parameters, {"lift": lift})
        assert [found.low, found.high][keys.get("low") is None] == keys.get("low", keys.get("high"))
        return
    with pytest.raises(InputError) as error:
        parameters_of(plan.parameters, {"lift": lift})
    assert f"plan: parameters.X: {said}" in str(error.value)


def test_a_fault_of_a_plan_is_told_with_its_line(tmp_path):
    file = tmp_path / "plan.yaml"
    file.write_text(
        "columns: {north: x}\ncommands: {}\nparameters:\n  X:\n    path: mass_kg\n    low: 1e3\n    high: 2\n"
    )
    with pytest.raises(ScenarioError, match=r"plan\.yaml:4: parameters\.X: low 1000 must be below high 2"):
        load_plan(file)
    with pytest.raises(ScenarioError, match=r"there is no such file \(did you mean 'plan\.yaml'\?\)"):
        load_plan(tmp_path / "plna.yaml")


def test_one_path_may_have_a_factor():
    plan = load_plan({**PLAN, "parameters": {"m": {"path": "mass_kg", "factors": [2.5]}}})
    (found,) = parameters_of(plan.parameters, {"mass_kg": 20.0})
    assert found.prior == pytest.approx(8.0)


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("diagnal", r"did you mean terms\.drag\.diagonal\.0\?.* unknown key 'diagnal'; known: current.east, "),
        ("drag.diagonal.1", r"did you mean terms\.drag\.diagonal\.1\?"),
        ("terms.drag.diagnal.1", r"unknown key below 'terms\.drag' 'diagnal' \(did you mean 'diagonal'\?\)"),
        ("mass", r"unknown key 'mass' \(did you mean 'mass_kg'\?\)"),
        ("zzz", "unknown key 'zzz'; known: "),
    ],
)
def test_a_path_that_is_not_there_is_told_with_the_nearest(path, said):
    data = {"terms": {"drag": {"diagonal": [12.0, -40.0, 7.0]}}, "mass_kg": 20.0}
    with pytest.raises(LookupFailed) as told:
        parameters_of({"X": ParameterConfig(path=path)}, data)
    assert re.search(said, str(told.value)), told.value
    assert ("did you mean" in str(told.value)) == (path != "zzz")


def test_radians_that_turn_over_are_known_where_they_are_called_degrees():
    """A hovering vehicle, whose way says nothing, and whose heading goes through north or south."""
    t = 0.1 * np.arange(600)
    for wrapped in ((0.25 * t + np.pi) % (2 * np.pi) - np.pi, 0.25 * t % (2 * np.pi)):
        data = {"t": t, "psi": wrapped}
        plan = {"columns": {"heading": {"column": "psi", "unit": "deg"}}, "commands": {}}
        with pytest.raises(
            InputError, match=r"no number is beyond 2 pi, and they jump by 6\.\d+: radians\? Give unit: rad"
        ):
            read_record(data, load_plan(plan))
        assert read_record({**data, "psi": 3 * np.sin(t)}, load_plan(plan)).runs


def test_a_file_that_is_not_there_is_told_with_the_nearest(tmp_path):
    (tmp_path / "tank.csv").write_text("t\n1\n")
    with pytest.raises(InputError, match=r"there is no such file \(did you mean 'tank\.csv'\?\)"):
        read_record(tmp_path / "tnak.csv", load_plan(PLAN))
