"""A sunken fishing boat: hull lofted from sections, open hold with frames, wheelhouse, mast, rudder and screw."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.world import shapes
from pelagos.world.mesh import Mesh, difference, join

PROPORTIONS: Final = (13.5, 4.3, 2.3)
"""Length, beam and depth of the boat as drawn [m]; other lengths scale it."""

_L, _B, _D = PROPORTIONS


def _section(s: float, *, shell: float = 0.0, over: float = 0.0, points: int = 15) -> NDArray[np.float64]:
    """Outline `(2 points - 1, 3)` from the port gunwale round the keel to starboard at station s (0 stern, 1 bow).

    `shell` [m] moves it inwards, `over` [m] raises its ends. The keel lies at z = 0, x = 0 amidships, y to port.
    """
    half = _B / 2 * (0.84 + 0.16 * np.sin(np.pi * min(s / 0.55, 1) / 2)) * (1 - max(0.0, (s - 0.55) / 0.45) ** 2.3)
    half = max(half - shell, 0.02)
    keel = 1.15 * max(0.0, (s - 0.86) / 0.14) ** 2 + 0.55 * max(0.0, (0.16 - s) / 0.16) ** 1.5 + shell
    sheer = _D * (1 + 0.08 * (1 - 2 * s) ** 2 + 0.26 * s**3) + over
    fullness = np.interp(s, [0, 0.35, 0.6, 0.85, 1], [0.50, 0.42, 0.50, 0.85, 1.1])
    t = np.linspace(0, np.pi / 2, points)
    y = half * np.sin(t) ** fullness
    z = keel + (sheer - keel) * (1 - np.cos(t) ** 1.4)
    x = (s - 0.5) * _L + 0.35 * s**2 * (z / _D)  # raked stem
    side = np.stack([x, y, z], axis=1)
    return np.concatenate([side[::-1], (side * [1, -1, 1])[1:]])


def _skin(first: float, last: float, *, shell: float = 0.0, over: float = 0.0, stations: int = 26) -> Mesh:
    rows = [_section(s, shell=shell, over=over) for s in np.linspace(first, last, stations)]
    return shapes.loft(np.stack(rows))


def hull() -> Mesh:
    """The shell: solid foredeck and afterdeck, an open hold between, a hole stove in the starboard side."""
    solid = _skin(0.0, 0.995, stations=36)
    bulwark = difference(solid, [_above_deck()])
    hold = _skin(0.40, 0.74, shell=0.10, over=0.8)
    stove = shapes.noisy(shapes.sphere(0.55, sides=14, rings=8), 0.5, np.random.default_rng(7), scale=2.0)
    return difference(bulwark, [hold, stove.moved((1.3, -2.0, 1.3))])


def _above_deck() -> Mesh:
    """The space over the deck, inside the bulwarks: the hull's own plan raised to 0.45 m below the gunwale."""
    rows = []
    for s in np.linspace(0.015, 0.95, 24):
        edge = _section(s)
        half, top = edge[0, 1] - 0.09, edge[0, 2]
        x = edge[0, 0]
        half = max(half, 0.03)
        rows.append([(x, half, top + 1), (x, half, top - 0.45), (x, -half, top - 0.45), (x, -half, top + 1)])
    return shapes.loft(np.array(rows))


def frames() -> Mesh:
    """Ribs along the inside of the hold, every 0.55 m, and the keelson."""
    ribs = []
    for s in np.arange(0.42, 0.735, 0.55 / _L):
        line = _section(s, shell=0.14)
        ribs.append(shapes.tube(line[1:-1], 0.055, sides=6))
    keelson = shapes.beam((-1.0, 0, 0.22), (3.0, 0, 0.22), 0.11, sides=8)
    return join([*ribs, keelson])


def wheelhouse() -> Mesh:
    """A hollow house with window openings, standing on the after deck."""
    shell = shapes.box((2.6, 2.3, 2.1))
    cuts = [shapes.box((2.4, 2.1, 1.9)).moved((0, 0, 0))]
    cuts += [shapes.box((0.5, 0.62, 0.6)).moved((1.3, y, 0.45)) for y in (-0.72, 0.0, 0.72)]
    cuts += [shapes.box((0.7, 0.5, 0.6)).moved((x, y, 0.45)) for x in (-0.55, 0.5) for y in (-1.15, 1.15)]
    cuts += [shapes.box((0.5, 0.7, 1.7)).moved((-1.3, 0.5, -0.1))]  # the door, open aft
    roof = shapes.box((3.0, 2.6, 0.1)).moved((0, 0, 1.1))
    funnel = shapes.cylinder(0.18, 0.6, sides=16).moved((-0.8, -0.7, 1.3))
    return join([difference(shell, cuts), roof, funnel]).moved((-3.2, 0, _D - 0.42 + 1.05))


def rig() -> Mesh:
    """Mast (fallen back on the deck), derrick post, hatch coaming, bow rail, rudder, screw."""
    deck = _D - 0.42
    parts = [
        shapes.beam((2.6, 0.1, deck), (-1.1, 1.35, deck + 1.5), 0.09),
        shapes.beam((2.9, 0, deck), (2.9, 0, deck + 1.6), 0.11),
        shapes.box((4.4, 0.12, 0.35)).moved((1.0, 1.35, deck + 0.1)),
        shapes.box((4.4, 0.12, 0.35)).moved((1.0, -1.35, deck + 0.1)),
        shapes.cylinder(0.28, 0.9, sides=16).turned(roll=np.pi / 2).moved((3.6, 0, deck + 0.45)),  # anchor winch
        shapes.box((0.9, 0.08, 1.3)).moved((-_L / 2 - 0.25, 0, 0.9)),  # rudder
        shapes.cylinder(0.07, 1.2, sides=10).turned(pitch=np.pi / 2).moved((-_L / 2 + 0.5, 0, 0.45)),
    ]
    for turn in np.linspace(0, 2 * np.pi, 3, endpoint=False):
        blade = shapes.sphere(1.0, sides=10, rings=6).scaled((0.05, 0.12, 0.28)).turned(yaw=0.5).moved((0, 0, 0.28))
        parts.append(blade.turned(roll=turn).moved((-_L / 2 + 0.02, 0, 0.45)))
    rail = []
    for side in (1, -1):
        top = []
        for s in np.linspace(0.74, 0.97, 6):
            edge = _section(s)[0] * np.array([1, side, 1])
            over = edge + np.array([0, 0, 0.7])
            rail.append(shapes.beam(edge - np.array([0, 0, 0.05]), over, 0.025, sides=6))
            top.append(over)
        rail.append(shapes.tube(np.array(top), 0.025, sides=6))
    return join(parts + rail)


def boat(length: float = _L) -> list[tuple[Mesh, str]]:
    """The boat's parts with their materials; bow towards +x, keel on z = 0, scaled to `length` [m]."""
    scale = length / _L
    parts = [
        (hull(), "rusted_steel"),
        (frames(), "rusted_steel"),
        (wheelhouse(), "weathered_paint"),
        (rig(), "rusted_steel"),
    ]
    return [(mesh.scaled(scale), material) for mesh, material in parts]
