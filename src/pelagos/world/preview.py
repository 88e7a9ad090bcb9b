"""Pictures and numbers of a world: a shaded map, views from the air, statistics."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.files import whole
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.world.label import label_color
from pelagos.world.world import World

_SKY = (0.36, 0.45, 0.55)  # radiance of the even light from above, relative
_SUN = (0.62, -0.45, -0.55)  # direction in which the sun's light travels: low, and across the usual view
_PATH_S, _PATH_POINTS = 300.0, 1500  # paths of movers are drawn for this long [s], with this many points
_BLIND_M = 15.0  # from this size of a pixel on, small things are marked on a map [m]
_MOST_FACES = 12_000_000  # of copies in a picture
_LEGEND = 12  # labels that a map names at most


def statistics(world: World) -> dict[str, Any]:
    """Area, heights, objects by name, triangles, memory of the meshes."""
    low, high = world.bounds
    names = {g.instance: g.name for g in world.still}
    models = {id(g.model): g.model for g in world.geometries if isinstance(g, PlacedGeometry)}
    size = sum(g.bytes_held for g in (*world.geometries, *models.values()))
    ground = world.terrain.z if world.terrain is not None else np.array([low[2], high[2]])
    return {
        "extent_m": [float(v) for v in high - low],
        "area_m2": float(np.prod((high - low)[:2])),
        "ground_z_m": [float(ground.min()), float(np.median(ground)), float(ground.max())],
        "objects": dict(Counter(names.values()).most_common()),
        "labels": {name: number for number, name in world.labels.items()},
        "materials": [m.name for m in world.materials],
        "triangles": world.triangles,
        "mesh_mb": size / 1e6,
        "latitude_deg": world.origin.latitude,
        "longitude_deg": world.origin.longitude,
        "movers": {m.name: f"{m.body}, {m.path.kind}" for m in (*world.movers, *world.paused)},
        "notes": list(world.notes),
    }


def draw_map(world: World, path: Path, *, pixels: int = 900) -> Path:
    """A map from above: shaded heights, and everything that stands on the ground in the colour of its label.

    Paths of movers are drawn as lines; where `World.at_time` paused them, they are drawn themselves too.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    top, label = look_down(world, pixels)
    low, high = world.bounds
    ground = np.where(np.isfinite(top), top, np.nan)
    gx, gy = np.gradient(np.nan_to_num(ground, nan=float(np.nanmin(ground))))
    step = float((high - low)[0]) / max(ground.shape[0] - 1, 1)
    shade = np.clip(0.75 + 0.35 * (gx - 0.6 * gy) / step, 0.25, 1.0)[..., None]
    figure = Figure(figsize=(10, 8.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    span = [high[1], low[1], low[0], high[0]]  # west is left, north is up
    bare = ground[label == 4] if (label == 4).any() else ground
    limits = {"vmin": float(np.nanmin(bare)), "vmax": float(np.nanpercentile(bare, 99.5))}
    image = axes.imshow(ground[:, ::-1], extent=span, origin="lower", cmap="viridis", **limits)
    things = (label > 0) & (label != 4)
    paint = np.zeros((*label.shape, 4))
    for number in np.unique(label[things]):
        paint[label == number] = [*(c / 255 for c in label_color(int(number))), 1.0]
    axes.imshow(np.dstack([np.zeros((*label.shape, 3)), 0.8 * (1 - shade)])[:, ::-1], extent=span, origin="lower")
    axes.imshow(paint[:, ::-1], extent=span, origin="lower")
    axes.set(xlabel="y, west [m]", ylabel="x, north [m]", title=world.description or world.name)
    figure.colorbar(image, label="height [m]", shrink=0.8)
    _mark_small(axes, world, float((high - low)[:2].max()) / pixels)
    _draw_paths(axes, world)
    axes.set(xlim=span[:2], ylim=span[2:])
    _name_labels(axes, world, label[things], {g.label for g in world.geometries} - {4})
    with whole(path) as fresh:
        figure.savefig(fresh, dpi=110, bbox_inches="tight")
    return path


def _draw_paths(axes: Any, world: World) -> None:
    """The way of each mover over its first minutes, its name at the place where it is on the map first."""
    low, high = world.bounds[:, :2]
    for mover in (*world.movers, *world.paused):
        way = np.stack([mover.pose(t).position for t in np.linspace(0.0, _PATH_S, _PATH_POINTS)])
        axes.plot(way[:, 1], way[:, 0], color="white", linewidth=2.2, alpha=0.7)
        axes.plot(way[:, 1], way[:, 0], color="#c0392b", linewidth=1.1, linestyle=(0, (4, 2)))
        inside = ((way[:, :2] > low) & (way[:, :2] < high)).all(axis=1)
        if inside.any():
            x, y = way[int(np.argmax(inside)), :2]
            box = {"boxstyle": "round,pad=0.15", "facecolor": "white", "alpha": 0.75, "linewidth": 0}
            offset = {"xytext": (4, 4), "textcoords": "offset points"}
            axes.annotate(mover.name, (y, x), fontsize=8, color="#7b241c", clip_on=True, bbox=box, **offset)


def _mark_small(axes: Any, world: World, pixel: float) -> None:
    """Circles where things stand that are too small to be seen; one for those that would share it."""
    drawn: set[tuple[int, int, int]] = set()
    for g in world.geometries:
        if g.label == 4 or not len(g.faces) or pixel < _BLIND_M:
            continue
        low, high = g.extent[:, :2]
        x, y = (low + high) / 2
        key = (g.label, round(x / (8 * pixel)), round(y / (8 * pixel)))
        if float((high - low).max()) < 3 * pixel and key not in drawn:
            drawn.add(key)
            color = [c / 255 for c in label_color(g.label)]
            axes.plot(y, x, "o", color=color, markersize=6, markeredgecolor="white", markeredgewidth=0.8)


def _name_labels(axes: Any, world: World, seen: NDArray[np.uint32], known: set[int]) -> None:
    """A legend of the labels on the map, those of the largest area first, then those that are too small to be seen."""
    from matplotlib.patches import Patch

    numbers, area = np.unique(seen, return_counts=True)
    ordered = [int(n) for n in numbers[np.argsort(-area, kind="stable")]]
    ordered = [*ordered, *sorted(known - set(ordered))][:_LEGEND]
    patches = [Patch(color=[c / 255 for c in label_color(n)], label=world.labels.get(n, str(n))) for n in ordered]
    if patches:
        axes.legend(handles=patches, loc="upper left", bbox_to_anchor=(0, -0.06), ncols=6, fontsize=8, frameon=False)


def look_down(world: World, pixels: int) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """Height `(nx, ny)` [m] of the first thing met from above, NaN where nothing is, and its label."""
    low, high = world.bounds
    step = float((high - low)[:2].max()) / pixels
    x = np.arange(low[0] + step / 2, high[0], step)
    y = np.arange(low[1] + step / 2, high[1], step)
    gx, gy = np.meshgrid(x, y, indexing="ij")
    paused = world.geometries[len(world.still) :]
    top = max([float(high[2]), *(float(g.vertices[:, 2].max()) for g in paused)])
    start = np.stack([gx.ravel(), gy.ravel(), np.full(gx.size, top + 1.0)], axis=1)
    hits = world.cast(start, (0, 0, -1), float(top - low[2] + 10))
    z = np.where(hits.valid, hits.position[:, 2], np.nan)
    return z.reshape(gx.shape), hits.label.reshape(gx.shape)


def render(
    world: World,
    path: Path,
    *,
    eye: ArrayLike | None = None,
    target: ArrayLike | None = None,
    size: tuple[int, int] = (1120, 700),
    samples: int = 32,
    fov_deg: float = 60.0,
    exaggeration: float = 1.0,
) -> Path:
    """A picture in air and daylight, as if the water were drained.

    Args:
        world: the world.
        path: PNG to write.
        eye, target: from where to where [m]; a view over the whole world where not given.
        size: width and height in pixels.
        samples: per pixel.
        fov_deg: horizontal field of view.
        exaggeration: factor on heights above the target.
    """
    from pelagos import jit

    low, high = world.bounds
    middle = (low + high) / 2
    middle[2] = low[2]
    reach = float((high - low)[:2].max())
    at = np.asarray(target if target is not None else middle, dtype=np.float64)
    start = np.asarray(eye if eye is not None else middle + reach * np.array([-0.55, -0.45, 0.38]), dtype=np.float64)
    scene = _drained(world, exaggeration, float(at[2]))
    view = jit.mi.load_dict({
        "type": "perspective", "fov": fov_deg, "near_clip": 1e-5 * reach, "far_clip": 10.0 * reach,
        "to_world": jit.mi.ScalarTransform4f().look_at((start - middle).tolist(), (at - middle).tolist(), [0, 0, 1]),
        "film": {"type": "hdrfilm", "width": size[0], "height": size[1]},
        "sampler": {"type": "independent", "sample_count": samples},
    })  # fmt: skip
    jit.mi.util.write_bitmap(str(path), jit.mi.render(scene, sensor=view, spp=samples), write_async=False)
    return path


def _drained(world: World, exaggeration: float, level: float) -> Any:
    """A Mitsuba scene of the world under sun and sky, about the middle of its foot; heights grow from a level [m]."""
    from pelagos import jit

    low, high = world.bounds
    middle = np.array([*((low + high) / 2)[:2], low[2]])
    description: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 3},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": list(_SKY)}},
        "sun": {
            "type": "directional",
            "direction": list(_SUN),
            "irradiance": {"type": "rgb", "value": [3.4, 3.2, 2.9]},
        },
    }
    for smooth in (True, False):
        for row, what in enumerate(world.materials):
            parts = [
                (g, g.faces if isinstance(g.material, int) else g.faces[g.face_materials == row])
                for g in _shown(world)
                if _smooth(g) == smooth and (g.material == row if isinstance(g.material, int) else row in g.material)
            ]
            if parts:
                description[f"{what.name}_{row}_{smooth}"] = _mesh(parts, middle, what.albedo, exaggeration, level)
    return jit.mi.load_dict(description, parallel=False, optimize=False)


