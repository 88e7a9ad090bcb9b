"""Who sums which echoes, and what is read in pairs."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics.beamforming import pair, unpair
from pelagos.acoustics.echo import walk


@pytest.mark.parametrize(("beams", "rays"), [(1, 100), (2, 33), (3, 7), (16, 4), (64, 5)])
def test_every_ray_is_summed_once_by_a_walker_of_its_beam(beams: int, rays: int) -> None:
    beam = np.random.default_rng(1).permutation(np.repeat(np.arange(beams), rays))
    found = walk(beam, beams)
    order = found.order.reshape(found.steps, beams * found.parts)
    assert found.parts == max(16 // beams, 1)
    present = order < len(beam)
    assert sorted(order[present]) == list(range(len(beam)))
    walker = np.broadcast_to(np.arange(beams * found.parts), order.shape)
    assert (beam[order[present]] == walker[present] // found.parts).all()


def test_pairs_come_back() -> None:
    a, b = np.float32([0.0, -1.5, 3e-30, np.inf]), np.float32([7.25, -0.0, 1e30, -2.0])
    low, high = unpair(pair(jit.Float(a), jit.Float(b)))
    np.testing.assert_array_equal(np.array(low), a)
    np.testing.assert_array_equal(np.array(high), b)
