"""Roll damping of ships after Ikeda: friction, waves, eddies, bilge keels and lift.

The hull's components are those of the formula that its authors fitted to Ikeda's method over conventional cargo ships:
Y. Kawahara, K. Maekawa, Y. Ikeda, A simple prediction formula of roll damping of conventional cargo ships on the basis
of Ikeda's method and its limitation, Proc. STAB 2009 and doi 10.1007/978-94-007-1482-3_26. The lift is that of Ikeda,
Himeno and Tanaka 1978, as ITTC procedure 7.5-02-07-04.5 (2011) has it. Damping is an equivalent linear one, B44,
without dimension: B44 sqrt(B/2g)/(rho V B^2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray

from pelagos.math.constants import GRAVITY

VISCOSITY: Final = 1.14e-6  # of fresh water at 15 degC, as in the formula [m^2/s]
AMPLITUDES: Final = np.radians(np.arange(1.0, 21.0))
"""Over which linear and quadratic damping are told apart [rad]."""


@dataclass(frozen=True)
class RollForm:
    """The hull as the formula has it.

    Attributes:
        length, beam, draught: [m].
        block, midship: coefficients of fineness [-].
        depth_of_gravity: of the centre of gravity below the waterline [m], negative above it.
        keel_length, keel_breadth: of the bilge keels [m]; 0 without.
    """

    length: float
    beam: float
    draught: float
    block: float
    midship: float
    depth_of_gravity: float
    keel_length: float = 0.0
    keel_breadth: float = 0.0

    @property
    def volume(self) -> float:
        """Displaced [m^3]."""
        return self.length * self.beam * self.draught * self.block


@dataclass(frozen=True)
class RollComponents:
    """Equivalent linear damping without dimension, by its cause, at one amplitude and frequency."""

    friction: float
    waves: float
    eddies: float
    keels: float

    @property
    def total(self) -> float:
        """Their sum."""
        return self.friction + self.waves + self.eddies + self.keels


def roll_components(form: RollForm, amplitude: float, frequency: float) -> RollComponents:
    """Ikeda's components at rest for an amplitude [rad] and a frequency [rad/s].

    Fitted for B/d 2.5 .. 4.5, block coefficients 0.5 .. 0.85, midship 0.9 .. 0.99, OG/d -1.5 .. 0.2, frequencies up to
    sqrt(2g/B), bilge keels of 0.05 .. 0.4 L and 0.01 .. 0.06 B.
    """
    ratio, below = form.beam / form.draught, form.depth_of_gravity / form.draught
    reduced = frequency * np.sqrt(form.beam / 2 / GRAVITY)
    return RollComponents(
        _friction(form, frequency),
        _waves(ratio, form.block, form.midship, 1 - below, reduced),
        _eddies(ratio, form.block, form.midship, below, reduced * amplitude),
        _keels(form, ratio, below, float(np.degrees(amplitude))) * reduced if form.keel_length > 0 else 0.0,
    )


def roll_damping(form: RollForm, frequency: float, density: float) -> tuple[float, float]:
    """Linear [N m s] and quadratic [N m s^2] damping that dissipate what the components do in harmonic roll.

    They are exact without bilge keels; see `linear_and_quadratic`.
    """
    scale = density * form.volume * form.beam**2 / np.sqrt(form.beam / 2 / GRAVITY)
    damping = [scale * roll_components(form, float(a), frequency).total for a in AMPLITUDES]
    return linear_and_quadratic(damping, frequency)


def linear_and_quadratic(damping: Sequence[float], frequency: float) -> tuple[float, float]:
    """Linear [N m s] and quadratic [N m s^2] damping of equivalent linear ones [N m s], none below 0, at `AMPLITUDES`.

    Over a period |p| p of an amplitude a is worth (8/3 pi) a w p, so the quadratic one is the slope over a w. Least
    squares in which neither part may be below 0: the damping of narrow bilge keels grows faster than the amplitude, and
    the free fit's negative intercept would drive small rolls. Such keels have a quadratic part alone.

    frequency: of roll [rad/s].
    """
    slope, zero = np.polyfit(AMPLITUDES, damping, 1)
    if zero < 0:
        slope, zero = np.dot(AMPLITUDES, damping) / np.dot(AMPLITUDES, AMPLITUDES), 0.0
    elif slope < 0:
        slope, zero = 0.0, np.mean(damping)
    return float(zero), float(slope * 3 * np.pi / (8 * frequency))


def roll_lift(form: RollForm, density: float) -> float:
    """Damping of the lift at forward speed, by speed [N s^2]: B44 = this times U."""
    kappa = 0.0 if form.midship <= 0.92 else 0.1 if form.midship <= 0.97 else 0.3
    slope = 2 * np.pi * form.draught / form.length + kappa * (4.1 * form.beam / form.length - 0.045)
    lift, rise, below = 0.3 * form.draught, 0.5 * form.draught, form.depth_of_gravity
    arm = lift * rise * (1 - 1.4 * below / rise + 0.7 * below**2 / (lift * rise))
    return float(density / 2 * form.length * form.draught * slope * arm)


def _friction(form: RollForm, frequency: float) -> float:
    """Laminar, Kato: independent of the amplitude, whose first power Blasius's law takes away."""
    ratio, below = form.beam / form.draught, form.depth_of_gravity / form.draught
    radius = form.draught * ((0.887 + 0.145 * form.block) * (1.7 + form.block * ratio) - 2 * below) / np.pi
    surface = form.length * (1.75 * form.draught + form.block * form.beam)
    period = 2 * np.pi / frequency
    coefficient = 1.328 * (3.22 * radius**2 / (period * VISCOSITY)) ** -0.5  # times 1/amplitude
    damping = 4 / (3 * np.pi) * surface * radius**3 * frequency * coefficient  # by the density
    return float(damping / (form.volume * form.beam**2) * np.sqrt(form.beam / 2 / GRAVITY))


