"""The command line without a device: help, check, list, schema, cite, errors and exit codes."""

from __future__ import annotations

import csv
import json
import socket
import subprocess
import sys
import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.cli.main import main
from pelagos.errors import ValidityWarning

ROOT = Path(__file__).parents[2]
HARBOUR = str(ROOT / "examples" / "harbour_survey.yaml")
SMALL = """\
world: {type: flat, depth_m: 20}
duration_s: 2
agents:
  auv0:
    vehicle: remus100
    start: {depth_m: 5, speed_mps: 1}
    sensors:
      imu: {type: imu, rate_hz: 100}
      depth: {type: depth, rate_hz: 10}
"""


@pytest.fixture
def small(tmp_path: Path) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    return path


def outcome(*arguments: str) -> int:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    return int(caught.value.code or 0)


@pytest.mark.parametrize("command", ["run", "check", "list", "explain", "world", "schema", "bench", "recover", "cite"])
def test_help_of_every_command_teaches_by_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(command, "--help") == 0
    text = capsys.readouterr().out
    assert f"pelagos {command}" in text
    assert "Example" in text


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("--version") == 0
    assert capsys.readouterr().out.startswith("pelagos ")


def test_no_arguments_show_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome() in (0, 2)
    captured = capsys.readouterr()
    assert "explain" in captured.out + captured.err


