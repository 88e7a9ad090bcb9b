"""LiDARs as ROS 2 messages: point clouds in which a pulse without an echo is NaN."""

from __future__ import annotations

from typing import Any

import numpy as np

from pelagos.messages.encoding import Encoding, Site, Topic, seconds_nanoseconds
from pelagos.messages.point_cloud import POINT_CLOUD, point_cloud
from pelagos.messages.template import STAMP, Buffer, Template
from pelagos.sensors.sensor import Reading


def lidar(config: Any, site: Site) -> Encoding:
    """PointCloud2 of all pulses, ring after ring; data `(n, channels, steps, 4)`: x, y, z [m], intensity.

    A semantic LiDAR's fourth value is `cosine`, of incidence, and its points have the extras `label` and `instance`
    `(n, channels, steps)` too.
    """
    fourth = "cosine" if config.type == "semantic_lidar" else "intensity"
    templates: dict[tuple[int, ...], Template] = {}

    def encode(reading: Reading, copy: int) -> tuple[Buffer]:
        data = reading.data[copy]
        named = [name for name in ("label", "instance") if name in reading.extras]
        kinds = [
            *((name, "<f4") for name in ("x", "y", "z", fourth)),
            ("ring", "<u2"),
            *((n, "<u4") for n in named),
        ]
        points = np.empty(data.shape[:2], dtype=np.dtype(kinds))
        for i, name in enumerate(("x", "y", "z", fourth)):
            points[name] = data[..., i]
        points["ring"] = np.arange(data.shape[0])[:, None]
        for name in named:
            points[name] = reading.extras[name][copy]
        key = (*data.shape, len(named))
        if key not in templates:
            cloud = point_cloud(site.frame, points.dtype, points.size)
            templates[key] = Template(POINT_CLOUD, cloud, [*STAMP, "data:bytes"])
        return (templates[key].encode(*seconds_nanoseconds(reading.t_ns), points.tobytes()),)

    return Encoding((Topic("points", POINT_CLOUD),), encode)
