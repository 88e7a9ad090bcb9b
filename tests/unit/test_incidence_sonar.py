"""The sonar by incidence alone: its rays, its cells, its noise, by themselves."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.sensors.sonar.incidence_sonar import IncidenceSonar, IncidenceSonarConfig, _rays


def bare(beam: Any = (), **keys: Any) -> IncidenceSonar:
    """Its arithmetic, without a world."""
    made = object.__new__(IncidenceSonar)
    made.config, made._beam = IncidenceSonarConfig(**keys), np.array(beam)
    return made


@pytest.mark.parametrize("beams", [3, 100])
def test_rays_of_a_sector_go_from_left_to_right_and_from_below_to_above(beams: int) -> None:
    config = IncidenceSonarConfig(beams=beams, horizontal_aperture_deg=70.0, vertical_aperture_deg=24.0)
    direction, beam = _rays(config)
    azimuth = np.degrees(np.arctan2(direction[:, 1], direction[:, 0]))
    elevation = np.degrees(np.arcsin(direction[:, 2]))
    assert np.linalg.norm(direction, axis=1) == pytest.approx(1.0)
    assert (beam == np.floor((35.0 - azimuth) / 70.0 * beams)).all()
    across, up = np.unique(azimuth.round(9)), np.unique(elevation.round(9))
    assert len(across) == beams * max(4, math.ceil(256 / beams))
    assert len(up) == 64
    for even, aperture in ((across, 70.0), (up, 24.0)):
        step = aperture / len(even)
        assert even == pytest.approx(-aperture / 2 + step * (np.arange(len(even)) + 0.5), abs=1e-6)


def test_rays_of_a_cone_are_even_over_its_disc() -> None:
    """As many within each part of it as its area says; all round about x."""
    direction, beam = _rays(IncidenceSonarConfig(beams=1, cone=True, horizontal_aperture_deg=30.0))
    off = np.degrees(np.arccos(direction[:, 0]))
    assert off.max() < 15.0
    for part in (0.3, 0.5, 0.8, 1.0):
        assert (off <= 15.0 * part).mean() == pytest.approx(part**2, abs=1e-3)
    assert np.abs(direction[:, 1:].mean(axis=0)).max() < 1e-3
    quarter = np.arctan2(direction[:, 2], direction[:, 1]) // (math.pi / 2)
    assert np.bincount(quarter.astype(int) + 2, minlength=4) == pytest.approx(len(off) / 4, abs=3)
    assert (beam == 0).all()


def test_a_cell_is_the_mean_of_what_falls_into_it() -> None:
    """Two beams of four bins from 2 to 4 m; what lies before, beyond or nowhere counts for none."""
    sonar = bare([0, 0, 0, 1, 1, 1, 1, 0], beams=2, bins=4, range_min_m=2.0, range_max_m=4.0)
    distance = np.array([2.0, 2.49, 3.6, 3.99, 3.2, 4.0, np.inf, 1.99])
    echo = np.array([0.2, 0.6, 0.5, 0.7, 0.3, 0.9, 0.8, 0.95])
    assert sonar._image(distance, echo) == pytest.approx(np.array([[0.4, 0.0, 0.0, 0.5], [0.0, 0.0, 0.3, 0.7]]))


class Drawn:
    """A stream whose draws are known."""

    normal, ray = np.array([[0.5, -1.0, 2.0, 0.3]]), np.array([[0.7, 1.2, 0.1, 2.0]])

    def standard_normal(self, shape: tuple[int, int]) -> np.ndarray:
        return np.broadcast_to(self.normal, shape)

    def rayleigh(self, scale: float, shape: tuple[int, int]) -> np.ndarray:
        return scale * np.broadcast_to(self.ray, shape)


@pytest.mark.parametrize("scaled", [False, True])
def test_noise_multiplies_and_adds_and_may_grow_with_range_and_towards_the_middle(scaled: bool) -> None:
    """image (gain + m N) + R(a), the latter times (k/bins)^2 (1 + exp(-azimuth^2/(aperture/64))/2) of bin k."""
    keys = {"gain": 0.5, "multiplicative": 0.2, "additive": 0.03, "scale_noise": scaled}
    sonar = bare(beams=3, bins=4, horizontal_aperture_deg=9.0, **keys)
    image = np.arange(12.0).reshape(3, 4) / 7
    found = sonar._noise(image.copy(), Drawn())  # type: ignore[arg-type]
    for b, azimuth in enumerate((3.0, 0.0, -3.0)):
        for k in range(4):
            rain = 0.03 * Drawn.ray[0, k]
            if scaled:
                rain *= (k / 4) ** 2 * (1 + 0.5 * math.exp(-(azimuth**2) / (9.0 / 64)))
            assert found[b, k] == pytest.approx(image[b, k] * (0.5 + 0.2 * Drawn.normal[0, k]) + rain)


def test_ranges_err_late_and_fade() -> None:
    """Echoes go from r to r + n and from e to e exp(-n/mean), n exponential of that mean; truth has none."""
    sonar = bare(np.zeros(4000, int), beams=1, bins=50, range_min_m=1.0, range_max_m=6.0, range_error_m=0.4, gain=0.6)
    sonar._strength = 0.8
    sonar._met = lambda _: (np.full((2, 4000), 2.05), np.full((2, 4000), 0.5))  # type: ignore[method-assign]
    words: Any = lambda *_: {"words": np.array([[1, 2, 3, 4], [1, 2, 3, 5]], np.uint32)}
    sonar._streams, sonar._key = words, None
    reading = sonar.sense(SimpleNamespace())  # type: ignore[arg-type]
    assert reading.truth[:, 0, 10] == pytest.approx(0.6 * 0.8 * 0.5)
    assert (np.delete(reading.truth, 10, axis=2) == 0.0).all()
    late = (np.arange(50) + 0.5) * 0.1 - 1.05
    for k in (12, 18, 25):  # within a bin of 0.1 m the factor varies by 28 %
        assert reading.data[:, 0, k] == pytest.approx(0.6 * 0.8 * 0.5 * math.exp(-late[k] / 0.4), rel=0.08)
    assert (reading.data[:, 0, :10] == 0.0).all()
    assert (reading.data[0] != reading.data[1]).any()
