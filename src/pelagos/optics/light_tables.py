"""Tables of daylight in the water, solved on the host once for a kind of water under a sky."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.optics.phase import PEAK_EDGE
from pelagos.optics.radiative_transfer import MODES, Above, Field, gauss, media, mirror, solve
from pelagos.optics.sunlight import Daylight, beam_and_mean_sky
from pelagos.optics.water import FORWARD_PEAK, MEAN_COSINE, REFRACTIVE_INDEX, WaterOptics

SHALLOW: Final = 0.1  # [m]
_DEEPEST: Final = 400.0  # [m]
LEVELS: Final = 56
ROWS: Final = 384  # of irradiance: fine enough to take the nearest
UPS: Final = 33  # of u = d_z, -1 .. 1
SIDES: Final = 9  # of azimuth from the sun, 0 .. pi
TERMS: Final = 8  # of irradiance; one is idle
CRITICAL_COSINE: Final = math.sqrt(1 - REFRACTIVE_INDEX**-2)
MOLECULES: Final = 1 / (4 * math.pi)


@dataclass(frozen=True)
class Solved:
    """Tables on the host, see `LightField`."""

    beam: NDArray[np.float64]
    loss: NDArray[np.float64]
    fading: NDArray[np.float64]
    decay: NDArray[np.float64]
    irradiance: NDArray[np.float32]
    radiance: NDArray[np.float32]
    calm: NDArray[np.float32]
    source: NDArray[np.float32]


@lru_cache(maxsize=32)
def solved(water: WaterOptics, light: Daylight) -> Solved:
    """The tables for a kind of water under a sky."""
    depths = SHALLOW * np.expm1(depth_step(LEVELS) * np.arange(LEVELS))
    rows = SHALLOW * np.expm1(depth_step(ROWS) * np.arange(ROWS))
    fields = [solve(m, a, depths) for m, a in zip(media(water), entering(light), strict=True)]
    ups = np.linspace(-1, 1, UPS)
    ups[UPS // 2] = 1e-3
    waves = np.cos(np.arange(MODES)[:, None] * np.linspace(0, math.pi, SIDES))  # (MODES, sides)
    radiance, calm, source = np.zeros((3, LEVELS, UPS, SIDES, 4))
    terms = np.zeros((ROWS, 3, TERMS))
    loss = np.add(water.absorption, water.water_scattering) + np.multiply(1 - FORWARD_PEAK, water.particle_scattering)
    for c, field in enumerate(fields):
        excess = field.medium.attenuation - loss[c]
        radiance[..., c] = field.at(ups) @ waves
        source[..., c] = field.source(ups) @ waves - excess * radiance[..., c]
        for rate, sign in ((field.medium.attenuation, 1.0), (loss[c], -1.0)):
            once, made = _turned_once(field, rate, ups, np.linspace(0, math.pi, SIDES))
            radiance[..., c] += sign * once
            source[..., c] += sign * made - (excess * once if sign > 0 else 0)
        calm[..., c] = _calmed(np.maximum(radiance[..., c], 0), once, field, loss[c], ups)
        for k, column in enumerate(_irradiance_terms(field, loss[c])):
            terms[:, c, k] = np.interp(rows, depths, column)
    return Solved(
        beam=np.array([f.above.sun for f in fields]),
        loss=loss,
        fading=np.array([f.medium.attenuation for f in fields]),
        decay=np.array([f.medium.decay for f in fields]),
        irradiance=terms.astype(np.float32),
        radiance=np.maximum(radiance, 0).astype(np.float32),
        calm=calm.astype(np.float32),
        source=np.maximum(source, 0).astype(np.float32),
    )


_MOST: Final = 700.0  # exponent; e^709 is the largest number


def _turned_once(
    field: Field, rate: float, ups: NDArray[np.float64], sides: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The beam's light that is turned once and lost at a rate, over e^{-K z}: radiance and source."""
    above, medium = field.above, field.medium
    mu = above.towards_sun
    sine = np.sqrt(np.maximum(1 - ups**2, 0) * (1 - mu**2))
    cosine = np.minimum(ups[:, None] * mu + sine[:, None] * np.cos(sides), PEAK_EDGE)
    g = MEAN_COSINE
    particles = (1 - g * g) / (4 * math.pi) / (1 + g * g - 2 * g * cosine) ** 1.5
    made = (medium.molecules * MOLECULES + medium.particles * particles) * above.sun
    made = made * np.exp((medium.decay - rate / mu) * field.depths)[:, None, None]  # (levels, ups, sides)
    up = ups > 0
    way = np.where(up, field.depths[:, None] / np.where(up, ups, 1), 1e4)
    along = rate * (1 - ups / mu)
    along = np.where(np.abs(along) < 1e-6, 1e-6, along)
    gained = np.minimum(-along * way, _MOST)  # beyond it the sun's beam itself is 0 there
    return made * (-np.expm1(gained) / along)[..., None], made


