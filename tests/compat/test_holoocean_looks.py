"""Weather, fog and lamps change pictures as they should: own checks in place of HoloOcean's recorded pictures."""

import numpy as np
import pytest
from holoocean_env import agent, opened

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning"),
]


def camera(**keys):
    return {"sensor_type": "RGBCamera", "configuration": {"CaptureWidth": 64, "CaptureHeight": 48}, **keys}


def wet(**keys):
    """A hovering agent 3 m before the wall of Dam, under water."""
    return opened(
        agent("HoveringAUV", [camera(socket="CameraLeftSocket")], location=(-22, 0, -5), rotation=[0, 0, 180]),
        world="Dam", **keys,
    )  # fmt: skip


def dry(**keys):
    """A sphere over TestWorld's floor that looks ahead."""
    return opened(agent("SphereAgent", [camera()], location=(-8, 5, 2)), **keys)


def seen(env, ticks=1):
    return env.tick(ticks)["RGBCamera"][..., :3].astype(float)


def contrast(picture):
    grey = picture.mean(axis=-1)
    return grey.std() / grey.mean()


def test_fog_in_the_water_lowers_the_contrast():
    with wet() as env:
        clear = seen(env)
        env.water_fog(6)
        assert contrast(seen(env)) < 0.8 * contrast(clear)
        env.water_fog(0)
        assert contrast(seen(env)) > 0.95 * contrast(clear)


def test_fog_in_the_air_lowers_the_contrast():
    with dry() as env:
        clear = seen(env)
        env.air_fog(8)
        assert contrast(seen(env)) < 0.8 * contrast(clear)


def test_rain_changes_the_picture_and_going_back_restores_it():
    with dry(weather={"type": 0}) as env:
        sunny = seen(env)
        env.weather.set_weather(2)
        assert env.weather.get_weather() == 2
        assert np.abs(seen(env) - sunny).mean() > 5
        env.change_weather(0)
        assert np.abs(seen(env) - sunny).mean() < 2


def test_a_flashlight_lights_the_night_and_goes_out():
    with wet(time_cycle={"active": False, "hour": 0}) as env:
        dark = seen(env)
        env.turn_on_flashlight("flashlight1", intensity=50_000, beam_width=60, angle_pitch=0)
        lit = seen(env)
        assert np.abs(lit - dark).mean() > 5
        env.turn_off_flashlight("flashlight1")
        out = seen(env)  # in the dark a camera sees its own noise, which is new in every picture
        assert abs(out.mean() - dark.mean()) < 3
        assert contrast(lit) < 0.7 * contrast(out)


def test_water_has_the_colour_that_was_asked_for():
    with wet() as env:
        env.water_color(0.1, 0.2, 0.9)
        blue = seen(env).mean(axis=(0, 1))
        env.water_color(0.3, 0.8, 0.2)
        green = seen(env).mean(axis=(0, 1))
        assert blue[0] / blue[1] > 1.2 * green[0] / green[1]  # blue over green, in BGR


def test_a_tide_moves_the_water_in_the_picture():
    with opened(agent("SphereAgent", [camera()], location=(0, -50, 1.0))) as env:
        over = seen(env)
        env.tide(3, 1)
        assert np.abs(seen(env) - over).mean() > 10
        env.tide(0, 1)
        assert np.abs(seen(env) - over).mean() < 5
