"""`pelagos channel` with arrivals that are given: what it asks for, and how it prints them."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.cli import channel, console
from pelagos.errors import InputError


class Arrivals:
    """So many, the latest first, in numbers that differ."""

    def __init__(self, count: int) -> None:
        k = np.arange(count, 0, -1.0)
        self.delay, self.loss_db, self.phase = 0.01 * k, 40.0 + k, np.radians(-7.0 * k)
        self.departure_angle, self.arrival_angle = np.radians(-2.0 * k), np.radians(1.5 * k)
        self.surface, self.bottom = (k + 1).astype(int), (k + 2).astype(int)
        self.doppler, self.blocked = 1 - 1e-4 * k, k == 2

    def __len__(self) -> int:
        return len(self.delay)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the simulation is asked for; `count` arrivals are there."""
    found: dict[str, Any] = {"count": 3, "ran": []}
    scenario = SimpleNamespace(name="bay")
    sim = SimpleNamespace(run=lambda seconds: found["ran"].append(seconds))
    monkeypatch.setattr(channel, "load", lambda path, changes, trust: found.update(trust=trust) or scenario)
    monkeypatch.setattr("pelagos.sim.simulation.Simulation.load", lambda loaded: sim)
    monkeypatch.setattr(console.out, "_width", 160)

    def made(of: Any, a: Any, b: Any, *, frequency_hz: float) -> Any:
        found.update(ends=(a, b), frequency_hz=frequency_hz)
        return SimpleNamespace(
            arrivals=lambda: Arrivals(found["count"]), source=np.array([1.0, 2, -3]), receiver=np.array([4.0, -2, -15]),
            depths=(3.0, 15.0), frequency_hz=frequency_hz, noise_level_db=lambda: 51.25,
            transmission_loss=lambda: 38.75,
        )  # fmt: skip

    monkeypatch.setattr("pelagos.sim.channel.channel", made)
    return found


def show(*, at_s: float = 0.0, as_json: bool = False, out: Path | None = None) -> None:
    channel.show_channel(
        Path("it.yaml"), [], ("auv0.modem", "4,-2,-15"), frequency_hz=18_000.0, at_s=at_s, out=out, as_json=as_json
    )  # fmt: skip


def test_arrivals_are_listed_by_their_delay(asked: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    """3 m north, 4 m east and 12 m down are 13 m; the later of more than twenty are counted."""
    show()
    told = capsys.readouterr().out
    assert told.splitlines()[0] == (
        "auv0.modem to 4,-2,-15: 13.0 m, depths 3.0 and 15.0 m, 18 kHz, noise 51.2 dB re 1 uPa^2/Hz"
    )
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in told.splitlines() if line.startswith("│")]
    assert rows == [
        ["10.0000", "41.0", "-7", "-2.00", "1.50", "2", "3", "0.999900"],
        ["20.0000", "blocked", "-14", "-4.00", "3.00", "3", "4", "0.999800"],
        ["30.0000", "43.0", "-21", "-6.00", "4.50", "4", "5", "0.999700"],
    ]
    assert told.rstrip().endswith("all together: 38.8 dB re 1 m (powers added)")
    assert (asked["ran"], asked["ends"], asked["frequency_hz"]) == ([], ("auv0.modem", (4.0, -2.0, -15.0)), 18_000.0)
    asked["count"] = 23
    show()
    told = capsys.readouterr().out
    assert "... and 3 later ones" in told
    assert [f"{10 * k}.0000" in told for k in (1, 20, 21)] == [True, True, False]
    asked["count"] = 20
    show()
    assert "later ones" not in capsys.readouterr().out


def test_a_channel_is_that_of_the_time_that_is_asked_for(
    asked: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    show(at_s=2.5, as_json=True)
    assert asked["ran"] == [2.5]
    told = json.loads(capsys.readouterr().out)
    assert (told["frequency_hz"], told["transmission_loss_db"], told["noise_db"]) == (18_000.0, 38.75, 51.25)
    assert told["arrivals"][1] == {
        "delay_s": 0.02, "loss_db": 42.0, "phase_rad": pytest.approx(np.radians(-14.0)),
        "departure_deg": pytest.approx(-4.0), "arrival_deg": pytest.approx(3.0), "surface": 3, "bottom": 4,
        "doppler": pytest.approx(0.9998), "blocked": True,
    }  # fmt: skip
    with pytest.raises(InputError, match=r"--at -1\.0: a time from 0 on"):
        show(at_s=-1.0)
    with pytest.raises(InputError, match=r"give a file that ends in \.png"):
        show(out=Path("it.jpg"))


def test_a_shadow_zone_is_told_in_words_and_has_no_loss(
    asked: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    asked["count"] = 0
    show()
    told = capsys.readouterr().out
    assert "a shadow zone, or a bottom in between" in told
    assert "all together" not in told
    show(as_json=True)
    found = json.loads(capsys.readouterr().out)
    assert (found["transmission_loss_db"], found["arrivals"]) == (None, [])
