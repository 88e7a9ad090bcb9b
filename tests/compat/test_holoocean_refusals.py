"""What HoloOcean's interface refuses, what it only warns of, and the other side of each limit."""

import json
import math
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from holoocean_env import agent, opened
from scipy.spatial.transform import Rotation

import pelagos.compat.holoocean as holoocean
from pelagos.compat.holoocean import command, importing, joint_constraints, lcm, octrees, packagemanager, settings, util
from pelagos.compat.holoocean.advice import Advice, HoloOceanWarning
from pelagos.compat.holoocean.agents import AgentDefinition, AgentFactory
from pelagos.compat.holoocean.bst_graph import BST_Visualizer
from pelagos.compat.holoocean.building import build, hand_over
from pelagos.compat.holoocean.convert import _Unbuilt, converted
from pelagos.compat.holoocean.environments import HoloOceanEnvironment
from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException, HoloOceanException, three
from pelagos.compat.holoocean.flashlight import FlashlightController
from pelagos.compat.holoocean.fossen_dynamics import FossenInterface, changes
from pelagos.compat.holoocean.holooceanclient import HoloOceanClient
from pelagos.compat.holoocean.native_scenario import native_scenario, native_sensor, waves_of
from pelagos.compat.holoocean.noise import Normal
from pelagos.compat.holoocean.sensors import SensorDefinition, SensorFactory
from pelagos.compat.holoocean.shmem import Shmem
from pelagos.compat.holoocean.spaces import ContinuousActionSpace, DiscreteActionSpace
from pelagos.compat.holoocean.tides import TideController, cycle_of
from pelagos.compat.holoocean.time_cycle import TimeController
from pelagos.errors import InputError

LOCATION = {"sensor_type": "LocationSensor"}


def unbuilt(*sensors, kind="HoveringAUV", more=(), **keys):
    """An environment without a simulation."""
    agents = [agent(kind, sensors), *more]
    return _Unbuilt(scenario={"name": "t", "world": "TestWorld", "ticks_per_sec": 60, "agents": agents, **keys}, seed=1)


def sensor(kind, /, beside=None, **configuration):
    return {"sensor_type": kind, "configuration": configuration, **(beside or {})}


@pytest.fixture(scope="module")
def still():
    """An environment without a simulation, which scripts may ask for anything."""
    stations = [sensor("AcousticBeaconSensor", id=3), sensor("OpticalModemSensor", id=4)]
    fields = sensor("BSTSensor")
    return unbuilt(*stations, fields, more=[agent("BlueROV2", [LOCATION], name="auv1")])


SONAR = {"RangeMax": 10.0}
BOTH = {"GoalActor": "auv0", "GoalLocation": [1, 2, 3]}
SENSORS = {
    "no type": ({"sensor_name": "x"}, HoloOceanException, "agent auv0: a sensor has no sensor_type"),
    "Hz": ({**LOCATION, "Hz": 0}, ValueError, "auv0.LocationSensor: Hz is above zero, not 0"),
    "Hz below": ({**LOCATION, "Hz": -2}, ValueError, "Hz is above zero, not -2"),
    "bins": (
        sensor("ImagingSonar", **SONAR, RangeBins=20, RangeRes=0.1),
        ValueError,
        "RangeBins or RangeRes, not both",
    ),
    "noise": (sensor("ImagingSonar", **SONAR, AddSigma=0, AddCov=0), ValueError, "AddSigma or AddCov, not both"),
    "spread": (sensor("ImagingSonar", **SONAR, MultSigma=1, MultCov=1), ValueError, "MultSigma or MultCov, not both"),
    "physics": (sensor("ImagingSonar", physics="real"), HoloOceanConfigurationException, "'holoocean', not 'real'"),
    "tags": (
        sensor("SemanticRaycastSinglebeamSonar", UseTags=True, UseIds=True),
        HoloOceanConfigurationException,
        "either UseTags or UseIds",
    ),
    "hands": (sensor("PressureSensor"), HoloOceanConfigurationException, "PressureSensor is for AndroidAgent"),
    "joints": (
        sensor("JointRotationSensor"),
        HoloOceanConfigurationException,
        "JointRotationSensor is for AndroidAgent",
    ),
    "goal": (sensor("DistanceTask", **BOTH), HoloOceanConfigurationException, "DistanceTask: give either GoalActor or"),
    "interval": (sensor("DistanceTask", Interval=0), HoloOceanConfigurationException, "Interval is above 0, not 0"),
    "reach": (
        sensor("AvoidTask", ToAvoid="auv0", MinDistance=0),
        HoloOceanConfigurationException,
        "MinDistance is above 0, not 0",
    ),
    "channel": ({"sensor_type": "CollisionSensor", "lcm_channel": "A"}, KeyError, "CollisionSensor has no LCM message"),
}


@pytest.mark.parametrize("case", SENSORS)
def test_a_sensor_that_cannot_be_is_refused(case):
    given, kind, words = SENSORS[case]
    with pytest.raises(kind, match=words):
        unbuilt(given)


@pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")
@pytest.mark.parametrize(
    "given",
    [
        {**LOCATION, "Hz": 1e-3},
        sensor("ImagingSonar", **SONAR, RangeBins=20, AzimuthRes=1.0, AddSigma=0.1, MultCov=0.1, physics="pelagos"),
        sensor("SemanticRaycastSinglebeamSonar", UseTags=True, UseIds=False),
        sensor("SemanticRaycastSinglebeamSonar", UseTags=False, UseIds=True),
        sensor("DistanceTask", GoalActor="auv0", Interval=1e-3),
        sensor("LocationTask", GoalLocation=[1, 2, 3]),
        sensor("AvoidTask", ToAvoid="auv0", MinDistance=1e-3),
    ],
)
def test_one_on_the_other_side_of_the_limit_is_not(given):
    assert list(unbuilt(given).agents["auv0"].sensors) == [given["sensor_type"]]


