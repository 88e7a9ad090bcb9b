"""Positioning by sound: ultra-short and long baselines, hydrophones."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.acoustics.bearing import bearing_bound, direction_from_phases, element_phases
from pelagos.sensors.comms.link.budget import measured_direction

ARRAY = np.array([(0.02, 0, 0), (-0.02, 0, 0), (0, 0.02, 0), (0, -0.02, 0), (0, 0, 0.025)])
WAVELENGTH = 1500 / 28_000


def unit(azimuth: float, elevation: float) -> np.ndarray:
    c = np.cos(elevation)
    return np.array([c * np.cos(azimuth), c * np.sin(azimuth), np.sin(elevation)])


@pytest.mark.parametrize("direction", [(0.4, -0.3), (-2.5, 0.9), (1.7, -1.2)])
def test_phases_give_the_direction(direction: tuple[float, float]) -> None:
    u = unit(*direction)
    pressure = element_phases(ARRAY, u[None], np.array([0.3 - 0.2j]), WAVELENGTH)
    np.testing.assert_allclose(direction_from_phases(ARRAY, pressure, WAVELENGTH, u), u, atol=1e-12)
    flat = ARRAY[:4]
    pressure = element_phases(flat, u[None], np.ones(1, complex), WAVELENGTH)
    np.testing.assert_allclose(direction_from_phases(flat, pressure, WAVELENGTH, u), u, atol=1e-9)


def test_phases_that_are_too_large_for_a_flat_array_say_along_it() -> None:
    """Direction cosines of 1.2 in its plane, which no wave has: as far as it can be, along the array."""
    flat, wanted = ARRAY[:4], np.array([0.96, -0.72, 0.0])
    pressure = element_phases(flat, wanted[None], np.ones(1, complex), WAVELENGTH)
    found = direction_from_phases(flat, pressure, WAVELENGTH, wanted / 1.2)
    np.testing.assert_allclose(found, [0.8, -0.6, 0.0], atol=1e-9)


def test_error_of_a_bearing_meets_its_bound() -> None:
    """Planar array, 4000 draws: standard deviations of both direction cosines within 6 % of Cramer and Rao's bound."""
    rng = np.random.default_rng(7)
    flat, u, snr = ARRAY[:4], unit(0.7, -0.5), 200.0
    clean = element_phases(flat, u[None], np.ones(1, complex), WAVELENGTH)
    found = np.array(
        [
            direction_from_phases(
                flat, clean + (rng.normal(size=4) + 1j * rng.normal(size=4)) / np.sqrt(2 * snr), WAVELENGTH, u
            )
            for _ in range(4000)
        ]
    )
    bound = bearing_bound(flat, WAVELENGTH, snr)
    np.testing.assert_allclose(found[:, :2].std(axis=0), bound, rtol=0.06)


def test_a_ports_bearing_has_that_error_too() -> None:
    """2000 draws at 23 dB behind the correlator: the bound of the same array, within 4 standard errors."""
    flat, u, snr = ARRAY[:4], unit(0.7, -0.5), 200.0
    port: Any = SimpleNamespace(array=flat, sound_speed_mps=1500.0, frequency_hz=28_000.0)
    rng, waves = np.random.default_rng(8), (u[None], np.array([0.3 - 0.2j]))
    found = np.array([measured_direction(port, waves, snr, rng.normal(size=(2, 4))) for _ in range(2000)])
    cosines = np.array([unit(*angles) for angles in found])[:, :2]
    np.testing.assert_allclose(cosines.std(axis=0), bearing_bound(flat, WAVELENGTH, snr), rtol=4 / np.sqrt(4000))


def scenario(sensors: dict[str, Any], others: dict[str, Any] | None = None, **changes: Any) -> dict[str, Any]:
    return {
        "seed": 3,
        "tick_rate_hz": 20,
        "world": {"type": "flat", "depth_m": 80.0},
        "agents": {
            "usv": {
                "vehicle": "remus100",
                "start": {"position_m": [0, 0], "depth_m": 10, "heading_deg": 30},
                "sensors": sensors,
            },
            **(others or {}),
        },
    } | changes


