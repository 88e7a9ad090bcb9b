"""A picture from behind a vehicle, drawn with the world's own rays: no browser, no graphics card."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from pelagos.drawing.colours import DEPTHS, display, painted
from pelagos.vehicles.vehicle import Vehicle
from pelagos.viewer.frame import ShownPose
from pelagos.viewer.hull import model_3d
from pelagos.world.world import World

_ACROSS: Final = 0.75  # tangent of half of the width
_SMALL: Final = 4  # a ray for so many pixels along each side
_FAR_M: Final = 90.0
_DIM_M: Final = 28.0  # distance at which 1/e of a colour is left
_SUN: Final = np.array([-0.43, 0.33, 0.84])
_UP, _DOWN = np.array([62.0, 128.0, 152.0]), np.array([6.0, 26.0, 48.0])
_TRACK: Final = (255, 209, 102)


def draw_chase(
    sheet: Image.Image, world: World, poses: Mapping[str, tuple[ShownPose, Vehicle]], agent: str,
    track: Sequence[tuple[float, float]], depths: Sequence[tuple[float, float]],
) -> None:  # fmt: skip
    """Draw world, track and vehicles onto a sheet, from behind `agent`."""
    pose, vehicle = poses[agent]
    length = float(np.ptp(vehicle.hull.vertices[:, 0]))
    heading = -math.radians(pose.euler[2])
    ahead = np.array([math.cos(heading), math.sin(heading), 0.0])
    left = np.array([-ahead[1], ahead[0], 0.0])
    back = 3.2 * length + 2.0
    eye = pose.position - back * ahead + 0.4 * back * left + np.array([0.0, 0.0, 0.4 * back])
    sight = pose.position + 0.6 * length * ahead - eye
    sight /= np.linalg.norm(sight)
    right = np.cross(sight, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    basis = np.stack([right, np.cross(right, sight), sight])
    _background(sheet, world, eye, basis)
    places = np.array([[x, y, -d] for (x, y), (_, d) in zip(track, depths, strict=True)])
    _line(sheet, places, eye, basis)
    for where, what in sorted(poses.values(), key=lambda pair: -float(np.linalg.norm(pair[0].position - eye))):
        _hull(sheet, where, what, eye, basis)


def _background(sheet: Image.Image, world: World, eye: NDArray[np.float64], basis: NDArray[np.float64]) -> None:
    w, h = sheet.width // _SMALL, sheet.height // _SMALL
    u, v = np.meshgrid(np.linspace(-1, 1, w) * _ACROSS, np.linspace(1, -1, h) * _ACROSS * h / w)
    ways = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3) @ basis
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    hits = world.cast(np.broadcast_to(eye, ways.shape), ways, _FAR_M)
    part = np.clip(0.5 + 0.9 * ways[:, 2:], 0, 1)
    colour = (1 - part) * _DOWN + part * _UP
    hit = hits.valid
    if hit.any():
        albedo = np.array([display(m.albedo) for m in world.palette])[hits.material[hit]]
        ground = painted(hits.position[hit, 2], float(world.bounds[0, 2]), 0.0, DEPTHS) / 255.0
        own = np.where((hits.label[hit] == 4)[:, None], ground, albedo)
        light = 0.35 + 0.65 * np.clip(hits.normal[hit] @ _SUN, 0, 1)
        left = np.exp(-hits.t[hit] / _DIM_M)[:, None]
        colour[hit] = 255 * own * light[:, None] * left + colour[hit] * (1 - left)
    small = Image.fromarray(np.clip(colour, 0, 255).reshape(h, w, 3).astype(np.uint8))
    sheet.paste(small.resize(sheet.size, Image.Resampling.BICUBIC))


def _seen(sheet: Image.Image, points: NDArray[np.float64], eye: Any, basis: Any) -> NDArray[np.float64]:
    """`(m, 3)` pixel places and distances along the sight."""
    local = (points - eye) @ basis.T
    depth = np.maximum(local[:, 2], 1e-3)
    scale = sheet.width / (2 * _ACROSS)
    x = sheet.width / 2 + scale * local[:, 0] / depth
    y = sheet.height / 2 - scale * local[:, 1] / depth
    return np.stack([x, y, local[:, 2]], axis=-1)


def _line(sheet: Image.Image, places: NDArray[np.float64], eye: Any, basis: Any) -> None:
    if len(places) < 2:
        return
    draw, seen = ImageDraw.Draw(sheet), _seen(sheet, places[-600:], eye, basis)
    for a, b in pairwise(seen):
        if a[2] > 0.2 and b[2] > 0.2:
            draw.line([(a[0], a[1]), (b[0], b[1])], fill=_TRACK, width=2)


def _hull(sheet: Image.Image, pose: ShownPose, vehicle: Vehicle, eye: Any, basis: Any) -> None:
    draw = ImageDraw.Draw(sheet)
    triangles = []
    model = model_3d(vehicle)
    parts: list[tuple[Any, Any, tuple[int, int, int]]] = [(p.vertices, p.faces, p.colour) for p in model.still]
    parts += [(p.vertices + p.foot, p.faces, p.colour) for p in model.turning]
    for vertices, faces, colour in parts:
        world = pose.to_world(vertices)
        seen, corners = _seen(sheet, world, eye, basis)[faces], world[faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        size = np.linalg.norm(normal, axis=1, keepdims=True)
        normal = normal / np.maximum(size, 1e-12)
        away = ((eye - corners[:, 0]) * normal).sum(axis=1)
        normal = np.where(away[:, None] < 0, -normal, normal)
        light = 0.45 + 0.65 * np.clip(normal @ _SUN, 0, 1)
        dim = np.exp(-seen[..., 2].mean(axis=1) / _DIM_M)
        shade = np.clip(np.outer(light * dim, colour) + np.outer(1 - dim, 0.5 * (_UP + _DOWN)), 0, 255).astype(int)
        triangles += [(float(s[:, 2].mean()), s, c) for s, c in zip(seen, shade, strict=True) if (s[:, 2] > 0.1).all()]
    for _, seen, colour in sorted(triangles, key=lambda t: -t[0]):
        draw.polygon([(float(x), float(y)) for x, y, _ in seen], fill=(int(colour[0]), int(colour[1]), int(colour[2])))
