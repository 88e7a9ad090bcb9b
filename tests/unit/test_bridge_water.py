"""Instruments that sample the water, as recorded: what they measured, in the message's units."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl
from pelagos.messages.water import ATMOSPHERE, CTD_FIELDS, FLOW_FIELDS, FLUID_PRESSURE_FIELDS, TEMPERATURE_FIELDS
from pelagos.sim.replay import Recording

SENSORS = {
    "ctd": {"type": "ctd", "rate_hz": 4},
    "sound": {"type": "sound_velocity", "rate_hz": 2},
    "oxygen": {"type": "oxygen"},
    "ntu": {"type": "turbidity"},
    "chl": {"type": "fluorometer"},
    "dye": {"type": "tracer", "tracer": "dye"},
    "flow": {"type": "current_meter", "rate_hz": 4},
}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    file = tmp_path_factory.mktemp("water") / "out.mcap"
    scenario = {
        "tick_rate_hz": 20,
        "world": {"type": "flat", "depth_m": 50.0},
        "ocean": {
            "currents": {"type": "uniform", "speed_mps": 0.5, "towards_deg": 90},
            "temperature_c": 14.0,
            "salinity": 38.0,
            "tracers": {"oxygen": 240.0, "turbidity": 3.0, "chlorophyll": 1.5, "dye": 7.0},
        },
        "agents": {
            "auv0": {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 10.0}, "sensors": SENSORS}
        },
    }
    pl.Simulation.load(scenario, seed=2).run(3.0, record=str(file))
    return Recording(file)


def test_ctd_says_it_three_times(recording: Recording) -> None:
    t, whole = recording.table("/auv0/ctd/ctd", CTD_FIELDS)
    assert len(t) == 13  # at 0, 0.25 ... 3 s
    conductivity, temperature, pressure, salinity, speed = whole[:, 2:].T
    assert temperature == pytest.approx(14.0, abs=0.01)
    assert pressure == pytest.approx(10.0 * 1.0287 * 0.9806, abs=0.6)  # dbar
    assert salinity == pytest.approx(38.0, abs=0.05)
    assert conductivity == pytest.approx(4.43, abs=0.1)  # S/m
    assert speed == pytest.approx(1506.0, abs=2.0)
    _, other = recording.table("/auv0/ctd/temperature", TEMPERATURE_FIELDS)
    assert np.array_equal(other[:, 2], temperature)
    _, pascal = recording.table("/auv0/ctd/pressure", FLUID_PRESSURE_FIELDS)
    assert pascal[:, 2] == pytest.approx(1e4 * pressure + ATMOSPHERE, rel=1e-12)
    message = recording.message("/auv0/ctd/temperature", 0).message
    assert message.header.frame_id == "auv0/ctd"
    assert message.variance > 0


@pytest.mark.parametrize(
    ("topic", "quantity", "unit", "value", "within"),
    [
        ("/auv0/sound/sound_speed", "sound_speed", "m/s", 1506.0, 2.0),
        ("/auv0/oxygen/oxygen", "oxygen", "umol/kg", 240.0, 25.0),
        ("/auv0/ntu/turbidity", "turbidity", "NTU", 3.0, 1.0),
        ("/auv0/chl/chlorophyll", "chlorophyll", "mg/m^3", 1.5, 0.5),
        ("/auv0/dye/tracer", "dye", "", 7.0, 1e-12),
    ],
)
def test_a_property_has_its_name_and_unit(
    recording: Recording, topic: str, quantity: str, unit: str, value: float, within: float
) -> None:
    message = recording.message(topic, 0).message
    assert (message.quantity, message.unit) == (quantity, unit)
    assert message.value == pytest.approx(value, abs=within)
    assert message.variance >= 0


def test_current_meter_is_a_twist_of_the_water(recording: Recording) -> None:
    """The vehicle heads north and is carried along: across it at first half a metre a second to starboard (y left)."""
    _, rows = recording.table("/auv0/flow/flow", FLOW_FIELDS)
    assert rows[0, 3] == pytest.approx(-0.5, abs=0.05)
    message = recording.message("/auv0/flow/flow", 0).message
    assert message.twist.covariance[0] > 0
