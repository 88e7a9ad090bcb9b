"""A harbour basin: quay, pier on piles, sunken boat, pipeline, boulders, debris and moorings on a dredged bed.

The world is `length_m` along x and `width_m` along y, about the origin. The quay stands at the edge of greatest y and
looks towards -y; the pier stands before it. With the standard sizes, free water for surveys is x -90 .. 90, y -66 .. 44
from the surface down to 4.5 m above the bed: nothing in it rises more than 4 m, and the first piles stand at y = 56.
The boat lies at `boat_at_m`, the pipeline runs along x near y = -36, moorings with chains stand at x = -97 and x = 97.
"""

from __future__ import annotations

from functools import partial
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.math.geodesy import GeoOrigin
from pelagos.world import shapes
from pelagos.world.config import WorldConfig
from pelagos.world.generate import debris, waterfront, wreck
from pelagos.world.generate.pipeline import Pipeline, pipe_mesh, supports
from pelagos.world.generate.quayside import add_quayside
from pelagos.world.generate.relief import dent, fractal, ripples, smoothstep
from pelagos.world.generate.scatter import Places
from pelagos.world.mesh import Mesh, join, lean, rotation
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField
from pelagos.world.world import World

_QUAY = 14.0  # [m], depth of the quay from its face to the edge of the world
_APRON = 10.0  # [m], from the quay's face to the outer row of the pier's piles