def target(x: float, y: float, depth: float) -> dict[str, Any]:
    return {
        "vehicle": "remus100",
        "start": {"position_m": [x, y], "depth_m": depth},
        "sensors": {"modem": {"type": "modem", "device": "x150"}},
    }


def fixes(sim: pl.Simulation, seconds: float) -> np.ndarray:
    found = []
    for _ in range(round(seconds * 20)):
        reading = sim.step()["usv"].get("usbl")
        if reading is not None and np.isfinite(reading.extras["fix"]).all():
            found.append(reading.extras["fix"][0])
    return np.array(found)


EXACT = {"bearing_noise_deg": 0.0, "range_noise_m": 0.0}
"""No errors but those of the water: noise, echoes, refraction."""


def test_usbl_finds_a_vehicle_in_its_own_frame() -> None:
    """Within 2 % of the range; the frame turns with the vessel (heading 30 deg is -30 deg about z up)."""
    usbl = {"type": "usbl", "interrogate": ["auv"], "interrogate_s": 2.0, "sound_speed_mps": 1497.0, **EXACT}
    sim = pl.Simulation.load(scenario({"usbl": usbl}, {"auv": target(60.0, -80.0, 35.0)}))
    found = fixes(sim, 13.0)
    assert len(found) >= 3
    way = sim.state["auv"].position[0] - sim.state["usv"].position[0]
    yaw = sim.state["usv"].euler[0, 2]
    local = np.array([np.cos(yaw) * way[0] + np.sin(yaw) * way[1], np.cos(yaw) * way[1] - np.sin(yaw) * way[0], way[2]])
    error = np.linalg.norm(found - local, axis=1)
    assert error.max() < 0.03 * np.linalg.norm(local)
    assert np.linalg.norm(found, axis=1).mean() == pytest.approx(np.linalg.norm(local), abs=0.5)


def test_usbl_error_grows_with_range_and_falls_with_level() -> None:
    """Scatter of the bearing in a fleet of 40: louder is better, farther is worse; 20 dB are a factor of ten."""
    scatter = {}
    for name, distance, level in (("near", 60.0, 130.0), ("far", 240.0, 130.0), ("loud", 240.0, 150.0)):
        usbl = {"type": "usbl", "source_level_db": level, "bandwidth_hz": 8000.0, "multipath_window_s": 0.0002} | EXACT
        made = scenario({"usbl": usbl}, {"auv": target(distance, 0.0, 12.0)}, world={"type": "flat", "depth_m": 900.0})
        made["agents"]["auv"]["sensors"]["modem"] |= {"source_level_db": level, "multipath_window_s": 0.0002}
        made["agents"]["auv"]["start"]["depth_m"] = 400.0
        made["agents"]["usv"]["start"]["depth_m"] = 400.0
        sim = pl.Simulation.load(made, n=40)
        sim.send("auv", "modem", "x", to="usv")
        bearings: list[float] = []
        for _ in range(40):
            reading = sim.step()["usv"].get("usbl")
            if reading is not None:
                bearings += [p.azimuth_rad for packets in reading.packets for p in packets]
        assert len(bearings) > 30, name
        scatter[name] = np.std(bearings)
    assert scatter["far"] > 2.5 * scatter["near"]
    assert scatter["far"] / scatter["loud"] == pytest.approx(10.0, rel=0.35)


def test_an_array_on_a_line_is_refused() -> None:
    line = {"type": "usbl", "elements_m": [[0.0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]]}
    with pytest.raises(pl.InputError, match="on one line"):
        pl.Simulation.load(scenario({"usbl": line}))


