"""Every number of a scenario has a range, which the schema states and checking applies."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from pelagos.cli.schema import schema_data
from pelagos.config.limits import FREE, range_of
from pelagos.config.loader import load_scenario
from pelagos.errors import ScenarioError

SCHEMA = schema_data()
SCENARIO = {
    "world": {"type": "flat", "depth_m": 30},
    "agents": {"auv0": {"vehicle": "remus100", "sensors": {"imu": {"type": "imu", "rate_hz": 100}}}},
}


def numbers(node: Any, key: str, at: str) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Each schema of a number, with the key that it belongs to and its place."""
    if isinstance(node, list):
        for child in node:
            yield from numbers(child, key, at)
    elif isinstance(node, dict):
        if node.get("type") in ("number", "integer") and "const" not in node and "enum" not in node:
            yield key, at, node
        for name, child in node.items():
            if name in ("properties", "$defs"):
                for inner, value in child.items():
                    yield from numbers(value, inner, f"{at}.{inner}")
            elif name not in ("default", "examples", "const", "enum", "discriminator", "required"):
                yield from numbers(child, key, at)


def test_every_number_of_the_schema_has_two_limits() -> None:
    found = list(numbers(SCHEMA, "", "scenario"))
    assert len(found) > 900
    low, high = ("minimum", "exclusiveMinimum"), ("maximum", "exclusiveMaximum")
    open_ = [at for key, at, n in found if key not in FREE and not (n.keys() & {*low} and n.keys() & {*high})]
    assert not open_


def test_keys_without_range_are_few_and_say_why() -> None:
    assert set(FREE) == {"parameters"}
    assert all(FREE.values())


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("duration_s", 1e11, "duration_s of 1e+11"),
        ("world.depth_m", 1e9, "depth_m of 1e+09"),
        ("agents.auv0.start.position_m", [float("nan"), 0.0], "finite"),
        ("agents.auv0.start.speed_mps", -2e4, "speed_mps of -20000"),
        ("agents.auv0.sensors.imu.accelerometer_noise_density", float("inf"), "finite"),
        ("agents.auv0.sensors.imu.position_m", [0.0, -1e300, 0.0], "position_m of -1e+300"),
        ("origin", {"latitude_deg": 91.0, "longitude_deg": 0.0}, "latitude"),
    ],
)
def test_a_number_out_of_range_is_refused_at_its_place(key: str, value: Any, words: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario(SCENARIO, overrides={key: value})
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("key", "within"),
    [
        ("range_max_m", (-1e8, 1e8)),
        ("density_kg_m3", (-1e15, 1e15)),  # a product of units, not a volume
        ("roll_n_m", (-1e15, 1e15)),
        ("latitude_deg", (-90.0, 90.0)),
        ("kp", (-1e15, 1e15)),
        ("parameters", None),
    ],
)
def test_ranges_go_by_the_unit_of_the_key(key: str, within: tuple[float, float] | None) -> None:
    assert range_of(key) == within
