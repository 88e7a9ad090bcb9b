"""What patterns give in the mean."""

from __future__ import annotations

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.texture import PATTERNS, _ripples, looks, mean_albedo, mean_facing, surface_look
from pelagos.world.material import MATERIALS

COUNT = 40_000


@pytest.mark.parametrize("kind", PATTERNS)
def test_the_mean_colour_is_the_mean_of_the_colours(kind: str):
    """Over level ground and a wall of each kind: 6 % of albedo, by which these differ, and 2 % of the relief."""
    material = next(m for m in MATERIALS.values() if m.texture == kind)
    table = looks(jit.Array3f(*(jit.Float([c]) for c in (0.3, 0.2, 0.1))), jit.Float([material.texture_scale]), [kind])
    row, lanes = dr.zeros(jit.UInt32, COUNT), dr.full(jit.Bool, True, COUNT)
    p, q = (jit.Float(v) for v in np.random.default_rng(4).uniform(-40, 40, (2, COUNT)))
    nothing, one = dr.zeros(jit.Float, COUNT), dr.full(jit.Float, 1, COUNT)
    colours, facing = [], []
    for place, normal in (
        (jit.Array3f(p, q, nothing - 12), jit.Array3f(nothing, nothing, one)),
        (jit.Array3f(nothing + 3.3, p, q), jit.Array3f(one, nothing, nothing)),
    ):
        albedo, bumpy = surface_look(table, row, place, normal, one * 0.01, lanes)
        colours.append(np.array(albedo).mean(axis=1))
        facing.append(np.array(dr.dot(bumpy, normal)).mean())
    assert np.array(mean_albedo(table, row, lanes))[:, 0] == pytest.approx(np.mean(colours, axis=0), rel=0.06)
    assert np.array(mean_facing(table, row, lanes))[0] == pytest.approx(np.mean(facing), rel=0.02)


def test_ripples_slope_as_their_height_changes():
    """The slope is the height's derivative over 2 pi, a unit being a wavelength; both fade out together."""
    p, q = np.random.default_rng(6).uniform(-5, 5, (2, 400))
    nothing = dr.zeros(jit.Float, 400)

    def at(x, y, kept=1.0, slow=nothing, middle=nothing):
        return _ripples(jit.Array3f(jit.Float(x), jit.Float(y), nothing), slow, middle, jit.Float(kept))

    slope, height = (np.array(v) for v in at(p, q))
    h = 2e-3
    along = [(np.array(at(p + a, q + b)[1]) - np.array(at(p - a, q - b)[1])) / (2 * h) for a, b in ((h, 0), (0, h))]
    assert slope == pytest.approx(np.array(along) / (2 * np.pi), abs=3e-3)
    assert np.abs(slope).max(axis=1) / 0.55 == pytest.approx([0.94 * 1.56, 0.34 * 1.56], rel=0.02)
    fainter, lower = (np.array(v) for v in at(p, q, 0.25))
    assert fainter == pytest.approx(0.25 * slope, abs=1e-6)
    assert lower == pytest.approx(0.25 * height, abs=1e-6)
    turned = np.array(at(p, q, 1.0, nothing + 0.2, nothing - 0.4)[1])  # on by 5.5 0.2 - 2.2 0.4 rad, and higher
    moved = np.array(at(p + 0.22 / (2 * np.pi * 0.94), q)[1])
    assert turned / (0.55 + 0.9 * 0.2 + 0.5 * 0.4) == pytest.approx(moved / 0.55, abs=2e-3)
