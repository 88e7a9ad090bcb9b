"""Things that people lose or leave on the seabed: tyres, drums, traps, anchors, mines, wrecks."""

from __future__ import annotations

from typing import Final

import numpy as np

from pelagos.world import shapes
from pelagos.world.generate import debris, waterfront, wreck
from pelagos.world.generate.thing import Kind, Part, Thing
from pelagos.world.mesh import Mesh, join


def _single(mesh: Mesh, name: str, label: str, material: str, *, sink: float = 0.0, follow: float = 1.0) -> Thing:
    return Thing(name, label, (Part(mesh, material),), sink, follow)


def tyre(size: float, rng: np.random.Generator) -> Thing:
    """A tyre, mostly lying."""
    ring = waterfront.tyre()
    ring = ring.moved((0, 0, 0.14)) if rng.uniform() < 0.75 else ring.turned(roll=1.5).moved((0, 0, 0.35))
    return _single(ring.scaled(size), "tyre", "tyre", "rubber", sink=0.06 * size)


def barrel(size: float, rng: np.random.Generator) -> Thing:
    """A steel drum, mostly lying."""
    drum = debris.drum() if rng.uniform() < 0.3 else debris.drum().turned(roll=np.pi / 2).moved((0, 0.44, 0.29))
    return _single(drum.scaled(size / 0.88), "barrel", "barrel", "rusted_steel", sink=0.08 * size)


def trap(size: float, rng: np.random.Generator) -> Thing:
    """A crab or lobster trap with its line and float."""
    crate = debris.crate().scaled(size)
    s = np.linspace(0, 1, 9)
    line = np.stack([0.3 * s, 0.2 * np.sin(3 * s), 0.4 + 2.2 * s], axis=1) * size
    rope = shapes.tube(line, 0.012, sides=5)
    ball = shapes.sphere(0.14, sides=14, rings=8).moved(line[-1])
    parts = (Part(crate, "rusted_steel"), Part(rope, "netting"), Part(ball, "red"))
    return Thing("crab trap", "trap", parts, 0.03, 0.0)


def anchor(size: float, rng: np.random.Generator) -> Thing:
    """An anchor on its side with a length of chain."""
    iron = debris.stock_anchor(size).turned(pitch=np.pi / 2 - 0.18).moved((-0.5 * size, 0, 0.28 * size))
    s = np.linspace(0, 1, 20)
    path = np.stack([0.6 * size + 2.5 * size * s, 0.5 * size * np.sin(4 * s), np.full(20, 0.05 * size)], axis=1)
    links = shapes.chain(path, 0.16 * size, 0.016 * size)
    return Thing("anchor", "anchor", (Part(iron, "rusted_steel"), Part(links, "rusted_steel", 60.0)), 0.05 * size, 1.0)


def bottom_mine(size: float, rng: np.random.Generator) -> Thing:
    """A cylindrical bottom mine, lying: `size` long, a quarter as thick."""
    r = size / 8
    profile = [
        (0, -size / 2),
        (0.7 * r, -size / 2),
        (r, -size / 2 + 0.4 * r),
        (r, size / 2 - r),
        (0.6 * r, size / 2 - 0.2 * r),
        (0, size / 2),
    ]
    body = shapes.revolve(profile, sides=28).turned(pitch=np.pi / 2).moved((0, 0, r))
    return _single(body, "bottom mine", "mine", "rusted_steel", sink=r * rng.uniform(0.1, 0.7))


def moored_mine(size: float, rng: np.random.Generator) -> Thing:
    """A sphere with horns, `size` across, on a wire above its sinker."""
    up = size * rng.uniform(3, 6)
    ball = shapes.sphere(size / 2, sides=32, rings=16).moved((0, 0, up))
    horns = []
    for polar in (0.5, 1.1):
        for turn in np.linspace(0, 2 * np.pi, 5, endpoint=False):
            d = np.array([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)])
            horns.append(shapes.beam(d * size * 0.48 + [0, 0, up], d * size * 0.62 + [0, 0, up], 0.04 * size, sides=8))
    wire = shapes.beam((0, 0, 0.4 * size), (0, 0, up - 0.48 * size), 0.008 * size + 0.004, sides=6)
    sinker = shapes.box((0.7 * size, 0.7 * size, 0.45 * size)).moved((0, 0, 0.22 * size))
    parts = (Part(join([ball, *horns]), "rusted_steel"), Part(wire, "steel"), Part(sinker, "rusted_steel"))
    return Thing("moored mine", "mine", parts, 0.05 * size, 0.0)