class HarbourConfig(WorldConfig):
    """A dredged harbour basin with a quay wall, a pier on piles, a sunken boat, a pipeline and debris."""

    TITLE: ClassVar[str] = "A dredged basin with quay wall, pier on piles, sunken boat, pipeline and debris"

    type: Literal["harbour"] = "harbour"
    """The kind of world."""
    seed: int = Field(default=1, ge=0)
    """Seed of everything random in this world."""
    length_m: float = Field(default=220.0, ge=140, le=1000)
    """Extent along x, the quay's direction [m]."""
    width_m: float = Field(default=160.0, ge=120, le=1000)
    """Extent along y, quay included [m]."""
    depth_m: float = Field(default=15.0, ge=8, le=40)
    """Depth of the basin's bed below the mean sea surface [m]."""
    grid_m: float = Field(default=0.5, ge=0.1, le=4)
    """Spacing of the seabed's nodes [m]."""
    relief_m: float = Field(default=0.22, ge=0, le=2)
    """Root mean square of the bed's undulations [m]."""
    ripple_m: float = Field(default=0.05, ge=0, le=0.5)
    """Height of sand ripples, half of crest to trough [m]."""
    quay_height_m: float = Field(default=2.5, ge=0.5, le=10)
    """Height of the quay above the mean sea surface [m]."""
    pier_length_m: float = Field(default=140.0, ge=20, le=900)
    """Length of the pier along x [m]; at most `length_m` less 60 m."""
    pile_bay_m: float = Field(default=7.0, ge=3, le=15)
    """Distance between the pier's bents along x [m]; each bent stands on three steel piles."""
    pile_diameter_m: float = Field(default=0.55, ge=0.2, le=1.5)
    """Diameter of the steel piles [m]; the wooden fender piles have two thirds of it."""
    boat_at_m: tuple[float, float] = (22.0, -8.0)
    """Where the sunken boat lies, x and y of its middle [m]."""
    boat_heading_deg: float = 65.0
    """Direction of its bow, from x towards y [deg]."""
    boat_length_m: float = Field(default=13.5, ge=5, le=40)
    """Its length [m]."""
    pipe_diameter_m: float = Field(default=0.6, ge=0.1, le=2)
    """Outer diameter of the pipeline [m]."""
    boulders: int = Field(default=110, ge=0, le=5000)
    """How many boulders lie on the bed."""
    debris: int = Field(default=60, ge=0, le=2000)
    """How many tyres, drums, pallets, crates, girders and other lost things lie on the bed."""
    moorings: int = Field(default=4, ge=0, le=20)
    """How many buoys are moored at the basin's ends, each on a block and a chain."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.pier_length_m > self.length_m - 60:
            raise ValueError(f"pier_length_m must be at most length_m - 60 = {self.length_m - 60:g} m")
        return self

    def build(self) -> World:
        """Build it; the same configuration gives the same bytes."""
        return _Harbour(self).world()


class _Harbour:
    """One harbour under construction: first the ground takes all its dents, then things are set on it."""

    def __init__(self, config: HarbourConfig) -> None:
        self.c = config
        streams = np.random.SeedSequence(config.seed).spawn(9)
        self.rng = [np.random.Generator(np.random.PCG64(s)) for s in streams]
        self.site = Site(user_labels=config.labels)
        self.x = (-config.length_m / 2, config.length_m / 2)
        self.y = (-config.width_m / 2, config.width_m / 2)
        self.face = self.y[1] - _QUAY
        first = self.face - _APRON
        half = config.pier_length_m / 2
        self.pier = waterfront.Pier(
            x=(-half, half), rows=(first + 1.1, first + 4.7, first + 8.3), bay=config.pile_bay_m,
            deck=config.quay_height_m - 0.2, radius=config.pile_diameter_m / 2,
            fender_radius=config.pile_diameter_m / 3,
        )  # fmt: skip
        self.places = Places((self.x[0] + 4, self.x[1] - 4), (self.y[0] + 4, self.pier.fender_y - 1.5))

    def world(self) -> World:
        c = self.c
        ground = self._ground()
        pipe = self._pipeline(ground)
        pipe.scour(ground, depth=0.9)
        self._scour(ground)
        self.site.ground_patches(ground, ("silt", "sand", "mud", "gravel"), self._bed_materials(ground))
        radius = c.pipe_diameter_m / 2
        self.site.add(pipe_mesh(pipe, ground), "concrete", label="pipe", name="pipeline", crease_deg=40)
        self.site.add(supports(pipe, ground, 3), "concrete", label="concrete", name="pipe supports")
        for x, y in pipe.path[::2]:
            self.places.take(x, y, radius + 0.6)
        piles = self._waterfront(ground)
        size = f"{c.length_m:g} m x {c.width_m:g} m, {c.depth_m:g} m deep"
        self._boat(ground)
        self._boulders(ground)
        self._debris(ground)
        self._moorings(ground)
        return self.site.world(
            name="harbour",
            description=f"harbour basin {size}, {piles} piles, seed {c.seed}",
            origin=GeoOrigin(
                44.0970 if c.latitude_deg is None else c.latitude_deg,
                9.8350 if c.longitude_deg is None else c.longitude_deg,
            ),
        )

    def _ground(self) -> HeightField:
        """The bed before anything stands on it."""
        c, rng = self.c, self.rng[0]
        nx, ny = round(c.length_m / c.grid_m) + 1, round(c.width_m / c.grid_m) + 1
        field = HeightField(self.x[0], self.y[0], c.grid_m, np.zeros((nx, ny)))
        x, y = field.x[:, None], field.y[None, :]
        edge = np.minimum(np.minimum(x - self.x[0], self.x[1] - x), y - self.y[0] + 0 * x)
        wander = 3.0 * fractal((nx, ny), c.grid_m, rng, slope=3.0, longest=90, shortest=12)
        dredged = smoothstep(edge + wander, 3.0, 17.0)  # slopes of about one in four round the dredged part
        pocket = smoothstep(y + wander, self.pier.fender_y - 22, self.pier.fender_y - 12)
        z = -c.depth_m + 3.2 * (1 - dredged) - 1.2 * pocket + 0.8 * x / c.length_m
        toe = self.pier.fender_y + 1.5  # riprap rises under the pier towards the wall
        z = z + np.clip((y - toe) * 0.52, 0, None) + 0 * x
        z += c.relief_m * fractal((nx, ny), c.grid_m, rng, slope=3.2, longest=60, shortest=2 * c.grid_m)
        furrows = np.sin(2 * np.pi * (y + 1.5 * wander) / 17) ** 7  # left by the dredger's draghead
        z -= 0.24 * np.abs(furrows) * dredged * (1 - pocket)
        self.sandy = smoothstep(
            fractal((nx, ny), c.grid_m, rng, slope=3.0, longest=120, shortest=8) + 0.6 * (1 - dredged), 0.1, 0.5
        )
        z += (
            c.ripple_m
            * self.sandy
            * ripples(field.x, field.y, wavelength=max(1.8, 3.5 * c.grid_m), heading=0.35, wander=0.9 * wander)
        )
        stony = smoothstep(y + 0 * x, toe, toe + 1.5)
        z += stony * 0.12 * fractal((nx, ny), c.grid_m, rng, slope=1.5, longest=4, shortest=2 * c.grid_m)
        self._anchor_scars(field, z, rng)
        return HeightField(self.x[0], self.y[0], c.grid_m, z)

    def _anchor_scars(self, field: HeightField, z: NDArray[np.float64], rng: np.random.Generator) -> None:
        for _ in range(3):
            start = np.array([rng.uniform(*self.x) * 0.7, rng.uniform(self.y[0] * 0.7, self.pier.fender_y - 25)])
            turn = rng.uniform(0, 2 * np.pi)
            for _ in range(int(rng.uniform(25, 60))):
                turn += rng.normal() * 0.06
                start = start + 0.7 * np.array([np.cos(turn), np.sin(turn)])
                if abs(start[0]) < self.x[1] - 5 and self.y[0] + 5 < start[1] < self.pier.fender_y - 5:
                    dent(field.x, field.y, z, start, 0.55, 0.07)
                    side = 1.1 * np.array([-np.sin(turn), np.cos(turn)])
                    dent(field.x, field.y, z, start + side, 0.5, -0.025)
                    dent(field.x, field.y, z, start - side, 0.5, -0.025)

    def _pipeline(self, ground: HeightField) -> Pipeline:
        c, rng = self.c, self.rng[1]
        x = np.arange(self.x[0] + 0.5, self.x[1] - 0.25, 0.5)
        bend = 5.0 * np.sin(2 * np.pi * x / (0.8 * c.length_m) + rng.uniform(0, 2 * np.pi))
        y = self.y[0] * 0.45 + bend
        radius = c.pipe_diameter_m / 2
        span = (c.length_m * 0.60, c.length_m * 0.60 + 16.0)
        ends = smoothstep(np.abs(x), c.length_m / 2 - 22, c.length_m / 2 - 4)
        burial = radius * (0.55 + 0.45 * np.sin(2 * np.pi * x / 61 + 1.0) + 2.2 * ends)
        hang = (x - self.x[0] > span[0] - 4) & (x - self.x[0] < span[1] + 4)
        burial[hang] = 0.1 * radius
        return Pipeline(np.stack([x, y], axis=1), radius, burial, span)

    def _scour(self, ground: HeightField) -> None:
        """Hollows that currents dig round what stands on the bed, and the drift behind the boat."""
        rng = self.rng[2]
        for x, y in self.pier.feet():
            dent(ground.x, ground.y, ground.z, (x, y), rng.uniform(0.7, 1.1), rng.uniform(0.1, 0.35))
        along = np.array([np.cos(np.radians(self.c.boat_heading_deg)), np.sin(np.radians(self.c.boat_heading_deg))])
        across = np.array([-along[1], along[0]])
        middle, length = np.array(self.c.boat_at_m), self.c.boat_length_m
        for s in np.linspace(-0.55, 0.55, 9):
            dent(ground.x, ground.y, ground.z, middle + s * length * along - 0.2 * length * across, 1.3, 0.22)
            dent(ground.x, ground.y, ground.z, middle + s * length * along + 0.24 * length * across, 1.8, -0.20)

    def _bed_materials(self, ground: HeightField) -> NDArray[np.float32]:
        """Fields `(4, nx, ny)`: silt with patches of sand, mud in the berth pocket, gravel under the pier."""
        from scipy.ndimage import gaussian_filter  # a quarter of the time that all imports take

        sandy = self.sandy
        y = ground.y[None, :]
        ragged = gaussian_filter(self.rng[3].standard_normal(sandy.shape), 2.0) * 6
        wavy = gaussian_filter(self.rng[3].standard_normal(sandy.shape), 1.2)
        sand = sandy + 0.25 * wavy - 0.5
        bed = np.maximum(sand, 0)
        muddy = np.minimum((y + 4 * ragged + 4 * wavy - self.pier.fender_y + 14) / 5, 0.9 - sandy)
        mud = bed + muddy
        gravel = np.maximum(bed, mud) + (y + ragged - self.pier.fender_y - 1.5) / 5
        return np.stack([np.zeros_like(sand), sand, mud, gravel]).astype(np.float32)

    def _waterfront(self, ground: HeightField) -> int:
        c = self.c
        half = c.pier_length_m / 2 + 1.5
        waterfront.add_quay(
            self.site, x=self.x, face_y=self.face, back_y=self.y[1], top=c.quay_height_m,
            base=float(ground.z.min()) - 3, exposed=[(self.x[0], -half), (half, self.x[1])],
        )  # fmt: skip
        add_quayside(
            self.site, x=self.x, face_y=self.face, back_y=self.y[1], top=c.quay_height_m, rng=self.rng[8]
        )  # fmt: skip
        piles = waterfront.add_pier(self.site, self.pier, ground, self.rng[4])
        self._riprap(ground)
        return piles

    def _riprap(self, ground: HeightField) -> None:
        """The larger stones of the slope at the quay's foot: one thing, as they are laid as one."""
        rng = self.rng[7]
        count = int(4.0 * self.c.length_m)
        kinds = [debris.boulder(1.0, rng, sides=9) for _ in range(24)]
        x = rng.uniform(self.x[0] + 1, self.x[1] - 1, count)
        y = rng.triangular(self.pier.fender_y + 1.8, self.face - 2, self.face - 0.4, count)
        z = ground.height(x, y) + 0.04
        size = rng.uniform(0.3, 1.0, count)
        stones = [
            kinds[k % 24].scaled(s).moved(p) for k, (s, p) in enumerate(zip(size, np.stack([x, y, z], 1), strict=True))
        ]
        self.site.add(join(stones), "rock", label="rock", name="riprap")

    def _boat(self, ground: HeightField) -> None:
        c = self.c
        x, y = c.boat_at_m
        turn = rotation(np.radians(13.0), np.radians(-2.5), np.radians(c.boat_heading_deg))
        bed = float(np.median(ground.height(x + np.linspace(-3, 3, 9), y + np.linspace(-3, 3, 9))))
        sunk = bed - 0.9 * c.boat_length_m / wreck.PROPORTIONS[0]
        instance = self.site.new_instance()
        for mesh, what in wreck.boat(c.boat_length_m):
            placed = mesh.rotated(turn).moved((x, y, sunk))
            self.site.add(placed, what, label="boat", name="sunken boat", crease_deg=35, instance=instance)
        self.places.take(x, y, c.boat_length_m / 2 + 0.5)

    def _boulders(self, ground: HeightField) -> None:
        rng = self.rng[5]
        heaps = [
            rng.uniform((self.places.x[0], self.places.y[0]), (self.places.x[1], self.places.y[1])) for _ in range(5)
        ]
        for k in range(self.c.boulders):
            size = float(np.clip(rng.lognormal(np.log(0.6), 0.45), 0.25, 1.9))
            near = heaps[k % len(heaps)] if rng.uniform() < 0.55 else None
            at = self.places.find(rng, size / 2 + 0.05, around=None if near is None else (near, 4.0))
            if at is None:
                self.site.notes.append(f"boulder {k + 1} of {self.c.boulders} found no free place")
                continue
            stone = debris.boulder(size, rng).moved((*at, _bed(ground, at) + size * rng.uniform(0.02, 0.2)))
            self.site.add(stone, "rock", label="rock", name="boulder", crease_deg=60)

    def _debris(self, ground: HeightField) -> None:
        rng = self.rng[6]
        for k in range(self.c.debris):
            mesh, material, label, name, radius, sink = _lost_thing(k, rng)
            shore = rng.uniform() < 0.6  # most of it fell from the quay
            limit = self.pier.fender_y - (16 if shore else 1000)
            at = self.places.find(rng, radius, accept=partial(_beyond, limit), tries=400)
            if at is None:
                self.site.notes.append(f"{name} {k + 1} of {self.c.debris} found no free place")
                continue
            placed = mesh.rotated(_lie(ground, at, rng)).moved((*at, _bed(ground, at) - sink))
            self.site.add(placed, material, label=label, name=name, crease_deg=40)

    def _moorings(self, ground: HeightField) -> None:
        for k in range(self.c.moorings):
            side = 1 if k % 2 else -1
            row = (k // 2 + 0.5) / max(1, (self.c.moorings + 1) // 2)
            y = self.y[0] * 0.75 + row * (self.pier.fender_y - 22 - self.y[0] * 0.75)
            at = np.array([side * (self.x[1] - 13.0), y])
            bed = _bed(ground, at)
            self.site.add(
                debris.mooring_block().moved((*at, bed - 0.25)), "concrete", label="mooring", name="mooring block"
            )
            drift = np.array([-side * 1.0, 0.8])
            s = np.linspace(0, 1, 40)
            slack = 2.2 * np.sin(np.pi * s) * (1 - s) ** 1.5  # the chain hangs in the lower part
            path = np.column_stack(
                [
                    at + np.outer(s**1.6 * 2.5 - 0.0 * s, drift) + np.outer(slack, [side * 0.4, -0.6]),
                    bed + 0.86 + s * (-1.0 - bed - 0.86),
                ]
            )
            self.site.add(
                shapes.chain(path, 0.28, 0.028), "rusted_steel", label="chain", name="mooring chain", crease_deg=60
            )
            top = path[-1]
            self.site.add(
                debris.buoy().moved((top[0], top[1], -0.18)), "yellow", label="buoy", name="mooring buoy", crease_deg=50
            )


def _beyond(limit: float, x: float, y: float) -> bool:
    del x
    return y > limit


def _bed(ground: HeightField, at: NDArray[np.float64]) -> float:
    return float(ground.height(at[0], at[1]))


def _lie(ground: HeightField, at: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """A rotation that lays a thing on the slope, with any heading and a little tilt."""
    d = 0.5
    gx = float(ground.height(at[0] + d, at[1]) - ground.height(at[0] - d, at[1])) / (2 * d)
    gy = float(ground.height(at[0], at[1] + d) - ground.height(at[0], at[1] - d)) / (2 * d)
    return lean(gx, gy) @ rotation(rng.normal() * 0.06, rng.normal() * 0.06, rng.uniform(0, 2 * np.pi))


def _lost_thing(k: int, rng: np.random.Generator) -> tuple[Mesh, str, str, str, float, float]:
    """Mesh, material, label, name, radius of its place [m], and how deep it sinks in [m]."""
    kinds = ["tyre", "tyre", "drum", "pallet", "crate", "girder", "pipe", "anchor", "block", "tyre", "log", "drum"]
    kind = kinds[k % len(kinds)]
    if kind == "tyre":
        lying = rng.uniform() < 0.75
        mesh = (
            waterfront.tyre()
            if lying
            else waterfront.tyre().turned(roll=np.pi / 2 + rng.normal() * 0.15).moved((0, 0, 0.3))
        )
        return mesh.moved((0, 0, 0.14)), "rubber", "tyre", "tyre", 0.55, rng.uniform(0.02, 0.1)
    if kind == "drum":
        upright = rng.uniform() < 0.3
        mesh = debris.drum() if upright else debris.drum().turned(roll=np.pi / 2).moved((0, 0.44, 0.29))
        return mesh, "rusted_steel", "barrel", "drum", 0.65, rng.uniform(0.03, 0.15)
    if kind == "pallet":
        return debris.pallet(), "wood", "pallet", "pallet", 0.8, 0.03
    if kind == "crate":
        return debris.crate(), "rusted_steel", "trap", "lobster crate", 0.65, 0.05
    if kind == "girder":
        return debris.girder(rng.uniform(2, 4)), "rusted_steel", "debris", "girder", 2.0, 0.06
    if kind == "pipe":
        return (
            debris.pipe_piece(rng.uniform(1.2, 3), rng.uniform(0.12, 0.3)),
            "rusted_steel",
            "debris",
            "pipe piece",
            1.6,
            0.06,
        )
    if kind == "anchor":
        mesh = debris.stock_anchor().turned(pitch=np.pi / 2 - 0.18).moved((-0.8, 0, 0.45))
        return mesh, "rusted_steel", "anchor", "anchor", 1.2, 0.1
    if kind == "block":
        return shapes.box((1.1, 0.8, 0.7)).moved((0, 0, 0.35)), "concrete", "concrete", "concrete block", 0.75, 0.12
    return (
        shapes.noisy(
            shapes.tube([(-1.6, 0, 0.16), (0, 0.1, 0.18), (1.7, 0, 0.15)], np.array([0.17, 0.16, 0.12])), 0.02, rng
        ),
        "wood",
        "debris",
        "log",
        1.8,
        0.05,
    )