@pytest.mark.parametrize(
    ("kind", "configuration", "words"),
    [
        ("ImagingSonar", {"InitOctreeRange": 5}, "InitOctreeRange: no octree is needed"),
        ("ImagingSonar", {"WaterSoundSpeed": 1490}, "taken as WaterSpeedSound"),
        ("ImagingSonar", {"ClusterSize": 4}, "ClusterSize changes nothing: reflections are traced"),
        (
            "ImagingSonar",
            {"physics": "holoocean", "ClusterSize": 4, "MultiPath": True},
            "ClusterSize, MultiPath: the simp",
        ),
        ("RaycastLidar", {"ShowDebugPoints": True}, "ShowDebugPoints draws nothing here"),
        ("LocationSensor", {"socket": "IMUSocket"}, "'socket' belongs beside 'configuration'"),
        ("LocationSensor", {"Cov": [[1, 2, 0], [2, 1, 0], [0, 0, 1]]}, "Cov is not positive definite"),
    ],
)
def test_what_changes_nothing_is_told_of_and_only_that(kind, configuration, words):
    with pytest.warns(HoloOceanWarning) as said:
        unbuilt(sensor(kind, {"Hz": 1}, **configuration))
    assert [words in str(w.message) for w in said] == [True]


def test_a_sonar_without_such_keys_and_a_lidar_are_quiet(recwarn):
    env = unbuilt(sensor("ImagingSonar", {"Hz": 1}, MultiPath=True, ClusterSize=0), sensor("RaycastLidar", {"Hz": 1}))
    assert not recwarn.list
    assert env.agents["auv0"].sensors["ImagingSonar"].speed is None
    both = unbuilt(sensor("ImagingSonar", {"Hz": 1}, WaterSpeedSound=1500))
    assert both.agents["auv0"].sensors["ImagingSonar"].speed == 1500.0


def test_names_and_numbers_of_stations_are_given_once():
    with pytest.raises(HoloOceanException, match="auv0: two sensors are called 'LocationSensor'; give"):
        unbuilt(LOCATION, {**LOCATION, "sensor_name": "other"}, LOCATION)
    twice = [sensor("AcousticBeaconSensor", {"sensor_name": str(k)}, id=2) for k in range(2)]
    with pytest.raises(HoloOceanConfigurationException, match="two AcousticBeaconSensor have the id 2"):
        unbuilt(*twice)
    env = unbuilt(twice[0], sensor("OpticalModemSensor", id=2), {**LOCATION, "sensor_name": "other"}, LOCATION)
    assert (env.beacons_id, env.modems_id) == ([2], [2])


@pytest.mark.parametrize("given", [[1, 2], [1, 2, 3, 4], ["a", "b", "c"], [1, [2], 3], None, [1, 2, math.inf]])
def test_three_numbers_and_no_others(given):
    assert three("it", (1, -2, 3)) == [1.0, -2.0, 3.0]
    with pytest.raises(HoloOceanConfigurationException, match="it is three finite numbers, not "):
        three("it", given)


# environments


@pytest.mark.parametrize("tps", [0, -30, math.nan, 12.5, "30", math.inf])
def test_ticks_are_whole_and_above_zero(tps, still):
    for ask in (
        lambda: _Unbuilt(scenario={"world": "TestWorld", "agents": []}, ticks_per_sec=tps, seed=1),
        lambda: unbuilt(ticks_per_sec=tps),
        lambda: still.set_ticks_per_sec(tps),
    ):
        with pytest.raises(HoloOceanException, match=f"ticks_per_sec is a whole number above zero, not {tps!r}"):
            ask()
    assert still._ticks_per_sec == 60


def test_ticks_are_those_of_the_first_who_says():
    scenario = {"world": "TestWorld", "agents": [], "ticks_per_sec": 20.0}
    assert _Unbuilt(scenario=dict(scenario), seed=1)._ticks_per_sec == 20
    assert _Unbuilt(scenario=dict(scenario), seed=1, set_tps=40)._ticks_per_sec == 40
    env = _Unbuilt(scenario=dict(scenario), seed=1, set_tps=40, ticks_per_sec=1)
    assert env._ticks_per_sec == 1
    env.set_ticks_per_sec(7)
    env.set_fps(5)
    assert (env._ticks_per_sec, env._frames_per_sec) == (7, 5)


def test_an_environment_needs_a_scenario_by_name_or_itself(tmp_path, monkeypatch):
    with pytest.raises(HoloOceanException, match=r"an environment needs a scenario: holoocean\.make"):
        HoloOceanEnvironment()
    with pytest.raises(HoloOceanException, match="make needs the name of a scenario, or scenario_cfg"):
        holoocean.make()
    (tmp_path / "list.json").write_text("[1]")
    with pytest.raises(HoloOceanException, match=r"list\.json: a scenario is a mapping, not a list"):
        packagemanager.load_scenario_file(tmp_path / "list.json")
    monkeypatch.setattr("pelagos.compat.holoocean.making.HoloOceanEnvironment", lambda scenario, **keys: scenario)
    named = holoocean.make("Dam-Hovering", scenario_cfg={"world": "Other"})
    assert (named["world"], named["name"]) == ("Dam", "Hovering")


@pytest.mark.parametrize("seed", ["-1", "1.5", "x"])
def test_a_seed_of_the_command_line_is_whole(seed, monkeypatch):
    monkeypatch.setenv(settings.SEED, seed)
    with pytest.raises(InputError, match=f"{settings.SEED} is a whole number from 0 on, not '{seed}'"):
        settings.settings()
    monkeypatch.setenv(settings.SEED, "0")
    assert settings.settings().seed == 0


