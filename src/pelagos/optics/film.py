"""Development of a picture's numbers from a sensor's: white balance, and curves from linear light to display values."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from pelagos.jit import Array
from pelagos.optics.exposure import GREY
from pelagos.optics.water import CHANNELS_NM, Triple

_PLANCK = 1.438777e7  # h c / k [nm K], CODATA 2018
_WHITE_K = 6500.0


def balance_gains(temperature_k: float, tint: float) -> Triple:
    """Gains of red, green, blue that make light of a black body's colour white (Planck's law at the channels' centres).

    Args:
        temperature_k: of the light [K]; 6500 changes nothing.
        tint: -1 .. 1, stops by which green is weakened against red and blue; positive is magenta.
    """
    gains = [_planck(nm, _WHITE_K) / _planck(nm, temperature_k) for nm, _ in CHANNELS_NM.values()]
    r, g, b = (gain / gains[1] for gain in gains)
    return r, g * 2.0**-tint, b


def _planck(nm: float, kelvin: float) -> float:
    """Spectral radiance of a black body, up to a constant."""
    return float(nm**-5 / math.expm1(_PLANCK / (nm * kelvin)))


@dataclass(frozen=True)
class FilmCurve:
    """A film's response over log10 of exposure: a straight part between two bends, passing through middle grey.

    Attributes:
        slope: of the straight part.
        toe, shoulder: 0 .. 1, how much of the range the dark and the bright bend take.
        black_clip, white_clip: how far beyond 0 and 1 the bends would go, so that they are cut off.
    """

    slope: float = 0.88
    toe: float = 0.55
    shoulder: float = 0.26
    black_clip: float = 0.0
    white_clip: float = 0.04


def film(x: Array, curve: FilmCurve) -> Array:
    """Linear exposure (1 is a full pixel) -> linear display value 0 .. 1.

    The generalised ACES curve of common game engines: two logistic bends of log10 x, blended smoothly, with middle
        grey kept.
    """
    dark, bright = 1 + curve.black_clip - curve.toe, 1 + curve.white_clip - curve.shoulder
    grey = math.log10(GREY)
    if curve.toe > 0.8:
        toe_at = (1 - curve.toe - GREY) / curve.slope + grey
    else:
        bend = (GREY + curve.black_clip) / dark - 1
        toe_at = grey - 0.5 * math.log((1 + bend) / (1 - bend)) * dark / curve.slope
    middle = (1 - curve.toe) / curve.slope - toe_at
    shoulder_at = curve.shoulder / curve.slope - middle
    u = dr.log2(dr.maximum(x, 1e-7)) * math.log10(2)
    straight = curve.slope * (u + middle)
    low = 2 * dark / (1 + dr.exp(-2 * curve.slope / dark * (u - toe_at))) - curve.black_clip
    high = 1 + curve.white_clip - 2 * bright / (1 + dr.exp(2 * curve.slope / bright * (u - shoulder_at)))
    low = dr.select(u < toe_at, low, straight)
    high = dr.select(u > shoulder_at, high, straight)
    t = dr.clip((u - toe_at) / (shoulder_at - toe_at), 0, 1)
    t = 1 - t if shoulder_at < toe_at else t
    return dr.clip(dr.lerp(low, high, t * t * (3 - 2 * t)), 0, 1)
