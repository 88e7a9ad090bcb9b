"""The water of the view: sections, waves and light that the page sets, and colours that all eyes tell apart."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.drawing.colours import DEPTHS, HEAT, INTENSITY
from pelagos.drawing.water import MATTER, SALT, SPEEDS, WARMTH
from pelagos.errors import LookupFailed
from pelagos.viewer.currents import arrows
from pelagos.viewer.live import Live
from pelagos.viewer.orders import Orders
from pelagos.viewer.pilot import Pilot
from pelagos.viewer.section import Asked, curtain, sections
from pelagos.viewer.session import Watch
from pelagos.viewer.soundings import water_of

SURFACE_C, BOTTOM_C, DEPTH_M = 21.0, 9.0, 24.0
SCENARIO: dict[str, Any] = {
    "seed": 5,
    "world": {"type": "flat", "depth_m": DEPTH_M},
    "ocean": {"temperature_c": {"depth_m": [0, DEPTH_M], "value": [SURFACE_C, BOTTOM_C]}},
    "agents": {"auv0": {
        "vehicle": "remus100", "start": {"position_m": [6, -11], "depth_m": 4.0, "speed_mps": 1.2, "heading_deg": 70},
        "control": "depth_heading_speed", "command": [5.0, 1.2, 1.5],
        "sensors": {"depth": {"type": "depth", "rate_hz": 10}},
    }},
}  # fmt: skip
SEA = {"type": "jonswap", "significant_height_m": 1.4, "peak_period_s": 6.5, "towards_deg": 35}


@pytest.fixture(scope="module")
def loaded() -> pl.Simulation:
    return pl.Simulation.load(SCENARIO)


@pytest.fixture
def sim(loaded: pl.Simulation) -> pl.Simulation:
    loaded.ocean.set(current=None, turbidity=1.0, keys={"waves": [], "sun": {"elevation_deg": 45, "azimuth_deg": 180}})
    loaded.reset(seed=5)
    return loaded


@pytest.fixture
def pilot(sim: pl.Simulation, tmp_path: Any) -> tuple[Pilot, Orders, list[str]]:
    made = Pilot(sim, Live(sim), paused=True)
    said: list[str] = []
    made.say = lambda text, kind: said.append(text)
    return made, Orders(made, tmp_path), said


def obey(pilot: Pilot, orders: Orders, **message: Any) -> None:
    assert orders.obey(message)
    pilot._obey()


def test_section_has_the_profile_of_the_water_from_surface_to_ground(sim):
    """A linear profile is a linear ramp of colours: each of the curtain's corners has that of its own depth."""
    place = sim.state["auv0"].position[0]
    found = curtain(sim.ocean.fields, sim.world, Asked("temperature", "east"), place, 0.0)
    x, y, z = found.vertices.T
    assert x == pytest.approx(np.full(len(x), place[0]), abs=1e-4)  # through the vehicle, east and west
    assert np.ptp(y) == pytest.approx(np.ptp(sim.world.bounds[:, 1]), rel=1e-6)
    assert (z.min(), z.max()) == pytest.approx((-DEPTH_M, 0.0), abs=1e-4)
    assert (found.low, found.high) == pytest.approx((BOTTOM_C, SURFACE_C), abs=0.02)
    level = 1.0 + z.astype(float) / DEPTH_M
    ramp = np.asarray(WARMTH(np.linspace(0, 1, 256)))[:, :3] * 255
    assert np.abs(found.colours - ramp[np.round(255 * level).astype(int)]).max() <= 5  # two steps of the ramp
    assert found.faces.max() < len(found.vertices)
    v = found.vertices[found.faces].astype(float)
    area = 0.5 * np.linalg.norm(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]), axis=1).sum()
    assert area == pytest.approx(np.ptp(y) * DEPTH_M, rel=1e-5)
    assert found.shades[0] != found.shades[-1]
    assert "sound_speed" in sections(sim.ocean.fields)
    with pytest.raises(LookupFailed, match="did you mean 'salinity'"):
        curtain(sim.ocean.fields, sim.world, Asked("salinty"), place, 0.0)


