"""What is done with a scenario that was drawn: checked, written and read again; built and run for five ticks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from zlib import crc32

import numpy as np
import yaml

from pelagos.cli.check import show_check
from pelagos.config.loader import load_scenario, to_yaml
from pelagos.sim.simulation import Simulation

Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def check(data: Any) -> None:
    """The checks of `pelagos check --no-build`; a quarter of what passes is written out, and reads as the same."""
    scenario = load_scenario(data)
    show_check(scenario, "fuzz.yaml", build=False)
    if not crc32(repr(data).encode()) % 4:  # half of the time of a check
        assert load_scenario(yaml.load(to_yaml(scenario), Loader=Loader)) == scenario


def short_run(data: Any) -> None:
    """What passes the check is built and runs five ticks within two gigabytes; readings have their own guard."""
    sim = Simulation.load(load_scenario(data), memory_limit=2e9)
    for _ in range(5):
        sim.step()
    assert np.isfinite(sim.state.motion).all()


DO: dict[str, Callable[[Any], None]] = {"check": check, "run": short_run}