ASKED = {
    "weather": (lambda e: e.change_weather(3), HoloOceanException, "a weather is 0 .* not 3"),
    "controller": (lambda e: e.weather.__class__(e, -1), HoloOceanException, "a weather is 0 .* not -1"),
    "collisions": (lambda e: e.enable_world_collisions(False), HoloOceanException, "cannot be switched off"),
    "command": (lambda e: e.send_world_command("Flood"), HoloOceanException, "the world knows no command 'Flood'"),
    "material": (
        lambda e: e.spawn_prop("box", material="gould"),
        HoloOceanException,
        "not 'gould' .did you mean 'gold'",
    ),
    "drawing": (lambda e: e.draw_line([0, 0, 0], [1, 1]), HoloOceanException, r"end of a drawing is three .* \[1, 1\]"),
    "agent": (
        lambda e: e.add_agent(AgentDefinition("auv1", "BlueROV2")),
        HoloOceanException,
        "an agent 'auv1' already",
    ),
    "action": (
        lambda e: e.act("auv0", [1, np.nan]),
        HoloOceanException,
        r"auv0: an action must be finite; given \[1.0, nan",
    ),
    "joints": (lambda e: e.get_joint_constraints("auv", "j"), KeyError, "no agent 'auv' .did you mean 'auv1'.*auv0"),
    "lamp": (
        lambda e: e.turn_on_flashlight("flashlight5"),
        HoloOceanException,
        "one of flashlight1, .*, not 'flashlight5'",
    ),
    "lamp off": (lambda e: e.turn_off_flashlight("lamp"), HoloOceanException, "not 'lamp'"),
    "lamp only": (lambda e: e.turn_on_flashlight("auv0"), HoloOceanException, "not 'auv0'"),
    "lamp key": (
        lambda e: e.turn_on_flashlight("flashlight1", color_G=1, colour_R=1),
        TypeError,
        "no 'colour_R'.*color_R",
    ),
    "lamp numbers": (
        lambda e: e.turn_on_flashlight("flashlight1", *range(11)),
        TypeError,
        "has 10 numbers, .*; 11 given",
    ),
    "lamp agent": (lambda e: e.turn_on_flashlight("flashlight1", agent_tag="auv2"), KeyError, "no agent 'auv2'"),
    "lamp first": (lambda e: e.turn_off_flashlight("flashlight1", "auv2"), KeyError, "no agent 'auv2'"),
    "setter": (lambda e: FlashlightController(e).set_colour_R, AttributeError, "no 'set_colour_R'.*set_color_R"),
    "controller key": (lambda e: FlashlightController(e, beam=1), TypeError, "a flashlight has no 'beam'"),
    "message": (
        lambda e: e.send_acoustic_message(3, 3, "TWOWAY", 1),
        ValueError,
        "'TWOWAY' is no type of .* OWAY, OWAYU",
    ),
    "sea": (lambda e: e.fft_sea_state(10), HoloOceanException, "a sea state is 0 to 9, not 10"),
    "sea below": (lambda e: e.fft_sea_state(-1), HoloOceanException, "a sea state is 0 to 9, not -1"),
    "sea between": (lambda e: e.fft_sea_state(3.5), HoloOceanException, "a sea state is 0 to 9, not 3.5"),
    "wind": (
        lambda e: e.fft_wave_scalars({"WindSpeed": -1}),
        HoloOceanException,
        "wind of waves is 0 m/s or more, not -1",
    ),
    "tide": (
        lambda e: e.tide_cycle.set_frequency(0),
        HoloOceanException,
        "period of a tide is above zero ticks, not 0",
    ),
    "tide type": (lambda e: e.tide_cycle.set_tide_type("TideFreaky"), HoloOceanException, "only, not 'TideFreaky'"),
    "tide made": (lambda e: TideController(e, tide_type="Freaky"), HoloOceanException, "only, not 'Freaky'"),
    "tide on": (lambda e: TideController(e, 1, 0).set_active(True), HoloOceanException, "above zero ticks, not 0"),
    "day": (lambda e: e.time_cycle.set_frequency(-1), HoloOceanException, "a day has 0 ticks or more, not -1"),
    "ticks": (lambda e: beacon(e).set_ticks_per_capture(0), HoloOceanConfigurationException, "from 1 on, not 0"),
    "ticks of": (lambda e: beacon(e).set_ticks_per_capture(2.0), HoloOceanConfigurationException, "from 1 on, not 2.0"),
    "ticks so": (
        lambda e: beacon(e).set_ticks_per_capture(True),
        HoloOceanConfigurationException,
        "from 1 on, not True",
    ),
    "turn": (
        lambda e: beacon(e).rotate([1, 2]),
        HoloOceanConfigurationException,
        "auv0.AcousticBeaconSensor: a rotation is",
    ),
}


def beacon(env):
    return env.agents["auv0"].sensors["AcousticBeaconSensor"]


@pytest.mark.parametrize("case", ASKED)
def test_what_a_script_may_not_ask_for(case, still):
    ask, kind, words = ASKED[case]
    still._stale, before = False, json.dumps(still._scenario)
    with pytest.raises(kind, match=words):
        ask(still)
    assert not still._stale
    assert json.dumps(still._scenario) == before
    assert not still._lit
    assert beacon(still).status == "Idle"


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"weather": {"type": 3}}, "a weather is 0 .sunny.* not 3"),
        ({"tide_cycle": {"active": True, "frequency": 0}}, "period of a tide is above zero ticks, not 0"),
        ({"tide": {"amplitude": 1, "period": -2}}, "period of a tide is above zero ticks, not -120.0"),
        ({"time_cycle": {"frequency": -3}}, "a day has 0 ticks or more, not -3"),
        ({"flashlight": [{"flashlight_name": "lamp"}]}, "a flashlight is one of .* not 'lamp'"),
    ],
)
def test_surroundings_that_cannot_be(keys, words):
    with pytest.raises(HoloOceanException, match=words):
        unbuilt(**keys)


