"""Ends of runs: signals, the wall-clock limit, a missing folder, and runs that go on from a checkpoint."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from test_cli_run import SMALL, outcome

import pelagos as pl

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
LONG = ("--duration", "100000", "--realtime")


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    return path


def start(*arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "pelagos", "run", *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip


def wait_for(path: Path, process: subprocess.Popen[str], size: int = 20_000) -> None:
    deadline = time.monotonic() + 120
    while not (path.exists() and path.stat().st_size > size):
        assert time.monotonic() < deadline
        assert process.poll() is None, process.stderr.read() if process.stderr else ""
        time.sleep(0.05)


@pytest.mark.parametrize(
    ("signals", "code"),
    [
        pytest.param([signal.SIGTERM], 143, id="terminate", marks=pytest.mark.slow),
        pytest.param([signal.SIGINT] * 3, 130, id="Ctrl-C thrice"),
        pytest.param([signal.SIGHUP], 129, id="hang up", marks=pytest.mark.slow),
    ],
)
def test_signals_leave_index_report_and_statistics(small: Path, signals: list[signal.Signals], code: int) -> None:
    process = start(str(small), "--out", "out", *LONG)
    wait_for(Path("out/mission.mcap"), process)
    for number in signals:
        process.send_signal(number)
        time.sleep(0.1)
    printed, errors = process.communicate(timeout=120)
    assert process.returncode == code, errors
    assert "Traceback" not in errors
    assert "stopped; everything until here is recorded" in printed
    assert "mission.mcap" in printed
    assert {p.name for p in Path("out").iterdir()} == {"mission.mcap", "report.html", "stats.json", "scenario.yaml"}
    assert pl.Recording("out/mission.mcap").complete
    assert json.loads(Path("out/stats.json").read_text())["ended"] == "interrupt"


def interrupt_at(small: Path, delay_s: float, number: signal.Signals, *, cache: Path | None = None) -> None:
    """A signal at any moment: its exit code, no traceback, and either nothing or a recording that can be read."""
    shutil.rmtree("out", ignore_errors=True)
    environment = os.environ if cache is None else {**os.environ, "HOME": str(cache)}
    code = "from pelagos.cli.main import main; print('ready', flush=True); main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "run", str(small), "--out", "out", "--duration", "20", "--no-report"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(delay_s)
    process.send_signal(number)
    _, errors = process.communicate(timeout=120)
    assert "Traceback" not in errors
    assert process.returncode in (0, 128 + number, -number), errors  # the last: before or after everything of ours
    if number != signal.SIGKILL and Path("out/mission.mcap").exists():
        assert pl.Recording("out/mission.mcap").complete
    elif Path("out/mission.mcap").exists():
        assert pl.Recording("out/mission.mcap").damage == []


@pytest.mark.parametrize("delay_s", [0.15, 1.2])
def test_ctrl_c_while_kernels_are_made(small: Path, delay_s: float, tmp_path: Path) -> None:
    interrupt_at(small, delay_s, signal.SIGINT, cache=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_signals_at_fifty_random_moments(small: Path, number: signal.Signals, tmp_path: Path) -> None:
    draw = random.Random(int(number))
    for k in range(50):
        interrupt_at(small, draw.uniform(0.0, 4.0), number, cache=tmp_path / f"cold{k}" if k % 2 else None)


def test_the_wall_clock_ends_a_run_in_order(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("run", str(small), "--out", "out", "--max-wall", "2", "--no-report", *LONG) == 0
    assert "the wall-clock time is over; everything until here is recorded" in capsys.readouterr().out
    assert pl.Recording("out/mission.mcap").complete
    assert outcome("run", str(small), "--max-wall", "-1") == 2


def test_a_folder_of_results_that_vanishes_ends_the_run_at_once(small: Path) -> None:
    Path("tapes").mkdir()
    process = start(str(small), "--out", "out", "--record", "tapes/a.mcap", "--no-report", *LONG)
    wait_for(Path("tapes/a.mcap"), process)
    shutil.rmtree("out")
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 1
    assert errors.strip().endswith("the folder of results was removed during the run")
    assert pl.Recording("tapes/a.mcap").complete


def test_a_run_goes_on_from_a_checkpoint_in_one_recording(small: Path) -> None:
    text = SMALL.replace("hold, seconds: 1000", "hold, seconds: 3.3").replace("duration_s: 2", "duration_s: 6")
    small.write_text(text)
    assert outcome("run", str(small), "--out", "whole", "--no-report") == 0
    assert outcome("run", str(small), "--out", "parts", "--no-report", "--checkpoint-every", "1.5") == 0
    whole, parts = messages("whole"), messages("parts")
    assert parts == whole
    newest, previous = Path("parts/checkpoint.npz"), Path("parts/checkpoint.previous.npz")
    assert previous.exists()
    newest.write_bytes(b"half of it")  # as a power cut may leave it: the one before is taken
    recording = Path("parts/mission.mcap")
    recording.write_bytes(recording.read_bytes()[:-2000])
    cut = recording.read_bytes()
    shutil.copytree("parts", "copied")
    assert outcome("run", "--resume", "copied", "--no-report") == 0
    assert messages("copied") == whole
    assert recording.read_bytes() == cut
    assert outcome("run", "--resume", "parts", "--no-report") == 0
    assert messages("parts") == whole
    assert pl.Recording("parts/mission.mcap").attachments == pl.Recording("whole/mission.mcap").attachments
    assert not list(Path("parts").glob(".*"))


def messages(folder: str) -> set[tuple[str, int, bytes]]:
    recording = pl.Recording(f"{folder}/mission.mcap")
    assert recording.complete
    found = [(m.topic, m.t_ns, m.raw) for m in recording.messages()]
    assert len(set(found)) == len(found)
    return set(found)


@pytest.mark.slow
def test_a_killed_run_goes_on(small: Path) -> None:
    small.write_text(SMALL.replace("duration_s: 2", "duration_s: 12"))
    assert outcome("run", str(small), "--out", "whole", "--no-report") == 0
    process = start(str(small), "--out", "parts", "--no-report", "--realtime", "--checkpoint-every", "2")
    wait_for(Path("parts/checkpoint.previous.npz"), process, 100)
    process.kill()
    process.communicate()
    assert outcome("run", "--resume", "parts", "--no-report") == 0
    assert messages("parts") == messages("whole")


WRONG = [
    (["--resume", "nowhere"], "give the folder of a run with --checkpoint-every"),
    ([], "give a scenario file, or --resume"),
    (["small.yaml", "--resume", "out", "--seed", "3"], "leave out a scenario, --seed"),
    (["small.yaml", "--checkpoint-every", "0"], "--checkpoint-every must be a positive number"),
]


@pytest.mark.parametrize(("arguments", "message"), WRONG)
def test_wrong_options(small: Path, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("run", *arguments) == 2
    assert message in capsys.readouterr().err
