"""What everything that casts sound must do, checked the day it is added: it sees each change with its next ping."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pelagos as pl
from cases import slow
from pelagos.config import registry
from pelagos.errors import LookupFailed
from pelagos.sensors.sonar.keys.ping_keys import PingConfig
from pelagos.sensors.sonar.ping.sea_surface import SEA_SURFACE_INSTANCE

AHEAD, BELOW, ASIDE = (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, np.cos(np.radians(27)), -np.sin(np.radians(27)))
LOOKS: dict[str, tuple[Any, dict[str, Any]]] = {
    "imaging_sonar": (AHEAD, {"beams": 33, "bins": 256}),
    "mechanical_scanning_sonar": (AHEAD, {"bins": 256, "sector_deg": 2.0, "step_deg": 2.0}),
    "profiling_sonar": (BELOW, {"beams": 33, "bins": 256, "orientation_deg": [0, 90, 0]}),
    "singlebeam": (BELOW, {"bins": 256}),
    "multibeam": (BELOW, {"beams": 33}),
    "altimeter": (BELOW, {}),
    "dvl": (BELOW, {}),
    "adcp": (BELOW, {"cells": 30}),
    "sidescan": (ASIDE, {"bins": 256}),
    "synthetic_aperture_sonar": (ASIDE, {"bins": 1200, "rays": 4096, "range_min_m": 1.0}),
}
AKIN = ("mechanical_scanning_sonar", "profiling_sonar", "sidescan")
"""Sonars whose pings are those of others, as seen by others: of the imaging sonar, and of the synthetic aperture."""
NAMES = [slow(name) if name in AKIN else name for name in sorted(LOOKS)]
DEPTH, ALTITUDE = 15.0, 20.0


def test_all_sonars_are_here():
    names = registry.entries("sensor", plugins=False)
    gives_levels = {name for name in names if issubclass(registry.find("sensor", name).load().Config, PingConfig)}
    assert gives_levels | {"multibeam", "altimeter", "dvl", "adcp"} == set(LOOKS)


def simulation(
    name: str, *, run: dict[str, int] | None = None, ocean: dict[str, Any] | None = None, **options: Any
) -> pl.Simulation:
    sensor: dict[str, Any] = {"type": name, "rate_hz": 10, **LOOKS[name][1], **options}
    if name not in ("altimeter", "dvl", "adcp"):
        sensor = {"range_max_m": 30.0} | sensor
    start = {"position_m": [0.0, 0.0], "depth_m": DEPTH}
    auv = {"vehicle": "remus100", "start": start, "sensors": {"it": sensor}}
    world = {"type": "flat", "depth_m": DEPTH + ALTITUDE}
    scenario = {"world": world, "ocean": ocean or {}, "agents": {"auv0": auv}}
    return pl.Simulation.load(scenario, **(run or {}))


def next_ping(sim: pl.Simulation, *, z: float = -DEPTH) -> Any:
    """The next reading, of a vehicle that is held in its place; None where there is none within 40 ticks."""
    for _ in range(40):
        still = {"position": (0, 0, z), "attitude": (1, 0, 0, 0), "velocity": (0, 0, 0)}
        sim.set_state("auv0", **{k: np.tile(v, (sim.n, 1)) for k, v in still.items()})
        obs = sim.step()
        if "it" in obs["auv0"]:
            return obs["auv0"]["it"]
    return None


def ranges_of(name: str, reading: pl.Reading, before: pl.Reading, ranges: np.ndarray | None) -> float:
    """The nearest range at which the truth of two readings differs [m]."""
    if name in ("dvl", "adcp"):
        return float(np.nanmin(reading.extras["ranges"][0]))
    if ranges is None:
        return float(np.nanmin(reading.truth[0]))
    now, then = (10.0 ** (4.5 * r.truth[0].reshape(-1, len(ranges)).astype(float)) for r in (reading, before))
    return float(ranges[(np.abs(now - then).max(axis=0) > 1e-2 * np.abs(now - then).max()).argmax()])


@pytest.mark.parametrize("name", NAMES)
def test_a_prop_that_is_spawned_moved_and_removed_is_seen_by_the_next_ping(name):
    """No caches: a cube of 8 m in the sonar's view, at 6 m, at 9 m, and gone."""
    sim = simulation(name)
    sim.reset()
    axis = np.array(LOOKS[name][0])
    table = sim.model.agents["auv0"].sensors["it"].sensor
    ranges = getattr(table, "tables", {}).get("range")
    place = lambda r: np.array([0, 0, -DEPTH]) + (r + 4.0) * axis  # whose near face is at the range r
    empty = next_ping(sim)
    cube = sim.spawn(pl.Prop("box", position=place(6.0), size=8.0))
    spawned = next_ping(sim)
    cube.move(position=place(9.0))
    moved = next_ping(sim)
    cube.remove()
    gone = next_ping(sim)
    if name == "mechanical_scanning_sonar":
        gone = next_ping(sim)  # in which the head points where it did

    tilt = {"dvl": 1 / np.cos(np.radians(30)), "adcp": 1 / np.cos(np.radians(20))}.get(name, 1.0)
    assert ranges_of(name, spawned, empty, ranges) == pytest.approx(6.0 * tilt, abs=1.5)
    assert ranges_of(name, moved, empty, ranges) == pytest.approx(9.0 * tilt, abs=1.5)
    assert np.array_equal(gone.truth, empty.truth, equal_nan=gone.truth.dtype.kind == "f")
    if name in ("dvl", "adcp"):
        assert np.array_equal(gone.extras["ranges"] > 15.0, empty.extras["ranges"] > 15.0)


