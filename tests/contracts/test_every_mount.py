"""A sensor whose place is drawn for a copy reads what it reads in a scenario that writes that place."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_every_sensor import SMALL

import pelagos as pl
from pelagos.config import registry
from pelagos.config.vary import MOUNT
from pelagos.errors import ScenarioError
from pelagos.sim.observe import of_a_run

NAMES = sorted(registry.entries("sensor", plugins=False))
OF_A_RUN = [name for name in NAMES if of_a_run(registry.find("sensor", name).load())]
MOVED = [name for name in NAMES if name not in OF_A_RUN]
POSITION, ORIENTATION = [0.3, -0.2, 0.25], [4.0, -3.0, 10.0]
DRAWS = ({"uniform": [0.2, 0.6]}, {"uniform": [-0.4, -0.1]}, {"uniform": [0.1, 0.4]}, *[{"uniform": [-12, -2]}] * 3)


def scenario(sensors: dict[str, Any], vary: dict[str, Any]) -> dict[str, Any]:
    return {
        "seed": 11,
        "tick_rate_hz": 100,
        "world": {
            "type": "flat",
            "depth_m": 8.0,
            "things": [{"shape": "box", "at_m": [6.0, -3.0, -6.0], "size_m": [2.0, 1.0, 3.0]}],
        },
        "ocean": {"tracers": {"chlorophyll": 2.0, "oxygen": 240.0, "turbidity": 1.5}},
        "agents": {
            "auv0": {
                "vehicle": "remus100",
                "start": {"position_m": [0.0, 0.0], "depth_m": 3.0, "pitch_deg": -4.0, "speed_mps": 1.2},
                "control": "depth_heading",
                "command": [4.0, 0.9, 700.0],  # a turn: the lever arm matters to speeds and accelerations
                "sensors": sensors,
            }
        },
        "vary": vary,
    }


def placed(position: list[float], orientation: list[float]) -> dict[str, Any]:
    place = {"position_m": position, "orientation_deg": orientation}
    return {name: {"type": name, "rate_hz": 10, **SMALL.get(name, {}), **place} for name in MOVED}


def key(sensor: str, number: str) -> str:
    return f"agents.auv0.sensors.{sensor}.{number}"


@pytest.mark.filterwarnings("ignore::pelagos.errors.ValidityWarning")  # pings lie far apart
def test_a_drawn_mount_is_a_written_one() -> None:
    """To the last bit but for rounding where a velocity is turned twice: 1e-15 of some m/s."""
    vary = {key(s, number): draw for s in MOVED for number, draw in zip(MOUNT, DRAWS, strict=True)}
    many = pl.Simulation.load(scenario(placed(POSITION, ORIENTATION), vary), n=2)
    written, seen = placed(POSITION, ORIENTATION), []
    for name in MOVED:
        own = [float(many.drawn[key(name, number)][1]) for number in MOUNT]
        written[name] |= {"position_m": own[:3], "orientation_deg": own[3:]}
        seen.append(tuple(own))
    assert len(set(seen)) == len(MOVED)
    alone = pl.Simulation.load(scenario(written, {}), environment=1)
    mine, theirs = (sim.step(ticks=20)["auv0"] for sim in (many, alone))
    assert set(mine) == set(theirs)
    assert len(mine) > 30
    for name, reading in mine.items():
        for of_two, of_one in ((reading.data, theirs[name].data), (reading.truth, theirs[name].truth)):
            np.testing.assert_allclose(of_two[1], of_one[0], rtol=0, atol=1e-14, equal_nan=True, err_msg=name)


@pytest.mark.parametrize("name", ["imu", "dvl", "multibeam", "imaging_sonar"])
def test_the_mount_matters(name: str) -> None:
    vary = {key(name, number): draw for number, draw in zip(MOUNT, DRAWS, strict=True)}
    sim = pl.Simulation.load(scenario({name: placed(POSITION, ORIENTATION)[name]}, vary), n=2)
    first, second = np.asarray(sim.step(ticks=20)["auv0"][name].truth, dtype=np.float64)
    assert np.nanmean(np.abs(first - second)) > 0.02 * np.nanmean(np.abs(first))


@pytest.mark.parametrize("name", OF_A_RUN)
def test_what_tells_of_a_run_has_one_place(name: str) -> None:
    sensor = {"type": name, "rate_hz": 10, **SMALL.get(name, {})}
    with pytest.raises(ScenarioError, match=rf"auv0\.sensors\.{name}\.position_m\.0 .* of the type {name}"):
        pl.Simulation.load(scenario({name: sensor}, {key(name, "position_m.0"): {"uniform": [0, 1]}}))
