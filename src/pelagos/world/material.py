"""Materials of surfaces: one value carries the optical, the acoustic and the contact properties together.

Sediments take their acoustics from APL-UW TR 9407 (see `sediment.py`). Solids take densities and sound speeds of
handbooks, relative to sea water of 1025 kg/m^3 and 1500 m/s. Everything marked `assumed` is a plausible value without a
measurement behind it: colours, Lambert strengths of man-made surfaces, contact stiffness.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Final

import numpy as np

from pelagos import jit
from pelagos.errors import LookupFailed
from pelagos.jit import Array
from pelagos.world.sediment import SEDIMENTS, Sediment


@dataclass(frozen=True)
class Material:
    """A surface.

    Attributes:
        name: its key in `MATERIALS`.
        albedo: diffuse reflectance of (red, green, blue), linear light, 0 .. 1.
        optical_roughness: GGX roughness 0 .. 1; 1 is matt.
        texture: pattern that varies the albedo: one of `TEXTURES`.
        texture_scale: size of the pattern's cells [m].
        density_ratio: density over that of the water.
        sound_speed_ratio: compressional sound speed over that of the water.
        loss: delta, imaginary over real acoustic wave number.
        volume_scatter: sigma2, volume scattering cross-section over attenuation.
        spectral_strength: w2 of the relief spectrum [cm^4].
        lambert_db: mu of Lambert's law S = mu + 20 log10 sin(grazing) [dB], for targets without a sediment model.
        friction: Coulomb coefficient against a vehicle's hull.
        stiffness: contact stiffness of one hull probe [N/m].
        damping: contact damping of one hull probe [N s/m].
        source: where the acoustic numbers come from.
        sediment: its numbers are those of the seabed model of TR 9407, by which it scatters sound.
        corner_m: of the inside of a corner reflector with such edges [m], whose cross section it scatters with; else 0.
    """

    name: str
    albedo: tuple[float, float, float]
    optical_roughness: float
    texture: str
    texture_scale: float
    density_ratio: float
    sound_speed_ratio: float
    loss: float
    volume_scatter: float
    spectral_strength: float
    lambert_db: float
    friction: float
    stiffness: float
    damping: float
    source: str
    sediment: bool = False
    corner_m: float = 0.0


TEXTURES: Final = ("none", "grain", "ripples", "pebbles", "concrete", "rust", "planks", "bricks", "growth", "blades")
"""Kinds of albedo pattern, by index as in `MaterialTables.texture`."""


def _sediment(
    name: str,
    row: Sediment,
    albedo: tuple[float, float, float],
    texture: str,
    scale: float,
    lambert_db: float,
    contact: tuple[float, float, float],
) -> Material:
    return Material(
        name, albedo, 1.0, texture, scale, row.density_ratio, row.sound_speed_ratio, row.loss, row.volume_scatter,
        row.spectral_strength, lambert_db, *contact, source="APL-UW TR 9407 (1994), Sec. IV, Table 2",
        sediment=True,
    )  # fmt: skip


def _tr9407() -> dict[str, Material]:
    """Every row of TR 9407, with colour, Lambert strength and contact graded by grain size (assumed)."""
    made = {}
    for name, row in SEDIMENTS.items():
        fine = 0.0 if row.grain_size_phi is None else float(np.clip((row.grain_size_phi + 1) / 10, 0, 1))
        albedo = (round(0.36 - 0.26 * fine, 3), round(0.31 - 0.22 * fine, 3), round(0.23 - 0.16 * fine, 3))  # assumed
        contact = (round(0.6 - 0.35 * fine, 2), round(8e4 * 10 ** (-1.2 * fine), -2), 600.0)  # assumed
        texture, scale = ("pebbles", 0.06) if row.grain_size_phi is None else ("grain", 0.02)
        # Mackenzie's -27 dB for sand, and the span -25 .. -35 of sediments (Jackson and Richardson 2007, Ch. 12)
        made[name] = _sediment(name, row, albedo, texture, scale, round(-22 - 13 * fine, 1), contact)
    return made


def _solid(
    name: str,
    albedo: tuple[float, float, float],
    roughness: float,
    texture: tuple[str, float],
    acoustics: tuple[float, float, float],
    lambert_db: float,
    contact: tuple[float, float, float],
) -> Material:
    """A solid: acoustics are (density [kg/m^3], sound speed [m/s], loss); its relief scatters as Lambert's law says."""
    density, speed, loss = acoustics
    return Material(
        name, albedo, roughness, texture[0], texture[1], round(density / 1025, 4), round(speed / 1500, 4), loss, 0.002,
        0.01862, lambert_db, *contact, source="density and sound speed: CRC Handbook; Lambert strength assumed",
    )  # fmt: skip


