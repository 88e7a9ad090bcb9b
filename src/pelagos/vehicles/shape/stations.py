"""Stations of hulls that float, for strip theory."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError
from pelagos.hydro.strips import Station
from pelagos.vehicles.shape.pontoon import PontoonConfig, fullness

Values = NDArray[np.float64]
_PANELS = 60  # of a section: 1 % of its coefficients, see `hydro.section`


def pontoon_stations(hulls: Sequence[PontoonConfig], draught: float, count: int = 16) -> list[Station]:
    """Stations of pontoons at a draught [m], `count` of each hull, from the stern to the bow."""
    found: list[Station] = []
    for hull in hulls:
        edges = np.linspace(-1, 1, count + 1)
        for u in (edges[1:] + edges[:-1]) / 2:
            half = 0.5 * hull.beam_m * float(fullness(np.abs(u), hull.waterplane_coefficient))
            low = np.sin(np.linspace(0, np.pi / 2, 200))
            side = np.stack([half * fullness(low, hull.section_coefficient), -draught * low], axis=-1)
            if hull.section_coefficient == 1.0:  # a flat bottom
                side = np.concatenate([side, [[0.0, -draught]]])
            port = side * [-1, 1]
            points = even_points(np.concatenate([port, side[-2::-1]]))
            x = hull.position_x_m + 0.5 * hull.length_m * float(u)
            found += [Station(x, hull.length_m / count, side, points) for side in hull.sides]
    return sorted(found, key=lambda s: s.position)


def mesh_stations(vertices: Values, faces: NDArray[np.int64], count: int = 16) -> list[Station]:
    """Stations of a closed mesh, FRD [m], that floats at z = 0, from the stern to the bow.

    Raises:
        InputError: no section that crosses the waterline.
    """
    import trimesh

    mesh = trimesh.Trimesh(vertices * [1.0, 1.0, -1.0], faces, process=False)
    waterline = trimesh.intersections.mesh_plane(mesh, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0])
    wet = np.concatenate([mesh.vertices[mesh.vertices[:, 2] <= 0, 0], np.ravel(waterline[..., 0])])
    edges = np.linspace(float(wet.min()), float(wet.max()), count + 1)
    found: list[Station] = []
    for x in (edges[1:] + edges[:-1]) / 2:
        lines = trimesh.intersections.mesh_plane(mesh, [1.0, 0.0, 0.0], [x, 0.0, 0.0])
        for loop in _loops(np.asarray(lines)[..., 1:]):
            for run in _under_water(loop):
                middle = 0.5 * float(run[0, 0] + run[-1, 0])
                points = even_points(run - [middle, 0.0])
                found.append(Station(float(x), float(edges[1] - edges[0]), middle, points))
    if not found:
        raise InputError("the mesh has no section that crosses the waterline: it does not float at z = 0")
    return found


def _loops(lines: Values) -> list[Values]:
    """Closed lines, corners `(n, 2)` each, of straight pieces `(m, 2, 2)` in any order."""
    size = float(np.abs(lines).max(initial=0.0))
    keys = [[tuple(np.round(end / (1e-9 * size)).astype(int).tolist()) for end in line] for line in lines]
    meet: dict[tuple[int, ...], list[int]] = {}
    for i, (a, b) in enumerate(keys):
        if a != b:
            meet.setdefault(a, []).append(i)
            meet.setdefault(b, []).append(i)
    left = {i for i, (a, b) in enumerate(keys) if a != b}
    loops = []
    while left:
        i = left.pop()
        corners, at = [lines[i, 0]], keys[i][1]
        while True:
            corners.append(lines[i, keys[i].index(at)])
            onward = [j for j in meet[at] if j in left]
            if not onward:
                break
            i = onward[0]
            left.remove(i)
            at = keys[i][1] if keys[i][0] == at else keys[i][0]
        loops.append(np.array(corners[:-1]))
    return loops


def _under_water(points: Values) -> list[Values]:
    """Parts `(n, 2)` of a closed line of y and z that lie under water, each from port to starboard."""
    dry = np.flatnonzero(points[:, 1] > 0)
    if len(dry) == 0:
        return []
    points = np.roll(points, -dry[0], axis=0)
    points = np.concatenate([points, points[:1]])
    runs: list[Values] = []
    run: list[Values] = []
    for a, b in pairwise(points):
        if (a[1] > 0) != (b[1] > 0):
            cross = a + (b - a) * a[1] / (a[1] - b[1])
            run.append(np.array([cross[0], 0.0]))
            if b[1] > 0:
                line = np.array(run)
                runs.append(line if line[0, 0] < line[-1, 0] else line[::-1])
                run = []
        if b[1] <= 0:
            run.append(b)
    return runs


def even_points(line: Values) -> Values:
    """A section's line, from waterline to waterline, as points at even distances along it."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    keep = np.concatenate([[True], np.diff(along) > 0])
    at = np.linspace(0, along[-1], _PANELS + 1)
    found = np.stack([np.interp(at, along[keep], line[keep, k]) for k in range(2)], axis=-1)
    found[[0, -1], 1] = 0.0
    return found