def _calmed(
    radiance: NDArray[np.float64], once: NDArray[np.float64], field: Field, loss: float, ups: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Radiance with its brightest part cut off, so that with light turned once (`once`) it gives what irradiance there
    is on level ground besides the beam."""
    side = np.full(SIDES, 2 * math.pi / (SIDES - 1))
    side[[0, -1]] /= 2
    weight = (np.maximum(ups, 0) * 2 / (UPS - 1))[:, None] * side
    weight[-1] /= 2
    mu, u = field.above.towards_sun, field.u
    fall = [np.exp((field.medium.decay - rate / mu) * field.depths) for rate in (loss, field.medium.attenuation)]
    down = 2 * math.pi * field.radiance[:, :, 0] @ (field.weight * np.maximum(u, 0))
    wanted = down - field.above.sun * mu * (fall[0] - fall[1]) - np.sum(once * weight, axis=(1, 2))
    wanted -= _window_irradiance(field, loss) - _window_irradiance(field, field.medium.attenuation)
    low, high = np.zeros(len(wanted)), radiance.max(axis=(1, 2))
    for _ in range(40):
        cap = 0.5 * (low + high)
        over = np.sum(np.minimum(radiance, cap[:, None, None]) * weight, axis=(1, 2)) > wanted
        low, high = np.where(over, low, cap), np.where(over, cap, high)
    return np.asarray(np.minimum(radiance, high[:, None, None]))


def _window_irradiance(field: Field, rate: float) -> NDArray[np.float64]:
    """Irradiance of the sky itself on level ground where it is lost at a rate, over e^{-K z}, `(levels,)`."""
    v = field.above.window_u
    kept = np.exp((field.medium.decay - rate / v) * field.depths[:, None])
    return np.asarray(2 * math.pi * kept @ (field.above.window_weight * field.above.window * v))


def entering(light: Daylight) -> list[Above]:
    """Light of sun and sky that gets through a level surface, by channel."""
    n = REFRACTIVE_INDEX
    high = max(light.towards_sun[2], 0.0)
    mu = math.sqrt(1 - (1 - high * high) / n**2)
    u, weight = gauss(CRITICAL_COSINE, 1, 16)
    air = np.sqrt(1 - (1 - u * u) * n * n)
    through = (1 - mirror(u)) * n * n
    passed = (1 - float(mirror(np.array(mu)))) * high / mu
    found = []
    beam, sky = beam_and_mean_sky(light, air)
    for sun, radiance in zip(beam, sky.T, strict=True):
        found.append(Above(mu, float(sun) * passed, u, weight, radiance * through))
    return found


def _irradiance_terms(field: Field, loss: float) -> list[NDArray[np.float64]]:
    """Factors of 1, n_x, n_z, n_x^2, n_z^2, n_x n_z, n_z^4, each `(depths,)`; x is towards the sun.

    E(n) is the integral of L max(n . d, 0), and max(x, 0) = 1/4 + x/2 + 5/16 P_2(x) - 3/32 P_4(x) + ... (R. Ramamoorthi
    and P. Hanrahan, SIGGRAPH 2001, doi 10.1145/383259.383317); of the fourth order only what is even about the zenith.
    """
    u, across = field.u, np.sqrt(1 - field.u**2)
    above = field.above
    faded = np.exp((field.medium.decay - field.medium.attenuation / above.window_u) * field.depths[:, None])
    sky = 2 * math.pi * faded * above.window * above.window_weight

    # the beam takes along what is scattered by a few degrees: it is not counted twice
    sine = math.sqrt(1 - above.towards_sun**2)
    fall = [np.exp((field.medium.decay - rate / above.towards_sun) * field.depths)
            for rate in (field.medium.attenuation, loss)]  # fmt: skip
    beamed = above.sun * (fall[1] - fall[0])

    def zonal(f: Any) -> NDArray[np.float64]:
        diffuse = 2 * math.pi * field.radiance[:, :, 0] @ (field.weight * f(u)) + sky @ f(above.window_u)
        return np.asarray(diffuse - beamed * f(np.array(above.towards_sun)))

    def mode(m: int, f: NDArray[np.float64], of_sun: float) -> NDArray[np.float64]:
        return np.asarray(math.pi * field.radiance[:, :, m] @ (field.weight * f) - beamed * of_sun)

    def fourth(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return (35 * x**4 - 30 * x**2 + 3) / 8

    whole, zz = zonal(np.ones_like), zonal(np.square)
    spread = 0.5 * mode(2, across**2, sine**2)
    xx, yy = 0.5 * (whole - zz) + spread, 0.5 * (whole - zz) - spread
    p4 = -3 / 32 * zonal(fourth)
    q = 15 / 32
    return [
        (0.25 - 5 / 32) * whole + q * yy + 3 / 8 * p4,
        0.5 * mode(1, across, sine),
        0.5 * zonal(lambda v: v),
        q * (xx - yy),
        q * (zz - yy) - 30 / 8 * p4,
        2 * q * mode(1, u * across, above.towards_sun * sine),
        35 / 8 * p4,
    ]


def depth_step(count: int) -> float:
    """B in the depths 0.1 (e^{B i} - 1) m of so many levels."""
    return math.log1p(_DEEPEST / SHALLOW) / (count - 1)
