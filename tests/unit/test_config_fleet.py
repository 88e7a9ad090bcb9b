"""Scenarios of many agents that are alike: one vehicle for all, and mistakes in bounded numbers of lines."""

from __future__ import annotations

import pytest

from pelagos.config.loader import load_scenario
from pelagos.errors import ScenarioError


def fleet(count: int, vehicle: object = "remus100", **depth: object) -> dict:
    """A scenario of single agents, alike but for their places."""
    return {
        "world": {"type": "flat", "depth_m": 90},
        "agents": {
            f"a{i}": {
                "vehicle": vehicle,
                "start": {"position_m": [30 * i, -7]},
                "sensors": {"d": {"type": "depth", **depth}},
            }
            for i in range(count)
        },
    }  # fmt: skip


def test_agents_that_are_alike_share_one_vehicle() -> None:
    """A fleet's vehicle is validated once, one that differs in a number by itself, and a wrong one is told of each."""
    data = fleet(4)
    data["agents"]["a2"]["vehicle"] = {"type": "remus100", "length_m": 1.9}
    agents = load_scenario(data).agents
    assert agents["a0"].vehicle is agents["a1"].vehicle is agents["a3"].vehicle
    assert agents["a2"].vehicle.length_m == 1.9 != agents["a0"].vehicle.length_m
    assert load_scenario(data).agents["a0"].vehicle == agents["a0"].vehicle
    with pytest.raises(ScenarioError, match="2 things are wrong") as told:
        load_scenario(fleet(2, {"type": "remus100", "length_m": -1.6}))
    assert "a0.vehicle.length_m" in str(told.value)


def test_vehicles_that_differ_in_a_number_are_different() -> None:
    data = fleet(3)
    data["agents"]["a1"]["vehicle"] = {"type": "remus100", "density_kg_m3": 1000}
    data["agents"]["a2"]["vehicle"] = {"type": "remus100", "density_kg_m3": 1000.5}
    agents = load_scenario(data).agents
    assert [agents[a].vehicle.density_kg_m3 for a in ("a1", "a2")] == [1000, 1000.5]


def test_a_fleet_of_mistakes_is_told_in_forty_lines() -> None:
    with pytest.raises(ScenarioError, match="60 things are wrong") as told:
        load_scenario(fleet(60, rate=3))
    lines = str(told.value).splitlines()
    assert len(lines) == 42
    assert lines[-1] == "  and 20 more"
    assert "agents.a39.sensors.d" in lines[40]
