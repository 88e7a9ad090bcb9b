"""A small cargo ship under way: hull with bulb and transom, hatches, deckhouse, funnel, screw and rudder."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pelagos.world import shapes
from pelagos.world.mesh import Mesh, join

BEAM: float = 0.16
"""Beam over length."""

DRAUGHT: float = 0.055
"""Draught over length."""

_DEPTH = 0.095  # keel to deck over length


def ship(length: float) -> list[tuple[Mesh, str]]:
    """Its parts with their materials: origin amidships on the waterline, bow towards +x, `length` [m]."""
    parts = [
        (join([_hull(), _bulb(), _rudder(), *_screw()]), "hull_paint"),
        (join([_hatch(x) for x in (0.3, 0.16, 0.02, -0.12)]), "rusted_steel"),
        (join([_house(), _funnel()]), "white"),
    ]
    return [(mesh.scaled(length), material) for mesh, material in parts]


def _section(s: float) -> NDArray[np.float64]:
    """Outline `(k, 3)` from the port deck edge round the keel to starboard at station s (0 stern, 1 bow)."""
    half = BEAM / 2 * np.interp(s, [0, 0.12, 0.3, 0.75, 0.9, 0.97, 1], [0.78, 0.94, 1, 1, 0.66, 0.28, 0.02])
    below = np.interp(s, [0, 0.1, 0.25, 0.8, 0.93, 1], [0.35, 0.55, 1, 1, 0.5, 0.03])  # fullness under water
    keel = -DRAUGHT * np.interp(s, [0, 0.05, 0.2, 1], [0.15, 0.45, 1, 1])
    deck = (_DEPTH - DRAUGHT) * (1 + 0.5 * np.clip((s - 0.75) / 0.25, 0, 1) ** 2)
    t = np.linspace(0, np.pi / 2, 9)
    z = keel - keel * (1 - np.cos(t))
    y = half * below * np.sin(t) ** 0.45
    side = np.stack([y, z], axis=1)
    side = np.concatenate([side, [[half, deck]]])
    x = s - 0.5 + 0.03 * np.clip(side[:, 1], 0, None) / _DEPTH * (s > 0.9)
    points = np.column_stack([np.broadcast_to(x, len(side)), side])
    return np.concatenate([points[::-1], points[1:] * [1, -1, 1]])


def _hull() -> Mesh:
    return shapes.loft(np.stack([_section(s) for s in np.linspace(0.0, 1.0, 41)]))


def _bulb() -> Mesh:
    return shapes.sphere(0.5, sides=20, rings=12).scaled((0.06, 0.03, 0.034)).moved((0.49, 0, -0.6 * DRAUGHT))


def _rudder() -> Mesh:
    return shapes.box((0.022, 0.004, 0.045)).moved((-0.495, 0, -0.036))


def _screw() -> list[Mesh]:
    blade = shapes.box((0.003, 0.010, 0.018)).turned(yaw=0.5).moved((0, 0, 0.011))
    return [blade.turned(roll=a).moved((-0.468, 0, -0.036)) for a in 2 * np.pi * np.arange(4) / 4]


def _hatch(x: float) -> Mesh:
    return shapes.box((0.1, 0.7 * BEAM, 0.012)).moved((x, 0, _DEPTH - DRAUGHT + 0.004))


def _house() -> Mesh:
    deck = _DEPTH - DRAUGHT
    floors = [shapes.box((0.1 - 0.02 * k, BEAM * (0.9 - 0.06 * k), 0.028)).moved((-0.36, 0, deck + 0.012 + 0.028 * k))
              for k in range(4)]  # fmt: skip
    wings = shapes.box((0.03, BEAM, 0.02)).moved((-0.33, 0, deck + 0.12))
    mast = shapes.cylinder(0.003, 0.09, sides=8).moved((-0.35, 0, deck + 0.16))
    return join([*floors, wings, mast])


def _funnel() -> Mesh:
    return shapes.cylinder(0.018, 0.07, sides=20).moved((-0.43, 0, _DEPTH - DRAUGHT + 0.06))