def test_help_and_check_need_no_simulator() -> None:
    code = (
        "import sys; from pelagos.cli.main import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'drjit', 'mitsuba', 'numpy', 'pydantic', 'matplotlib', 'scipy'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


@pytest.mark.parametrize("name", ["harbour_survey", "adriatic_survey", "venice_survey", "salish_sea"])
def test_examples_are_valid(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("check", "--no-build", str(ROOT / "examples" / f"{name}.yaml")) == 0  # surveys lie elsewhere
    text = capsys.readouterr().out
    assert "a valid scenario" in text
    assert "multibeam" in text
    assert "lawn-mower pattern" in text


@pytest.mark.parametrize(
    ("ocean", "words"),
    [
        (
            "{waves: {type: jonswap, significant_hight_m: 1, peak_period_s: 5}}",
            "(did you mean 'significant_height_m'?)",
        ),
        ("{waves: {type: sea_state, state: 3}, waves_depth_m: 0}", "waves_depth_m: must be greater than 0 [m], not 0"),
        ("{waves: {type: table, frequency_hz: [0.1, 0.2], density_m2phz: [0, 0]}}", "somewhere positive"),
        ("{currents: {type: gridded, file: nothing.nc}}", "ocean.currents[0]: there is no file"),
        ("{temperature_c: [{type: gridded, file: nothing.nc}]}", "ocean.temperature_c: there is no file"),
        ("{tracers: {dye: [{type: gridded, file: nothing.nc}]}}", "ocean.tracers.dye: there is no file"),
    ],
)
def test_check_refuses_an_ocean_that_a_run_would_refuse(
    small: Path, ocean: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    small.write_text(f"{SMALL}origin: {{latitude_deg: 44, longitude_deg: 13}}\nocean: {ocean}\n")
    assert outcome("check", str(small)) == 2
    assert words in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("agents.auv0.start.depth_m=1000", "cannot start here"),
        ("agents.auv0.sensors.dye={type: tracer, tracer: dye, rate_hz: 1}", "dye"),
        ("world={type: bathymetry, path: nothing.tif}", "nothing.tif"),
    ],
)
def test_check_refuses_what_a_run_refuses(
    small: Path, tmp_path: Path, change: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    told = []
    for command in (["check"], ["run", "--out", str(tmp_path / "out")]):
        assert outcome(*command, str(small), "--set", change) == 2
        told.append(" ".join(capsys.readouterr().err.split()).partition("wrong input: ")[2])  # a run says what it loads
        assert words in told[-1]
    assert told[0] == told[1]


def test_check_says_where_the_doors_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A port that somebody has is told; it is no fault of the scenario, which may be run elsewhere or later."""
    path = tmp_path / "doors.json"
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        bridges = {
            "web": {"type": "rosbridge", "port": port}, "any": {"type": "foxglove", "port": 0},
            "ros": {"type": "ros2", "domain_id": 37}, "ground": {"type": "mavlink", "port": 14551},
            "gps": {"type": "instrument", "protocol": "nmea", "sensors": ["gps"], "port": "udp:127.0.0.1:7001"},
        }  # fmt: skip
        auv = {
            "vehicle": "remus100",
            "start": {"position_m": [0, 0], "depth_m": 3},
            "sensors": {"gps": {"type": "gps"}},
        }
        scenario = {"world": {"type": "flat", "depth_m": 9.0}, "agents": {"auv0": auv}, "bridges": bridges}
        path.write_text(json.dumps(scenario), encoding="utf-8")
        with pytest.raises(SystemExit):
            main(["check", str(path), "--no-build"])
        told = [line.split(maxsplit=2) for line in capsys.readouterr().out.splitlines()]
    where = {words[0]: words[2].strip() for words in told if len(words) == 3}
    assert where["web"] == f"listens at tcp 127.0.0.1:{port} (taken at present)"
    assert where["any"] == "listens at a free port"
    assert where["ros"] == "ROS domain 37"
    assert where["ground"] == "goes to 127.0.0.1:14551"
    assert where["gps"] == "speaks at udp:127.0.0.1:7001"


def test_check_prints_twenty_agents_and_counts_the_rest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "fleet.yaml"
    agents = "".join(f"  a{i}: {{vehicle: otter, start: {{position_m: [{9 * i}, 4]}}}}\n" for i in range(23))
    path.write_text(f"world: {{type: flat, depth_m: 30}}\nagents:\n{agents}")
    assert outcome("check", str(path), "--no-build") == 0
    lines = capsys.readouterr().out.splitlines()
    assert "a19" in lines
    assert "a20" not in lines
    assert any(line.startswith("and 3 more agents") for line in lines)


def test_check_runs_without_a_device(small: Path) -> None:
    code = f"from pelagos.cli.main import main; main(['check', {str(small)!r}])"
    where = {"PELAGOS_LLVM_SEARCH": "/nonexistent", "PELAGOS_DEVICE": "cpu", "PATH": "/usr/bin:/bin"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=where, check=False)
    assert done.returncode == 0, done.stderr


def test_no_usable_llvm_is_one_clear_error(small: Path, tmp_path: Path) -> None:
    where = {"PELAGOS_LLVM_SEARCH": "/nonexistent", "PELAGOS_DEVICE": "cpu", "PATH": "/usr/bin:/bin"}
    command = [sys.executable, "-m", "pelagos", "run", str(small), "--out", str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, env=where, check=False)
    assert done.returncode == 1
    assert "Pelagos needs LLVM" in done.stderr
    assert "apt-get install libllvm19" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_resolved_scenario_is_a_scenario(small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("check", str(small), "--resolved") == 0
    again = tmp_path / "again.yaml"
    again.write_text(capsys.readouterr().out)
    assert outcome("check", str(again), "--resolved") == 0
    assert capsys.readouterr().out == again.read_text()


@pytest.mark.parametrize(
    ("what", "names"),
    [
        ("sensors", ["imu", "dvl", "multibeam", "imaging_sonar", "camera"]),
        ("vehicles", ["remus100"]),
        ("worlds", ["harbour", "bathymetry", "flat"]),
        ("devices", ["oculus_m750d", "kongsberg_em2040", "edgetech_4125", "waterlinked_a50"]),
    ],
)
def test_list(what: str, names: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("list", what) == 0
    lines = capsys.readouterr().out.splitlines()
    for name in names:
        row = next(line for line in lines if line.split()[:1] == [name])
        assert len(row.split()) > 2, f"{name} has no line about it"


def test_list_of_one_name_says_its_keys(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("list", "sensors", "camera") == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert next(r for r in rows if r[:1] == ["width_px"])[1] == "640"
    assert next(r for r in rows if r[:1] == ["focus_distance_m"])[1] == "None"
    assert outcome("list", "worlds", "bathymetry") == 0
    assert "required" in capsys.readouterr().out


def test_warnings_come_without_the_line_that_warns(
    small: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def warns(*_: object, **__: object) -> None:
        warnings.simplefilter("always")
        warnings.warn("agents.auv0.sensors.it: too fine", ValidityWarning, stacklevel=1)
        warnings.warn("somebody else's", UserWarning, stacklevel=1)

    monkeypatch.setattr("pelagos.cli.check.check_scenario", warns)
    assert outcome("check", str(small)) == 0
    said = capsys.readouterr().err
    assert said.startswith("warning: agents.auv0.sensors.it: too fine\n")
    assert "UserWarning: somebody else's" in said


def test_committed_schema_is_that_of_the_program(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("schema", "--check", str(ROOT / "schema" / "scenario.schema.json")) == 0, capsys.readouterr().err
    assert outcome("schema", "--check", str(ROOT / "pyproject.toml")) == 1
    assert "renew it with" in capsys.readouterr().err


def test_schema_names_every_component(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("schema") == 0
    definitions = json.loads(capsys.readouterr().out)["$defs"]
    assert {"MultibeamConfig", "HarbourConfig", "BathymetryConfig", "OceanConfig", "VehicleConfig"} <= set(definitions)
    assert definitions["MultibeamConfig"]["additionalProperties"] is False
    assert "[m]" in definitions["MultibeamConfig"]["properties"]["range_max_m"]["description"]


def test_cite_prints_sources(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("cite", str(small)) == 0
    text = capsys.readouterr().out
    assert "imu" in text
    assert "multibeam" not in text


BAD = [
    (["check", "no_such.yaml"], "there is no such file"),
    (["run", "SMALL", "--duration", "-3"], "--duration must be a positive number of seconds, not -3"),
    (["run", "SMALL", "--duration", "nan"], "--duration must be a positive number of seconds, not nan"),
    (["run", "SMALL", "--seed", "-1"], "--seed must be a whole number from 0 on, not -1"),
    (["run", "SMALL", "--out", "SMALL"], "this is a file; give a folder"),
    (["run", "SMALL", "--out", "FOLDER"], "the folder is not empty"),
    (["run", "SMALL", "--record", "/no/such/folder/a.mcap"], "give a file in a folder that exists"),
    (["check", "SMALL", "--set", "agents.auv0.sensors.imu.rate_hz=3"], "3 Hz does not divide the tick rate"),
    (["check", "SMALL", "--set", "agents.auv0.vehicle=remus10"], "unknown vehicle 'remus10' (did you mean 'remus100'?)"),  # noqa: E501
    (["check", "SMALL", "--set", "world.type=harbor"], "unknown world 'harbor' (did you mean 'harbour'?)"),
    (["check", "SMALL", "--set", "duration_s=2 min"], "expected a number of seconds [s], not '2 min'; write 120"),
    (["check", "SMALL", "--set", "agents.auv0.sensors.s={type: singlebeam, hears: [auv1.s]}"], "agents.auv0.sensors.s.hears: unknown sonar that can be heard 'auv1.s' (did you mean 'auv0.s'?)"),  # noqa: E501
    (["explain", "SMALL", "auv0.imuu"], "unknown sensor of auv0 'imuu' (did you mean 'imu'?)"),
    (["explain", "SMALL", "auv1.imu"], "unknown agent 'auv1' (did you mean 'auv0'?)"),
    (["explain", "SMALL", "auv0"], "name a sensor as AGENT.SENSOR: auv0.imu, auv0.depth"),
    (["list", "sensors", "camra"], "unknown sensor 'camra' (did you mean 'camera'?)"),
    (["list", "vehicles", "remus100"], "takes no name"),
    (["bench", "no_such_case"], "unknown benchmark 'no_such_case'"),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "message"), BAD)
def test_wrong_input_is_one_clear_error_with_exit_code_2(
    arguments: list[str], message: str, small: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(small.parent)
    named = {"SMALL": str(small), "FOLDER": str(small.parent)}
    assert outcome(*(named.get(word, word) for word in arguments)) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert "Traceback" not in captured.err
    assert [p.name for p in small.parent.iterdir()] == ["small.yaml"], "something was written"


def test_recovering_what_is_no_recording_is_wrong_input(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("recover", str(small)) == 2
    assert str(small) in capsys.readouterr().err
    assert outcome("recover", "no_such.mcap") == 2
    assert small.read_text() == SMALL


def test_debug_shows_the_traceback(small: Path) -> None:
    with pytest.raises(Exception, match="does not divide"):
        main(["--debug", "check", str(small), "--set", "agents.auv0.sensors.imu.rate_hz=3"])


@pytest.mark.parametrize("options", [(), ("--until", "distance_m=0.25", "--seed", "4", "--n", "3")])
def test_a_training_is_told_as_it_ended(
    options: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three updates, of which the first was the worst: `run.json` has the last, `curve.csv` all."""
    rows = [{"steps": 96.0 * k, "seconds": 2.5 * k, "reward": k - 2.5, "distance_m": 0.9 / k} for k in (1, 2, 3)]
    asked: dict[str, Any] = {}

    def train(env: Any, recipe: Any, *, seed: int, name: str, each: Any) -> Any:
        asked.update(env, seed=seed, until=recipe.until, steps=recipe.steps, name=name)
        for row in rows:
            each(row)
        policy = SimpleNamespace(save=lambda path: path.write_bytes(b"policy"))
        return SimpleNamespace(policy=policy, curve=rows, reached=bool(recipe.until))

    def make(task: str, copies: int, **options: Any) -> Any:
        return {"copies": copies, "options": options}

    monkeypatch.setattr("pelagos.envs.ppo.train", train)
    monkeypatch.setattr("pelagos.envs.registry.make", make)
    with pytest.raises(SystemExit) as ended:
        main(
            ["train", "Hover-v0", "--steps", "288", "--out", str(tmp_path / "hover"), "--set", "reach_m=0.4", *options]
        )
    assert not ended.value.code
    told = json.loads((tmp_path / "hover" / "run.json").read_text())
    assert told["end"] == rows[-1]
    assert told["reached"] is bool(options)
    assert (told["seed"], told["copies"], told["task"]) == (asked["seed"], asked["copies"], asked["name"])
    assert told["options"] == {"reach_m": 0.4}
    assert asked["options"] == {"seed": told["seed"], "arrays": "torch", "reach_m": 0.4}
    assert (asked["steps"], asked["name"]) == (288, "pelagos/Hover-v0")
    if options:
        assert (asked["until"], asked["seed"], asked["copies"]) == (("distance_m", 0.25), 4, 3)
        assert "distance_m <= 0.25: reached" in capsys.readouterr().out
    with (tmp_path / "hover" / "curve.csv").open(newline="") as file:
        assert [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)] == rows