def manta_mine(size: float, rng: np.random.Generator) -> Thing:
    """A truncated cone mine, `size` across."""
    body = shapes.cone(size / 2, 0.45 * size, top_radius=0.24 * size, sides=32).moved((0, 0, 0.225 * size))
    return _single(body, "truncated cone mine", "mine", "black", sink=0.03 * size)


def rubbish(size: float, rng: np.random.Generator) -> Thing:
    """One piece of debris: pallet, girder, pipe, block, crate, log."""
    pick = int(rng.integers(0, 6))
    mesh, material = [
        (debris.pallet().scaled(size / 1.2), "wood"),
        (debris.girder(size), "rusted_steel"),
        (debris.pipe_piece(size, 0.1 * size), "rusted_steel"),
        (shapes.box((0.6 * size, 0.45 * size, 0.4 * size)).moved((0, 0, 0.2 * size)), "concrete"),
        (debris.crate().scaled(size), "rusted_steel"),
        (
            shapes.tube(
                [(-size / 2, 0, 0.06 * size), (0, 0.03 * size, 0.07 * size), (size / 2, 0, 0.06 * size)], 0.06 * size
            ),
            "wood",
        ),
    ][pick]
    return _single(mesh, "debris", "debris", material, sink=0.04 * size)


def boat(size: float, rng: np.random.Generator) -> Thing:
    """A sunken fishing boat, heeled and partly buried."""
    roll, pitch = rng.uniform(-0.35, 0.35), rng.uniform(-0.08, 0.08)
    parts = tuple(Part(m.turned(roll=roll, pitch=pitch), what, 35.0) for m, what in wreck.boat(size))
    return Thing("sunken boat", "boat", parts, 0.055 * size, 0.5)


def aircraft(size: float, rng: np.random.Generator) -> Thing:
    """A sunken propeller aircraft, `size` long: fuselage, wings (one broken off), tail, engine."""
    s = np.linspace(0, 1, 15)
    r = size * 0.075 * np.sqrt(np.clip(np.interp(s, [0, 0.05, 0.25, 0.5, 1.0], [0.15, 0.6, 1.0, 0.85, 0.06]), 0, 1))
    x = (0.5 - s) * size
    fuselage = shapes.tube(np.stack([x, np.zeros(15), 0.02 * size * s], axis=1), r, sides=20)
    wings = [_wing(0.55 * size, 0.2 * size).moved((0.12 * size, 0.04 * size, -0.03 * size))]
    broken = _wing(0.32 * size, 0.2 * size).scaled((1, -1, 1)).moved((0.12 * size, -0.04 * size, -0.03 * size))
    lost = _wing(0.24 * size, 0.15 * size).turned(yaw=1.9, roll=0.1).moved((-0.1 * size, -0.42 * size, -0.06 * size))
    tail = [
        _wing(0.18 * size, 0.1 * size).scaled((1, side, 1)).moved((-0.44 * size, 0, 0.03 * size)) for side in (1, -1)
    ]
    fin = _wing(0.16 * size, 0.12 * size).turned(roll=np.pi / 2).moved((-0.44 * size, 0, 0.02 * size))
    canopy = (
        shapes.sphere(1.0, sides=16, rings=8)
        .scaled((0.09 * size, 0.04 * size, 0.05 * size))
        .moved((0.08 * size, 0, 0.07 * size))
    )
    hub = np.array([0.51 * size, 0, 0])
    blades = [
        shapes.box((0.01 * size, 0.02 * size, 0.13 * size)).moved((0, 0, 0.06 * size)).turned(roll=a).moved(hub)
        for a in (0.4, 2.5, 4.6)
    ]
    roll, pitch = rng.uniform(-0.12, 0.12), rng.uniform(-0.02, 0.06)
    whole = join([fuselage, *wings, broken, lost, *tail, fin, canopy, *blades]).turned(roll=roll, pitch=pitch)
    return Thing(
        "sunken aircraft", "aircraft", (Part(whole.moved((0, 0, 0.06 * size)), "steel", 35.0),), 0.02 * size, 0.7
    )


def _wing(span: float, chord: float) -> Mesh:
    """A tapered wing along +y from its root."""
    a = np.linspace(0, 2 * np.pi, 14, endpoint=False)
    section = np.stack([0.5 * np.cos(a), 0.07 * np.sin(a)], axis=1)
    rows = []
    for s, c in ((0, 1.0), (0.7, 0.7), (1.0, 0.35)):
        rows.append(
            np.column_stack(
                [
                    section[:, 0] * chord * c - 0.12 * chord * s,
                    np.full(14, s * span),
                    section[:, 1] * chord * c + 0.04 * span * s,
                ]
            )
        )
    return shapes.loft(np.array(rows))


