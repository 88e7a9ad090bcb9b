"""Lines of sight through water that is not the same everywhere: what they lose, and what the water sends into them.

A line is followed away from the eye in stretches that grow with the way. Between its ends a stretch's water changes
linearly, so that optical depths are those of the trapezoidal rule; light comes into it as into a stretch of even water,
in closed form. Sums up to the end of each stretch are kept, and asked for at any distance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.light_field import LightField, turned_phase
from pelagos.optics.transport import path_length
from pelagos.optics.water import WaterArrays, daylight_decay

STRETCHES: Final = 32
_FIRST: Final = 0.15  # length of the first stretch [m]
_GROWTH: Final = 1.12  # of a stretch over the one before it: 44 m in all


@jit.struct
class SightLines:
    """Sums along lines at the ends of their stretches, and the four lines around each ray: a Dr.Jit struct.

    Attributes:
        sums: `Float`, three tables of `(STRETCHES + 1, lines, 4)` flattened: absorption and scattering by particles
            [1], the sun's beam turned into the line over its irradiance at the eye [1/sr], and metres' worth of the
            eye's diffuse source, by channel.
        lines: how many, `UInt32` (1).
        corner: `UInt32` by ray, the lines around it.
        right, down: `Float` by ray, place between them, 0 .. 1.
    """

    sums: list[Array]
    lines: Array
    corner: list[Array]
    right: Array
    down: Array


@jit.struct
class Sight:
    """One place on each line of sight, a Dr.Jit struct.

    Attributes:
        water: mean of all water before it.
        beam, diffuse: `Array3f`, see `SightLines.sums`.
    """

    water: WaterArrays
    beam: Array
    diffuse: Array


def sums_along(
    water_at: Callable[[Array], WaterArrays], field: LightField, here: WaterArrays, direction: Array, rate: Array
) -> list[Array]:
    """`SightLines.sums` of lines from an eye.

    Args:
        water_at: the water at a distance [m], by line.
        field: light around the eye, by line.
        here: the water there.
        direction: unit `Array3f`.
        rate: at which the diffuse source falls along the line in the eye's water [1/m].
    """
    lines = dr.width(direction)
    number = dr.arange(jit.UInt32, lines)
    sums = [dr.zeros(jit.Float, 4 * lines * (STRETCHES + 1)) for _ in range(3)]
    rise = direction.z / field.below.z
    zero = dr.zeros(jit.Array3f, lines)

    def step(
        k: Array, length: Array, way: Array, a0: Array, p0: Array, a: Array, p: Array, beam: Array, diffuse: Array,
        beam_loss: Array, diffuse_loss: Array,
    ) -> tuple[Array, ...]:  # fmt: skip
        end = water_at(way + length)
        known = dr.isfinite(end.absorption + end.particle_scattering)  # beyond the grid: as before
        a1 = dr.select(known, end.absorption, a0)
        p1 = dr.select(known, end.particle_scattering, p0)
        absorption, particles = 0.5 * (a0 + a1), 0.5 * (p0 + p1)
        water = _with_decay(absorption, here.water_scattering, particles)
        along, falls = _rates_along(field, here, water, rise, rate)
        beam += turned_phase(field, water, direction) * dr.exp(-beam_loss) * path_length(along, length)
        beam_loss += along * length
        diffuse += water.turning / here.turning * dr.exp(-diffuse_loss) * path_length(falls, length)
        diffuse_loss += falls * length
        a, p = a + absorption * length, p + particles * length
        packets = zip((a, p, beam), diffuse, strict=True)
        for table, (v, w) in zip(sums, packets, strict=True):
            dr.scatter(table, jit.Array4f(v.x, v.y, v.z, w), (k + 1) * lines + number)
        return k + 1, length * _GROWTH, way + length, a1, p1, a, p, beam, diffuse, beam_loss, diffuse_loss

    state = (
        jit.UInt32(0), jit.Float(_FIRST), dr.zeros(jit.Float, lines), zero + here.absorption,
        zero + here.particle_scattering, *(zero + 0 for _ in range(6)),
    )  # fmt: skip
    dr.while_loop(state, lambda k, *_: k < STRETCHES, step, mode="symbolic")
    dr.eval(sums)
    return sums


def sight_at(
    lines: SightLines, field: LightField, here: WaterArrays, direction: Array, rate: Array, distance: Array
) -> Sight:
    """A place on each line of sight.

    Args:
        lines: by ray.
        field, here: light and water around the eye, by ray.
        direction: unit `Array3f`, of the ray.
        rate: see `sums_along`.
        distance: from the eye [m]; beyond the last stretch its water goes on.
    """
    s = dr.maximum(distance, 1e-3)
    stretch, length, inside = _stretch(s)
    (a0, p0, beam0), (a1, p1, beam1) = (_sums(lines, lines.sums, stretch + k) for k in (0, 1))
    diffuse0, diffuse1 = (jit.Array3f(a.w, p.w, beam.w) for a, p, beam in ((a0, p0, beam0), (a1, p1, beam1)))
    a0, p0, beam0, a1, p1, beam1 = (v.xyz for v in (a0, p0, beam0, a1, p1, beam1))
    share = inside / length
    around = _with_decay((a1 - a0) / length, here.water_scattering, (p1 - p0) / length)
    beam_part, diffuse_part = (
        path_length(along, inside) / path_length(along, length)
        for along in _rates_along(field, here, around, direction.z / field.below.z, rate)
    )
    absorption, particles = dr.lerp(a0, a1, share) / s, dr.lerp(p0, p1, share) / s
    water = _with_decay(absorption, here.water_scattering, particles)
    return Sight(water, dr.lerp(beam0, beam1, beam_part), dr.lerp(diffuse0, diffuse1, diffuse_part))


def waters_at(lines: SightLines, here: WaterArrays, distance: Array) -> tuple[WaterArrays, WaterArrays]:
    """Mean of the water before a distance along each line, and the water there; arguments as of `sight_at`.

    Without their own decay of daylight.
    """
    s = dr.maximum(distance, 1e-3)
    stretch, length, inside = _stretch(s)
    (a0, p0), (a1, p1) = (_sums(lines, lines.sums[:2], stretch + k) for k in (0, 1))
    a0, p0, a1, p1 = (v.xyz for v in (a0, p0, a1, p1))
    share, w, k = inside / length, here.water_scattering, here.downwelling
    mean = WaterArrays(dr.lerp(a0, a1, share) / s, w, dr.lerp(p0, p1, share) / s, k)
    return mean, WaterArrays((a1 - a0) / length, w, (p1 - p0) / length, k)


def _stretch(s: Array) -> tuple[Array, Array, Array]:
    """Number of the stretch at a distance, its length, and the way inside it [m]."""
    number = dr.floor(dr.clip(dr.log(1 + s * ((_GROWTH - 1) / _FIRST)) * (1 / math.log(_GROWTH)), 0, STRETCHES - 1))
    length = _FIRST * dr.power(_GROWTH, number)
    return jit.UInt32(number), length, s - (length - _FIRST) * (1 / (_GROWTH - 1))


def _rates_along(
    field: LightField, here: WaterArrays, water: WaterArrays, rise: Array, rate: Array
) -> tuple[Array, Array]:
    """Rates at which beam and diffuse light that is turned into a line fall in a stretch of `water` [1/m]."""
    loss = water.absorption + water.turning
    return loss * (1 - rise), loss + (rate - field.loss) * water.downwelling / here.downwelling


def _with_decay(absorption: Array, scattering: Array, particles: Array) -> WaterArrays:
    return WaterArrays(absorption, scattering, particles, daylight_decay(absorption, scattering, particles))


def _sums(lines: SightLines, tables: list[Array], stretch: Array) -> list[Array]:
    """Values `Array4f` of tables at the beginning of a stretch."""
    found = []
    for table in tables:
        p, q, r, s = (dr.gather(jit.Array4f, table, stretch * lines.lines + c) for c in lines.corner)
        found.append(dr.lerp(dr.lerp(p, q, lines.right), dr.lerp(r, s, lines.right), lines.down))
    return found
