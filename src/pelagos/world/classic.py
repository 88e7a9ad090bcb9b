"""The worlds that users of HoloOcean know by name, in our own designs: their purpose, size and contents, not their art.

Sizes and contents follow HoloOcean's documentation of its worlds (BYU FRoSt Lab); every design here is ours.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar, Final, Literal

from pelagos.world.built import BuiltConfig
from pelagos.world.campus import business_campus
from pelagos.world.config import WorldConfig
from pelagos.world.generate.generated import GeneratedConfig
from pelagos.world.world import World


def dam(seed: int) -> BuiltConfig | GeneratedConfig:
    """650 m x 650 m of reservoir about a dam with gates and roads, outlet pipes with covers, and vents on the bed."""
    wet = (4, 60)  # no boulders on the banks
    things = [
        {"kind": "dam", "at_m": [[_DAM_X, 0]], "count": 1, "size_m": 560, "heading_deg": 90},
        {"kind": "boulder", "density_per_ha": 6, "size_m": [0.5, 3], "cluster": 0.6, "depth_m": wet},
        {"kind": "debris", "density_per_ha": 1.5, "cluster": 0.5, "depth_m": wet},
    ]
    banks = [
        {"at_m": (-187, 0), "size_m": (280, 660), "depth_m": -2.0, "relief": 0.2, "blend_m": 6},  # below the dam
        {"at_m": (0, 310), "size_m": (660, 40), "depth_m": -5.0, "relief": 0.3, "blend_m": 25},
        {"at_m": (0, -308), "size_m": (660, 50), "depth_m": -4.8, "relief": 0, "blend_m": 25},
        {"at_m": (200, -225), "size_m": (260, 210), "depth_m": -4.8, "relief": 0, "blend_m": 30},
    ]
    return GeneratedConfig(
        seed=seed, size_m=(650, 650), grid_m=2.0, depth_m=24, material="silt", patches=("mud", "gravel"),
        grades=tuple(banks), objects=_objects(things), things=_on_the_dam() + _before_the_dam(),
        exclude=({"at_m": (0, 0), "radius_m": 12},),
        terrain={"kind": "canyon", "relief_m": 8, "wavelength_m": 500, "roughness_m": 0.3, "heading_deg": 90},
    )  # fmt: skip


_DAM_X: Final = -30.0  # [m], where its face meets the crest; it looks towards x


def _on_the_dam() -> Any:
    """The road on the crest, 5 m above the water, and on along the banks; its walls, and towers of its lifting gear."""
    crest = _DAM_X - 6.6
    road = [_box((crest, -7.5, 5.15), (9.0, 575, 0.3), "black", "asphalt", "road")]
    road.append(_box((36.7, -290, 5.15), (155.6, 8.0, 0.3), "black", "asphalt", "road"))
    road.append(_box((110, -210, 5.15), (9.0, 152, 0.3), "black", "asphalt", "road"))
    road.append(_box((110, -150, 5.14), (60, 50, 0.3), "black", "asphalt", "yard"))
    road += [_box((x, 0, 5.6), (0.4, 560, 1.2), "concrete", "railing", "parapet") for x in (crest - 4.7, crest + 4.7)]
    towers = [
        _box((crest + 3, y, 8.0), (4.5, 7.0, 6.0), "concrete", "building", "gate house") for y in range(-240, 241, 80)
    ]
    return (*road, *towers)


def _before_the_dam() -> Any:
    """Pipes from the foot of the dam with covers at their ends, and vents with covers, in rows along it."""
    ends = [-220.5 + 63 * k for k in range(8)]
    pipes: list[dict[str, Any]] = []
    for y in ends:
        pipes += [
            {"shape": "cylinder", "at_m": [_DAM_X + 22, y, 1.0], "size_m": [2.4, 2.4, 30],
             "orientation_deg": [0, 90, 0], "on_ground": True, "material": "rusted_steel", "label": "pipe",
             "name": "outlet pipe"},
            {"shape": "cylinder", "at_m": [_DAM_X + 37.2, y, 1.0], "size_m": [3.4, 3.4, 0.5],
             "orientation_deg": [0, 90, 0], "on_ground": True, "material": "steel", "label": "pipe_cover",
             "name": "pipe cover"},
        ]  # fmt: skip
    for x, y in [(60, y) for y in range(-75, 226, 75)] + [(140, y) for y in range(0, 201, 100)]:
        pipes += [
            {"shape": "cylinder", "at_m": [x, y, 1.0], "size_m": [3, 3, 3.4], "on_ground": True,
             "material": "concrete", "label": "concrete", "name": "vent"},
            {"shape": "cylinder", "at_m": [x, y, 2.9], "size_m": [3.6, 3.6, 0.4], "on_ground": True,
             "material": "rusted_steel", "label": "vent_cover", "name": "vent cover"},
        ]  # fmt: skip
    return tuple(pipes)


def pier_harbor(seed: int) -> BuiltConfig | GeneratedConfig:
    """2 km x 2 km of harbour: quays with piers of three sizes, ships, boats and houses, a marina, moles, a channel."""
    quay = [[x, 420.0] for x in range(-300, 301, 120)]
    marina = [[520.0, 300.0], [640.0, 300.0]]
    moles = [[s * x, -500.0] for x in range(120, 601, 120) for s in (-1, 1)]
    berths = [[x + s * 10.5, 352.0] for x in (-240, 0, 240) for s in (-1, 1)]
    channel = [[x, y] for y in range(-940, -540, 80) for x in (-55, 55)]
    fingers = [475 + 30 * k for k in range(8)]
    wet = (5, 60)  # nothing is strewn over the land behind the quay
    things = [
        {"kind": "quay_wall", "count": len(quay) + 2, "at_m": quay + marina, "size_m": 120, "heading_deg": 0},
        {"kind": "quay_wall", "count": len(moles), "at_m": moles, "size_m": 120, "heading_deg": 180},
        {"kind": "pier", "count": 3, "at_m": [[x, 357] for x in (-240, 0, 240)], "size_m": 120, "heading_deg": 90},
        {"kind": "moored_ship", "count": 5, "at_m": berths[:5], "size_m": 80, "heading_deg": 90},
        {"kind": "pier", "count": 8, "at_m": [[x, 279] for x in fingers], "size_m": 36, "heading_deg": 90},
        {
            "kind": "moored_ship",
            "count": 8,
            "at_m": [[x + 5.5, 279] for x in fingers],
            "size_m": 16,
            "heading_deg": 90,
            "label": "yacht",
        },
        {
            "kind": "moored_ship",
            "count": 2,
            "at_m": [[36, 10], [18, 28]],
            "size_m": 12,
            "heading_deg": 20,
            "label": "boat",
        },
        {"kind": "pier", "count": 1, "at_m": [[23, 17]], "size_m": 60, "heading_deg": 20},
        {"kind": "mooring", "count": len(channel), "at_m": channel, "size_m": 18, "label": "buoy"},
        {"kind": "moored_ship", "count": 3, "size_m": [60, 110], "min_distance_m": 60, "depth_m": wet},
        {"kind": "wreck_boat", "count": 4, "depth_m": wet},
        {"kind": "piling", "count": 80, "cluster": 0.8, "cluster_radius_m": 15, "depth_m": wet},
        {"kind": "mooring", "count": 12, "depth_m": wet, "label": "buoy"},
        {"kind": "boulder", "density_per_ha": 0.8, "size_m": [0.5, 3], "cluster": 0.6, "depth_m": wet},
        {"kind": "kelp", "density_per_ha": 0.6, "cluster": 0.9, "depth_m": wet},
        {"kind": "tyre", "density_per_ha": 0.3, "depth_m": wet, "label": "trash"},
        {"kind": "debris", "density_per_ha": 0.4, "cluster": 0.5, "depth_m": wet, "label": "trash"},
    ]
    land = {"at_m": (0, 480), "size_m": (716, 108), "depth_m": -2.4, "relief": 0, "blend_m": 5}
    houses = [_box((x, 456, 7.4), (70, 36, 10), "brick", "building", "warehouse") for x in range(-300, 301, 120)]
    houses += [_box((x, 456, 12.9), (72, 38, 1), "concrete", "building", "roof") for x in range(-300, 301, 120)]
    return GeneratedConfig(
        seed=seed, size_m=(2000, 2000), grid_m=4.0, depth_m=20, material="silt", patches=("sand", "mud"), patch_m=150,
        grades=(land,), objects=_objects(things), things=tuple(houses),
        exclude=({"at_m": (0, -600), "radius_m": 60}, {"at_m": (-20, 10), "radius_m": 20}),
        terrain={"kind": "flat", "relief_m": 4, "wavelength_m": 300, "roughness_m": 0.2},
    )  # fmt: skip


def open_water(seed: int) -> BuiltConfig | GeneratedConfig:
    """2 km x 2 km of rolling hills about 295 m deep, with sunken submarines and aircraft, rock, plants and coral."""
    things = [
        {
            "kind": "wreck_submarine",
            "count": 4,
            "at_m": [[650, 176], [556, 252], [52, -48]],
            "size_m": 55,
            "heading_deg": 8,
        },
        {"kind": "wreck_aircraft", "count": 5, "at_m": [[208, 460], [44, 24]], "label": "plane"},
        {"kind": "outcrop", "density_per_ha": 0.4, "cluster": 0.5, "cluster_radius_m": 40},
        {"kind": "boulder", "density_per_ha": 3, "size_m": [0.5, 4], "cluster": 0.5},
        {"kind": "coral", "density_per_ha": 1.5, "cluster": 0.8},
        {"kind": "sponge", "density_per_ha": 1, "cluster": 0.8},
        {"kind": "seagrass", "density_per_ha": 2, "size_m": [0.5, 1.5], "cluster": 0.8},
    ]
    hills = [  # under the places that HoloOcean's documentation starts vehicles at: low enough, and within their sonars
        ((620, 170), 297.0), ((556, 246), 301.0), ((35, -40), 299.0), ((205, 457), 297.0), ((0, 20), 293.0),
        ((170, 10), 291.0), ((175, -92), 284.0),
    ]  # fmt: skip
    return GeneratedConfig(
        seed=seed, size_m=(2000, 2000), grid_m=4.0, depth_m=295, material="sand", patches=("silt", "gravel"),
        patch_m=200, grades=tuple({"at_m": at, "radius_m": 15, "depth_m": d, "blend_m": 100} for at, d in hills),
        exclude=tuple({"at_m": at, "radius_m": 4} for at, _ in hills),
        objects=_objects(things), terrain={"kind": "flat", "relief_m": 30, "wavelength_m": 500, "roughness_m": 0.3,
                                           "spectrum_slope": 5.0},  # slopes of small relief would show the grid
    )  # fmt: skip


def simple_underwater(seed: int) -> BuiltConfig | GeneratedConfig:
    """A walled basin of 240 m x 240 m, 20 m deep, with pipes at its north end."""
    del seed
    depth, half = 20.0, 120.0
    walls = [
        _box((s * (half - 1), 0, -depth / 2 + 1), (2, 2 * half, depth + 2), "concrete", "wall", "wall") for s in (-1, 1)
    ] + [
        _box((0, s * (half - 1), -depth / 2 + 1), (2 * half - 4, 2, depth + 2), "concrete", "wall", "wall")
        for s in (-1, 1)
    ]
    pipes: list[dict[str, Any]] = [
        {"shape": "cylinder", "at_m": [80, -60 + 30 * k, -depth + 1.2 + 0.6 * (k % 2)], "size_m": [1.2, 1.2, 60],
         "orientation_deg": [0, 90, 0], "material": "rusted_steel", "label": "pipe", "name": "pipe"} for k in range(5)
    ]  # fmt: skip
    pipes.append(
        {"shape": "cylinder", "at_m": [70, 0, -depth + 3.2], "size_m": [1.5, 1.5, 150], "orientation_deg": [90, 0, 0],
         "material": "rusted_steel", "label": "pipe", "name": "header"}
    )  # fmt: skip
    blocks = [
        _box((20 + 12 * k, -35 + 23 * k, -depth + 1), (2, 2, 2), "concrete", "concrete", "block") for k in range(3)
    ]
    return _built(depth, (2 * half, 2 * half), [*walls, *pipes, *blocks])


def flat_underwater(seed: int) -> BuiltConfig | GeneratedConfig:
    """A flat, sandy bed of 1 km x 1 km at 20 m."""
    del seed
    return _built(20.0, (1000.0, 1000.0), [])


def rooms(seed: int) -> BuiltConfig | GeneratedConfig:
    """Four dry rooms of 8 m x 8 m about a corridor, floor at z = 0.05 m, with furniture."""
    del seed
    things = [
        _box((0, 0, -0.05), (24, 20, 0.2), "wood", "floor", "floor"),  # its top, 5 cm up, covers the sea surface
        _box((0, 0, 3.1), (24, 20, 0.2), "white", "ceiling", "ceiling"),
    ]
    for y in (-10.0, 10.0):
        things.append(_box((0, y, 1.5), (24, 0.2, 3), "white", "wall", "wall"))
    for x in (-12.0, 12.0):
        things.append(_box((x, 0, 1.5), (0.2, 20, 3), "white", "wall", "wall"))
    for y in (-1.5, 1.5):
        for x, wide in ((-10.25, 3.5), (0.0, 13.0), (10.25, 3.5)):  # doors of 2 m at x = -7.5 and x = 7.5
            things.append(_box((x, y, 1.5), (wide, 0.15, 3), "white", "wall", "wall"))
        things.append(_box((0, 5.75 * (1 if y > 0 else -1), 1.5), (0.15, 8.5, 3), "white", "wall", "wall"))
    for k, (x, y) in enumerate(((-6, 6), (6, 6), (-6, -6), (6, -6))):
        things.append(_box((x, y, 0.72), (1.6, 0.8, 0.06), "wood", "table", "table"))
        things += [
            _box((x + dx, y + dy, 0.35), (0.06, 0.06, 0.7), "wood", "table", "table")
            for dx in (-0.7, 0.7)
            for dy in (-0.3, 0.3)
        ]
        things.append(_box((x + 2.5, y + (-1) ** k, 0.4), (0.8, 0.8, 0.8), "yellow", "crate", "crate"))
    return BuiltConfig(depth_m=None, things=tuple(things))


def tank(seed: int) -> BuiltConfig | GeneratedConfig:
    """A test tank of 20 m x 10 m, 5 m deep, with a calibration sphere and a target plate."""
    del seed
    walls = [_box((s * 10.15, 0, -2.25), (0.3, 10.6, 5.5), "concrete", "wall", "tank wall") for s in (-1, 1)]
    walls += [_box((0, s * 5.15, -2.25), (20, 0.3, 5.5), "concrete", "wall", "tank wall") for s in (-1, 1)]
    sphere = {"shape": "sphere", "at_m": [6, 0, -2.5], "size_m": [0.38, 0.38, 0.38], "material": "steel",
              "label": "sphere",
              "name": "calibration sphere"}  # fmt: skip
    plate = _box((8, -3, -2.5), (0.02, 1.0, 1.0), "steel", "cube", "target plate")
    return _built(5.0, (21.0, 11.0), [*walls, sphere, plate], material="concrete")


def test_world(seed: int) -> BuiltConfig | GeneratedConfig:
    """Ground at z = 0 beside water, a wall at x = 2.77 m, blockers: a stand-in for HoloOcean's test level."""
    del seed
    things = [
        _box((-17.5, 0, -0.235), (45, 30, 0.53), "grass", "landscape", "ground"),
        {"shape": "plane", "at_m": [2.77, 0.7, 1.0], "size_m": [2.0, 1.0, 1.0], "orientation_deg": [0, -90, 0],
         "material": "concrete", "label": "wall", "name": "wall"},  # nothing is inside a sheet
        _box((1.75, -30, -1.0), (2.0, 4.0, 6.0), "concrete", "wall", "blocker"),
        _box((-10, 5.5, 0.53), (1.0, 1.0, 1.0), "wood", "cube", "blocker"),
        _box((0, -50, -3.5), (12, 12, 1.0), "sand", "landscape", "shoal"),
        *(_box((47, -58 + 8 * k, -3.0), (8, 8, 2.0), m, "landscape", "layer")
          for k, m in enumerate(("sand", "gravel", "rock"), -1)),
    ]  # fmt: skip
    return _built(24.0, (160.0, 160.0), things)


