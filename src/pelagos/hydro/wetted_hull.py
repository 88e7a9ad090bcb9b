"""Pressure on the wet part of a hull, triangle by triangle: exact for pressures and surfaces that are linear in each
triangle.

Frame-neutral: corners may be in any right-handed frame, moments are about its origin. Corners run counter-clockwise
seen from the water. Forces come out per rho g, in cubic metres: times rho g they are newtons; under still water their
vertical part is the displaced volume. Source: Gauss' theorem on the clipped polyhedron; the integrals of linear
functions over a triangle are those of its corners (e.g. O. C. Zienkiewicz, The Finite Element Method, 3rd ed.,
Section 7.6).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import drjit as dr

from pelagos.jit import Array

Corners: TypeAlias = tuple[Array, Array, Array]


@dataclass
class HullLoad:
    """Attributes: force, 3-array [m^3], and moment, 3-array [m^4], per rho g; area of the wet part [m^2]."""

    force: Array
    moment: Array
    area: Array


def wetted_load(corners: Corners, immersion: Corners, head: Corners) -> HullLoad:
    """Load on each triangle (lanes), integrated over the part of it that is under water.

    Args:
        corners: the three corners, 3-arrays [m].
        immersion: how far each corner is below the surface [m], negative in the air; decides what is wet.
        head: pressure over rho g at each corner [m]; equal to `immersion` in still water.
    """
    a, b, c = corners
    normal = 0.5 * dr.cross(b - a, c - a)  # area, outwards
    wet = [d > 0 for d in immersion]
    count = sum(dr.select(w, 1, 0) for w in wet)
    all_wet, none_wet = count == 3, count == 0

    whole0, whole1 = _moments((a, b, c), head)
    cut = ~all_wet & ~none_wet
    # most triangles are all wet or all dry: packets without one at the surface skip the rest
    share, tip0, tip1 = dr.if_stmt(
        (a, b, c, *immersion, *head),
        cut,
        lambda a, b, c, da, db, dc, ha, hb, hc: _tip((a, b, c), (da, db, dc), (ha, hb, hc)),
        lambda a, b, c, da, *_: (0 * da, 0 * da, 0 * a),
        mode="symbolic",
    )
    tip_is_wet = cut & (count == 1)
    zero = 0 * whole0
    pressure = dr.select(all_wet, whole0, dr.select(none_wet, zero, dr.select(tip_is_wet, tip0, whole0 - tip0)))
    first = dr.select(all_wet, whole1, dr.select(none_wet, 0 * whole1, dr.select(tip_is_wet, tip1, whole1 - tip1)))
    wet_share = dr.select(all_wet, 1.0, dr.select(none_wet, 0.0, dr.select(tip_is_wet, share, 1 - share)))
    return HullLoad(-pressure * normal, -dr.cross(first, normal), dr.norm(normal) * wet_share)


def _tip(corners: Corners, immersion: Corners, head: Corners) -> tuple[Array, Array, Array]:
    """The part of a triangle that is alone on its side of the surface: its share of the area, and its moments."""
    wet = [d > 0 for d in immersion]
    # The corner that is alone on its side of the surface comes first, the order of the others does not matter.
    second = (wet[1] != wet[0]) & (wet[1] != wet[2])
    third = (wet[2] != wet[0]) & (wet[2] != wet[1])

    def turned(x: Array, y: Array, z: Array) -> Corners:
        return (
            dr.select(second, y, dr.select(third, z, x)),
            dr.select(second, z, dr.select(third, x, y)),
            dr.select(second, x, dr.select(third, y, z)),
        )

    (ra, rb, rc), (da, db, dc), (ha, hb, hc) = turned(*corners), turned(*immersion), turned(*head)
    to_b, to_c = da / (da - db), da / (da - dc)
    share = to_b * to_c
    tip_head = (ha, ha + to_b * (hb - ha), ha + to_c * (hc - ha))
    tip0, tip1 = _moments((ra, ra + to_b * (rb - ra), ra + to_c * (rc - ra)), tip_head)
    return share, share * tip0, share * tip1


def _moments(corners: Corners, head: Corners) -> tuple[Array, Array]:
    """Mean over a triangle of the head, and of the head times the place."""
    a, b, c = corners
    ha, hb, hc = head
    total = ha + hb + hc
    return total / 3, (ha * a + hb * b + hc * c + total * (a + b + c)) / 12
