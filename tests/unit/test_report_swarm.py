"""A swarm in the report: distances, approaches and contacts that are known because the motion was made up."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from report_mission import Seabed

from pelagos.messages.navigation import WRENCH_FIELDS
from pelagos.report.mission import RecordedMotion
from pelagos.report.swarm import swarm_section, swarms

T = np.linspace(0.0, 20.0, 41)


def member(number: int, *, feels: bool) -> Any:
    """On a line 10 m beside the one before; number 3 comes within 1.5 m of number 2 at 10 s, and away again."""
    aside = 10.0 * number - (8.5 * np.exp(-((T - 10.0) ** 2)) if number == 3 else 0.0)
    place = np.stack([1.5 * T, aside + 0.0 * T, -5.0 - 0.1 * number + 0.0 * T], axis=-1)
    force = np.zeros((len(T), len(WRENCH_FIELDS)))
    force[[19, 20, 25], 2] = -7.0 if number == 3 else 0.0  # two contacts, the first over two readings
    return SimpleNamespace(
        name=f"auv_{number}",
        agent=f"auv_{number}",
        scenario={"agents": {"auv": {"count": 6}, "rov": {}}},
        motion=RecordedMotion(T, place, np.tile([1.0, 0, 0, 0], (len(T), 1)), 0.0 * place),
        channels=lambda kind, message: [SimpleNamespace(topic="/felt")] if feels and kind == "collision" else [],
        recording=SimpleNamespace(channels={}, table=lambda topic, fields: (T, force)),
    )


def test_separation_and_contacts_are_those_of_the_motion() -> None:
    (found,) = swarms([member(i, feels=True) for i in range(6)])
    assert (found.name, len(found.members)) == ("auv", 6)
    assert found.contacts is not None
    assert found.contacts.tolist() == [[T[19], 3.0], [T[25], 3.0]]
    numbers: dict[str, Any] = {}
    section = swarm_section(found, Seabed(), numbers)
    said = numbers["swarms"]["auv"]
    assert said["members"] == 6
    assert said["contacts"] == 2
    assert said["way_m"]["least"] == pytest.approx(30.0)
    nearest = said["nearest_approaches"][0]
    assert (nearest["member"], nearest["to"], nearest["t_s"]) == ("auv_2", "auv_3", 10.0)
    assert nearest["distance_m"] == pytest.approx(np.hypot(1.5, 0.1))
    assert said["separation_m"]["least"] == nearest["distance_m"]
    assert said["separation_m"]["median"] == pytest.approx(np.hypot(10.0, 0.1), rel=1e-3)
    assert "auv_3" in section.body
    assert "felt 2 contacts" in section.text


def test_few_vehicles_and_those_of_no_group_are_drawn_one_by_one() -> None:
    assert swarms([member(i, feels=False) for i in range(4)]) == []
    (found,) = swarms([member(i, feels=False) for i in range(5)])
    assert found.contacts is None
    assert "not known" in swarm_section(found, Seabed(), {}).text
