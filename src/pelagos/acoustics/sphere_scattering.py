"""Echo of a sphere at any frequency: the exact sum over spherical waves, for rigid, soft, fluid and elastic spheres.

Form functions are backscattering amplitudes f [m], far away from the sphere: TS = 20 log10 |f|. Host-side NumPy:
sonars evaluate them once for each target, not per ping.

Sources: V. C. Anderson, J. Acoust. Soc. Am. 22, 426 (1950), doi 10.1121/1.1906621 (fluid sphere); J. J. Faran, J.
Acoust. Soc. Am. 23, 405 (1951), doi 10.1121/1.1906780, and R. R. Goodman and R. Stern, J. Acoust. Soc. Am. 34, 338
(1962), doi 10.1121/1.1928120 (elastic sphere); K. G. Foote, J. Acoust. Soc. Am. 71, 742 (1982), doi 10.1121/1.387497
(standard targets).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Filling:
    """Material of a sphere.

    Attributes:
        density, speed: density and compressional sound speed over those of the water [1].
        shear: shear wave speed over the water's sound speed [1]; 0: a fluid.
    """

    density: float
    speed: float
    shear: float = 0.0


def sphere_form(
    radius: float, frequency_hz: ArrayLike, filling: Filling | None, *, sound_speed: float, soft: bool = False
) -> NDArray[np.complex128]:
    """Backscattering amplitude f [m] of a sphere, of the shape of `frequency_hz`.

    Args:
        radius: a [m].
        frequency_hz: [Hz].
        filling: what it is made of; None: a rigid sphere, or with `soft` a pressure-release one.
        sound_speed: of the water [m/s].
        soft: see `filling`.
    """
    ka = np.atleast_1d(2.0 * math.pi * np.asarray(frequency_hz, dtype=np.float64) * radius / sound_speed)
    orders = np.arange(int(np.ceil(ka.max() + 4.0 * ka.max() ** (1 / 3))) + 8)
    terms = _wave_coefficients(orders[:, None], ka[None, :], filling, soft=soft)
    total = ((2 * orders[:, None] + 1) * (-1.0) ** orders[:, None] * terms).sum(axis=0)
    form = -1j * total * radius / ka
    return np.asarray(form.reshape(np.shape(frequency_hz)))


def sphere_strength(
    radius: float, frequency_hz: ArrayLike, filling: Filling | None, *, sound_speed: float, soft: bool = False
) -> NDArray[np.float64]:
    """Target strength 20 log10 |f| [dB re 1 m^2]; arguments as of `sphere_form`."""
    form = sphere_form(radius, frequency_hz, filling, sound_speed=sound_speed, soft=soft)
    return np.asarray(20.0 * np.log10(np.abs(form)))


def _wave_coefficients(
    n: NDArray[np.integer], x: NDArray[np.float64], filling: Filling | None, *, soft: bool
) -> NDArray[np.complex128]:
    """Part of each outgoing spherical wave, from the boundary's conditions; 0 beyond what doubles can tell.

    With L the load of the sphere, pressure over displacement's slope as x j'(x)/j(x) of a fluid would be, the
    coefficient is -(L j - x j')/(L h - x h').
    """
    from scipy.special import spherical_jn, spherical_yn

    j, dj = spherical_jn(n, x), spherical_jn(n, x, derivative=True)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        h = j + 1j * spherical_yn(n, x)
        dh = dj + 1j * spherical_yn(n, x, derivative=True)
        if filling is None:
            found = -j / h if soft else -dj / dh
        else:
            load = _elastic_load(n, x, filling) if filling.shear > 0.0 else _fluid_load(n, x, filling)
            found = -(load * j - x * dj) / (load * h - x * dh)
    return np.where(np.isfinite(found), found, 0.0)


def _fluid_load(n: NDArray[np.integer], x: NDArray[np.float64], filling: Filling) -> NDArray[np.float64]:
    from scipy.special import spherical_jn

    inside = x / filling.speed
    return np.asarray(inside * spherical_jn(n, inside, derivative=True) / spherical_jn(n, inside) / filling.density)


def _elastic_load(n: NDArray[np.integer], x: NDArray[np.float64], filling: Filling) -> NDArray[np.float64]:
    """Load of an elastic sphere, from the determinants of Goodman and Stern: compressional and shear waves inside,
    no shear stress at the surface."""
    from scipy.special import spherical_jn

    xl, xt = x / filling.speed, x / filling.shear
    jl, djl = spherical_jn(n, xl), xl * spherical_jn(n, xl, derivative=True)
    jt, djt = spherical_jn(n, xt), xt * spherical_jn(n, xt, derivative=True)
    m = n * (n + 1.0)
    # displacement, tangential stress and normal stress of both waves, times the radius (stress over 2 mu)
    ul, ut = djl, m * jt
    tl, tt = djl - jl, (m - 1.0 - 0.5 * xt**2) * jt - djt
    sl, st = (m - 0.5 * xt**2) * jl - 2.0 * djl, m * (djt - jt)
    # waves l + b t with tangential stress tl + b tt = 0 (n > 0; n = 0 has no shear wave)
    b = np.where(n > 0, -tl / np.where(tt == 0.0, 1.0, tt), 0.0)
    displacement, stress = ul + b * ut, sl + b * st
    # pressure -2 mu stress/a; the slope of the water's pressure is rho w^2 a times the displacement
    return np.asarray(-displacement * xt**2 / (2.0 * stress) / filling.density)
