"""Torpedo-shaped hulls."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np

from pelagos.vehicles.part import NonNegative, Number, PartConfig, Positive
from pelagos.vehicles.shape.mesh import Mesh, Points, revolved, slab


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

    @property
    def outward(self) -> Points:
        """Unit vector from the axis to the tip `(3,)`, FLU; angles are meant in FRD."""
        angle = math.radians(self.angle_deg)
        return np.array([0.0, -math.cos(angle), -math.sin(angle)])


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
    fin_material: str | None = None
    """What fins and propeller are made of; the vehicle's first material where not given."""

    def meshes(self) -> list[Mesh]:
        """The parts."""
        nose_x = self.tip
        a, c, length = self.nose_m, self.tail_m, self.length_m
        bow = a * (1 - np.cos(np.linspace(0, math.pi / 2, 13)))
        stern = length - c + c * np.sin(np.linspace(0, math.pi / 2, 13))
        from_nose = np.unique(np.concatenate([bow, stern]))
        parts = [revolved(nose_x - from_nose, myring_radius(self, from_nose))]
        trim = [_fin(fin) for fin in self.fins]
        if self.propeller_m > 0:
            trim += _propeller(nose_x - length, self.propeller_m)
        return parts + [replace(mesh, material=self.fin_material) for mesh in trim]

    def probes(self) -> tuple[Points, Points]:
        """Contact probes: starts `(p, 3)` on the spine and vectors `(p, 3)` from there to the hull, FLU [m]."""
        radius = self.diameter_m / 2
        front, back = self.tip - radius, self.tip - self.length_m + radius
        starts: list[Points] = []
        vectors: list[Points] = []

        def probe(x: float, vector: Points) -> None:
            starts.append(np.array([x, 0.0, 0.0]))
            vectors.append(vector)

        for x in np.linspace(front, back, max(3, round((front - back) / self.diameter_m) + 1)):
            reach = max(float(myring_radius(self, np.array([self.tip - x]))[0]), 0.25 * radius)
            for angle in 2 * math.pi * (np.arange(6) + 0.5) / 6:
                probe(x, reach * np.array([0.0, math.cos(angle), math.sin(angle)]))
        for x, sign in ((front, 1.0), (back, -1.0)):
            probe(x, np.array([sign * radius, 0.0, 0.0]))
            for angle in 2 * math.pi * np.arange(6) / 6:
                probe(x, 0.7 * radius * np.array([sign, math.cos(angle), math.sin(angle)]))
        for fin in self.fins:
            probe(fin.x_m, fin.span_m * fin.outward)
        return np.array(starts), np.array(vectors)

    @property
    def tip(self) -> float:
        """x of the nose [m]."""
        return self.length_m / 2 if self.nose_x_m is None else self.nose_x_m


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


def _fin(fin: FinShape) -> Mesh:
    out = fin.outward
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
