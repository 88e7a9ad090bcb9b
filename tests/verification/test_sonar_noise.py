"""The noise of sonars in water without echoes: independent from beam to beam, bin to bin and ping to ping."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pytest
from sonar_scenes import at, context, plane

from pelagos.sensors.sonar.altimeter import Altimeter, AltimeterConfig
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.mechanical_scanning_sonar import MechanicalScanningSonar, MechanicalScanningSonarConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.profiling_sonar import ProfilingSonar, ProfilingSonarConfig
from pelagos.sensors.sonar.sidescan import Sidescan, SidescanConfig
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.sensors.sonar.synthetic_aperture_sonar import SyntheticApertureSonar, SyntheticApertureSonarConfig

PINGS, BINS = 6, 160
UNLIKELY = 1e-7  # that any of a test's correlations is beyond its bound by chance

KINDS: dict[str, Any] = {
    "sidescan": (Sidescan, SidescanConfig(bins=BINS, range_max_m=40.0, iq=True)),
    "imaging": (ImagingSonar, ImagingSonarConfig(beams=37, bins=BINS, range_max_m=20.0, iq=True)),
    "imaging, beams apart": (
        ImagingSonar, ImagingSonarConfig(beams=21, bins=BINS, range_max_m=20.0, iq=True, side_lobe_beams=0)
    ),
    "profiling": (ProfilingSonar, ProfilingSonarConfig(beams=19, bins=BINS, range_max_m=20.0, iq=True)),
    "mechanical": (
        MechanicalScanningSonar, MechanicalScanningSonarConfig(bins=BINS, range_max_m=20.0, rays=64, iq=True)
    ),
    "singlebeam": (Singlebeam, SinglebeamConfig(bins=BINS, range_max_m=20.0, iq=True)),
    "aperture": (SyntheticApertureSonar, SyntheticApertureSonarConfig(bins=BINS, range_min_m=9.0, range_max_m=11.0)),
    "multibeam": (
        Multibeam, MultibeamConfig(beams=32, range_max_m=30.0, water_column_bins=BINS, iq=True, rate_hz=5.0)
    ),
    "altimeter": (Altimeter, AltimeterConfig(range_max_m=30.0, water_column_bins=BINS, iq=True)),
}  # fmt: skip

WHERE = {"multibeam": "water_column_iq"}


def noise_of(kind: str) -> np.ndarray:
    """`(pings, beams, bins)`, of unit power in each bin."""
    make, config = KINDS[kind]
    sonar = make(config, context([plane(-3000.0)]))
    pings = []
    for k in range(PINGS):
        reading = sonar.sense(at(0.0, 0.0, -500.0, tick=400 * k))
        pings.append(reading.data[0] if kind == "aperture" else reading.extras[WHERE.get(kind, "iq")][0])
    signal = np.asarray(pings, np.complex128).reshape(PINGS, -1, np.shape(pings[0])[-1])
    return signal / np.sqrt((np.abs(signal) ** 2).mean(axis=(0, 1)))


@pytest.mark.parametrize("kind", KINDS)
def test_noise_of_beams_bins_and_pings_is_independent(kind: str) -> None:
    """Of complex noise the square of a mean product over N numbers is exponential, of mean 1/N."""
    signal = noise_of(kind)
    beams = signal.shape[1]
    for ping, bin_ in product((0, 1, 2), (0, 1, 2, 3)):
        a, b = signal[: PINGS - ping, :, : signal.shape[2] - bin_], signal[ping:, :, bin_:]
        count = a.shape[0] * a.shape[2]
        found = np.abs(np.einsum("pbk,pck->bc", a, b.conj())) / count
        if (ping, bin_) == (0, 0):
            assert np.allclose(found.diagonal(), 1.0, atol=6.0 / math.sqrt(count))  # power is exponential
            np.fill_diagonal(found, 0.0)
        assert found.max() < math.sqrt(math.log(12 * beams**2 / UNLIKELY) / count), f"{ping} pings, {bin_} bins apart"
