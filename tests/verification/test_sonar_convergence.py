"""Images converge as rays grow: the energy of each range bin at the default number of rays, without rings."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sonar_scenes import DT_NS, at, context, plane

from cases import slow
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar
from pelagos.sensors.sonar.mechanical_scanning_sonar import MechanicalScanningSonar
from pelagos.sensors.sonar.multibeam import Multibeam
from pelagos.sensors.sonar.profiling_sonar import ProfilingSonar
from pelagos.sensors.sonar.sidescan import Sidescan
from pelagos.sensors.sonar.singlebeam import Singlebeam
from pelagos.sensors.sonar.synthetic_aperture_sonar import SyntheticApertureSonar

QUIET = {"self_noise_db": -200.0, "source_level_db": 300.0, "wind_speed_mps": 0.0, "scale": "linear"}
DEEP = -200.0
DOWN = (0.0, 90.0, 0.0)


@pytest.fixture(autouse=True)
def _plain_surfaces(monkeypatch):
    monkeypatch.setattr("pelagos.sensors.sonar.ping.patches.patch_factor", lambda *_: 1.0)


def by_range(kind: Any, rays: str, factor: int, *, altitude: float, slope: float, **options: Any) -> np.ndarray:
    """Mean energy `(bins,)` over all beams, above a plane, at so many times the default number of rays."""
    default = kind.Config.model_fields[rays].default
    config = kind.Config(**QUIET, **options, **{rays: factor * default})
    return kind(config, context([plane(DEEP - altitude, slope=slope)])).sense(at(0, 0, DEEP)).truth[0].reshape(
        -1, config.bins).astype(float).mean(axis=0)  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "rays", "altitude", "slope", "options"),
    [
        (ImagingSonar, "rays_per_beam", 5.0, 0.0, {"beams": 128}),
        slow(ImagingSonar, "rays_per_beam", 5.0, 0.0, {"beams": 128, "orientation_deg": (0.0, 15.0, 0.0)}),
        (ImagingSonar, "rays_per_beam", 5.0, 0.1, {"beams": 128, "bins": 1024}),
        slow(ProfilingSonar, "rays_per_beam", 10.0, 0.0, {"orientation_deg": DOWN, "range_max_m": 40.0}),
        (ProfilingSonar, "rays_per_beam", 10.0, 0.2, {"orientation_deg": DOWN, "range_max_m": 40.0}),
        (ProfilingSonar, "rays_per_beam", 10.0, 0.0, {"orientation_deg": (0.0, 30.0, 0.0), "range_max_m": 60.0}),
        slow(ProfilingSonar, "rays_per_beam", 10.0, 0.0, {"orientation_deg": (0.0, 60.0, 0.0), "range_max_m": 40.0}),
        (MechanicalScanningSonar, "rays", 5.0, 0.0, {}),
        slow(Sidescan, "rays_per_side", 8.0, 0.0, {}),
        (Sidescan, "rays_per_side", 8.0, 0.1, {}),
        (Singlebeam, "rays", 12.0, 0.2, {}),
        slow(Singlebeam, "rays", 12.0, 0.2, {"range_max_m": 20.0}),
        slow(SyntheticApertureSonar, "rays", 10.0, 0.0, {}),
    ],
)
def test_energy_of_each_bin_is_within_a_percent_of_the_converged_image(kind, rays, altitude, slope, options):
    """Root mean square over the bins within 10 dB of the strongest, against 8 times as many rays."""
    found, best = (by_range(kind, rays, k, altitude=altitude, slope=slope, **options) for k in (1, 8))
    loud = best > 0.1 * best.max()
    assert found.sum() == pytest.approx(best.sum(), rel=2e-3)
    assert np.sqrt(np.mean((found[loud] / best[loud] - 1.0) ** 2)) < 0.01


def test_the_error_falls_with_the_number_of_rays():
    """Strips tile, so that it falls faster than that of random rays, whose error is as 1/sqrt(N)."""
    best = by_range(ImagingSonar, "rays_per_beam", 16, altitude=5.0, slope=0.0, beams=64)
    loud = best > 0.1 * best.max()
    error = []
    for rays in (24, 96):
        config = ImagingSonar.Config(**QUIET, beams=64, rays_per_beam=rays)
        truth = ImagingSonar(config, context([plane(DEEP - 5.0)])).sense(at(0, 0, DEEP)).truth[0].mean(axis=0)
        error.append(np.sqrt(np.mean((truth[loud] / best[loud] - 1.0) ** 2)))
    assert error[1] < 0.5 * error[0]


def test_no_rings_at_the_defaults():
    """The level over a flat bottom has no period in range: no line stands out of the spectrum of its small errors.

    Empty or doubled bins between strips of 0.4 deg would come back every 1 to 3 m. HoloOcean's documentation shows
    such rings at 8 500 rays and none at 68 000; 128 beams of 96 rays are 12 300.
    """
    found = by_range(ImagingSonar, "rays_per_beam", 1, altitude=5.0, slope=0.0, beams=128)
    best = by_range(ImagingSonar, "rays_per_beam", 16, altitude=5.0, slope=0.0, beams=128)
    far = slice(found.size // 2, None)
    ripple = found[far] / best[far] - 1.0
    assert np.abs(ripple).max() < 5e-3
    assert 2.0 * np.abs(np.fft.rfft(ripple - ripple.mean())).max() / ripple.size < 1e-3  # amplitude of a sinusoid


def test_water_column_of_the_multibeam_converges(monkeypatch):
    """Its 24 rays a beam against 192."""
    column = {}
    for rays in (24, 192):
        monkeypatch.setattr("pelagos.sensors.sonar.ping.multibeam_column._RAYS", rays)
        config = Multibeam.Config(beams=64, range_max_m=40.0, water_column_bins=400, source_level_db=300.0)
        reading = Multibeam(config, context([plane(DEEP - 10.0)])).sense(at(0, 0, DEEP))
        column[rays] = (10 ** (reading.extras["water_column_truth"][0].astype(float) / 10)).mean(axis=0)
    found, best = column[24], column[192]
    loud = best > 0.1 * best.max()
    assert np.sqrt(np.mean((found[loud] / best[loud] - 1.0) ** 2)) < 0.01


@pytest.mark.parametrize(
    ("kind", "altitude", "options"),
    [
        (ImagingSonar, 1.0, {"orientation_deg": (0.0, 15.0, 0.0), "range_max_m": 20.0}),
        slow(ImagingSonar, 3.0, {"orientation_deg": (0.0, 15.0, 0.0), "rays_per_beam": 400, "range_max_m": 20.0}),
        slow(ProfilingSonar, 2.0, {"orientation_deg": DOWN, "range_max_m": 10.0}),
        (ProfilingSonar, 20.0, {"orientation_deg": DOWN}),
        slow(ProfilingSonar, 10.0, {"orientation_deg": (0.0, 30.0, 0.0)}),
        (Sidescan, 3.0, {}),
    ],
)
def test_interference_leaves_the_mean_energy_however_dense_the_rays(kind, altitude, options):
    """The data's mean over the truth's, of 30 pings at places apart: rays that meet one facet of the roughness are
    counted, so that their adding in phase does not raise the level; without that it is 1.01 to 4.7.

    Some 10 000 cells of speckle: 1 %. The count takes rows of rays for independent of each other, where they are
    spread more evenly, and as dense as 1/l where they stand at random: 5 % either way where a few rays share a facet.
    """
    sonar = kind(kind.Config(**QUIET, **options), context([plane(DEEP - altitude)]))
    places = np.array([0, 0, DEEP]) + np.arange(30)[:, None] * np.array([0.37, 0.23, 0])
    reading = sonar.sense(lanes(range(30), dt_ns=DT_NS, position=places))
    data, truth = (v.reshape(-1, sonar.config.bins).astype(float) for v in (reading.data, reading.truth))
    heard = truth.mean(axis=0) > 0.01 * truth.mean(axis=0).max()
    assert (data[:, heard].sum() / truth[:, heard].sum()) == pytest.approx(1.0, abs=0.07)
