"""Speed of sound in sea water by the classical formulas; the ocean itself uses TEOS-10."""

from __future__ import annotations

import drjit as dr

from pelagos.jit import Array


def mackenzie(temperature: Array, salinity: Array, depth: Array) -> Array:
    """Sound speed [m/s] for temperature 2-30 [deg C], practical salinity 25-40, depth 0-8000 [m].

    Source: K. V. Mackenzie, J. Acoust. Soc. Am. 70, 807 (1981), doi 10.1121/1.386920.
    """
    T, s, D = temperature, salinity - 35.0, depth
    return (
        1448.96
        + T * (4.591 + T * (-5.304e-2 + 2.374e-4 * T))
        + 1.340 * s
        + D * (1.630e-2 + 1.675e-7 * D)
        - 1.025e-2 * T * s
        - 7.139e-13 * T * D * D * D
    )


def chen_millero(temperature: Array, salinity: Array, pressure: Array) -> Array:
    """Sound speed [m/s]; temperature 0-40 [deg C, ITS-90], practical salinity 0-40, pressure 0-1000 [bar].

    Source: C.-T. Chen and F. J. Millero, J. Acoust. Soc. Am. 62, 1129 (1977), doi 10.1121/1.381646, with the ITS-90
    coefficients of G. S. K. Wong and S. Zhu, J. Acoust. Soc. Am. 97, 1732 (1995), doi 10.1121/1.413048, Table II.
    Up to 0.64 m/s above TEOS-10 in the deep sea.
    """
    T, S, p = temperature, salinity, pressure
    c0 = _poly(T, 1402.388, 5.03830, -5.81090e-2, 3.3432e-4, -1.47797e-6, 3.1419e-9)
    c1 = _poly(T, 0.153563, 6.8999e-4, -8.1829e-6, 1.3632e-7, -6.1260e-10)
    c2 = _poly(T, 3.1260e-5, -1.7111e-6, 2.5986e-8, -2.5353e-10, 1.0415e-12)
    c3 = _poly(T, -9.7729e-9, 3.8513e-10, -2.3654e-12)
    a0 = _poly(T, 1.389, -1.262e-2, 7.166e-5, 2.008e-6, -3.21e-8)
    a1 = _poly(T, 9.4742e-5, -1.2583e-5, -6.4928e-8, 1.0515e-8, -2.0142e-10)
    a2 = _poly(T, -3.9064e-7, 9.1061e-9, -1.6009e-10, 7.994e-12)
    a3 = _poly(T, 1.100e-10, 6.651e-12, -3.391e-13)
    b = _poly(T, -1.922e-2, -4.42e-5) + p * _poly(T, 7.3637e-5, 1.7950e-7)
    d = 1.727e-3 - 7.9836e-6 * p
    return _poly(p, c0, c1, c2, c3) + S * _poly(p, a0, a1, a2, a3) + b * S * dr.sqrt(S) + d * S * S


def del_grosso(temperature: Array, salinity: Array, pressure: Array) -> Array:
    """Sound speed [m/s]; temperature 0-30 [deg C, IPTS-68], practical salinity 30-40, pressure 0-1000 [kg/cm^2].

    Source: V. A. Del Grosso, J. Acoust. Soc. Am. 56, 1084 (1974), doi 10.1121/1.1903388, Table IX. Temperatures of
    ITS-90 are to be multiplied by 1.00024 first; 1 dbar is 0.101971621 kg/cm^2.
    """
    T, S, P = temperature, salinity, pressure
    of_t = T * (5.01109398873 + T * (-5.50946843172e-2 + T * 2.21535969240e-4))
    of_s = S * (1.32952290781 + S * 1.28955756844e-4)
    of_p = P * (0.156059257041 + P * (2.44998688441e-5 - 8.83392332513e-9 * P))
    of_all = (
        -1.27562783426e-2 * T * S
        + 6.35191613389e-3 * T * P
        + 2.65484716608e-8 * T * T * P * P
        - 1.59349479045e-6 * T * P * P
        + 5.22116437235e-10 * T * P * P * P
        - 4.38031096213e-7 * T * T * T * P
        - 1.61674495909e-9 * S * S * P * P
        + 9.68403156410e-5 * T * T * S
        + 4.85639620015e-6 * T * S * S * P
        - 3.40597039004e-4 * T * S * P
    )
    return 1402.392 + of_t + of_s + of_p + of_all


def _poly(x: Array, *coefficients: Array) -> Array:
    """c0 + c1 x + c2 x^2 + ..., by Horner's rule."""
    value = coefficients[-1]
    for c in coefficients[-2::-1]:
        value = value * x + c
    return value