def test_lbl_ranges_fix_a_place() -> None:
    """Four transponders: ranges within centimetres of the way that sound takes, and a place from them within 0.3 m."""
    places = {"n": [300, 0, -75], "s": [-250, 60, -70], "e": [20, -320, -78], "w": [0, 280, -72]}
    lbl = {"type": "lbl", "rate_hz": 1.0, "transponders": {k: {"position_m": v} for k, v in places.items()}}
    sim = pl.Simulation.load(scenario({"lbl": lbl}))
    errors = []
    for _ in range(80):
        reading = sim.step()["usv"].get("lbl")
        if reading is not None:
            errors.append(reading.data - reading.truth)
            ranges, time = reading.data[0], reading.extras["travel_time"][0]
    errors_m = np.array(errors)
    assert np.abs(errors_m).max() < 0.4
    assert errors_m.std(axis=0).mean() < 0.1
    assert np.ptp(errors_m[:, 0, 0]) > 0.0
    anchors, guess = np.array(list(places.values()), float), np.array([5.0, 5.0, -12.0])
    for _ in range(20):
        way = guess - anchors
        distance = np.linalg.norm(way, axis=1)
        guess = guess - np.linalg.lstsq(way / distance[:, None], distance - ranges, rcond=None)[0]
    assert np.linalg.norm(guess - sim.state["usv"].position[0]) < 1.0
    assert (time > 0).all()


def test_lbl_is_deaf_behind_a_wall_and_beyond_its_range() -> None:
    lbl = {"type": "lbl", "transponders": {"a": {"position_m": [100, 0, -12]}, "b": {"position_m": [0, 200, -12]}},
           "range_max_m": 150.0}  # fmt: skip
    sim = pl.Simulation.load(scenario({"lbl": lbl}))
    sim.spawn(pl.Prop("box", position=(50.0, 0.0, -40.0), size=(4.0, 80.0, 84.0), material="steel"))
    found = [o["usv"]["lbl"] for o in (sim.step() for _ in range(40)) if "lbl" in o["usv"]]
    assert all(np.isnan(r.data).all() for r in found)


def test_hydrophones_hear_a_pinger_when_and_where_it_is() -> None:
    """Onset after the travel time; phases between elements give its direction; level by spreading."""
    elements = [[0.0, 0, 0], [0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.01]]
    pinger = {"position_m": [60, 40, -30], "frequency_hz": 27_000.0, "source_level_db": 170.0, "first_s": 0.51}
    hydrophone = {"type": "hydrophone", "elements_m": elements, "pingers": {"p": pinger}, "rate_hz": 1.0}
    made = scenario({"hydrophone": hydrophone}, world={"type": "flat", "depth_m": 700.0})
    made["agents"]["usv"]["start"]["depth_m"] = 300.0
    made["agents"]["usv"]["sensors"]["hydrophone"]["pingers"]["p"]["position_m"] = [60, 40, -320]
    sim = pl.Simulation.load(made)
    reading = None
    for _ in range(25):
        got = sim.step()["usv"].get("hydrophone")
        reading = got if got is not None and got.t_ns == 1_000_000_000 else reading
    assert reading is not None
    x, t = reading.data[0], 1.0 + reading.extras["time"]
    assert x.shape == (4, 96_000)
    way = np.array([60.0, 40.0, -320.0]) - sim.state["usv"].position[0]
    distance = float(np.linalg.norm(way))
    loud = np.flatnonzero(np.abs(reading.truth[0, 0]) > 0.2 * np.abs(reading.truth[0, 0]).max())
    assert t[loud[0]] == pytest.approx(0.51 + distance / 1497.0, abs=2e-3)
    window = (t > t[loud[0]] + 1e-3) & (t < t[loud[0]] + 3e-3)
    tone = np.exp(-2j * np.pi * 27_000.0 * t[window])
    pressure = (x[:, window] * tone).mean(axis=1) * 2
    expected = 10 ** (170 / 20) * 1e-6 * np.sqrt(2) / distance
    assert abs(pressure[0]) == pytest.approx(expected, rel=0.15)
    u = direction_from_phases(np.array(elements), pressure, 1497.0 / 27_000.0, way / distance)
    yaw = sim.state["usv"].euler[0, 2]
    local = np.array([np.cos(yaw) * way[0] + np.sin(yaw) * way[1], np.cos(yaw) * way[1] - np.sin(yaw) * way[0], way[2]])
    assert u @ local / distance > np.cos(0.05)