@pytest.mark.parametrize("name", NAMES)
def test_complex_signal_and_labels_come_on_request_and_change_nothing_else(name):
    more: dict[str, Any] = {"iq": True, "labels": True}
    down = {"orientation_deg": [0, 45, 0]} if LOOKS[name][0] == AHEAD else {}
    if name == "multibeam":
        more["water_column_bins"] = 64
    plain, asked = (next_ping(simulation(name, **options)) for options in (down, down | more))
    assert plain.data.tobytes() == asked.data.tobytes()
    assert plain.truth.tobytes() == asked.truth.tobytes()
    signal = asked.data if name == "synthetic_aperture_sonar" else asked.extras["iq"]
    assert signal.dtype == np.complex64
    assert np.isfinite(signal).all()
    assert np.abs(signal).max() > 0
    label, instance = (asked.extras["label" if k == 0 else "instance"] for k in (0, 1))
    assert label.shape == instance.shape
    assert label.max() > 0  # the ground's
    if "water_column" in asked.extras:
        level, truth = asked.extras["water_column"], asked.extras["water_column_truth"]
        assert level.shape == truth.shape == asked.extras["water_column_label"].shape
        assert asked.extras["water_column_instance"].shape == level.shape
        loudest = np.unravel_index(truth.argmax(), truth.shape)
        assert asked.extras["water_column_label"][loudest] == label.max()


@pytest.mark.parametrize("name", NAMES)
def test_a_copy_of_a_fleet_hears_what_it_hears_alone(name):
    """Bit for bit, raw signal and labels included; another copy hears other noise."""
    more: dict[str, Any] = {"iq": True, "labels": True} | ({"water_column_bins": 64} if name == "multibeam" else {})
    if "elements" in component(name).model_fields:
        more["elements"] = True
    many, one = (simulation(name, run=run, **more) for run in ({"n": 2}, {"environment": 1}))
    fleet, alone = next_ping(many), next_ping(one)
    tables = one.model.agents["auv0"].sensors["it"].sensor.tables
    assert fleet.data[1].tobytes() == alone.data[0].tobytes()
    for extra, values in alone.extras.items():
        assert extra in tables or fleet.extras[extra][1].tobytes() == values[0].tobytes(), extra
    signal = fleet.data if name == "synthetic_aperture_sonar" else fleet.extras["iq"]
    assert signal[0].tobytes() != signal[1].tobytes()


