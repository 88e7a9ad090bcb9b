"""Generated worlds: a landform, sediments, and things in numbers, sizes and clusters as asked, from one seed."""

from __future__ import annotations

from typing import Annotated, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator

from pelagos.errors import LookupFailed, WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.config import WorldConfig
from pelagos.world.generate.draw import Distribution, Drawn, _from_pair, draw
from pelagos.world.generate.kinds.lost import LOST
from pelagos.world.generate.kinds.natural import NATURAL
from pelagos.world.generate.kinds.structures import STRUCTURES
from pelagos.world.generate.landform import LANDFORMS, Ground
from pelagos.world.generate.relief import fractal, ripples
from pelagos.world.generate.route import add_cable, add_pipeline, route
from pelagos.world.generate.scatter import Places
from pelagos.world.generate.sediments import sediment_fields
from pelagos.world.generate.thing import Kind, Thing, stand
from pelagos.world.material import material
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField
from pelagos.world.world import World

KINDS: Final[dict[str, Kind]] = NATURAL | LOST | STRUCTURES
"""Everything that `objects` may name, but for the lines."""

LINES: Final = {"pipeline": (0.3, 0.9), "cable": (0.05, 0.2)}
"""Lines across the ground, with the diameters [m] that they have where a scenario says nothing."""

_MODEL: Final = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


class TerrainConfig(BaseModel):
    """The ground."""

    model_config = _MODEL

    kind: Literal["flat", "slope", "ridges", "canyon", "dunes", "seamount", "reef", "trench", "mixed"] = "flat"
    """Its landform."""
    relief_m: Drawn = 4.0
    """Height of the landform, from foot to top [m]."""
    wavelength_m: Drawn = 80.0
    """Horizontal scale of the landform: from crest to crest, width of a canyon, radius of a seamount [m]."""
    heading_deg: Drawn = 0.0
    """Direction of the landform, from x towards y [deg]."""
    roughness_m: Drawn = 0.15
    """Root mean square of small relief on top of the landform [m]."""
    spectrum_slope: Drawn = 3.2
    """Power spectrum of the small relief over wave number, S ~ k^-slope; natural seabeds have 2 to 4."""
    ripple_m: Drawn = 0.0
    """Height of sand ripples on top, half of crest to trough [m]."""
    ripple_wavelength_m: Drawn = 1.5
    """Crest to crest of the ripples [m]; at least three cells of the grid."""


class ObjectConfig(BaseModel):
    """Things of one kind."""

    model_config = _MODEL

    kind: str
    """What: boulder, outcrop, kelp, seagrass, coral, wreck_boat, pipeline, ... (all in docs/worlds.md)."""
    count: int | None = Field(default=None, ge=0)
    """How many; instead of `density_per_ha`."""
    density_per_ha: float | None = Field(default=None, ge=0)
    """How many in a hectare on average; their number is drawn from Poisson's distribution."""
    size_m: Annotated[Distribution | float | None, BeforeValidator(_from_pair)] = None
    """Size [m]: a number, [least, greatest], or a distribution; the kind says what is measured."""
    cluster: float = Field(default=0.0, ge=0, le=1)
    """Share that stands in clusters; the rest is spread evenly."""
    cluster_radius_m: float = Field(default=8.0, gt=0)
    """Standard deviation of the distance from a cluster's middle [m]."""
    min_distance_m: float = Field(default=0.0, ge=0)
    """Free ground between a thing and everything else [m]."""
    max_slope_deg: float | None = Field(default=None, gt=0, le=90)
    """Steepest ground that it stands on [deg]; by kind where not given."""
    depth_m: tuple[float, float] | None = None
    """Least and greatest depth of the ground it stands on [m]."""
    heading_deg: float | None = None
    """Heading of all, from x towards y [deg]; random where not given."""
    at_m: tuple[tuple[float, float], ...] = ()
    """Places x, y of the first ones [m]; the rest is placed at random."""

    @field_validator("kind")
    @classmethod
    def _known(cls, value: str) -> str:
        known = [*KINDS, *LINES]
        if value not in known:
            raise ValueError(str(LookupFailed("kind of object", value, known)))
        return value


class ExclusionConfig(BaseModel):
    """A disc where nothing is placed."""

    model_config = _MODEL

    at_m: tuple[float, float]
    """Its middle x, y [m]."""
    radius_m: float = Field(gt=0)
    """Its radius [m]."""