def test_a_tide_that_stands_still_needs_no_period():
    assert cycle_of({"tide_cycle": {"frequency": 0}}, 60) == (100.0, 0.0, False)
    assert cycle_of({"tide": {"amplitude": 1.5, "period": 2}}, 60) == (1.5, 120.0, True)
    assert cycle_of({"tide": {"amplitude": 1.5, "period": 2, "active": False}}, 60) == (1.5, 120.0, False)


def test_a_flashlight_of_an_agent_that_is_not_there_is_told_of():
    with pytest.warns(HoloOceanWarning, match="flashlight: agent_tag: there is no 'auv' .did you mean 'auv0'.*nothing"):
        unbuilt(flashlight=[{"agent_tag": "auv"}])
    env = unbuilt(flashlight=[{"agent_tag": "auv0", "intensity": 70}, {"flashlight_name": "flashlight2"}])
    assert [lamp["flux_lm"] for lamp in env.flashlights.native("auv0")] == [70, 5000]
    env.turn_on_flashlight("auv0", "flashlight1", 90)
    assert [lamp["flux_lm"] for lamp in env.flashlights.native("auv0")] == [90, 5000]
    assert env._lit == {"auv0"}
    env.turn_off_flashlight("flashlight1", "auv0")
    assert len(env.flashlights.native("auv0")) == 1


@pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")
@pytest.mark.parametrize("names", ["snake", "camel"])
def test_waves_that_were_asked_for_last_count_whatever_they_are_called(names):
    sea, speed, towards = ("sea_state", "wind_speed", "wind_direction")
    if names == "camel":
        sea, speed, towards = ("SeaState", "WindSpeed", "WindDirection")
    env = unbuilt(fft_waves={sea: 3, speed: 2.0, towards: 30.0})
    env.fft_sea_state(9)
    found = waves_of(env._scenario["fft_waves"])
    assert (found["wind"]["speed_mps"], found["waves"][0]["towards_deg"]) == (30.0, 240.0)
    env._stale = False
    env.fft_wave_scalars({"WindSpeed": 12.0, "Choppiness": 0.3})
    found = waves_of(env._scenario["fft_waves"])
    assert (found["wind"]["speed_mps"], found["waves"][0]["towards_deg"], env._stale) == (12.0, 240.0, True)
    env.fft_wave_scalars({"wind_direction": -20.0})
    assert waves_of(env._scenario["fft_waves"])["wind"] == {"speed_mps": 12.0, "from_deg": 110.0}
    env.fft_sea_state(0)
    assert waves_of(env._scenario["fft_waves"]) == {}


def test_what_changes_nothing_of_the_surroundings_is_told_of(still):
    for ask, words in (
        (lambda: still.fft_wave_scalars({"Choppiness": 0.3}), "Choppiness: waves follow"),
        (lambda: still.fft_wave_cascades({}), "cascades change nothing"),
        (lambda: still.set_render_quality(3), "render quality changes nothing"),
    ):
        with pytest.warns(HoloOceanWarning, match=words):
            ask()
    still.enable_world_collisions(True)
    still.move_viewport([1, 2, 3], [4, 5, 6])
    still.should_render_viewport(0)
    assert [[*v] for v in still.viewport] == [[1, 2, 3], [4, 5, 6]]
    assert still.viewport_on is False


def test_no_wave_below_half_a_metre_a_second():
    assert waves_of({"wind_speed": 0.49}) == {} == waves_of({"wind_speed": 0})
    assert waves_of({"wind_speed": 0.5})["wind"]["speed_mps"] == 0.5


def test_the_day_goes_round_and_the_sun_moves_by_quarters_of_an_hour():
    shown = []
    day = TimeController(SimpleNamespace(change_time_of_day=shown.append), hour=7)
    day.tick(5)  # a day of 0 ticks stands still
    assert (day.get_time_of_day(), shown) == (7, [])
    day.set_frequency(480)  # 0.05 h a tick
    day.set_active(1)
    for tick in range(477, 487):
        day.tick(tick)
    assert day.active is True
    assert shown == pytest.approx([23.85, 0.0, 0.25])
    assert day.get_time_of_day() == pytest.approx(0.3)


# agents and sensors


def test_a_sensor_turns_by_the_engines_signs_and_reads_at_another_rate():
    """Pitch and yaw of `rotate` are opposite to those of the key `rotation`."""
    turned, keyed = (unbuilt(sensor("DVLSensor", {"rotation": r, "Hz": 20})) for r in ([0, 0, 0], [10, 20, 30]))
    one, other = (e.agents["auv0"].sensors["DVLSensor"] for e in (turned, keyed))
    turned._stale = False
    one.rotate([10, -20, -30])
    assert turned._stale is True
    np.testing.assert_allclose(one.turned, other.turned, atol=1e-12)
    assert native_sensor(turned, one) == native_sensor(keyed, other)
    turned._stale, one.tick_count = False, 2
    one.set_ticks_per_capture(1)
    assert (one.tick_every, one.tick_count, turned._stale) == (1, 0, True)
    still = unbuilt(LOCATION)
    still._stale = False
    still.agents["auv0"].sensors["LocationSensor"].rotate([1, 2, 3])  # has no native sensor
    assert still._stale is False


def test_agents_and_sensors_come_and_go():
    env = unbuilt(LOCATION, sensor("DVLSensor"), sensor("RGBCamera"))
    one, env._stale = env.agents["auv0"], False
    assert one.has_camera()
    assert repr(one) == "<HoveringAUV 'auv0'>"
    one.remove_sensors("RGBCamera")
    assert (list(one.sensors), one.has_camera(), env._stale) == (["LocationSensor", "DVLSensor"], False, True)
    one.remove_sensors([SensorDefinition("auv0", "HoveringAUV", "DVLSensor", "DVLSensor"), "LocationSensor"])
    assert list(one.sensors) == []
    one.add_sensors(SensorDefinition("auv0", "HoveringAUV", "view", "ViewportCapture"))
    assert one.has_camera()
    env._stale, env._legacy = False, True
    env.add_agent(AgentDefinition("auv1", "BlueROV2"))
    assert (list(env.agents), env._agent.name, env._stale) == (["auv0", "auv1"], "auv1", True)  # none was the main one
    assert env.agents["auv1"].definition.legacy is True
    env.spawn_agent(AgentDefinition("auv2", "BlueROV2"))
    assert env._agent.name == "auv1"
    env.add_agent(AgentDefinition("auv3", "SphereAgent"), is_main_agent=True)
    assert env._agent.name == "auv3"
    assert env.action_space.get_high() == env.agents["auv3"].action_space.get_high()
    assert env.get_joint_constraints("auv3", "j") is joint_constraints.get_joint_constraints("SphereAgent", "j") is None


