"""Optical properties of ten kinds of sea water, per camera channel: absorption, scattering, backscatter, attenuation.

How the inherent properties of each Jerlov type are made, wavelength by wavelength:

* Kd, downward diffuse attenuation, is tabulated and taken as it is (I-1C: R. W. Austin and T. J. Petzold, SIO Ref.
  84-3, 1984; 3C-9C: N. G. Jerlov, Marine Optics, 2nd ed. 1976, Table XXVII). It is never used as a beam attenuation.
* b, scattering: pure sea water (A. Morel 1974) plus particles. Measured for IB-5C (C. A. Williamson and R. C. Hollins,
  Appl. Opt. 61:9951, 2022, doi 10.1364/AO.470464, Table 7), where it hardly changes with wavelength: b_p ~
  wavelength^-0.3, large particles of O. V. Kopelevich 1983. Nobody has measured enough of I, IA, 7C and 9C: theirs is
  what M. G. Solonenko and C. D. Mobley, Appl. Opt. 54:5392 (2015), doi 10.1364/AO.54.005392, fitted to Kd.
* a, absorption, is what makes both agree: (Kd m)^2 = a^2 + a G b for sunlight whose cosine from the zenith in the water
  is m (`table_sun`), down to where a tenth is left: the form of J. T. O. Kirk, Limnol. Oceanogr. 29:350, 1984, doi
  10.4319/lo.1984.29.2.0350, equation 8, with G as `radiative_transfer` gives it for the phase functions used here
  (`kirk`). Never below pure water (R. M. Pope and E. S. Fry, Appl. Opt. 36:8710, 1997, doi 10.1364/AO.36.008710). Where
  pure water alone already uses up Kd, particles scatter less, down to none: the clear types in red.
* b_b, backscatter: half of the water's scattering, and 0.0183 of the particles' (Petzold's average particle, C. D.
  Mobley, Light and Water, 1994, Table 3.10).

Channels are broad. A camera's red, green and blue are taken as Gaussians (`CHANNELS_NM`), and each coefficient is its
mean under the channel's sensitivity; absorption is again what makes Kd and scattering agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import LookupFailed
from pelagos.jit import Array

JerlovType: TypeAlias = Literal["I", "IA", "IB", "II", "III", "1C", "3C", "5C", "7C", "9C"]
Triple: TypeAlias = tuple[float, float, float]
Numbers: TypeAlias = float | NDArray[np.float64]

REFRACTIVE_INDEX: Final = (
    1.34  # sea water at 20 degC, 35 g/kg, 550 nm (X. Quan and E. S. Fry, Appl. Opt. 34:3477, 1995)
)
PARTICLE_BACKSCATTER: Final = 0.0183  # share of b_p, Petzold's average particle
MEAN_COSINE: Final = 0.924  # of the same phase function
FORWARD_PEAK: Final = 0.75  # share of the particles' scattering, within 15 degrees, that counts as going straight on

CHANNELS_NM: Final[dict[str, tuple[float, float]]] = {
    "red": (605.0, 30.0),
    "green": (535.0, 38.0),
    "blue": (465.0, 30.0),
}
"""Centre and standard deviation [nm] of each channel, about those of common RGB sensors behind an infrared filter."""

_NM: Final = np.arange(400.0, 701.0, 5.0)
_KD_NM: Final = np.arange(400.0, 701.0, 25.0)
_KD: Final[dict[str, tuple[float, ...]]] = {
    "I": (0.0217, 0.0185, 0.0176, 0.0184, 0.0280, 0.0504, 0.0640, 0.0931, 0.2408, 0.3174, 0.3559, 0.4372, 0.6513),
    "IA": (0.0316, 0.0280, 0.0257, 0.0250, 0.0332, 0.0545, 0.0674, 0.0960, 0.2437, 0.3206, 0.3601, 0.4410, 0.6530),
    "IB": (0.0438, 0.0395, 0.0355, 0.0330, 0.0396, 0.0596, 0.0715, 0.0995, 0.2471, 0.3245, 0.3652, 0.4457, 0.6550),
    "II": (0.0878, 0.0814, 0.0714, 0.0620, 0.0627, 0.0779, 0.0863, 0.1122, 0.2595, 0.3389, 0.3837, 0.4626, 0.6623),
    "III": (0.1697, 0.1594, 0.1381, 0.1160, 0.1056, 0.1120, 0.1139, 0.1359, 0.2826, 0.3655, 0.4181, 0.4942, 0.6760),
    "1C": (0.2516, 0.2374, 0.2048, 0.1700, 0.1486, 0.1461, 0.1415, 0.1596, 0.3057, 0.3922, 0.4525, 0.5257, 0.6896),
    "3C": (0.78, 0.54, 0.39, 0.29, 0.22, 0.20, 0.19, 0.21, 0.33, 0.40, 0.46, 0.56, 0.71),
    "5C": (1.1, 0.78, 0.56, 0.43, 0.36, 0.31, 0.30, 0.33, 0.40, 0.48, 0.54, 0.65, 0.80),
    "7C": (1.6, 1.2, 0.89, 0.71, 0.58, 0.49, 0.46, 0.46, 0.48, 0.54, 0.63, 0.78, 0.92),
    "9C": (2.4, 1.9, 1.6, 1.23, 0.99, 0.78, 0.63, 0.58, 0.60, 0.65, 0.76, 0.92, 1.1),
}  # fmt: skip
JERLOV_TYPES: Final = tuple(_KD)

_B_GREEN: Final[dict[str, float]] = {  # particles and water together, at 550 nm [1/m]
    "I": 0.0017, "IA": 0.0035, "IB": 0.122, "II": 0.177, "III": 0.287,
    "1C": 0.427, "3C": 0.645, "5C": 1.195, "7C": 2.350, "9C": 3.120,
}  # fmt: skip
_PARTICLE_SLOPE: Final = 0.3

_OPEN_SEA: Final = ("I", "IA", "IB", "II", "III")
_GAIN: Final[dict[float, tuple[float, ...]]] = {  # by the light's cosine from the zenith, see `kirk`
    1.00: (1.571, 0.344, 0.158, 0.047, 8.8, 0.062),
    0.98: (1.5747, 0.2866, 0.1577, 0.0383, 7.47, 0.055),
    0.85: (1.5001, 0.2066, 0.1534, 0.0036, 0.5, 0.0341),
}

_PURE_NM: Final = np.arange(400.0, 701.0, 10.0)
_PURE_A: Final = (
    0.00663, 0.00473, 0.00454, 0.00495, 0.00635, 0.00922, 0.00979, 0.0106, 0.0127, 0.0150, 0.0204, 0.0325, 0.0409,
    0.0434, 0.0474, 0.0565, 0.0619, 0.0695, 0.0896, 0.1351, 0.2224, 0.2644, 0.2755, 0.2916, 0.3108, 0.340, 0.410,
    0.439, 0.465, 0.516, 0.624,
)  # fmt: skip


@dataclass(frozen=True)
class WaterOptics:
    """Optical properties of sea water for the three channels (red, green, blue), plain numbers.

    Attributes:
        name: Jerlov type, or where it came from.
        absorption: a [1/m].
        water_scattering: scattering by the water itself, b_w [1/m]; nearly isotropic.
        particle_scattering: b_p [1/m]; strongly forward.
        downwelling: Kd [1/m] of light from the zenith, down to where a tenth is left, see `kirk`: for irradiance from
            above against depth only. `spectra` has the tables'.
    """

    name: str
    absorption: Triple
    water_scattering: Triple
    particle_scattering: Triple
    downwelling: Triple

    @property
    def scattering(self) -> Triple:
        """b = b_w + b_p [1/m]."""
        return _triple(np.add(self.water_scattering, self.particle_scattering))

    @property
    def attenuation(self) -> Triple:
        """Beam attenuation c = a + b [1/m]."""
        return _triple(np.add(self.absorption, self.scattering))

    @property
    def backscatter(self) -> Triple:
        """b_b [1/m]: scattering by more than 90 degrees."""
        particles = np.multiply(PARTICLE_BACKSCATTER, self.particle_scattering)
        return _triple(np.add(np.multiply(0.5, self.water_scattering), particles))

    def arrays(self) -> WaterArrays:
        """The same as Dr.Jit arrays, for frozen functions."""
        import drjit as dr

        water = WaterArrays(*(jit.Array3f(*v) for v in (self.absorption, self.water_scattering,
                                                       self.particle_scattering, self.downwelling)))  # fmt: skip
        dr.make_opaque(water)
        return water


@dataclass
class WaterArrays:
    """`WaterOptics` as a Dr.Jit struct of `Array3f` (red, green, blue) [1/m]."""

    absorption: Array
    water_scattering: Array
    particle_scattering: Array
    downwelling: Array

    def of(self, row: Array) -> WaterArrays:
        """The water of each place, by rows `UInt32` of these."""
        import drjit as dr

        return WaterArrays(*(dr.gather(jit.Array3f, getattr(self, f.name), row) for f in fields(WaterArrays)))

    @property
    def scattering(self) -> Array:
        """b = b_w + b_p [1/m]."""
        return self.water_scattering + self.particle_scattering

    @property
    def attenuation(self) -> Array:
        """Beam attenuation c = a + b [1/m]."""
        return self.absorption + self.scattering

    @property
    def turning(self) -> Array:
        """b_t [1/m]: scattering without the forward peak (delta-Eddington scaling, J. H. Joseph et al. 1976)."""
        return self.water_scattering + (1 - FORWARD_PEAK) * self.particle_scattering

    @property
    def backscatter(self) -> Array:
        """b_b [1/m]."""
        return 0.5 * self.water_scattering + PARTICLE_BACKSCATTER * self.particle_scattering


def several(waters: Sequence[WaterOptics]) -> WaterArrays:
    """The optics of several kinds of water, one after the other."""
    made = []
    for f in fields(WaterArrays):
        rows = np.array([getattr(water, f.name) for water in waters], dtype=np.float32)
        made.append(jit.Array3f(np.ascontiguousarray(rows.T)))
    jit.align(made)
    return WaterArrays(*made)


def water_optics(jerlov_type: str, *, turbidity: float = 1.0) -> WaterOptics:
    """Channel-mean properties of a Jerlov type.

    Args:
        jerlov_type: one of `JERLOV_TYPES`.
        turbidity: factor on the particles' scattering (1 is the type's own); Kd grows with it as `kirk` says.

    Raises:
        LookupFailed: no such type.
    """
    if jerlov_type not in _KD:
        raise LookupFailed("Jerlov water type", jerlov_type, JERLOV_TYPES)
    s = spectra(jerlov_type)
    kd, water, own = (np.array(channel_means(v)) for v in (s.downwelling, s.water_scattering, s.particle_scattering))
    particles = turbidity * own
    a = _absorption(kd, water, own, table_sun(jerlov_type))
    return WaterOptics(
        name=jerlov_type if turbidity == 1 else f"{jerlov_type} with {turbidity:g} x its particles",
        absorption=_triple(a),
        water_scattering=_triple(water),
        particle_scattering=_triple(particles),
        downwelling=_triple(kirk(a, water, particles)),
    )


@dataclass(frozen=True)
class Spectra:
    """Properties of one type against wavelength, each `(61,)` [1/m] at `nm` [nm]."""

    nm: NDArray[np.float64]
    absorption: NDArray[np.float64]
    water_scattering: NDArray[np.float64]
    particle_scattering: NDArray[np.float64]
    downwelling: NDArray[np.float64]

    @property
    def scattering(self) -> NDArray[np.float64]:
        """b = b_w + b_p."""
        return self.water_scattering + self.particle_scattering


def spectra(jerlov_type: str) -> Spectra:
    """400-700 nm in steps of 5 nm, made as the module's docstring says."""
    kd = np.interp(_NM, _KD_NM, _KD[jerlov_type])
    pure = np.interp(_NM, _PURE_NM, _PURE_A)
    water = 0.00288 * (_NM / 500.0) ** -4.32
    particles = max(_B_GREEN[jerlov_type] - 0.00288 * 1.1**-4.32, 0.0) * (_NM / 550.0) ** -_PARTICLE_SLOPE
    sun = table_sun(jerlov_type)
    free = _absorption(kd, water, particles, sun)
    a = np.maximum(free, pure)
    particles = np.where(free < pure, _fewer_particles(kd, a, water, particles, sun), particles)
    return Spectra(_NM, a, water, particles, kd)


