"""Pictures and short tables of objects in a notebook's cell. Every name is text, never HTML."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray
from PIL import Image

from pelagos.drawing.colours import DEPTHS, INTENSITY, display, painted
from pelagos.drawing.relief import depth_norm, relief, shaded, tone_of
from pelagos.drawing.sample import numbers_of
from pelagos.math.frames import enu_to_nwu_np
from pelagos.messages.fan import FanPreview, copper
from pelagos.world.material import material

_WIDE: Final = 420
_MOST: Final = 12  # rows of a table
_FEW: Final = 16  # numbers of a reading that have names
_LEAST_M: Final = 10.0  # side of a picture of tracks
_SUN: Final = np.array([-0.4, -0.45, 0.8])
_TRUE: Final = "#ffd166"
_ARROW: Final = Path([(0, 1), (0.6, -0.8), (0, -0.45), (-0.6, -0.8), (0, 1)])  # to the north


def reading_html(reading: Any) -> str:
    """A reading: its picture, its fan of ranges, or its numbers beside the truth."""
    head = f"{reading.frame}, t = {reading.t_ns * 1e-9:.3f} s, copies: {len(reading.data)}"
    if not np.ravel(reading.valid)[0]:
        return _card(head, "<p>copy 0 has no reading</p>")
    picture = reading_picture(reading)
    if picture is not None:
        return _card(head, _image(picture))
    values, truth = np.asarray(reading.data[0]), np.asarray(reading.truth)[0]
    if values.ndim == 1 and len(values) > _MOST:
        return _card(head, _figure(series_figure(reading)))
    found, true = (numbers_of(reading.kind, v, {}) for v in (values, truth)) if values.size <= _FEW else _first(values)
    rows: list[tuple[str, ...]] = [("", "reading", "truth")]
    rows += [(n, *(f"{v:.6g}" if np.isfinite(v) else "–" for v in (found[n], true[n]))) for n in found]
    return _card(head, _table(rows))


def _first(values: NDArray[Any]) -> tuple[dict[str, float], dict[str, float]]:
    """The first of many numbers, and no truth: it may be of another shape."""
    found = {str(i): float(v) for i, v in enumerate(np.ravel(values)[:_MOST])}
    return found, dict.fromkeys(found, np.nan)


def series_figure(reading: Any) -> Figure:
    """A row of numbers and its truth: a multibeam's ranges as a section across the track, others by their number."""
    values, truth = (np.asarray(v, dtype=np.float64)[0] for v in (reading.data, reading.truth))
    angle = np.ravel(np.asarray(reading.extras.get("angle", ())))
    drawn = Figure(figsize=(6.0, 2.6), layout="constrained")
    FigureCanvasAgg(drawn)
    axes = drawn.subplots()
    for v, style, label in (
        (truth, {"color": "#8a97a6", "lw": 1.6}, "truth"),
        (values, {"color": "#0072b2"}, "reading"),
    ):
        mark = {} if label == "truth" else {"ls": "", "marker": ".", "ms": 3}
        if reading.kind == "multibeam" and len(angle) == len(v):
            axes.plot(v * np.sin(angle), -v * np.cos(angle), label=label, **style, **mark)
        else:
            axes.plot(np.arange(len(v)), v, label=label, **style, **mark)
    if reading.kind == "multibeam" and len(angle) == len(values):
        axes.set(xlabel="across the track, to port [m]", ylabel="below [m]")
        axes.invert_xaxis()
    else:
        axes.set(xlabel="number", ylabel=reading.kind.replace("_", " ") or "reading")
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    return drawn


def reading_picture(reading: Any) -> NDArray[np.uint8] | None:
    """`(h, w, 3)` of the first copy of a reading; None where it is but numbers."""
    data, extras = np.asarray(reading.data[0]), reading.extras
    if data.ndim == 3 and data.shape[-1] == 3 and data.dtype == np.uint8:
        return np.asarray(data)
    if data.ndim == 2 and "azimuth" in extras and "range" in extras:
        azimuth, distance = (
            np.asarray(extras["azimuth"], dtype=np.float64),
            np.asarray(extras["range"], dtype=np.float64),
        )
        half = 0.5 * float(distance[1] - distance[0])
        fan = FanPreview(azimuth, float(distance[0]) - half, float(distance[-1]) + half, data.shape[1])
        return fan(_levels(data))
    if data.ndim == 2 and min(data.shape) == 2:
        return np.asarray(
            np.repeat(copper()[np.concatenate([_levels(data)[0][::-1], _levels(data)[1]])][None], 40, axis=0)
        )
    if data.ndim == 2 and min(data.shape) > 8:
        finite = data[np.isfinite(data)]
        low, high = np.percentile(finite, [1, 99]) if finite.size else (0.0, 1.0)
        return painted(data, float(low), float(high), INTENSITY)
    return None