def test_a_scheme_of_an_agent_that_is_not_there_is_only_told_of(still, capsys):
    still.set_control_scheme("auv", 1)
    assert capsys.readouterr().out == "No such agent auv\n"
    still.set_control_scheme("auv0", 1)
    assert [a.scheme for a in still.agents.values()] == [1, 0]


def test_states_that_are_no_copies_hold_everything_due_or_not():
    """Nested as those that are: by the agents of the last reset."""
    env = unbuilt(LOCATION, sensor("DepthSensor"), more=[agent("BlueROV2", [LOCATION], name="auv1")])
    env._copy_state, env._agent, env._values = False, env.agents["auv1"], lambda *_: {}
    for k, one in enumerate(s for a in env.agents.values() for s in a.sensors.values()):
        one.sensor_data = k
    env._flat = False
    assert env._state(None) == {"auv0": {"LocationSensor": 0, "DepthSensor": 1}, "auv1": {"LocationSensor": 2}}
    env._flat = True
    assert env._state(None) == {"LocationSensor": 2}
    env._agent = None
    assert env._state(None) == {}


def test_factories_make_what_definitions_say(still):
    made = AgentFactory.build_agent(still, AgentDefinition("a", "TorpedoAUV"))
    assert (made.name, made.kind.name) == ("a", "TorpedoAUV")
    one = SensorFactory.build_sensor(still, SensorDefinition("auv0", "HoveringAUV", "d", "DepthSensor"))
    assert (one.name, one.sensor_type) == ("d", "DepthSensor")
    one.sensor_data = 4
    assert one.idle() == 4


def test_spaces_draw_within_what_an_agent_may_be_told():
    assert ContinuousActionSpace([3], sample_fn=lambda: 7).sample() == 7
    drawn = np.stack([ContinuousActionSpace([4, 250]).sample() for _ in range(4)])
    assert abs(drawn.mean()) < 4 / np.sqrt(drawn.size)
    assert abs(drawn.var() - 1) < 4 * np.sqrt(2 / drawn.size)
    assert set(DiscreteActionSpace([400], 2, 5).sample().tolist()) == {2, 3, 4}


def test_stations_forget_and_a_beacon_that_transmits_takes_no_other(still, capsys):
    one, modem = beacon(still), still.agents["auv0"].sensors["OpticalModemSensor"]
    assert (still.modems, still.modems_id) == ({4: modem}, [4])
    for nobody in (-1, "all", []):  # there is no other beacon
        still.send_acoustic_message(3, nobody, "OWAY", 0)
        assert (still.beacons_status, still.media.flights) == (["Idle"], [])
    still.send_acoustic_message(3, 3, "OWAY", 1)
    assert still.beacons_status == ["Transmitting"]
    still.send_acoustic_message(3, 3, "OWAY", 2)
    assert capsys.readouterr().out == "Beacon 3 is still transmitting, so the message was not sent\n"
    assert [flight.data for flight in still.media.flights] == [1]
    for each in (one, modem):
        each.inbox.append("x")
        each.reset()
        assert each.inbox == []
    assert one.status == "Idle"
    still.media.clear()


def test_a_point_sees_itself_and_what_stands_in_the_same_place(still):
    assert still.__class__.sees(SimpleNamespace(pelagos=None), "a", [1, 2, 3], "b", [1, 2, 3.0005])
    env = unbuilt(sensor("AvoidTask", ToAvoid="auv0", OnlyWithinSight=True))
    env.motions = {"auv0": SimpleNamespace(position=np.ones(3), rotation=np.eye(3))}
    assert env.agents["auv0"].sensors["AvoidTask"].seen("auv0", "auv0")


def test_fields_of_a_bst_sensor_are_a_scripts_own(still):
    for name in ("salinity", "temperature", "biomass"):
        getattr(still, f"set_{name}_function")("auv0", name)
    fields = still.agents["auv0"].sensors["BSTSensor"].fields
    assert fields == {name: name for name in ("biomass", "salinity", "temperature")}
    env = unbuilt(sensor("BSTSensor"))
    one = env.agents["auv0"].sensors["BSTSensor"]
    one.fields = {
        "biomass": lambda location: 1 / 0,
        "salinity": lambda location: math.nan,
        "temperature": lambda location: [4],
    }
    motion = SimpleNamespace(position=np.zeros(3), rotation=np.eye(3))
    assert np.ravel(one.value(motion, None)).tolist() == [0, 0, 4]


def test_a_covariance_that_is_none_is_no_noise(recwarn):
    assert Normal({"Cov": [[1, 2], [2, 1]]}, "", 2).root is None
    assert not recwarn.list
    root = Normal({"Cov": [[4, 2], [2, 5]]}, "", 2).root
    np.testing.assert_allclose(root @ root.T, [[4, 2], [2, 5]])


def test_a_simulation_that_cannot_be_is_refused_in_holooceans_words():
    with pytest.raises(HoloOceanException, match=r"this scenario cannot be: .*range_m: must be .* -1"):
        build(unbuilt(sensor("RaycastLidar", Range=-1)))


# the rest of HoloOcean's modules