def _waves(ratio: float, block: float, midship: float, height: float, reduced: float) -> float:
    """By B/d, Cb, Cm, 1 - OG/d and the reduced frequency: a log-normal hump, fitted."""
    size = _poly(height, [_nested(_SIZE[k], ratio, block) for k in range(3)])
    size *= 1 + (_nested(_SIZE_BELOW[1], ratio, block) * midship + _nested(_SIZE_BELOW[0], ratio, block)) * (1 - height)
    width = _poly(height, [9.45, -10.993, 7.189, -1.402])
    middle = _poly(height, [_poly(block, c) for c in _MIDDLE]) + _middle_below(ratio, block, height)
    return float(size / reduced * np.exp(-width * (np.log(reduced) - middle) ** 2 / 1.44))


def _middle_below(ratio: float, block: float, height: float) -> float:
    form = _poly(block, [8.8007, -33.234, 41.495, -17.102]) * height + _poly(block, [-18.108, 71.8, -89.203, 36.566])
    share = _poly(ratio, [11.588, -10.356, 3.39, -0.3767]) * form
    shifted = height - _poly(ratio, [-1.2818, 0.7, -0.0727])
    return float(share * (_poly(shifted, _MIDDLE_SHIFTED) + _poly(ratio, [-0.61655, 0.4518, -0.0495])))


def _eddies(ratio: float, block: float, midship: float, below: float, reduced_rate: float) -> float:
    """By B/d, Cb, Cm, OG/d and the reduced frequency times the amplitude."""
    size = (-0.0182 * block + 0.0155) * (ratio - 1.8) ** 3
    size += _poly(block, [-14.848, 93.894, -215.883, 215.695, -79.414])
    first = (3.98 * block - 5.1525) * (-0.2 * ratio + 1.6) * below
    first *= _poly(block, [0.723, -1.55, 0.9717]) * below + 0.04567 * block + 0.9408
    second = (0.25 * below + 0.95) * below + _poly(block, [59.6, -283.3, 443.7, -219.2])
    power = -15.0 * block * ratio + 46.5 * block + 11.2 * ratio - 28.6
    drag = size * np.exp(first + second * midship**power)
    return float(4 * reduced_rate / (3 * np.pi * block * ratio**3) * drag)


