"""Stones, plants and animals of the seabed."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.world import shapes
from pelagos.world.generate import debris
from pelagos.world.generate.thing import Kind, Part, Thing
from pelagos.world.mesh import Mesh, join


def boulder(size: float, rng: np.random.Generator) -> Thing:
    """A rounded stone, up to half buried."""
    stone = debris.boulder(size, rng)
    return Thing("boulder", "rock", (Part(stone, "rock", 60.0),), sink=-size * rng.uniform(-0.1, 0.12), follow=0.0)


def outcrop(size: float, rng: np.random.Generator) -> Thing:
    """Rock that breaks through the bed: several slabs that dip the same way."""
    dip, strike = rng.uniform(0.25, 0.6), rng.uniform(0, 2 * np.pi)
    beds = []
    for k in range(int(rng.integers(4, 7))):  # one bed on the other, each set back from the one below
        turn = (np.arange(14) + rng.uniform(-0.35, 0.35, 14)) * 2 * np.pi / 14
        edge = size * rng.uniform(0.20, 0.36, 14) * rng.uniform(0.85, 1.1)
        outline = np.stack([edge * np.cos(turn), 1.2 * edge * np.sin(turn)], axis=1)
        slab = shapes.extrude(outline, size * rng.uniform(0.07, 0.11))
        shift = size * np.array([(k - 2) * 0.13 + 0.04 * rng.normal(), 0.05 * rng.normal(), (k - 2) * 0.075])
        beds.append(slab.turned(yaw=rng.normal() * 0.12).moved(shift))
    slabs = [join(beds).turned(pitch=dip).turned(yaw=strike).moved((0, 0, 0.06 * size))]
    return Thing("rock outcrop", "rock", (Part(join(slabs), "rock", 50.0),), follow=0.0)


def kelp(size: float, rng: np.random.Generator) -> Thing:
    """A giant kelp: a few stipes that sway one way, with blades on either side and a holdfast."""
    sway = rng.uniform(0, 2 * np.pi)
    stipes, blades = [], []
    for _ in range(int(rng.integers(4, 8))):
        s = np.linspace(0, 1, 9)
        lean = 0.25 * size * s**2 * rng.uniform(0.5, 1.2)
        turn = sway + rng.normal() * 0.3
        path = np.stack([np.cos(turn) * lean, np.sin(turn) * lean, size * s * (1 - 0.08 * s)], axis=1)
        path[:, :2] += np.outer(np.minimum(4 * s, 1.0), rng.normal(size=2) * 0.05 * size)
        stipes.append(shapes.tube(path, 0.022, sides=5))
        for k, along in enumerate(np.arange(0.12, 1.0, 0.16 / max(size, 1.0) + 0.03)):
            foot = np.array([np.interp(along, s, path[:, i]) for i in range(3)])
            side = turn + (1.3 if k % 2 else -1.3) + rng.normal() * 0.5
            blades.append(_blade(foot, side, rng.uniform(0.5, 0.9) * min(1.0, size / 4 + 0.3), rng))
    holdfast = shapes.sphere(0.16, sides=10, rings=6).scaled((1, 1, 0.6))
    return Thing("kelp", "seaweed", (Part(join([*stipes, holdfast, *blades]), "kelp", 60.0),), follow=0.0)


def _blade(foot: NDArray[np.float64], turn: float, length: float, rng: np.random.Generator) -> Mesh:
    """A thin closed leaf from `foot` outwards."""
    s = np.linspace(0, 1, 4)
    width = 0.16 * length * np.sin(np.pi * np.clip(s * 0.85 + 0.1, 0, 1))
    out = np.array([np.cos(turn), np.sin(turn), 0.35])
    side = np.array([-np.sin(turn), np.cos(turn), rng.normal() * 0.3])
    middle = foot + np.outer(s * length, out) - np.outer(0.55 * length * s**2, [0, 0, 1])
    thin = np.array([0, 0, 0.004])
    rings = np.stack(
        [middle + np.outer(width, side), middle + thin, middle - np.outer(width, side), middle - thin], axis=1
    )
    return shapes.loft(rings)


def seagrass(size: float, rng: np.random.Generator) -> Thing:
    """A tuft of seagrass, `size` high: thirty leaves."""
    leaves = []
    for _ in range(30):
        turn, lean = rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 0.5)
        at = rng.normal(size=2) * 0.25 * size
        s = np.linspace(0, 1, 4)
        height = size * rng.uniform(0.6, 1.0)
        middle = np.stack(
            [at[0] + np.cos(turn) * lean * height * s**2, at[1] + np.sin(turn) * lean * height * s**2, height * s], 1
        )
        half = 0.012 * np.array([1.0, 1.0, 0.8, 0.2])
        side = np.array([-np.sin(turn), np.cos(turn), 0])
        thin = np.array([np.cos(turn), np.sin(turn), 0]) * 0.003
        rings = np.stack(
            [middle + np.outer(half, side), middle + thin, middle - np.outer(half, side), middle - thin], axis=1
        )
        leaves.append(shapes.loft(rings))
    return Thing("seagrass", "seaweed", (Part(join(leaves), "grass", None),), follow=0.0)


def coral(size: float, rng: np.random.Generator) -> Thing:
    """A branching coral: limbs that fork three times from one foot."""
    limbs: list[Mesh] = [shapes.sphere(0.16 * size, sides=12, rings=6).scaled((1, 1, 0.5))]

    def grow(foot: NDArray[np.float64], direction: NDArray[np.float64], length: float, order: int) -> None:
        tip = foot + direction * length
        limbs.append(
            shapes.tube(
                np.stack([foot, (foot + tip) / 2 + rng.normal(size=3) * 0.04 * length, tip]),
                np.array([1.0, 0.85, 0.65]) * 0.15 * length,
                sides=7,
            )
        )
        if order == 0:
            return
        for _ in range(2):
            new = direction + rng.normal(size=3) * 0.55
            new[2] = abs(new[2]) + 0.25
            grow(foot + direction * length * rng.uniform(0.7, 1.0), new / np.linalg.norm(new), length * 0.68, order - 1)

    for _ in range(3):
        first = np.array([*(rng.normal(size=2) * 0.45), 1.0])
        grow(np.zeros(3), first / np.linalg.norm(first), 0.36 * size, 3)
    color = ("coral", "red_coral", "ochre_coral", "purple_coral")[int(rng.integers(4))]
    return Thing("coral", "coral", (Part(join(limbs), color, 60.0),), sink=0.03 * size, follow=0.3)


def brain_coral(size: float, rng: np.random.Generator) -> Thing:
    """A massive coral: a furrowed dome."""
    dome = shapes.noisy(shapes.sphere(0.5, sides=36, rings=18), 0.12, rng, waves=10, scale=6.0).scaled(
        (size, size, 0.75 * size)
    )
    color = ("coral", "green_coral", "ochre_coral")[int(rng.integers(3))]
    return Thing("brain coral", "coral", (Part(dome, color, 80.0),), sink=-0.1 * size, follow=0.3)


def sponge(size: float, rng: np.random.Generator) -> Thing:
    """A cluster of barrel sponges, hollow at the top."""
    barrels = []
    for k in range(int(rng.integers(1, 4))):
        h = size * (1.0 if k == 0 else rng.uniform(0.4, 0.8))
        profile = [
            (0, -0.05 * h),
            (0.16 * h, -0.05 * h),
            (0.26 * h, 0.35 * h),
            (0.28 * h, 0.75 * h),
            (0.22 * h, h),
            (0.15 * h, 0.97 * h),
            (0.14 * h, 0.5 * h),
            (0, 0.45 * h),
        ]
        at = rng.normal(size=2) * 0.35 * size * (k > 0)
        barrels.append(
            shapes.revolve(profile, sides=18)
            .turned(roll=rng.normal() * 0.12, pitch=rng.normal() * 0.12)
            .moved((at[0], at[1], 0))
        )
    color = ("sponge", "red_sponge")[int(rng.integers(2))]
    return Thing("sponge", "sponge", (Part(join(barrels), color, 50.0),), follow=0.3)


def fish(length: float = 0.35) -> Mesh:
    """One fish about the origin, swimming along +x."""
    s = np.linspace(0, 1, 9)
    half = np.array([0.004, 0.06, 0.1, 0.115, 0.105, 0.08, 0.05, 0.03, 0.012]) * length
    turn = np.linspace(0, 2 * np.pi, 10, endpoint=False)
    x = (0.5 - s) * length
    rings = np.stack(
        [np.broadcast_to(x[:, None], (9, 10)), 0.5 * half[:, None] * np.cos(turn), half[:, None] * np.sin(turn)],
        axis=-1,
    )
    fins = [  # tail, two lobes; back fin; anal fin: each a thin leaf from its root to its tip
        ((-0.42, 0.022), (-0.42, -0.022), (-0.60, 0.005), (-0.60, 0.13)),
        ((-0.42, 0.022), (-0.42, -0.022), (-0.60, -0.13), (-0.60, -0.005)),
        ((0.12, 0.095), (-0.20, 0.055), (-0.22, 0.085), (0.02, 0.175)),
        ((-0.10, -0.085), (-0.26, -0.045), (-0.27, -0.07), (-0.17, -0.13)),
    ]
    made = [shapes.loft(rings)]
    for corners in fins:
        flat = np.array(corners) * length
        sheet = np.stack([np.insert(flat, 1, side * 0.006 * length, axis=1) for side in (1.0, -1.0)])
        fin = shapes.loft(sheet)
        made.append(fin if fin.volume > 0 else shapes.loft(sheet[::-1]))
    return join(made)


def school(size: float, rng: np.random.Generator) -> Thing:
    """A school of fish above the bed, all swimming one way; `size` across."""
    count = int(np.clip(6 * size**2, 12, 150))
    one = fish(0.3)
    made = []
    for _ in range(count):
        at = rng.normal(size=3) * size / 4.5 * np.array([1, 1, 0.5])
        at[2] = abs(at[2]) + 0.9 * size
        made.append(
            one.turned(yaw=rng.normal() * 0.25, pitch=rng.normal() * 0.1).scaled(rng.uniform(0.7, 1.2)).moved(at)
        )
    return Thing("school of fish", "fish", (Part(join(made), "fish", 60.0),), follow=0.0)


NATURAL: Final = {
    "boulder": Kind("Rounded stones, partly buried", "greatest diameter", (0.4, 2.0), boulder, 24, 40.0, 0.0),
    "outcrop": Kind("Dipping slabs of rock that break through the bed", "extent", (3.0, 12.0), outcrop, 0, 45.0, 0.0),
    "kelp": Kind("Giant kelp with stipes, blades and holdfast", "height", (3.0, 8.0), kelp, 12, 35.0, 1.0),
    "seagrass": Kind("Tufts of seagrass", "height", (0.3, 0.8), seagrass, 12, 20.0, 1.0),
    "coral": Kind("Branching corals", "height", (0.3, 1.2), coral, 12, 50.0, 1.0),
    "brain_coral": Kind("Massive, furrowed corals", "diameter", (0.3, 1.5), brain_coral, 8, 50.0, 1.0),
    "sponge": Kind("Barrel sponges", "height", (0.2, 0.9), sponge, 8, 50.0, 1.0),
    "fish_school": Kind("Schools of fish above the bed", "diameter", (1.5, 4.0), school, 0, 60.0, 2.5),
}
"""The kinds of this module by name."""