def test_maps_are_drawn_where_they_stand_and_close(still):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    named = {f"{n}_function": lambda at, k=k: k + at[0] for k, n in enumerate(("biomass", "salinity", "temperature"))}
    shown = still.initialize_bst_graphs(**named)
    assert isinstance(shown, BST_Visualizer)
    shown.close()  # nothing is open
    shown.update([1.0, -2.0, -3.0])
    figure, axes = shown._figure
    shown.update()
    assert shown._figure[0] is figure
    assert shown.location.tolist() == [1.0, -2.0, -3.0]
    titles = [f"{n} {plane}" for plane in ("xy", "xz") for n in ("biomass", "salinity", "temperature")]
    assert [a.get_title() for a in axes.ravel()] == titles
    maps = shown.maps()
    for a in axes.ravel():
        (image,) = a.images
        np.testing.assert_array_equal(image.get_array(), maps[a.get_title()])
        assert image.get_extent() == [-75, 75, -75, 75]
    shown.show()
    shown.close()
    assert (shown._figure, pyplot.fignum_exists(figure.number)) == (None, False)


def test_maps_without_a_bst_sensor_are_the_usual_ones():
    other = {"agents": [{"agent_name": "a", "sensors": [LOCATION]}]}
    at = np.array([3.0, 4.0, -20.0])
    for given in (None, other):
        shown = BST_Visualizer(given)
        assert shown.fields["temperature"](at) == BST_Visualizer().fields["temperature"](at)


def test_commands_wait_until_the_buffer_is_emptied():
    center, one = command.CommandCenter(), command.TideCommand(1)
    one.set_command_type("Other")
    assert json.loads(one.to_json())["name"] == "Other"
    for end in (center.handle_buffer, center.clear):
        center.enqueue_command(one)
        assert center.queue_size == 1
        end()
        assert center.queue_size == 0
    empty = len('{"commands": []}') + len(command.CustomCommand("").to_json())
    center.enqueue_command(command.CustomCommand("x" * (command.BUFFER - empty)))
    center.handle_buffer()  # just fits
    center.enqueue_command(command.CustomCommand("x" * (command.BUFFER - empty + 1)))
    with pytest.raises(HoloOceanException, match="longer than the buffer of 1048576 bytes"):
        center.handle_buffer()
    group = command.CommandsGroup()
    group.add_command(one)
    group.clear()
    assert group.size == 0


def test_memory_of_one_process_is_named():
    client = HoloOceanClient("id")
    one = client.malloc("a", [2, 3], np.float32)
    one[:] = 5
    assert client.malloc("a", (2, 3), np.float32) is one
    for other in (client.malloc("a", [3, 2], np.float32), client.malloc("a", [3, 2], np.int8)):
        assert not other.any()
    assert client.malloc("a", [3, 2], np.int8).dtype == np.int8
    client.command_center.enqueue_command(command.TideCommand(1))
    assert client.command_center.queue_size == 1
    shared = Shmem("b", [4], np.int16)
    assert (shared.name, shared.shape, shared.np_array.tolist(), shared.np_array.dtype) == (
        "b",
        (4,),
        [0] * 4,
        np.int16,
    )


def test_sizes_and_versions_for_people():
    assert [util.human_readable_size(1024.0**k) for k in (7, 8, 9)] == ["1.0 ZB", "1.0 YB", "1024.0 YB"]
    assert util.get_holoocean_version() == holoocean.__version__


def test_caches_of_octrees_go_where_they_are(tmp_path, monkeypatch):
    monkeypatch.setenv("HOLODECKPATH", str(tmp_path))
    for world in ("", ".", "..", "Dam/x", "/Dam"):
        with pytest.raises(HoloOceanException, match=f"a world is named, not '{world}'"):
            octrees.delete_world_octrees(world)
    octrees.delete_all_octrees()
    octrees.delete_world_octrees("Dam")  # nothing is there
    scenario = {"world": "Dam", "package_name": "Ocean", "octree_min": 0.1, "octree_max": 5}
    for world in ("Dam", "PierHarbor"):
        octrees.leave_folder({**scenario, "world": world})
    octrees.delete_world_octrees("Dam")
    assert [p.name for p in octrees._folder().iterdir()] == ["PierHarbor"]
    octrees.delete_all_octrees()
    assert not octrees._folder().exists()
    octrees._folder().write_text("in the way")
    octrees.leave_folder(scenario)
    assert octrees._folder().read_text() == "in the way"


def test_lcm_says_what_is_missing(tmp_path, monkeypatch):
    with pytest.raises(HoloOceanException, match=r"a language is one of c, cpp, .*, not 'rust'"):
        lcm.gen("rust", str(tmp_path))
    monkeypatch.setattr("shutil.which", lambda *_, **__: None)
    with pytest.raises(HoloOceanException, match="lcm-gen is not installed"):
        lcm.gen("c", str(tmp_path))
    assert not list(tmp_path.iterdir())
    monkeypatch.setitem(sys.modules, "lcm", None)
    with pytest.raises(HoloOceanException, match=r"an lcm_channel; install lcm: pip install 'pelagos\[lcm\]'"):
        lcm.provider("")


