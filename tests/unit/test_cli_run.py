"""`pelagos run`, `explain` and `recover` on a small scenario, as a user would call them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

import pelagos as pl
from pelagos.cli.main import main

SMALL = """\
name: small
world: {type: flat, depth_m: 12}
duration_s: 2
agents:
  auv0:
    vehicle: remus100
    start: {depth_m: 5, speed_mps: 1}
    mission:
      - {type: hold, seconds: 1000}
    sensors:
      imu: {type: imu, rate_hz: 100}
      depth: {type: depth, rate_hz: 10}
      altimeter: {type: altimeter, rate_hz: 5}
"""


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    return path


def outcome(*arguments: str) -> int:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    return int(caught.value.code or 0)


def test_run_leaves_a_recording_a_report_numbers_and_the_scenario(
    small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome("run", str(small), "--seed", "5") == 0
    folder = small.parent / "results" / "small-1"
    assert {p.name for p in folder.iterdir()} == {"mission.mcap", "report.html", "stats.json", "scenario.yaml"}
    printed = capsys.readouterr().out
    assert "2.0 s simulated" in printed
    assert "x real time" in printed
    assert os.path.join("results", "small-1", "report.html") in printed
    assert pl.load_scenario(folder / "scenario.yaml").seed == 5
    assert pl.Recording(folder / "mission.mcap").metadata["seed"] == "5"
    assert json.loads((folder / "stats.json").read_text())
    assert outcome("run", str(small), "--duration", "0.5", "--no-report") == 0
    assert {p.name for p in (small.parent / "results" / "small-2").iterdir()} == {"mission.mcap", "scenario.yaml"}


def test_memory_that_is_given_is_the_limit(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("run", str(small), "--no-report", "--memory-limit", "1MB") == 2
    assert "may take 1 MB" in capsys.readouterr().err
    assert not (small.parent / "results").exists()


def test_resolved_scenario_repeats_the_run(small: Path) -> None:
    assert outcome("run", str(small), "--no-report", "--seed", "9", "--set", "world.depth_m=14", "--out", "a") == 0
    assert outcome("run", "a/scenario.yaml", "--no-report", "--out", "b") == 0
    first, second = pl.Recording("a/mission.mcap"), pl.Recording("b/mission.mcap")
    assert [(m.topic, m.t_ns, bytes(m.raw)) for m in first.messages()] == [
        (m.topic, m.t_ns, bytes(m.raw)) for m in second.messages()
    ]


def test_recording_may_go_elsewhere(small: Path) -> None:
    (small.parent / "tapes").mkdir()
    arguments = ["--duration", "0.2", "--no-report", "--record", "tapes/a.mcap", "--out", "out", "--n", "2"]
    assert outcome("run", str(small), *arguments) == 0
    assert "/env1/auv0/imu/data_raw" in pl.Recording("tapes/a.mcap").channels


WRONG_WHEN_BUILT = [
    ("agents.auv0.start.depth_m=30", "lies inside the seabed, which is at z = -12.00 m there"),
    ("agents.auv0.control=depht", "control mode 'depht' cannot be used here"),
    ("agents.auv0={vehicle: remus100, command: [1, 2]}", "takes 3 numbers, [depth, heading, speed], not 2"),
    ("world.material=sandd", "(did you mean 'sand'?)"),
]


@pytest.mark.parametrize(("change", "message"), WRONG_WHEN_BUILT)
def test_what_only_shows_when_built_is_wrong_input_too(
    change: str, message: str, small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome("run", str(small), "--set", change) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert "Traceback" not in captured.err
    assert [p.name for p in small.parent.iterdir()] == ["small.yaml"], "something was written"


def test_explain_shows_five_stops_and_one_reading(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("explain", str(small), "auv0.altimeter", "--at", "0.5") == 0
    text = capsys.readouterr().out
    for stop in ("1  the scenario", "2  its configuration", "3  one reading", "4  rays into the world", "5  physics"):
        assert stop in text
    assert "small.yaml:13" in text
    assert "altimeter.py:" in text
    assert "Altimeter.sense" in text
    assert "caster.py:" in text
    assert "acoustics" in text
    assert "rate_hz" in text
    assert "One reading at 0.5 s" in text


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_ends_the_run_cleanly_and_says_where_it_is_recorded(small: Path) -> None:
    command = [sys.executable, "-m", "pelagos", "run", str(small), "--duration", "100000", "--no-report", "--realtime"]
    # jobs in the background of a shell ignore Ctrl-C, and so would what they start
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )
    recording = small.parent / "results" / "small-1" / "mission.mcap"
    deadline = time.monotonic() + 120
    while not (recording.exists() and recording.stat().st_size > 20_000):
        assert time.monotonic() < deadline
        assert process.poll() is None, process.stderr.read() if process.stderr else ""
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    printed, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "stopped; everything until here is recorded" in printed
    assert "mission.mcap" in printed
    assert "Traceback" not in errors
    assert pl.Recording(recording).complete


def test_recover_says_what_is_in_a_recording(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("run", str(small), "--no-report", "--out", "out") == 0
    whole = Path("out/mission.mcap").read_bytes()
    Path("cut.mcap").write_bytes(whole[: len(whole) * 3 // 4])
    capsys.readouterr()
    assert outcome("recover", "cut.mcap") == 0
    assert "has everything that could be read" in capsys.readouterr().out
    assert pl.Recording("cut.recovered.mcap").complete
    assert Path("cut.mcap").read_bytes() == whole[: len(whole) * 3 // 4]
    hurt = bytearray(whole)
    hurt[len(whole) // 2] ^= 4
    Path("hurt.mcap").write_bytes(hurt)
    assert outcome("recover", "hurt.mcap", "--out", "mended.mcap") == 1
    assert capsys.readouterr().err.startswith("lost: bytes ")
    assert pl.Recording("mended.mcap").complete
    assert Path("hurt.mcap").read_bytes() == bytes(hurt)
    assert outcome("recover", "out/mission.mcap") == 0
    assert "was whole already" in capsys.readouterr().out
    assert outcome("recover", "out/mission.mcap", "--out", "copy.mcap") == 0
    assert "copy.mcap was not written" in capsys.readouterr().out.replace("\n", " ")
    assert not Path("copy.mcap").exists()
    touched = bytearray(whole)
    touched[whole.index(b"seed") + 1] ^= 1  # of the metadata, beside every chunk
    Path("touched.mcap").write_bytes(touched)
    assert outcome("recover", "touched.mcap", "--out", "again.mcap") == 0
    assert capsys.readouterr().err.startswith("no message lost: bytes ")
    kept = Path("mended.mcap").read_bytes()
    wrong = {
        "mended.mcap": "mended.mcap exists already", "out": "out exists already",
        "no/folder.mcap": "no/folder.mcap cannot be written: there is no folder no",
    }  # fmt: skip
    for name, message in wrong.items():
        assert outcome("recover", "hurt.mcap", "--out", name) == 2
        assert capsys.readouterr().err.startswith(f"wrong input: {message}")
    assert Path("mended.mcap").read_bytes() == kept
    assert not list(Path().glob("**/.*"))


BAD_SURVEYS = [
    ({"path": "missing.nc"}, "missing.nc does not exist"),
    ({"path": "empty.nc"}, "is empty"),
    ({"path": "nan.xyz", "crs": "EPSG:4326"}, "holds no values"),
    ({"path": "matplotlib:topobathy.npz", "centre_deg": [-122.95, 48.835]}, "are latitude and longitude exchanged?"),
    ({"path": "matplotlib:topobathy.npz", "centre_deg": [10, 10]}, "lies outside the data, which cover latitude 48.0"),
    ({"path": "matplotlib:topobathy.npz", "centre_deg": [48.835]}, "centre_deg: expected 2 values [deg], not 1"),
]


@pytest.mark.parametrize(("survey", "message"), BAD_SURVEYS)
def test_surveys_that_cannot_be_used(
    survey: dict[str, object], message: str, small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("empty.nc").touch()
    Path("nan.xyz").write_text("1 2 nan\n2 3 nan\n")
    if "centre_deg" in survey:
        survey = {**survey, "size_m": [2000, 2000]}
    before = sorted(p.name for p in small.parent.iterdir())
    assert outcome("run", str(small), "--set", f"world={json.dumps({'type': 'bathymetry', **survey})}") == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert "Traceback" not in captured.err
    assert sorted(p.name for p in small.parent.iterdir()) == before, "something was written"


def test_explain_names_the_source_of_a_device(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change = "agents.auv0.sensors.ping={type: mechanical_scanning_sonar, rate_hz: 1, device: ping360, rays: 32}"
    assert outcome("explain", str(small), "auv0.ping", "--set", change) == 0
    assert "device ping360, Blue Robotics Ping360: Blue Robotics, Ping360 Scanning" in capsys.readouterr().out
