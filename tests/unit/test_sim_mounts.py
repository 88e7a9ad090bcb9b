"""Sensors that begin inside something solid, and sonars that begin in the air."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import MountWarning
from pelagos.raycast.geometry import Geometry
from pelagos.sim.mounts import winding_number
from pelagos.world.shapes import sphere


def scenario(arm, *, kind="altimeter", second=None, depth=8.0):
    agents = {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0.0, 0.0], "depth_m": 5.0},
            "sensors": {"it": {"type": kind, "rate_hz": 5, "position_m": list(arm)}},
        }
    }
    if second is not None:
        agents["auv1"] = {"vehicle": "remus100", "start": {"position_m": list(second), "depth_m": 5.0}}
    return {"world": {"type": "flat", "depth_m": depth}, "agents": agents}


def test_a_mount_below_the_seabed_is_told_with_place_and_remedy():
    with pytest.warns(
        MountWarning, match=r"agents\.auv0\.sensors\.it.*\(1\.00, 0\.00, -8\.50\) m lies inside the seabed"
    ) as told:
        pl.Simulation.load(scenario((1.0, 0.0, -3.5)))
    assert "position_m, which is [1, 0, -3.5]" in str(told[0].message)


def test_a_mount_inside_another_hull_is_told():
    with pytest.warns(MountWarning, match="lies inside auv1"):
        pl.Simulation.load(scenario((0.0, 0.6, 0.0), second=(0.0, 0.6)))


@pytest.mark.parametrize("arm", [(0.3, 0.0, 0.0), (0.0, 0.0, -2.5)])
def test_mounts_inside_the_own_hull_or_in_the_water_are_fine(arm):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pl.Simulation.load(scenario(arm))


def test_a_sonar_above_the_water_is_told_and_hears_nothing():
    with pytest.warns(MountWarning, match=r"sensors\.it.*lies 1 m above the water: it hears nothing there"):
        sim = pl.Simulation.load(scenario((0.0, 0.0, 6.0), depth=20.0))
    assert "it" not in sim.reset()["auv0"]


def test_a_camera_may_be_in_the_air():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pl.Simulation.load(scenario((0.0, 0.0, 6.0), kind="depth_camera", depth=20.0))


def test_sensors_that_cast_no_rays_may_be_anywhere():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pl.Simulation.load(scenario((0.0, 0.0, -3.5), kind="imu"))


def test_winding_number_of_a_ball():
    mesh = sphere(1.0, sides=24, rings=12)
    ball = Geometry(np.asarray(mesh.vertices), mesh.faces, 0, 1, 1)
    assert winding_number(ball, np.array([0.2, -0.3, 0.4])) == pytest.approx(1.0, abs=1e-9)
    assert winding_number(ball, np.array([0.9, 0.9, 0.0])) == pytest.approx(0.0, abs=1e-9)
