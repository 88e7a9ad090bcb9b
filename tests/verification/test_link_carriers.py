"""Links by light and radio between given ends: levels by formulas of their own, and why nothing comes."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.sensors.comms.ais import Ais, AisConfig, reporting_interval
from pelagos.sensors.comms.link.carrier import Light, Radio
from pelagos.sensors.sensor import SensorContext

LEVELS = (-0.3, 0.6)  # of the sea, by copy
OWN = np.array([70, 71], np.uint32)


class Around:
    """A world with something in the way of some casts, which it remembers."""

    def __init__(self, *, stands: bool = False) -> None:
        self.stands, self.casts = stands, []

    def cast(self, origin: Any, direction: Any, *, max_range: float, copy: Any, own_body: Any) -> Any:
        """See `World`."""
        self.casts.append((np.array(origin), np.array(direction), max_range, int(copy[0]), int(own_body[0])))
        return SimpleNamespace(valid=np.array([self.stands]))


def sea(**keys: Any) -> Any:
    def elevation(x: Any, y: Any, t: Any, copy: Any) -> Any:
        return np.array([LEVELS[int(np.array(copy)[0])] + 0.01 * np.array(x)[0] - 0.02 * np.array(y)[0]])

    return SimpleNamespace(elevation=elevation, **keys)


def ends(*places: Any, turned: Any = None) -> SimpleNamespace:
    attitude = np.tile([1.0, 0, 0, 0], (len(places), 1)) if turned is None else np.asarray(turned)
    return SimpleNamespace(position=np.array(places, float), attitude=attitude)


def lost(one: Any, pair: tuple[int, int, int], poses: dict[int, Any]) -> str:
    """Why nothing comes from one end to another of the same make."""
    return str(one.hear(pair, poses, 0.0, one).lost)


def radio(world: Any) -> Radio:
    return Radio(world, sea(), 2.4e9, 27.0, -95.0, OWN)


@pytest.mark.parametrize("copy", [0, 1])
@pytest.mark.parametrize("distance", [30.0, 90.0, 3000.0])
def test_radio_falls_as_in_free_space_and_farther_as_two_rays(copy: int, distance: float) -> None:
    """(4 pi d/lambda)^2, or d^4/(h1 h2)^2 where that is more: beyond 4 pi h1 h2/lambda, some 400 m; antennas over the
    waves at their own place."""
    a = [[1.0, 2.0, 1.4], [3.0, -2.0, 2.9]]
    b = [[1.0 + distance, 2.0, 0.01 * distance + 2.2], [3.0, -2.0 + distance, 4.1 - 0.02 * distance]]
    world = Around()
    heard = radio(world).hear((4, 2, copy), {4: ends(*a), 2: ends(*b)}, 3.0, radio(world))
    pa, pb = np.array(a[copy]), np.array(b[copy])
    way = float(np.linalg.norm(pb - pa))
    h1, h2 = (p[2] - (LEVELS[copy] + 0.01 * p[0] - 0.02 * p[1]) for p in (pa, pb))
    free = (4 * math.pi * way * 2.4e9 / 299_792_458.0) ** 2
    loss = max(free, way**4 / (h1 * h2) ** 2)
    assert (loss > free) == (distance > 1000)
    assert heard.level_db == pytest.approx(27.0 - 10 * math.log10(loss), abs=1e-9)
    assert heard.delay_s == pytest.approx(way / 299_792_458.0)
    assert (heard.lost, heard.echoes_db, heard.doppler, heard.spread_s) == ("", -math.inf, 1.0, 0.0)
    ((origin, along, reach, of_copy, own),) = world.casts
    np.testing.assert_allclose(origin, pa)
    np.testing.assert_allclose(along, pb - pa)
    assert (reach, of_copy, own) == (pytest.approx(way - 1.5), copy, 70 + copy)


def test_why_no_radio_comes() -> None:
    """Either antenna submerged, in its own copy; beyond both horizons together; something between, but not so near."""
    low, high, wet = [0.0, 0, 1.0], [200.0, 0, 5.0], [200.0, 0, 2.1]
    for pair in ((low, wet), (wet, low)):
        poses = {0: ends(pair[0], pair[0]), 1: ends(pair[1], pair[1])}
        assert [lost(radio(Around()), (0, 1, c), poses) for c in (0, 1)] == ["", "submerged"]
    reach = 4120.0 * (math.sqrt(1.3) + math.sqrt(4.3))
    for factor, why in ((0.999, ""), (1.001, "out of range")):
        there = [0.0, factor * reach, 4.0 - 0.02 * factor * reach]
        assert lost(radio(Around()), (0, 1, 0), {0: ends(low), 1: ends(there)}) == why
    stands = radio(Around(stands=True))
    poses = {0: ends(low), 1: ends(high), 2: ends([2.9, 0, 1.0])}
    assert [lost(stands, (0, k, 0), poses) for k in (1, 2)] == ["blocked", ""]


def quaternion(*euler_deg: float) -> Any:
    return Rotation.from_euler("ZYX", euler_deg, degrees=True).as_quat()[[3, 0, 1, 2]]


WATER = SimpleNamespace(attenuation=(0.5, 0.12, 0.2), downwelling=(0.4, 0.09, 0.06))


def light(world: Any, *, sun: float = -0.3, channel: int = 1) -> Light:
    ocean = sea(water=WATER, sun_elevation=np.array([sun]))
    return Light(
        world=world, ocean=ocean, power_w=3.0, half_angle=math.radians(40.0), field_of_view=math.radians(50.0),
        area=6e-4, responsivity=0.35, bandwidth=2e5, channel=channel, filter_share=0.03, own=OWN,
    )  # fmt: skip


@pytest.mark.parametrize("copy", [0, 1])
@pytest.mark.parametrize(("sun", "channel"), [(-0.3, 1), (0.9, 1), (0.9, 2)])
def test_light_by_the_link_equation_and_the_noise_of_its_diode(copy: int, sun: float, channel: int) -> None:
    """P (m + 1)/(2 pi d^2) cos^m A cos exp(-c d) on the diode; its noise by day at the receiver's depth over that in
    the dark is taken from the level: Kaushal and Kaddoum 2016, electrical power in decibels of its current. The lamp is
    the sender's, everything else the receiver's, a device of another make."""
    a, b = [[0.0, 0, -6], [1.0, 2, -9]], [[9.0, 4, -8], [-8.0, 5, -4]]
    looks = [quaternion(35, 5, 20), quaternion(150, -20, -40)]
    back = [quaternion(-140, -20, 10), quaternion(-40, 15, 70)]
    world = Around()
    eye_of = light(world, sun=sun, channel=channel)
    lamp_of = replace(
        eye_of, power_w=1.7, half_angle=math.radians(25.0), field_of_view=0.1, area=1.0, responsivity=9.0,
        filter_share=0.9, bandwidth=7.0, own=OWN + 10,
    )  # fmt: skip
    heard = lamp_of.hear((1, 0, copy), {1: ends(*a, turned=looks), 0: ends(*b, turned=back)}, 2.0, eye_of)
    way = np.array(b[copy]) - np.array(a[copy])
    d = float(np.linalg.norm(way))
    axes = [Rotation.from_quat(np.roll(q, -1)).apply([1.0, 0, 0]) for q in (looks[copy], back[copy])]
    lamp, eye = float(axes[0] @ way) / d, -float(axes[1] @ way) / d
    m = math.log(0.5) / math.log(math.cos(math.radians(25.0)))
    power = 1.7 * (m + 1) / (2 * math.pi * d * d) * lamp**m * 6e-4 * eye * math.exp(-WATER.attenuation[channel] * d)
    current = 0.35 * power
    over = b[copy][2] - (LEVELS[copy] + 0.01 * b[copy][0] - 0.02 * b[copy][1])  # the waves there
    day = 1000.0 * max(math.sin(sun), 0.0) * math.exp(WATER.downwelling[channel] * over)
    background = 0.35 * day * 0.03 * 6e-4 * math.sin(math.radians(50.0)) ** 2

    def noise(amperes: float) -> float:
        return (2 * 1.602176634e-19 * (amperes + 1e-9) + 4 * 1.380649e-23 * 290 / 1000.0) * 2e5

    excess = noise(current + background) / noise(0.0)
    assert heard.lost == ""
    assert heard.level_db == pytest.approx(20 * math.log10(current) - 10 * math.log10(excess), abs=1e-6)
    assert eye_of.noise() == pytest.approx(10 * math.log10(noise(0.0)), abs=1e-9)
    assert heard.delay_s == pytest.approx(d * 1.34 / 299_792_458.0)
    ((_, _, reach, of_copy, own),) = world.casts
    assert (reach, of_copy, own) == (pytest.approx(d - 1.5), copy, 80 + copy)


def test_why_no_light_comes() -> None:
    """Either end in the air, a lamp that looks away, a receiver that looks 51 instead of 49 degrees past it, a wall."""
    dry, wet = [0.0, 0, -0.2], [12.0, 0, -0.9]
    ahead, back = quaternion(0, 0, 0), quaternion(180, 0, 0)
    for pair in ((dry, wet), (wet, dry)):
        poses = {0: ends(pair[0], turned=[ahead]), 1: ends(pair[1], turned=[back])}
        assert lost(light(Around()), (0, 1, 0), poses) == "in air"

    def why(lamp: float, eye: float, *, stands: bool = False, distance: float = 12.0) -> str:
        poses = {0: ends([0.0, 0, -5], turned=[quaternion(lamp, 0, 0)]),
                 1: ends([distance, 0, -5], turned=[quaternion(180.0 + eye, 0, 0)])}  # fmt: skip
        return lost(light(Around(stands=stands)), (0, 1, 0), poses)

    assert [why(0, 0), why(89, 0), why(91, 0), why(0, 49), why(0, -51)] == ["", "", "out of beam", "", "out of beam"]
    assert [why(0, 0, stands=True), why(0, 0, stands=True, distance=2.9)] == ["blocked", ""]


def test_reports_come_as_often_as_the_speed_says() -> None:
    """ITU-R M.1371-5, Annex 1, Tables 1 and 2: up to and including 14 and 23 kn, and 2 kn."""
    assert [reporting_interval(v, "A") for v in (14.0, 14.1, 23.0, 23.1)] == [10.0, 6.0, 6.0, 2.0]
    assert [reporting_interval(v, "B") for v in (2.0, 2.1)] == [180.0, 30.0]


@pytest.mark.parametrize(("ais_class", "knots", "pause", "every"), [
    ("A", 8.7, 10.0, 36), ("A", 17.0, 6.0, 60), ("A", 26.0, 2.0, 180), ("B", 1.0, 180.0, 2), ("B", 12.0, 30.0, 12),
])  # fmt: skip
def test_positions_and_every_six_minutes_static_data(ais_class: Any, knots: float, pause: float, every: int) -> None:
    """Of the asked copy: place, course by its velocity, heading by its bow, not its antenna; channels in turn."""
    import pyais

    config = AisConfig(
        ais_class=ais_class, name="otter", length_m=13, beam_m=4, ship_type=52, orientation_deg=(0, 0, 50)
    )
    context = SensorContext.alone("a.ais")
    ais = Ais(config, context)
    told = {"A": 359.97, "B": 213.4}[ais_class]  # of the compass
    yaw, course = math.radians(31.0), math.radians(told)
    speed = knots * 1852 / 3600
    body = Rotation.from_euler("ZYX", [-yaw, math.radians(3.0), math.radians(-8.0)])
    antenna = (body * Rotation.from_euler("Z", 50.0, degrees=True)).as_quat()[[3, 0, 1, 2]]
    pose: Any = SimpleNamespace(
        position=np.array([[9e3, 9e3, 0], [-41e3, 26e3, 3.0]]), attitude=np.array([[1.0, 0, 0, 0], antenna]),
        velocity=np.array([[99.0, 9.0, 0.0], [speed * math.cos(course), -speed * math.sin(course), 3.0]]),
    )  # fmt: skip
    port: Any = SimpleNamespace(mmsi=211_000_007)
    place = context.world.origin.to_geodetic(pose.position[1:])[0]
    static = []
    for count in (0, 1, every - 1, every, 2 * every, 2 * every + 1, 23, 180):
        said, wait = ais._report(port, pose, 1, count)
        lines = said.decode().split("\n")
        assert wait == pause
        assert {line.split(",")[4] for line in lines} == {"AB"[count % 2]}
        messages = (
            [pyais.decode(line).asdict() for line in lines] if ais_class == "B" else [pyais.decode(*lines).asdict()]
        )
        assert {m["mmsi"] for m in messages} == {211_000_007}
        if len(lines) > 1 and ais_class == "A":
            assert {line.split(",")[3] for line in lines} == {str(count % 10)}
        if messages[0]["msg_type"] in (5, 24):
            static.append(count)
            named = {k: v for m in messages for k, v in m.items()}
            assert (named["to_bow"], named["to_stern"], named["to_port"], named["to_starboard"]) == (6, 7, 2, 2)
            assert (named["shipname"].rstrip("@ "), named["ship_type"]) == ("OTTER", 52)
        else:
            (m,) = messages
            assert m["msg_type"] == {"A": 1, "B": 18}[ais_class]
            assert (m["lat"], m["lon"]) == (pytest.approx(place[0], abs=2e-6), pytest.approx(place[1], abs=2e-6))
            assert m["speed"] == pytest.approx(knots, abs=1e-9)
            assert (m["course"], m["heading"], m["second"]) == (round(told, 1) % 360, 31, 60)
    assert static == [k for k in (0, 1, every - 1, every, 2 * every, 2 * every + 1, 23, 180) if k % every == 0]


@pytest.mark.parametrize(
    ("keys", "noise", "power"), [({"ais_class": "A"}, -119.0, 41.0), ({"ais_class": "B"}, -119.0, 33.0)]
)
def test_a_transponder_sends_with_the_power_of_its_class(keys: dict[str, Any], noise: float, power: float) -> None:
    """12.5 W and 2 W over 1 mW: 41 and 33 dB."""
    added: list[Any] = []
    medium: Any = SimpleNamespace(add=lambda port, context: added.append(port))
    Ais(AisConfig(mmsi=211_000_009, address=5, **keys), replace(SensorContext.alone("a.ais"), medium=medium))
    (port,) = added
    assert (port.carrier.power_dbm, port.carrier.noise_dbm, port.carrier.frequency) == (power, noise, 162e6)
    assert (port.mmsi, port.address, port.packet_max_bytes, port.queue, port.kind) == (
        211_000_009,
        5,
        1024,
        16,
        "radio",
    )
    assert 10 * math.log10({41.0: 12.5e3, 33.0: 2e3}[power]) == pytest.approx(power, abs=0.05)
