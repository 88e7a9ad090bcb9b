"""Structures in the sea: piles, piers, walls, dams, platforms, turbines, manifolds, pens, docks."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.world import shapes
from pelagos.world.generate import waterfront
from pelagos.world.generate.thing import Kind, Part, Thing
from pelagos.world.mesh import Mesh, difference, join
from pelagos.world.ship import ship

_EMBED: Final = 3.0  # [m] that foundations reach into the ground


def piling(size: float, rng: np.random.Generator, depth: float) -> Thing:
    """One pile, `size` thick, that stands 2 m out of the water."""
    top, foot = np.array([0.0, 0.0, depth + 2.0]), np.array([0.0, 0.0, -_EMBED])
    # growth goes by the height over the water: build at true heights, then lift
    sunk = np.array([0.0, 0.0, -depth])
    mesh = waterfront.pile(top + sunk, foot + sunk, size / 2, 0.08 * size, rng).moved(-sunk)
    wood = rng.uniform() < 0.4
    return Thing("pile", "piling", (Part(mesh, "wood" if wood else "rusted_steel", 50.0),), follow=0.0)


def pier(size: float, rng: np.random.Generator, depth: float) -> Thing:
    """A finger pier, `size` long and 4 m wide, on pairs of piles."""
    bents = np.linspace(-size / 2 + 1.5, size / 2 - 1.5, max(2, round(size / 5) + 1))
    steel, deck = [], []
    for x in bents:
        for y in (-1.5, 1.5):
            steel.append(shapes.beam((x, y, -_EMBED), (x, y, depth + 1.2), 0.2, sides=14))
        deck.append(shapes.box((0.4, 4.0, 0.5)).moved((x, 0, depth + 1.3)))
        steel.append(shapes.beam((x, -1.5, depth - 2.0), (x, 1.5, depth + 0.9), 0.07, sides=8))
    deck.append(shapes.box((size, 4.2, 0.3)).moved((0, 0, depth + 1.7)))
    parts = (Part(join(steel), "rusted_steel", 50.0), Part(join(deck), "wood", None))
    return Thing("pier", "pier", parts, follow=0.0)


def moored_ship(size: float, rng: np.random.Generator, depth: float) -> Thing:
    """A cargo ship, `size` long, that lies still on the water."""
    parts = tuple(Part(mesh.moved((0, 0, depth)), material, 35.0) for mesh, material in ship(size))
    return Thing("moored ship", "container_boat", parts, follow=0.0)


def quay_wall(size: float, rng: np.random.Generator, depth: float) -> Thing:
    """A piece of concrete quay, `size` long, 6 m thick, with fenders and a ladder on the side of -y."""
    wall = shapes.box((size, 6.0, depth + 2.5 + _EMBED)).moved((0, 0, (depth + 2.5 - _EMBED) / 2))
    fenders = [
        shapes.box((0.45, 0.4, 4.0)).moved((x, -3.2, depth - 0.2)) for x in np.arange(-size / 2 + 2, size / 2 - 1, 5.0)
    ]
    rungs = waterfront.ladder(depth + 3.3, max(depth - 6.0, 0.2)).moved((size / 2 - 1.0, -3.0, 0))
    parts = _parts(([wall], "concrete", None), (fenders, "rubber", None), ([rungs], "steel", 50.0))
    return Thing("quay wall", "wall", parts, follow=0.0)


def dam(size: float, rng: np.random.Generator, depth: float) -> Thing:
    """A dam face, `size` long, that looks towards -y: battered concrete, buttresses, gates with frames, trash racks."""
    height = depth + 5.0
    section = [(0.35 * height + 3, -_EMBED), (0.35 * height + 3, height), (0, height), (-0.12 * height, -_EMBED)]
    body = shapes.loft(np.array([[(x, y, z) for y, z in section] for x in (-size / 2, size / 2)]))
    gates, racks, frames = [], [], []
    bays = np.arange(-size / 2 + 10, size / 2 - 5, 16.0)
    cuts = [shapes.box((4.4, 3.0, 4.4)).moved((x, -0.12 * height + 0.6, 0.22 * depth)) for x in bays]
    body = difference(body, cuts)
    for x in bays:
        z, y = 0.22 * depth, -0.12 * height
        gates.append(shapes.box((4.3, 0.3, 4.3)).moved((x, y + 1.8, z)))
        frames += [shapes.box((0.5, 1.2, 5.4)).moved((x + s * 2.45, y + 0.2, z)) for s in (-1, 1)]
        frames.append(shapes.box((5.4, 1.2, 0.5)).moved((x, y + 0.2, z + 2.45)))
        racks += [
            shapes.beam((x + b, y - 0.35, z - 2.4), (x + b, y - 0.1, z + 2.4), 0.03, sides=6)
            for b in np.linspace(-2.2, 2.2, 15)
        ]
        racks += [
            shapes.beam((x - 2.3, y - 0.3, z + b), (x + 2.3, y - 0.3, z + b), 0.05, sides=6) for b in (-1.8, 0.0, 1.8)
        ]
    buttress = [
        shapes.loft(
            np.array(
                [
                    [
                        (x + o, -0.12 * height - 1.6, -_EMBED),
                        (x + o, 1.5, -_EMBED),
                        (x + o, 1.5, height - 1),
                        (x + o, -0.2, height - 1),
                    ]
                    for o in (-0.8, 0.8)
                ]
            )
        )
        for x in np.arange(-size / 2 + 2, size / 2, 16.0)
    ]
    parts = _parts(
        ([body, *buttress], "concrete", None),
        (gates, "rusted_steel", None),
        (racks, "rusted_steel", 60.0),
        (frames, "concrete", None),
    )
    return Thing("dam", "wall", parts, follow=0.0)


def jacket(size: float, rng: np.random.Generator, depth: float) -> Thing:
    """An offshore jacket, `size` wide at its foot: four battered legs, braces, boat landing, deck."""
    top = depth + 8.0
    foot, head = size / 2, 0.32 * size
    corner = [(1, 1), (-1, 1), (-1, -1), (1, -1)]

    def at(k: int, z: float) -> NDArray[np.float64]:
        half = foot + (head - foot) * (z / top)
        return np.array([corner[k % 4][0] * half, corner[k % 4][1] * half, z])

    thick = 0.045 * size
    bars = [shapes.beam(at(k, -_EMBED), at(k, top), thick, sides=16) for k in range(4)]
    levels = np.linspace(0.5, top - 1.0, max(3, round(top / (0.7 * size)) + 1))
    for a, b in pairwise(levels):
        for k in range(4):
            bars.append(shapes.beam(at(k, a), at(k + 1, b), 0.5 * thick, sides=10))
            bars.append(shapes.beam(at(k + 1, a), at(k, b), 0.5 * thick, sides=10))
    for z in levels:
        bars += [shapes.beam(at(k, z), at(k + 1, z), 0.5 * thick, sides=10) for k in range(4)]
    bars += [shapes.beam(at(k, -_EMBED) * [1.12, 1.12, 1], at(k, 3.0) * [1.12, 1.12, 1], 0.7 * thick) for k in range(4)]
    anodes = [
        shapes.box((0.15 * thick * 4, 0.6 * thick, 1.2)).moved(at(k, z) + np.array([0, thick, 0]))
        for k in range(4)
        for z in levels[:-1] + 1.5
    ]
    deck = shapes.box((1.1 * size, 1.1 * size, 0.8)).moved((0, 0, top + 0.4))
    house = shapes.box((0.4 * size, 0.5 * size, 3.5)).moved((0.2 * size, 0, top + 2.5))
    parts = (
        Part(join(bars), "rusted_steel", 50.0),
        Part(join(anodes), "steel", None),
        Part(join([deck, house]), "yellow", None),
    )
    return Thing("offshore jacket", "jacket", parts, follow=0.0)


def turbine(size: float, rng: np.random.Generator, depth: float) -> Thing:
    """A wind turbine on a monopile of diameter `size`: pile, transition piece, tower, rotor, scour protection."""
    r = size / 2
    pile = shapes.cylinder(r, depth + 12 + 2 * _EMBED, sides=40).moved((0, 0, (depth + 12) / 2 - _EMBED + 0.0))
    piece = shapes.cylinder(1.05 * r, 14.0, sides=40).moved((0, 0, depth + 5.0))
    rails = shapes.torus(1.5 * r, 0.08, sides=40, tube_sides=6).moved((0, 0, depth + 12.9))
    platform = shapes.cylinder(1.6 * r, 0.3, sides=40).moved((0, 0, depth + 12.0))
    tower = shapes.cone(0.95 * r, 70.0, top_radius=0.55 * r, sides=40).moved((0, 0, depth + 47.0))
    nacelle = shapes.box((10, 3.6, 3.8)).moved((-1.5, 0, depth + 83.5))
    hub = np.array([4.2, 0, depth + 83.5])
    blades = []
    for turn in np.linspace(0.3, 0.3 + 2 * np.pi, 3, endpoint=False):
        s = np.linspace(0, 1, 8)
        chord = np.interp(s, [0, 0.15, 1], [1.5, 3.2, 0.5])
        rows = [
            [(0.1 * c, -c / 2, 48 * t), (0, c / 2, 48 * t), (-0.1 * c, -c / 2, 48 * t)]
            for t, c in zip(s, chord, strict=True)
        ]
        blades.append(shapes.loft(np.array(rows)).turned(roll=turn).moved(hub))
    stones = []
    shape = [shapes.noisy(shapes.sphere(0.5, sides=9, rings=6), 0.25, rng, scale=1.6) for _ in range(8)]
    for _ in range(int(60 * size)):
        away, turn = r + abs(rng.normal()) * 1.2 * size, rng.uniform(0, 2 * np.pi)
        lump = shape[int(rng.integers(8))].scaled(rng.uniform(0.3, 0.8))
        stones.append(lump.moved((away * np.cos(turn), away * np.sin(turn), rng.uniform(0.0, 0.35))))
    cable = shapes.tube(
        [(1.1 * r, 0, depth + 2), (1.15 * r, 0, 2.0), (1.6 * r, 0, 0.4), (3.5 * r, 0, 0.12)], 0.13, sides=10
    )
    parts = (
        Part(pile, "rusted_steel", 40.0), Part(join([piece, platform, rails]), "yellow", 40.0),
        Part(join([tower, nacelle, shapes.sphere(1.8, sides=20).moved(hub), *blades]), "white", 40.0),
        Part(join(stones), "rock", None), Part(cable, "black", 50.0),
    )  # fmt: skip
    return Thing("wind turbine", "turbine", parts, follow=0.0)


def manifold(size: float, rng: np.random.Generator) -> Thing:
    """A subsea manifold, `size` long: protection frame on a mud mat, headers, valves, hubs, a panel for an ROV."""
    w, h = 0.6 * size, 0.38 * size
    legs = [(sx * size / 2, sy * w / 2) for sx in (-1, 1) for sy in (-1, 1)]
    bars = [shapes.beam((x, y, 0), (0.85 * x, 0.85 * y, h), 0.018 * size + 0.05, sides=12) for x, y in legs]
    for z, k in ((0.15, 1.0), (h, 0.85)):
        ring = [
            (k * size / 2, k * w / 2, z),
            (-k * size / 2, k * w / 2, z),
            (-k * size / 2, -k * w / 2, z),
            (k * size / 2, -k * w / 2, z),
        ]
        bars += [
            shapes.beam(a, b, 0.014 * size + 0.04, sides=10) for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
        ]
    bars += [
        shapes.beam((x, -0.42 * w, h), (x, 0.42 * w, h), 0.05, sides=8) for x in np.linspace(-0.35, 0.35, 5) * size
    ]
    mat = shapes.box((1.1 * size, 1.15 * w, 0.12)).moved((0, 0, 0.06))
    pipes = []
    for y in (-0.16 * w, 0.16 * w):
        pipes.append(shapes.beam((-0.46 * size, y, 0.42 * h), (0.46 * size, y, 0.42 * h), 0.03 * size, sides=18))
        for x in np.linspace(-0.32, 0.32, 4) * size:
            pipes.append(shapes.beam((x, y, 0.42 * h), (x, 2.4 * y, 0.42 * h), 0.018 * size, sides=12))
            pipes.append(shapes.sphere(0.045 * size, sides=14, rings=8).moved((x, 1.5 * y, 0.42 * h)))
            pipes.append(shapes.cylinder(0.022 * size, 0.25 * h, sides=12).moved((x, 1.5 * y, 0.60 * h)))
            pipes.append(
                shapes.cylinder(0.035 * size, 0.05 * size, sides=16)
                .turned(roll=np.pi / 2)
                .moved((x, 2.4 * y, 0.42 * h))
            )
    panel = shapes.box((0.04 * size, 0.3 * w, 0.4 * h)).moved((0.44 * size, 0, 0.55 * h))
    parts = (
        Part(join([*bars, panel]), "yellow", 50.0),
        Part(join(pipes), "steel", 50.0),
        Part(mat, "rusted_steel", None),
    )
    return Thing("subsea manifold", "manifold", parts, 0.03, 0.6)


def net_pen(size: float, rng: np.random.Generator, depth: float) -> Thing:
    """A fish farm's pen, `size` across: floating collar, net of ropes with a pointed bottom, sinker ring, moorings."""
    r, deep = size / 2, min(0.65 * depth, 0.6 * size + 4)
    collar = [shapes.torus(r + o, 0.16, sides=72, tube_sides=8).moved((0, 0, depth)) for o in (0.0, 0.7)]
    rail = shapes.torus(r, 0.05, sides=72, tube_sides=6).moved((0, 0, depth + 1.0))
    turn = np.linspace(0, 2 * np.pi, 36, endpoint=False)
    posts = [
        shapes.beam((r * np.cos(t), r * np.sin(t), depth), (r * np.cos(t), r * np.sin(t), depth + 1.0), 0.04, sides=6)
        for t in turn
    ]
    ropes = [
        shapes.beam(
            (0.99 * r * np.cos(t), 0.99 * r * np.sin(t), depth),
            (0.9 * r * np.cos(t), 0.9 * r * np.sin(t), depth - deep),
            0.02,
            sides=5,
        )
        for t in np.linspace(0, 2 * np.pi, 96, endpoint=False)
    ]
    hoops = [
        shapes.torus(r * (0.99 - 0.09 * s), 0.02, sides=72, tube_sides=5).moved((0, 0, depth - s * deep))
        for s in np.linspace(0.06, 1, 18)
    ]
    point = max(depth - deep - 0.25 * r, 0.5)  # the bottom of the net hangs down to a point
    ropes += [
        shapes.beam((0.9 * r * np.cos(t), 0.9 * r * np.sin(t), depth - deep), (0, 0, point), 0.02, sides=5)
        for t in np.linspace(0, 2 * np.pi, 48, endpoint=False)
    ]
    hoops += [
        shapes.torus(0.9 * r * s, 0.02, sides=48, tube_sides=5).moved((0, 0, point + s * (depth - deep - point)))
        for s in (0.2, 0.4, 0.6, 0.8)
    ]
    sinker = shapes.torus(0.9 * r, 0.12, sides=72, tube_sides=8).moved((0, 0, depth - deep))
    lines = [
        shapes.beam(
            (r * np.cos(t), r * np.sin(t), depth - 0.2), (1.9 * r * np.cos(t), 1.9 * r * np.sin(t), -0.3), 0.04, sides=6
        )
        for t in np.linspace(0.4, 0.4 + 2 * np.pi, 8, endpoint=False)
    ]
    buoys = [
        shapes.sphere(0.5, sides=20, rings=10).moved((1.12 * r * np.cos(t), 1.12 * r * np.sin(t), depth))
        for t in np.linspace(0.4, 0.4 + 2 * np.pi, 8, endpoint=False)
    ]
    parts = (
        Part(join([*collar, rail, *posts]), "black", 60.0),
        Part(join(buoys), "yellow", 60.0),
        Part(join([*ropes, *hoops]), "netting", None),
        Part(join([sinker, *lines]), "black", 60.0),
    )
    return Thing("net pen", "net", parts, follow=0.0)