def channel_means(spectrum: NDArray[np.float64]) -> Triple:
    """Mean of a spectrum `(61,)` under the sensitivity of red, green and blue."""
    return _triple(channel_weights() @ spectrum)


def channel_weights() -> NDArray[np.float64]:
    """`(3, 61)` share of each 5-nm band in red, green, blue; rows sum to 1."""
    w = np.array([np.exp(-0.5 * ((_NM - mean) / sigma) ** 2) for mean, sigma in CHANNELS_NM.values()])
    return np.asarray(w / w.sum(axis=1, keepdims=True))


def kirk(a: Numbers, water: Numbers, particles: Numbers, *, sun: float = 1.0) -> NDArray[np.float64]:
    """Kd [1/m] for parallel light from above, down to where a tenth is left, of absorption and of scattering by water
    and by particles [1/m].

    A fit to `radiative_transfer.solve`, within 0.3 % up to b_w / a = 0.25, and to b_p / a = 64 (20 unless the light
    comes from the zenith).

    Args:
        a, water, particles: [1/m].
        sun: cosine of the light from the zenith, in the water: 1, or what `table_sun` gives.
    """
    return np.asarray(a / sun * np.sqrt(1 + _gain(np.divide(water, a), np.divide(particles, a), sun)))


def daylight_decay(a: Array, water: Array, particles: Array) -> Array:
    """`kirk` of Dr.Jit arrays."""
    import drjit as dr

    return a * dr.sqrt(1 + _gain(water / a, particles / a))


