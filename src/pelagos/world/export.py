"""A world as files that other programs read, and that Pelagos reads back byte for byte.

`world.npz` holds everything; the world type `saved` reads it. `world.glb` is for Blender, Unreal, USD tools and
browsers: one node for each object, named "instance_name", y up as glTF demands. `labels.json` names labels, instances
and materials.
`height.npz` is the ground: x, y and z; on a survey's own nodes x and y have two axes.
"""

from __future__ import annotations

import json
import zlib
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, ClassVar, Final, Literal
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from pelagos.config.path import ScenarioPath
from pelagos.errors import WorldError
from pelagos.files import whole, write_whole
from pelagos.math.geodesy import GeoOrigin
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.world.bathymetry.nodes import SurveyNodes
from pelagos.world.config import WorldConfig
from pelagos.world.files import read_mesh
from pelagos.world.large.picture import pictured
from pelagos.world.legend import legend
from pelagos.world.material import Material
from pelagos.world.mover import MoverConfig
from pelagos.world.size import refuse_large
from pelagos.world.terrain import HeightField
from pelagos.world.world import World

FORMAT: Final = 2
"""Version of `world.npz`."""


class SavedConfig(WorldConfig):
    """A world that was exported before."""

    TITLE: ClassVar[str] = "A world that was exported before: world.npz"

    type: Literal["saved"] = "saved"
    """The kind of world."""
    path: ScenarioPath
    """Its `world.npz`, relative to the scenario."""

    def build(self) -> World:
        """Read it.

        Raises:
            WorldError: missing, damaged, or of another version.
        """
        world = load(self.path)
        if self.latitude_deg is None or self.longitude_deg is None:
            return world
        return replace(world, origin=GeoOrigin(self.latitude_deg, self.longitude_deg))


def export(world: World, folder: Path, *, t: float = 0.0) -> list[Path]:
    """Write `world.npz`, `world.glb`, `labels.json` and the ground; returns the files.

    Movers stand in the mesh where they are at time t [s]; in `world.npz` they keep their paths.
    """
    folder.mkdir(parents=True, exist_ok=True)
    shown = pictured(world.at_time(t))
    made = [save(world, folder / "world.npz"), save_glb(shown, folder / "world.glb"), folder / "labels.json"]
    write_whole(made[2], json.dumps(legend(shown), indent=1))
    if world.terrain is not None:
        made.append(folder / "height.npz")
        field = world.terrain
        x, y = (field.x, field.y) if not isinstance(field, SurveyNodes) else np.moveaxis(_plan(field), -1, 0)
        with whole(made[3]) as fresh:
            np.savez_compressed(fresh, x=x, y=y, z=field.z)
    return made


def save(world: World, path: Path) -> Path:
    """Write everything about a world into one archive; a large one with the ground that `pictured` gives it."""
    world = pictured(world)
    arrays: dict[str, Any] = {}
    rows: list[dict[str, Any]] = []
    placed = [g for g in world.geometries if isinstance(g, PlacedGeometry)]
    models = {id(g.model): g.model for g in placed}
    number = {key: k for k, key in enumerate(models)}
    for g in world.geometries:
        k = len(rows)
        row: dict[str, Any] = {"name": g.name, "label": g.label, "instance": g.instance}
        if isinstance(g, PlacedGeometry):
            rows.append({**row, "material": g.material, "model": number[id(g.model)], "scale": g.scale})
            continue
        _write_mesh(arrays, f"{k}", g)
        if not isinstance(g.material, int):
            arrays[f"m{k}"] = g.face_materials
        rows.append({**row, "material": g.material if isinstance(g.material, int) else -1})
    for k, model in enumerate(models.values()):
        _write_mesh(arrays, f"_model{k}", model)
    if placed:
        arrays["turn"], arrays["offset"] = np.array([g.turn for g in placed]), np.array([g.offset for g in placed])
    field = world.terrain
    if field is not None:
        arrays["terrain"] = field.z
    if isinstance(field, SurveyNodes):
        arrays["terrain_u"], arrays["terrain_v"] = field.u, field.v
    about = {
        "format": FORMAT,
        "name": world.name,
        "description": world.description,
        "notes": list(world.notes),
        "origin": [world.origin.latitude, world.origin.longitude],
        "user_labels": dict(world.user_labels),
        "materials": [asdict(m) for m in world.materials],
        "geometries": rows,
        "terrain": None if field is None else [field.x0, field.y0, field.spacing],
        "terrain_crs": field.crs if isinstance(field, SurveyNodes) else "",
        "movers": _movers(world, path),
        "terrain_origin": [field.origin.latitude, field.origin.longitude] if isinstance(field, SurveyNodes) else [],
    }
    with whole(path) as fresh:
        np.savez_compressed(fresh, about=np.frombuffer(json.dumps(about).encode(), dtype=np.uint8), **arrays)
    return path


def load(path: Path) -> World:
    """Read what `save` wrote.

    Raises:
        WorldError: missing, damaged, or of another version.
    """
    if not path.is_file():
        raise WorldError(f"saved world {path} does not exist")
    try:
        refuse_large(path, "saved world")
        with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
            about = json.loads(bytes(data["about"]).decode())
            if about["format"] != FORMAT:
                raise WorldError(f"saved world {path} has format {about['format']}; this version reads {FORMAT}")
            geometries = _geometries(data, about["geometries"])
            grid = about["terrain"]
            terrain = None if grid is None else _terrain(data, about)
    except (OSError, ValueError, KeyError, EOFError, TypeError, zlib.error, BadZipFile) as error:
        raise WorldError(f"saved world {path} cannot be read; it may be damaged or cut short ({error})") from error
    materials = tuple(Material(**{**m, "albedo": tuple(m["albedo"])}) for m in about["materials"])
    return World(
        geometries, materials, GeoOrigin(*about["origin"]), about["name"], about["description"], terrain,
        tuple(about["notes"]), about["user_labels"], _read_movers(about.get("movers", []), path),
    )  # fmt: skip


