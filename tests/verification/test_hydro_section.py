"""Waves about sections against closed forms: a circle, a thin plate, energy, and what reciprocity demands."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import iv, kv

from pelagos.errors import InputError
from pelagos.hydro.section import SectionWaves, section_added_mass, section_radiation, section_waves

G = 9.81


def arc(half: float, draught: float, skew: float = 0.0, panels: int = 80) -> np.ndarray:
    """Half an ellipse, its keel moved to starboard by `skew` of the draught."""
    angle = np.linspace(np.pi, 2 * np.pi, panels + 1)
    y, z = half * np.cos(angle), draught * np.sin(angle)
    z[[0, -1]] = 0.0
    return np.stack([y - skew * z, z], axis=-1)


def far(found: SectionWaves) -> np.ndarray:
    """Damping (3) by the energy of the waves that leave: 2 P / |v|^2 = g c_g (|A port|^2 + |A starboard|^2)."""
    return G * found.group_velocity * (np.abs(found.radiated) ** 2).sum(axis=0)


def test_half_a_circle_at_infinite_frequency() -> None:
    """Heave pi R^2 / 2, sway 2 R^2 / pi (F. M. Lewis 1929; F. Ursell 1949), roll about the centre none. Eighty chords
    take 0.1 % of the area, the bottom 20 radii below adds 0.1 %, and potentials are constant on panels: 0.5 %.
    """
    found = section_added_mass(arc(1.3, 1.3))
    assert found[1, 1] == pytest.approx(np.pi / 2 * 1.69, rel=5e-3)
    assert found[0, 0] == pytest.approx(2 / np.pi * 1.69, rel=5e-3)
    assert np.abs(found[2]).max() < 1e-3


@pytest.mark.parametrize(("omega", "depth"), [(1.6, None), (2.9, None), (2.1, 1.5), (3.4, 0.9), (0.7, 2.0)])
def test_energy_and_reciprocity(omega: float, depth: float | None) -> None:
    """Of a section that is not the same on both sides. What damping takes leaves as waves; a wave pushes as hard as the
    wave that the motion sends back towards it is high (Haskind 1957; J. N. Newman 1962): |X| = 2 g c_g |A|; what a held
    hull reflects and lets pass is the wave; coefficients are symmetric. Forty panels a wave, and ends three depths off:
    1.5 %.
    """
    found = section_waves(arc(0.9, 0.6, skew=-0.4), omega, depth=depth)
    assert far(found) == pytest.approx(np.diag(found.damping), rel=0.015)
    assert np.abs(found.excitation) == pytest.approx(2 * G * found.group_velocity * np.abs(found.radiated[0]), rel=0.02)
    assert abs(found.reflected) ** 2 + abs(found.transmitted) ** 2 == pytest.approx(1.0, abs=0.015)
    for matrix in (found.added_mass, found.damping):
        scale = np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))
        assert np.abs(matrix - matrix.T).max() < 0.01 * scale.max()
    assert abs(found.damping[0, 1]) > 0.001 * np.sqrt(found.damping[0, 0] * found.damping[1, 1])  # sway heaves here


@pytest.mark.parametrize("ka", [0.3, 0.8])
def test_thin_plate_lets_pass_what_ursell_found(ka: float) -> None:
    """F. Ursell, Proc. Camb. Phil. Soc. 43:374 (1947): |T| = K1 / sqrt(pi^2 I1^2 + K1^2) of ka for a plate of draught a
    in deep water. One 2 % of a thick lets pass less by the order of its thickness: 0.03.
    """
    a = 0.7
    down = a * (1 - np.cos(np.linspace(0, np.pi, 61))) / 2
    t = 0.01 * a
    plate = np.concatenate([np.stack([0 * down - t, -down], -1), np.stack([0 * down + t, -down[::-1]], -1)])
    found = section_waves(plate, np.sqrt(G * ka / a))
    exact = kv(1, ka) / np.hypot(np.pi * iv(1, ka), kv(1, ka))
    assert abs(found.transmitted) == pytest.approx(exact, abs=0.03)
    assert abs(found.reflected) == pytest.approx(np.sqrt(1 - exact**2), abs=0.03)


def test_long_waves_feel_the_waterplane_and_the_volume() -> None:
    """Undisturbed pressure, at 0.35 rad/s in deep water, k times the draught 0.005: heave g B - g k S, sway -i g k S
    with S the section's area, roll i k g times the moment of B^3 / 12 and of the area about the surface.
    """
    points = arc(0.8, 0.4)
    found = section_waves(points, 0.35)
    k, beam, area = found.wavenumber, 1.6, np.pi / 2 * 0.8 * 0.4
    assert found.froude_krylov[1] == pytest.approx(G * (beam - k * area), rel=3e-3)
    assert found.froude_krylov[0] == pytest.approx(-1j * G * k * area, rel=3e-3)
    depth_of_center = 4 * 0.4 / 3 / np.pi
    assert found.froude_krylov[2] == pytest.approx(1j * G * k * (beam**3 / 12 - area * depth_of_center), rel=5e-3)
    assert k == pytest.approx(0.35**2 / G, rel=1e-3)


def test_deep_water_is_water_of_a_wavelength() -> None:
    """Two tanks of other panels, each within 1 %."""
    deep, shallow = (section_waves(arc(0.5, 0.7), 4.0, depth=d) for d in (None, 2 * np.pi * G / 16))
    assert deep.added_mass == pytest.approx(shallow.added_mass, rel=0.02, abs=0.01)
    assert deep.excitation == pytest.approx(shallow.excitation, rel=0.02, abs=0.02)


def test_mirrored_section() -> None:
    """Mirrored coefficients: couplings of sway and roll with heave turn."""
    one, other = (section_waves(arc(0.6, 0.8, skew=s), 3.0, depth=2.0) for s in (0.5, -0.5))
    sign = np.outer([-1, 1, -1], [-1, 1, -1])
    assert one.added_mass == pytest.approx(sign * other.added_mass, abs=1e-6)
    assert one.damping == pytest.approx(sign * other.damping, abs=1e-6)


@pytest.mark.parametrize(
    ("points", "depth", "message"),
    [
        (arc(1, 1)[::-1], None, "from the waterline"),
        (arc(1, 1) - [0, 0.1], None, "from the waterline"),
        (np.abs(arc(1, 1)), None, "from the waterline"),
        (arc(1, 1)[:5], None, "at least 9"),
        (arc(1, 1), 0.9, "more than the draught"),
        (np.repeat(arc(1, 1), 2, axis=0), None, "without a point twice"),
    ],
)
def test_impossible_sections(points: np.ndarray, depth: float | None, message: str) -> None:
    with pytest.raises(InputError, match=message):
        section_waves(points, 2.0, depth=depth)
    with pytest.raises(InputError, match=message):
        section_added_mass(points, depth=depth)


def test_sections_whose_sides_differ() -> None:
    """Waterlines at 2.4 m to port and 0.5 m to starboard: both sides of the surface have panels of their own."""
    y = np.linspace(-2.4, 0.5, 81)
    points = np.stack([y, -0.6 * np.sqrt(np.clip((y + 2.4) * (0.5 - y), 0.0, None))], axis=-1)
    found = section_waves(points, 2.2, depth=1.6)
    assert far(found) == pytest.approx(np.diag(found.damping), rel=0.015)
    assert abs(found.reflected) ** 2 + abs(found.transmitted) ** 2 == pytest.approx(1.0, abs=0.015)


def test_waves_too_short_for_the_panels_are_refused() -> None:
    with pytest.raises(InputError, match="need more than 4000 panels; take a lower omega"):
        section_waves(arc(1, 1), 40.0)


@pytest.mark.parametrize("omega", [0.0, -1.0, np.nan, np.inf])
def test_impossible_frequency(omega: float) -> None:
    with pytest.raises(InputError, match="omega must be a positive number"):
        section_waves(arc(1, 1), omega)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_scattering_by_the_sections_own_motion(side: float) -> None:
    """Force of the scattered wave from potentials of sway, heave and roll (Haskind), against the one solved for, of a
    section that is not the same on both sides, in waves to either; deep water: 2 %.
    """
    points, omega = arc(0.9, 0.6, skew=-0.4), 2.3
    found = -1j * omega * section_radiation(points, omega).scattered(omega, side)
    mirrored = points if side > 0 else (points * [-1, 1])[::-1]
    force = section_waves(mirrored, omega).diffraction * ([1, 1, 1] if side > 0 else [-1, 1, -1])
    assert found == pytest.approx(force, abs=0.02 * np.abs(force).max())
    added = section_radiation(points, omega).momentum.real
    assert added == pytest.approx(section_waves(points, omega).added_mass, rel=1e-12, abs=1e-12)
