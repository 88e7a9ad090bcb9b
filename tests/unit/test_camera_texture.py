"""What patterns give in the mean."""

from __future__ import annotations

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.texture import PATTERNS, looks, mean_albedo, mean_facing, surface_look
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
