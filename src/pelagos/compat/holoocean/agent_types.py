"""HoloOcean's agents by their names.

Facts: HoloOcean 2.3 and its documentation (BYU FRoSt Lab, MIT licence).
"""

from __future__ import annotations

from typing import Final

from pelagos.compat.holoocean.agent_type import DOWN, FLIPPED, AgentType, sockets_of
from pelagos.compat.holoocean.land_agents import HUSKY, NAV, SPHERE, TURTLE, UAV
from pelagos.compat.holoocean.thruster_agents import (
    BLUEROV2,
    HOVER_ACCEL,
    HOVER_LIMIT,
    HOVERING_SOCKETS,
    SURFACE,
    hovering,
)
from pelagos.compat.holoocean.torpedo_agents import torpedo

AGENT_TYPES: Final[dict[str, AgentType]] = {
    a.name: a
    for a in (
        hovering("HoveringAUV", "HoveringAUV", mass=31.02, limit=HOVER_LIMIT, sockets=HOVERING_SOCKETS, lamps=(
            (0.31, -0.25, 0.14), (0.31, 0.25, 0.14), (0.31, -0.25, -0.15), (0.31, 0.25, -0.15))),
        hovering("FixedWing", "FixedWing", mass=31.02, limit=HOVER_LIMIT),
        hovering("ScubaDiver", "ScubaDiver", mass=100.0, limit=250.0),
        BLUEROV2,
        torpedo(
            "TorpedoAUV", "TorpedoAUV", "torpedo", drag_area=0.025, limits=None,
            inertia=(1.050901, 19.77644, 20.12126), products=(-0.008125074, 0.003106652, 0.01013012),
            lamps=((1.05, 0.0, 0.0),),
            sockets=sockets_of(
                SonarSocket=(0, 0, -7, DOWN), DVLSocket=(-30, 0, -7), IMUSocket=(86, -3, -3), DepthSocket=(95, 3, 3),
                CameraSocket=(30, 0, -7, DOWN), Viewport=(-400, 0, 300),
            ),
        ),
        torpedo(
            "CougUV", "CougUV", "couguv", drag_area=0.15, limits=HOVER_ACCEL,
            inertia=(0.7423271, 4.667311, 4.989965), products=(-0.01084379, -0.00249569, 0.04351779),
            lamps=((0.62, -0.002, 0.085),),
            sockets=sockets_of(
                COM=(0, 0, 0), DVLSocket=(50.4, 0, -5.3, FLIPPED), IMUSocket=(50.4, 0, -5.3, FLIPPED),
                DepthSocket=(16.2, 0, 0), AcousticModemSocket=(37.85, 0, -9.85), CameraSocket=(10, 0, 0),
                Viewport=(-216, 0, 138),
            ),
        ),
        SURFACE,
        UAV,
        SPHERE,
        NAV,
        TURTLE,
        HUSKY,
    )
}  # fmt: skip
