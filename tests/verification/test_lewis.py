"""Lewis forms: circles, ellipses, and the three numbers that they are made of."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.errors import InputError
from pelagos.hydro.lewis import fullness_range, lewis_form


@pytest.mark.parametrize(("half", "draught"), [(3.0, 3.0), (4.0, 2.5), (1.5, 3.5)])
def test_ellipses_have_no_third_coefficient(half: float, draught: float) -> None:
    """Fullness pi/4 is that of an ellipse: a3 = 0, a1 = (H0 - 1)/(H0 + 1), M its mean half axis."""
    form = lewis_form(2 * half, draught, np.pi / 2 * half * draught)
    assert form.third == pytest.approx(0.0, abs=1e-12)
    assert form.first == pytest.approx((half - draught) / (half + draught), abs=1e-12)
    assert form.scale == pytest.approx((half + draught) / 2, rel=1e-12)
    y, z = form.points(90).T
    assert (y / half) ** 2 + (z / draught) ** 2 == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("fullness", [0.62, 0.83, 0.98])
@pytest.mark.parametrize(("beam", "draught"), [(29.0, 9.3), (12.0, 15.5)])
def test_forms_have_their_beam_draught_and_area(beam: float, draught: float, fullness: float) -> None:
    """By the polygon of 2000 chords, which lie within (girth/2000)^2/8r of it: 1e-5 of the area."""
    y, z = lewis_form(beam, draught, fullness * beam * draught).points(2000).T
    assert (y[-1] - y[0], z[1000]) == pytest.approx((beam, -draught), rel=1e-12)
    area = 0.5 * abs(float(np.sum(y[:-1] * z[1:] - y[1:] * z[:-1])))
    assert area == pytest.approx(fullness * beam * draught, rel=1e-5)


def test_the_finest_and_the_fullest_form() -> None:
    """Von Kerczek and Tuck: 3 pi/32 (2 - s) and pi/32 (10 + s + 1/s), s the smaller of H0 and 1/H0; both ways round."""
    assert fullness_range(0.8) == pytest.approx((3 * np.pi / 32 * 1.2, np.pi / 32 * (10 + 0.8 + 1.25)), rel=1e-12)
    assert fullness_range(1.25) == pytest.approx(fullness_range(0.8), rel=1e-12)
    low, high = fullness_range(1.25)
    for fullness in (0.999 * low, 1.001 * high):
        with pytest.raises(InputError, match=r"is none of a Lewis form, which has 0.3534 to 1.183"):
            lewis_form(2.5, 1.0, fullness * 2.5)
    assert lewis_form(2.5, 1.0, 1.001 * low * 2.5).third > 0 > lewis_form(2.5, 1.0, 0.999 * high * 2.5).third