def world_html(world: Any) -> str:
    """A world: its map and its measures."""
    low, high = world.bounds
    rows = [
        ("size", f"{high[0] - low[0]:.0f} x {high[1] - low[1]:.0f} m"), ("heights", f"{low[2]:.1f} to {high[2]:.1f} m"),
        ("things", str(len(world.geometries))), ("triangles", f"{world.triangles:,}"),
        ("labels", ", ".join(list(world.labels.values())[:_MOST])),
    ]  # fmt: skip
    picture = _figure(map_figure(world)) if bool((high[:2] > low[:2]).all()) else ""
    return _card(world.description or world.name, picture + _table(rows))


def map_figure(world: Any, agents: Mapping[str, tuple[float, float, float]] | None = None) -> Figure:
    """A map of a world, north up.

    Args:
        world: whose ground.
        agents: x, y NWU [m] and heading of the compass [rad] by name.
    """
    ground = relief(world, *world.bounds[:, :2], pixels=_WIDE)
    drawn = Figure(figsize=(6.0, 4.6), layout="constrained")
    FigureCanvasAgg(drawn)
    axes = drawn.subplots()
    if np.isfinite(ground.height).any():
        norm = depth_norm(ground.height)
        axes.imshow(shaded(ground, tone_of(ground, norm)), origin="lower", extent=ground.extent)
        bar = drawn.colorbar(ScalarMappable(norm, DEPTHS), ax=axes, shrink=0.8, pad=0.02)
        bar.set_label("depth [m]")
        bar.formatter = lambda z, _: f"{-z:g}"
        bar.update_ticks()
    axes.set(xlabel="east [m]", ylabel="north [m]", aspect="equal")
    for name, (x, y, heading) in (agents or {}).items():
        arrow = _ARROW.transformed(Affine2D().rotate(-heading))
        axes.plot(-y, x, marker=arrow, ms=13, color=_TRUE, mec="#0c2238", ls="")
        if len(agents or {}) <= _MOST:
            axes.annotate(name, (-y, x), xytext=(8, 6), textcoords="offset points", color="white", fontsize=8,
                          path_effects=[withStroke(linewidth=2.5, foreground="#0c2238")])  # fmt: skip
    return drawn


def vehicle_html(vehicle: Any) -> str:
    """A vehicle: from the side and from above, and what it can be told."""
    size = np.ptp(vehicle.hull.vertices, axis=0)
    rows = [("size", " x ".join(f"{v:.2f}" for v in size) + " m"), ("actuators", ", ".join(vehicle.actuator_names))]
    rows += [(f"mode {m}", ", ".join(vehicle.command_names(m)) or "no numbers") for m in vehicle.modes]
    return _card(f"vehicle {vehicle.name}", _figure(vehicle_figure(vehicle)) + _table(rows[:_MOST]))


