"""Optical properties that plankton and sediment add, by camera channel, to those of the water type.

* Phytoplankton absorbs 0.06 A(lambda) C^0.65 at C mg/m^3 of chlorophyll (A: L. Prieur and S. Sathyendranath, Limnol.
  Oceanogr. 26:671, 1981) and scatters 0.30 C^0.62 550/lambda (H. R. Gordon and A. Morel 1983).
* Sediment scatters 0.5 m^2 per gram at 555 nm (coastal mean of M. Babin et al., Limnol. Oceanogr. 48:843, 2003, doi
  10.4319/lo.2003.48.2.0843), falling as 1/lambda; a turbidity of 1 NTU stands for 1 g/m^3 (assumed).
"""

from __future__ import annotations

from functools import cache
from typing import Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.water import Triple, WaterArrays, channel_means, daylight_decay, spectra

_NM: Final = np.arange(400.0, 701.0, 10.0)
_PLANKTON: Final = (
    0.687, 0.828, 0.913, 0.973, 1.000, 0.944, 0.917, 0.870, 0.798, 0.750, 0.668, 0.618, 0.528, 0.474, 0.416, 0.357,
    0.294, 0.276, 0.291, 0.282, 0.236, 0.252, 0.276, 0.317, 0.334, 0.356, 0.441, 0.595, 0.502, 0.329, 0.215,
)  # fmt: skip
_SCATTERING_PER_GRAM: Final = 0.5  # [m^2/g]


@cache
def plankton_absorption() -> Triple:
    """Of 1 mg/m^3 of chlorophyll [1/m]."""
    return channel_means(0.06 * np.interp(spectra("I").nm, _NM, _PLANKTON))


@cache
def plankton_scattering() -> Triple:
    """Likewise [1/m]."""
    return channel_means(0.30 * 550.0 / spectra("I").nm)


@cache
def sediment_scattering() -> Triple:
    """Of 1 NTU [1/m]."""
    return channel_means(_SCATTERING_PER_GRAM * 555.0 / spectra("I").nm)


def with_suspended(water: WaterArrays, chlorophyll: Array | None, turbidity: Array | None) -> WaterArrays:
    """The optics of `water` with chlorophyll [mg/m^3] and turbidity [NTU] in it; None for neither."""
    absorption, particles = water.absorption, water.particle_scattering
    if chlorophyll is not None:
        c = dr.maximum(jit.Float(chlorophyll), 1e-6)
        absorption = absorption + jit.Array3f(*plankton_absorption()) * dr.power(c, 0.65)
        particles = particles + jit.Array3f(*plankton_scattering()) * dr.power(c, 0.62)
    if turbidity is not None:
        particles = particles + jit.Array3f(*sediment_scattering()) * dr.maximum(jit.Float(turbidity), 0)
    decay = daylight_decay(absorption, water.water_scattering, particles)
    return WaterArrays(absorption, water.water_scattering + 0, particles, decay)