def save_glb(world: World, path: Path) -> Path:
    """Write binary glTF: one node an object and material, metres, y up, x forward; copies of a model share its mesh."""
    import trimesh

    scene = trimesh.Scene()
    up = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])  # z up -> y up
    known: dict[str, str] = {}
    for k, g in enumerate(world.geometries):
        if isinstance(g, PlacedGeometry):
            what = world.materials[int(g.material)]
            shared = f"model_{id(g.model)}_{what.name}"
            if shared not in known:
                known[shared] = f"model_{len(known)}_{what.name}"
                scene.geometry[known[shared]] = _glb_mesh(g.model.vertices, g.model.faces, what)
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = g.scale * g.turn, g.offset
            node = f"{g.instance}_{g.name}_{k}_{what.name}".replace(" ", "_")
            scene.graph.update(node, geometry=known[shared], matrix=up @ matrix)
            continue
        for row in np.unique(g.face_materials):
            what = world.materials[int(row)]
            mesh = _glb_mesh(g.vertices, g.faces[g.face_materials == row], what)
            name = f"{g.instance}_{g.name}_{k}_{what.name}".replace(" ", "_")
            scene.add_geometry(mesh, node_name=name, geom_name=name, transform=up)
    write_whole(path, scene.export(file_type="glb"))
    return path


def _glb_mesh(vertices: NDArray[np.floating], faces: NDArray[np.uint32], what: Material) -> Any:
    import trimesh

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.remove_unreferenced_vertices()
    mesh.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(
            name=what.name,
            baseColorFactor=[*(round(255 * c) for c in what.albedo), 255],
            roughnessFactor=what.optical_roughness,
            metallicFactor=0.0,
        )
    )
    return mesh


def _movers(world: World, path: Path) -> list[dict[str, Any]]:
    """Movers as data; the meshes that they name are written beside the archive."""
    rows = []
    for mover in world.movers:
        row = mover.model_dump(mode="json")
        if mover.body == "file" and mover.file is not None:
            row["file"] = _beside(path, mover.name, mover.file)
        rows.append(row)
    return rows


def _beside(path: Path, name: str, mesh: Path) -> str:
    """A mesh file that goes with the archive; a glTF that keeps its numbers in other files becomes one file."""
    suffix = mesh.suffix if mesh.suffix.lower() != ".gltf" else ".ply"
    target = path.with_name(f"{path.stem}_{name}{suffix}")
    if suffix == mesh.suffix:
        if not (target.exists() and target.samefile(mesh)):
            write_whole(target, mesh.read_bytes())
        return target.name
    import trimesh

    read = read_mesh(mesh)
    write_whole(target, trimesh.Trimesh(read.vertices, read.faces, process=False).export(file_type="ply"))
    return target.name


def _read_movers(rows: list[dict[str, Any]], path: Path) -> tuple[MoverConfig, ...]:
    context = {"folder": path.resolve().parent}
    try:
        return tuple(MoverConfig.model_validate(row, context=context) for row in rows)
    except ValidationError as error:
        raise WorldError(f"saved world {path}: its movers cannot be read ({error})") from error


def _write_mesh(arrays: dict[str, Any], name: str, g: Geometry) -> None:
    arrays[f"v{name}"], arrays[f"f{name}"] = g.vertices, g.faces
    if g.vertex_normals is not None:
        arrays[f"n{name}"] = g.vertex_normals


def _geometries(data: Any, rows: list[dict[str, Any]]) -> tuple[Geometry, ...]:
    models: dict[int, Geometry] = {}
    made: list[Geometry] = []
    turn, offset = data.get("turn"), data.get("offset")
    placed = 0
    for k, row in enumerate(rows):
        what = {"label": row["label"], "instance": row["instance"], "name": row["name"]}
        if "model" not in row:
            material = data[f"m{k}"] if row["material"] < 0 else int(row["material"])
            made.append(Geometry(data[f"v{k}"], data[f"f{k}"], material, vertex_normals=data.get(f"n{k}"), **what))
            continue
        m = row["model"]
        if m not in models:
            models[m] = Geometry(data[f"v_model{m}"], data[f"f_model{m}"], 0, 0, 0, data.get(f"n_model{m}"))
        made.append(
            PlacedGeometry(
                models[m],
                turn=turn[placed],
                scale=row["scale"],
                offset=offset[placed],
                material=row["material"],
                **what,
            )
        )
        placed += 1
    return tuple(made)


def _terrain(data: Any, about: dict[str, Any]) -> HeightField:
    x0, y0, spacing = about["terrain"]
    if not about.get("terrain_crs"):
        return HeightField(x0, y0, spacing, data["terrain"])
    origin = GeoOrigin(*about["terrain_origin"])
    u, v = data["terrain_u"], data["terrain_v"]
    return SurveyNodes(x0, y0, spacing, data["terrain"], origin, about["terrain_crs"], u, v)


def _plan(field: HeightField) -> NDArray[np.float64]:
    """`(nx, ny, 2)` where the nodes stand [m]."""
    return field.vertices()[:, :2].reshape(*field.z.shape, 2)