def _gain(w: Any, p: Any, sun: float = 1.0) -> Any:
    c = _GAIN[sun]
    return w * (c[0] + c[1] * w) + p * (c[2] + c[3] * p / (p + c[4])) + c[5] * w * p / (1 + p / 20)


def table_sun(jerlov_type: str) -> float:
    """Cosine from the zenith, in the water, of the light under which a type's table was made: the sun 90 degrees high
    over the open sea, 45 at the coast (N. G. Jerlov, Optical Oceanography, 1968, Table XXI), as Solonenko and Mobley
    take it in their equation 3.
    """
    return 0.98 if jerlov_type in _OPEN_SEA else 0.85


def _absorption(kd: Numbers, water: Numbers, particles: Numbers, sun: float) -> NDArray[np.float64]:
    """Absorption that `kirk` turns into kd, by fixed point."""
    a = np.asarray(kd, dtype=float)
    for _ in range(60):
        scattered = np.square(sun * kirk(a, water, particles, sun=sun)) / a - a
        a = 0.5 * (np.sqrt(scattered**2 + 4 * np.square(np.multiply(sun, kd))) - scattered)
    return a


def _fewer_particles(kd: Numbers, a: Numbers, water: Numbers, particles: Numbers, sun: float) -> NDArray[np.float64]:
    """Scattering by particles that `kirk` turns into kd, none if water alone uses it up; by bisection."""
    low, high = np.zeros_like(particles), np.array(particles)
    for _ in range(60):
        middle = 0.5 * (low + high)
        over = kirk(a, water, middle, sun=sun) > kd
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    return low


def _triple(values: NDArray[np.float64]) -> Triple:
    r, g, b = (float(v) for v in values)
    return r, g, b
