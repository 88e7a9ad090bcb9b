"""Samples as panels of the page: a picture each, and the numbers below it."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.colours import DEPTHS, painted, shades
from pelagos.drawing.sample import Sample, fan
from pelagos.messages.pictures import jpeg
from pelagos.sensors.sensor import SensorConfig
from pelagos.viewer.hub import Hub

LINES: Final = 240
"""Of a waterfall."""
QUALITY: Final = 80
_INNER: Final = (3, 97)  # percentiles of a swath's depths: the rest are outliers
_LEAST_M: Final = 2.0  # between the ends of a multibeam's colours: noise is not relief
_ROUND: Final = 320  # pixels of a scanning sonar's picture
_PICTURED: Final = (
    "imaging_sonar", "profiling_sonar", "mechanical_scanning_sonar", "sidescan", "singlebeam", "multibeam", "camera",
    "depth_camera", "semantic_camera", "instance_camera", "normal_camera", "optical_flow_camera", "thermal_camera",
    "event_camera", "synthetic_aperture_sonar",
)  # fmt: skip


class Panel:
    """One sensor's picture, made when it is asked for.

    Args:
        config: of the sensor.
    """

    def __init__(self, config: SensorConfig) -> None:
        self._config = config
        self._sample: Sample | None = None
        self._waterfall: NDArray[np.uint8] | None = None
        self._round: NDArray[np.uint8] | None = None
        self._swaths: NDArray[np.float32] | None = None
        self._spans: deque[tuple[float, float]] = deque(maxlen=LINES)
        self.fresh = False

    @property
    def sample(self) -> Sample | None:
        """The newest."""
        return self._sample

    def take(self, sample: Sample) -> None:
        """Keep a sample; lines of a waterfall pile up."""
        self._sample, self.fresh = sample, True
        if sample.line is not None:
            self._waterfall = _piled(self._waterfall, sample.line)
        if sample.swath is not None:
            self._swaths = _piled(self._swaths, sample.swath)
            finite = sample.swath[np.isfinite(sample.swath)]
            if len(finite):
                low, high = np.percentile(finite, _INNER)
                self._spans.append((float(low), float(high)))
        if sample.sector is not None:
            self._sweep(*sample.sector)

    def clear(self) -> None:
        """Begin anew."""
        self._sample = self._waterfall = self._round = self._swaths = None
        self._spans.clear()
        self.fresh = False

    def picture(self) -> NDArray[np.uint8] | bytes | None:
        """`(h, w, 3)`, or a JPEG as it was recorded; None where there is nothing to see."""
        s = self._sample
        if s is None:
            return None
        if s.polar is not None:
            return fan(self._config, s.polar)
        if s.picture is not None:
            return s.picture
        if self._swaths is not None and self.scale is not None:
            low, high = self.scale
            return painted(-self._swaths, -high, -low, DEPTHS)
        return self._waterfall if self._waterfall is not None else self._round

    @property
    def scale(self) -> tuple[float, float] | None:
        """Depths below a multibeam [m] that the first and the last colour of its waterfall stand for."""
        if not self._spans:
            return None
        low, high = min(s[0] for s in self._spans), max(s[1] for s in self._spans)
        middle, half = (low + high) / 2, max((high - low) / 2, _LEAST_M / 2)
        return middle - half, middle + half

    def jpeg(self) -> bytes | None:
        """The picture as it is sent."""
        found = self.picture()
        return jpeg(found, quality=QUALITY) if isinstance(found, np.ndarray) else found

    def _sweep(self, colours: NDArray[np.uint8], angle: float) -> None:
        """Paint one direction of a scanning sonar's round picture; ahead is up, left is left."""
        if self._round is None:
            self._round = np.zeros((_ROUND, _ROUND, 3), dtype=np.uint8)
        half = _ROUND / 2
        width = math.radians(float(getattr(self._config, "step_deg", 2.0)))
        radius = np.arange(0.5, half)
        bins = np.minimum((radius / half * len(colours)).astype(int), len(colours) - 1)
        for turn in np.linspace(angle - width / 2, angle + width / 2, max(3, math.ceil(half * width))):
            row = np.clip((half - radius * math.cos(turn)).astype(int), 0, _ROUND - 1)
            column = np.clip((half - radius * math.sin(turn)).astype(int), 0, _ROUND - 1)
            self._round[row, column] = colours[bins]


def _piled(waterfall: NDArray[Any] | None, line: NDArray[Any]) -> NDArray[Any]:
    """A waterfall with a line more on top."""
    if waterfall is None or waterfall.shape[1] != len(line):
        nothing = np.nan if line.dtype.kind == "f" else 0
        waterfall = np.full((LINES, *line.shape), nothing, dtype=line.dtype)
    waterfall[1:] = waterfall[:-1].copy()
    waterfall[0] = line
    return waterfall


class Panels:
    """All sensors' panels, and what of them goes to the browsers.

    Args:
        sensors: configurations by "agent.sensor".
    """

    def __init__(self, sensors: Mapping[str, SensorConfig]) -> None:
        self.sensors = dict(sensors)
        self.panels = {name: Panel(config) for name, config in sensors.items()}

    def listing(self) -> list[dict[str, Any]]:
        """List of all sensors for the page: JSON types."""
        return [
            {
                "name": name, "kind": c.type, "rate_hz": c.rate_hz, "pictured": c.type in _PICTURED,
                "config": {k: v for k, v in c.model_dump(mode="json").items() if v is not None and k != "type"},
                **({"shades": shades(DEPTHS)} if c.type == "multibeam" else {}),
            }
            for name, c in self.sensors.items()
        ]  # fmt: skip

    def take(self, sample: Sample) -> None:
        """Keep a sample."""
        if sample.name in self.panels:
            self.panels[sample.name].take(sample)

    def clear(self) -> None:
        """Begin anew."""
        for panel in self.panels.values():
            panel.clear()

    def publish(self, hub: Hub, wanted: set[str] | None = None) -> None:
        """Send the panels that changed; pictures only of those that somebody looks at."""
        for name, panel in self.panels.items():
            sample = panel.sample
            if not panel.fresh or sample is None:
                continue
            panel.fresh = False
            pictured = sample.kind in _PICTURED and (wanted is None or name in wanted)
            picture = panel.jpeg() if pictured and hub.count else None
            numbers = {k: _rounded(v) for k, v in sample.numbers.items()}
            header: dict[str, Any] = {
                "type": "panel",
                "name": name,
                "t": sample.t_ns * 1e-9,
                "numbers": numbers,
                "pictured": picture is not None,
            }
            if sample.truth:
                header["truth"] = {k: _rounded(v) for k, v in sample.truth.items()}
            if picture is not None and panel.scale is not None:
                header["bar"] = [round(v, 2) for v in panel.scale]
            hub.publish(f"panel/{name}", header, picture or b"")


def _rounded(value: float) -> float | None:
    return None if not math.isfinite(value) else float(f"{value:.6g}")
