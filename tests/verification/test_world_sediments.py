"""Sediments: the regressions over mean grain size that the table of APL-UW TR 9407 (1994), Section IV, is made of.

The seabed models of both editions of Jackson and Richardson (High-Frequency Seafloor Acoustics, 2007, Table 10.1) give
them too; here each is written out as in the report, and holds to the digits that the table has.
"""

from __future__ import annotations

import math

import pytest

from pelagos.world.material import MATERIALS
from pelagos.world.sediment import SEDIMENTS

GRAINY = {name: row for name, row in SEDIMENTS.items() if row.grain_size_phi is not None}
WATER_MPS = 1528.0  # of the report's own examples


def density(m: float) -> float:
    if m < 1:
        return 0.007797 * m**2 - 0.17057 * m + 2.3139
    if m < 5.3:
        return -0.0165406 * m**3 + 0.2290201 * m**2 - 1.1069031 * m + 3.0455
    return -0.0012973 * m + 1.1565


def speed(m: float) -> float:
    if m < 1:
        return 0.002709 * m**2 - 0.056452 * m + 1.2778
    if m < 5.3:
        return -0.0014881 * m**3 + 0.0213937 * m**2 - 0.1382798 * m + 1.3425
    return -0.0024324 * m + 1.0019


def attenuation(m: float) -> float:
    """In dB/m and kHz."""
    if m < 0:
        return 0.4556
    if m < 2.6:
        return 0.4556 + 0.0245 * m
    if m < 4.5:
        return 0.1978 + 0.1245 * m
    if m < 6:
        return 8.0399 - 2.5228 * m + 0.20098 * m**2
    return 0.9431 - 0.2041 * m + 0.0117 * m**2


@pytest.mark.parametrize("name", GRAINY)
def test_a_row_of_the_table_follows_from_its_grain_size(name: str) -> None:
    row = SEDIMENTS[name]
    m = row.grain_size_phi
    assert m is not None
    assert row.density_ratio == pytest.approx(density(m), abs=6e-4)
    assert row.sound_speed_ratio == pytest.approx(speed(m), abs=6e-5)
    loss = attenuation(m) / 1e3 * row.sound_speed_ratio * WATER_MPS * math.log(10) / (40 * math.pi)
    assert row.loss == pytest.approx(loss, rel=3e-3)
    assert row.volume_scatter == (0.002 if m < 5.5 else 0.001)
    relief = ((2.03846 - 0.26923 * m) / (1.0 + 0.076923 * m)) ** 2 if m < 5 else 0.25
    assert row.spectral_strength == pytest.approx(0.00207 * relief, rel=2e-3)


def test_colours_strengths_and_contact_go_with_the_grain_from_rock_to_clay() -> None:
    """Finer is darker, softer, and weaker in echoes: from gravel of -1 phi to clay of 9 phi in even steps."""
    at = {row.grain_size_phi: MATERIALS[name] for name, row in GRAINY.items() if name in MATERIALS}
    coarse, middle, clay = at[-1.0], at[4.0], at[9.0]
    assert coarse.albedo == pytest.approx((0.36, 0.31, 0.23))
    assert clay.albedo == pytest.approx((0.10, 0.09, 0.07))
    assert middle.albedo == pytest.approx([(a + b) / 2 for a, b in zip(coarse.albedo, clay.albedo, strict=True)])
    assert (coarse.lambert_db, middle.lambert_db, clay.lambert_db) == (-22, -28.5, -35)
    assert (coarse.friction, clay.friction) == (0.6, 0.25)
    assert (coarse.stiffness, clay.stiffness) == (8e4, 5e3)
    assert middle.stiffness == pytest.approx(math.sqrt(8e4 * 5.05e3), rel=0.01)
