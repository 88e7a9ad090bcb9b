"""Whitecaps: as much of the surface breaks as the wind makes white, on the crests."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.whitecaps import whitecap_share


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
