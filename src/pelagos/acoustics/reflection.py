"""Reflection at the boundary of two fluids."""

from __future__ import annotations

import drjit as dr

from pelagos.acoustics.complex_pair import Pair, divide, root
from pelagos.jit import Array


def fluid_reflection(sine: Array, density_ratio: Array, sound_speed_ratio: Array, loss: Array) -> Pair:
    """Plane-wave reflection coefficient of a lossy fluid half-space, real and imaginary part.

    R = (y - 1)/(y + 1), y = rho sin(theta)/sqrt(kappa^2 - cos^2 theta), kappa = (1 + i delta)/nu.

    Args:
        sine: sine of the grazing angle theta.
        density_ratio: rho, of the bottom to the water.
        sound_speed_ratio: nu, of the bottom to the water.
        loss: delta, imaginary over real wavenumber.

    Source: APL-UW TR 9407 (1994), Section IV, Eqs. 23-25; the time convention is exp(-i omega t).
    """
    p = vertical_wavenumber(sine, sound_speed_ratio, loss)
    y = divide((density_ratio * sine, 0.0 * sine), p)
    return divide((y[0] - 1.0, y[1]), (y[0] + 1.0, y[1]))


def vertical_wavenumber(sine: Array, sound_speed_ratio: Array, loss: Array) -> Pair:
    """P = sqrt(kappa^2 - cos^2 theta), the bottom's vertical wavenumber over that of the water [1]."""
    kr, ki = 1.0 / sound_speed_ratio, loss / sound_speed_ratio
    return root((kr * kr - ki * ki - (1.0 - sine * sine), 2.0 * kr * ki))


def bottom_loss_db(reflection: Pair) -> Array:
    """-20 log10 |R| [dB]."""
    return -10.0 * dr.log2(reflection[0] ** 2 + reflection[1] ** 2) * 0.30102999566398120
