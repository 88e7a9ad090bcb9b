"""Hulls as meshes in the body frame FLU, generated from a few dimensions, and the probes that feel contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.raycast.geometry import Geometry
from pelagos.vehicles.part import NonNegative, Number, PartConfig, Positive

VEHICLE_LABEL: Final = 64
_AROUND: Final = 32  # vertices around a hull

Points = NDArray[np.float64]


class FinShape(PartConfig):
    """A fin as it looks (what it does is an actuator)."""

    angle_deg: Number
    """About x: 0 starboard, 90 down, 180 port, 270 up [deg]."""
    x_m: Number
    """Middle of its root [m]."""
    span_m: Positive
    """Tip from the hull's axis [m]."""
    chord_m: Positive
    """At the root [m]."""


class TorpedoHull(PartConfig):
    """A revolved Myring profile with fins and a propeller.

    Source: D. F. Myring, "A theoretical study of body drag in subcritical axisymmetric flow", Aeronautical
    Quarterly 27, 1976, doi 10.1017/S000192590000768X.
    """

    type: Literal["torpedo"]
    length_m: Positive
    """Nose to tail [m]."""
    diameter_m: Positive
    """[m]"""
    nose_m: Positive
    """Length of the nose [m]."""
    tail_m: Positive
    """Length of the tail cone [m]."""
    nose_exponent: Positive = 2.0
    """Fullness of the nose [-]."""
    tail_angle_deg: Positive = 25.0
    """Half angle at the tail's tip [deg]."""
    nose_x_m: Number | None = None
    """Tip of the nose forward of the origin [m]; left out: half the length."""
    fins: tuple[FinShape, ...] = ()
    """What stands out of the hull."""
    propeller_m: NonNegative = 0.0
    """Diameter of the propeller at the tail [m]; 0: none."""


HullConfig: TypeAlias = TorpedoHull


@dataclass
class Mesh:
    """Triangles with a normal a vertex: vertices `(v, 3)`, faces `(f, 3)`, normals `(v, 3)`."""

    vertices: Points
    faces: NDArray[np.uint32]
    normals: Points


def build_hull(config: TorpedoHull, name: str) -> Geometry:
    """The hull `(v, 3)` FLU [m] with smooth normals."""
    mesh = joined(_torpedo(config))
    return Geometry(
        vertices=mesh.vertices,
        faces=mesh.faces,
        material=0,
        label=VEHICLE_LABEL,
        instance=1,
        vertex_normals=mesh.normals.astype(np.float32),
        name=name,
    )


def myring_radius(config: TorpedoHull, from_nose: Points) -> Points:
    """Radius [m] at distances from the nose [m]: Myring 1976, as in T. Prestero, MSc thesis, MIT/WHOI 2001."""
    a, c, d = config.nose_m, config.tail_m, config.diameter_m
    tail = config.length_m - c
    theta = math.radians(config.tail_angle_deg)
    nose = 0.5 * d * np.maximum(1 - ((from_nose - a) / a) ** 2, 0.0) ** (1 / config.nose_exponent)
    s = from_nose - tail
    aft = 0.5 * d - (1.5 * d / c**2 - math.tan(theta) / c) * s**2 + (d / c**3 - math.tan(theta) / c**2) * s**3
    middle = np.full_like(from_nose, 0.5 * d)
    return np.where(from_nose < a, nose, np.where(s > 0, np.maximum(aft, 0.0), middle))


def _torpedo(config: TorpedoHull) -> list[Mesh]:
    nose_x = config.length_m / 2 if config.nose_x_m is None else config.nose_x_m
    a, c, length = config.nose_m, config.tail_m, config.length_m
    bow = a * (1 - np.cos(np.linspace(0, math.pi / 2, 13)))
    stern = length - c + c * np.sin(np.linspace(0, math.pi / 2, 13))
    from_nose = np.unique(np.concatenate([bow, stern]))
    parts = [revolved(nose_x - from_nose, myring_radius(config, from_nose))]
    for fin in config.fins:
        parts.append(_fin(fin))
    if config.propeller_m > 0:
        parts += _propeller(nose_x - length, config.propeller_m)
    return parts


def revolved(x: Points, radius: Points) -> Mesh:
    """The surface of a profile `(p,)`, x falling, revolved about x; ends with radius 0 close it."""
    angle = np.linspace(0, 2 * math.pi, _AROUND, endpoint=False)
    ring = np.stack([np.zeros(_AROUND), np.cos(angle), np.sin(angle)], axis=-1)
    vertices = x[:, None, None] * np.array([1.0, 0, 0]) + radius[:, None, None] * ring
    slope = np.gradient(radius, x)
    tip = radius < 1e-9
    normals = np.where(tip[:, None, None], 0.0, ring) - slope[:, None, None] * np.array([1.0, 0, 0])
    normals[tip] = np.array([1.0, 0, 0]) * np.sign(x[tip] - x.mean())[:, None, None]
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    i = np.arange(len(x) - 1)[:, None] * _AROUND
    j, k = np.arange(_AROUND)[None, :], np.roll(np.arange(_AROUND), -1)[None, :]
    a, b, c, d = i + j, i + k, i + _AROUND + j, i + _AROUND + k
    faces = np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    flat = vertices.reshape(-1, 3)
    p, q, r = (flat[faces[:, n]] for n in range(3))
    faces = faces[np.linalg.norm(np.cross(q - p, r - p), axis=-1) > 1e-14]
    return Mesh(flat, outward(flat, faces.astype(np.uint32), normals.reshape(-1, 3)), normals.reshape(-1, 3))


