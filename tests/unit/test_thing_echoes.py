"""Echoes of things in the cells of a ping, from what is known of each, against sums written out."""

from __future__ import annotations

import math
from dataclasses import fields
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics.echo_walk import Bins, pitch
from pelagos.acoustics.element_array import ElementLine
from pelagos.acoustics.target_tag import untag
from pelagos.sensors.sonar.ping.target_echoes import (
    Grid,
    coherent_echoes,
    echoes_at_elements,
    with_small_energies,
    with_small_things,
)
from pelagos.sensors.sonar.ping.target_sighting import Sighting

PINGS, THINGS, RAYS, BEAMS = 2, 3, 5, 4
BINS = Bins(9, 2.0, 0.5)
LOSS = np.array([0.04, 0.11])
BOOST = np.array([1.3, 0.6, 2.2, 0.9])
INSTANCES = np.array([40, 50, 60])
RNG = np.random.default_rng(8)
SMALL = np.array([[True, False, True], [True, True, False]])
POINT = np.array([[True, True, False], [False, True, True]])
SHAPE = (PINGS, THINGS, RAYS)
ENERGY = RNG.uniform(0.1, 2.0, SHAPE) * (RNG.uniform(size=SHAPE) > 0.2)
DISTANCE = RNG.uniform(1.3, 7.2, SHAPE)  # some before the first bin and behind the last
PAIR = RNG.normal(size=(2, *SHAPE))
BEAM = RNG.integers(0, BEAMS + 1, SHAPE)  # some from none
LABEL = RNG.integers(1, 9, SHAPE)
SIZE = np.array([[0.7, 0.0, 0.2], [0.4, 1.1, 0.3]])
REACH = np.array([[3.21, 4.0, 6.4], [2.1, 3.87, 5.02]])
TURN = RNG.uniform(-3, 3, (PINGS, THINGS))
SIDE = np.array([[0.3, -0.2, 0.05], [-0.4, 0.1, 0.25]])  # y of the direction
NEAREST = np.array([[1, 0, 3], [2, 2, 0]])


def sighting() -> Sighting:
    zero = dr.zeros(jit.Float, PINGS * THINGS)
    given: dict[str, Any] = {
        "small": jit.Bool(SMALL.ravel()), "point": jit.Bool(POINT.ravel()), "energy": jit.Float(ENERGY.ravel()),
        "distance": jit.Float(DISTANCE.ravel()), "real": jit.Float(PAIR[0].ravel()),
        "imaginary": jit.Float(PAIR[1].ravel()), "beam": jit.UInt32(BEAM.ravel()), "label": jit.UInt32(LABEL.ravel()),
        "size": jit.Float(SIZE.ravel()), "reach": jit.Float(REACH.ravel()), "cosine": jit.Float(np.cos(TURN).ravel()),
        "sine": jit.Float(np.sin(TURN).ravel()), "direction": jit.Array3f(0.1, jit.Float(SIDE.ravel()), -0.2),
        "nearest": jit.UInt32(NEAREST.ravel()),
    }  # fmt: skip
    return Sighting(**{f.name: given.get(f.name, zero) for f in fields(Sighting)})


def grid(beams: int = BEAMS, bins: Bins = BINS, resolution: float = 0.8) -> Grid:
    return Grid(beams=beams, bins=bins, resolution=resolution, pulse="cw", cell=0.17)


def heard() -> list[tuple[int, int, int, int, float, tuple[int, int, int]]]:
    """Ping, beam, bin, instance, level over the source's to that of the field, row of each ray that is heard."""
    found = []
    for row in np.ndindex(SHAPE):
        p, m, _ = row
        r, beam = DISTANCE[row], int(BEAM[row])
        bin_ = math.floor((r - 2.0) / 0.5)
        if not SMALL[p, m] or ENERGY[row] == 0.0 or beam == BEAMS or not 0 <= bin_ < 9:
            continue
        level = r**3 * 10 ** (2 * LOSS[p] * r / 10) / 0.17 * (BOOST[beam] if POINT[p, m] else 1.0)
        found.append((p, beam, bin_, int(INSTANCES[m]), level, row))
    assert 8 < len(found) < 26
    return found


