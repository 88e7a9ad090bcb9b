"""Products of velocities, magnitudes and heel by their names."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import ScenarioError
from pelagos.hydro.modulus import HEEL, modulus_force, products_of

NU = [1.3, -0.7, 0.2, -0.05, 0.03, -0.11]
NAMED = {
    "Xu|u|": (0, lambda u, v, w, p, q, r, phi: u * abs(u)),
    "Yphi|uv|": (1, lambda u, v, w, p, q, r, phi: phi * abs(u * v)),
    "Z|u|w": (2, lambda u, v, w, p, q, r, phi: abs(u) * w),
    "Kphiphiphi": (3, lambda u, v, w, p, q, r, phi: phi**3),
    "Kp": (3, lambda u, v, w, p, q, r, phi: p),
    "M|phi|uq": (4, lambda u, v, w, p, q, r, phi: abs(phi) * u * q),
    "Nr|v|": (5, lambda u, v, w, p, q, r, phi: r * abs(v)),
}


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("name", NAMED)
def test_a_name_is_its_product(name, side):
    axis, product = NAMED[name]
    nu = [side * x for x in NU]
    for heel, known in ((0.3 * side, 0.3 * side), (1.2 * side, HEEL * side)):
        expected = np.zeros(6)
        expected[axis] = -2.5 * product(*nu, known)
        found = modulus_force(products_of({name: -2.5}), nu, heel)
        assert [float(x) for x in found] == pytest.approx(list(expected), rel=1e-12, abs=1e-15)


def test_products_of_one_axis_add_up():
    found = modulus_force(products_of({"Yur": 3.0, "Y|u|v": -2.0}), NU, 0.0)
    assert float(found[1]) == pytest.approx(3.0 * 1.3 * -0.11 - 2.0 * 1.3 * -0.7, rel=1e-12)


@pytest.mark.parametrize("name", ["Y", "Yx", "Y|u", "Y||", "Quv", "Yu|v|w|", "Yur2", "yur", "Yph"])
def test_other_names_are_refused(name):
    with pytest.raises(ScenarioError, match="must be X, Y, Z, K, M or N and then u, v, w, p, q, r, phi"):
        pl.Vehicle.from_catalogue("navalvessel", terms={"hull": {"coefficients": {name: 1.0}}})