def test_wrong_hydrophones_are_refused() -> None:
    with pytest.raises(pl.InputError, match="no multiple of rate_hz"):
        pl.Simulation.load(scenario({"h": {"type": "hydrophone", "sample_rate_hz": 96_001.0}}))
    wrong = {"type": "hydrophone", "pingers": {"p": {"position_m": [0, 0, 0], "frequency_hz": 60_000.0}}}
    with pytest.raises(pl.InputError, match="above half the sample rate"):
        pl.Simulation.load(scenario({"h": wrong}))


def trilaterated(anchors: np.ndarray, ranges: np.ndarray, guess: np.ndarray) -> np.ndarray:
    """Least squares by Gauss and Newton."""
    for _ in range(30):
        way = guess - anchors
        distance = np.linalg.norm(way, axis=1)
        guess = guess - np.linalg.lstsq(way / distance[:, None], distance - ranges, rcond=None)[0]
    return guess


def test_short_baseline_on_a_ship_under_way() -> None:
    """Four transponders on a ship that sails on: places follow it, and ranges to them give the vehicle's place in the
    ship's own frame. The error is that of the ranges over the angle that the baseline fills: cond of the geometry.
    """
    corners = {"bow": (1.5, 0.7, -0.6), "stern": (-1.6, 0.1, -1.4), "port": (0.3, 1.1, -2.6), "keel": (0.2, -1.0, -4.1)}
    carried = {name: {"position_m": place, "agent": "ship"} for name, place in corners.items()}
    made = scenario(
        {"lbl": {"type": "lbl", "rate_hz": 2.0, "transponders": carried, "turnaround_error_s": 0.0,
                 "source_level_db": 205.0}},
        {"ship": {"vehicle": "wamv", "start": {"position_m": [25.0, -18.0], "speed_mps": 2.0, "heading_deg": 200.0}}},
    )  # fmt: skip
    sim = pl.Simulation.load(made)
    start = sim.state["ship"].position[0].copy()
    seen = 0
    for _ in range(80):
        reading = sim.step()["usv"].get("lbl")
        if reading is None:
            continue
        seen += 1
        ship = sim.state["ship"]
        w, x, y, z = ship.attitude[0]
        turn = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ])  # fmt: skip
        anchors = np.array(list(corners.values()))
        np.testing.assert_allclose(
            reading.extras["transponder_position"][0], ship.position[0] + anchors @ turn.T, atol=1e-6
        )
        assert np.isnan(reading.extras["transponders"]).all()
        np.testing.assert_allclose(reading.data, reading.truth, rtol=2e-4, atol=0.02)
        local = turn.T @ (sim.state["usv"].position[0] - ship.position[0])
        found = trilaterated(anchors, reading.data[0], np.array([-10.0, 5.0, -15.0]))
        way = local - anchors
        spread = np.linalg.svd(way / np.linalg.norm(way, axis=1)[:, None], compute_uv=False).min()
        assert np.linalg.norm(found - local) < 0.03 / spread
    assert seen == 8
    assert np.linalg.norm(sim.state["ship"].position[0] - start) > 0.5