def dock(size: float, rng: np.random.Generator) -> Thing:
    """An AUV's docking station, `size` long: entrance cone, tube of hoops, frame, four feet, lights."""
    r, axis = 0.16 * size, 0.45 * size
    wall = _funnel(0.20 * size, 2.2 * r, r, 0.012).moved((0.4 * size, 0, axis))
    hoops = [
        shapes.torus(r, 0.012 * size, sides=28, tube_sides=8).turned(pitch=np.pi / 2).moved((x, 0, axis))
        for x in np.linspace(-0.45, 0.3, 7) * size
    ]
    rails = [
        shapes.beam(
            (-0.46 * size, r * np.cos(t), axis + r * np.sin(t)),
            (0.31 * size, r * np.cos(t), axis + r * np.sin(t)),
            0.01 * size,
            sides=8,
        )
        for t in (0.3, 1.57, 2.84, 3.9, 5.5)
    ]
    legs = [
        shapes.beam((x, 0.8 * r * s, axis - 0.6 * r), (1.1 * x, 2.4 * r * s, 0), 0.014 * size, sides=8)
        for x in (-0.4 * size, 0.28 * size)
        for s in (-1, 1)
    ]
    feet = [
        shapes.cylinder(0.06 * size, 0.03 * size, sides=16).moved((1.1 * x, 2.4 * r * s, 0))
        for x in (-0.4 * size, 0.28 * size)
        for s in (-1, 1)
    ]
    lamps = [
        shapes.sphere(0.02 * size, sides=12, rings=6).moved(
            (0.5 * size, 2.3 * r * np.cos(t), axis + 2.3 * r * np.sin(t))
        )
        for t in np.linspace(0, 2 * np.pi, 6, endpoint=False)
    ]
    parts = (
        Part(join([wall, *hoops, *rails]), "yellow", 50.0),
        Part(join([*legs, *feet]), "steel", 50.0),
        Part(join(lamps), "white", 60.0),
    )
    return Thing("docking station", "dock", parts, 0.02, 0.5)


