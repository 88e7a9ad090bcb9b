"""Closed meshes of simple shapes, faces outwards, in metres, centred at the origin where nothing else is said."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.world.mesh import Mesh


def box(size: ArrayLike) -> Mesh:
    """A box of edge lengths `size (3,)`."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    faces = [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]  # fmt: skip
    return Mesh(corners * np.asarray(size, dtype=np.float64) / 2, np.array(faces, dtype=np.uint32))


def plane(size: tuple[float, float]) -> Mesh:
    """A horizontal rectangle that faces up: open."""
    x, y = size[0] / 2, size[1] / 2
    corners = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]], dtype=np.float64)
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32))


def cylinder(radius: float, height: float, *, sides: int = 24) -> Mesh:
    """An upright cylinder."""
    return revolve([(0, -height / 2), (radius, -height / 2), (radius, height / 2), (0, height / 2)], sides=sides)


def cone(radius: float, height: float, *, top_radius: float = 0.0, sides: int = 24) -> Mesh:
    """An upright cone, or a frustum where `top_radius` is not zero; its base lies at z = -height/2."""
    profile = [(0, -height / 2), (radius, -height / 2), (top_radius, height / 2), (0, height / 2)]
    return revolve(profile if top_radius > 0 else profile[:3], sides=sides)


def sphere(radius: float, *, sides: int = 24, rings: int = 12) -> Mesh:
    """A sphere of `rings` bands of latitude."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)
    profile = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    profile[[0, -1], 0] = 0
    return revolve(profile, sides=sides)


def torus(radius: float, tube_radius: float, *, sides: int = 24, tube_sides: int = 12) -> Mesh:
    """A ring in the horizontal plane: `radius` to the middle of the tube."""
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    around = np.linspace(2 * np.pi, 0, tube_sides, endpoint=False)
    rho = radius + tube_radius * np.cos(around)
    rings = np.stack(
        [
            np.cos(turn)[:, None] * rho,
            np.sin(turn)[:, None] * rho,
            np.broadcast_to(tube_radius * np.sin(around), (sides, tube_sides)),
        ],
        axis=-1,
    )
    return Mesh(rings.reshape(-1, 3), _skin(sides, tube_sides, closed_along=True))


def revolve(profile: ArrayLike, *, sides: int = 24) -> Mesh:
    """A profile `(k, 2)` of (radius, z), from bottom to top, turned about z; it must begin and end on the axis."""
    outline = np.asarray(profile, dtype=np.float64)
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    body = outline[1:-1]
    rings = np.stack(
        [body[:, :1] * np.cos(turn), body[:, :1] * np.sin(turn), np.broadcast_to(body[:, 1:], (len(body), sides))],
        axis=-1,
    )
    return _closed_stack(rings, np.array([0, 0, outline[0, 1]]), np.array([0, 0, outline[-1, 1]]))


def loft(sections: ArrayLike) -> Mesh:
    """A skin over closed outlines `(k, s, 3)`, all wound the same way; the ends are fanned shut."""
    rings = np.asarray(sections, dtype=np.float64)
    made = _closed_stack(rings, rings[0].mean(axis=0), rings[-1].mean(axis=0))
    return made if made.volume > 0 else Mesh(made.vertices, np.ascontiguousarray(made.faces[:, ::-1]))


def extrude(outline: ArrayLike, height: float) -> Mesh:
    """A simple polygon `(k, 2)`, counter-clockwise, raised from z = 0 to `height`."""
    import manifold3d

    polygon = np.asarray(outline, dtype=np.float64)
    caps = np.asarray(manifold3d.triangulate([polygon]), dtype=np.uint32)
    count = len(polygon)
    bottom = np.column_stack([polygon, np.zeros(count)])
    top = np.column_stack([polygon, np.full(count, height)])
    sides = _skin(2, count)
    return Mesh(
        np.concatenate([bottom, top]), np.concatenate([caps[:, ::-1], caps + np.uint32(count), sides]).astype(np.uint32)
    )


def tube(path: ArrayLike, radius: float | NDArray[np.float64], *, sides: int = 16) -> Mesh:
    """A round tube along a path `(k, 3)` with shut ends; `radius` [m] is one number, or `(k,)`."""
    points = np.asarray(path, dtype=np.float64)
    tangent = np.gradient(points, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side, up = _frames(tangent)
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    r = np.broadcast_to(np.asarray(radius, dtype=np.float64), (len(points),))[:, None, None]
    rings = points[:, None, :] + r * (np.cos(turn)[:, None] * side[:, None, :] + np.sin(turn)[:, None] * up[:, None, :])
    return _closed_stack(rings, points[0], points[-1])


def beam(start: ArrayLike, end: ArrayLike, radius: float, *, sides: int = 12) -> Mesh:
    """A straight round bar between two points: a `tube` of one section, made without its general frames."""
    a, b = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    tangent = (b - a) / np.linalg.norm(b - a)
    axis = np.array([0.0, 0.0, 1.0]) if abs(tangent[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    across = _cross(axis, tangent)
    side = across / np.linalg.norm(across)
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    ring = radius * (np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * _cross(tangent, side))
    return Mesh(np.concatenate([a + ring, b + ring, a[None], b[None]]), _closed_faces(2, sides).copy())


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """The cross product of two vectors `(3,)`; NumPy's own takes ten times as long for one pair."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def chain(path: ArrayLike, link_length: float, wire_radius: float) -> Mesh:
    """Oval links along a path `(k, 3)`, every other one turned by a quarter; closed link by link."""
    from pelagos.world.mesh import join

    points = np.asarray(path, dtype=np.float64)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    pitch = link_length - 2.2 * wire_radius
    stations = np.arange(pitch / 2, along[-1], pitch)
    at = np.stack([np.interp(stations, along, points[:, i]) for i in range(3)], axis=1)
    ahead = np.stack([np.interp(stations + pitch / 2, along, points[:, i]) for i in range(3)], axis=1)
    behind = np.stack([np.interp(stations - pitch / 2, along, points[:, i]) for i in range(3)], axis=1)
    tangent = ahead - behind
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side, up = _frames(tangent)
    ring = torus(link_length * 0.3, wire_radius, sides=10, tube_sides=6)
    stretch = (link_length / 2 - wire_radius) / (link_length * 0.3)
    oval = ring.scaled((stretch, 1.0, 1.0)).vertices
    links = []
    for k, (p, t, s, u) in enumerate(zip(at, tangent, side, up, strict=True)):
        a, b = (s, u) if k % 2 == 0 else (u, -s)
        links.append(Mesh(p + oval @ np.stack([t, a, b]), ring.faces))
    return join(links)


