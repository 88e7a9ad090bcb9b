"""The line that tells how far a run is, where no terminal shows a bar."""

from __future__ import annotations

import pytest

from pelagos.cli import dataset, live_bar, progress


def test_a_run_that_begins_anew_is_told_at_its_own_pace(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = 100.0
    monkeypatch.setattr(progress.time, "perf_counter", lambda: now)
    shown = progress.RunProgress()
    for now, t_s in ((130.0, 60.0), (140.0, 80.0), (142.0, 1.0), (170.0, 57.0)):  # noqa: B007
        shown(t_s, 90.0)
    assert [line.rpartition(", ")[2] for line in capsys.readouterr().err.splitlines()] == [
        "2.0 x real time", "2.0 x real time", "2.0 x real time",
    ]  # fmt: skip


def test_a_line_tells_the_rate_of_what_was_done_since_it_began_and_the_time_that_is_left(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """3 of 23 stood already: 4 in 10 s leave 16, which take 40 s; a line every ten seconds at most."""
    now = 100.0
    monkeypatch.setattr(live_bar.time, "perf_counter", lambda: now)
    with dataset.Bar("samples") as bar:
        for now, done in ((101.0, 3), (110.0, 7), (115.0, 8), (119.9, 9), (120.0, 9), (125.0, 11), (131.0, 15)):  # noqa: B007
            bar(done, 23)
    assert [" ".join(line.split()) for line in capsys.readouterr().err.splitlines()] == [
        "7 of 23 samples, 0.40 a second, 40 s left", "9 of 23 samples, 0.30 a second, 47 s left",
        "15 of 23 samples, 0.39 a second, 21 s left",
    ]  # fmt: skip
