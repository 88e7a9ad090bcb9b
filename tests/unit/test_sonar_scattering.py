"""The table of what surfaces scatter: all materials at once give what each gives alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics.sea_surface import bubble_backscatter
from pelagos.sensors.sonar.ping.surface_scattering import mirror_table, scattering_table
from pelagos.world.material import MATERIALS

ALL = [MATERIALS[name] for name in ("sand", "steel", "mud", "concrete", "rock")]
ALL.insert(2, replace(MATERIALS["steel"], corner_m=0.3))


@pytest.mark.parametrize("frequency_hz", [5e3, 5e4, 4e5])  # below, in and above the range of TR 9407
@pytest.mark.parametrize("table", [scattering_table, mirror_table])
def test_each_material_has_the_row_that_it_has_alone(table, frequency_hz) -> None:
    together = table(ALL, frequency_hz, wind_speed=5.0)
    assert together.shape == (len(ALL) + 1, 181)
    assert np.isfinite(together).all()
    assert (together >= 0).all()
    for row, material in zip(together, ALL, strict=False):
        assert np.array_equal(row, table([material], frequency_hz, wind_speed=5.0)[0])


def test_without_materials_the_sea_surface_is_left() -> None:
    assert scattering_table([], 4e5, wind_speed=5.0).shape == (1, 181)
    assert mirror_table([], 4e5, wind_speed=5.0).shape == (1, 181)


@pytest.mark.parametrize(
    ("wind_speed", "density"),
    [
        (4.0, 10**-3.3773),
        (9.0, 10**-1.0268),
        (14.0, 10**-0.0866 * (14 / 11) ** 3.5),
        (18.0, 10**-0.0866 * (18 / 11) ** 3.5),
    ],
)
def test_bubbles_grow_with_the_wind_and_slower_from_11_m_per_s(wind_speed: float, density: float) -> None:
    """APL-UW TR 9407, II.D.3: beta_v = 10^(-5.2577 + 0.4701 U) (f/25)^0.85, from 11 m/s on as (U/11)^3.5; by way of
    b = beta_v/sin(g), 0.0136 beta_v (1 + 8 b e^-2b - e^-4b)/(4 pi 0.0255 f^(1/3) 2 b)."""
    sine, khz = np.array([0.2, 0.7, 0.95]), 40.0
    density *= (khz / 25) ** 0.85
    b = density / sine
    expected = (
        density * 0.0136 / (4 * np.pi * 0.0255 * np.cbrt(khz)) * (1 + 8 * b * np.exp(-2 * b) - np.exp(-4 * b)) / (2 * b)
    )
    found = bubble_backscatter(jit.Float64(sine), 1e3 * khz, wind_speed)
    np.testing.assert_allclose(found.numpy(), expected, rtol=1e-6)