def test_carried_transponders_are_on_other_vehicles_of_the_scenario() -> None:
    def lbl(agent: str) -> dict[str, Any]:
        return {"lbl": {"type": "lbl", "transponders": {"t": {"position_m": [0, 0, 0.1], "agent": agent}}}}

    auv = {"auv": target(60.0, -80.0, 35.0)}
    with pytest.raises(pl.LookupFailed, match=r"usv\.sensors\.lbl\.transponders\.t\.agent: unknown agent 'auw'.*'auv'"):
        pl.Simulation.load(scenario(lbl("auw"), auv))
    with pytest.raises(pl.ScenarioError, match="carried by 'usv' itself"):
        pl.Simulation.load(scenario(lbl("usv"), auv))
    sim = pl.Simulation.load(scenario(lbl("auv"), auv), n=2)
    sim.set_state("auv", position=[[60.0, -80.0, -35.0], [20.0, 30.0, -15.0]])
    (truth,) = [o["usv"]["lbl"].truth for o in (sim.step() for _ in range(20)) if "lbl" in o["usv"]]
    np.testing.assert_allclose(truth[:, 0], [np.hypot(100.0, 25.0), np.hypot(np.hypot(20, 30), 5)], rtol=0.02)


def test_inverted_usbl_places_the_vehicle_by_a_ship() -> None:
    """The array is on the vehicle, the modem on a ship: turned into the world and taken from the ship's place, the fix
    is where the vehicle is, within 3 % of the range; it goes on with the ship.
    """
    ship = {
        "vehicle": "wamv",
        "start": {"position_m": [-70.0, 55.0], "speed_mps": 2.0, "heading_deg": 100.0},
        "sensors": {"modem": {"type": "modem", "device": "x150", "position_m": [0.4, 0.2, -1.0]}},
    }
    usbl = {"type": "usbl", "interrogate": ["ship"], "interrogate_s": 2.0, "sound_speed_mps": 1497.0, **EXACT}
    sim = pl.Simulation.load(scenario({"usbl": usbl}, {"ship": ship}))
    found = []
    for _ in range(220):
        reading = sim.step()["usv"].get("usbl")
        if reading is not None and np.isfinite(reading.extras["fix"]).all():
            roll, pitch, yaw = sim.state["usv"].euler[0]
            assert abs(roll) + abs(pitch) < 0.05
            x, y, z = reading.extras["fix"][0]
            way = np.array([np.cos(yaw) * x - np.sin(yaw) * y, np.sin(yaw) * x + np.cos(yaw) * y, z])
            here = sim.state["ship"].position[0] - way
            found.append(np.linalg.norm(here - sim.state["usv"].position[0]) / np.linalg.norm(way))
    assert len(found) >= 4
    assert max(found) < 0.05
    assert float(np.mean(found)) < 0.03


def range_bearing(targets: dict[str, Any], **keys: Any) -> dict[str, Any]:
    return {
        "it": {"type": "range_bearing", "rate_hz": 2.0, "targets": targets, "orientation_deg": [0.0, 0.0, 25.0], **keys}
    }


def one_reading(sim: pl.Simulation) -> pl.Reading | None:
    found = [o["usv"]["it"] for o in (sim.step() for _ in range(10)) if "it" in o["usv"]]
    return found[-1] if found else None


def test_range_and_bearing_of_a_vehicle_and_a_pinger() -> None:
    """Without noise: range, azimuth and elevation of the straight line from the mount, turned by heading and mount.

    Water of one sound speed but for pressure, 0.017 1/s: over 150 m a ray bends by g R/(2 c), 1e-3 rad.
    """
    silent = {"range_noise_m": 0.0, "azimuth_noise_rad": 0.0, "elevation_noise_rad": 0.0}
    targets = {"auv": {"position_m": [0.4, -0.1, 0.2], "agent": "auv"}, "pinger": {"position_m": [-70.0, -40.0, -62.0]}}
    sim = pl.Simulation.load(scenario(range_bearing(targets, **silent), {"auv": target(60.0, -80.0, 35.0)}))
    reading = one_reading(sim)
    assert reading is not None
    assert reading.data.shape == (1, 2, 3)
    place = reading.extras["target_position"][0]
    assert place[1].tolist() == [-70.0, -40.0, -62.0]
    assert np.linalg.norm(place[0] - sim.state["auv"].position[0]) < 1.0
    way = place - sim.state["usv"].position[0]
    yaw = sim.state["usv"].euler[0, 2] + np.radians(25.0)
    azimuth = np.arctan2(way[:, 1], way[:, 0]) - yaw
    expected = np.stack([np.linalg.norm(way, axis=1), np.angle(np.exp(1j * azimuth)),
                         np.arctan2(way[:, 2], np.hypot(way[:, 0], way[:, 1]))], axis=-1)  # fmt: skip
    np.testing.assert_allclose(reading.truth[0], expected, atol=0.02)
    np.testing.assert_allclose(reading.data[0, :, 0], expected[:, 0], rtol=2e-3)
    np.testing.assert_allclose(reading.data[0, :, 1:], reading.truth[0, :, 1:], atol=1.5e-3)
    assert not np.array_equal(reading.data, reading.truth)  # the ray is bent