def _keels(form: RollForm, ratio: float, below: float, degrees: float) -> float:
    """Of bilge keels, by the reduced frequency."""
    breadth, length = form.keel_breadth / form.beam, form.keel_length / form.length
    size = (-0.3651 * form.block + 0.3907) * (ratio - 2.83) ** 2 - 2.21 * form.block + 2.632
    size *= _poly(degrees, [0.4794, 0.122, 0.00255])
    size *= _poly(length, [0.0, _poly(breadth, [0.00189, -0.01185, 5.2857]), _poly(breadth, [0, -0.0733, -0.8913])])
    first = (5.0 * breadth + 0.3 * ratio - 0.2 * length + _poly(degrees, [-1.86, -0.0425, 0.00125])) * below
    second = -15.0 * breadth + 1.2 * form.block - 0.1 * ratio + _poly(below, [1.6164, 0.0586, -0.0657])
    return float(size * np.exp(first + second * form.midship ** (2.5 * below + 15.75)))


def _poly(x: float, coefficients: Sequence[float]) -> float:
    """Coefficients by power from 0."""
    return float(polyval(x, coefficients))


def _nested(rows: NDArray[np.float64], ratio: float, block: float) -> float:
    """Polynomial in Cb whose coefficients are polynomials in B/d; rows by power of Cb, columns by power of B/d."""
    return _poly(block, [_poly(ratio, row) for row in rows])


_SIZE: Final = (  # by power of the height: rows by power of Cb from 0, columns by power of B/d from 0
    np.array([
        [5.894703, -4.407535, 0.966362, -0.067119], [-20.539908, 16.368376, -3.535062, 0.237096],
        [29.007851, -23.974852, 5.222348, -0.350563], [-14.764856, 12.507855, -2.787462, 0.192207],
    ]),
    np.array([
        [-10.2018992, 6.9427931, -1.2494083, 0.0018704, 0.0107667],
        [31.4113508, -21.8126569, 3.1949667, 0.2639704, -0.0589333],
        [-37.7729778, 25.1269741, -2.2186833, -0.8108963, 0.1140667],
        [16.616327, -10.7918672, 0.52735, 0.4989259, -0.0628667],
    ]),
    np.array([
        [1.834167, -1.084987, 0.220371, -0.015422], [-1.641389, 0.904989, -0.161176, 0.010185],
        [0.599424, -0.286866, 0.040871, -0.002222],
    ]),
)  # fmt: skip
_SIZE_BELOW: Final = (  # without and with Cm
    np.array([
        [236.579, -235.827, 79.549, -8.56], [-660.665, 658.027, -222.507, 24.015],
        [463.848, -460.689, 156.399, -16.872],
    ]),
    np.array([
        [-250.787, 249.983, -84.332, 9.077], [701.494, -698.683, 236.275, -25.507],
        [-493.142, 489.799, -166.294, 17.945],
    ]),
)  # fmt: skip
_MIDDLE: Final = (  # by power of the height, each by power of Cb
    (20467.0904, -196679.7143, 780020.9393, -1634256.8172, 1907356.1357, -1175773.1606, 299122.8727),
    (-55751.1528, 538548.1194, -2143487.3508, 4500543.147, -5256636.5472, 3238899.7308, -822735.9289),
    (46600.823, -457313.6939, 1839829.259, -3888378.9905, 4553780.5017, -2803850.2395, 709672.0656),
    (-4774.6414, 58039.7328, -264294.7189, 599411.9264, -724186.4643, 446051.22, -110034.6584),
    (-10682.8619, 95501.4948, -358360.7392, 722677.104, -826728.7127, 507996.2604, -130677.4903),
    (4714.7918, -43358.7938, 166348.6917, -340629.4699, 392579.5937, -241201.0598, 61639.9103),
    (-577.8827, 5355.2035, -20665.147, 42480.7709, -49048.9664, 30131.5678, -7686.0287),
)
_MIDDLE_SHIFTED: Final = (
    0.0, -7.1654, 44.13177, -141.40915, 257.68705, -274.05701, 172.84571, -63.70534, 12.688, -1.05584,
)  # fmt: skip
