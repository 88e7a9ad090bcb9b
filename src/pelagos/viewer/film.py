"""Films of recordings: frame after frame drawn without a browser, and coded by FFmpeg's libraries (PyAV)."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from pelagos.drawing.relief import depth_norm, relief, shaded, tone_of
from pelagos.drawing.sample import CAMERAS, FANS
from pelagos.errors import InputError, LookupFailed, NoRecording
from pelagos.files import whole
from pelagos.sim.replay import Recording
from pelagos.viewer.frame import ShownFrame
from pelagos.viewer.panels import Panels
from pelagos.viewer.replay import Replay, subject_of

Kind = Literal["chase", "camera", "sonar", "panels"]
SUFFIXES: Final = (".mp4", ".mkv", ".mov")
_NIGHT, _CARD, _INK, _MUTED, _TRACK = (5, 15, 26), (14, 36, 56), (232, 241, 247), (143, 169, 189), (255, 209, 102)
_PLOT_S: Final = 60.0
_HEAD: Final = 40  # pixels that the line of numbers takes


@dataclass(frozen=True)
class FilmOptions:
    """Choices of a film.

    Attributes:
        kind: "chase", from behind the vehicle; "camera" or "sonar", one sensor alone; "panels", map, sensors, numbers.
        sensor: of "camera" and "sonar", "auv0.camera" or its own name; the first where empty.
        rate_hz: pictures in a second of the film.
        speed: times the recording's clock.
        size: width and height; both even.
    """

    kind: Kind = "panels"
    sensor: str = ""
    rate_hz: int = 20
    speed: float = 1.0
    size: tuple[int, int] = (1280, 720)


def make_film(
    recording: Path, target: Path, options: FilmOptions, *, progress: Callable[[int, int], None] = lambda done, of: None
) -> int:
    """Write a film; how many pictures it has.

    Args:
        recording: an MCAP file.
        target: .mp4, .mkv or .mov, in a folder that exists.
        options: what is shown.
        progress: called with (pictures done, all).

    Raises:
        InputError: a recording without poses, an unknown sensor.
        OSError: the film cannot be written; nothing is left of it.
    """
    if target.suffix.lower() not in SUFFIXES:
        raise InputError(f"{target}: a film ends in {', '.join(SUFFIXES)}")
    if not target.parent.is_dir():
        raise InputError(f"{target}: give a file in a folder that exists")
    try:
        import av
    except ImportError:
        raise InputError("films need the package av: pip install 'pelagos[viewer]'") from None
    if not 1 <= options.rate_hz <= 120 or not 0.01 <= options.speed <= 1000:
        raise InputError("--rate is 1 to 120 pictures in a second, and --speed 0.01 to 1000 times the clock")
    artist = _Artist(recording, options)
    step_ns = round(1e9 * options.speed / options.rate_hz)
    count = max(1, (artist.replay.last_ns - artist.replay.first_ns) // step_ns + 1)
    with whole(target) as fresh, av.open(str(fresh), "w") as film:
        stream = film.add_stream("libx264", rate=Fraction(options.rate_hz))
        stream.width, stream.height, stream.pix_fmt = *options.size, "yuv420p"
        stream.options = {"crf": "21", "preset": "veryfast"}
        for number in range(count):
            picture = artist.picture(artist.replay.first_ns + number * step_ns)
            for packet in stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")):
                film.mux(packet)
            progress(number + 1, count)
        for packet in stream.encode():
            film.mux(packet)
    return int(count)


class _Artist:
    """Draws the pictures of a film one after the other."""

    def __init__(self, path: Path, options: FilmOptions) -> None:
        recording = Recording(path)
        if not recording.topics("/truth"):
            raise NoRecording(f"{path}: this recording has no poses (no topic ends in /truth)")
        self.options = options
        self.subject, sensors = subject_of(recording)
        self.replay = Replay(recording, sensors)
        self.panels = Panels(sensors)
        self.agent = next(iter(self.replay.courses))
        self._before: int | None = None
        self._track: list[tuple[float, float]] = []
        self._depths: list[tuple[float, float]] = []
        self._names = self._chosen()
        low, high = self.subject.world.bounds[:, :2]
        places = np.concatenate([c.position[:, :2] for c in self.replay.courses.values()])
        margin = 0.2 * max(float(np.ptp(places, axis=0).max()), 20.0)
        self._low = np.maximum(places.min(axis=0) - margin, low)
        self._high = np.minimum(places.max(axis=0) + margin, high)
        ground = relief(self.subject.world, self._low, self._high)
        norm = depth_norm(ground.height)
        self._map = Image.fromarray((255 * shaded(ground, tone_of(ground, norm))[::-1]).astype(np.uint8))

    def picture(self, t_ns: int) -> NDArray[np.uint8]:
        """`(h, w, 3)` of a time."""
        frame = self.replay.frame(t_ns, since_ns=self._before)
        self._before = t_ns
        for placed in frame.samples:
            self.panels.take(placed.sample)
        pose = frame.agents[self.agent]
        self._track.append((float(pose.position[0]), float(pose.position[1])))
        self._depths.append((t_ns * 1e-9, float(-pose.position[2])))
        sheet = Image.new("RGB", self.options.size, _NIGHT)
        match self.options.kind:
            case "chase":
                self._chase(sheet, frame)
                self._numbers(sheet, frame)
            case "panels":
                self._sheet(sheet, frame)
            case _:
                self._sensor(sheet, self._names[0], (0, _HEAD, *self.options.size))
                self._numbers(sheet, frame)
        return np.asarray(sheet)

    def _chosen(self) -> list[str]:
        """The sensors that are shown."""
        kinds = {
            "camera": CAMERAS,
            "sonar": (*FANS, "mechanical_scanning_sonar", "sidescan", "multibeam", "singlebeam"),
        }
        wanted = kinds.get(self.options.kind, (*FANS, *CAMERAS, *kinds["sonar"]))
        able = [n for n, p in self.panels.sensors.items() if p.type in wanted]
        if self.options.kind not in kinds:
            return able
        asked = self.options.sensor
        found = [n for n in able if asked in ("", n, n.partition(".")[2])]
        if not found:
            raise LookupFailed(self.options.kind, asked or "(any)", able)
        return found[:1]

    def _sheet(self, sheet: Image.Image, frame: ShownFrame) -> None:
        """Map and depth on the left, up to four sensors on the right."""
        w, h = sheet.size
        names = self._names[:4]
        split = int(0.42 * w) if names else w
        self._chart(sheet, frame, (8, 48, split - 8, int(0.72 * h)))
        self._plot(sheet, (8, int(0.72 * h) + 8, split - 8, h - 8))
        rows = max(1, -(-len(names) // 2)) if len(names) > 1 else 1
        columns = 2 if len(names) > 1 else 1
        for i, name in enumerate(names):
            x, y = split + (i % columns) * (w - split) // columns, 44 + (i // columns) * (h - 44) // rows
            self._sensor(sheet, name, (x, y, x + (w - split) // columns - 8, y + (h - 44) // rows - 8))
        self._numbers(sheet, frame)

    def _sensor(self, sheet: Image.Image, name: str, box: tuple[int, int, int, int]) -> None:
        x0, y0, x1, y1 = box
        draw = ImageDraw.Draw(sheet)
        found = self.panels.panels[name].picture()
        if found is not None:
            picture = (
                Image.open(io.BytesIO(found)).convert("RGB") if isinstance(found, bytes) else Image.fromarray(found)
            )
            part = min((x1 - x0) / picture.width, (y1 - y0 - 26) / picture.height)
            small = picture.resize((max(1, int(picture.width * part)), max(1, int(picture.height * part))))
            sheet.paste(small, (x0 + (x1 - x0 - small.width) // 2, y0 + 26 + (y1 - y0 - 26 - small.height) // 2))
        titles, scale = [name], self.panels.panels[name].scale
        if scale is not None:
            titles = [f"{name}   {scale[0]:.1f} m (light) to {scale[1]:.1f} m (dark) below it",
                      f"{name}   {scale[0]:.1f} to {scale[1]:.1f} m", name]  # fmt: skip
        fits = [title for title in titles if draw.textlength(title, font=_font(15)) <= x1 - x0 - 12]
        draw.text((x0 + 6, y0 + 6), fits[0] if fits else name, fill=_INK, font=_font(15))

    def _chart(self, sheet: Image.Image, frame: ShownFrame, box: tuple[int, int, int, int]) -> None:
        x0, y0, x1, y1 = box
        part = min((x1 - x0) / self._map.width, (y1 - y0) / self._map.height)
        size = (int(self._map.width * part), int(self._map.height * part))
        left, top = x0 + (x1 - x0 - size[0]) // 2, y0 + (y1 - y0 - size[1]) // 2
        sheet.paste(self._map.resize(size), (left, top))
        draw = ImageDraw.Draw(sheet)
        span = self._high - self._low

        def place(x: float, y: float) -> tuple[float, float]:
            return left + (self._high[1] - y) / span[1] * size[0], top + (self._high[0] - x) / span[0] * size[1]

        if len(self._track) > 1:
            draw.line([place(*p) for p in self._track], fill=_TRACK, width=3)
        for pose in frame.agents.values():
            px, py = place(float(pose.position[0]), float(pose.position[1]))
            draw.ellipse((px - 6, py - 6, px + 6, py + 6), fill=_TRACK, outline=_NIGHT, width=2)

    def _plot(self, sheet: Image.Image, box: tuple[int, int, int, int]) -> None:
        """Depth over the last minute."""
        x0, y0, x1, y1 = box
        draw = ImageDraw.Draw(sheet)
        draw.rectangle(box, fill=_CARD)
        draw.text((x0 + 8, y0 + 4), "depth [m]", fill=_MUTED, font=_font(13))
        last = self._depths[-1][0]
        shown = [(t, d) for t, d in self._depths if t > last - _PLOT_S]
        deepest = max(d for _, d in self._depths) * 1.1 + 0.5

        def x(t: float) -> float:
            return x0 + 40 + (t - last + _PLOT_S) / _PLOT_S * (x1 - x0 - 50)

        def y(d: float) -> float:
            return y0 + 24 + max(d, 0.0) / deepest * (y1 - y0 - 34)

        for d in np.linspace(0, deepest, 4).tolist():
            draw.line((x0 + 40, y(d), x1 - 10, y(d)), fill=(27, 58, 84))
            draw.text((x0 + 8, y(d) - 8), f"{d:.1f}", fill=_MUTED, font=_font(12))
        if len(shown) > 1:
            draw.line([(x(t), y(d)) for t, d in shown], fill=_TRACK, width=2)

    def _numbers(self, sheet: Image.Image, frame: ShownFrame) -> None:
        pose = frame.agents[self.agent]
        text = (
            f"{self.agent}   t {frame.t_ns * 1e-9:7.1f} s   depth {-pose.position[2]:5.1f} m   "
            f"heading {pose.euler[2]:05.1f}°   speed {np.linalg.norm(pose.velocity):4.2f} m/s"
        )
        draw = ImageDraw.Draw(sheet)
        wide = draw.textlength(text, font=_font(15))
        draw.rectangle((10, 10, 26 + wide, 36), fill=_CARD)
        draw.text((18, 14), text, fill=_INK, font=_font(15))

    def _chase(self, sheet: Image.Image, frame: ShownFrame) -> None:
        """From behind and above: ground and hulls as triangles, the farthest first, dimmed by the water."""
        from pelagos.viewer.chase import draw_chase

        poses = {n: (p, self.subject.vehicles[n]) for n, p in frame.agents.items() if n in self.subject.vehicles}
        draw_chase(sheet, self.subject.world, poses, self.agent, self._track, self._depths)


def _font(size: int) -> Any:
    return ImageFont.load_default(size)
