"""Quay walls, piers on piles, fenders, ladders and bollards."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pelagos.world import shapes
from pelagos.world.mesh import Mesh, join
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField

_EMBED = 3.0  # [m] that piles and walls reach into the ground


def pile(
    top: NDArray[np.float64], bottom: NDArray[np.float64], radius: float, growth: float, rng: np.random.Generator
) -> Mesh:
    """A round pile from bottom to top, overgrown below the water line by up to about `growth` [m]."""
    length = float(np.linalg.norm(top - bottom))
    count = max(3, int(length / 0.7))
    s = np.linspace(0, 1, count + 1)
    path = bottom + s[:, None] * (top - bottom)
    mesh = shapes.tube(path, radius, sides=16)
    z = mesh.vertices[:, 2]
    # mussels and weed: thick from the low-water line down to 6 m, thin below, bare in the air
    thick = np.interp(z, [-30, -9, -5, -0.6, 0.1, 0.3], [0.15, 0.3, 1.0, 0.9, 0.4, 0.0])
    axis = bottom + np.clip((z - bottom[2]) / (top[2] - bottom[2]), 0, 1)[:, None] * (top - bottom)
    out = mesh.vertices - axis
    reach = np.linalg.norm(out, axis=1, keepdims=True)
    bumps = growth * thick * rng.uniform(0.2, 1.0, len(z))
    grown = np.where(reach > radius / 2, out / np.maximum(reach, 1e-9), 0.0) * bumps[:, None]
    return Mesh(mesh.vertices + grown, mesh.faces)


@dataclass(frozen=True)
class Pier:
    """A pier deck parallel to x on rows of piles.

    Attributes:
        x: (first, last) bent [m].
        rows: y of each row of piles, from the water side [m].
        bay: distance of bents along x [m].
        deck: height of the deck's upper face above the mean sea surface [m].
        radius: of a steel pile [m].
        fender_radius: of a wooden fender pile [m].
    """

    x: tuple[float, float]
    rows: tuple[float, ...]
    bay: float
    deck: float
    radius: float
    fender_radius: float

    @property
    def bents(self) -> NDArray[np.float64]:
        """x of each bent [m]."""
        count = max(2, round((self.x[1] - self.x[0]) / self.bay) + 1)
        return np.linspace(self.x[0], self.x[1], count)

    def feet(self) -> NDArray[np.float64]:
        """`(k, 2)` where plumb and fender piles enter the ground [m]."""
        plumb = [(x, y) for x in self.bents for y in self.rows]
        return np.array(plumb + [(x, self.fender_y) for x in self.fender_x], dtype=np.float64)

    @property
    def fender_y(self) -> float:
        """y of the row of fender piles [m]."""
        return self.rows[0] - 1.1

    @property
    def fender_x(self) -> NDArray[np.float64]:
        """x of each fender pile, two in a bay [m]."""
        bents = self.bents
        step = (bents[1] - bents[0]) / 2
        return np.arange(bents[0] + step / 2, bents[-1], step)


def add_pier(site: Site, pier: Pier, ground: HeightField, rng: np.random.Generator) -> int:
    """Build the pier; returns how many piles it stands on."""
    under = pier.deck - 1.4
    piles = 0
    for k, x in enumerate(pier.bents):
        for y in pier.rows:
            foot = np.array([x, y, float(ground.height(x, y)) - _EMBED])
            steel = pile(np.array([x, y, under + 0.2]), foot, pier.radius, 0.05, rng)
            site.add(steel, "rusted_steel", label="piling", name="steel pile", crease_deg=50)
            piles += 1
        if k % 3 == 1:
            piles += _batter_pair(site, pier, ground, x, under, rng)
        _bent_braces(site, pier, x, under, braced=k % 2 == 0)
    for x in pier.fender_x:
        y = pier.fender_y
        foot = np.array([x, y, float(ground.height(x, y)) - _EMBED])
        lean = np.array([x, y + 0.15, pier.deck + 0.35])
        wood = pile(lean, foot, pier.fender_radius * rng.uniform(0.9, 1.1), 0.035, rng)
        site.add(wood, "wood", label="piling", name="fender pile", crease_deg=50)
        piles += 1
    _deck(site, pier, under)
    return piles


def _batter_pair(site: Site, pier: Pier, ground: HeightField, x: float, under: float, rng: np.random.Generator) -> int:
    """Two raking piles, one in five, to either side along x, that carry horizontal loads."""
    y = (pier.rows[0] + pier.rows[1]) / 2
    for side in (-1.0, 1.0):
        drop = under - float(ground.height(x, y)) + _EMBED
        foot = np.array([x + side * drop / 5, y, under - drop])
        steel = pile(np.array([x + side * 0.3, y, under + 0.2]), foot, pier.radius * 0.8, 0.05, rng)
        site.add(steel, "rusted_steel", label="piling", name="batter pile", crease_deg=50)
    return 2


def _bent_braces(site: Site, pier: Pier, x: float, under: float, *, braced: bool) -> None:
    """The concrete cap beam of a bent, and under every other one a steel cross between the rows."""
    width = pier.rows[-1] - pier.rows[0] + 2.6
    middle = (pier.rows[-1] + pier.rows[0]) / 2
    cap = shapes.box((1.0, width, 0.9)).moved((x, middle, under + 0.45))
    site.add(cap, "concrete", label="pier", name="cap beam")
    if not braced:
        return
    bars = []
    for a, b in zip(pier.rows[:-1], pier.rows[1:], strict=True):
        bars.append(shapes.beam((x + 0.12, a, under - 0.4), (x + 0.12, b, under - 4.6), 0.09))
        bars.append(shapes.beam((x - 0.12, b, under - 0.4), (x - 0.12, a, under - 4.6), 0.09))
        bars.append(shapes.beam((x, a, under - 4.7), (x, b, under - 4.7), 0.09))
    site.add(join(bars), "rusted_steel", label="pier", name="cross brace", crease_deg=50)


def _deck(site: Site, pier: Pier, under: float) -> None:
    length = pier.x[1] - pier.x[0] + 3.0
    front, back = pier.rows[0] - 1.5, pier.rows[-1] + 1.5
    x, y = (pier.x[0] + pier.x[1]) / 2, (front + back) / 2
    slab = shapes.box((length, back - front, 0.5)).moved((x, y, pier.deck - 0.25))
    stringers = [
        shapes.box((length, 0.4, 0.6)).moved((x, row, under + 0.75)) for row in np.linspace(front + 0.6, back - 0.6, 5)
    ]
    rail = shapes.box((length, 0.3, 0.3)).moved((x, front + 0.2, pier.deck + 0.15))
    instance = site.add(slab, "concrete", label="pier", name="pier deck")
    site.add(join(stringers), "concrete", label="pier", name="pier deck", instance=instance)
    site.add(rail, "wood", label="pier", name="pier deck", instance=instance)
    for at in np.arange(pier.x[0] + 5, pier.x[1], 15.0):
        site.add(bollard().moved((at, front + 1.0, pier.deck)), "steel", label="pier", name="bollard", crease_deg=40)


def bollard() -> Mesh:
    """A mooring bollard, 0.6 m high, standing at the origin."""
    profile = [
        (0, -0.05),
        (0.30, -0.05),
        (0.30, 0.06),
        (0.17, 0.10),
        (0.15, 0.35),
        (0.26, 0.45),
        (0.26, 0.55),
        (0.15, 0.6),
        (0, 0.6),
    ]
    return shapes.revolve(profile, sides=20)


def add_quay(
    site: Site,
    *,
    x: tuple[float, float],
    face_y: float,
    back_y: float,
    top: float,
    base: float,
    exposed: list[tuple[float, float]],
) -> None:
    """A concrete quay wall along x that looks towards -y.

    Args:
        site: the world under construction.
        x: ends [m].
        face_y, back_y: front face and landward end [m].
        top, base: heights of the cope and of the foot [m].
        exposed: stretches of x [m] that ships can lie at: these get fenders, ladders and hanging tyres.
    """
    joints = np.arange(x[0] + 20, x[1] - 1, 20.0)  # open joints between the caissons
    front = [(x[0], face_y)]
    for j in joints:
        front += [(j - 0.06, face_y), (j - 0.06, face_y + 0.18), (j + 0.06, face_y + 0.18), (j + 0.06, face_y)]
    front += [(x[1], face_y), (x[1], back_y), (x[0], back_y)]
    wall = shapes.extrude(front, top - 0.5 - base).moved((0, 0, base))
    cope = shapes.box((x[1] - x[0], back_y - face_y + 0.25, 0.5)).moved(
        ((x[0] + x[1]) / 2, (face_y - 0.25 + back_y) / 2, top - 0.25)
    )
    instance = site.add(wall, "concrete", label="wall", name="quay wall")
    site.add(cope, "concrete", label="wall", name="quay wall", instance=instance)
    for first, last in exposed:
        for k, at in enumerate(np.arange(first + 2.5, last - 1.0, 5.0)):
            fender = shapes.box((0.45, 0.4, 4.6)).moved((at, face_y - 0.2, top - 2.8))
            site.add(fender, "rubber", label="fender", name="fender")
            if k % 3 == 1:
                site.add(
                    ladder(top + 0.9, -6.0).moved((at + 2.3, face_y, 0)),
                    "steel",
                    label="ladder",
                    name="ladder",
                    crease_deg=50,
                )
            else:
                tyre_ = tyre().turned(roll=np.pi / 2).moved((at + 2.5, face_y - 0.22, 0.4))
                site.add(tyre_, "rubber", label="tyre", name="hanging tyre", crease_deg=50)
        for at in np.arange(first + 5, last, 10.0):
            site.add(bollard().moved((at, face_y + 0.6, top)), "steel", label="pier", name="bollard", crease_deg=40)


def ladder(top: float, bottom: float) -> Mesh:
    """A steel ladder against a wall in the plane y = 0 that looks towards -y, from height `bottom` to `top` [m]."""
    rails = [shapes.beam((x, -0.25, bottom), (x, -0.25, top), 0.035, sides=8) for x in (-0.25, 0.25)]
    rungs = [
        shapes.beam((-0.25, -0.25, z), (0.25, -0.25, z), 0.018, sides=8) for z in np.arange(bottom + 0.15, top, 0.3)
    ]
    stays = [
        shapes.beam((x, -0.25, z), (x, 0.05, z), 0.025, sides=8)
        for x in (-0.25, 0.25)
        for z in np.arange(bottom + 0.4, top - 1.2, 2.0)
    ]
    return join(rails + rungs + stays)


def tyre() -> Mesh:
    """A lorry tyre lying on its side about the origin: 1.0 m across, 0.28 m thick."""
    outline = [
        (0.29, -0.11),
        (0.40, -0.14),
        (0.48, -0.12),
        (0.50, 0.0),
        (0.48, 0.12),
        (0.40, 0.14),
        (0.29, 0.11),
        (0.34, 0.0),
    ]
    section = np.array(outline[::-1])
    ring = shapes.torus(1.0, 0.1, sides=24, tube_sides=len(outline))
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    vertices = np.stack(
        [
            np.cos(turn)[:, None] * section[:, 0],
            np.sin(turn)[:, None] * section[:, 0],
            np.broadcast_to(section[:, 1], (24, len(outline))),
        ],
        axis=-1,
    )
    return Mesh(vertices.reshape(-1, 3), ring.faces)
