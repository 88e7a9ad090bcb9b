"""Runs that would not fit are refused before anything is allocated, with what to change."""

from __future__ import annotations

import resource
import time
from pathlib import Path
from typing import Any

import pytest

import pelagos as pl
from pelagos.cli.main import main
from pelagos.config.loader import load_scenario
from pelagos.errors import InputError
from pelagos.sim.cost import check_memory, cost_of, parsed_size, size

BARE: dict[str, Any] = {"world": {"type": "flat", "depth_m": 30}, "agents": {"auv0": {"vehicle": "remus100"}}}


def with_sensor(**keys: Any) -> dict[str, Any]:
    return {**BARE, "agents": {"auv0": {"vehicle": "remus100", "sensors": {"one": keys}}}}


HUGE = [
    (BARE, 10**8, "agents.auv0: lower n"),
    (with_sensor(type="multibeam", rate_hz=1, beams=4096, samples=1024, rays_along=31), 100, "rays_along"),
    (with_sensor(type="imaging_sonar", rate_hz=1, beams=4096, rays_per_beam=4096, bins=65536), 64, "bins"),
    (with_sensor(type="adcp", rate_hz=1e-4, pulse_s=5e3, bandwidth_hz=1e6, frequency_hz=1e7), 1, "pulse_s"),
    (with_sensor(type="camera", rate_hz=1, width_px=8192, height_px=8192), 64, "width_px"),
    (with_sensor(type="hydrophone", rate_hz=1, sample_rate_hz=1e12), 1, "sample_rate_hz"),
    ({**BARE, "world": {"type": "generated", "size_m": [1e6, 1e6], "grid_m": 0.1}}, 1, "size_m"),
]


@pytest.mark.parametrize(("scenario", "n", "advice"), HUGE)
def test_what_would_not_fit_is_refused_at_once(scenario: dict[str, Any], n: int, advice: str) -> None:
    before, began = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.monotonic()
    with pytest.raises(InputError, match="memory") as caught:
        pl.Simulation.load(scenario, n=n, memory_limit=64e9 if n > 1 else 60e9)
    assert advice in str(caught.value)
    assert time.monotonic() - began < 10
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000  # [kB], the modules of the sensors


def test_what_fits_is_not_refused() -> None:
    for path in sorted((Path(__file__).parents[2] / "examples").glob("harbour*.yaml")):
        check_memory(load_scenario(path), 1, 4e9, block_s=1.0)
    check_memory(load_scenario(BARE), 16_384, 4e9)


def test_memory_grows_with_copies_and_rays() -> None:
    camera = load_scenario(with_sensor(type="camera", rate_hz=1, width_px=640, height_px=480))
    finer = load_scenario(with_sensor(type="camera", rate_hz=1, width_px=1280, height_px=960))
    sensor = {c.path: c for c in cost_of(camera, 3).parts}["agents.auv0.sensors.one"]
    other = {c.path: c for c in cost_of(finer, 3).parts}["agents.auv0.sensors.one"]
    assert sensor.rays_per_s == 3 * 640 * 480
    assert other.rays_per_s == 4 * sensor.rays_per_s
    assert 3.9 < other.memory / sensor.memory < 4.1


@pytest.mark.parametrize(("text", "count"), [("8G", 8e9), ("500MB", 5e8), ("2e9", 2e9), (" 1.5t", 1.5e12)])
def test_sizes_are_read(text: str, count: float) -> None:
    assert parsed_size(text) == count


@pytest.mark.parametrize(
    ("count", "text"),
    [(9.994e8, "999 MB"), (9.996e8, "1 GB"), (9.996e11, "1 TB"), (2.345e12, "2.35 TB"), (1.2e4, "0.012 MB")],
)
def test_sizes_are_told_in_three_digits(count: float, text: str) -> None:
    assert size(count) == text


@pytest.mark.parametrize("text", ["", "many", "-3G", "0", "nan"])
def test_what_is_no_size_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="memory-limit"):
        parsed_size(text)


def test_commands_tell_and_refuse(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "s.yaml"
    path.write_text("world: {type: flat, depth_m: 30}\nagents: {auv0: {vehicle: remus100}}\n")
    with pytest.raises(SystemExit) as ended:
        main(["check", "--cost", "--n", "1000", str(path)])
    assert not ended.value.code
    assert "agents.auv0" in capsys.readouterr().out
    with pytest.raises(SystemExit) as ended:
        main(["run", str(path), "--n", "100000000", "--out", str(tmp_path / "out")])
    assert ended.value.code == 2
    assert "lower n" in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "out").exists()
