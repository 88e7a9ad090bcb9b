"""Packets by light under water and by radio above it; AIS sentences decoded by another package."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pynmea2
import pytest

import pelagos as pl
from pelagos.optics.optical_link import lambert_order, received_power
from pelagos.sensors.comms.ais import reporting_interval

pyais = pytest.importorskip("pyais")


def scenario(agents: dict[str, Any], **ocean: Any) -> dict[str, Any]:
    return {
        "seed": 3,
        "tick_rate_hz": 20,
        "origin": {"latitude_deg": 54.3, "longitude_deg": 10.2},
        "world": {"type": "flat", "depth_m": 60.0},
        "ocean": {"sun": {"elevation_deg": -30.0}, **ocean},
        "agents": agents,
    }


def lit(x: float, heading: float, depth: float = 30.0, **keys: Any) -> dict[str, Any]:
    return {
        "vehicle": "remus100",
        "start": {"position_m": [x, 0.0], "depth_m": depth, "heading_deg": heading},
        "sensors": {"light": {"type": "optical_modem", **keys}},
    }


def fates(sim: pl.Simulation, agent: str, sensor: str, seconds: float) -> list[Any]:
    found: list[Any] = []
    for _ in range(round(20 * seconds)):
        reading = sim.step()[agent].get(sensor)
        if reading is not None:
            found += reading.extras["fates"][0]
    return found


def test_power_falls_with_water_distance_and_angle() -> None:
    """Closed form: exp(-c d)/d^2, cosines of both angles; half the power at the half-power angle."""
    order = lambert_order(math.radians(30.0))
    near, far = (received_power(2.0, d, 0.15, 1e-3, order=order, cos_lamp=1.0, cos_receiver=1.0) for d in (5.0, 12.0))
    assert near / far == pytest.approx((12.0 / 5.0) ** 2 * math.exp(0.15 * 7.0), rel=1e-12)
    aside = received_power(2.0, 5.0, 0.15, 1e-3, order=order, cos_lamp=math.cos(math.radians(30.0)), cos_receiver=1.0)
    assert aside / near == pytest.approx(0.5, rel=1e-9)
    turned = received_power(2.0, 5.0, 0.15, 1e-3, order=order, cos_lamp=1.0, cos_receiver=0.6)
    assert turned / near == pytest.approx(0.6, rel=1e-12)
    assert received_power(2.0, 5.0, 0.15, 1e-3, order=order, cos_lamp=1.0, cos_receiver=-0.1) == 0.0


def test_light_carries_packets_where_both_look_at_each_other() -> None:
    sim = pl.Simulation.load(scenario({"a": lit(0.0, 0.0), "b": lit(12.0, 180.0)}))
    sim.send("a", "light", b"x" * 1000, to="b")
    (found,) = fates(sim, "b", "light", 1.0)
    assert found.fate == "received"
    away = pl.Simulation.load(scenario({"a": lit(0.0, 0.0), "b": lit(12.0, 0.0)}))
    away.send("a", "light", b"x", to="b")
    assert [f.fate for f in fates(away, "b", "light", 1.0)] == ["out of beam"]


def test_turbid_water_and_daylight_take_range() -> None:
    """What passes in clear water does not in turbid water; near the surface under the sun the margin is smaller."""
    clear = pl.Simulation.load(scenario({"a": lit(0.0, 0.0), "b": lit(25.0, 180.0)}, water_type="I"))
    turbid = pl.Simulation.load(scenario({"a": lit(0.0, 0.0), "b": lit(25.0, 180.0)}, water_type="5C"))
    got = []
    for sim in (clear, turbid):
        sim.send("a", "light", b"x" * 100, to="b")
        got += fates(sim, "b", "light", 1.0)
    assert [f.fate for f in got] == ["received", "out of range"]
    margins = []
    for elevation in (-30.0, 60.0):
        pair = {"a": lit(0.0, 0.0, 3.0), "b": lit(15.0, 180.0, 3.0)}
        sim = pl.Simulation.load(scenario(pair, water_type="I", sun={"elevation_deg": elevation}))
        sim.send("a", "light", b"x", to="b")
        margins.append(fates(sim, "b", "light", 1.0)[0].snr_db)
    assert margins[0] > margins[1] + 3.0


@pytest.mark.parametrize(("turned", "fate"), [(50.0, "received"), (-50.0, "received"), (70.0, "out of beam")])
def test_a_receiver_sees_60_degrees_to_each_side(turned: float, fate: str) -> None:
    sim = pl.Simulation.load(scenario({"a": lit(0.0, 0.0), "b": lit(6.0, 180.0 + turned)}))
    sim.send("a", "light", b"x", to="b")
    assert [f.fate for f in fates(sim, "b", "light", 1.0)] == [fate]


def test_daylight_is_that_at_the_receiver() -> None:
    """Both ways along one slanting path, by day: who listens 6 m deeper hears better, at night both hear alike."""
    margins = {}
    for elevation in (60.0, -30.0):
        pair = {"a": lit(0.0, 0.0, 3.0), "b": lit(15.0, 180.0, 9.0)}
        sim = pl.Simulation.load(scenario(pair, water_type="1C", sun={"elevation_deg": elevation}))
        for sender, receiver in (("a", "b"), ("b", "a")):
            sim.send(sender, "light", b"x", to=receiver)
            margins[elevation, receiver] = fates(sim, receiver, "light", 1.0)[0].snr_db
    assert margins[-30.0, "b"] == pytest.approx(margins[-30.0, "a"], abs=0.1)
    assert margins[60.0, "b"] > margins[60.0, "a"] + 0.5


def test_a_wall_stops_light() -> None:
    sim = pl.Simulation.load(scenario({"a": lit(0.0, 0.0), "b": lit(12.0, 180.0)}))
    sim.spawn(pl.Prop("box", position=(6.0, 0.0, -30.0), size=(0.5, 6.0, 6.0), material="steel"))
    sim.send("a", "light", b"x", to="b")
    assert [f.fate for f in fates(sim, "b", "light", 1.0)] == ["blocked"]


def boat(x: float, y: float, height: float, sensors: dict[str, Any]) -> dict[str, Any]:
    placed = {name: {**keys, "position_m": [0.0, 0.0, height]} for name, keys in sensors.items()}
    return {"vehicle": "otter", "start": {"position_m": [x, y], "heading_deg": 40.0}, "sensors": placed}


def test_radio_reaches_the_horizon_and_drops_at_submersion() -> None:
    """4.12 km (sqrt(h1) + sqrt(h2)): 8.2 km for antennas 1 m up; an antenna under water hears nothing."""
    for distance, fate in ((2_000.0, "received"), (9_500.0, "out of range")):
        wifi = {"radio": {"type": "radio", "power_dbm": 50.0, "bit_rate_bps": 1e5}}
        sim = pl.Simulation.load(scenario({"a": boat(0, 0, 1.0, wifi), "b": boat(distance, 0, 1.0, wifi)}))
        sim.send("a", "radio", b"hello", to="b")
        assert [f.fate for f in fates(sim, "b", "radio", 1.0)] == [fate]
    low, high = 1.2, 8.6
    horizon = 4120.0 * (math.sqrt(low) + math.sqrt(high))  # a third more than by the root of the sum
    for distance, fate in ((0.97 * horizon, "received"), (1.03 * horizon, "out of range")):
        far = {"radio": {"type": "radio", "power_dbm": 60.0, "bit_rate_bps": 1e5}}
        sim = pl.Simulation.load(scenario({"a": boat(0, 0, low, far), "b": boat(distance, 0, high, far)}))
        sim.send("a", "radio", b"hello", to="b")
        assert [f.fate for f in fates(sim, "b", "radio", 1.0)] == [fate]
    under = {
        "vehicle": "remus100",
        "start": {"position_m": [50, 0], "depth_m": 5},
        "sensors": {"radio": {"type": "radio"}},
    }
    sim = pl.Simulation.load(scenario({"a": boat(0, 0, 1.0, {"radio": {"type": "radio"}}), "b": under}))
    sim.send("a", "radio", b"hello", to="b")
    assert [f.fate for f in fates(sim, "b", "radio", 1.0)] == ["submerged"]
    with pytest.raises(pl.CommandError, match="radio sends above it"):
        sim.send("b", "radio", b"hello", to="a")


SIZE = {"length_m": 13, "beam_m": 5}


@pytest.mark.parametrize(("ais_class", "kinds"), [("A", {1, 5}), ("B", {18, 24})])
def test_ais_sentences_are_decoded_by_another_package(ais_class: str, kinds: set[int]) -> None:
    """Messages of the class, with the position where the boat is (1e-4 minutes) and its own number; checksums hold."""
    turned = {"orientation_deg": [0.0, 0.0, 90.0]}  # the ship's heading is told, not the antenna's
    ais = {"ais": {"type": "ais", "mmsi": 211_000_001, "ais_class": ais_class, "name": "Otter", **SIZE, **turned}}
    other = {"ais": {"type": "ais", "mmsi": 211_000_002}}
    sim = pl.Simulation.load(scenario({"a": boat(300, -200, 2.0, ais), "b": boat(0, 0, 2.0, other)}))
    lines: list[str] = []
    if ais_class == "B":  # at rest a class B reports every three minutes: asked by hand
        medium = sim.medium
        sim.step(ticks=4)
        report = medium.modems["a.ais"].report
        assert report is not None
        lines = [
            line
            for k in (0, 1)
            for line in report(medium.modems["a.ais"], medium.pose("a.ais"), 0, k)[0].decode().split("\n")
        ]
    for _ in range(20 * 26 if ais_class == "A" else 0):
        reading = sim.step()["b"].get("ais")
        if reading is not None:
            lines += [line for p in reading.packets for line in p.payload.decode().split("\n")]
    assert lines
    assert {line.split(",")[0] for line in lines} == {"!AIVDM"}  # of others; VDO would be the own ship
    for line in lines:
        assert pynmea2.NMEASentence.checksum(line.strip("!").split("*")[0]) == int(line.split("*")[1], 16)
    seen, pending = [], []
    for line in lines:
        pending.append(line)
        if line.split(",")[1] == line.split(",")[2]:
            seen.append(pyais.decode(*pending).asdict())
            pending = []
    assert {m["msg_type"] for m in seen} == kinds
    place = sim.world.origin.to_geodetic(sim.state["a"].position)[0]
    for m in seen:
        assert m["mmsi"] == 211_000_001
        if m["msg_type"] in (1, 18):
            np.testing.assert_allclose([m["lat"], m["lon"]], place[:2], atol=2e-5)
            assert m["heading"] == pytest.approx(40.0, abs=8.0)
        if "shipname" in m:
            assert m["shipname"].rstrip("@ ") == "OTTER"
        if "to_bow" in m:  # the antenna amidships: the parts are the ship
            assert (m["to_bow"], m["to_port"]) == (6, 2)
            assert (m["to_bow"] + m["to_stern"], m["to_port"] + m["to_starboard"]) == (13, 5)


def test_packets_by_light_and_radio_are_those_of_each_copy() -> None:
    """What three copies say to one another, whose vehicles lie elsewhere, is what each says alone."""
    radio = {"radio": {"type": "radio"}, "ais": {"type": "ais"}}
    agents = {"a": boat(0, 0, 1.0, radio), "b": boat(300, 20, 1.0, radio), "c": lit(0.0, 0.0), "d": lit(12.0, 180.0)}
    made = scenario(agents) | {
        "vary": {"agents.b.start.speed_mps": {"uniform": [0.5, 2.5]}} | {
            f"agents.{key}": {"uniform": [-most, most]}
            for key, most in {
                "a.start.position_m.0": 200.0, "b.start.position_m.1": 90.0, "a.start.heading_deg": 60.0,
                "c.start.position_m.0": 4.0, "d.start.position_m.1": 2.0, "b.start.heading_deg": 60.0,
                "c.start.heading_deg": 20.0, "d.start.pitch_deg": 20.0,
            }.items()
        }
    }  # fmt: skip

    def told(sim: pl.Simulation) -> list[list[str]]:
        found: list[list[str]] = [[] for _ in range(sim.n)]
        sim.step(ticks=4)
        port = sim.medium.modems["b.ais"]
        assert port.report is not None
        for k in range(sim.n):
            for agent, sensor in (("a", "radio"), ("c", "light"), ("d", "light"), ("b", "radio")):
                sim.send(agent, sensor, b"here", where=[k])
            sim.send("b", "ais", port.report(port, sim.medium.pose("b.ais"), k, 1)[0], where=[k])
        for _ in range(8):
            for agent, readings in sim.step().items():
                for name, reading in readings.items():
                    for k in range(sim.n):
                        if reading.extras["fates"][k] or reading.extras["packets"][k]:
                            heard = reading.extras["fates"][k], reading.extras["packets"][k], reading.data[k]
                            found[k].append(f"{agent}.{name} {heard}")
        return found

    fleet = told(pl.Simulation.load(made, n=3))
    assert {line.partition(" ")[0] for line in fleet[1]} >= {"a.radio", "b.radio", "a.ais", "c.light", "d.light"}
    assert len({str(said) for said in fleet}) == 3
    for k in (1, 2):
        assert told(pl.Simulation.load(made, environment=k))[0] == fleet[k]


def test_reporting_intervals() -> None:
    assert [reporting_interval(v, "A") for v in (5.0, 18.0, 30.0)] == [10.0, 6.0, 2.0]
    assert [reporting_interval(v, "B") for v in (1.0, 5.0)] == [180.0, 30.0]


def test_ships_have_numbers_and_names_of_their_own() -> None:
    ais = {"ais": {"type": "ais", "mmsi": 211_000_001}}
    twice = scenario({"u": boat(0, 0, 2.0, ais), "v": boat(90, 0, 2.0, ais)})
    with pytest.raises(
        pl.ScenarioError, match=r"agents\.v\.sensors\.ais: v\.ais: MMSI 211000001 is that of u\.ais already"
    ):
        pl.Simulation.load(twice)
    unnumbered = scenario({name: boat(0, 40 * k, 2.0, {"ais": {"type": "ais"}}) for k, name in enumerate("uvw")})
    unnumbered["agents"]["t"] = boat(0, 200, 2.0, {"ais": {"type": "ais", "mmsi": 200_000_001}})
    modems = pl.Simulation.load(unnumbered).medium.modems
    assert [modems[f"{name}.ais"].mmsi for name in "uvw"] == [200_000_000, 200_000_002, 200_000_003]
    named = scenario({"u": boat(0, 0, 2.0, {"ais": {**ais["ais"], "name": "Müritz"}})})
    with pytest.raises(pl.InputError, match="AIS has no character Ü"):
        pl.Simulation.load(named)
