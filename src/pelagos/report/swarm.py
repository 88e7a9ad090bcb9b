"""Groups of vehicles in a report: one section for a swarm, in place of a page for each of its members."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos.messages.navigation import WRENCH, WRENCH_FIELDS
from pelagos.report import theme
from pelagos.report.ground import depth_norm, draw_ground, relief
from pelagos.report.mission import Mission
from pelagos.report.movers import draw_movers, mover_tracks
from pelagos.report.page import Section, image, table
from pelagos.report.track import around

FEWEST: Final = 5  # members from which on a group is drawn as one
_CELLS: Final = 60  # of the map of density, along its longer side
_MOST_LINES: Final = 400  # tracks drawn
_TOUCH_N: Final = 1e-3  # force from which on a collision sensor tells of a contact


@dataclass(frozen=True)
class Swarm:
    """The members of a group.

    Attributes:
        name: of the group in the scenario.
        members: in the scenario's order.
        t: `(k,)` times of the first member [s].
        position: `(k, members, 3)` NWU [m].
        contacts: `(c, 2)` time [s] and number of the member, where a collision sensor began to feel something; None
            where no member carries one.
    """

    name: str
    members: list[Mission]
    t: NDArray[np.float64]
    position: NDArray[np.float64]
    contacts: NDArray[np.float64] | None

    @property
    def nearest(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Distance of each member to its nearest neighbour `(k, members)` [m], and which that is; between origins."""
        from scipy.spatial import cKDTree  # a tenth of the time that all imports take

        # not balanced: see `contact.broad_phase.close_pairs`
        found = [cKDTree(places, balanced_tree=False).query(places, k=2) for places in self.position]
        return np.stack([d[:, 1] for d, _ in found]), np.stack([i[:, 1] for _, i in found])


def swarms(missions: list[Mission]) -> list[Swarm]:
    """The groups of a recording that are drawn as one, in the scenario's order."""
    if not missions:
        return []
    agents = missions[0].scenario.get("agents", {})
    found = []
    for group, entry in agents.items():
        count = (entry or {}).get("count") if isinstance(entry, dict) else None
        names = {f"{group}_{i}" for i in range(count or 0)}
        members = [m for m in missions if m.name in names and len(m.motion.t) > 1]
        if len(members) >= FEWEST:
            t = members[0].motion.t
            found.append(
                Swarm(group, members, t, np.stack([m.motion.at(t).position for m in members], axis=1), _felt(members))
            )
    return found


def _felt(members: list[Mission]) -> NDArray[np.float64] | None:
    """Times at which members' collision sensors began to feel something."""
    carried, begun = False, []
    for number, member in enumerate(members):
        for channel in member.channels("collision", WRENCH):
            carried = True
            t, values = member.recording.table(channel.topic, WRENCH_FIELDS)
            touches = np.linalg.norm(values[:, 2:5], axis=1) > _TOUCH_N
            begins = touches & ~np.concatenate([[False], touches[:-1]])
            begun += [(float(when), float(number)) for when in t[begins]]
    return np.array(sorted(begun)).reshape(-1, 2) if carried else None


def swarm_section(swarm: Swarm, world: Any, numbers: dict[str, Any]) -> Section:
    """Tracks and density, separation over time, the nearest approaches and the contacts of a swarm."""
    away, whom = swarm.nearest
    way = np.linalg.norm(np.diff(swarm.position, axis=0), axis=2).sum(axis=0)
    closest = _approaches(swarm, away, whom)
    said: dict[str, Any] = {
        "members": len(swarm.members), "way_m": {"mean": float(way.mean()), "least": float(way.min())},
        "separation_m": {"least": float(away.min()), "median": float(np.median(away))},
        "nearest_approaches": closest,
    }  # fmt: skip
    if swarm.contacts is not None:
        said["contacts"] = len(swarm.contacts)
    numbers.setdefault("swarms", {})[swarm.name] = said
    text = (
        f"The {len(swarm.members)} members went {way.mean():.0f} m on average, {way.min():.0f} m at least. The nearest "
        f"neighbour of a member was {np.median(away):.1f} m away in the median, {away.min():.1f} m at the least; "
        "distances are between origins. "
    )
    if swarm.contacts is None:
        text += "None carries a collision sensor, so contacts are not known."
    else:
        text += f"Collision sensors felt {len(swarm.contacts)} contacts."
    drawn = _figure(swarm, away, world)
    heads = ["nearest approach", "to", "distance [m]", "at [s]"]
    rows = [[c["member"], c["to"], f"{c['distance_m']:.2f}", f"{c['t_s']:.1f}"] for c in closest]
    body = image(theme.data_uri(theme.as_png(drawn)), f"tracks, density and separation of {swarm.name}")
    return Section(
        f"Swarm {swarm.name}: {len(swarm.members)} vehicles", text, body + table(heads, rows, numbers=(2, 3))
    )


def _approaches(swarm: Swarm, away: NDArray[np.float64], whom: NDArray[np.int64]) -> list[dict[str, Any]]:
    """The five pairs that came nearest, and when."""
    best = np.argmin(away, axis=0)  # of each member
    found: dict[tuple[int, int], dict[str, Any]] = {}
    for member in np.argsort(away[best, np.arange(len(best))], kind="stable"):
        at = int(best[member])
        pair = min(int(member), int(whom[at, member])), max(int(member), int(whom[at, member]))
        one, other = (swarm.members[i].name for i in pair)
        told = {"member": one, "to": other, "distance_m": float(away[at, member]), "t_s": float(swarm.t[at])}
        found.setdefault(pair, told)
    return list(found.values())[:5]


