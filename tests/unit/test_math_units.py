"""One table of lengths and speeds, from which all doors take theirs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import pelagos
from pelagos.config.unit import FACTORS, in_unit_of
from pelagos.identification.noise_keys import COLUMN_UNITS
from pelagos.identification.plan import UNIT_SCALES, UNITS_OF
from pelagos.math.units import KNOT, LENGTHS, SPEEDS
from pelagos.world.bathymetry.values import METRES

YARD = 0.9144  # [m], by the agreement of 1959


def test_units_are_what_their_definitions_say() -> None:
    """A foot is a third of a yard, a fathom two yards, an inch a 36th; 54 nautical miles are 100.008 km; a knot is one
    an hour."""
    assert LENGTHS["ft"] == pytest.approx(YARD / 3, rel=1e-15)
    assert LENGTHS["in"] == pytest.approx(YARD / 36, rel=1e-15)
    assert LENGTHS["fathom"] == pytest.approx(2 * YARD, rel=1e-15)
    assert 54 * LENGTHS["nmi"] == pytest.approx(100_008.0, rel=1e-15)
    knots = LENGTHS["nmi"] / KNOT  # covered in an hour
    assert knots == pytest.approx(3600, rel=1e-15)
    kilometre_an_hour = LENGTHS["km"] / 3600
    expected = {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "km/h": kilometre_an_hour, "kn": 1.852 * kilometre_an_hour}
    assert dict(SPEEDS) == pytest.approx(expected, rel=1e-15)
    assert (LENGTHS["m"], LENGTHS["cm"], LENGTHS["mm"]) == (1.0, 1e-2, 1e-3)


@pytest.mark.parametrize("table", [
    UNIT_SCALES, FACTORS["m"], FACTORS["mps"], COLUMN_UNITS["m"], COLUMN_UNITS["m/s"], METRES,
])  # fmt: skip
def test_every_table_has_the_numbers_of_the_one(table: dict[str, float]) -> None:
    known = {**LENGTHS, **SPEEDS}
    shared = table.keys() & known.keys()
    assert len(shared) >= 3
    assert {unit: table[unit] for unit in shared} == {unit: known[unit] for unit in shared}


def test_units_of_a_door_are_those_that_it_had() -> None:
    """Which units a plan, a column of noise and a key take is for each to say."""
    assert UNITS_OF["m"] == ("m", "cm", "mm", "km", "nmi", "ft")
    assert UNITS_OF["m/s"] == ("m/s", "cm/s", "mm/s", "km/h", "kn")
    assert [*COLUMN_UNITS["m"]] == ["m", "cm", "mm"]
    assert [*COLUMN_UNITS["m/s"]] == ["m/s", "cm/s", "mm/s", "kn"]
    assert in_unit_of("depth_m", "12 fathom") == pytest.approx(21.9456)
    assert in_unit_of("speed_mps", "7 kt") == pytest.approx(3.60111)  # to six digits


def test_no_other_module_writes_these_numbers() -> None:
    root = Path(pelagos.__file__).parent
    numbers = re.compile(r"(?<![\d.])(1852(\.0)?|0\.3048|1\.8288|0\.51444*)(?![\d.])")
    found = [str(p.relative_to(root)) for p in sorted(root.rglob("*.py")) if numbers.search(p.read_text())]
    assert found == ["math/units.py"]