_HARD: Final = (0.5, 2.0e5, 400.0)  # assumed: friction, stiffness [N/m], damping [N s/m] of a composite hull on stone
_METAL: Final = (0.3, 2.5e5, 300.0)  # assumed
_SOFT: Final = (0.8, 2.0e4, 600.0)  # assumed


def _materials() -> dict[str, Material]:
    sediments = _tr9407()
    pick = SEDIMENTS
    named = [
        _sediment("sand", pick["medium_sand"], (0.36, 0.30, 0.20), "ripples", 0.12, -27.0, (0.5, 4e4, 600.0)),
        _sediment("silt", pick["medium_silt"], (0.19, 0.16, 0.11), "grain", 0.02, -32.0, (0.3, 1e4, 700.0)),
        _sediment("mud", pick["fine_silt"], (0.12, 0.10, 0.07), "grain", 0.03, -34.0, (0.25, 6e3, 800.0)),
        _sediment("gravel", pick["sandy_gravel"], (0.26, 0.24, 0.20), "pebbles", 0.04, -23.0, (0.55, 7e4, 600.0)),
        _sediment("cobblestone", pick["cobble"], (0.24, 0.23, 0.21), "pebbles", 0.15, -20.0, _HARD),
        replace(sediments["rock"], albedo=(0.20, 0.18, 0.15), texture="growth", texture_scale=0.15, lambert_db=-18.0),
        _solid("concrete", (0.34, 0.33, 0.30), 0.9, ("concrete", 0.4), (2400, 3700, 0.01), -19.0, _HARD),
        _solid("brick", (0.36, 0.14, 0.09), 0.9, ("bricks", 0.22), (1900, 3650, 0.02), -19.0, _HARD),
        _solid("steel", (0.45, 0.45, 0.47), 0.35, ("none", 1.0), (7850, 5900, 0.001), -21.0, _METAL),
        _solid("rusted_steel", (0.22, 0.10, 0.05), 0.8, ("rust", 0.10), (7850, 5900, 0.001), -17.0, _METAL),
        _solid("gold", (1.00, 0.70, 0.28), 0.2, ("none", 1.0), (19300, 3240, 0.001), -21.0, _METAL),
        _solid("tungsten_carbide", (0.35, 0.35, 0.36), 0.2, ("none", 1.0), (14900, 6853, 0.001), -21.0, _METAL),
        _solid("copper", (0.72, 0.43, 0.32), 0.3, ("none", 1.0), (8947, 4760, 0.001), -21.0, _METAL),
        _solid("hull_paint", (0.75, 0.50, 0.03), 0.4, ("none", 1.0), (1800, 2700, 0.02), -21.0, (0.3, 1e5, 400.0)),
        _solid("wood", (0.28, 0.18, 0.10), 0.8, ("planks", 0.18), (750, 3300, 0.05), -20.0, (0.4, 8e4, 500.0)),
        _solid("rubber", (0.03, 0.03, 0.03), 0.9, ("none", 1.0), (1150, 1600, 0.10), -26.0, _SOFT),
        _solid("white", (0.85, 0.85, 0.85), 0.6, ("none", 1.0), (2000, 2700, 0.02), -20.0, _HARD),
        _solid("weathered_paint", (0.55, 0.55, 0.50), 0.8, ("rust", 0.16), (7850, 5900, 0.001), -19.0, _METAL),
        _solid("black", (0.02, 0.02, 0.02), 0.6, ("none", 1.0), (2000, 2700, 0.02), -20.0, _HARD),
        _solid("red", (0.60, 0.05, 0.03), 0.5, ("none", 1.0), (2000, 2700, 0.02), -20.0, _HARD),
        _solid("green", (0.04, 0.35, 0.10), 0.5, ("none", 1.0), (2000, 2700, 0.02), -20.0, _HARD),
        _solid("blue", (0.04, 0.12, 0.50), 0.5, ("none", 1.0), (2000, 2700, 0.02), -20.0, _HARD),
        _solid("yellow", (0.80, 0.55, 0.03), 0.5, ("none", 1.0), (2000, 2700, 0.02), -20.0, _HARD),
        _solid("grass", (0.10, 0.22, 0.05), 1.0, ("blades", 0.05), (1030, 1530, 0.05), -30.0, _SOFT),
        _solid("kelp", (0.16, 0.13, 0.03), 0.6, ("blades", 0.08), (1040, 1540, 0.05), -28.0, (0.2, 5e2, 60.0)),
        *(
            _solid(name, albedo, 0.9, ("grain", 0.03), (2000, 3000, 0.02), -18.0, _HARD)
            for name, albedo in (
                ("coral", (0.48, 0.30, 0.24)),
                ("red_coral", (0.52, 0.10, 0.07)),
                ("ochre_coral", (0.55, 0.36, 0.10)),
                ("purple_coral", (0.33, 0.18, 0.36)),
                ("green_coral", (0.22, 0.32, 0.12)),
            )
        ),
        *(
            _solid(name, albedo, 1.0, ("growth", 0.04), (1100, 1600, 0.08), -28.0, _SOFT)
            for name, albedo in (("sponge", (0.50, 0.30, 0.08)), ("red_sponge", (0.45, 0.08, 0.05)))
        ),
        _solid("netting", (0.06, 0.07, 0.06), 0.8, ("none", 1.0), (1140, 2600, 0.05), -24.0, (0.3, 2e4, 300.0)),
        _solid("fish", (0.35, 0.38, 0.40), 0.3, ("none", 1.0), (1070, 1560, 0.01), -22.0, (0.2, 2e3, 100.0)),
    ]
    return sediments | {m.name: m for m in named}


