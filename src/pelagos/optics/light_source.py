"""Lamps and lasers alike: what arrives from one at a point, and what the water in its beam sends to the eye."""

from __future__ import annotations

from typing import TypeAlias

from pelagos.jit import Array
from pelagos.optics.lamp import Beam, lamp_backscatter, lamp_beam_at
from pelagos.optics.laser_beam import LaserBeam, laser_at, laser_glow, laser_loss
from pelagos.optics.sight_line import SightLines
from pelagos.optics.water import WaterArrays

LightSource: TypeAlias = Beam | LaserBeam


def loss_of(source: LightSource, water: WaterArrays) -> Array:
    """Rate at which its light is lost on the way to a surface under water [1/m]: forward scattering keeps a lamp's
    wide beam together, and widens a laser's."""
    return laser_loss(water) if isinstance(source, LaserBeam) else water.absorption + water.backscatter


def light_at(source: LightSource, loss: Array, point: Array, footprint: Array) -> tuple[Array, Array, Array]:
    """Irradiance across the beam [lx] at a point, with `loss` [1/m] on the way; direction to the source; distance [m].

    Args:
        source: see `Beam` and `LaserBeam`.
        loss: `Array3f`.
        point: `Array3f`, relative to the camera, world axes [m].
        footprint: width of a pixel there [m].
    """
    if isinstance(source, LaserBeam):
        return laser_at(source, loss, point, footprint)
    return lamp_beam_at(source, loss, point)


def glow(
    source: LightSource, water: WaterArrays, direction: Array, reach: Array, pixel_angle: float,
    lines: SightLines | None = None,
) -> tuple[Array, Array | None]:  # fmt: skip
    """Radiance that the water along a camera ray sends back, `Array3f` [cd/m^2]; the place that a thin beam's comes
    from, relative to the camera [m], None for a lamp's whole cone."""
    if isinstance(source, LaserBeam):
        return laser_glow(source, water, direction, reach, pixel_angle, lines)
    return lamp_backscatter(source, water, direction, reach, lines), None