def submarine(size: float, rng: np.random.Generator) -> Thing:
    """A sunken submarine, `size` long: pressure hull, casing, sail with masts, planes, rudders, screw."""
    s = np.linspace(0, 1, 25)
    r = 0.055 * size * np.clip(np.interp(s, [0, 0.04, 0.12, 0.7, 0.93, 1], [0.05, 0.55, 1, 1, 0.35, 0.08]), 0, 1)
    hull = shapes.tube(np.stack([(0.5 - s) * size, np.zeros(25), np.zeros(25)], axis=1), r, sides=28)
    casing = shapes.box((0.66 * size, 0.04 * size, 0.02 * size)).moved((0.06 * size, 0, 0.058 * size))
    plan = [(0.12, 0), (0.09, 1), (-0.04, 1), (-0.07, 0), (-0.04, -1), (0.09, -1)]
    sail = shapes.loft(np.array([
        [(size * x, size * y * w, size * z) for x, y in plan] for z, w in ((0.05, 0.016), (0.12, 0.013))
    ]))  # fmt: skip
    masts = [
        shapes.cylinder(0.003 * size, 0.05 * size, sides=10).moved((x, 0, 0.14 * size))
        for x in (0.05 * size, 0.02 * size)
    ]
    planes = [
        _wing(0.07 * size, 0.05 * size).scaled((1, y, 1)).moved((x, 0, 0.01 * size))
        for x in (-0.43 * size, 0.38 * size)
        for y in (1, -1)
    ]
    fins = [_wing(0.07 * size, 0.05 * size).turned(roll=a).moved((-0.44 * size, 0, 0)) for a in (np.pi / 2, -np.pi / 2)]
    blades = [
        shapes.box((0.006 * size, 0.012 * size, 0.05 * size))
        .moved((0, 0, 0.02 * size))
        .turned(roll=a)
        .moved((-0.505 * size, 0, 0))
        for a in np.linspace(0, 5, 5)
    ]
    roll, pitch = rng.uniform(-0.3, 0.3), rng.uniform(-0.04, 0.04)
    whole = join([hull, casing, sail, *masts, *planes, *fins, *blades]).turned(roll=roll, pitch=pitch)
    return Thing(
        "sunken submarine", "sub", (Part(whole.moved((0, 0, 0.045 * size)), "rusted_steel", 35.0),), 0.015 * size, 0.7
    )


def mooring(size: float, rng: np.random.Generator) -> Thing:
    """A block and chain with a buoy `size` above the bed."""
    s = np.linspace(0, 1, 30)
    path = np.stack([0.12 * size * s**1.5, 0.05 * size * np.sin(3 * s), 0.9 + (size - 0.9) * s], axis=1)
    buoy = debris.buoy(0.6).moved(path[-1] + [0, 0, 0.65])
    parts = (
        Part(debris.mooring_block(), "concrete", None),
        Part(shapes.chain(path, 0.3, 0.03), "rusted_steel", 60.0),
        Part(buoy, "yellow", 50.0),
    )
    return Thing("mooring", "mooring", parts, 0.2, 0.0)


LOST: Final = {
    "tyre": Kind("Lorry tyres", "diameter", (0.6, 1.1), tyre, 8, 30.0, 0.0),
    "barrel": Kind("Steel drums", "height", (0.8, 1.0), barrel, 6, 30.0, 0.0),
    "crab_trap": Kind("Traps with line and float", "length", (0.7, 1.1), trap, 4, 20.0, 3.0),
    "anchor": Kind("Anchors with a length of chain", "length of the shank", (0.8, 2.5), anchor, 0, 25.0, 0.0),
    "bottom_mine": Kind("Cylindrical bottom mines", "length", (1.5, 2.6), bottom_mine, 6, 20.0, 0.0),
    "moored_mine": Kind("Horned mines on a wire", "diameter", (0.8, 1.1), moored_mine, 6, 20.0, 8.0),
    "manta_mine": Kind("Truncated cone mines", "diameter", (0.9, 1.1), manta_mine, 1, 20.0, 0.0),
    "debris": Kind("Pallets, girders, pipes, blocks, crates, logs", "length", (0.8, 3.0), rubbish, 0, 30.0, 0.0),
    "wreck_boat": Kind("Sunken fishing boats", "length", (9.0, 18.0), boat, 0, 15.0, 0.0),
    "wreck_aircraft": Kind("Sunken propeller aircraft", "length", (8.0, 16.0), aircraft, 0, 15.0, 0.0),
    "wreck_submarine": Kind("Sunken submarines", "length", (40.0, 75.0), submarine, 0, 12.0, 0.0),
    "mooring": Kind("Blocks with chain and a submerged buoy", "height of the buoy", (4.0, 10.0), mooring, 0, 20.0, 1.3),
}
"""The kinds of this module by name."""
