"""Whole missions: the harbour survey of `make demo`, and its navigation sensors alone."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path
from typing import Any, Final

import yaml

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import example
from pelagos.bench.probe import probe

SCENARIO: Final = "harbour_survey.yaml"
RAY_SENSORS: Final = ("multibeam", "imaging_sonar", "camera")
REAL_TIME: Final = Reference("real time", 1.0)


def harbour() -> dict[str, Any]:
    """The demo's scenario, as data."""
    data: dict[str, Any] = yaml.safe_load(example(SCENARIO).read_text(encoding="utf-8"))
    return data


def _navigation() -> dict[str, Any]:
    """The same mission without the sensors that make images of the world."""
    scenario = harbour()
    for agent in scenario["agents"].values():
        kept = {k: v for k, v in agent.get("sensors", {}).items() if v.get("type", k) not in RAY_SENSORS}
        agent["sensors"] = kept
    return scenario


@cache
def _harbour_run() -> dict[str, Any]:
    return probe(harbour(), warm_up_s=3.0, seconds=20.0)


def nav_rtf() -> Measured:
    """Real-time factor of the navigation-only mission, recording included."""
    found = probe(_navigation(), warm_up_s=5.0, seconds=120.0)
    return Measured(found["real_time_factor"], detail=f"{sum(found['counts'].values())} readings in 120 s, recorded")


def harbour_rtf() -> Measured:
    """Real-time factor of the whole mission, recording included."""
    found = _harbour_run()
    return Measured(found["real_time_factor"], detail=f"{sum(found['counts'].values())} readings in 20 s, recorded")


def harbour_cold_s() -> Measured:
    """From the start of Python to the first tick, with no compiled kernels on disk."""
    with tempfile.TemporaryDirectory() as home:
        found = probe(harbour(), seconds=0.0, home=Path(home))
        kernels = sum(1 for p in Path(home).rglob("*") if p.is_file())
    return Measured(found["first_tick_s"], detail=f"every sensor read at tick 0; {kernels} files in the new cache")


def harbour_warm_s() -> Measured:
    """From the start of Python to the first tick, with every kernel in the cache on disk."""
    with tempfile.TemporaryDirectory() as home:
        cold = probe(harbour(), seconds=0.0, home=Path(home))["first_tick_s"]
        warm = probe(harbour(), seconds=0.0, home=Path(home))["first_tick_s"]
    return Measured(warm, Reference("the same start with an empty cache", cold), "every sensor read at tick 0")


def harbour_memory_mb() -> Measured:
    """Peak memory of the whole mission's process."""
    found = _harbour_run()
    return Measured(found["memory_mb"], detail="peak resident size of the process, all sensors, recorded")


CASES: Final = (
    Case("nav_rtf", "REMUS-100 survey with navigation sensors, DVL and altimeter; simulated over wall-clock time",
         nav_rtf, "x real time", 150.0, "higher", REAL_TIME),
    Case("harbour_rtf", "the harbour survey of `make demo` with all sensors; simulated over wall-clock time",
         harbour_rtf, "x real time", 1.5, "higher", REAL_TIME),
    Case("harbour_cold_s", "start of Python to the end of the first tick of the harbour survey, empty kernel cache",
         harbour_cold_s, "s", 15.0, "lower", Reference("no published figure")),
    Case("harbour_warm_s", "the same with every kernel in the cache",
         harbour_warm_s, "s", 5.0, "lower", Reference("the same start with an empty cache")),
    Case("harbour_memory_mb", "peak memory of the harbour survey",
         harbour_memory_mb, "MB", 1500.0, "lower", Reference("no published figure")),
)  # fmt: skip
