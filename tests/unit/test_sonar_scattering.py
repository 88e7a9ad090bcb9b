"""The table of what surfaces scatter: all materials at once give what each gives alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

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
