"""Camera frames as they were recorded."""

from __future__ import annotations

import io
from typing import Final

import numpy as np
from PIL import Image

from pelagos.messages.pictures import COMPRESSED_IMAGE
from pelagos.report.mission import Mission

FRAMES: Final = 6
_LOOKED_AT: Final = 60


def camera_topics(mission: Mission) -> list[str]:
    """Topics of pictures of colour cameras."""
    return [c.topic for c in mission.channels("camera", COMPRESSED_IMAGE)]


def chosen_pictures(mission: Mission, topic: str, *, count: int = FRAMES) -> list[tuple[float, bytes]]:
    """`(time [s], JPEG)` of the pictures with the most contrast, one from each of `count` parts of the mission."""
    total = mission.recording.count(topic)
    step = max(1, total // _LOOKED_AT)
    rated = []
    for index in range(step // 2, total, step):
        recorded = mission.recording.message(topic, index)
        data = bytes(recorded.message.data)
        rated.append((_contrast(data), recorded.t_ns * 1e-9, data))
    parts = np.array_split(np.arange(len(rated)), min(count, len(rated)))
    best = [max((rated[i] for i in part), key=lambda r: r[0]) for part in parts]
    return [(t, data) for _, t, data in best]


def _contrast(jpeg: bytes) -> float:
    """Spread of brightness of a small copy."""
    picture = Image.open(io.BytesIO(jpeg))
    picture.draft("L", (160, 120))
    return float(np.std(np.asarray(picture.convert("L").resize((80, 60)), dtype=np.float32)))