def test_rays_of_small_things_add_to_their_cells_and_the_strongest_gives_its_name() -> None:
    """Amplitudes by the root of the level, onto what is there already; points as a whole."""
    row = pitch(BINS.count)
    field, energies = (np.zeros((PINGS, BEAMS, row, *extra)) for extra in ((2,), ()))
    best: dict[tuple[int, int, int], tuple[float, int, int]] = {}
    for p, beam, bin_, instance, level, at in heard():
        field[p, beam, bin_] += math.sqrt(level) * PAIR[(slice(None), *at)]
        energies[p, beam, bin_] += level * ENERGY[at]
        best[p, beam, bin_] = max(best.get((p, beam, bin_), (0.0, 0, 0)), (level * ENERGY[at], LABEL[at], instance))
    made, whole = jit.Float(np.full(field.size, 0.5)), jit.Float(np.full(energies.size, 0.25))
    tags = dr.zeros(jit.UInt64, PINGS * BEAMS * row)
    boost = jit.Float(BOOST)
    lanes: Any = SimpleNamespace(medium=SimpleNamespace(absorption=jit.Float(LOSS)))
    with_small_things(sighting(), grid(), lanes, boost, made, tags, jit.UInt32(INSTANCES))
    with_small_energies(sighting(), grid(), jit.Float(LOSS), boost, whole)
    np.testing.assert_allclose(np.array(made).reshape(field.shape), 0.5 + field, rtol=2e-4, atol=2e-4)
    np.testing.assert_allclose(np.array(whole).reshape(energies.shape), 0.25 + energies, rtol=2e-4, atol=2e-4)
    label, instance = (np.array(v).reshape(energies.shape) for v in untag(tags))
    for cell in np.ndindex(energies.shape):
        assert (label[cell], instance[cell]) == best.get(cell, (0, 0, 0))[1:]
    assert len(best) < len(heard())


def spread(received: Any, receivers: int, bins: Bins, resolution: float) -> np.ndarray:
    """By ping, receiver and bin: every thing's wave in all bins that its pulse reaches, a triangle of a resolution to
    each side; bins wider than 0.3 of a resolution keep the strongest of their samples."""
    field = np.zeros((PINGS, receivers, bins.count), complex)
    slack = max(0.5 * (bins.width - 0.3 * resolution), 0.0)
    middles = bins.first_range + (np.arange(bins.count) + 0.5) * bins.width
    for p, m in np.ndindex(PINGS, THINGS):
        off = np.maximum(np.abs(middles - REACH[p, m]) - slack, 0.0) / resolution
        wave = SIZE[p, m] * np.exp(1j * TURN[p, m]) * np.maximum(1 - off, 0.0)
        for k in range(receivers):
            field[p, k] += received(p, m, k) * wave
    return field


@pytest.mark.parametrize(("bins", "resolution"), [(BINS, 0.8), (Bins(30, 2.0, 0.15), 0.6)])
def test_coherent_echoes_are_spread_by_the_pulse_in_the_beam_that_looks_there(bins: Bins, resolution: float) -> None:
    aperture: Any = SimpleNamespace(steered=False)
    made = coherent_echoes(sighting(), grid(bins=bins, resolution=resolution), aperture, None, PINGS, energies=False)  # type: ignore[arg-type]
    expected = spread(lambda p, m, k: float(NEAREST[p, m] == k), BEAMS, bins, resolution)
    found = np.array(made).reshape(PINGS, BEAMS, bins.count, 2)
    np.testing.assert_allclose(found[..., 0] + 1j * found[..., 1], expected, atol=2e-5)


def test_energies_of_steered_beams_are_squares_of_each_echo() -> None:
    """Heard through the array's amplitude, which may be negative, in the thing's own direction."""
    side = lambda beam, y: 0.4 * (beam - 1.3) + y
    aperture: Any = SimpleNamespace(steered=True, side_amplitude=lambda _, beam, way: side(jit.Float(beam), way.y))
    whole = np.zeros((PINGS, BEAMS, BINS.count))
    for p, m in np.ndindex(PINGS, THINGS):
        alone = spread(lambda a, b, k, p=p, m=m: side(k, SIDE[a, b]) * (a == p and b == m), BEAMS, BINS, 0.8)
        whole += np.abs(alone) ** 2
    made = coherent_echoes(sighting(), grid(), aperture, None, PINGS, energies=True)  # type: ignore[arg-type]
    np.testing.assert_allclose(np.array(made).reshape(whole.shape), whole, atol=2e-5)


def test_elements_hear_things_by_the_phase_of_their_bearing() -> None:
    """2 pi y sin(a) cycles at y wavelengths, by each ping's own scale."""
    line = ElementLine(np.array([-1.1, -0.55, 0.0, 0.55, 1.1]), np.full(5, 0.2))
    scale = np.array([0.97, 1.04])
    made = np.array(echoes_at_elements(sighting(), grid(), line, jit.Float(scale), PINGS)).reshape(PINGS, 5, 9, 2)
    expected = spread(lambda p, m, k: np.exp(2j * np.pi * line.places[k] * SIDE[p, m] * scale[p]), 5, BINS, 0.8)
    np.testing.assert_allclose(made[..., 0] + 1j * made[..., 1], expected, atol=3e-5)