def test_waves_that_are_set_are_those_of_a_scenario_with_waves(pilot, tmp_path):
    """A vehicle under a sea that was set moves as one that was loaded in it, to the last bit; crests stay."""
    made, orders, said = pilot
    obey(made, orders, do="waves", height=1.4, period=6.5, towards_deg=35)
    assert said == []
    other = pl.Simulation.load({**SCENARIO, "ocean": {**SCENARIO["ocean"], "waves": [SEA]}})
    made.sim.reset(seed=5)
    made.sim.run(3.0)
    other.run(3.0)
    for a, b in zip(made.sim.state["auv0"].position[0], other.state["auv0"].position[0], strict=True):
        assert a == b
    height, period, towards = water_of(made.sim).settings["waves"]
    assert height == pytest.approx(1.4, rel=0.03)  # the largest components have 95 % of the energy or more
    assert period == pytest.approx(6.5, rel=0.15)  # of the largest component
    assert abs(towards - 35) < 60  # it has a direction of its own, within the spreading
    before = water_of(made.sim).sea.rows
    obey(made, orders, do="waves", height=0.7, period=6.5, towards_deg=35)
    assert water_of(made.sim).sea.rows[:, :4] == pytest.approx(before[:, :4])
    assert water_of(made.sim).sea.rows[:, 4] == pytest.approx(0.5 * before[:, 4])
    obey(made, orders, do="waves", height=0, period=1, towards_deg=0)
    assert len(water_of(made.sim).sea.rows) == 0


@pytest.mark.parametrize(
    ("order", "says"),
    [
        ({"do": "waves", "height": 4.0, "period": 3.0, "towards_deg": 0}, "4 m have a peak period of 6.2 to 25 s"),
        ({"do": "waves", "height": -1.0, "period": 3.0, "towards_deg": 0}, "0 to 15 m, not -1"),
        ({"do": "waves", "height": 1.0, "period": "long", "towards_deg": 0}, "period is a number, not 'long'"),
        ({"do": "sun", "elevation_deg": 120.0, "azimuth_deg": 10.0}, "elevation_deg"),
        ({"do": "sun", "elevation_deg": 20.0}, "azimuth_deg is a number, not None"),
        ({"do": "turbidity", "turbidity": -3.0}, "from 0 to 1000"),
        ({"do": "current", "speed": 11.0, "towards_deg": 0}, "0 to 10 m/s"),
    ],
)  # fmt: skip
def test_water_that_cannot_be_is_refused(pilot, order, says):
    made, orders, said = pilot
    obey(made, orders, **order)
    assert len(said) == 1
    assert says in said[0]


def test_settings_of_the_page_are_those_of_the_water(pilot):
    made, orders, said = pilot
    obey(made, orders, do="current", speed=0.5, towards_deg=120)
    obey(made, orders, do="current", speed=0.8, towards_deg=-60)  # the second is in force, not the first
    obey(made, orders, do="turbidity", turbidity=2.5)
    clear = np.array(water_of(pl.Simulation.load(SCENARIO)).attenuation)
    obey(made, orders, do="sun", elevation_deg=12.0, azimuth_deg=250.0)
    assert said == []
    water = water_of(made.sim)
    assert water.settings["current"] == pytest.approx([0.8, 300.0])
    assert water.settings["turbidity"] == 2.5
    assert water.settings["sun"] == pytest.approx([12.0, 250.0], abs=0.05)
    e, a = np.radians(12.0), np.radians(250.0)
    assert water.sunward == pytest.approx([np.cos(e) * np.cos(a), -np.cos(e) * np.sin(a), np.sin(e)], abs=1e-3)
    assert (np.array(water.attenuation) > 1.2 * clear).any()
    ways = np.diff(arrows(made.sim.ocean.fields, made.sim.world, 0.0, 4.0), axis=1)[:5, 0]
    assert ways[:, 1] / ways[:, 0] == pytest.approx(np.full(5, np.tan(np.radians(60.0))), rel=1e-3)