def vehicle_figure(vehicle: Any) -> Figure:
    """The hull from port and from above, lit."""
    hull = vehicle.hull
    albedo = np.array([display(material(name).albedo) for name in vehicle.materials])[hull.face_materials]
    corners = np.asarray(hull.vertices, dtype=np.float64)[hull.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    drawn = Figure(figsize=(6.4, 3.6), layout="constrained")
    FigureCanvasAgg(drawn)
    for axes, across, up, sight in zip(drawn.subplots(2, 1), (0, 0), (2, 1), ([0, 1, 0], [0, 0, 1]), strict=True):
        towards = np.array(sight, dtype=np.float64)
        order = np.argsort(corners.mean(axis=1) @ towards, kind="stable")
        light = 0.4 + 0.6 * np.clip(normal[order] @ ((_SUN * [1, -1, 1] + towards) / 1.9), 0, 1)
        faces = PolyCollection(
            list(corners[order][:, :, [across, up]]), facecolors=np.clip(albedo[order] * light[:, None], 0, 1),
            edgecolors="face", linewidths=0.4,  # no seams between triangles
        )  # fmt: skip
        axes.add_collection(faces)
        axes.autoscale_view()
        axes.set(aspect="equal", ylabel=("z [m]", "y [m]")[up == 1])
        axes.spines[["top", "right"]].set_visible(False)
    return drawn


def simulation_html(sim: Any) -> str:
    """A simulation: where its vehicles are."""
    rows = [("agent", "north, west, up [m]", "heading", "speed", "mode")]
    places: dict[str, tuple[float, float, float]] = {}
    for name, s in sim.state.items():
        (x, y, z), turn = (float(v) for v in s.position[0]), float(-s.euler[0, 2])
        places[name] = (x, y, turn)
        if len(rows) <= _MOST:
            heading, speed = round(np.degrees(turn)) % 360, float(np.linalg.norm(s.velocity[0]))
            place = ", ".join(f"{v + 0.0:.1f}" for v in np.round((x, y, z), 1))
            rows.append((name, place, f"{heading:03d}°", f"{speed:.2f} m/s", sim.stepper.mode(name)))
    head = f"{sim.scenario.name}, t = {sim.time_ns * 1e-9:.2f} s, copies: {sim.n}, seed {sim.seed}"
    return _card(
        head, _figure(map_figure(sim.world, places)) + _table(rows) + "<p><code>sim.view()</code> shows it live.</p>"
    )


def recording_html(recording: Any) -> str:
    """A recording: its tracks, and what is in it."""
    topics = recording.topics("/truth")
    pictures = ""
    if topics:
        pictures = _figure(tracks_figure(recording, topics[:_MOST]))
    rows = [("topic", "messages", "type")]
    rows += [(t, str(recording.count(t)), recording.channels[t].type) for t in recording.topics()[:_MOST]]
    return _card(str(recording.path), pictures + _table(rows))


def tracks_figure(recording: Any, topics: Sequence[str]) -> Figure:
    """Tracks from above, and depths over time, of topics with true poses."""
    drawn = Figure(figsize=(7.6, 3.2), layout="constrained")
    FigureCanvasAgg(drawn)
    above, deep = drawn.subplots(1, 2)
    for topic in topics:
        t_s, v = recording.table(topic, [f"pose.pose.position.{axis}:float64" for axis in "xyz"])
        place = enu_to_nwu_np(v)
        (line,) = above.plot(-place[:, 1], place[:, 0], label=topic.rsplit("/", 2)[-2])
        above.plot(-place[0, 1], place[0, 0], "o", ms=4, color=line.get_color())
        deep.plot(t_s, -place[:, 2])
    middles = [float(np.mean(limits)) for limits in (above.get_xlim(), above.get_ylim())]
    half = 0.5 * max(_LEAST_M, *(float(np.ptp(limits)) for limits in (above.get_xlim(), above.get_ylim())))
    above.set(xlabel="east [m]", ylabel="north [m]", aspect="equal")
    above.set(xlim=(middles[0] - half, middles[0] + half), ylim=(middles[1] - half, middles[1] + half))
    deep.set(xlabel="time [s]", ylabel="depth [m]")
    deep.invert_yaxis()
    above.legend(frameon=False, fontsize=8)
    for axes in (above, deep):
        axes.spines[["top", "right"]].set_visible(False)
        axes.ticklabel_format(useOffset=False)
    return drawn


def _levels(data: NDArray[Any]) -> NDArray[np.uint8]:
    """Brightness: of levels from 0 to 1 as they are, of others between their percentiles; dark where there is none."""
    known = data[np.isfinite(data)]
    low, high = 0.0, 1.0
    if known.size and not (float(known.min()) >= 0 and float(known.max()) <= 1):
        low, high = (float(v) for v in np.percentile(known, [2, 99.5]))
    whole = np.nan_to_num(data, nan=low, posinf=high, neginf=low)
    return np.asarray(np.clip((whole - low) / max(high - low, 1e-12), 0, 1) * 255, dtype=np.uint8)


def _image(picture: NDArray[np.uint8]) -> str:
    out = io.BytesIO()
    Image.fromarray(picture).save(out, format="PNG")
    return _inline(out.getvalue())


def _figure(drawn: Figure) -> str:
    out = io.BytesIO()
    drawn.savefig(out, format="png", dpi=110)
    return _inline(out.getvalue())


def _inline(png: bytes) -> str:
    return f'<img style="max-width:{_WIDE + 80}px" src="data:image/png;base64,{base64.b64encode(png).decode()}">'


def _table(rows: Sequence[Sequence[str]]) -> str:
    body = "".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>" for row in rows)
    return f"<table>{body}</table>"


def _card(head: str, body: str) -> str:
    return f"<div><b>{escape(head)}</b><br>{body}</div>"