@pytest.mark.parametrize("waves", [False, slow(True)])
@pytest.mark.parametrize("name", sorted(LOOKS))
def test_in_the_air_it_hears_nothing(name, waves):
    """Neither bottom nor water, by straight or bent rays; back in the water it hears both again."""
    echoes = {"water_column_bins": 64} if name in ("adcp", "altimeter", "dvl", "multibeam") else {}
    hazy = {"volume_scattering_db": -50.0, **echoes, **({"cells": 15} if name == "adcp" else {})}
    bent = {"refraction": True} if waves and "refraction" in component(name).model_fields else {}
    sea = {"waves": {"type": "jonswap", "significant_height_m": 0.3, "peak_period_s": 3.0}} if waves else {}
    sim = simulation(name, ocean=sea, **hazy, **bent)
    sim.reset()
    wet, dry, again = (next_ping(sim, z=z) for z in (-8.0, 3.0, -8.0))
    assert heard(name, wet)
    assert not heard(name, dry)
    assert heard(name, again)


@pytest.mark.parametrize("name", sorted(LOOKS))
def test_it_sees_waves_from_below(name):
    """Turned up, below the surface, raw signal and all: what it meets is the sea's."""
    up = {"orientation_deg": [0, -60, 0] if LOOKS[name][0] == AHEAD or name == "profiling_sonar" else [180, 0, 0]}
    raw = {"iq": True, "labels": True} | ({"water_column_bins": 64} if name == "multibeam" else {})
    sea = {"waves": {"type": "jonswap", "significant_height_m": 0.3, "peak_period_s": 3.0}}
    sim = simulation(name, ocean=sea, **raw, **up)
    sim.reset()
    reading = next_ping(sim)
    assert heard(name, reading)
    names = [n for n in ("instance", "water_column_instance") if n in reading.extras]
    assert any((reading.extras[n] == SEA_SURFACE_INSTANCE).any() for n in names)


def test_sonars_of_every_kind_on_another_vehicle_may_be_heard_or_not():
    """`hears: others` takes those that can be heard; the rest are told from them by name."""
    start = {"position_m": [0.0, 0.0], "depth_m": DEPTH}
    mine = {"type": "imaging_sonar", "rate_hz": 10, "beams": 32, "bins": 64, "range_max_m": 30, "hears": "others"}
    theirs = {name: {"type": name, "rate_hz": 5, **LOOKS[name][1]} for name in LOOKS}
    theirs["synthetic_aperture_sonar"]["range_max_m"] = 30.0
    agents = {
        "auv0": {"vehicle": "remus100", "start": start, "sensors": {"it": mine}},
        "auv1": {"vehicle": "remus100", "start": start | {"position_m": [10.0, 0.0]}, "sensors": theirs},
    }
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": DEPTH + ALTITUDE}, "agents": agents})
    sim.reset()
    loud = next_ping(sim)
    mine["hears"] = ["auv1.imaging_sonar"]
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": DEPTH + ALTITUDE}, "agents": agents})
    sim.reset()
    assert loud.data.sum() >= next_ping(sim).data.sum() > 0
    mine["hears"] = ["auv1.dvl"]
    with pytest.raises(LookupFailed, match=r"sonar that can be heard 'auv1\.dvl'"):
        pl.Simulation.load({"world": {"type": "flat", "depth_m": DEPTH + ALTITUDE}, "agents": agents})


def heard(name: str, reading: pl.Reading | None) -> bool:
    """Whether a reading holds more than noise."""
    if reading is None:
        return False
    values = reading.data if name in ("adcp", "dvl") else reading.truth
    return bool((np.nan_to_num(np.abs(values)) > 0).any())


def component(name: str) -> Any:
    return registry.find("sensor", name).load().Config