def _frames(tangent: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two unit vectors `(k, 3)` across each tangent that turn as little as they must (side x up = tangent)."""
    side = np.empty_like(tangent)
    start = np.array([0.0, 0.0, 1.0]) if abs(tangent[0, 2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    previous = np.cross(start, tangent[0])
    for k, t in enumerate(tangent):
        across = previous - t * (previous @ t)
        previous = side[k] = across / np.linalg.norm(across)
    return side, np.cross(tangent, side)


def _skin(rings: int, sides: int, *, closed_along: bool = False) -> NDArray[np.uint32]:
    """Faces between consecutive rings of `sides` vertices, each counter-clockwise seen from the next."""
    k = np.arange(rings if closed_along else rings - 1)[:, None]
    s = np.arange(sides)
    a = k * sides + s
    b = k * sides + (s + 1) % sides
    c = (k + 1) % rings * sides + s
    d = (k + 1) % rings * sides + (s + 1) % sides
    return np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)]).astype(
        np.uint32
    )


def _closed_stack(rings: NDArray[np.float64], first: NDArray[np.float64], last: NDArray[np.float64]) -> Mesh:
    """Rings `(k, s, 3)` skinned and shut with fans to the two end points."""
    k, s = rings.shape[:2]
    return Mesh(np.concatenate([rings.reshape(-1, 3), first[None], last[None]]), _closed_faces(k, s).copy())


@cache
def _closed_faces(k: int, s: int) -> NDArray[np.uint32]:
    """Faces of `k` rings of `s` vertices, and of the fans to two further vertices that shut the ends."""
    turn = np.arange(s)
    bottom, top = k * s, k * s + 1
    fan_first = np.stack([np.full(s, bottom), (turn + 1) % s, turn], axis=-1)
    fan_last = np.stack([np.full(s, top), (k - 1) * s + turn, (k - 1) * s + (turn + 1) % s], axis=-1)
    return np.concatenate([_skin(k, s), fan_first, fan_last]).astype(np.uint32)


def noisy(mesh: Mesh, amplitude: float, rng: np.random.Generator, *, waves: int = 6, scale: float = 1.0) -> Mesh:
    """Vertices pushed along their direction from the middle by a smooth random field: stones.

    Args:
        mesh: closed, star-shaped about the origin.
        amplitude: about the greatest change of radius, relative to it.
        rng: random numbers.
        waves: how many plane waves make the field.
        scale: wave number of the slowest, relative to the unit sphere.
    """
    direction = mesh.vertices / np.maximum(np.linalg.norm(mesh.vertices, axis=1, keepdims=True), 1e-12)
    field = np.zeros(len(direction))
    for k in range(waves):
        wave = rng.normal(size=3) * scale * (1 + 0.6 * k)
        field += np.sin(direction @ wave + rng.uniform(0, 2 * np.pi)) / (1 + 0.5 * k)
    return Mesh(mesh.vertices * (1 + amplitude * field[:, None] / 2), mesh.faces)
