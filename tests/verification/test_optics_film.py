"""A film's response: bends at both ends of a straight part, whatever their shares."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.film import FilmCurve, film

CURVES = {
    "as it is": FilmCurve(),
    "much toe": FilmCurve(slope=0.9, toe=0.85, shoulder=0.3),
    "cut off": FilmCurve(slope=1.1, toe=0.6, shoulder=0.2, black_clip=0.06, white_clip=0.09),
    "little toe": FilmCurve(slope=0.7, toe=0.4, shoulder=0.4, black_clip=0.02),
}


@pytest.mark.parametrize("name", CURVES)
def test_a_film_rises_without_steps_from_its_black_to_its_white(name: str) -> None:
    """Middle grey stays (to a hundredth where the dark bend ends below it), around it a decade of light is `slope` of
    the range; black and white are cut off where the bends would go beyond them."""
    curve = CURVES[name]
    decades = np.linspace(-6, 4, 4001)
    shown = np.array(film(jit.Float64(10.0**decades), curve))
    rise = np.diff(shown) / np.diff(decades)
    assert rise.min() > -1e-9
    assert rise.max() < 1.3 * curve.slope  # no steps
    assert shown[0] == pytest.approx(0.0, abs=2e-3)
    assert shown[-1] == pytest.approx(1.0 if curve.white_clip > 0 else shown[-1], abs=2e-3)
    assert (shown[decades < -5] == 0).all() == (curve.black_clip > 0)
    grey = float(np.interp(math.log10(0.18), decades, shown))
    assert grey == pytest.approx(0.18, abs=0.012)
