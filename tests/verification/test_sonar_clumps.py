"""Reverberation of few scatterers: K-distributed intensities, by the size of what a sample hears, adrift."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy.special import gamma, kv
from scipy.stats import gamma as gamma_law
from scipy.stats import kstest
from sonar_scenes import StillWater, at, context, plane

from pelagos import jit
from pelagos.acoustics.gamma_texture import gamma_table, gamma_texture
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig

DEEP = -500.0
SPARSE = {
    "beams": 128, "bins": 1200, "range_min_m": 2.0, "range_max_m": 32.0, "rays_per_beam": 8, "iq": True,
    "side_lobe_beams": 0, "self_noise_db": -200.0, "source_level_db": 230.0, "volume_scattering_db": -50.0,
    "horizontal_aperture_deg": 120.0, "scale": "linear",
}  # fmt: skip


@pytest.mark.parametrize("shape", [0.07, 0.31, 1.0, 2.6, 17.0, 150.0])
def test_textures_are_gamma_distributed(shape):
    """A million scores: mean one, variance 1/nu, the tail of the law; the table is linear between 129 scores and 49
    shapes 19 % apart, 2 % of a variance."""
    score = np.random.Generator(np.random.PCG64(3)).standard_normal(1_000_000).astype(np.float32)
    table = jit.Float(gamma_table())
    found = np.array(gamma_texture(table, jit.Float(shape), jit.Float(score)), dtype=np.float64)
    assert found.mean() == pytest.approx(1.0, abs=0.01 + 4 / math.sqrt(shape * 1e6))
    assert found.var() == pytest.approx(1.0 / shape, rel=0.04)
    for part in (0.5, 0.9, 0.999):
        quantile = gamma_law.ppf(part, shape) / shape
        assert np.mean(found > quantile) == pytest.approx(1.0 - part, rel=0.06)


def intensities(ocean: Any = None, ticks: tuple[int, ...] = (0,), **options: Any) -> tuple[ImagingSonar, np.ndarray]:
    """A sonar in open water, and intensities over their mean by tick, beam and bin."""
    s = ImagingSonar(ImagingSonarConfig(**(SPARSE | options)), context([plane(-3000.0)], ocean=ocean))
    found = [s.sense(at(0.0, 0.0, DEEP, tick=k)) for k in ticks]
    mean = _mean(s, found)
    return s, np.array([np.abs(r.extras["iq"][0]) ** 2 / mean for r in found])


def _mean(s: ImagingSonar, readings: list[Any]) -> np.ndarray:
    """Mean intensity of each beam and range before gain, without clumps: a law of the range by one of beams.

    24 pings of 1200 bins: a beam's mean to 0.6 %.
    """
    plain = ImagingSonar(s.config.model_copy(update={"volume_scatterers_per_m3": None}), context([plane(-3000.0)]))
    pings = [plain.sense(at(0.0, 0.0, DEEP, tick=k)) for k in range(24)]
    for reading in readings:
        level = pings[0].truth[0] / np.maximum(reading.truth[0], 1e-30)
        assert level == pytest.approx(np.ones_like(level), rel=1e-3)  # clumps leave the mean as it is
    intensity = [np.abs(p.extras["iq"][0]) ** 2 for p in pings]
    r = s.tables["range"].astype(float)
    fitted = np.polyfit(np.log(r), np.log(np.mean(intensity, axis=(0, 1))), 4)
    by_range = np.exp(np.polyval(fitted, np.log(r)))
    return np.mean(np.array(intensity) / by_range, axis=(0, 2))[:, None] * by_range


def test_intensities_are_k_distributed_by_range():
    """nu = density times beam width, fan height, pulse depth and r^2; <I^2>/<I>^2 = 2 (1 + 1/nu), and the law's tail.

    128 beams over 130 ranges of the same nu within 10 %; the second moment of K has a heavy tail: 12 %.
    """
    s, found = intensities(volume_scatterers_per_m3=300.0, ticks=(1, 2, 3))
    r = s.tables["range"].astype(float)
    width = 1.056 / (0.886 * 1.1294 / math.radians(1.0))  # of the light-shaded array, broadside [rad]
    azimuth = s.tables["azimuth"].astype(float)
    depth = 1.5 * 1500.0 / (2 * 30e3)
    for distance, slack in ((5.0, 0.15), (11.0, 0.12), (28.0, 0.08)):
        near = np.abs(r / distance - 1) < 0.05
        nu = 300.0 * width / np.cos(azimuth) * math.radians(20.0) * depth * distance**2
        ahead = np.abs(azimuth) < math.radians(30)
        sample = found[:, ahead][:, :, near].reshape(-1)
        moment = (sample**2).mean() / sample.mean() ** 2
        shape = 1.0 / np.mean(1.0 / nu[ahead])
        assert sample.mean() == pytest.approx(1.0, rel=0.1)
        assert moment == pytest.approx(2 * (1 + 1 / shape), rel=slack)
        level = np.quantile(sample, 0.99)
        tail = 2 / gamma(shape) * (shape * level) ** (shape / 2) * kv(shape, 2 * math.sqrt(shape * level))
        assert tail == pytest.approx(0.01, rel=0.35)


def test_many_scatterers_are_rayleigh_s_speckle():
    _, found = intensities(volume_scatterers_per_m3=1e9)
    sample = found[0][::3, 600::4].reshape(-1)
    assert kstest(sample / sample.mean(), "expon").statistic < 1.8 / math.sqrt(len(sample))


@dataclass
class Stream(StillWater):
    """Water that flows by `flow` [m/s] along x; a struct."""

    flow: Any = None

    def current(self, position, t, copy=None):
        still = 0.0 * position[0]
        return jit.Array3f64(still + self.flow, still, still)


def test_clumps_stand_still_in_still_water_and_go_with_the_current():
    """The logarithm of smoothed intensities is alike from ping to ping; in a current it is alike one shift later."""
    at_rest, moving = (Stream(dr.opaque(jit.Float64, 1500.0), dr.opaque(jit.Float64, flow)) for flow in (0.0, 0.75))
    keys = {"volume_scatterers_per_m3": 30.0, "horizontal_aperture_deg": 8.0, "beams": 64, "beamwidth_deg": 0.2}
    _, still = intensities(at_rest, ticks=(0, 200), **keys)
    s, gone = intensities(moving, ticks=(0, 200), **keys)
    log = lambda v: np.log(v + 1e-6) - np.log(v + 1e-6).mean(axis=0)
    alike = lambda a, b: float((log(a) * log(b)).mean() / math.sqrt((log(a) ** 2).mean() * (log(b) ** 2).mean()))
    assert alike(still[0], still[1]) > 0.25
    assert alike(gone[0], gone[1]) < 0.1
    shift = round(0.75 / s.config.bin_width_m)  # a second of the current, along the beams
    middle = slice(24, 40)
    assert alike(gone[0][middle, :-shift], gone[1][middle, shift:]) > 0.2


def test_elements_hear_the_same_clumps():
    _, plain = intensities(volume_scatterers_per_m3=20.0, beams=32, horizontal_aperture_deg=30.0)
    _, raw = intensities(volume_scatterers_per_m3=20.0, beams=32, horizontal_aperture_deg=30.0, elements=True)
    a, b = (v[0, :, 200:600].mean(axis=0) for v in (plain, raw))
    assert np.corrcoef(np.log(a), np.log(b))[0, 1] > 0.3
