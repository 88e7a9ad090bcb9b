"""The line that tells how far a run is, where no terminal shows a bar."""

from __future__ import annotations

import pytest

from pelagos.cli import progress


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