MATERIALS: Final[dict[str, Material]] = _materials()
"""The materials that a scenario may name."""


def material(name: str) -> Material:
    """The material of that name.

    Raises:
        LookupFailed: there is none; the message lists those there are.
    """
    if name not in MATERIALS:
        raise LookupFailed("material", name, MATERIALS)
    return MATERIALS[name]


@jit.struct
class MaterialTables:
    """One row a material of a world: a Dr.Jit struct, gathered by `Hits.material`. Fields are those of `Material`.

    Attributes:
        albedo: `Array3f`; texture: `UInt32`, index in `TEXTURES`; all others: `Float`.
    """

    albedo: Array
    optical_roughness: Array
    texture: Array
    texture_scale: Array
    density_ratio: Array
    sound_speed_ratio: Array
    loss: Array
    volume_scatter: Array
    spectral_strength: Array
    lambert_db: Array
    friction: Array
    stiffness: Array
    damping: Array


def material_tables(materials: Sequence[Material]) -> MaterialTables:
    """The device tables of `materials`, row by row; at least one."""

    columns = {}
    for f in fields(MaterialTables):
        values = [getattr(m, f.name) for m in materials]
        if f.name == "albedo":
            columns[f.name] = jit.Array3f(np.array(values, dtype=np.float32).T)
        elif f.name == "texture":
            columns[f.name] = jit.UInt32([TEXTURES.index(v) for v in values])
        else:
            columns[f.name] = jit.Float([float(v) for v in values])
    tables = MaterialTables(**columns)
    jit.align(tables)
    return tables
