"""Tides, light and sensors in odd places, as scripts in HoloOcean's style meet them."""

import math

import pytest
from holoocean_env import agent, opened

from pelagos import jit
from pelagos.compat.holoocean.advice import HoloOceanWarning
from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.compat.holoocean.sensors import SensorDefinition

DEPTH = {"sensor_type": "DepthSensor"}
QUIET = pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")


@pytest.mark.parametrize(
    "tide", [{"tide_cycle": {"active": True, "amplitude": -2.0, "frequency": 90}},
             {"tide": {"amplitude": -2.0, "period": 3.0}}]
)  # fmt: skip
def test_a_tide_goes_by_the_count_of_ticks_and_goes_on_over_a_reset(tide):
    """z of a hull that floats is not looked at: the level itself is A sin(2 pi n / T) after tick n."""
    slow = {"sensor_type": "LocationSensor", "Hz": 2}  # makes the native clock begin later
    with opened(agent("SphereAgent", [DEPTH, slow], location=(0, -50, 1.5)), ticks_per_sec=30, **tide) as env:
        for n in range(40):
            env.tick()
            level = -2.0 * math.sin(2 * math.pi * n / 90)
            assert env.sea_level == pytest.approx(level, abs=1e-9)
            native = env.pelagos.ocean.fields.tide.level(jit.Float64(env.pelagos.time_ns * 1e-9))
            assert float(native[0]) == pytest.approx(level, abs=1e-6)
        env.reset()
        env.tick()
        assert env.sea_level == pytest.approx(-2.0 * math.sin(2 * math.pi * 40 / 90), abs=1e-9)
        assert env.tick()["DepthSensor"][0] == pytest.approx(1.5 - env.sea_level, abs=0.15)


def test_a_tide_may_stand_still_and_says_which_keys_it_has():
    with opened(agent("SphereAgent", [DEPTH], location=(0, -50, 3.0)), tide={"level": 2.0, "offset": -0.5}) as env:
        assert env.tick()["DepthSensor"][0] == pytest.approx(1.5)
        env.tide(-1, False)
        env.tick()
        assert env.sea_level == pytest.approx(0.5)
    with pytest.warns(HoloOceanWarning, match="did you mean 'level'"):
        opened(agent("SphereAgent"), tide={"levle": 2.0})


def test_a_socket_that_is_not_there_is_named():
    with pytest.warns(HoloOceanWarning, match="no socket 'IMUSockt'.*did you mean 'IMUSocket'"):
        opened(agent("HoveringAUV", [dict(DEPTH, socket="IMUSockt")]))


def test_an_unknown_sensor_is_a_key_error_with_words():
    with pytest.raises(KeyError, match="did you mean 'DepthSensor'") as caught:
        opened(agent("HoveringAUV", [{"sensor_type": "DepthSensr"}]))
    assert isinstance(caught.value, HoloOceanException)


@QUIET
def test_fog_at_sunset_keeps_every_number_of_the_light_finite():
    eye = {"sensor_type": "RGBCamera", "configuration": {"CaptureWidth": 16, "CaptureHeight": 16}}
    with opened(agent("HoveringAUV", [eye], location=(10, 10, -3))) as env:
        before = env.tick()["RGBCamera"]
        env.water_color(0.2, 0.5, 0.3)
        env.water_fog(5)
        env.change_time_of_day(17.9)
        after = env.tick()["RGBCamera"]  # a warning of NumPy's would be an error
        assert (after != before).any()


@QUIET
def test_a_semantic_sonar_looks_along_its_boresight_whatever_the_physics():
    down = {"sensor_type": "SemanticRaycastSinglebeamSonar", "rotation": [0, 90, 0],
            "configuration": {"physics": "holoocean", "RangeMax": 10, "OpeningAngle": 20}}  # fmt: skip
    with opened(agent("HoveringAUV", [down], location=(10, 10, -19))) as env:
        assert env.tick()["SemanticRaycastSinglebeamSonar"][:, 0].any()


@QUIET
def test_what_was_asked_for_last_holds_when_the_simulation_is_built_anew():
    """Another sensor builds it anew: what had been changed stays, and the latest of two changes of one thing wins."""
    with opened(agent("SphereAgent", [DEPTH], location=(3, -50, -4))) as env:
        env.air_fog(5)
        env.set_rain_parameters(0, 0, 0, 1500)
        env.water_color(0.2, 0.5, 0.3)
        env.tick()
        now = env.pelagos.scenario.ocean
        assert (now.weather.visibility_m, now.weather.rain_mm_per_h, now.water_type) == (40.0, 5.0, "5C")
        env.agents["auv0"].add_sensors(SensorDefinition("auv0", "SphereAgent", "other", "DepthSensor"))
        env.air_fog(2.5)
        env.water_color(0.2, 0.4, 0.7)
        first = env.pelagos
        env.tick()
        now = env.pelagos.scenario.ocean
        assert (now.weather.visibility_m, now.weather.rain_mm_per_h, now.water_type) == (80.0, 5.0, "II")
        env.tick()
        assert env.pelagos is first
        assert env.pelagos.scenario.ocean.weather.visibility_m == 80.0
