"""Propellers of the B-series against values that Fossen's MSS toolbox printed (`remus100.m`, four digits)."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.hydro.b_series import advance_at, thrust_polynomial, torque_polynomial


def at(polynomial, j):
    return np.polynomial.polynomial.polyval(j, polynomial)


@pytest.mark.parametrize(("j", "kt", "kq"), [(0.0, 0.4566, 0.0700), (0.6632, 0.1798, 0.0312)])
def test_remus_propeller(j, kt, kq):
    """wageningen(J, 1, 0.718, 3): half of the last digit that is printed."""
    shape = 1.0, 0.718, 3
    assert at(thrust_polynomial(*shape), j) == pytest.approx(kt, abs=5e-5)
    assert at(torque_polynomial(*shape), j) == pytest.approx(kq, abs=5e-5)


def test_every_power_counts():
    """The sum term by term as it is printed, Horner-wise in J against powers: blades, area and pitch far from 1."""
    for shape in ((0.6, 0.4, 2), (1.3, 0.9, 6)):
        thrust = thrust_polynomial(*shape)
        j = advance_at(thrust, 0.0)
        assert at(thrust, j) == pytest.approx(0, abs=1e-12)
        assert 0.4 * shape[0] < j < 1.3 * shape[0]  # zero thrust near the pitch
        efficiency = max(
            x / (2 * np.pi) * at(thrust, x) / at(torque_polynomial(*shape), x) for x in np.linspace(0, j, 99)
        )
        assert 0.45 < efficiency < 0.85
