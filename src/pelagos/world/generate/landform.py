"""Shapes of generated ground: each a function from node coordinates to heights relative to the mean bed [m]."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.world.generate.relief import fractal, ripples, smoothstep

Field = NDArray[np.float64]


@dataclass(frozen=True)
class Ground:
    """Ground that a landform is made for.

    Attributes:
        x, y: node coordinates `(nx,)`, `(ny,)` [m].
        spacing: of the nodes [m].
        relief: height of the form, crest to trough or foot to top [m].
        wavelength: its horizontal scale [m].
        heading: its direction, from x towards y [rad].
        slope: slope of the two-dimensional power spectrum of its roughness.
        rng: random numbers.
    """

    x: Field
    y: Field
    spacing: float
    relief: float
    wavelength: float
    heading: float
    slope: float
    rng: np.random.Generator

    @property
    def shape(self) -> tuple[int, int]:
        """Nodes."""
        return len(self.x), len(self.y)

    def rough(self, longest: float, *, slope: float | None = None) -> Field:
        """Random relief of unit root mean square with wavelengths from two cells to `longest` [m]."""
        return fractal(
            self.shape, self.spacing, self.rng, slope=slope or self.slope, longest=longest, shortest=2 * self.spacing
        )

    def along(self) -> tuple[Field, Field]:
        """Coordinates along and across the heading [m]."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        x, y = self.x[:, None], self.y[None, :]
        return c * x + s * y, -s * x + c * y


def flat(g: Ground) -> Field:
    """Level ground whose relief is random with the spectrum asked for; `relief` is four standard deviations."""
    return g.rough(g.wavelength) * g.relief / 4


def slope(g: Ground) -> Field:
    """A plane that rises by `relief` over one wavelength along the heading, with a little roughness."""
    along, _ = g.along()
    return along / g.wavelength * g.relief + g.rough(g.wavelength / 2) * 0.02 * g.relief


def ridges(g: Ground) -> Field:
    """Sharp, branching crests across the heading: folded noise."""
    along, _ = g.along()
    bend = 0.35 * g.wavelength * g.rough(3 * g.wavelength, slope=5.0)
    wave = 1 - np.abs(np.sin(np.pi * (along + bend) / g.wavelength))
    height = 0.55 + 0.45 * np.tanh(g.rough(4 * g.wavelength, slope=3.5))
    return g.relief * (wave**1.5 * height - 0.3) + g.rough(g.wavelength) * 0.06 * g.relief


def canyon(g: Ground) -> Field:
    """A winding canyon along the heading with a flat floor, terraces and side gullies."""
    along, across = g.along()
    phase = g.rng.uniform(0, 2 * np.pi)
    winding = 0.35 * g.wavelength * np.sin(2 * np.pi * along / (1.9 * g.wavelength) + phase)
    winding += 0.15 * g.wavelength * g.rough(3 * g.wavelength, slope=4.5)
    away = np.abs(across - winding) / (0.5 * g.wavelength)
    gullies = 0.22 * (1 - np.abs(g.rough(0.8 * g.wavelength, slope=4.2)))
    wall = smoothstep(away + gullies * smoothstep(away, 0.2, 0.6), 0.22, 1.0)
    terraced = 0.85 * wall + 0.15 * np.round(wall * 5) / 5
    return g.relief * (terraced - 0.75) + g.rough(g.wavelength / 2) * 0.02 * g.relief


def dunes(g: Ground) -> Field:
    """Sand waves with steep lee sides, and smaller ripples on their backs."""
    along, _ = g.along()
    bend = 0.3 * g.wavelength * g.rough(6 * g.wavelength, slope=5.5)
    turn = (along + bend) / g.wavelength % 1.0
    lee = 0.28  # share of the wavelength that the steep side takes
    saw = np.where(turn < 1 - lee, turn / (1 - lee), (1 - turn) / lee)
    strength = 0.75 + 0.25 * np.tanh(g.rough(5 * g.wavelength, slope=3.5))
    wave = smoothstep(saw, -0.15, 1.1) * strength
    length = max(g.wavelength / 9, 4 * g.spacing)
    small = ripples(g.x, g.y, wavelength=length, heading=g.heading, wander=2 * np.pi * bend / length)
    return g.relief * (wave - 0.45) + 0.04 * g.relief * small + g.rough(g.wavelength) * 0.015 * g.relief


def seamount(g: Ground) -> Field:
    """A cone with a rounded summit, flanks of rock ribs and a smaller cone on one side."""
    x, y = g.x[:, None] - g.x.mean(), g.y[None, :] - g.y.mean()
    radius = g.wavelength
    turn = np.arctan2(y, x)
    ribs = 0.08 * np.sin(7 * turn + g.rng.uniform(0, 6)) + 0.05 * np.sin(13 * turn + g.rng.uniform(0, 6))
    r = np.hypot(x, y) / radius * (1 + ribs)
    cone = 1 / (1 + (1.6 * r) ** 2.4)
    sx, sy = 0.55 * radius * np.cos(g.heading), 0.55 * radius * np.sin(g.heading)
    side = 0.35 * np.exp(-(((x - sx) ** 2 + (y - sy) ** 2) / (0.25 * radius) ** 2))
    rough = g.rough(radius / 2, slope=3.4) * 0.035 * (0.25 + cone)
    height: Field = g.relief * (np.maximum(cone, 0.8 * cone + side) + rough)
    return height


def reef(g: Ground) -> Field:
    """Flat-topped patch reefs with steep, rough edges on sand."""
    patches = g.rough(2 * g.wavelength, slope=4.0)
    raised = smoothstep(patches, 0.35, 0.75)
    heads = np.clip(g.rough(6 * max(g.spacing, 1.0), slope=3.0), 0, None)  # of coral: as high as they grow
    top = 0.9 * g.relief + min(0.1 * g.relief, 0.5) * heads
    return raised * top + (1 - raised) * g.rough(g.wavelength) * 0.03 * g.relief


def trench(g: Ground) -> Field:
    """A straight deep with V-shaped walls and slumps, across the heading."""
    along, _ = g.along()
    bend = 0.15 * g.wavelength * g.rough(4 * g.wavelength, slope=3.5)
    away = np.abs(along + bend) / g.wavelength
    wall = 1 - np.exp(-((away / 0.55) ** 1.4))
    return g.relief * (wall - 1) + g.rough(g.wavelength / 2, slope=3.4) * 0.03 * g.relief


def mixed(g: Ground) -> Field:
    """Ridges, dunes, reef and plain ground, one fading into the next."""
    forms = [ridges(g), dunes(_smaller(g)), reef(_smaller(g)), flat(g)]
    weights = np.stack([np.exp(1.8 * g.rough(5 * g.wavelength, slope=3.5)) for _ in forms])
    weights /= weights.sum(axis=0)
    return np.asarray(sum(w * f for w, f in zip(weights, forms, strict=True)), dtype=np.float64)


def _smaller(g: Ground) -> Ground:
    return Ground(g.x, g.y, g.spacing, 0.4 * g.relief, 0.5 * g.wavelength, g.heading, g.slope, g.rng)


LANDFORMS: Final[dict[str, Callable[[Ground], Field]]] = {
    form.__name__: form for form in (flat, slope, ridges, canyon, dunes, seamount, reef, trench, mixed)
}
"""Landforms by name."""
