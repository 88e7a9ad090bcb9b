"""The water that a mission went through: the current on a map, and current, temperature, salinity and tracers in a
vertical section along the track.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos import jit
from pelagos.drawing.water import MATTER, SALT, SPEEDS, WARMTH, sampled
from pelagos.report import theme
from pelagos.report.ground import Relief, relief
from pelagos.report.mission import Mission
from pelagos.report.track import around

Values = NDArray[np.float64]

_ARROWS: Final = 24  # of a map's longer side
_COLOURS: Final = 160  # of a map's or section's longer side
_DOWN: Final = 90  # rows of a section
_STILL_M: Final = 20.0  # who goes less far has a section over time
_SLOW: Final = 0.02  # of the speed: a current that changes less in the mission is drawn once


@dataclass(frozen=True)
class Section:
    """A vertical sheet of water along the track, seen when the vehicle passed.

    Attributes:
        along: `(c,)`, way [m] or time [s].
        label: of the axis.
        depth: `(r,)` [m].
        place: `(c, 2)` NWU [m]; time: `(c,)` [s]; vehicle, bed: depth `(c,)` [m].
    """

    along: Values
    label: str
    depth: Values
    place: Values
    time: Values
    vehicle: Values
    bed: Values

    def sampled(self, field: Callable[[Any, Any], Any]) -> Values:
        """A field of the ocean at every point: `(r, c)`, or `(r, c, 3)` for vectors; NaN well below the bed."""
        rows, columns = len(self.depth), len(self.along)
        position = np.empty((rows, columns, 3))
        position[..., :2], position[..., 2] = self.place, -self.depth[:, None]
        found = sampled(field, position.reshape(-1, 3), np.tile(self.time, rows)).reshape(rows, columns, -1)
        found[self.depth[:, None] > self.bed + 2 * self.depth[1]] = np.nan  # the bed is drawn over the edge
        return found[..., 0] if found.shape[-1] == 1 else found


def current_figure(mission: Mission, world: Any, ocean: Any) -> tuple[Figure, str] | None:
    """Map and section of the current with a caption; None where the ocean has none."""
    if not ocean.currents:
        return None
    motion = mission.motion
    depth = float(np.median(-motion.position[:, 2]))
    low, high = around(motion.position[:, :2], np.asarray(world.bounds)[:, :2], margin=0.3)
    ground = relief(world, low, high)
    times = [float(motion.t[0]), float(motion.t[-1])]
    maps = [_map_of(ocean, low, high, depth, t) for t in times]
    change = _largest(np.linalg.norm(maps[1][2] - maps[0][2], axis=-1))
    fastest = _largest(*(np.linalg.norm(m[2], axis=-1) for m in maps))
    if change <= max(_SLOW * fastest, 1e-6):
        maps, times = maps[:1], times[:1]
    section = section_along(mission, world)
    flow = section.sampled(ocean.current)
    norm = Normalize(0.0, max(_largest(*(np.linalg.norm(m[2], axis=-1) for m in maps), _speed(flow)), 1e-3))
    with theme.style():
        drawn, panels, bottom = _sheet(len(maps), float((high - low)[1] / (high - low)[0]))
        for axes, field, t in zip(panels, maps, times, strict=True):
            _draw_map(axes, field, norm, ground, mission)
            axes.set_title(f"at {depth:.1f} m depth" + (f", t = {t:.0f} s" if len(maps) > 1 else ""))
        for axes in panels[1:]:
            axes.set_ylabel("")
        _bar(panels, norm, SPEEDS, "speed [m/s]")
        _draw_section(bottom, section, _speed(flow), norm, SPEEDS)
        _arrows_in_section(bottom, section, flow)
        bottom.set_title("along the track; arrows as on a map, north up")
    caption = (
        f"The water's velocity without the waves' motion; up to {norm.vmax:.2f} m/s. "
        f"{'The current changes during the mission: its start and its end. ' if len(maps) > 1 else ''}"
        "The section shows each place when the vehicle passed it; the white line is the vehicle."
    )
    return drawn, caption


def water_figure(mission: Mission, world: Any, ocean: Any, scenario: Mapping[str, Any]) -> tuple[Figure, str] | None:
    """Sections of what the scenario lets vary in the water: temperature, salinity, tracers; None where nothing does."""
    said = scenario.get("ocean", {})
    varying = [
        (title, getattr(ocean, name), colours)
        for key, name, title, colours in (
            ("temperature_c", "temperature", "temperature [°C]", WARMTH),
            ("salinity", "salinity", "practical salinity", SALT),
        )
        if isinstance(said.get(key), list | dict)
    ]
    if varying:
        varying.append(("speed of sound [m/s]", ocean.sound_speed, theme.DEPTHS))
    varying += [(name, partial(ocean.tracer, name), MATTER) for name in ocean.tracers]
    if not varying:
        return None
    section = section_along(mission, world)
    drawn_fields = [(title, section.sampled(field), colours) for title, field, colours in varying]
    drawn_fields = [f for f in drawn_fields if f[0] not in ocean.tracers or _differs(f[1])]
    if not drawn_fields:
        return None
    with theme.style():
        drawn = theme.figure(11.4, 2.35 * len(drawn_fields) + 0.3)
        panels = drawn.subplots(len(drawn_fields), 1, squeeze=False, sharex=True)[:, 0]
        for axes, (title, values, colours) in zip(panels, drawn_fields, strict=True):
            norm = _between(values)
            _draw_section(axes, section, values, norm, colours)
            axes.label_outer()
            _bar([axes], norm, colours, title)
    return (
        drawn,
        "Along the track, from the surface to the seabed, when the vehicle passed. The white line is the vehicle.",
    )


def water_statistics(mission: Mission, ocean: Any) -> dict[str, Any]:
    """Statistics of the water along the vehicle's way: least, mean and greatest value of each field."""
    motion = mission.motion
    pick = np.linspace(0, len(motion.t) - 1, min(len(motion.t), 400)).astype(int)
    place, t = motion.position[pick], motion.t[pick]
    fields: dict[str, Callable[[Any, Any], Any]] = {
        "temperature_c": ocean.temperature, "salinity": ocean.salinity, "sound_speed_mps": ocean.sound_speed,
        **{name: partial(ocean.tracer, name) for name in ocean.tracers},
    }  # fmt: skip
    found = {name: sampled(field, place, t)[:, 0] for name, field in fields.items()}
    if ocean.currents:
        found["current_mps"] = np.linalg.norm(sampled(ocean.current, place, t), axis=-1)
    return {
        name: {"least": float(v.min()), "mean": float(v.mean()), "greatest": float(v.max())}
        for name, v in found.items()
    }


