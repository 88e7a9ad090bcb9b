"""LCM messages of HoloOcean's sensors, read with classes that `lcm-gen` makes of their definitions."""

import sys

import numpy as np
import pytest
from holoocean_env import agent, opened

from pelagos.compat.holoocean.lcm import gen

lcm = pytest.importorskip("lcm")
pytestmark = pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")
SMALL = {
    "ImagingSonar": {"RangeBins": 32, "AzimuthBins": 16}, "RGBCamera": {"CaptureWidth": 16, "CaptureHeight": 24},
    "RangeFinderSensor": {"LaserCount": 5}, "DVLSensor": {"ReturnRange": False}, "IMUSensor": {},
    "GPSSensor": {}, "LocationSensor": {}, "VelocitySensor": {}, "RotationSensor": {}, "OrientationSensor": {},
    "PoseSensor": {}, "DepthSensor": {},
}  # fmt: skip


@pytest.fixture(scope="module")
def classes(tmp_path_factory):
    """The generated classes, by type."""
    folder = tmp_path_factory.mktemp("lcm")
    gen("python", str(folder))
    kept = {name: sys.modules.pop(name) for name in list(sys.modules) if name == "lcm" or name.startswith("lcm.")}
    sys.path.insert(0, str(folder))
    import lcm as made

    found = {name: getattr(made, name) for name in (*SMALL, "AcousticBeaconSensor")}
    sys.path.remove(str(folder))
    for name in [n for n in sys.modules if n == "lcm" or n.startswith("lcm.")]:
        del sys.modules[name]
    sys.modules.update(kept)
    return found


def written(log, *agents, ticks, before=lambda env: None):
    """Events of a log, by channel, and the last state."""
    with opened(*agents, lcm_provider=f"file://{log}?mode=w", ticks_per_sec=25) as env:
        before(env)
        for _ in range(ticks):
            state = env.tick()
    found = {}
    for event in lcm.EventLog(str(log), "r"):
        found.setdefault(event.channel, []).append(event.data)
    return found, state


@pytest.mark.parametrize("kind", SMALL)
def test_every_tick_gives_a_message(kind, classes, tmp_path):
    sensor = {"sensor_type": kind, "lcm_channel": "CH", "configuration": dict(SMALL[kind])}
    found, state = written(tmp_path / "log", agent("HoveringAUV", [sensor], location=(10, 10, -1)), ticks=50)
    assert len(found["CH"]) == 50
    messages = [classes[kind].decode(data) for data in found["CH"]]
    assert [m.timestamp for m in messages] == [40 * (i + 1) for i in range(50)]  # after the count of ticks
    last, value = messages[-1], state[kind]
    if kind == "DVLSensor":
        np.testing.assert_allclose(last.velocity, value[:3])
        assert np.isnan(last.range).all()
    elif kind == "IMUSensor":
        np.testing.assert_allclose([last.acceleration, last.angular_velocity], value)
        assert np.isnan([last.acceleration_bias, last.angular_velocity_bias]).all()
    elif kind == "RotationSensor":
        np.testing.assert_allclose([last.roll, last.pitch, last.yaw], value)
    elif kind == "RangeFinderSensor":
        assert last.count == 5
        np.testing.assert_allclose(last.distances, value)
        np.testing.assert_allclose(last.angles, [0, 72, 144, 216, 288])
    elif kind in ("ImagingSonar", "RGBCamera"):
        np.testing.assert_allclose(last.image, value)
    else:
        name = {"DepthSensor": "depth", "VelocitySensor": "velocity"}.get(kind)
        name = name or ("matrix" if kind in ("OrientationSensor", "PoseSensor") else "position")
        np.testing.assert_allclose(np.ravel(getattr(last, name)), np.ravel(value))


@pytest.mark.parametrize(
    ("kind", "known"),
    [("OWAY", ""), ("OWAYU", "azimuth elevation"), ("MSG_REQ", ""), ("MSG_REQU", "azimuth elevation"),
     ("MSG_REQX", "azimuth elevation z")],
)  # fmt: skip
def test_a_beacon_tells_what_its_message_has(kind, known, classes, tmp_path):
    def beacon(number, x):
        sensor = {"sensor_type": "AcousticBeaconSensor", "lcm_channel": f"B{number}", "configuration": {"id": number}}
        return agent("SphereAgent", [sensor], name=f"a{number}", location=(x, 2 * x, 60 - x))

    found, _ = written(
        tmp_path / "log", beacon(0, 0), beacon(1, 20), ticks=5,
        before=lambda env: env.send_acoustic_message(0, 1, kind, "data"),
    )  # fmt: skip
    message = classes["AcousticBeaconSensor"].decode(found["B1"][0])
    assert (message.msg_type, message.from_beacon) == (kind, 0)
    for name in ("azimuth", "elevation", "range", "z"):
        assert np.isnan(getattr(message, name)) == (name not in known.split())