class GeneratedConfig(WorldConfig):
    """Ground of a landform with things on it, all from one seed."""

    TITLE: ClassVar[str] = "Generated ground (ridges, canyon, dunes, reef, ...) with natural and man-made things"

    type: Literal["generated"] = "generated"
    """The kind of world."""
    seed: int = Field(default=1, ge=0)
    """Seed of everything random in this world."""
    size_m: tuple[float, float] = (400.0, 400.0)
    """Extent along x (north) and y (west), about the origin [m]."""
    grid_m: float = Field(default=1.0, gt=0)
    """Spacing of the ground's nodes [m]."""
    depth_m: Drawn = 30.0
    """Depth of the mean bed below the mean sea surface [m]."""
    terrain: TerrainConfig = TerrainConfig()
    """The ground."""
    material: str = "sand"
    """Sediment of the bed."""
    patches: tuple[str, ...] = ()
    """Further sediments, in patches that share the bed evenly with the first."""
    patch_m: float = Field(default=60.0, gt=0)
    """Size of the patches [m]."""
    objects: tuple[ObjectConfig, ...] = ()
    """Things on the bed, placed in this order: large ones first."""
    exclude: tuple[ExclusionConfig, ...] = ()
    """Discs where nothing is placed."""

    def build(self) -> World:
        """Build it; the same configuration gives the same bytes.

        Raises:
            WorldError: more nodes than memory is meant for.
            LookupFailed: an unknown sediment.
        """
        return _Generated(self).world()


_MAX_NODES: Final = 40_000_000


