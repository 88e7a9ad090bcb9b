"""Modems: errors against theory, packets through the water, protocols, ranges, repeatability."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos.acoustics.image_sources import paths
from pelagos.acoustics.modulation import aloha_throughput, bit_error_rate, packet_success


@pytest.mark.parametrize(
    ("modulation", "expected"),
    [
        ("bpsk", [7.865e-2, 1.250e-2, 2.388e-3, 1.909e-4, 3.872e-6]),
        ("dpsk", [0.1839, 4.056e-2, 9.333e-3, 9.094e-4, 2.270e-5]),
        ("fsk", [0.3033, 0.1424, 6.831e-2, 2.132e-2, 3.369e-3]),
    ],
)
def test_bit_errors_against_theory(modulation: Any, expected: list[float]) -> None:
    snr = 10 ** (np.array([0.0, 4.0, 6.0, 8.0, 10.0]) / 10)
    np.testing.assert_allclose(bit_error_rate(modulation, snr), expected, rtol=5e-4)


def test_orthogonal_signals_by_simulation() -> None:
    """Non-coherent detection of 4 and of 64 signals: within four standard errors, and 10 % for the integral."""
    rng = np.random.default_rng(1)
    for order, db in ((4, 6.0), (64, 4.0)):
        bits = np.log2(order)
        g = 10 ** (db / 10) * bits
        count = 40_000
        z = (rng.normal(size=(count, order)) + 1j * rng.normal(size=(count, order))) / np.sqrt(2)
        z[:, 0] += np.sqrt(g)
        wrong = np.mean(np.abs(z).argmax(axis=1) != 0)
        expected = float(bit_error_rate("mfsk", 10 ** (db / 10), order=order)) * (order - 1) / (order / 2)
        assert wrong == pytest.approx(expected, abs=4 * np.sqrt(wrong / count) + (0.0 if order <= 16 else 0.1 * wrong))


def test_packets_and_aloha() -> None:
    """(1 - p)^n; the greatest throughput is 1/(2e) at half a packet a packet time, and 1/e at one in slots."""
    assert packet_success(1e-3, 800) == pytest.approx(0.999**800, rel=1e-9)
    load = np.linspace(0.05, 2.0, 2000)
    assert aloha_throughput(load).max() == pytest.approx(1 / (2 * np.e), rel=1e-5)
    assert aloha_throughput(load, slotted=True).max() == pytest.approx(1 / np.e, rel=1e-5)


def scenario(places: dict[str, tuple[float, float, float]], **keys: Any) -> dict[str, Any]:
    """Vehicles that stand still, each with a modem."""
    return {
        "seed": 5,
        "tick_rate_hz": 20,
        "world": {"type": "flat", "depth_m": 60.0},
        "ocean": {"temperature_c": 12.0},
        "agents": {
            name: {
                "vehicle": "remus100",
                "start": {"position_m": [x, y], "depth_m": depth},
                "sensors": {"modem": {"type": "modem", "device": "micromodem", **keys}},
            }
            for name, (x, y, depth) in places.items()
        },
    }


TWO = {"a": (0.0, 0.0, 20.0), "b": (300.0, 0.0, 30.0)}
THREE = {**TWO, "c": (150.0, 260.0, 25.0)}


def listen(sim: pl.Simulation, seconds: float) -> tuple[dict[str, list[Any]], dict[str, list[Any]]]:
    """Packets and fates by agent of the first copy."""
    packets: dict[str, list[Any]] = {name: [] for name in sim.model.agents}
    fates: dict[str, list[Any]] = {name: [] for name in sim.model.agents}
    for _ in range(round(seconds * 1e9 / sim.dt_ns)):
        for name, readings in sim.step().items():
            if "modem" in readings:
                packets[name] += readings["modem"].extras["packets"][0]
                fates[name] += readings["modem"].extras["fates"][0]
    return packets, fates


def test_a_packet_arrives_after_its_travel_time() -> None:
    """Twice the distance is twice the delay; level by spreading and absorption."""
    times = []
    for distance in (300.0, 600.0):
        sim = pl.Simulation.load(scenario({"a": (0, 0, 20), "b": (distance, 0, 20)}))
        assert sim.send("a", "modem", "hello", to="b") == 1
        packets, fates = listen(sim, 3.0)
        (packet,) = packets["b"]
        assert packet.payload == b"hello"
        assert (packet.sender, packet.to, packet.kind) == ("a.modem", "b.modem", "data")
        times.append(packet.travel_time_s)
        c = 1497.0
        assert packet.travel_time_s == pytest.approx(distance / c, rel=2e-3)
        duration = 0.2 + 8 * (4 + 5) / 80
        assert (packet.received_ns - packet.sent_ns) * 1e-9 == pytest.approx(distance / c + duration, rel=2e-3)
        direct = 190.0 - 20 * np.log10(distance) - 4e-3 * distance
        lengths = np.array([image.length for image in paths(60.0, 20.0, 20.0, distance, count=40)])
        within = lengths < lengths[0] + 0.0125 * c  # of surface and bottom, which take something each time
        most = 10 * np.log10(np.sum((lengths[0] / lengths[within]) ** 2))
        assert direct - 0.5 < packet.level_db < direct + most + 0.1
        assert [f.fate for f in fates["b"]] == ["received"]
        assert packets["a"] == []
    assert times[1] / times[0] == pytest.approx(2.0, abs=0.01)


def test_two_way_range() -> None:
    """Half the time between request and response, less the turn-around, at 1500 m/s; here water has about 1497."""
    sim = pl.Simulation.load(scenario(TWO))
    sim.send("a", "modem", b"", to="b", kind="request")
    packets, _ = listen(sim, 4.0)
    (response,) = packets["a"]
    assert response.kind == "response"
    way = float(np.hypot(300.0, 10.0))
    assert response.range_m == pytest.approx(way * 1500 / 1497.0, abs=0.6)
    assert response.depth_m == pytest.approx(30.0, abs=0.5)


def test_a_request_to_all_gives_the_range_of_each_that_answers() -> None:
    """Three at 300, 800 and 1300 m: headers of 0.6 s that come back 0.67 s one after the other do not meet."""
    others = {"b": (300.0, 0.0, 30.0), "c": (-800.0, 0.0, 30.0), "d": (0.0, 1300.0, 30.0)}
    sim = pl.Simulation.load(scenario({"a": (0.0, 0.0, 20.0), **others}))
    sim.send("a", "modem", b"", to="*", kind="request")
    packets, _ = listen(sim, 6.0)
    ranges = {p.sender: p.range_m for p in packets["a"]}
    assert sorted(ranges) == ["b.modem", "c.modem", "d.modem"]
    for name, (x, y, _) in others.items():
        way = float(np.hypot(np.hypot(x, y), 10.0))
        assert ranges[f"{name}.modem"] == pytest.approx(way * 1500 / 1497.0, rel=3e-3)


def test_clocks_drift() -> None:
    """One-way times have the difference of both clocks: offset 10 ms each, so its scatter is 14 ms."""
    sim = pl.Simulation.load(scenario(TWO, clock_offset_std_s=0.01), n=60)
    sim.send("a", "modem", "x", to="b")
    found: list[float] = []
    for _ in range(60):
        readings = sim.step()["b"]
        if "modem" in readings:
            found += [p.travel_time_s for packets in readings["modem"].packets for p in packets]
    assert len(found) >= 55
    assert np.std(found) == pytest.approx(0.0141, rel=0.35)


def test_a_wall_blocks_and_distance_loses() -> None:
    sim = pl.Simulation.load(scenario({"a": (0, 0, 10), "b": (100, 0, 10)}, device="m64"))
    wall = sim.spawn(pl.Prop("box", position=(50.0, 0.0, -30.0), size=(4.0, 60.0, 60.0), material="steel"))
    sim.send("a", "modem", "x", to="b")
    _, fates = listen(sim, 4.0)
    assert [f.fate for f in fates["b"]] == ["blocked"]
    wall.remove()
    sim.send("a", "modem", "x", to="b")
    _, fates = listen(sim, 6.0)
    assert [f.fate for f in fates["b"]] == ["received"]
    far = pl.Simulation.load(scenario({"a": (0, 0, 10), "b": (2500, 0, 10)}, device="m64"))
    far.send("a", "modem", "x", to="b")
    _, fates = listen(far, 6.0)
    assert [f.fate for f in fates["b"]] == ["out of range"]


def test_collisions_and_half_duplex() -> None:
    """Two that speak at once are lost at the third, and do not hear each other."""
    sim = pl.Simulation.load(scenario(THREE))
    sim.send("a", "modem", "from a", to="*")
    sim.send("b", "modem", "from b", to="*")
    packets, fates = listen(sim, 3.0)
    assert [f.fate for f in fates["c"]] == ["collision", "collision"]
    assert [f.fate for f in fates["a"]] == ["half duplex"]
    assert not any(packets.values())


def test_capture_of_the_near_one() -> None:
    """A packet 30 dB above another survives."""
    sim = pl.Simulation.load(scenario({"a": (0, 0, 20), "b": (1500, 0, 20), "c": (20, 0, 20)}))
    sim.send("a", "modem", "near", to="*")
    sim.send("b", "modem", "far", to="*")
    packets, _ = listen(sim, 4.0)
    assert [p.payload for p in packets["c"]] == [b"near"]


@pytest.mark.parametrize("mac", ["tdma", "csma", "maca"])
def test_protocols_keep_packets_apart(mac: str) -> None:
    """What collides without a protocol arrives with one."""
    frame = {"slots": 3, "slot_s": 3.0, "guard_s": 0.6} if mac == "tdma" else {}
    sim = pl.Simulation.load(scenario(THREE, mac=mac, **frame, timeout_s=2.5, acknowledge=True, retries=8))
    for k in range(2):
        sim.send("a", "modem", f"a{k}", to="c")
        sim.send("b", "modem", f"b{k}", to="c")
    packets, _ = listen(sim, {"tdma": 30.0, "csma": 40.0, "maca": 60.0}[mac])
    assert {p.payload for p in packets["c"]} == {b"a0", b"a1", b"b0", b"b1"}


def test_acknowledged_packets_are_sent_again() -> None:
    """A collision, then retries after random times: both get through, each exactly once or more."""
    sim = pl.Simulation.load(scenario(THREE, mac="aloha", acknowledge=True, retries=8))
    sim.send("a", "modem", "from a", to="c")
    sim.send("b", "modem", "from b", to="c")
    packets, fates = listen(sim, 60.0)
    assert {p.payload for p in packets["c"]} == {b"from a", b"from b"}
    assert any(f.kind == "ack" and f.fate == "received" for f in [*fates["a"], *fates["b"]])


def test_an_answered_request_is_not_asked_again() -> None:
    """Its answer is the acknowledgement."""
    sim = pl.Simulation.load(scenario(TWO, acknowledge=True, timeout_s=2.5))
    sim.send("a", "modem", "", to="b", kind="request")
    _, fates = listen(sim, 20.0)
    assert [(f.kind, f.fate) for f in fates["b"]] == [("request", "received")]
    assert [(f.kind, f.fate) for f in fates["a"]] == [("response", "received")]


def test_without_a_protocol_what_collided_collides_again() -> None:
    """Both wait equally long for an acknowledgement, and send again at once: nine times, and neither gets through."""
    sim = pl.Simulation.load(scenario(THREE, mac="none", acknowledge=True, retries=8))
    sim.send("a", "modem", "from a", to="c")
    sim.send("b", "modem", "from b", to="c")
    packets, fates = listen(sim, 60.0)
    assert packets["c"] == []
    assert [f.fate for f in fates["c"]] == ["collision"] * 18


def test_beacons_run_by_themselves() -> None:
    sim = pl.Simulation.load(scenario(THREE, beacon_s=6.0, mac="tdma", slots=3, slot_s=2.0, guard_s=0.2))
    packets, _ = listen(sim, 18.5)
    assert all(len(found) >= 4 for found in packets.values())


def test_sonars_in_the_band_disturb() -> None:
    """A sonar of 220 dB in the modem's band drowns what arrives at its own vehicle; its twin's too (moved together)."""
    made = scenario(THREE)
    ping = {"type": "singlebeam", "frequency_hz": 25_500.0, "source_level_db": 220.0, "pulse_s": 0.01, "rate_hz": 10}
    for name in ("a", "b"):
        made["agents"][name]["sensors"]["sonar"] = ping
    sim = pl.Simulation.load(made)
    sim.send("c", "modem", "x", to="*")
    _, fates = listen(sim, 3.0)
    assert [f.fate for name in ("a", "b") for f in fates[name]] == ["sonar", "sonar"]


def test_sonars_disturb_by_their_share_of_time_and_band() -> None:
    """Level at the modem, 20 log r down, times pulse over period and the part of the pulse's band in the modem's; of
    two sonars the powers add, in each copy from where they are there.

    The modem hears 23 to 27 kHz, the sonars 25.5 to 29.5 kHz: 1.5 of 4 kHz, and 24 to 26 kHz: all.
    """
    made = scenario(THREE, frequency_hz=25_000.0, bandwidth_hz=4_000.0)
    pings = [
        {"frequency_hz": 27_500.0, "bandwidth_hz": 4_000.0, "source_level_db": 211.0, "pulse_s": 0.01, "rate_hz": 2},
        {"frequency_hz": 25_000.0, "bandwidth_hz": 2_000.0, "source_level_db": 203.0, "pulse_s": 0.003, "rate_hz": 4},
    ]
    for name, ping in zip("ab", pings, strict=True):
        made["agents"][name]["sensors"]["sonar"] = {"type": "singlebeam", "position_m": [0.5, 0.1, 0.2], **ping}
    made["vary"] = {f"agents.{name}.start.position_m.0": {"uniform": [200.0, 500.0]} for name in "bc"}
    sim = pl.Simulation.load(made, n=3)
    sim.step(ticks=2)
    medium = sim.medium
    port = medium.modems["c.modem"]
    mount = sim.model.agents["a"].sensors["sonar"].config
    for copy in range(3):
        here, *there = (medium.pose(f"{name}.modem").position[copy] for name in "cab")
        arms = [medium.pose_of(name, mount).position[copy] - here for name in "ab"]
        assert np.linalg.norm(arms[0] + here - there[0]) > 0.3
        ways = [float(np.linalg.norm(arm)) for arm in arms]
        first = 10.0 ** (21.1 - 2.0 * np.log10(ways[0])) * (0.01 * 2) * (1.5 / 4.0)
        second = 10.0 ** (20.3 - 2.0 * np.log10(ways[1])) * (0.003 * 4)
        found = medium.sonar_noise(port, medium.pose("c.modem"), copy)
        assert found == pytest.approx(10.0 * np.log10(first + second), abs=1e-6)
    assert len(set(sim.state["b"].position[:, 0])) == 3


def test_addresses_follow_the_scenario() -> None:
    """Those that are given stay, others are the next free ones in order; changed keys of a modem leave them alone."""
    made = scenario({"a": (0, 0, 20), "b": (300, 0, 30), "c": (150, 260, 25), "d": (90, 60, 20)})
    made["agents"]["b"] = {**made["agents"]["b"], "vehicle": "bluerov2"}
    made["agents"]["c"]["sensors"]["modem"]["address"] = 0
    sim = pl.Simulation.load(made)
    expected = {"a.modem": 1, "b.modem": 2, "c.modem": 0, "d.modem": 3}
    assert {path: port.address for path, port in sim.medium.modems.items()} == expected
    sim.set("a.modem", source_level_db=170.0)
    assert {path: port.address for path, port in sim.medium.modems.items()} == expected
    assert sim.medium.modems["a.modem"].source_level_db == 170.0


def beacons() -> dict[str, Any]:
    made = scenario(THREE, beacon_s=2.5, mac="csma", clock_offset_std_s=0.01)
    made["agents"]["a"]["control"] = "depth_heading"
    made["agents"]["a"]["command"] = [20.0, 0.3, 1200.0]
    return made


def comparable(packets: dict[str, list[Any]]) -> list[str]:
    return [repr(p) for name in sorted(packets) for p in packets[name]]


def test_same_seed_same_packets_in_steps_blocks_fleets_and_from_a_checkpoint() -> None:
    one, other = (pl.Simulation.load(beacons()) for _ in range(2))
    packets = comparable(listen(one, 12.0)[0])
    assert len(packets) > 5
    assert comparable(listen(other, 12.0)[0]) == packets
    fleet = pl.Simulation.load(beacons(), n=3)
    alone = pl.Simulation.load(beacons(), environment=2)
    third: dict[str, list[Any]] = {name: [] for name in fleet.model.agents}
    for _ in range(240):
        for name, readings in fleet.step().items():
            if "modem" in readings:
                third[name] += readings["modem"].extras["packets"][2]
    assert comparable(third) == comparable(listen(alone, 12.0)[0])
    blocks = pl.Simulation.load(beacons())
    seen: dict[str, list[Any]] = {name: [] for name in blocks.model.agents}
    for name in seen:
        blocks.subscribe(f"{name}.modem", lambda r, name=name: seen[name].extend(r.packets))
    blocks.run(12.0)
    assert comparable(seen) == packets
    first = pl.Simulation.load(beacons())
    half = listen(first, 5.0)[0]
    kept = first.checkpoint()
    second = pl.Simulation.load(beacons())
    second.restore(kept)
    rest = listen(second, 7.0)[0]
    assert comparable({k: half[k] + rest[k] for k in half}) == packets


def test_recordings_hold_every_packet_with_its_fate(tmp_path: Path) -> None:
    import json

    file = tmp_path / "talk.mcap"
    pl.Simulation.load(beacons()).run(8.0, record=file)

    texts = [json.loads(m.message.data) for m in pl.Recording(file).messages("/b/modem/packets")]
    lines = [line for text in texts for line in text]
    assert lines
    assert {"fate", "sender", "receiver", "sent_ns", "time_ns", "level_db"} <= lines[0].keys()


def test_wrong_packets_are_refused() -> None:
    sim = pl.Simulation.load(scenario(TWO))
    with pytest.raises(pl.CommandError, match="holds 32 bytes; given 40"):
        sim.send("a", "modem", b"x" * 40, to="b")
    with pytest.raises(pl.LookupFailed, match="unknown modem 'd'"):
        sim.send("a", "modem", "x", to="d")
    with pytest.raises(pl.LookupFailed, match=r"did you mean 'modem'"):
        sim.send("a", "moden", "x", to="b")
    with pytest.raises(pl.CommandError, match="to itself"):
        sim.send("a", "modem", "x", to="a")
    with pytest.raises(pl.CommandError, match="bytes or text"):
        sim.send("a", "modem", 5, to="b")  # type: ignore[arg-type]
    sim.set_state("a", position=(0.0, 0.0, 3.0))
    with pytest.raises(pl.CommandError, match="above the water"):
        sim.send("a", "modem", "x", to="b")


def test_wrong_modems_are_refused() -> None:
    with pytest.raises(pl.ScenarioError, match="address 3 is that of"):
        pl.Simulation.load(scenario(TWO, address=3))
    with pytest.raises(pl.InputError, match="bit_rate_bps"):
        pl.Simulation.load(scenario(TWO, bit_rate_bps=0))
    with pytest.raises(pl.InputError, match="unknown modem device 'm65'"):
        pl.Simulation.load(scenario(TWO, device="m65"))
    with pytest.raises(pl.InputError, match="no room for a header"):
        pl.Simulation.load(scenario(TWO, mac="tdma", slot_s=0.3))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"chirp_order": 16}, "'chirp_order' changes nothing without 'modulation: mfsk or chirp'"),
        ({"slots": 3, "guard_s": 0.1}, "'slots', 'guard_s' changes nothing without 'mac: tdma'"),
        ({"beacon_bytes": 4}, "'beacon_bytes' changes nothing without 'beacon_s'"),
        ({"type": "usbl", "interrogate_s": 3.0}, "'interrogate_s' changes nothing without 'interrogate'"),
    ],
)
def test_keys_that_change_nothing_are_told(keys: dict[str, Any], message: str) -> None:
    with pytest.warns(pl.ValidityWarning, match=r"[ab]\.modem: " + message):
        pl.Simulation.load(scenario(TWO, **keys))


def test_a_copy_above_the_water_leaves_the_others_sending() -> None:
    sim = pl.Simulation.load(scenario(TWO), n=2)
    sim.set_state("b", position=[[300.0, 0.0, -21.0], [300.0, 0.0, 4.0]])
    assert sim.send("b", "modem", "x", to="a", where=[1, 0]) >= 0
    with pytest.raises(pl.CommandError, match=r"4(\.\d)? m above the water"):
        sim.send("b", "modem", "x", to="a", where=[1])


def test_what_no_water_carries_is_refused() -> None:
    """Names that nobody has, slots that hold no packet, housings that do not stand the depth, parts of protocols."""
    with pytest.raises(pl.LookupFailed, match=r"agents\.a\.sensors\.modem\.beacon_to: unknown modem 'zz'"):
        pl.Simulation.load(scenario(TWO, beacon_s=2.0, beacon_to="zz"))
    with pytest.raises(pl.InputError, match="does not hold it"):
        pl.Simulation.load(scenario(TWO, mac="tdma", slot_s=1.2, guard_s=0.1, beacon_s=4.0, beacon_bytes=32))
    with pytest.raises(pl.InputError, match="power of two"):
        pl.Simulation.load(scenario(TWO, modulation="mfsk", chirp_order=3))
    sim = pl.Simulation.load(scenario(TWO, mac="tdma", slot_s=1.2, guard_s=0.1, depth_max_m=25.0))
    with pytest.raises(pl.CommandError, match=r"32 bytes take 3\.8 s"):
        sim.send("a", "modem", b"x" * 32, to="b")
    with pytest.raises(pl.CommandError, match="30 m deep; its housing stands 25 m"):
        sim.send("b", "modem", "x", to="a")
    with pytest.raises(pl.LookupFailed, match="known: data, request"):
        sim.send("a", "modem", "", to="b", kind="ack")  # type: ignore[arg-type]
    sim.send("a", "modem", "x", to="b")
    assert [f.fate for f in listen(sim, 3.5)[1]["b"]] == ["too deep"]


@pytest.mark.parametrize(("place", "said"), [([10, 40, 3.0], "3 m above"), ([10, 40, -75.0], "15 m below the ground")])
@pytest.mark.parametrize("sensor", ["lbl", "hydrophone"])
def test_transponders_and_pingers_are_in_the_water(sensor: str, place: list[float], said: str) -> None:
    made = scenario(TWO)
    devices = {"transponders" if sensor == "lbl" else "pingers": {"p": {"position_m": place}}}
    made["agents"]["a"]["sensors"]["other"] = {"type": sensor, **devices}
    with pytest.raises(pl.ScenarioError, match=said):
        pl.Simulation.load(made)


def test_a_ship_that_moves_between_two_modems_blocks_them() -> None:
    """The same packet before, while and after a long hull lies across the way; it is seen within two seconds."""
    made = scenario({"a": (0, 0, 2), "b": (80, 0, 2)}, device="m64")
    made["world"] = {"type": "flat", "depth_m": 4.0}
    sim = pl.Simulation.load(made)
    hull = sim.spawn(pl.Prop("box", position=(40.0, 300.0, -1.0), size=(6.0, 60.0, 6.4), material="steel"))
    fates = []
    for y in (300.0, 0.0, -300.0):
        hull.move(position=(40.0, y, -1.0))
        sim.send("a", "modem", "x", to="b")
        fates.append([f.fate for f in listen(sim, 4.0)[1]["b"]])
    assert fates == [["received"], ["blocked"], ["received"]]


def test_a_vehicle_that_passes_between_two_modems_blocks_them() -> None:
    """A third vehicle's own hull, driven: where it stands across the straight way nothing comes by that way.

    Water so deep and a window so short that echoes are out: without the direct path a packet of 64 bit/s is lost.
    """
    made = scenario({"a": (0, 0, 200), "b": (40, 0, 200), "c": (20, 60, 200)}, device="m64")
    made["world"] = {"type": "flat", "depth_m": 900.0}
    sim = pl.Simulation.load(made)
    levels = []
    for y, heading in ((60.0, 0.0), (0.0, np.pi / 2), (-60.0, 0.0)):
        attitude = (np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2))
        sim.set_state("c", position=(20.0, y, -200.0), attitude=attitude, velocity=(0.0, 0.0, 0.0))
        levels.append(pl.channel(sim, "a", "b", frequency_hz=140_500.0).transmission_loss())
    assert levels[1] > levels[0] + 20.0
    assert levels[2] == pytest.approx(levels[0], abs=0.01)


def sinking(position: Any, t: Any) -> Any:
    """Warm water over cold [degC]: 18 above, 8 below a layer of 5 m that sinks from 8 to 60 m within a minute."""
    top = 8.0 + 52.0 * dr.clip(t / 60.0, 0.0, 1.0)
    return 18.0 - 10.0 * dr.clip((-position[2] - top) / 5.0, 0.0, 1.0)


def test_a_deeper_thermocline_moves_the_shadow_zone() -> None:
    """Sound between modems 10 and 12 m deep, 1.5 km apart: a thermocline over them bends the direct ray down and away,
    one below them leaves it; the second packet, sent in the same run, is louder by what the direct ray is.

    In the warm layer only the pressure bends: 0.016 1/s, 3 m in 1.5 km, so that a ray between them stays above 60 m.
    """
    made = scenario({"a": (0, 0, 10), "b": (1500, 0, 12)}, device="micromodem", rate_hz=1.0, multipath_window_s=0.001)
    made["world"] = {"type": "flat", "depth_m": 400.0, "size_m": [6000.0, 6000.0]}
    made["ocean"] = {"temperature_c": [{"type": "python", "function": f"{__name__}:sinking"}]}
    sim = pl.Simulation.load(made)
    direct, levels = [], []
    for wait in (0.0, 62.0):
        listen(sim, wait)
        found = pl.channel(sim, "a", "b", frequency_hz=25e3).arrivals()
        direct.append(int(((found.bottom == 0) & (found.surface == 0)).sum()))
        sim.send("a", "modem", "x", to="b")
        levels += [f.level_db for f in listen(sim, 4.0)[1]["b"]]
    assert direct == [0, 1]
    assert levels[1] > levels[0] + 3.0


def test_another_level_of_the_sea_is_that_of_modems_too() -> None:
    """A modem 2 m under the surface is in the air when the sea has fallen by 3 m, and under water when it is back."""
    sim = pl.Simulation.load(scenario({"a": (0, 0, 20), "b": (100, 0, 2)}))
    fates = []
    for level in (0.0, -3.0, 0.0):
        sim.ocean.set(level_m=level)
        sim.set_state("b", position=(100.0, 0.0, -2.0), velocity=(0.0, 0.0, 0.0))
        sim.send("a", "modem", "x", to="b")
        fates.append([f.fate for f in listen(sim, 1.5)[1]["b"]])
    assert fates == [["received"], ["in air"], ["received"]]


@pytest.mark.parametrize("phase_deg", [50.0, 205.0])
def test_a_packet_tells_the_depth_that_a_gauge_beside_the_modem_reads(phase_deg: float) -> None:
    """Tide 3.1 cos(2 pi t / 72 s - phase) [m]: a response from z = -30 tells of 30 m and the level when its modem
    looks at its queue (ten times a second), to the 3 cm that its vehicle sinks in 1 s; and to 0.1 mm what a depth
    gauge at its place reads of the pressure then."""
    gauge = {"type": "depth", "rate_hz": 20, "noise_density": 0, "bias_std_m": 0, "drift_m": 0, "resolution_m": 0}
    given = scenario(TWO)
    given["ocean"]["tide"] = [{"amplitude_m": 3.1, "period_h": 0.02, "phase_deg": phase_deg}]
    given["agents"]["b"]["sensors"]["gauge"] = gauge
    sim = pl.Simulation.load(given)
    sim.send("a", "modem", b"", to="b", kind="request")
    read: dict[int, float] = {}
    answers: list[Any] = []
    while not answers and sim.time_ns < 4_000_000_000:
        found = sim.step()
        read[sim.time_ns] = float(found["b"]["gauge"].data[0])
        answers = found["a"]["modem"].extras["packets"][0] if "modem" in found["a"] else []
    (response,) = answers
    looked = -(-response.sent_ns // 100_000_000) * 100_000_000
    level = 3.1 * np.cos(2 * np.pi * looked * 1e-9 / 72.0 - np.deg2rad(phase_deg))
    assert abs(level) > 1.0
    assert response.depth_m == pytest.approx(30.0 + level, abs=0.03)
    assert response.depth_m == pytest.approx(read[looked], abs=1e-4)


def test_what_is_under_way_ends_with_a_reset() -> None:
    """200 ms on the way, and no packet of the life before arrives."""
    sim = pl.Simulation.load(scenario(TWO))
    sim.send("a", "modem", "of before", to="b")
    sim.step(ticks=2)
    sim.reset()
    assert listen(sim, 3.0)[0]["b"] == []
    sim.send("a", "modem", "of now", to="b")
    assert [p.payload for p in listen(sim, 3.0)[0]["b"]] == [b"of now"]


def test_a_fleet_sends_where_one_of_its_copies_can() -> None:
    """The housing stands 25 m: a copy at 10 m may send, one at 30 m not, alone or with another there."""
    sim = pl.Simulation.load(scenario(TWO, depth_max_m=25.0), n=2)
    place = sim.state["b"].position.copy()
    place[0, 2] = -10.0
    sim.set_state("b", position=place)
    sim.send("b", "modem", "x", to="a")
    sim.send("b", "modem", "x", to="a", where=[0])
    with pytest.raises(pl.CommandError, match="30 m deep; its housing stands 25 m"):
        sim.send("b", "modem", "x", to="a", where=[1])


def test_beacons_of_a_copy_that_begins_anew_count_from_then() -> None:
    """Two beacons at 0, 2, 4 s of each run: six packets within 5 s, also of a run that begins at 7 s."""
    sim = pl.Simulation.load(scenario(TWO, beacon_s=2.0), n=2)
    sim.run(7.0)
    sim.reset(where=[True, False])
    counts = []
    for seconds in (1.0, 2.0, 2.0):
        sim.run(seconds)
        counts.append(sim.stepper.traffic._numbers[0])
    assert counts == [2, 4, 6]