def _shown(world: World) -> list[Geometry]:
    """Contents of a picture: of copies, as many as memory is meant for, evenly spread over their order."""
    placed = [g for g in world.geometries if isinstance(g, PlacedGeometry)]
    faces = sum(len(g.faces) for g in placed)
    if faces <= _MOST_FACES:
        return list(world.geometries)
    kept = {id(g) for g in placed[:: -(-faces // _MOST_FACES)]}
    return [g for g in world.geometries if not isinstance(g, PlacedGeometry) or id(g) in kept]


def _smooth(g: Geometry) -> bool:
    return (g.model if isinstance(g, PlacedGeometry) else g).vertex_normals is not None


def _mesh(
    parts: list[tuple[Any, Any]],
    middle: NDArray[np.float64],
    albedo: tuple[float, float, float],
    exaggeration: float,
    level: float,
) -> Any:
    from pelagos import jit

    starts = np.cumsum([0] + [len(g.vertices) for g, _ in parts[:-1]])
    # z -> level + exaggeration (z - level), less the middle
    stretch = np.array([1.0, 1.0, exaggeration])
    shift = np.array([*middle[:2], level + (middle[2] - level) / exaggeration])
    vertices = np.concatenate([(g.vertices - shift) * stretch for g, _ in parts]).astype(np.float32)
    faces = np.concatenate([f + np.uint32(s) for (_, f), s in zip(parts, starts, strict=True)])
    smooth = parts[0][0].vertex_normals is not None
    properties = jit.mi.Properties()
    diffuse = {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(albedo)}}
    properties["bsdf"] = jit.mi.load_dict({"type": "twosided", "nested": diffuse})
    mesh = jit.mi.Mesh("part", len(vertices), len(faces), has_vertex_normals=smooth, props=properties)
    values = jit.mi.traverse(mesh)
    values["vertex_positions"], values["faces"] = vertices.ravel(), faces.astype(np.uint32).ravel()
    if smooth:
        normals = np.concatenate([g.vertex_normals for g, _ in parts]) / stretch
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        values["vertex_normals"] = (normals / np.maximum(length, 1e-12)).astype(np.float32).ravel()
    values.update()
    return mesh
