"""The way from what rays meet to patches: strips of surface that echo."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import drjit as dr

from pelagos.acoustics.echo import Patches, strip_span, widened
from pelagos.acoustics.spreading import patch_intensity
from pelagos.jit import Array
from pelagos.math.quick import larger, smaller
from pelagos.sensors.sonar.ping.surface_scattering import Surfaces, patch_factor, scattering

if TYPE_CHECKING:
    pass
from pelagos.sensors.sonar.ping.fan import Fan, FanHits, Lanes, Trace

_STEEPEST: Final = 2.0  # longest strip, relative to one on level ground
_GROUND: Final = 0.8  # upward part of the normal of ground, which goes on where a strip leaves its triangle
_SLOPING: Final = 0.01  # [rad], angle that a strip of ground may stretch to, at most four times as far as others
_LEAST_SINE: Final = 0.01  # grazing angle below which patches are cut off (0.6 deg)


def patches_of(
    view: FanHits,
    fan: Fan,
    lanes: Lanes,
    surfaces: Surfaces,
    *,
    longest: float,
    fall: Callable[[Array, Array], Array] = patch_intensity,
    trace: Trace = None,
) -> Patches:
    """The echo of every ray as a strip of surface: its intensity re the source level at 1 m, or, with another `fall`
    of distance [m] and absorption [dB/m] than the water's, what a gain makes of it.

    The patch of a stratum with solid angle w has the area w t^2/sin(grazing); its echo is sigma w/(t^2 sin) times the
    two-way absorption (Lurton 2010, Eq. 3.38). Area and strip are those of the triangle that was hit, so that patches
    tile the mesh as it is; what it scatters follows the interpolated normal.
    """
    hits = view.hits
    t = dr.select(hits.valid, hits.t, 1.0)
    loss = view.loss
    section = scattering(surfaces, hits.material, view.sine) * patch_factor(hits, surfaces)
    normal = hits.normal
    facing = larger(dr.abs(dr.dot(normal, view.direction)), _LEAST_SINE)
    scattered = section / facing * view.of_ray(fan.weight)
    lower, upper = view.of_ray(fan.lower), view.of_ray(fan.upper)
    # a strip much longer than on level ground leaves the thing that was hit: the side of a boulder, the rim of a hull
    level = _STEEPEST * (upper - lower)
    angle = dr.select(normal.z > _GROUND, larger(smaller(4.0 * level, _SLOPING), level), level)
    slant = t / larger(dr.abs(view.direction.z), 0.02)
    limit = smaller(angle * slant, longest)
    near, far, slide = strip_span(t, view.direction, normal, view.along, view.aside, lower, upper, limit)
    length, width = None, None
    if fan.across is not None:  # their product is the strip's area
        length = larger((far - near) * dr.norm(slide), t * (upper - lower))
        width = t * view.of_ray(fan.across) * dr.rsqrt(dr.square(facing) + dr.square(dr.dot(normal, view.along)))
    if fan.half is not None:
        half = view.of_ray(fan.half)
        limit = smaller(_STEEPEST * half * slant, longest)
        near, far = widened(near, far, t, view.direction, normal, view.along, half, limit)
    if trace is not None:
        _tell(trace, view, section, scattered * patch_intensity(t, loss), far - near)
    return Patches(
        valid=hits.valid,
        distance=t,
        near=near,
        far=far,
        energy=dr.select(hits.valid, scattered * fall(t, loss), 0.0),
        slide=slide,
        direction=view.direction,
        label=hits.label,
        instance=hits.instance,
        length=length,
        width=width,
    )


def _tell(trace: Callable[[str, Array, str], None], view: FanHits, section: Array, echo: Array, span: Array) -> None:
    """Tell what made the patches' echoes."""
    trace("ray direction, up component", view.direction.z, "1")
    trace("slant range", view.hits.t, "m")
    trace("sine of the grazing angle", view.sine, "1")
    trace("cross section per unit area", section, "1")
    trace("echo intensity of a ray re 1 m", echo, "1")
    trace("range span of a ray's patch", span, "m")
