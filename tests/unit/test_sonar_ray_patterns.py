"""Ray patterns of sonars: each ray in its stratum, strata that tile, weights that add up to the beam's pattern."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from pelagos.sensors.sonar import mechanical_scanning_sonar as scanning
from pelagos.sensors.sonar import sidescan
from pelagos.sensors.sonar import synthetic_aperture_sonar as sas
from pelagos.sensors.sonar.altimeter import cone_rays as altimeter_rays
from pelagos.sensors.sonar.ping.cone_rays import cone_rays
from pelagos.sensors.sonar.ping.multibeam_column import Column, column_rays
from pelagos.sensors.sonar.ping.thin_fan_rays import slice_rays

ANGLES, SECTORS = np.array([0.5, 0.1, -0.4]), np.array([0.3, 0.35, 0.4])


def line(width: float, angle: float, power: int = 4) -> float:
    """Pattern of a uniform line of a half-power width, to a power."""
    return float(np.sinc(0.8858929413789 / (2 * math.sin(width / 2)) * math.sin(angle)) ** power)


def lobe(width: float, power: int = 4) -> float:
    """Its integral over the angle, between the first nulls."""
    null = math.asin(2 * math.sin(width / 2) / 0.8858929413789)
    return float(quad(lambda a: line(width, a, power), -null, null)[0])


def rays_of(name: str) -> tuple[dict[str, Any], list[float]]:
    """Rays of an unusual sonar, and the integral of the pattern over each of its beams, by quadrature."""
    wide, narrow = math.radians(24.0), math.radians(1.7)
    if name == "cone":
        reach = 1.129 * wide
        return cone_rays(wide, 400), [quad(lambda a: 2 * math.pi * math.sin(a) * line(wide, a), 0, reach)[0]]
    if name == "altimeter":
        return altimeter_rays(wide), [quad(lambda a: 2 * math.pi * math.sin(a) * line(wide, a), 0, 0.875 * wide)[0]]
    if name == "head":
        config = scanning.MechanicalScanningSonarConfig(
            beamwidth_deg=1.7, vertical_beamwidth_deg=24.0, vertical_side_lobes=1, rays=300
        )
        limit = math.asin(2 * 2 * math.sin(wide / 2) / 0.8858929413789)
        up = quad(lambda e: line(wide, e) * math.cos(e), -limit, limit, limit=200)[0]
        return scanning.beam_rays(config), [lobe(narrow) * up]
    if name == "sidescan":
        config = sidescan.SidescanConfig(
            beamwidth_deg=1.7,
            vertical_beamwidth_deg=24.0,
            depression_deg=40.0,
            vertical_floor_db=-10.0,
            rays_per_side=500,
        )

        def shape(a: float) -> float:
            off = a - math.radians(50.0)
            return ((line(wide, off, 2) if abs(off) < math.pi / 2 else 0.0) + 0.1) / 1.1

        up = quad(lambda a: shape(a) ** 2, math.radians(-5.0), math.radians(185.0), limit=400)[0]
        return sidescan.side_rays(config), [lobe(narrow) * up] * 2
    if name == "synthetic aperture":
        made = sas.SyntheticApertureSonarConfig(
            beamwidth_deg=9.0, vertical_beamwidth_deg=24.0, depression_deg=35.0, rays=6400
        )
        along = quad(lambda a: line(math.radians(9.0), a), -1.1 * math.radians(9.0), 1.1 * math.radians(9.0))[0]
        low, high = -1.1 * wide - math.radians(35.0), 1.1 * wide - math.radians(35.0)
        up = quad(lambda e: line(wide, e + math.radians(35.0)) * math.cos(e), low, high)[0]
        return sas.beam_rays(made), [along * up]
    if name == "slice":
        rays = slice_rays(ANGLES, SECTORS, rays=60, width=narrow, ways=2)
        return rays, [s * lobe(narrow) for s in SECTORS]
    rays = column_rays(Column(ANGLES, 1.0, 0.02, narrow))
    return rays, [abs(s) * lobe(narrow, 2) for s in np.gradient(ANGLES)]


KINDS = ["cone", "altimeter", "head", "sidescan", "synthetic aperture", "slice", "column"]
CLOSE = {"altimeter": 0.03, "synthetic aperture": 0.01}  # four rings; strata that are sampled along the track


@pytest.mark.parametrize("name", KINDS)
def test_rays_stand_in_strata_that_add_up_to_the_pattern(name: str) -> None:
    rays, whole = rays_of(name)
    way, along = rays["direction"], rays["along"]
    assert np.linalg.norm(way, axis=1) == pytest.approx(1.0)
    assert np.linalg.norm(along, axis=1) == pytest.approx(1.0)
    assert (rays["lower"] <= 1e-12).all()
    assert (rays["upper"] >= -1e-12).all()
    assert (rays["upper"] > rays["lower"]).all()
    for beam, expected in enumerate(whole):
        assert rays["weight"][rays["beam"] == beam].sum() == pytest.approx(expected, rel=CLOSE.get(name, 2e-3))


@pytest.mark.parametrize("name", KINDS)
def test_a_beams_rays_look_about_its_axis(name: str) -> None:
    """The mean direction by weight; of a slice where its beam looks, between its sector's edges."""
    rays, whole = rays_of(name)
    axes = {
        "cone": [[0, 0, -1]], "altimeter": [[0, 0, -1]], "head": [[1, 0, 0]],
        "synthetic aperture": [[0, math.cos(math.radians(35)), -math.sin(math.radians(35))]],
        "slice": [[math.cos(a), math.sin(a), 0] for a in ANGLES],
        "column": [[0, math.sin(a), -math.cos(a)] for a in ANGLES],
        "sidescan": [[0, s * math.cos(math.radians(40)), -math.sin(math.radians(40))] for s in (1, -1)],
    }[name]  # fmt: skip
    off = {"head": 0.01, "sidescan": 0.25, "cone": 0.01, "altimeter": 0.01, "synthetic aperture": 0.03}.get(name, 0.02)
    for beam in range(len(whole)):
        mine = rays["beam"] == beam
        mean = (rays["weight"][mine][:, None] * rays["direction"][mine]).sum(axis=0)
        assert mean / np.linalg.norm(mean) == pytest.approx(axes[beam], abs=off)


