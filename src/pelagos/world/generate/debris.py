"""Small things that lie about in harbours; each stands on z = 0 about the origin."""

from __future__ import annotations

import numpy as np

from pelagos.world import shapes
from pelagos.world.mesh import Mesh, join


def boulder(size: float, rng: np.random.Generator, *, sides: int = 18) -> Mesh:
    """A stone about `size` [m] across, in any attitude, its middle at the origin."""
    ball = shapes.noisy(shapes.sphere(0.5, sides=sides, rings=max(6, sides // 2)), 0.22, rng, scale=1.6)
    ball = ball.scaled(size * np.array([1.0, rng.uniform(0.65, 1.0), rng.uniform(0.5, 0.85)]))
    return ball.turned(roll=rng.uniform(-0.4, 0.4), pitch=rng.uniform(-0.4, 0.4), yaw=rng.uniform(0, 2 * np.pi))


def drum() -> Mesh:
    """A 200 litre steel drum, upright: 0.59 m across, 0.88 m high, with two rolling hoops."""
    r = 0.286
    profile = [(0, 0.02), (r - 0.02, 0.02), (r - 0.02, 0), (r, 0), (r, 0.28), (r + 0.012, 0.30), (r, 0.32), (r, 0.56)]
    profile += [(r + 0.012, 0.58), (r, 0.60), (r, 0.88), (r - 0.02, 0.88), (r - 0.02, 0.86), (0, 0.86)]
    return shapes.revolve(profile, sides=28)


def pallet() -> Mesh:
    """A wooden pallet, 1.2 m x 0.8 m x 0.144 m."""
    boards = [shapes.box((1.2, 0.1, 0.022)).moved((0, y, 0.133)) for y in np.linspace(-0.35, 0.35, 5)]
    across = [shapes.box((0.145, 0.8, 0.022)).moved((x, 0, 0.111)) for x in (-0.5, 0, 0.5)]
    feet = [shapes.box((0.145, 0.1, 0.1)).moved((x, y, 0.05)) for x in (-0.5, 0, 0.5) for y in (-0.35, 0, 0.35)]
    return join(boards + across + feet)


def crate() -> Mesh:
    """A wire lobster crate, 1.0 m x 0.6 m x 0.45 m: frame, slats, and an entrance hoop."""
    bars = []
    for y in (-0.3, 0.3):
        for z in (0.02, 0.43):
            bars.append(shapes.beam((-0.5, y, z), (0.5, y, z), 0.02, sides=6))
    for x in np.linspace(-0.5, 0.5, 6):
        for y in (-0.3, 0.3):
            bars.append(shapes.beam((x, y, 0.02), (x, y, 0.43), 0.012, sides=6))
        for z in (0.02, 0.43):
            bars.append(shapes.beam((x, -0.3, z), (x, 0.3, z), 0.012, sides=6))
    for z in (0.12, 0.22, 0.32):
        for y in (-0.3, 0.3):
            bars.append(shapes.beam((-0.5, y, z), (0.5, y, z), 0.01, sides=6))
    return join(bars)


def girder(length: float) -> Mesh:
    """A steel I-beam lying along x, 0.3 m high."""
    web = shapes.box((length, 0.012, 0.27)).moved((0, 0, 0.15))
    return join([web, *(shapes.box((length, 0.3, 0.02)).moved((0, 0, z)) for z in (0.01, 0.29))])


def pipe_piece(length: float, radius: float) -> Mesh:
    """An open piece of pipe lying along x."""
    wall = 0.05 * radius + 0.01
    turn = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rows = []
    for x, r in (
        (-length / 2, radius),
        (length / 2, radius),
        (length / 2, radius - wall),
        (-length / 2, radius - wall),
    ):
        rows.append(np.column_stack([np.full(20, x), ring * r + [0, radius]]))
    k = np.arange(4)[:, None] * 20
    nxt = (np.arange(4)[:, None] + 1) % 4 * 20
    s, t = np.arange(20), (np.arange(20) + 1) % 20
    faces = np.concatenate(
        [np.stack([k + s, nxt + t, k + t], -1).reshape(-1, 3), np.stack([k + s, nxt + s, nxt + t], -1).reshape(-1, 3)]
    )
    made = Mesh(np.concatenate(rows), faces.astype(np.uint32))
    return made if made.volume > 0 else Mesh(made.vertices, np.ascontiguousarray(made.faces[:, ::-1]))


def stock_anchor(size: float = 1.6) -> Mesh:
    """An Admiralty anchor lying on one fluke: shank, stock, arms, flukes, ring."""
    s = size
    arm = np.linspace(-1.05, 1.05, 13)
    arms = shapes.tube(
        np.stack([0.42 * s * np.sin(arm), np.zeros(13), 0.42 * s * (1 - np.cos(arm))], 1),
        np.interp(np.abs(arm), [0, 1.05], [0.07, 0.035]) * s,
        sides=10,
    )
    shank = shapes.beam((0, 0, 0), (0, 0, s), 0.05 * s)
    stock = shapes.beam((0, -0.45 * s, 0.9 * s), (0, 0.45 * s, 0.9 * s), 0.035 * s)
    ring = shapes.torus(0.09 * s, 0.018 * s, sides=16, tube_sides=8).turned(pitch=np.pi / 2).moved((0, 0, 1.08 * s))
    flukes = []
    for side in (1, -1):
        x, z = side * 0.42 * s * np.sin(1.0), 0.42 * s * (1 - np.cos(1.0))
        flukes.append(shapes.box((0.03 * s, 0.24 * s, 0.28 * s)).turned(pitch=-side * 0.6).moved((x * 0.95, 0, z)))
    return join([arms, shank, stock, ring, *flukes])


def mooring_block() -> Mesh:
    """A concrete sinker of 2.4 m^3 with a lifting eye."""
    body = shapes.loft(
        np.array(
            [[(x * h, y * h, z) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))] for z, h in ((0, 0.85), (1.0, 0.7))]
        )
    )
    eye = shapes.torus(0.14, 0.03, sides=16, tube_sides=8).turned(roll=np.pi / 2).moved((0, 0, 1.1))
    return join([body, eye])


def buoy(radius: float = 0.7) -> Mesh:
    """A mooring buoy about the origin, which lies on its water line."""
    ball = shapes.sphere(radius, sides=28, rings=14)
    mast = shapes.cylinder(0.05, radius * 1.2, sides=10).moved((0, 0, radius * 1.4))
    eye = shapes.torus(0.12, 0.03, sides=12, tube_sides=8).turned(roll=np.pi / 2).moved((0, 0, -radius - 0.08))
    return join([ball, mast, eye])