def test_errors_of_range_and_bearing_are_those_asked_for() -> None:
    """200 copies: standard deviations within 4 of their own, 20 %; copies and values are independent."""
    asked = np.array([0.7, 0.03, 0.011])
    keys = dict(zip(("range_noise_m", "azimuth_noise_rad", "elevation_noise_rad"), asked, strict=True))
    targets = {"a": {"position_m": [50.0, 30.0, -30.0]}, "b": {"position_m": [-20.0, 45.0, -4.0]}}
    reading = one_reading(pl.Simulation.load(scenario(range_bearing(targets, **keys)), n=200))
    assert reading is not None
    error = (reading.data - reading.truth).reshape(200, 6)
    np.testing.assert_allclose(error.std(axis=0), np.tile(asked, 2), rtol=4 / np.sqrt(2 * 200))
    together = np.corrcoef(error.T) - np.eye(6)
    assert np.abs(together).max() < 4.5 / np.sqrt(200)


def test_range_and_bearing_end_at_a_wall_at_the_noise_and_at_the_longest_range() -> None:
    targets = {"a": {"position_m": [100.0, 0.0, -12.0]}, "b": {"position_m": [0.0, 60.0, -12.0]}}
    sim = pl.Simulation.load(scenario(range_bearing(targets)))
    sim.spawn(pl.Prop("box", position=(50.0, 0.0, -40.0), size=(4.0, 80.0, 84.0), material="steel"))
    reading = one_reading(sim)
    assert reading is not None
    assert np.isnan(reading.data[0]).all(axis=1).tolist() == [True, False]
    assert np.isfinite(reading.truth).all()
    for keys in ({"source_level_db": 60.0}, {"range_max_m": 50.0}):
        assert one_reading(pl.Simulation.load(scenario(range_bearing(targets, **keys)))) is None
    with pytest.raises(pl.LookupFailed, match=r"usv\.sensors\.it\.targets\.a\.agent: unknown agent 'auw'"):
        pl.Simulation.load(scenario(range_bearing({"a": {"position_m": [0, 0, 0], "agent": "auw"}})))
    with pytest.raises(pl.ScenarioError, match="above the water"):
        pl.Simulation.load(scenario(range_bearing({"a": {"position_m": [0, 0, 3.0]}})))


def test_looking_between_two_readings_loses_no_packet() -> None:
    """A transceiver tells what has come since it was due last, however often somebody looks in between."""
    usbl = {"type": "usbl", "interrogate": ["auv"], "interrogate_s": 2.0}
    told = []
    for looks in (False, True):
        sim = pl.Simulation.load(scenario({"usbl": usbl}, {"auv": target(60.0, -80.0, 35.0)}))
        found = []
        for tick in range(round(9e9 / sim.dt_ns)):
            if looks and tick % 3 == 1:
                sim.read("usv")
            reading = sim.step()["usv"].get("usbl")
            if reading is not None:
                found.append((reading.t_ns, [(p.kind, p.sender) for p in reading.extras["packets"][0]]))
        told.append(found)
    assert sum(len(packets) for _, packets in told[0]) >= 2
    assert told[0] == told[1]