def test_watcher_gets_the_section_that_it_asks_for(sim):
    """Of a run that somebody else steps too; what does not exist is told in one sentence."""
    with Watch(sim, port=0) as watch:
        said: list[str] = []
        watch.view.control.say = said.append
        watch.view._heard({"do": "section", "what": "temperature", "along": "north"})
        watch.view._heard({"do": "section", "what": "temprature"})
        watch.view._heard({"do": "section", "what": "salinity", "along": "up"})
        sim.ocean.set(turbidity=2.25)  # by the program that steps: the page hears of it too
        sim.step(ticks=10)
        watch.live.show()
        for _ in range(100):
            found = watch.view.hub._kept.get("section")
            if found is not None:
                break
            watch.view._closed.wait(0.1)
        assert b'"title":"temperature","unit":"\\u00b0C"' in found
        assert b'"turbidity":2.25' in watch.view.hub._kept["water"]
        assert b"node/section" in watch.view.hub._kept["node/section"]
    assert len(said) == 2
    assert "did you mean 'temperature'" in said[0]
    assert "north" in said[1]


def lab(rgb: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """CIE L*a*b* under D65 of sRGB (CIE 15:2004; IEC 61966-2-1)."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    v = linear @ to_xyz.T / to_xyz.sum(axis=1)
    f = np.where(v > 216 / 24389, np.cbrt(v), (24389 / 27 * v + 16) / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=-1)


DEUTERANOPE = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)
PROTANOPE = np.array(
    [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
)
"""Machado, Oliveira and Fernandes (2009), severity 1, on linear RGB."""


@pytest.mark.parametrize("colours", [DEPTHS, INTENSITY, HEAT, SPEEDS, WARMTH, SALT, MATTER], ids=lambda c: c.name)
@pytest.mark.parametrize("seen", [np.eye(3), DEUTERANOPE, PROTANOPE], ids=["all", "deuteranope", "protanope"])
def test_colours_grow_lighter_or_darker_evenly_for_all_eyes(colours, seen):
    """Lightness never turns, and no tenth of a map has less than a fifth of its even share of the whole way."""
    rgb = np.asarray(colours(np.linspace(0, 1, 256)))[:, :3]
    linear = np.clip(np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4) @ seen.T, 0, 1)
    shown = lab(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))
    light = shown[::15, 0]
    rises = np.diff(light)
    assert (rises > -0.5).all() or (rises < 0.5).all()
    assert np.ptp(light) > 55
    way = np.linalg.norm(np.diff(shown, axis=0), axis=1)
    parts = np.array([p.sum() for p in np.array_split(way, 10)])
    assert parts.min() > 0.2 * parts.mean()
    assert parts.max() < 2.5 * parts.mean()


def test_where_there_is_no_ground_the_current_has_arrows() -> None:
    """A bank of 5 m to the south, nothing to the north: at 10 m arrows stand to the north alone."""
    bounds = np.array([[-60.0, -30.0, -5.0], [60.0, 30.0, 0.0]])
    world: Any = SimpleNamespace(bounds=bounds, height=lambda x, y: np.where(x > 0, np.nan, -5.0))
    ocean: Any = SimpleNamespace(current=lambda place, t, copy: jit.Array3f64(0.3, -0.2, 0.0) + 0.0 * place)
    shafts = arrows(ocean, world, 0.0, 10.0)[:36]  # of 12 by 6 places
    middle = shafts.mean(axis=1)
    assert len(arrows(ocean, world, 0.0, 10.0)) == 3 * 36
    assert np.unique(middle[:, 0].round(3)).tolist() == [5.0, 15.0, 25.0, 35.0, 45.0, 55.0]
    assert middle[:, 2] == pytest.approx(-10.0)