@pytest.mark.parametrize("name", ["slice", "column"])
def test_strata_of_a_slice_lie_within_its_sector_and_reach_as_far_fore_as_aft(name: str) -> None:
    """Along the plane from edge to edge; out of it by its half, whose strata hold equal shares of the pattern."""
    rays, _ = rays_of(name)
    sectors = SECTORS if name == "slice" else np.abs(np.gradient(ANGLES))
    ahead, left, fore = (
        rays["direction"].T
        if name == "slice"
        else (-rays["direction"][:, 2], rays["direction"][:, 1], rays["direction"][:, 0])
    )
    angle, beam = np.arctan2(left, ahead), rays["beam"]
    low, high = angle + rays["lower"], angle + rays["upper"]
    assert (low - (ANGLES - sectors / 2)[beam]).min() == pytest.approx(0.0, abs=1e-9)
    assert (high - (ANGLES + sectors / 2)[beam]).max() == pytest.approx(0.0, abs=1e-9)
    assert rays["across"] == pytest.approx(2 * rays["half"])
    for k in range(3):  # every column of strata covers the whole thickness once
        columns = np.unique(low[beam == k].round(9))
        thick = rays["across"][beam == k].sum() / len(columns)
        null = math.asin(2 * math.sin(math.radians(1.7) / 2) / 0.8858929413789)
        assert thick == pytest.approx(2 * null, rel=1e-3)
    assert np.abs(np.arcsin(fore)).max() < math.radians(1.7) * 1.13


def test_more_rays_of_a_cone_are_thinner_rings_of_the_same_pattern() -> None:
    """Edges of neighbouring rings meet, but for slopes' sake none is thinner than a ray's share of the disc."""
    rays = cone_rays(0.2, 50)
    angle = np.arccos(-rays["direction"][:, 2])
    assert angle == pytest.approx((np.arange(50) + 0.5) * 1.129 * 0.2 / 50, abs=1e-9)
    cell = 1.129 * 0.2 * math.sqrt(math.pi / 50)
    assert -rays["lower"] == pytest.approx(np.full(50, cell / 2))
    assert rays["upper"] == pytest.approx(np.full(50, cell / 2))
    assert rays["across"] ** 2 == pytest.approx(2 * math.pi * np.sin(angle) * 1.129 * 0.2 / 50)