def test_another_holoocean_stays_and_names_go_to_ours(monkeypatch, capsys):
    importing.install("Ocean", branch="b")
    assert "Ocean comes with Pelagos" in capsys.readouterr().out
    for name in [n for n in sys.modules if n.split(".")[0] == "holoocean"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    monkeypatch.setitem(sys.modules, "holoocean", ModuleType("holoocean"))
    with pytest.raises(ImportError, match="another holoocean is imported already, from"):
        importing.install()
    finder = importing._Finder()
    assert finder.find_spec("holooceans", None) is finder.find_spec("holoocean.nothing", None) is None
    package, module = (finder.find_spec(n, None) for n in ("holoocean", "holoocean.lcm"))
    assert (package.submodule_search_locations, module.submodule_search_locations) == ([], None)
    assert finder.create_module(module) is lcm


CONVERTED = {
    "nowhere": (None, "No such file"),
    "no JSON": ("{", "Expecting property name"),
    "list": ("[1]", "a scenario is a mapping, not a list"),
    "bare": ('{"world": "TestWorld"}', "the key 'agents' is missing"),
    "refused": ('{"world": "TestWorld", "agents": [], "weather": {"type": 7}}', "a weather is 0 .*not 7"),
    "value": (
        json.dumps({"world": "TestWorld", "agents": [agent("HoveringAUV", [{**LOCATION, "Hz": 31}])]}),
        "Hz of 31 is above ticks_per_sec, 30",
    ),
}


@pytest.mark.parametrize("case", CONVERTED)
def test_a_file_that_cannot_be_converted_is_named(case, tmp_path):
    text, words = CONVERTED[case]
    path = tmp_path / "it.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=rf"it\.json: .*{words}"):
        converted(path)


def test_a_sensor_without_a_native_one_is_noted(tmp_path):
    path = tmp_path / "it.json"
    path.write_text(
        json.dumps({"world": "TestWorld", "agents": [agent("HoveringAUV", [sensor("BSTSensor"), LOCATION])]})
    )
    text = converted(path)
    assert "# * auv0.BSTSensor: BSTSensor has no native sensor of its kind" in text
    assert "rate_hz: 30.0" in text


# Fossen's interface

DYNAMICS = sensor("DynamicsSensor", UseCOM=True, UseRPY=False)


def fossen(*sensors, names="auv0", kind="torpedo", tps=50, **more):
    one = agent("TorpedoAUV", sensors or [DYNAMICS], fossen_model=kind, **more)
    return FossenInterface(names, {"agents": [one], **({} if tps is None else {"ticks_per_sec": tps})})


FOSSEN = {
    "model": ({"kind": "tropedo"}, KeyError, "'torpedo' or 'otter', not 'tropedo'"),
    "mode": (
        {"control_mode": "DPcontrol"},
        ValueError,
        "torpedo has no mode 'DPcontrol'.* it has manualControl, stepInput",
    ),
    "its mode": ({"kind": "otter", "control_mode": "depthAutopilot"}, ValueError, "otter has no mode 'depthAutopilot'"),
    "name": ({"names": ["auv0", "auv1"]}, ValueError, "the scenario has no agent 'auv1' .did you mean 'auv0'"),
}


@pytest.mark.parametrize("case", FOSSEN)
def test_a_fossen_vehicle_that_cannot_be(case):
    keys, kind, words = FOSSEN[case]
    with pytest.raises(kind, match=words):
        fossen(**keys)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (sensor("DynamicsSensor", UseCOM=True, UseRPY=True), "auv0: its DynamicsSensor needs UseCOM: True and UseRPY"),
        (sensor("DynamicsSensor", UseCOM=True), "needs UseCOM: True and UseRPY: False"),
        (sensor("DynamicsSensor", UseCOM=False, UseRPY=False), "needs UseCOM: True and UseRPY: False"),
        ({**DYNAMICS, "sensor_name": "D"}, "auv0 needs a DynamicsSensor of that name"),
        (LOCATION, "auv0 needs a DynamicsSensor of that name"),
    ],
)
def test_fossens_interface_needs_a_dynamics_sensor(given, words):
    with pytest.raises(ValueError, match=words):
        fossen(given)


def test_fossens_interface_takes_what_a_vehicle_can_do_and_no_more():
    it = fossen(control_mode="depthHeadingAutopilot")
    limit = it.vehicles["auv0"].rpm_limit
    for ask, kind, words in (
        (
            lambda: it.update("auv0", {"DynamicsSensor": np.zeros(18)}),
            ValueError,
            r"needs UseRPY: False; its shape is .18,",
        ),
        (lambda: it.get_u_control("auv"), KeyError, "there is no vehicle 'auv' .did you mean 'auv0'"),
        (lambda: it.set_u_control("auv0", [0] * 4), ValueError, "auv0: a command has 5 numbers, not 4"),
        (lambda: it.set_goal("auv0", depth=-0.1), ValueError, "a depth is from 0 on, positive down; given -0.1"),
        (lambda: it.set_goal("auv0", heading=180.1), ValueError, "a heading is -180 to 180 deg; given 180.1"),
        (lambda: it.set_goal("auv0", heading=-180.1), ValueError, "a heading is -180 to 180 deg; given -180.1"),
        (lambda: it.set_goal("auv0", rpm=-1), ValueError, f"is 0 to {limit:g} 1/min; given -1"),
        (lambda: it.set_goal("auv0", rpm=limit + 1), ValueError, f"is 0 to {limit:g} 1/min; given "),
        (lambda: it.set_control_mode("auv0", "manual"), ValueError, "no mode 'manual'"),
    ):
        with pytest.raises(kind, match=words):
            ask()
    assert it.vehicles["auv0"].goals == {"depth": 0.0, "heading": 0.0, "rpm": 0.0}
    for heading, rpm in ((-180, 0), (180, limit)):
        it.set_goal("auv0", depth=0, heading=heading, rpm=rpm)
        assert it.vehicles["auv0"].goals == {"depth": 0.0, "heading": heading, "rpm": rpm}
    it.set_control_mode("auv0", "stepInput")
    assert (it.get_control_mode("auv0"), it.vehicles["auv0"].native) == ("stepInput", "actuators")


def test_fossens_interface_tells_of_what_it_takes_for_granted_or_lets_lie():
    with pytest.warns(HoloOceanWarning, match="no ticks_per_sec; 30 is taken"):
        assert fossen(tps=None).vehicles["auv0"]._dt == 1 / 30
    other = agent("TorpedoAUV", fossen_model="otter", actuator={"T_n": 2}, dynamics={"Cd": 1}, autopilot={})
    with pytest.warns(HoloOceanWarning, match="auv0: dynamics, actuator configure a torpedo only"):
        assert changes(other, Advice()) == {}


