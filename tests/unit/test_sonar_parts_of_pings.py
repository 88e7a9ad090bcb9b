"""Sums within a ping, beside the same in NumPy."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pelagos import jit
from pelagos.sensors.sonar.dvl import _RAYS, beam_echo
from pelagos.sensors.sonar.ping.pinger import boost


def test_a_beam_reads_the_mean_of_its_rays_that_meet_something() -> None:
    """Three copies, all four beams, of which rays are lost at random: more than half must see."""
    rng, lanes = np.random.default_rng(8), 3
    shape = (lanes, 4, _RAYS)
    valid, distance, section = rng.random(shape) < 0.6, rng.uniform(2, 40, shape), rng.uniform(0.1, 3, shape)
    ground, axis = rng.normal(size=(3, *shape)), rng.normal(size=(4, 3))
    flat = lambda kind, a: jit.from_numpy(kind, np.ascontiguousarray(a.reshape(-1).astype(np.float32)))
    for beam in range(4):
        seen, *found = beam_echo(
            lanes, beam, jit.Bool(valid.ravel().tolist()), flat(jit.Float, distance), flat(jit.Float, section),
            jit.Array3f(*(flat(jit.Float, g) for g in ground)), axis[beam],
        )  # fmt: skip
        hits = valid[:, beam].sum(axis=1)
        assert np.array(seen).tolist() == (hits > _RAYS / 2).tolist()
        along = np.einsum("clr,c->lr", ground[:, :, beam], axis[beam])
        for value, all_rays in zip(found, (distance[:, beam], section[:, beam], along), strict=True):
            mean = (all_rays * valid[:, beam]).sum(axis=1) / np.maximum(hits, 1)
            np.testing.assert_allclose(np.array(value), mean, rtol=2e-6, atol=1e-6)


@pytest.mark.parametrize("steered", [False, True])
def test_a_boost_undoes_what_the_middle_of_beam_and_pulse_takes(steered: bool) -> None:
    """Squares of amplitudes are powers: pulse^2 x its equivalent length over a bin, beams by their middle^2."""
    steering = np.array([[0.3, 0.9, 0.2], [0.1, 0.7, 0.4]]) if steered else None
    layout = SimpleNamespace(beams=2, steering=steering, heard_parts=np.array([0.8, 0.55]))
    found = boost(
        SimpleNamespace(equivalent_m=0.3, bin_width_m=0.04), layout, np.array([0.2, 0.65, 0.1], dtype=np.float32)
    )
    middle = np.array([0.81, 0.49]) if steered else 1.0
    np.testing.assert_allclose(found, 1 / (middle * np.array([0.8, 0.55]) * 0.65**2 * 0.3 / 0.04), rtol=1e-6)
