"""Who sums which echoes, and what is read in pairs."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.acoustics import echo_sum
from pelagos.acoustics.echo_sum import pitch, walk
from pelagos.bench.cases.sonar import context, motion
from pelagos.sensors.imaging_sonar import ImagingSonar, ImagingSonarConfig


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


@pytest.mark.parametrize("bins", [8, 16, 511, 512, 1024])
def test_rows_of_bins_start_in_different_cache_lines(bins: int) -> None:
    found = pitch(bins)
    assert bins <= found < bins + 8
    assert (found // 4) % 2 == 1  # lines of four cells: an odd number of them shares no power of two


def test_a_sum_does_not_depend_on_the_order_in_which_strips_are_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    config = ImagingSonarConfig(beams=16, rays_per_beam=64, bins=128, range_max_m=30.0, orientation_deg=(0, 20, 0))
    images = []
    for sorted_from in (32, 10**9):
        monkeypatch.setattr(echo_sum, "_SORTED_FROM", sorted_from)
        images.append(ImagingSonar(config, context()).sense(motion(0)).data)
    # float32 sums of tens of terms: the order changes their last places, 45 dB on a scale of 1
    np.testing.assert_allclose(images[0], images[1], atol=1e-3)
    assert np.ptp(images[0]) > 0.3
