"""Shadows in a lamp's cone, against the integral of single scattering along rays behind a plate."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pelagos import jit
from pelagos.optics.lamp import Beam, _unshaded, seen_from
from pelagos.optics.water import MEAN_COSINE, water_optics
from pelagos.sensors.camera.picture import glow
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.camera_rays import pixel_rays
from pelagos.sim.simulation import Simulation

LAMP = np.array([0.0, 1.5, 0.3])  # relative to the camera, forward-left-up [m]
TURN = math.radians(-20)  # to the right
PLATE_X, PLATE_Y, PLATE_Z = 2.5, (0.5, 1.3), (-0.4, 0.4)  # facing the camera [m]
REACH = 8.0  # [m], to the wall behind
SIZE = {"width_px": 144, "height_px": 96, "horizontal_fov_deg": 70}


def picture(*, plate: bool) -> NDArray[np.float64]:
    """Green light of the water at night; linear, without noise."""
    lamp = {"position_m": LAMP.tolist(), "orientation_deg": [0, 0, -20], "flux_lm": 8000, "beam_angle_deg": 50}
    camera = {
        "type": "camera", "rate_hz": 10, "lamps": [lamp], "exposure": "manual", "shutter_s": 0.01, "iso": 200,
        "tone": "linear", "bits": 16, "vignette": 0.0, **SIZE,
    }  # fmt: skip
    y, z = np.mean(PLATE_Y), np.mean(PLATE_Z) - 8
    things: list[dict[str, Any]] = [
        {"shape": "box", "name": "back", "at_m": [REACH + 0.05, 0, -8], "size_m": [0.1, 60, 60], "material": "black",
         "label": "wall"},
        {"shape": "box", "name": "plate", "at_m": [PLATE_X, float(y), float(z) if plate else -25.0],
         "size_m": [0.02, 0.8, 0.8], "material": "black", "label": "wall"},
    ]  # fmt: skip
    values = {
        "world": {"type": "built", "depth_m": 40, "things": things},
        "ocean": {"water_type": "1C", "sun": {"elevation_deg": -30}},
        "agents": {"rov": {"vehicle": "hovering_auv", "start": {"position_m": [0, 0, -8]}, "sensors": {"c": camera}}},
    }
    truth = Simulation.load(values).reset()["rov"]["c"].truth
    return np.asarray(truth[0, :, :, 1], dtype=float)


def share_lit(direction: NDArray[np.float64]) -> float:
    """Of the light that the water along a ray sends back, the share that is left behind the plate."""
    water = water_optics("1C").arrays()
    keep, sea, particles = (
        float(v[1].numpy()[0])
        for v in (water.absorption + water.backscatter, water.water_scattering, water.particle_scattering)
    )
    s = np.linspace(0.01, REACH / direction[0], 20_000)
    place = s[:, None] * direction
    way = place - LAMP
    r = np.linalg.norm(way, axis=1)
    axis = np.array([math.cos(TURN), math.sin(TURN), 0.0])
    inner, outer = math.cos(math.radians(12.5)), math.cos(math.radians(25))
    t = np.clip((way @ axis / r - outer) / (inner - outer), 0, 1)
    turn = -(way @ direction) / r
    phase = (1 - MEAN_COSINE**2) / (4 * math.pi * (1 + MEAN_COSINE**2 - 2 * MEAN_COSINE * turn) ** 1.5)
    scattered = sea / (4 * math.pi) + particles * phase
    light = t * t * (3 - 2 * t) * np.exp(-keep * (r + s)) * scattered / r**2
    at = LAMP + way * ((PLATE_X - LAMP[0]) / np.maximum(way[:, :1], 1e-9))  # where its light passes the plate
    dark = (place[:, 0] > PLATE_X) & (at[:, 1] > PLATE_Y[0]) & (at[:, 1] < PLATE_Y[1]) & (np.abs(at[:, 2]) < PLATE_Z[1])
    return float(light[~dark].sum() / light.sum())


def test_the_cone_is_dark_behind_a_plate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shares of four parts of the ray, interpolated and smoothed over squares: the border of a shadow may be half a
    part off, and a part sends up to a fifth of the light. The glow, which is no single scattering, is left out.
    """
    monkeypatch.setattr(glow, "spread", lambda light, *_: light)
    bright, shaded = picture(plate=False), picture(plate=True)
    _, directions = pixel_rays(CameraConfig(**SIZE))
    places = [(row, column) for row in (44, 52, 60) for column in (74, 80, 86, 92, 98, 110)]  # right of the plate
    found = np.array([shaded[p] / bright[p] for p in places])
    expected = np.array([share_lit(directions[p]) for p in places])
    assert expected.min() < 0.75
    assert expected.max() > 0.99
    assert np.abs(found - expected).max() < 0.5 / 5, np.round([found, expected], 3)
    assert np.abs(found - expected).mean() < 0.04, np.round([found, expected], 3)


def test_parts_of_a_ray_are_of_equal_angle_seen_from_the_lamp() -> None:
    """From the camera at share 0 to the reach at share 1; the angle between goes as the share does."""
    rng = np.random.default_rng(2)
    lamp, away = rng.uniform(-2, 2, (3, 50)), rng.normal(size=(3, 50))
    away /= np.linalg.norm(away, axis=0)
    reach, share = rng.uniform(0.5, 9.0, 50), rng.uniform(0, 1, 50)
    beam = Beam(jit.Array3f(lamp.astype(np.float32)), *(jit.Float(0),) * 4)
    s, place, distance = (
        np.array(v) for v in seen_from(beam, jit.Array3f(away.astype(np.float32)), jit.Float(reach), jit.Float(share))
    )
    assert place == pytest.approx(s * away, abs=1e-4)
    assert distance == pytest.approx(np.linalg.norm(place - lamp, axis=0), rel=1e-4)

    def angle(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
        cosine = (a * b).sum(axis=0) / np.linalg.norm(a, axis=0) / np.linalg.norm(b, axis=0)
        return np.asarray(np.arccos(np.clip(cosine, -1, 1)))

    whole = angle(-lamp, reach * away - lamp)
    assert angle(-lamp, place - lamp) == pytest.approx(share * whole, abs=2e-3)
    assert (s > -1e-3).all()
    assert (s < reach + 1e-3).all()


def test_shade_passes_over_from_part_to_part() -> None:
    """Between the middles of four parts, and beyond the outer ones theirs."""
    values = [0.9, 0.2, 0.6, 0.4]
    beam = Beam(*(jit.Float(0),) * 5, shade=jit.Array4f(*values))
    for share in (0.0, 0.1, 0.125, 0.3, 0.5, 0.71, 0.875, 0.99):
        expected = np.interp(4 * share - 0.5, np.arange(4), values)
        assert np.array(_unshaded(beam, share))[0] == pytest.approx(expected, rel=1e-5)
    assert _unshaded(Beam(*(jit.Float(0),) * 5), 0.3) == 1.0
