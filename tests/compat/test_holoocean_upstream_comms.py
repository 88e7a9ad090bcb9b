"""What HoloOcean's own tests ask of beacons and optical modems, written anew from their descriptions."""

import math

import numpy as np
import pytest
from holoocean_env import agent, opened

pytestmark = pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")


def station(number, name, location, kind="AcousticBeaconSensor", rotation=(0, 0, 0), **keys):
    sensor = {"sensor_type": kind, "configuration": {"id": number, **keys}}
    return agent("SphereAgent", [sensor], name=name, location=location, rotation=list(rotation))


def pair(one, other, kind="AcousticBeaconSensor", turns=((0, 0, 0), (0, 0, 0)), **keys):
    return opened(
        station(0, "a0", one, kind, turns[0], **keys), station(1, "a1", other, kind, turns[1], **keys), ticks_per_sec=30
    )


def heard(env, name, ticks, kind="AcousticBeaconSensor"):
    """Messages of an agent, by the tick at which they came."""
    found = {}
    for i in range(ticks):
        state = env.tick()
        if kind in state[name]:
            found[i] = state[name][kind]
    return found


FREE = (0, 0, 60), (120, -40, 90)


def far(one=FREE[0], other=FREE[1]):
    return math.dist(one, other)


@pytest.mark.parametrize("kind", ["OWAY", "OWAYU", "MSG_REQ", "MSG_REQU", "MSG_REQX"])
def test_a_message_and_its_answer_come_after_the_time_of_sound(kind):
    delay = round(far() * 30 / 1500)
    with pair(*FREE) as env:
        env.send_acoustic_message(0, 1, kind, "data")
        assert env.beacons_status == ["Transmitting", "Idle"]
        there = heard(env, "a1", delay + 1)
        assert list(there) == [delay]
        message = there[delay]
        assert message[:3] == [kind, 0, "data"]
        line = np.subtract(FREE[0], FREE[1])
        if kind in ("OWAYU", "MSG_REQU", "MSG_REQX"):
            assert message[3] == pytest.approx(math.atan2(line[1], line[0]), abs=1e-6)
            assert message[4] == pytest.approx(math.atan2(line[2], math.hypot(line[0], line[1])), abs=1e-6)
        if kind.startswith("MSG_REQ"):
            back = heard(env, "a0", delay + 3)
            assert len(back) == 1
            answer = next(iter(back.values()))
            assert answer[:3] == [kind.replace("REQ", "RESP"), 1, None]
            if kind != "MSG_REQ":
                assert answer[5] == pytest.approx(far(), rel=1e-6)
                assert len(answer) == (6 if kind == "MSG_REQU" else 7)
        assert env.beacons_status == ["Idle", "Idle"]


def test_several_are_addressed_by_a_list_or_all():
    three = [station(i, f"a{i}", (30 * i, 0, 60)) for i in range(3)]
    for to in ([1, 2], -1, "all"):
        with opened(*three, ticks_per_sec=30) as env:
            env.send_acoustic_message(0, to, "OWAY", 7)
            names = set()
            for _ in range(5):
                state = env.tick()
                names |= {name for name in ("a0", "a1", "a2") if "AcousticBeaconSensor" in state[name]}
            assert names == {"a1", "a2"}


def test_two_at_once_are_lost():
    with pair(*FREE) as env:
        env.send_acoustic_message(0, 1, "OWAY", 1)
        env.send_acoustic_message(1, 0, "OWAY", 2)
        for _ in range(10):
            state = env.tick()
            assert "AcousticBeaconSensor" not in state["a0"]
            assert "AcousticBeaconSensor" not in state["a1"]
        assert env.beacons_status == ["Idle", "Idle"]


def test_bearings_are_those_of_the_receivers_frame():
    with pair((0, 0, 60), (30, 0, 60), turns=((0, 0, 0), (0, 0, 90))) as env:
        env.send_acoustic_message(0, 1, "OWAYU", "")
        azimuth = next(iter(heard(env, "a1", 5).values()))[3]
        assert azimuth == pytest.approx(math.pi / 2)  # astern of a bow that points to +y: to the left
    with pair((0, 0, 60), (0, 0, 90)) as env:
        env.send_acoustic_message(0, 1, "OWAYU", "")
        assert next(iter(heard(env, "a1", 5).values()))[4] == pytest.approx(-math.pi / 2)


@pytest.mark.parametrize(("most", "there"), [(100, False), (200, True)])
def test_a_greatest_distance(most, there):
    with pair(*FREE, MaxDistance=most) as env:
        env.send_acoustic_message(0, 1, "OWAY", "")
        assert bool(heard(env, "a1", 10)) is there


def test_a_wall_between_is_in_the_way_where_it_counts():
    for visible, there in ((True, False), (False, True)):
        with pair((10, -30, 0.1), (-6.5, -30, 0.1), CheckVisible=visible) as env:
            env.send_acoustic_message(0, 1, "OWAY", "")
            assert bool(heard(env, "a1", 5)) is there
    with pair(*FREE, CheckVisible=True) as env:
        env.send_acoustic_message(0, 1, "OWAY", "")
        assert heard(env, "a1", 10)


def some(env, send, name, kind, count=40):
    got = 0
    for _ in range(count):
        send(env)
        got += bool(heard(env, name, 3, kind))
    return got, count


def test_a_noisy_distance_lets_some_messages_through():
    with pair((0, 0, 60), (20, 0, 60), MaxDistance=20, DistanceSigma=5) as env:
        got, count = some(env, lambda e: e.send_acoustic_message(0, 1, "OWAY", ""), "a1", "AcousticBeaconSensor")
    assert 0 < got < count


MODEM = "OpticalModemSensor"
FACING = ((0, 0, 0), (0, 0, 180))


def seen(one, other, turns=FACING, **keys):
    with pair(one, other, MODEM, turns, **keys) as env:
        env.send_optical_message(0, 1, "light")
        return heard(env, "a1", 3, MODEM)


def test_modems_that_face_each_other_talk_at_the_next_tick():
    assert seen((0, 0, 60), (20, 0, 60)) == {0: "light"}
    assert seen((-10, 10, 0.25), (-10, 7, 0.25), ((0, 0, -90), (0, 0, 90))) == {0: "light"}


@pytest.mark.parametrize(
    ("one", "other", "turns", "keys"),
    [
        ((0, 0, 60), (60, 0, 60), FACING, {}),  # beyond 50 m
        ((0, 0, 60), (20, 0, 60), FACING, {"MaxDistance": 10}),
        ((0, 0, 60), (20, 0, 60), ((0, 0, 90), (0, 0, 180)), {}),  # looks aside
        ((0, 0, 60), (20, 0, 60), ((0, 0, 0), (0, 0, 0)), {}),  # does not look back
        ((10, -30, 0.1), (-6.5, -30, 0.1), ((0, 0, 180), (0, 0, 0)), {}),  # a wall
    ],
)
def test_distance_direction_and_walls_block(one, other, turns, keys):
    assert seen(one, other, turns, **keys) == {}


@pytest.mark.parametrize(
    "keys", [{"MaxDistance": 20, "DistanceSigma": 5}, {"LaserAngle": 20, "AngleSigma": 10}], ids=["distance", "angle"]
)
def test_a_noisy_gate_lets_some_messages_through(keys):
    turns = ((0, 0, 20), (0, 0, 200)) if "LaserAngle" in keys else FACING
    with pair((0, 0, 60), (20, 0, 60), MODEM, turns, **keys) as env:
        got, count = some(env, lambda e: e.send_optical_message(0, 1, ""), "a1", MODEM)
    assert 0 < got < count
