"""Whitecaps: as much of the surface breaks as the wind makes white, on the crests."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pelagos import jit
from pelagos.math.constants import GRAVITY
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.wave_system import Components, PiersonMoskowitzWavesConfig, RegularWavesConfig
from pelagos.ocean.whitecaps import NEVER, breaking_limit, whitecap_share, wind_behind


def sea(**said: Any) -> Any:
    return build_ocean(OceanConfig.model_validate(said), seed=2)


def field(ocean: Any, what: str, *, t: float = 5.0) -> np.ndarray:
    x, y = np.meshgrid(np.arange(0, 1600, 4.0), np.arange(0, 1600, 4.0))
    call = getattr(ocean.waves, what)
    return np.array(call(jit.Float64(x.ravel()), jit.Float64(y.ravel()), jit.Float64(t)))


@pytest.mark.parametrize(("wind", "share"), [(7.0, 0.0029), (10.0, 0.0099), (15.0, 0.0394)])
def test_monahans_whitecaps(wind: float, share: float) -> None:
    """Their formula's own values; at 10 m/s the sea is one per cent white."""
    assert whitecap_share(wind) == pytest.approx(share, rel=0.02)


@pytest.mark.parametrize("wind", [10.0, 15.0])
def test_as_much_breaks_as_the_wind_makes_white(wind: float) -> None:
    """Gaussian surface: the share beyond the limit is Monahan's. 400 x 400 places, some thousand patches: 15 %."""
    ocean = sea(waves={"type": "sea_state", "state": 6}, wind={"speed_mps": wind})
    falling = field(ocean, "_falling")
    assert np.mean(falling > np.array(ocean.waves.limit)[0]) == pytest.approx(whitecap_share(wind), rel=0.15)
    foam, height = field(ocean, "foam"), field(ocean, "elevation")
    assert 0 <= foam.min() <= foam.max() <= 1
    assert height[falling > np.array(ocean.waves.limit)[0]].mean() > 0.5 * height.std()  # on crests


@pytest.mark.parametrize(("state", "low", "high"), [(4, 0.002, 0.015), (6, 0.02, 0.07)])
def test_without_wind_the_sea_itself_says_how_white_it_is(state: int, low: float, high: float) -> None:
    """Beaufort 4 to 5 has some white horses, 7 has foam in streaks."""
    ocean = sea(waves={"type": "sea_state", "state": state})
    assert low < np.mean(field(ocean, "_falling") > np.array(ocean.waves.limit)[0]) < high


@pytest.mark.parametrize(
    "waves",
    [
        {"type": "sea_state", "state": 2},
        {"type": "ochi_hubble", "significant_height_m": 2.0, "peak_period_s": 15.0, "sharpness": 6},
        {"type": "regular", "height_m": 0.5, "period_s": 8.0},
    ],
)
def test_swell_and_small_seas_do_not_break(waves: dict[str, Any]) -> None:
    assert not sea(waves=waves).waves.breaks


@pytest.mark.parametrize("wind", [6.0, 11.0, 17.0])
def test_a_fully_developed_sea_tells_the_wind_that_raised_it(wind: float) -> None:
    """Pierson and Moskowitz's by its wind U19.5, which a neutral profile makes 0.93 of at 10 m (a drag of 1.3e-3).

    Hs = 2 sqrt(alpha / beta) U^2 / g is 0.2092 U^2 / g, 0.21 to two digits, and beyond 6 peak frequencies lies the
    share 1 - exp(-1.25 / 6^4) of the energy: together 0.2 % of the wind. Quadrature by eights: 1e-5.
    """
    sea = PiersonMoskowitzWavesConfig(wind_mps=wind).components(np.random.default_rng(3), None)
    height = 2 * np.sqrt(0.0081 / 0.74 * np.exp(-1.25 / 6**4))
    assert wind_behind(sea) == pytest.approx(0.93 * wind * np.sqrt(height / 0.21), rel=1e-5)
    assert wind_behind(sea) == pytest.approx(0.93 * wind, rel=3e-3)


@pytest.mark.parametrize(("share", "white"), [(0.15, 0.0), (0.26, 0.2), (0.41, 0.7), (0.6, 1.0)])
@pytest.mark.parametrize("period", [5.0, 9.0])
def test_the_steeper_a_sea_the_more_of_it_is_wind_sea(share: float, white: float, period: float) -> None:
    """Between a fifth and a half of the 0.051 of a developed sea; one wave is as steep as 2 pi Hs / (g T^2)."""
    height = share * 0.051 * GRAVITY * period**2 / (2 * np.pi)
    wave = RegularWavesConfig(height_m=height / np.sqrt(2), period_s=period).components(np.random.default_rng(0), None)
    assert wind_behind(wave) == pytest.approx(white * 0.93 * np.sqrt(height * GRAVITY / 0.21), rel=1e-9, abs=1e-6)


def test_the_limit_is_that_deviation_beyond_which_the_share_lies() -> None:
    """Acceleration's deviation over g of two waves sqrt(a^2 w^4 + b^2 v^4) / (sqrt 2 g), times the normal quantile."""
    two = np.array([0.8, 0.3]), np.array([0.7, 1.9])
    waves = Components(*two, *np.zeros((3, 2)))
    deviation = np.sqrt(0.5 * (0.8**2 * 0.7**4 + 0.3**2 * 1.9**4)) / GRAVITY
    share = 3.84e-6 * 12.0**3.41
    assert share == pytest.approx(0.01839, rel=1e-3)
    assert breaking_limit(waves, 12.0) == pytest.approx(2.0885 * deviation, rel=1e-3)  # of a table: z(0.01839) = 2.0885
    assert breaking_limit(waves, 1.2) == NEVER  # 7 millionths
    assert breaking_limit(waves, 1.5) < 5 * deviation
    assert breaking_limit(Components(*np.zeros((5, 1))), 12.0) == NEVER
    assert whitecap_share(60.0) == 0.5


def test_a_flat_sea_has_no_wind_behind_it() -> None:
    zero = np.zeros(3)
    assert wind_behind(Components(zero, zero + 0.7, zero + 0.05, zero, zero)) == 0
    assert wind_behind(Components(zero + 0.3, zero + 2.0, zero + 0.4, zero, zero)) > 0