def _figure(swarm: Swarm, away: NDArray[np.float64], world: Any) -> Figure:
    low, high = around(swarm.position[..., :2].reshape(-1, 2), np.asarray(world.bounds)[:, :2], margin=0.08)
    ground = relief(world, low, high)
    with theme.style():
        wide = float((high - low)[1] / (high - low)[0])
        maps = min(max(4.8 / wide, 2.4), 8.0) + 0.9  # [in]
        drawn = theme.figure(11.4, maps + 3.0)
        cells = drawn.add_gridspec(2, 2, height_ratios=[maps, 3.0])
        tracks, dense = drawn.add_subplot(cells[0, 0]), drawn.add_subplot(cells[0, 1])
        if np.isfinite(ground.height).any():
            draw_ground(tracks, ground, depth_norm(ground.height))
        draw_movers(tracks, mover_tracks(swarm.members[0].recording), low, high)
        _tracks(tracks, swarm)
        _density(drawn, dense, swarm, low, high)
        for axes in (tracks, dense):
            axes.set_aspect("equal")
            axes.set_xlim(ground.extent[:2])
            axes.set_ylim(ground.extent[2:])
        _separation(drawn.add_subplot(cells[1, 0]), swarm, away)
        _depths(drawn.add_subplot(cells[1, 1]), swarm)
    return drawn


def _tracks(axes: Axes, swarm: Swarm) -> None:
    east, north = -swarm.position[..., 1], swarm.position[..., 0]
    shown = np.unique(np.linspace(0, east.shape[1] - 1, _MOST_LINES).astype(int))
    thin = min(1.1, max(0.35, 25.0 / len(shown)))
    axes.set_title("tracks")
    axes.plot(east[:, shown], north[:, shown], color=theme.TRUTH, linewidth=thin, alpha=0.75)
    axes.plot(east[-1], north[-1], "o", color="#f2542d", markersize=2.0 + 2.0 * thin, markeredgecolor="white",
              markeredgewidth=0.3, linestyle="none", label="at the end")  # fmt: skip
    if swarm.contacts is not None and len(swarm.contacts):
        who = swarm.contacts[:, 1].astype(int)
        when = np.clip(np.searchsorted(swarm.t, swarm.contacts[:, 0]), 0, len(swarm.t) - 1)
        axes.plot(east[when, who], north[when, who], "x", color=theme.ALARM, markersize=6, label="contacts")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.13), ncols=2)


def _density(drawn: Figure, axes: Axes, swarm: Swarm, low: NDArray[np.float64], high: NDArray[np.float64]) -> None:
    """Density of vehicles: vehicle seconds on a hectare."""
    size = float((high - low).max()) / _CELLS
    edges = [np.arange(low[i], high[i] + size, size) for i in (0, 1)]
    spent = np.repeat(np.gradient(swarm.t), swarm.position.shape[1])
    flat = swarm.position[..., :2].reshape(-1, 2)
    count = np.histogram2d(flat[:, 0], flat[:, 1], bins=edges, weights=spent)[0] / (size * size * 1e-4)
    masked = np.ma.masked_equal(count, 0.0)
    axes.set_title("density")
    axes.set_facecolor(theme.EMPTY)
    picture = axes.pcolormesh(-edges[1], edges[0], masked, cmap="viridis", rasterized=True)
    bar = drawn.colorbar(picture, ax=axes, shrink=0.85, aspect=28, pad=0.015)
    bar.set_label("vehicle seconds on a hectare")
    bar.outline.set_visible(False)
    axes.grid(visible=False)
    axes.set_xlabel("east [m]")


def _separation(axes: Axes, swarm: Swarm, away: NDArray[np.float64]) -> None:
    scale, label = theme.time_axis(float(swarm.t[-1]))
    t = swarm.t / scale
    axes.set_title("distance to the nearest neighbour")
    axes.fill_between(t, *np.quantile(away, (0.05, 0.95), axis=1), color=theme.GRID, linewidth=0, label="nine of ten")
    axes.plot(t, np.median(away, axis=1), color=theme.TRUTH, linewidth=1.5, label="median")
    axes.plot(t, away.min(axis=1), color="#f2542d", linewidth=1.2, label="least")
    if swarm.contacts is not None and len(swarm.contacts):
        when = swarm.contacts[:, 0] / scale
        axes.plot(when, np.zeros(len(when)), "x", color=theme.ALARM, markersize=5, clip_on=False, label="contacts")
    axes.set_ylim(0, 1.25 * float(np.quantile(away, 0.99)))
    axes.set_xlim(t[0], t[-1])
    axes.set_xlabel(label)
    axes.set_ylabel("[m]")
    axes.legend(loc="upper right", ncols=4, columnspacing=1.2)


def _depths(axes: Axes, swarm: Swarm) -> None:
    scale, label = theme.time_axis(float(swarm.t[-1]))
    t, depth = swarm.t / scale, -swarm.position[..., 2]
    axes.set_title("depth")
    axes.fill_between(t, depth.min(axis=1), depth.max(axis=1), color="#e3eff5", linewidth=0, label="all")
    axes.fill_between(t, *np.quantile(depth, (0.05, 0.95), axis=1), color="#a9cfe0", linewidth=0, label="nine of ten")
    axes.plot(t, np.median(depth, axis=1), color=theme.TRUTH, linewidth=1.5, label="median")
    axes.invert_yaxis()
    axes.set_xlim(t[0], t[-1])
    axes.set_xlabel(label)
    axes.set_ylabel("[m]")
    axes.legend(loc="lower right", ncols=3)
