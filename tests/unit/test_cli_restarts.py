"""What begins a run with doors anew, and where it goes on; folders of results."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.cli import run as command
from pelagos.cli.doors import MOST_RESTARTS, _runs
from pelagos.cli.run import Options, _seen_from, _watched, results_folder
from pelagos.errors import InputError, RecordingError
from pelagos.sim.not_finite import NotFinite


class Exchange:
    """Runs that end as they are told: by an order and a lost state, by one that nobody caused, by a reset, or well."""

    def __init__(self, *ends: str) -> None:
        self.ends, self.files, self.resets = iter(ends), list[str](), 0
        self.inbox = SimpleNamespace(obeyed=Counter())
        self.reset_asked = False
        self.sim = SimpleNamespace(reset=self._reset)

    def _reset(self) -> None:
        self.resets += 1

    def run(self, seconds: float, *, record: Path, progress: Any) -> Any:
        self.files.append(record.name)
        assert (seconds, progress) == (6.5, "progress")
        end = next(self.ends)
        self.inbox.obeyed["command"] += end == "torn"
        if end in ("torn", "alone"):
            error = NotFinite.__new__(NotFinite)
            Exception.__init__(error, f"{end} apart")
            raise error
        self.reset_asked = end == "reset"
        return SimpleNamespace(simulated_s=1.25, end=end)


def runs(exchange: Exchange) -> Any:
    return _runs(exchange, Options(duration_s=6.5), Path("folder") / "it.mcap", "progress")  # type: ignore[arg-type]


def test_each_new_beginning_has_a_recording_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    exchange = Exchange("reset", "torn", "reset", "time")
    assert runs(exchange).end == "time"
    assert exchange.files == ["it.mcap", "it-2.mcap", "it-3.mcap", "it-4.mcap"]
    assert exchange.resets == 3
    told = " ".join(capsys.readouterr().out.split())
    assert "reset from outside at 1.25 s; goes on in it-2.mcap" in told
    assert "torn apart. It was commanded from outside: the run begins anew; goes on in it-3.mcap" in told


@pytest.mark.parametrize("ends", [("alone",), ("torn", "alone"), ("reset", "alone")])
def test_a_state_that_is_lost_without_an_order_in_that_run_ends_it(ends: tuple[str, ...]) -> None:
    exchange = Exchange(*ends)
    with pytest.raises(NotFinite, match="alone apart"):
        runs(exchange)
    assert exchange.resets == len(ends) - 1


def test_a_run_begins_anew_ten_times_and_no_more() -> None:
    assert runs(Exchange(*["torn"] * MOST_RESTARTS, "time")).end == "time"
    assert runs(Exchange(*["reset"] * 3 * MOST_RESTARTS, "torn", "time")).end == "time"
    exchange = Exchange(*["torn"] * (MOST_RESTARTS + 1), "time")
    with pytest.raises(NotFinite):
        runs(exchange)
    assert exchange.resets == MOST_RESTARTS == 10


def test_results_go_to_the_next_free_folder_or_to_an_empty_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scenario = Path("elsewhere") / "survey.yaml"
    assert results_folder(None, scenario) == Path("results") / "survey-1"
    for name in ("survey-1", "survey-2", "survey-4", "other-3"):
        (Path("results") / name).mkdir(parents=True)
    assert results_folder(None, scenario) == Path("results") / "survey-3"
    empty, full, file = Path("empty"), Path("full"), Path("file")
    empty.mkdir()
    full.mkdir()
    file.touch()
    (full / "it").touch()
    assert [results_folder(p, scenario) for p in (empty, Path("none") / "yet")] == [empty, Path("none") / "yet"]
    for wrong, text in ((full, "the folder is not empty"), (file, "this is a file")):
        with pytest.raises(InputError, match=text):
            results_folder(wrong, scenario)


def test_a_recording_is_found_from_a_folder_that_was_moved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    inside, outside = Path("out") / "a" / "it.mcap", Path("tapes") / "it.mcap"
    assert _seen_from(Path("out"), inside) == str(Path("a") / "it.mcap")
    assert _seen_from(Path("out"), outside) == str(tmp_path / "tapes" / "it.mcap")


def test_a_run_is_ended_where_it_is_asked_to_or_its_folder_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It looks for the folder twice a second by the clock, and shows what is simulated each time."""
    now, told, stops = [70.0], list[tuple[float, float]](), list[float]()
    monkeypatch.setattr(command, "time", SimpleNamespace(monotonic=lambda: now[0]))
    sim: Any = SimpleNamespace(stop=lambda: stops.append(now[0]))
    stopping: Any = SimpleNamespace(asked=False)
    folder = tmp_path / "out"
    folder.mkdir()
    progress = _watched(lambda *t: told.append(t), folder, sim, stopping)  # type: ignore[arg-type]
    progress(1.5, 9.0)
    assert (told, stops) == ([(1.5, 9.0)], [])
    stopping.asked = True
    progress(2.5, 9.0)
    assert stops == [70.0]
    folder.rmdir()
    for now[0] in (70.3, 70.49):
        progress(3.0, 9.0)
    folder.mkdir()
    now[0] = 70.6
    progress(3.5, 9.0)
    folder.rmdir()
    now[0] = 71.0
    progress(4.0, 9.0)
    now[0] = 71.2
    with pytest.raises(RecordingError, match="was removed during the run"):
        progress(4.5, 9.0)
    assert told[-1] == (4.5, 9.0)
