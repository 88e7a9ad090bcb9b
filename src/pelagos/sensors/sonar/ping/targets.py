"""Things that a sonar's rays may miss: small ones, and smooth ones, whose echo is a mirror's.

Whatever stands in the world is looked at once: by its vertices it is a sphere, a box, a cylinder, or anything else of
some size. A thing so small or so far away that few of the fan's rays would meet it has rays of its own, evenly spread
over its disc. A thing that is smooth in wavelengths sends back a coherent echo besides (see `specular`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.sphere_scattering import Filling, sphere_form
from pelagos.jit import Array
from pelagos.math.constants import NOMINAL_SOUND_SPEED
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.sonar.ping.solids import Solid, recognise_shape

if TYPE_CHECKING:
    from pelagos.raycast.geometry import Geometry
    from pelagos.raycast.scene import Scene
    from pelagos.world.material import Material

SPHERE, BOX, CYLINDER, OTHER = 1, 2, 3, 0
_KINDS: Final = {"other": OTHER, "sphere": SPHERE, "box": BOX, "cylinder": CYLINDER}
_MOST_VERTICES: Final = 20_000
_LARGEST: Final = 1.5  # [m], radius of things of no simple shape that are looked for
_MOST: Final = 1024  # things that are looked for, the smallest first
_ROUGH: Final = 0.12  # rms height over wavelength from which less than a tenth is coherent
_LINES: Final = 33  # frequencies of a band
_LARGE_KA: Final = 400.0  # from which a sphere is as its geometry says
_ROUGHNESS_M: Final = {
    "steel": 2e-5,
    "tungsten_carbide": 1e-6,
    "copper": 1e-5,
    "glass": 1e-6,
    "plastic": 5e-5,
    "rusted_steel": 1e-3,
    "concrete": 1e-3,
}
"""Rms height of surfaces [m]; of other solids a millimetre, and sediments are never smooth. Assumed."""
_SHEAR_MPS: Final = {"tungsten_carbide": 4171.0, "copper": 2288.5}
"""Shear wave speeds of the materials of standard spheres [m/s]: K. G. Foote, J. Acoust. Soc. Am. 71, 742 (1982), doi
10.1121/1.387497, and D. N. MacLennan and J. R. Dunn, J. Sound Vib. 97, 321 (1984). They echo as elastic spheres do,
with all resonances; other spheres as rigid ones, by what their surface reflects: what rings on inside is left out."""


@jit.struct
class Targets:
    """Things by row, a Dr.Jit struct.

    Attributes:
        kind: `UInt32`.
        centre: `Array3f64`: of what stands still in the world, of what moves in its body's frame [m].
        axes: `Array4f`, its own axes to the world's or the body's.
        half: `Array3f`, half lengths along its axes [m].
        radius: `Float`, of a sphere that holds it [m].
        form: `Float`, amplitude of a sphere's echo far away, rms over the band [m].
        mirror: `Float`, amplitude that its surface reflects squarely [1].
        smooth: `Float`, rms height of its roughness over the wavelength; large for what is never smooth.
        lambert: `Float`, what a unit of its surface scatters towards where it came from, met squarely [1].
        instance: `UInt32`.
        body: `UInt32`, things by copies: row of the moving table, `NO_BODY` for what stands still.
        of_instance: `UInt32`, row of an instance, or their number where it is none of them.
    """

    kind: Array
    centre: Array
    axes: Array
    half: Array
    radius: Array
    form: Array
    mirror: Array
    smooth: Array
    lambert: Array
    instance: Array
    body: Array
    of_instance: Array

    @property
    def size_key(self) -> tuple[int, int, int]:
        """Things, things by copies, instances."""
        return len(self.kind), len(self.body), len(self.of_instance)


FEW: Final = 24.0
"""Rays of a fan that meet a thing, below which it has rays of its own."""


@dataclass(frozen=True)
class Band:
    """Band that a sonar can hear, and what its rays meet anyway.

    Attributes:
        frequency_hz, bandwidth_hz: middle and width of its band.
        rays_per_sr: of its fan.
        reach: farthest range [m].
    """

    frequency_hz: float
    bandwidth_hz: float
    rays_per_sr: float
    reach: float


@dataclass(frozen=True)
class _Thing:
    geometry: Geometry
    solid: Solid
    rows: tuple[int, ...]  # of the moving table by copy; none: it stands still


def targets(scene: Scene, materials: Sequence[Material], band: Band) -> Targets | None:
    """Targets in a scene; None where there is nothing."""
    things = [_Thing(g, solid, ()) for g, solid in _sized(scene.standing)]
    moving: dict[tuple[int, int], list[int]] = {}
    count: dict[tuple[int, int], int] = {}
    by_key: dict[tuple[int, int], Geometry] = {}
    for row, (geometry, copy) in enumerate(scene.bodies):
        number = count[id(geometry), copy] = count.get((id(geometry), copy), -1) + 1
        moving.setdefault((id(geometry), number), []).append(row)
        by_key[id(geometry), number] = geometry
    for key, rows in moving.items():
        if len(rows) == scene.copies:
            things += [_Thing(g, solid, tuple(rows)) for g, solid in _sized([by_key[key]])]
    things = [t for t in things if _matters(t, materials, band)]
    things = sorted(things, key=lambda thing: thing.solid.radius)[:_MOST]
    return _table(things, scene.copies, materials, band) if things else None


def _matters(thing: _Thing, materials: Sequence[Material], band: Band) -> bool:
    """Whether the fan may miss a thing within its reach, or it is smooth."""
    if math.pi * (thing.solid.radius / band.reach) ** 2 * band.rays_per_sr < FEW:
        return True
    material = materials[int(thing.geometry.face_materials[0])]
    rough = _rms_height(material) * band.frequency_hz / NOMINAL_SOUND_SPEED
    return thing.solid.kind != "other" and rough < _ROUGH and _mirror(material) > 0.0


def _sized(geometries: Sequence[Geometry]) -> list[tuple[Geometry, Solid]]:
    found = []
    for geometry in geometries:
        if not 4 <= len(geometry.vertices) <= _MOST_VERTICES:
            continue
        solid = recognise_shape(geometry.vertices)
        if solid.kind != "other" or solid.radius <= _LARGEST:
            found.append((geometry, solid))
    return found


def _table(things: list[_Thing], copies: int, materials: Sequence[Material], band: Band) -> Targets:
    wavelength = NOMINAL_SOUND_SPEED / band.frequency_hz
    made = [materials[int(t.geometry.face_materials[0])] for t in things]
    instances = np.array([t.geometry.instance for t in things], dtype=np.uint32)
    of_instance = np.full(int(instances.max()) + 2, len(things), dtype=np.uint32)
    of_instance[instances] = np.arange(len(things))

    def column(values: Iterable[float]) -> Array:
        return jit.from_numpy(jit.Float, np.array(list(values), dtype=np.float32))

    body = np.array([t.rows or (NO_BODY,) * copies for t in things], dtype=np.uint32)
    found = Targets(
        kind=jit.from_numpy(jit.UInt32, np.array([_KINDS[t.solid.kind] for t in things], dtype=np.uint32)),
        centre=jit.Array3f64(np.ascontiguousarray(np.array([t.solid.centre for t in things]).T)),
        axes=jit.Array4f(np.ascontiguousarray(np.array([_quaternion(t.solid.axes) for t in things]).T, np.float32)),
        half=jit.Array3f(np.ascontiguousarray(np.array([t.solid.half for t in things]).T, np.float32)),
        radius=column(t.solid.radius for t in things),
        form=column(_form(t, m, band) for t, m in zip(things, made, strict=True)),
        mirror=column(_mirror(m) for m in made),
        smooth=column(_rms_height(m) / wavelength for m in made),
        lambert=column(10.0 ** (m.lambert_db / 10.0) for m in made),
        instance=jit.from_numpy(jit.UInt32, instances),
        body=jit.from_numpy(jit.UInt32, body.ravel()),
        of_instance=jit.from_numpy(jit.UInt32, of_instance),
    )
    jit.align(found)
    return found


def _rms_height(material: Material) -> float:
    return 1.0 if material.sediment or material.corner_m > 0.0 else _ROUGHNESS_M.get(material.name, 1e-3)


def _mirror(material: Material) -> float:
    """Amplitude reflected squarely by a half-space."""
    impedance = material.density_ratio * material.sound_speed_ratio
    return abs(impedance - 1.0) / (impedance + 1.0)


def _form(thing: _Thing, material: Material, band: Band) -> float:
    if thing.solid.kind != "sphere":
        return 0.0
    a = thing.solid.radius
    if 2.0 * math.pi * band.frequency_hz / NOMINAL_SOUND_SPEED * a > _LARGE_KA or _mirror(material) == 0.0:
        return 0.5 * a * _mirror(material)
    lines = np.maximum(band.frequency_hz + band.bandwidth_hz * np.linspace(-0.5, 0.5, _LINES), 1.0)
    filling, factor = None, _mirror(material)
    if material.name in _SHEAR_MPS:
        shear = _SHEAR_MPS[material.name] / NOMINAL_SOUND_SPEED
        filling, factor = Filling(material.density_ratio, material.sound_speed_ratio, shear), 1.0
    form = sphere_form(a, lines, filling, sound_speed=NOMINAL_SOUND_SPEED)
    return float(np.sqrt((np.abs(form) ** 2).mean())) * factor


def _quaternion(axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """(w, x, y, z) of a rotation matrix, by its largest component."""
    m = axes
    squares = np.array([
        1 + m[0, 0] + m[1, 1] + m[2, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2],
        1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2],
    ])  # fmt: skip
    k = int(squares.argmax())
    q = np.array([
        [squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], squares[1], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
        [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], squares[2], m[1, 2] + m[2, 1]],
        [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[3]],
    ])[k]  # fmt: skip
    return np.asarray(q / np.linalg.norm(q))


def is_smooth(things: Targets) -> bool:
    """Whether anything sends back a coherent echo."""
    smooth, kind, mirror = (np.array(v) for v in (things.smooth, things.kind, things.mirror))
    return bool(((smooth < _ROUGH) & (kind != OTHER) & (mirror > 0.0)).any())
