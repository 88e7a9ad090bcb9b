"""From the patches that rays meet to the field of echoes by beam sector and range bin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import drjit as dr

from pelagos import jit
from pelagos.acoustics.beam_pattern import line_length
from pelagos.acoustics.echo import Patches
from pelagos.acoustics.echo_strips import Strips
from pelagos.acoustics.echo_sum import Roughness, sum_amplitudes, sum_energies
from pelagos.acoustics.echo_walk import Walkers
from pelagos.acoustics.pulse import range_coupling
from pelagos.acoustics.spreading import from_db, time_varied_gain
from pelagos.jit import Array
from pelagos.math.constants import NOMINAL_SOUND_SPEED
from pelagos.sensors.sonar.ping.fan import Fan, FanHits, Lanes, Trace
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.patches import patches_of
from pelagos.sensors.sonar.ping.ping_spec import PingSpec
from pelagos.sensors.sonar.ping.surface_scattering import Surfaces

if TYPE_CHECKING:
    pass


def calibrated_echoes(
    spec: PingSpec, layout: Layout, view: FanHits, fan: Fan, lanes: Lanes, surfaces: Surfaces, velocity: Array,
    trace: Trace = None,
) -> Patches:  # fmt: skip
    """The direct echoes, as backscattering strength of the cell, at the ranges that their times mean.

    During the way of the sound the sonar and the target move: the echo of a target that closes at v arrives as from
    r (1 - v/c) (to first order in v/c; r is the range at transmission).
    """
    cell = layout.sector * spec.bin_width_m  # solid angle times depth of a cell [rad m]

    here = view.of_lane(lanes.medium.absorption)

    def levelled(distance: Array, loss: Array) -> Array:
        return distance * from_db(2.0 * distance * (here - loss)) * (1.0 / cell)  # under the gain 30 log r + 2 a r

    patches = patches_of(view, fan, lanes, surfaces, longest=spec.longest_strip_m, fall=levelled, trace=trace)
    if spec.sound_speed_mps is not None:
        scale = view.of_lane(spec.sound_speed_mps / lanes.medium.sound_speed)
        patches.near, patches.far = patches.near * scale, patches.far * scale
    if spec.doppler:
        closing = dr.dot(view.of_lane(jit.Array3f(velocity)) - view.hits.velocity, view.direction)
        factor = 1.0 - closing * view.of_lane(1.0 / lanes.medium.sound_speed)
        shift = range_coupling(spec.frequency_hz, spec.bandwidth_hz, spec.pulse_s, spec.pulse) * closing
        patches.near, patches.far = patches.near * factor - shift, patches.far * factor - shift
    return patches


def apply_gain(spec: PingSpec, layout: Layout, patches: Patches, view: FanHits, lanes: Lanes) -> Patches:
    """Give patches the gain 30 log r + 2 a r, and the unit of a backscattering strength."""
    loss = view.of_lane(lanes.medium.absorption)
    cell = layout.sector * spec.bin_width_m
    patches.energy *= time_varied_gain(patches.distance, loss, spreading=30.0) / cell
    return patches


def echoes(
    spec: PingSpec, layout: Layout, patches: list[Patches], walkers: Walkers, lanes: Lanes, seed: Array
) -> tuple[Array, Array | None, list[Strips]]:
    """The sum of all echoes by beam and bin, the strongest one's tag, and strips: see `sum_amplitudes`."""
    total: Array | None = None
    tags: Array | None = None
    strips = []
    for k, group in enumerate(patches):
        roughness = Roughness(
            wave_cycles=2.0 * spec.frequency_hz / lanes.medium.sound_speed,
            origin=lanes.position,
            facet=facet_size(spec, layout),
            seed=seed + k,
            scattered=layout.facet is not None,
            single_file=layout.single_file,
        )
        field, strongest, kept = sum_amplitudes(group, walkers, roughness, tags=spec.labels and k == 0)
        total, tags = (field, strongest) if total is None else (total + field, tags)
        strips.append(kept)
    return total, tags, strips


def energies(strips: list[Strips], walkers: Walkers) -> Array:
    """The energy of all echoes by beam and bin."""
    total = sum_energies(strips[0], walkers)
    for more in strips[1:]:
        total = total + sum_energies(more, walkers)
    return total


def facet_size(spec: PingSpec, layout: Layout) -> float:
    """Edge of the roughness lattice [m]: speckle decorrelates over half an aperture, and from bin to bin."""
    if layout.facet is not None:
        return layout.facet
    aperture = line_length(layout.horizontal_width) * NOMINAL_SOUND_SPEED / spec.frequency_hz
    return min(0.5 * aperture, 0.5 * spec.bin_width_m)
