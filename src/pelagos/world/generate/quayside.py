"""A harbour's quay: containers in stacks, a shed, portal cranes, lamp posts. All of it above water."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pelagos.world import shapes
from pelagos.world.generate.waterfront import bollard
from pelagos.world.mesh import Mesh, join, rotation
from pelagos.world.site import Site

_CONTAINER = np.array([6.06, 2.44, 2.59])  # [m], ISO 668 1CC
_PAINTS = ("red", "blue", "green", "rusted_steel", "yellow", "weathered_paint")


def add_quayside(
    site: Site, *, x: tuple[float, float], face_y: float, back_y: float, top: float, rng: np.random.Generator
) -> None:
    """Furnish a quay along x that looks towards -y.

    Args:
        site: the world under construction.
        x: ends [m].
        face_y, back_y: front face and landward end [m].
        top: height of its upper face [m].
        rng: draws the containers' colours and the stacks' heights.
    """
    for at in np.arange(x[0] + 6.0, x[1] - 5.0, 18.0):
        site.add(bollard().moved((at, face_y + 0.7, top)), "steel", label="railing", name="quay bollard", crease_deg=40)
    middle = (x[0] + x[1]) / 2
    row = back_y - 0.6 - _CONTAINER[1] / 2
    shed = (middle - 26.0, middle - 2.0)
    for at in np.arange(x[0] + 5.0, x[1] - 5.0, _CONTAINER[0] + 0.35):
        if shed[0] - 5 < at < shed[1] + 5 or rng.uniform() < 0.25:
            continue
        for y in (row, row - _CONTAINER[1] - 0.15):
            _stack(site, (at, y, top), int(rng.integers(0, 4)), rng)
    _shed(site, ((shed[0] + shed[1]) / 2, back_y - 4.6, top), shed[1] - shed[0])
    for share in (0.24, 0.74):
        _crane(site, (x[0] + share * (x[1] - x[0]), face_y + 4.2, top), turn=rng.uniform(-0.5, 0.5))
    for at in np.arange(x[0] + 12.0, x[1] - 8.0, 24.0):
        _lamp_post(site, (at, face_y + 8.6, top))


def container() -> Mesh:
    """A container with corrugated walls, standing on the ground about the origin."""
    half = _CONTAINER / 2
    count = 22
    s = np.linspace(-half[0] + 0.1, half[0] - 0.1, 4 * count + 1)
    dent = np.tile([0.0, 0.0, 0.036, 0.036], count + 1)[: len(s)]  # a trapezoidal wave
    right = [(a, -half[1] + d) for a, d in zip(s, dent, strict=True)]
    left = [(a, half[1] - d) for a, d in zip(s[::-1], dent[::-1], strict=True)]
    ends = half[0] - 0.02
    outline = [(-ends, -half[1]), *right, (ends, -half[1]), (ends, half[1]), *left, (-ends, half[1])]
    walls = shapes.extrude(outline, _CONTAINER[2] - 0.1).moved((0, 0, 0.05))
    posts = [
        shapes.box((0.16, 0.16, _CONTAINER[2])).moved((sx * (half[0] - 0.08), sy * (half[1] - 0.07), half[2]))
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    bars = [shapes.beam((half[0] + 0.02, y, 0.15), (half[0] + 0.02, y, 2.45), 0.02, sides=6)
            for y in (-0.75, -0.35, 0.35, 0.75)]  # fmt: skip
    return join([walls, *posts, *bars])


def _stack(site: Site, at: tuple[float, float, float], height: int, rng: np.random.Generator) -> None:
    for k in range(height):
        turn = rotation(0, 0, np.pi * float(rng.integers(2)))
        place = (at[0] + rng.normal() * 0.03, at[1] + rng.normal() * 0.03, at[2] + k * _CONTAINER[2])
        paint = _PAINTS[int(rng.integers(len(_PAINTS)))]
        site.add(container().rotated(turn).moved(place), paint, label="crate", name="container")


def _shed(site: Site, at: tuple[float, float, float], length: float) -> None:
    """A brick shed with a pitched roof and three sliding doors towards the water."""
    width, eaves, ridge = 8.0, 4.8, 6.6
    x, y, z = at
    walls = shapes.box((length, width, eaves)).moved((x, y, z + eaves / 2))
    gable = np.array([(-width / 2 - 0.35, eaves - 0.12), (width / 2 + 0.35, eaves - 0.12), (0.0, ridge)])
    roof = shapes.extrude(gable, length + 0.8).rotated(rotation(np.pi / 2, 0, np.pi / 2))
    roof = roof.moved((x - (length + 0.8) / 2, y, z))
    instance = site.add(walls, "brick", label="building", name="shed")
    site.add(roof, "rusted_steel", label="building", name="shed", instance=instance)
    for k in (-1, 0, 1):
        door = shapes.box((3.6, 0.12, 3.8)).moved((x + k * length / 3.4, y - width / 2 - 0.02, z + 1.9))
        site.add(door, "green", label="building", name="shed", instance=instance)
        for side in (-3.0, 3.0):
            window = shapes.box((1.1, 0.1, 0.9)).moved((x + k * length / 3.4 + side, y - width / 2 - 0.01, z + 2.9))
            site.add(window, "black", label="building", name="shed", instance=instance)


def _crane(site: Site, at: tuple[float, float, float], turn: float) -> None:
    """A portal crane: four legs on the quay, a turning house, a lattice jib out over the water, a hook."""
    x, y, z = at
    span, depth, height = 3.6, 3.0, 7.0
    feet = [(sx * span, sy * depth) for sx in (-1, 1) for sy in (-1, 1)]
    portal = [shapes.beam((a, b, 0.0), (0.55 * a, 0.55 * b, height), 0.26, sides=8) for a, b in feet]
    portal += [shapes.box((2 * span + 0.8, 0.5, 0.5)).moved((0, sy * depth, 0.6)) for sy in (-1, 1)]
    portal += [shapes.box((0.62 * 2 * span, 0.62 * 2 * depth, 0.6)).moved((0, 0, height))]
    portal += [shapes.cylinder(1.1, 1.4, sides=20).moved((0, 0, height + 0.9))]
    swing = rotation(0, 0, -np.pi / 2 + turn)  # the jib points at the water
    house = shapes.box((4.4, 2.8, 2.6)).moved((-0.8, 0, height + 2.9))
    cab = shapes.box((1.3, 1.1, 1.5)).moved((1.9, -1.3, height + 2.8))
    weight = shapes.box((1.2, 2.6, 1.5)).moved((-3.4, 0, height + 2.3))
    foot, tip = np.array([1.2, 0.0, height + 2.2]), np.array([13.5, 0.0, height + 12.0])
    mast, side = np.array([-1.2, 0.0, height + 8.4]), np.array([0.0, 1.0, 0.0])
    frame = [shapes.beam((-0.2, s, height + 4.1), mast + 0.25 * s * side, 0.12, sides=8) for s in (-1, 1)]
    frame += [shapes.beam((-2.6, s, height + 4.1), mast + 0.25 * s * side, 0.12, sides=8) for s in (-1, 1)]
    ropes = [shapes.beam(mast + 0.2 * s * side, tip + 0.2 * s * side, 0.035, sides=6) for s in (-1, 1)]
    hook = tip - np.array([-0.1, 0.0, 11.0])
    ropes += [shapes.beam(tip, hook, 0.03, sides=6), shapes.box((0.5, 0.3, 0.8)).moved(hook)]
    moved = [m.rotated(swing).moved((x, y, z)) for m in (house, weight, join([*_lattice(foot, tip), *frame]))]
    instance = site.add(join(portal).moved((x, y, z)), "blue", label="building", name="crane")
    for mesh, paint in zip(moved, ("yellow", "concrete", "yellow"), strict=True):
        site.add(mesh, paint, label="building", name="crane", instance=instance)
    site.add(cab.rotated(swing).moved((x, y, z)), "white", label="building", name="crane", instance=instance)
    site.add(join(ropes).rotated(swing).moved((x, y, z)), "black", label="building", name="crane", instance=instance)


def _lattice(foot: NDArray[np.float64], tip: NDArray[np.float64]) -> list[Mesh]:
    """A jib of four chords that meet at the tip, laced together."""
    bars: list[Mesh] = []
    along = (tip - foot) / np.linalg.norm(tip - foot)
    up = np.cross(along, [0.0, 1.0, 0.0])
    s = np.linspace(0.0, 0.97, 9)
    wide = 0.62 * np.interp(s, [0, 0.25, 1], [0.5, 1.0, 0.15])
    nodes = [[foot + t * (tip - foot) + w * (a * np.array([0, 1, 0]) + b * up) for t, w in zip(s, wide, strict=True)]
             for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]  # fmt: skip
    for k, chord in enumerate(nodes):
        after = nodes[(k + 1) % 4]
        for i in range(len(s) - 1):
            bars.append(shapes.beam(chord[i], chord[i + 1], 0.07, sides=6))
            bars.append(shapes.beam(chord[i], after[i + 1], 0.035, sides=6))
    return bars


def _lamp_post(site: Site, at: tuple[float, float, float]) -> None:
    pole = shapes.beam((0, 0, -0.1), (0, 0, 9.0), 0.09, sides=10)
    arms = [shapes.beam((0, 0, 8.8), (0, s * 1.4, 9.2), 0.05, sides=8) for s in (-1, 1)]
    heads = [shapes.box((0.35, 0.8, 0.14)).moved((0, s * 1.7, 9.2)) for s in (-1, 1)]
    instance = site.add(join([pole, *arms]).moved(at), "steel", label="street_lamps", name="lamp post", crease_deg=40)
    site.add(join(heads).moved(at), "white", label="street_lamps", name="lamp post", instance=instance)
