"""Pictures and short tables of objects in a notebook's cell. Every name is text, never HTML."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from html import escape
from typing import Any, Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from pelagos.drawing.colours import INTENSITY, display, painted
from pelagos.drawing.relief import depth_norm, relief, shaded, tone_of
from pelagos.math.frames import enu_to_nwu_np
from pelagos.messages.fan import FanPreview, copper
from pelagos.world.material import material

_WIDE: Final = 420
_MOST: Final = 12  # rows of a table
_SUN: Final = np.array([-0.4, -0.45, 0.8])


def reading_html(reading: Any) -> str:
    """A reading: its picture, or its numbers beside the truth."""
    head = f"{reading.frame}, t = {reading.t_ns * 1e-9:.3f} s, copies: {len(reading.data)}"
    picture = reading_picture(reading)
    if picture is not None:
        return _card(head, _image(picture))
    values, truth = np.ravel(reading.data[0])[:_MOST], np.ravel(np.asarray(reading.truth)[0])[:_MOST]
    rows = [("", "reading", "truth")] + [
        (str(i), f"{float(v):.6g}", f"{float(t):.6g}") for i, (v, t) in enumerate(zip(values, truth, strict=False))
    ]
    return _card(head, _table(rows))


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
    picture = _image(map_of(world)) if bool((high[:2] > low[:2]).all()) else ""
    return _card(world.description or world.name, picture + _table(rows))


def map_of(world: Any, track: NDArray[np.float64] | None = None) -> NDArray[np.uint8]:
    """`(h, w, 3)` map of a world, north up, or of the surroundings of a track `(k, 2)` NWU [m] with the track on it."""
    low, high = world.bounds[:, :2]
    if track is not None and len(track):
        room = 0.15 * max(float(np.ptp(track, axis=0).max()), 20.0)
        low, high = np.maximum(track.min(axis=0) - room, low), np.minimum(track.max(axis=0) + room, high)
    ground = relief(world, low, high, pixels=_WIDE)
    finite = bool(np.isfinite(ground.height).any())
    picture = (
        shaded(ground, tone_of(ground, depth_norm(ground.height)))
        if finite
        else np.full((*ground.height.shape, 3), 0.25)
    )
    out = np.ascontiguousarray((255 * picture[::-1]).astype(np.uint8))
    if track is not None and len(track):
        row = np.interp(track[:, 0], [low[0], high[0]], [out.shape[0] - 1, 0]).astype(int)
        column = np.interp(track[:, 1], [low[1], high[1]], [out.shape[1] - 1, 0]).astype(int)
        for dy, dx in ((0, 0), (0, 1), (1, 0), (1, 1)):
            out[np.clip(row + dy, 0, len(out) - 1), np.clip(column + dx, 0, out.shape[1] - 1)] = (255, 209, 102)
    return out


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
        order = np.argsort(corners.mean(axis=1) @ towards)
        light = 0.4 + 0.6 * np.clip(normal[order] @ ((_SUN * [1, -1, 1] + towards) / 1.9), 0, 1)
        faces = PolyCollection(
            list(corners[order][:, :, [across, up]]), facecolors=np.clip(albedo[order] * light[:, None], 0, 1)
        )
        axes.add_collection(faces)
        axes.autoscale_view()
        axes.set(aspect="equal", ylabel=("z [m]", "y [m]")[up == 1])
        axes.spines[["top", "right"]].set_visible(False)
    return drawn


def simulation_html(sim: Any) -> str:
    """A simulation: where its vehicles are."""
    rows = [("agent", "position NWU [m]", "heading", "speed", "mode")]
    for name in list(sim.model.agents)[:_MOST]:
        s = sim.state[name]
        x, y, z = s.position[0]
        heading, speed = np.degrees(-s.euler[0, 2]) % 360, np.linalg.norm(s.velocity[0])
        rows.append((name, f"{x:.1f}, {y:.1f}, {z:.1f}", f"{heading:.0f}°", f"{speed:.2f} m/s", sim.stepper.mode(name)))
    head = f"{sim.scenario.name}, t = {sim.time_ns * 1e-9:.2f} s, copies: {sim.n}, seed {sim.seed}"
    return _card(head, _image(map_of(sim.world)) + _table(rows) + "<p><code>sim.view()</code> shows it live.</p>")


def recording_html(recording: Any) -> str:
    """A recording: its tracks, and what is in it."""
    topics = recording.topics("/truth")
    pictures = ""
    if topics:
        drawn = Figure(figsize=(5.2, 3.4), layout="constrained")
        FigureCanvasAgg(drawn)
        axes = drawn.subplots()
        for topic in topics[:_MOST]:
            _, v = recording.table(
                topic, ["pose.pose.position.x:float64", "pose.pose.position.y:float64", "pose.pose.position.z:float64"]
            )
            place = enu_to_nwu_np(v)
            axes.plot(-place[:, 1], place[:, 0], label=topic.rsplit("/", 2)[-2])
        axes.set(xlabel="east [m]", ylabel="north [m]", aspect="equal")
        axes.legend(frameon=False)
        pictures = _figure(drawn)
    rows = [("topic", "messages", "type")]
    rows += [(t, str(recording.count(t)), recording.channels[t].type) for t in recording.topics()[:_MOST]]
    return _card(str(recording.path), pictures + _table(rows))


def _levels(data: NDArray[Any]) -> NDArray[np.uint8]:
    if float(np.nanmin(data)) >= 0 and float(np.nanmax(data)) <= 1:
        return np.asarray(np.nan_to_num(data) * 255, dtype=np.uint8)
    low, high = np.nanpercentile(data, [2, 99.5])
    return np.asarray(np.clip((np.nan_to_num(data) - low) / max(float(high - low), 1e-12), 0, 1) * 255, dtype=np.uint8)


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