def _funnel(length: float, wide: float, narrow: float, wall: float) -> Mesh:
    """A hollow cone along x that opens towards +x."""
    outer = shapes.cone(narrow, length, top_radius=wide, sides=32)
    inner = shapes.cone(narrow - wall, length + 0.02, top_radius=wide - wall, sides=32)
    return difference(outer, [inner]).turned(pitch=np.pi / 2)


STRUCTURES: Final = {
    "piling": Kind("Single piles that reach out of the water", "diameter", (0.3, 0.8), None, 0, 30.0, 0.0, piling),
    "pier": Kind("Finger piers on pairs of piles", "length", (20.0, 50.0), None, 0, 12.0, 0.0, pier),
    "moored_ship": Kind("Cargo ships at berth or at anchor", "length", (40.0, 90.0), None, 0, 30.0, 0.1, moored_ship),
    "quay_wall": Kind("Pieces of concrete quay", "length", (20.0, 60.0), None, 0, 12.0, 0.0, quay_wall),
    "dam": Kind("A dam face with gates and trash racks", "length", (60.0, 150.0), None, 0, 15.0, 0.0, dam),
    "jacket": Kind("Offshore jackets with deck", "width of the foot", (12.0, 25.0), None, 0, 10.0, 0.5, jacket),
    "turbine": Kind("Wind turbines on monopiles", "diameter of the pile", (5.0, 8.0), None, 0, 10.0, 1.0, turbine),
    "manifold": Kind("Subsea manifolds", "length", (6.0, 14.0), manifold, 0, 8.0, 1.0),
    "net_pen": Kind("Fish farm pens with moorings", "diameter", (16.0, 50.0), None, 0, 20.0, 0.5, net_pen),
    "dock": Kind("Docking stations for torpedo vehicles", "length", (2.5, 4.0), dock, 0, 10.0, 1.5),
}
"""The kinds of this module by name."""


def _parts(*of: tuple[Sequence[Mesh], str, float | None]) -> tuple[Part, ...]:
    """Meshes joined by material and crease [deg], without those that a small thing has no room for."""
    return tuple(Part(join(meshes), material, crease) for meshes, material, crease in of if meshes)
