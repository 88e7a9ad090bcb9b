"""Generated worlds: a landform, sediments, and things in numbers, sizes and clusters as asked, from one seed."""

from __future__ import annotations

from typing import Annotated, ClassVar, Final, Literal

import numpy as np
from pydantic import ConfigDict, Field

from pelagos.config.described import Described
from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.by_hand import add, footprint
from pelagos.world.config import Positive, WorldConfig
from pelagos.world.generate.draw import Drawn, bounded, draw
from pelagos.world.generate.grade import GradeConfig, graded
from pelagos.world.generate.landform import LANDFORMS, Ground
from pelagos.world.generate.objects import ExclusionConfig, ObjectConfig, Placer
from pelagos.world.generate.relief import fractal, ripples
from pelagos.world.generate.scatter import Places
from pelagos.world.generate.sediments import sediment_fields
from pelagos.world.material import material
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField
from pelagos.world.world import World

_MODEL: Final = ConfigDict(frozen=True, extra="forbid")


class TerrainConfig(Described):
    """The ground."""

    model_config = _MODEL

    kind: Literal["flat", "slope", "ridges", "canyon", "dunes", "seamount", "reef", "trench", "mixed"] = "flat"
    """Its landform."""
    relief_m: Drawn = 4.0
    """Height of the landform, from foot to top [m]."""
    wavelength_m: Annotated[Drawn, bounded(above=0)] = 80.0
    """Horizontal scale of the landform: from crest to crest, width of a canyon, radius of a seamount [m]."""
    heading_deg: Drawn = 0.0
    """Direction of the landform, from x towards y [deg]."""
    roughness_m: Annotated[Drawn, bounded(least=0)] = 0.15
    """Root mean square of small relief on top of the landform [m]."""
    spectrum_slope: Annotated[Drawn, bounded(least=0, most=8)] = 3.2
    """Power spectrum of the small relief over wave number, S ~ k^-slope; natural seabeds have 2 to 4."""
    ripple_m: Annotated[Drawn, bounded(least=0)] = 0.0
    """Height of sand ripples on top, half of crest to trough [m]."""
    ripple_wavelength_m: Annotated[Drawn, bounded(above=0)] = 1.5
    """Crest to crest of the ripples [m]; at least three cells of the grid."""


class GeneratedConfig(WorldConfig):
    """Ground of a landform with things on it, all from one seed."""

    TITLE: ClassVar[str] = "Generated ground (ridges, canyon, dunes, reef, ...) with natural and man-made things"

    PLACES_THINGS: ClassVar[bool] = True

    type: Literal["generated"] = "generated"
    """The kind of world."""
    seed: int = Field(default=1, ge=0)
    """Seed of everything random in this world."""
    size_m: tuple[Positive, Positive] = (400.0, 400.0)
    """Extent along x (north) and y (west), about the origin [m]."""
    grid_m: float = Field(default=1.0, gt=0)
    """Spacing of the ground's nodes [m]."""
    depth_m: Drawn = 30.0
    """Depth of the mean bed below the mean sea surface [m]."""
    terrain: TerrainConfig = TerrainConfig()
    """The ground."""
    grades: tuple[GradeConfig, ...] = ()
    """Places where the ground is raised or dug to a depth of their own, in this order."""
    material: str = "sand"
    """Sediment of the bed."""
    patches: tuple[str, ...] = ()
    """Further sediments, in patches that share the bed evenly with the first."""
    patch_m: float = Field(default=60.0, gt=0)
    """Size of the patches [m]."""
    objects: tuple[ObjectConfig, ...] = ()
    """Things on the bed, placed in this order: large ones first."""
    exclude: tuple[ExclusionConfig, ...] = ()
    """Discs and rectangles where nothing is placed."""

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
        self.site = Site(user_labels=config.labels)
        sequence = np.random.SeedSequence(config.seed)
        self.streams = [np.random.Generator(np.random.PCG64(s)) for s in sequence.spawn(3 + len(config.objects))]
        half = config.size_m[0] / 2, config.size_m[1] / 2
        self.places = Places((-half[0], half[0]), (-half[1], half[1]))
        for zone in config.exclude:
            for x, y, radius in zone.discs:
                self.places.take(x, y, radius)
        self.origin = GeoOrigin(config.latitude_deg or 0.0, config.longitude_deg or 0.0)
        for thing in config.things:
            for x, y, radius in footprint(thing, self.origin):
                self.places.take(x, y, radius)

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
        placer = Placer(self.site, self.places, ground)
        for config, rng in zip(c.objects, self.streams[3:], strict=True):
            counts.append(f"{placer.place(config, rng)} {config.kind}")
        self.site.terrain = ground
        for thing in c.things:
            add(self.site, thing, self.origin)
        land = float((ground.z >= 0).mean())
        if land > 0:
            self.site.notes.append(f"{100 * land:.1f} % of the area is land or lies at the sea surface")
        size = f"{c.size_m[0]:g} m x {c.size_m[1]:g} m"
        self.site.ground_patches(ground, sediments, fields)  # last: pipelines dig into it
        return self.site.world(
            name="generated",
            description=f"{c.terrain.kind}, {size}, seed {c.seed}: {', '.join(counts) or 'nothing on it'}",
            origin=self.origin,
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
        wavelength = max(wavelength, c.grid_m)
        place = Ground(x, y, c.grid_m, relief, wavelength, float(np.radians(heading)), slope, rng)
        z = LANDFORMS[t.kind](place) - depth
        if rough > 0:
            z += rough * place.rough(min(40.0, 0.5 * min(c.size_m)))
        if ripple > 0:
            length = max(length, 3 * c.grid_m)
            shortest = min(max(6 * c.grid_m, 5 * length), 40.0)  # crests bend over several ripples, and do not break
            wander = 2.0 * fractal(place.shape, c.grid_m, rng, slope=3.5, longest=60, shortest=shortest)
            z += ripple * ripples(x, y, wavelength=length, heading=place.heading, wander=wander)
        return graded(HeightField(float(x[0]), float(y[0]), c.grid_m, z), c.grades)