def gridded_files(mission: Mission, ocean: Any) -> list[dict[str, Any]]:
    """Fields from files along the way: what, file, policy beyond its grid, and the share of the way out there."""
    motion = mission.motion
    place, t = jit.Array3f64(np.ascontiguousarray(motion.position.T)), jit.Float64(np.ascontiguousarray(motion.t))
    found = []
    for name, grid in ocean.grids:
        share = float(np.broadcast_to(np.array(grid.beyond(place, t)), motion.t.shape).mean())
        found.append({"field": name, "file": grid.source, "outside": grid.outside, "share_beyond": share})
    return found


def files_text(files: list[dict[str, Any]]) -> str:
    """A sentence a file; empty without files."""
    held = {"clamp": "the value at the edge held there", "fade": "the field went to zero there"}
    return "".join(
        f" {f['field'].capitalize()} from {f['file']} (outside: {f['outside']})"
        + (f": {100 * f['share_beyond']:.0f} % of the way lay beyond it, {held.get(f['outside'], 'no value')}."
           if f["share_beyond"] > 0 else ", which covers the whole way.")
        for f in files
    )  # fmt: skip


def section_along(mission: Mission, world: Any) -> Section:
    """The sheet under the track: by the way made good, or by time for a vehicle that stays where it is."""
    motion = mission.motion
    steps = np.linalg.norm(np.diff(motion.position[:, :2], axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    if way[-1] > _STILL_M:
        along, scale = np.linspace(0.0, way[-1], _COLOURS), 1000.0 if way[-1] > 5000 else 1.0
        t, label = np.interp(along, way, motion.t), "way [km]" if scale > 1 else "way [m]"
    else:
        scale, label = theme.time_axis(float(motion.t[-1]))
        t = along = np.linspace(motion.t[0], motion.t[-1], _COLOURS)
    place = np.stack([np.interp(t, motion.t, motion.position[:, k]) for k in range(3)], axis=-1)
    bed = -np.asarray(world.height(place[:, 0], place[:, 1]), dtype=np.float64)
    bed = np.where(np.isfinite(bed), bed, np.inf)
    deepest = max(float(-motion.position[:, 2].min()), 3.0)
    bottom = float(min(bed[np.isfinite(bed)].max(initial=0.0) or np.inf, 4 * deepest))
    depth = np.linspace(0.0, 1.04 * bottom, _DOWN)
    return Section(along / scale, label, depth, place[:, :2], t, -place[:, 2], bed)


def _map_of(ocean: Any, low: Values, high: Values, depth: float, t: float) -> tuple[Values, Values, Values]:
    """East `(w,)`, north `(h,)` [m], and the current `(h, w, 3)` NWU [m/s]."""
    step = float((high - low).max()) / _COLOURS
    north, east = np.arange(low[0], high[0], step), np.arange(-high[1], -low[1], step)
    x, y = np.meshgrid(north, -east, indexing="ij")
    position = np.stack([x.ravel(), y.ravel(), np.full(x.size, -depth)], axis=-1)
    return east, north, sampled(ocean.current, position, np.full(x.size, t)).reshape(*x.shape, 3)


def _draw_map(
    axes: Axes, field: tuple[Values, Values, Values], norm: Normalize, ground: Relief, mission: Mission
) -> None:
    east, north, flow = field
    extent = (float(east[0]), float(east[-1]), float(north[0]), float(north[-1]))
    axes.imshow(_speed(flow), origin="lower", extent=extent, cmap=SPEEDS, norm=norm, interpolation="bilinear")
    if np.nanmax(ground.height, initial=-np.inf) - np.nanmin(ground.height, initial=np.inf) > 0.5:
        axes.contour(
            ground.east, ground.north, ground.height, levels=7, colors=theme.INK, linewidths=0.4, alpha=0.35,
            linestyles="solid",
        )  # fmt: skip
    dark = np.zeros((*ground.structure.shape, 4))
    dark[ground.structure] = (0.30, 0.33, 0.36, 1.0)
    dark[np.nan_to_num(ground.height, nan=-1.0) > 0] = (0.79, 0.72, 0.61, 1.0)
    axes.imshow(dark, origin="lower", extent=ground.extent, interpolation="nearest")
    every = max(1, max(len(east), len(north)) // _ARROWS)
    half = every // 2
    u, v = -flow[half::every, half::every, 1], flow[half::every, half::every, 0]
    axes.quiver(
        east[half::every], north[half::every], u, v, color=theme.INK, pivot="mid", width=0.0032, angles="xy",
        scale_units="xy", scale=float(norm.vmax or 1.0) / (0.95 * every * float(east[1] - east[0])),
    )  # fmt: skip
    place = mission.motion.position
    axes.plot(-place[:, 1], place[:, 0], color=theme.INK, linewidth=3.4, solid_capstyle="round")
    axes.plot(-place[:, 1], place[:, 0], color="white", linewidth=1.8, solid_capstyle="round")
    axes.plot(-place[0, 1], place[0, 0], "o", color="white", markeredgecolor=theme.INK, markersize=6)
    axes.set_xlim(extent[:2])
    axes.set_ylim(extent[2:])
    axes.grid(visible=False)
    axes.set_aspect("equal")
    axes.set_xlabel("east [m]")
    axes.set_ylabel("north [m]")


def _draw_section(axes: Axes, section: Section, values: Values, norm: Normalize, colours: Colormap) -> None:
    shading: Literal["gouraud", "nearest"] = "gouraud" if np.isfinite(values).all() else "nearest"
    axes.pcolormesh(section.along, section.depth, values, cmap=colours, norm=norm, shading=shading)
    bed = np.minimum(section.bed, section.depth[-1])
    axes.fill_between(section.along, bed, section.depth[-1], color="#c9b79c", linewidth=0)
    axes.plot(section.along, section.vehicle, color=theme.INK, linewidth=2.8)
    axes.plot(section.along, section.vehicle, color="white", linewidth=1.4)
    axes.set_xlim(section.along[0], section.along[-1])
    axes.set_ylim(section.depth[-1], 0.0)
    axes.set_xlabel(section.label)
    axes.set_ylabel("depth [m]")
    axes.grid(visible=False)


def _arrows_in_section(axes: Axes, section: Section, flow: Values) -> None:
    box = axes.get_position()
    count = int(44 * box.width / 0.9)
    columns = np.linspace(0, len(section.along) - 1, max(count, 14)).astype(int)[1:-1]
    rows = np.linspace(0, len(section.depth) - 1, 9).astype(int)[1:-1]
    some = flow[np.ix_(rows, columns)]
    length = max(_largest(_speed(some)), 1e-6)
    axes.quiver(
        section.along[columns], section.depth[rows], -some[..., 1], some[..., 0], color=theme.INK, pivot="mid",
        width=0.0013 * 44 / len(columns), scale_units="width", scale=len(columns) * length, headwidth=4,
    )  # fmt: skip


def _sheet(maps: int, wide: float) -> tuple[Figure, list[Axes], Axes]:
    """Maps `wide` times as wide as high in a row, and a section below; beside it where one high map leaves room."""
    if maps == 1 and wide < 1.3:
        width = min(5.0 * wide, 5.2)
        drawn = theme.figure(11.4, width / wide + 0.4)
        cells = drawn.add_gridspec(1, 2, width_ratios=[width + 0.9, 10.5 - width])
        return drawn, [drawn.add_subplot(cells[0])], drawn.add_subplot(cells[1])
    height = min((10.0 / maps) / wide, 5.6)
    drawn = theme.figure(11.4, height + 3.0)
    cells = drawn.add_gridspec(2, maps, height_ratios=[height, 2.4])
    return drawn, [drawn.add_subplot(cells[0, k]) for k in range(maps)], drawn.add_subplot(cells[1, :])


def _bar(axes: list[Axes], norm: Normalize, colours: Colormap, label: str) -> None:
    bar = axes[0].figure.colorbar(ScalarMappable(norm, colours), ax=axes, aspect=28, pad=0.012)
    bar.set_label(label)
    bar.outline.set_visible(False)


def _differs(values: Values) -> bool:
    """Whether a field is not the same everywhere, to rounding."""
    low, high = float(np.nanmin(values, initial=np.inf)), float(np.nanmax(values, initial=-np.inf))
    return high - low > 1e-9 * max(abs(low), abs(high))


def _between(values: Values) -> Normalize:
    """Colours for all values; a field that is the same everywhere has some room about it."""
    if not np.isfinite(values).any():
        return Normalize(0.0, 1.0)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.5 * max(1e-3, 1e-4 * abs(low)) if high - low < max(1e-3, 1e-4 * abs(low)) else 0.0
    return Normalize(low - room, high + room)


def _speed(flow: Values) -> Values:
    return np.asarray(np.linalg.norm(flow, axis=-1))


def _largest(*values: Values) -> float:
    finite = [float(v[np.isfinite(v)].max(initial=0.0)) for v in values]
    return max(finite)