class _Generated:
    """One world under construction. Every purpose has its own stream, so that one more boulder moves no kelp."""

    def __init__(self, config: GeneratedConfig) -> None:
        self.c = config
        self.site = Site()
        sequence = np.random.SeedSequence(config.seed)
        self.streams = [np.random.Generator(np.random.PCG64(s)) for s in sequence.spawn(3 + len(config.objects))]
        half = config.size_m[0] / 2, config.size_m[1] / 2
        self.places = Places((-half[0], half[0]), (-half[1], half[1]))
        for disc in config.exclude:
            self.places.take(*disc.at_m, disc.radius_m)

    def world(self) -> World:
        c = self.c
        for name in (c.material, *c.patches):
            material(name)
        ground = self._ground()
        sediments = (c.material, *c.patches)
        for name in sediments:
            self.site.row(name)
        fields = sediment_fields(ground, sediments, c.patch_m, self.streams[1])
        counts: list[str] = []
        for config, rng in zip(c.objects, self.streams[3:], strict=True):
            wanted = self._wanted(config, rng)
            placed = (
                self._lines(config, ground, wanted, rng)
                if config.kind in LINES
                else self._things(config, ground, wanted, rng)
            )
            counts.append(f"{placed} {config.kind}")
            if placed < wanted:
                self.site.notes.append(
                    f"{config.kind}: {placed} of {wanted} were placed; no room was found for the rest"
                )
        size = f"{c.size_m[0]:g} m x {c.size_m[1]:g} m"
        self.site.ground_patches(ground, sediments, fields)  # last: pipelines dig into it
        return self.site.world(
            name="generated",
            description=f"{c.terrain.kind}, {size}, seed {c.seed}: {', '.join(counts) or 'nothing on it'}",
            origin=GeoOrigin(c.latitude_deg or 0.0, c.longitude_deg or 0.0),
        )

    def _ground(self) -> HeightField:
        c, t, rng = self.c, self.c.terrain, self.streams[0]
        nodes = [max(2, round(s / c.grid_m) + 1) for s in c.size_m]
        if nodes[0] * nodes[1] > _MAX_NODES:
            raise WorldError(f"{c.size_m} m at {c.grid_m:g} m are {nodes[0] * nodes[1]} nodes; use a larger grid_m")
        x, y = ((np.arange(n, dtype=np.float64) - (n - 1) / 2) * c.grid_m for n in nodes)
        depth, relief, wavelength, heading, rough, slope, ripple, length = (
            draw(v, rng)
            for v in (c.depth_m, t.relief_m, t.wavelength_m, t.heading_deg, t.roughness_m, t.spectrum_slope, t.ripple_m,
                      t.ripple_wavelength_m)
        )  # fmt: skip
        place = Ground(x, y, c.grid_m, relief, wavelength, float(np.radians(heading)), slope, rng)
        z = LANDFORMS[t.kind](place) - depth
        if rough > 0:
            z += rough * place.rough(min(40.0, 0.5 * min(c.size_m)))
        if ripple > 0:
            wander = 2.0 * fractal(place.shape, c.grid_m, rng, slope=3.5, longest=60, shortest=6 * c.grid_m)
            length = max(length, 3 * c.grid_m)
            z += ripple * ripples(x, y, wavelength=length, heading=place.heading, wander=wander)
        return HeightField(float(x[0]), float(y[0]), c.grid_m, z)

    def _wanted(self, config: ObjectConfig, rng: np.random.Generator) -> int:
        if config.count is not None:
            return config.count
        if config.density_per_ha is None:
            return max(1, len(config.at_m))
        return int(rng.poisson(config.density_per_ha * self.c.size_m[0] * self.c.size_m[1] / 1e4))

    def _things(self, config: ObjectConfig, ground: HeightField, wanted: int, rng: np.random.Generator) -> int:
        kind = KINDS[config.kind]
        size_of = config.size_m if config.size_m is not None else Distribution(uniform=kind.size)
        low, high = np.array([self.places.x[0], self.places.y[0]]), np.array([self.places.x[1], self.places.y[1]])
        heaps = [rng.uniform(low, high) for _ in range(max(1, wanted // 12))]
        typical = -float(np.median(ground.z))
        models: list[tuple[float, Thing]] = []
        placed = 0
        for k in range(wanted):
            size = max(draw(size_of, rng), 1e-2)
            if kind.variants and len(models) >= kind.variants:
                made, thing = models[k % kind.variants]
                thing = thing.scaled(size / made)
            else:
                thing = kind.build(size, rng, typical)
                models.append((size, thing))
            clustered = rng.uniform() < config.cluster
            heap = (heaps[int(rng.integers(len(heaps)))], config.cluster_radius_m) if clustered else None
            yaw = rng.uniform(0, 2 * np.pi) if config.heading_deg is None else float(np.radians(config.heading_deg))
            radius = thing.radius + config.min_distance_m / 2
            suits = _Suits(ground, config, kind, size)
            if k < len(config.at_m):
                at: NDArray[np.float64] | None = np.array(config.at_m[k])
                self.places.take(*config.at_m[k], radius)
            else:
                at = self.places.find(rng, radius, around=heap, accept=suits, tries=120)
                if at is None and heap is not None:
                    at = self.places.find(rng, radius, accept=suits, tries=120)
            if at is None:
                continue
            z, slope = _ground_at(ground, at)
            if kind.make_deep is not None:
                thing = kind.build(size, rng, max(-z, 0.5))
            stand(self.site, thing, at, z, slope, yaw)
            placed += 1
        return placed

    def _lines(self, config: ObjectConfig, ground: HeightField, wanted: int, rng: np.random.Generator) -> int:
        size_of = config.size_m if config.size_m is not None else Distribution(uniform=LINES[config.kind])
        placed = 0
        for _ in range(wanted):
            diameter = draw(size_of, rng)
            path = route(self.places, ground, rng, diameter / 2 + 0.7 + config.min_distance_m / 2)
            if path is None:
                continue
            if config.kind == "pipeline":
                add_pipeline(self.site, path, ground, diameter, rng)
            else:
                add_cable(self.site, path, ground, diameter)
            placed += 1
        return placed


class _Suits:
    """Whether ground suits a thing: its slope, its depth, water enough above."""

    def __init__(self, ground: HeightField, config: ObjectConfig, kind: Kind, size: float) -> None:
        self.ground = ground
        self.limit = np.tan(np.radians(config.max_slope_deg or kind.max_slope_deg))
        least, most = config.depth_m or (-np.inf, np.inf)
        self.depth = (max(least, kind.needs_depth * size if kind.needs_depth > 0 else -np.inf), most)

    def __call__(self, x: float, y: float) -> bool:
        z, slope = _ground_at(self.ground, np.array([x, y]))
        return bool(self.depth[0] <= -z <= self.depth[1] and np.hypot(*slope) <= self.limit)


def _ground_at(ground: HeightField, at: NDArray[np.float64]) -> tuple[float, tuple[float, float]]:
    """Height [m] and slope (dz/dx, dz/dy) over one cell."""
    d = ground.spacing
    x = min(max(float(at[0]), ground.x0 + d), ground.x0 + (ground.z.shape[0] - 2) * d)
    y = min(max(float(at[1]), ground.y0 + d), ground.y0 + (ground.z.shape[1] - 2) * d)
    z = ground.height(np.array([x, x + d, x - d, x, x]), np.array([y, y, y, y + d, y - d]))
    return float(z[0]), (float(z[1] - z[2]) / (2 * d), float(z[3] - z[4]) / (2 * d))
