"""Examples of modems and channels do what they say."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


def main_of(name: str) -> object:
    return runpy.run_path(str(EXAMPLES / name))["main"]


def test_the_shadow_takes_the_direct_ray() -> None:
    found = main_of("shadow_zone.py")()  # type: ignore[operator]
    assert {direct > 0 for _, _, direct in found} == {True, False}


def test_ranges_by_the_waters_own_speed_are_right() -> None:
    errors = main_of("one_way_ranges.py")(12.0)  # type: ignore[operator]
    assert all(abs(error) < 1.0 for error in errors.values())


@pytest.mark.slow
def test_homing_by_usbl() -> None:
    assert main_of("usbl_homing.py")() < 4.0  # type: ignore[operator]


@pytest.mark.slow
def test_a_swarm_of_twenty() -> None:
    heard = main_of("modem_swarm_20.py")(20, 8.0)  # type: ignore[operator]
    assert sum(heard.values()) > 60