def example_level(seed: int) -> BuiltConfig | GeneratedConfig:
    """A small level: a raft of 10 m x 10 m above water of 5 m, with a box, a ball and a cone on it."""
    del seed
    things = [
        _box((0, 0, -0.45), (10, 10, 1.0), "concrete", "floor", "raft"),
        _box((3, 2, 0.55), (1.0, 1.0, 1.0), "wood", "cube", "box"),
        {"shape": "sphere", "at_m": [3, -2, 0.55], "size_m": [1, 1, 1], "material": "gold", "label": "sphere"},
        {"shape": "cone", "at_m": [-3, 0, 0.55], "size_m": [1, 1, 1], "material": "yellow", "label": "cone"},
    ]
    return _built(5.0, (40.0, 40.0), things)


CLASSICS: Final[dict[str, Callable[[int], BuiltConfig | GeneratedConfig]]] = {
    made.__name__: made
    for made in (
        business_campus,
        dam,
        example_level,
        flat_underwater,
        open_water,
        pier_harbor,
        rooms,
        simple_underwater,
        tank,
        test_world,
    )
}
"""The classics by name: each gives the configuration of a built or generated world."""


class ClassicConfig(WorldConfig):
    """A world known from HoloOcean, in Pelagos's own design."""

    TITLE: ClassVar[str] = "The classics: dam, pier_harbor, open_water, simple_underwater, rooms, tank, ..."

    type: Literal["classic"] = "classic"
    """The kind of world."""
    name: Literal[
        "business_campus",
        "dam",
        "example_level",
        "flat_underwater",
        "open_water",
        "pier_harbor",
        "rooms",
        "simple_underwater",
        "tank",
        "test_world",
    ]
    """Which one."""
    seed: int = 1
    """Seed of what is random in it."""

    def build(self) -> World:
        """Build it."""
        plan = CLASSICS[self.name](self.seed)
        place = {"latitude_deg": self.latitude_deg, "longitude_deg": self.longitude_deg}
        built = plan.model_copy(update=place).build()
        title = (CLASSICS[self.name].__doc__ or "").strip().split("\n")[0]
        return replace(built, name=self.name, description=title)


def _objects(things: list[dict[str, Any]]) -> Any:
    return tuple(things)


def _box(at: tuple[float, float, float], size: tuple[float, float, float], material: str, label: str, name: str) -> Any:
    return {"shape": "box", "at_m": at, "size_m": size, "material": material, "label": label, "name": name}


def _built(depth: float, size: tuple[float, float], things: list[Any], *, material: str = "sand") -> BuiltConfig:
    return BuiltConfig(depth_m=depth, size_m=size, things=tuple(things), material=material)