def outward(vertices: Points, faces: NDArray[np.uint32], normals: Points) -> NDArray[np.uint32]:
    """Faces turned so that they are counter-clockwise seen from the side of their vertices' normals."""
    p, q, r = (vertices[faces[:, n]] for n in range(3))
    wrong = np.einsum("fi,fi->f", np.cross(q - p, r - p), normals[faces].sum(axis=1)) < 0
    faces = faces.copy()
    faces[wrong] = faces[wrong][:, ::-1]
    return faces


def slab(outline: Points, thickness: float, normal: Points) -> Mesh:
    """A convex plate: `outline` `(p, 3)` moved by half the thickness to both sides along the unit `normal`."""
    half = 0.5 * thickness * normal
    top, bottom = outline + half, outline - half
    p = len(outline)
    fan = np.array([[0, i, i + 1] for i in range(1, p - 1)])
    sides = np.array(
        [[i, (i + 1) % p, p + (i + 1) % p] for i in range(p)] + [[i, p + (i + 1) % p, p + i] for i in range(p)]
    )
    return flat_shaded(np.concatenate([top, bottom]), np.concatenate([fan, fan[:, ::-1] + p, sides]))


def flat_shaded(vertices: Points, faces: NDArray[np.int64]) -> Mesh:
    """Every face with vertices and a normal of its own; faces of a convex body are turned outwards."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    inward = np.einsum("fi,fi->f", normals, corners.mean(axis=1) - vertices.mean(axis=0)) < 0
    corners[inward] = corners[inward][:, ::-1]
    normals[inward] *= -1
    faces_out = np.arange(3 * len(faces), dtype=np.uint32).reshape(-1, 3)
    return Mesh(corners.reshape(-1, 3), faces_out, np.repeat(normals, 3, axis=0))


def joined(parts: list[Mesh]) -> Mesh:
    """One mesh of many."""
    starts = np.cumsum([0] + [len(p.vertices) for p in parts[:-1]])
    return Mesh(
        np.concatenate([p.vertices for p in parts]),
        np.concatenate([p.faces + np.uint32(s) for p, s in zip(parts, starts, strict=True)]).astype(np.uint32),
        np.concatenate([p.normals for p in parts]),
    )


def _fin(fin: FinShape) -> Mesh:
    angle = math.radians(fin.angle_deg)
    out = np.array([0.0, -math.cos(angle), -math.sin(angle)])  # angles are meant in FRD
    ahead = np.array([1.0, 0.0, 0.0])
    root, tip = 0.3 * fin.span_m, fin.span_m
    outline = np.array([
        (fin.x_m + fin.chord_m / 2) * ahead + root * out,
        (fin.x_m - fin.chord_m / 2) * ahead + root * out,
        (fin.x_m - fin.chord_m / 2) * ahead + tip * out,
        (fin.x_m + fin.chord_m * 0.1) * ahead + tip * out,
    ])  # fmt: skip
    return slab(outline, 0.1 * fin.chord_m, np.cross(ahead, out))


def _propeller(x: float, diameter: float) -> list[Mesh]:
    """Three twisted blades on the shaft."""
    blades = []
    for k in range(3):
        angle = 2 * math.pi * k / 3
        out = np.array([0.0, math.cos(angle), math.sin(angle)])
        side = np.cross([1.0, 0.0, 0.0], out)
        chord = 0.14 * diameter * (0.6 * side + 0.8 * np.array([1.0, 0.0, 0.0]))
        place = np.array([x - 0.02 * diameter, 0.0, 0.0])
        root, tip = place + 0.02 * diameter * out, place + 0.5 * diameter * out
        outline = np.array([root + chord / 2, root - chord / 2, tip - chord, tip + chord])
        normal = np.cross(chord, out)
        blades.append(slab(outline, 0.02 * diameter, normal / np.linalg.norm(normal)))
    return blades


def torpedo_probes(config: TorpedoHull) -> tuple[Points, Points]:
    """Contact probes: starts `(p, 3)` on the spine and vectors `(p, 3)` from there to the hull, FLU [m]."""
    nose_x = config.length_m / 2 if config.nose_x_m is None else config.nose_x_m
    radius = config.diameter_m / 2
    front, back = nose_x - radius, nose_x - config.length_m + radius
    starts: list[Points] = []
    vectors: list[Points] = []
    for x in np.linspace(front, back, max(3, round((front - back) / (2 * radius)) + 1)):
        for k in range(6):
            angle = 2 * math.pi * (k + 0.5) / 6
            reach = float(myring_radius(config, np.array([nose_x - x]))[0])
            starts.append(np.array([x, 0.0, 0.0]))
            vectors.append(max(reach, 0.25 * radius) * np.array([0.0, math.cos(angle), math.sin(angle)]))
    for x, sign in ((front, 1.0), (back, -1.0)):
        starts.append(np.array([x, 0.0, 0.0]))
        vectors.append(np.array([sign * radius, 0.0, 0.0]))
        for k in range(6):
            angle = 2 * math.pi * k / 6
            starts.append(np.array([x, 0.0, 0.0]))
            vectors.append(0.7 * radius * np.array([sign, math.cos(angle), math.sin(angle)]))
    for fin in config.fins:
        angle = math.radians(fin.angle_deg)
        starts.append(np.array([fin.x_m, 0.0, 0.0]))
        vectors.append(fin.span_m * np.array([0.0, -math.cos(angle), -math.sin(angle)]))
    return np.array(starts), np.array(vectors)
