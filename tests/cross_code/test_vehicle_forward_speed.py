"""Speed ahead against other programs: ShipX VERES's S-175 container ship, and Capytaine 3.0.0 on a Wigley hull.

`data/veres_s175.json`: added mass and damping of ShipX VERES (strip theory of Salvesen, Tuck and Faltinsen), FRD about
amidships, as the MSS toolbox has them (T. I. Fossen and T. Perez), at speeds of 0, 2.57 and 7.72 m/s, Froude 0 to 0.19.
`data/capytaine_wigley_speed.json`: 3 m x 0.3 m x 0.1875 m, half breadths of a Wigley hull times 1 + 0.3 x / 1.5 m, in
head seas that meet it at 6 and 8 rad/s, at Froude numbers of 0, 0.2 and 0.3 (`forward_speed`, which takes the steady
flow as uniform and drops the waterline's integral).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid

from pelagos.hydro.forward_speed import Transom, at_speed
from pelagos.hydro.strips import Station, Strips, strips_of
from pelagos.vehicles.shape.stations import even_points, mesh_stations

DATA = Path(__file__).parent / "data"
VERES = json.loads((DATA / "veres_s175.json").read_text())
WIGLEY = json.loads((DATA / "capytaine_wigley_speed.json").read_text())["cases"]
FLIP = np.array([1, -1, -1, 1, -1, -1])  # FLU and FRD
UPRIGHT = np.ix_([2, 4], [2, 4])


@pytest.mark.parametrize("frequency", [0, 1, 2])
def test_s175_heave_and_pitch(frequency: int) -> None:
    """The ship has a small transom. Its section's two numbers and its place follow from what the lower speed changes in
    A33, B33 and B53; the other five of that speed and all eight of the higher must then be VERES's. Seven digits, of
    which differences of 0.1 % of the whole keep four: 2e-4 of the largest pair's scale, where leaving the transom out
    costs up to 1.5 %.
    """
    omega, (_, slow, fast) = VERES["omega_radps"][frequency], VERES["speed_mps"]
    added, damping = (np.array(VERES[key][frequency]) for key in ("added_mass", "damping"))
    a = (damping[1, 2, 2] - damping[0, 2, 2]) / slow
    b = -(added[1, 2, 2] - added[0, 2, 2]) * omega**2 / slow
    place = -(damping[1, 4, 2] - damping[0, 4, 2] + slow * added[0, 2, 2]) / (slow * a)
    assert place == pytest.approx(-89.16, abs=0.1)  # astern of the after perpendicular, the same at every frequency
    section = np.zeros((3, 3), complex)
    section[1, 1] = a + b / (1j * omega)
    for i, speed in ((1, slow), (2, fast)):
        found = at_speed(added[0], damping[0], omega, speed, Transom(place, section))
        for mine, theirs in zip(found, (added[i], damping[i]), strict=True):
            scale = np.sqrt(np.outer(np.diag(theirs), np.diag(theirs)))[UPRIGHT]
            assert np.abs(mine - theirs)[UPRIGHT] / scale == pytest.approx(np.zeros((2, 2)), abs=5e-4)
        pointed = at_speed(added[0], damping[0], omega, speed)
        assert abs(pointed[1][2, 4] / damping[i, 2, 4] - 1) > 1e-3
        assert abs(damping[i, 2, 4] / damping[0, 2, 4] - 1) > 0.3  # that speed changes much


@pytest.mark.parametrize("frequency", [0, 1, 2])
def test_s175_sway_roll_and_yaw(frequency: int) -> None:
    """Without the transom, whose section adds 0.2 % at most."""
    omega = VERES["omega_radps"][frequency]
    added, damping = (np.array(VERES[key][frequency]) for key in ("added_mass", "damping"))
    rows = np.ix_([1, 3, 5], [1, 3, 5])
    for i, speed in enumerate(VERES["speed_mps"]):
        found = at_speed(added[0], damping[0], omega, speed)
        for mine, theirs in zip((found[0] * omega, found[1]), (added[i] * omega, damping[i]), strict=True):
            own = np.hypot(np.diag(added[i]) * omega, np.diag(damping[i]))
            scale = np.sqrt(np.outer(own, own))[rows]
            assert np.abs(mine - theirs)[rows] / scale == pytest.approx(np.zeros((3, 3)), abs=3e-3)
    assert np.abs(added[2, 1, 5] / added[0, 1, 5] - 1) > 0.2


def half_breadth(u: float, low: Any) -> Any:
    """Of the hull at u = 2 x / L and a share of the draught [m]."""
    return 0.15 * (1 - low**2) * (1 - u**2) * (1 + 0.2 * u**2) * (1 + 0.3 * u)


@pytest.fixture(scope="module")
def strips() -> Strips:
    low, edges = np.linspace(0, 1, 100), np.linspace(-1, 1, 17)
    stations = []
    for u in (edges[1:] + edges[:-1]) / 2:
        side = np.stack([half_breadth(float(u), low), -0.1875 * low], axis=-1)
        points = even_points(np.concatenate([side * [-1, 1], side[-2::-1]]))
        stations.append(Station(1.5 * float(u), 3.0 / 16, 0.0, points))
    return strips_of(stations, np.array([8.0, 8.1]))


def case(speed: float, omega: float) -> dict[str, Any]:
    return next(c for c in WIGLEY if abs(c["speed_mps"] - speed) < 1e-3 and c["omega_met_radps"] == omega)


def test_strips_against_a_panel_method(strips: Strips) -> None:
    """Waves of a third of the length, zero speed: what the ends do to heave and pitch in three dimensions is 7 %."""
    added, damping = (m[0] for m in strips.coefficients())
    theirs = case(0.0, 8.0)
    flip = np.outer(FLIP, FLIP)
    for mine, other in ((added, theirs["added_mass"]), (damping, theirs["damping"])):
        assert mine[UPRIGHT] == pytest.approx((np.array(other) * flip)[UPRIGHT], rel=0.07)
    assert damping[1, 1] == pytest.approx(theirs["damping"][1][1], rel=0.07)
    assert added == pytest.approx(added.T, abs=0.01 * added[2, 2])


@pytest.mark.parametrize("speed", [1.085, 1.6274])
def test_scattered_waves_at_speed(strips: Strips, speed: float) -> None:
    """Head sea that meets the hull at 8 rad/s: heave and pitch over half the length within 15 % of the larger. Without
    U / (i omega) in pitch it would be 25 to 40 % off.
    """
    theirs = case(round(speed, 4), 8.0)
    force = strips.excitation(theirs["omega_radps"], np.pi, theirs["speed_mps"])[1][[2, 4]]
    other = (np.array(theirs["diffraction"]) @ [1, 1j] * FLIP)[[2, 4]]
    arm = np.array([1.0, 1.5])
    assert np.abs(force - other) / arm == pytest.approx(np.zeros(2), abs=0.15 * np.abs(other / arm).max())


@pytest.mark.parametrize("omega", [6.0, 8.0])
@pytest.mark.parametrize("speed", [1.085, 1.6274])
def test_what_turns_over_with_the_course(speed: float, omega: float) -> None:
    """The antisymmetric part of heave and pitch, by zero-speed coefficients of the same program: 7 %. Its symmetric
    part changes with U in Capytaine, which reciprocity (Timman and Newman 1962) does not allow: its uniform stream goes
    through the hull. No comparison there.
    """
    still, theirs = case(0.0, omega), case(round(speed, 4), omega)
    flip = np.outer(FLIP, FLIP)
    before = [np.array(still[key]) * flip for key in ("added_mass", "damping")]
    for mine, key in zip(at_speed(*before, omega, theirs["speed_mps"]), ("added_mass", "damping"), strict=True):
        other = np.array(theirs[key]) * flip
        assert mine[2, 4] - mine[4, 2] == pytest.approx(other[2, 4] - other[4, 2], rel=0.07)


def test_stations_of_a_mesh_are_those_of_its_formula() -> None:
    """A closed mesh of the same hull, cut: areas under water within 1 %, from waterline to waterline."""
    u, low = -np.cos(np.linspace(0, np.pi, 41)), np.linspace(1, -0.5, 31)
    rim = np.concatenate([np.clip(low, 0, 1), np.clip(low[::-1], 0, 1)])
    height = np.concatenate([0.1875 * low, 0.1875 * low[::-1]])
    sign = np.repeat([-1.0, 1.0], 31)
    rings = [np.stack([np.full(62, 1.5 * x), sign * half_breadth(x, rim), height], -1) for x in u]
    vertices = np.concatenate(rings)
    faces = []
    for i in range(40):
        for j in range(62):
            a, b = i * 62 + j, i * 62 + (j + 1) % 62
            faces += [(a, b, a + 62), (b, b + 62, a + 62)]
    found = mesh_stations(vertices, np.array(faces), 10)
    assert len(found) == 10
    for station in found:
        x = station.position / 1.5
        area = 2 * 0.1875 * float(half_breadth(x, 0.0)) * 2 / 3
        y, z = station.points.T
        assert -float(trapezoid(z, y)) == pytest.approx(area, rel=0.01)
        assert station.side == pytest.approx(0.0, abs=1e-9)
        assert y[0] < 0 < y[-1]
        assert station.width == pytest.approx(0.3, rel=1e-6)