def test_a_mode_goes_over_to_the_simulation_before_its_command():
    with opened(agent("SphereAgent", [LOCATION], location=(0, 0, 60)), ticks_per_sec=30) as env:
        told = []
        sim = SimpleNamespace(stepper=SimpleNamespace(mode=lambda name: "other"), set_mode=lambda *a: told.append(a))
        sim.command = told.append
        env._sim, env._stale = sim, False
        env._change_surroundings = lambda sim: None
        env.agents["auv0"].changed = True
        hand_over(env)
        assert told[0] == ("auv0", env.agents["auv0"].mode)
        assert list(told[1]) == ["auv0"]


# between an environment and its simulation


@pytest.mark.parametrize(
    ("hits", "free"),
    [
        ([None], True),
        ([(2.0, "b")], True),
        ([(2.0, "wall")], False),
        ([(0.5, "a"), None], True),
        ([(0.5, "a"), (2.0, "wall")], False),
        ([(9.9985, "a")], True),  # the sender's own hull up to the other point
        ([(0.1, "a")] * 9, False),  # what a hull can hide no more
    ],
)
def test_a_line_of_sight_begins_behind_the_senders_own_hull(hits, free, still):
    rest, places = iter(hits), []

    def cast(at, along, reach):
        hit = next(rest)
        places.append((float(at[0, 0]), reach, along[0].tolist()))
        t, name = hit or (np.inf, "")
        return SimpleNamespace(valid=[hit is not None], t=[t], instance=[name])

    hulls = {name: SimpleNamespace(instance=name) for name in "ab"}
    sim = SimpleNamespace(bodies=SimpleNamespace(hulls=hulls), world=SimpleNamespace(cast=cast))
    it = SimpleNamespace(pelagos=sim, native_name=lambda name: name)
    assert still.__class__.sees(it, "a", [1.0, 0, 0], "b", [11.0, 0, 0]) is free
    assert places[0] == (1.0, pytest.approx(9.999), [1, 0, 0])
    for (at, reach, _), (before, left, _), (t, _) in zip(places[1:], places, hits, strict=False):
        assert (at, reach) == (pytest.approx(before + t + 1e-3), pytest.approx(left - t - 1e-3))


def test_lamps_go_to_the_cameras_of_whom_they_light_once():
    env = unbuilt(sensor("RGBCamera"), LOCATION, more=[agent("BlueROV2", [sensor("RGBCamera")], name="auv1")])
    told = []
    sim = SimpleNamespace(set=lambda name, lamps: told.append((name, [one["flux_lm"] for one in lamps])))
    env._turbidity, env._level_asked = None, False
    env.turn_on_flashlight("flashlight1", 80, agent_tag="auv0")
    env._change_surroundings(sim)
    env._change_surroundings(sim)
    assert told == [("auv0.RGBCamera", [80])]
    env.turn_on_flashlight("flashlight2", 90)
    env._change_surroundings(sim)
    assert sorted(told[1:]) == [("auv0.RGBCamera", [80, 90]), ("auv1.RGBCamera", [90])]


def test_the_time_of_day_goes_on_by_ticks_only_where_it_is_told_to():
    for active, sun in ((True, {"elevation_deg": 45.0, "azimuth_deg": 90.0}), (False, None)):
        env = unbuilt(time_cycle={"active": active, "frequency": 48, "hour": 5})
        env._num_ticks = 18
        env._cycle()
        assert {k.removeprefix("sun."): v for k, v in env._pending.items()} == (sun or {})


def test_a_sensor_that_is_due_and_was_not_read_is_read_then():
    env = unbuilt(sensor("RangeFinderSensor"), sensor("CollisionSensor", {"sensor_name": "hit"}))
    asked = []

    def read(name, sensors):
        asked.append((name, sensors))
        return {one: SimpleNamespace(data=np.array([[4.5]])) for one in sensors}

    it = SimpleNamespace(pelagos=SimpleNamespace(read=read), motions={"auv0": None})
    one = env.agents["auv0"]
    values = HoloOceanEnvironment._values(it, one, {"hit": SimpleNamespace(data=np.array([[True]]))})
    assert (asked, values["RangeFinderSensor"].tolist()) == ([("auv0", ["RangeFinderSensor"])], [4.5])
    for each in one.sensors.values():
        each.tick_count = 1
    assert HoloOceanEnvironment._values(it, one, {}) == {}
    assert len(asked) == 1


def test_a_weather_has_a_type():

    env = unbuilt(weather={"type": 1})
    assert native_scenario(env, env.agents.values())["ocean"]["weather"]
    env = unbuilt(weather={"rain": 1})
    with pytest.raises(
        HoloOceanException, match=r"a weather's type is 0 \(sunny\), 1 \(cloudy\) or 2 \(rain\), not None"
    ):
        native_scenario(env, env.agents.values())


def test_an_agent_sees_what_is_ahead_of_it_whatever_its_heading() -> None:
    """40 degrees to the left of north, tipped up by 25: forward is the first column of its rotation."""
    env = unbuilt(sensor("AvoidTask", ToAvoid="auv0", OnlyWithinSight=True, FOVRadians=0.5))
    env.sees = lambda *_: True
    task, turn = env.agents["auv0"].sensors["AvoidTask"], Rotation.from_euler("ZY", [40, -25], degrees=True)
    ahead = lambda *off: 8.0 * turn.apply(Rotation.from_euler("ZY", off, degrees=True).apply([1.0, 0.0, 0.0]))
    eye = SimpleNamespace(position=np.array([3.0, -7.0, -2.0]), rotation=turn.as_matrix())
    half = math.degrees(task._half)
    for off, seen in (((0, 0), True), ((half - 1, 0), True), ((half + 1, 0), False), ((0, half - 1), True),
                      ((0, -half - 1), False), ((-half - 1, 0), False)):  # fmt: skip
        env.motions = {"auv0": eye, "b": SimpleNamespace(position=eye.position + ahead(*off))}
        assert task.seen("auv0", "b") is seen, off
