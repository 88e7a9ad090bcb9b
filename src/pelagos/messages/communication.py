"""Modems in recordings: their state as numbers, and every packet with its fate as JSON in std_msgs/String."""

from __future__ import annotations

import json
import math
from typing import Any, Final

from pelagos.messages.encoding import Encoding, Site, Topic
from pelagos.messages.numbers import MULTI_ARRAY, multi_array
from pelagos.messages.store import make, serialize
from pelagos.sensors.sensor import Reading

TEXT: Final = "std_msgs/msg/String"
PACKETS: Final = "packets"
"""Suffix of the topic with packets and fates."""


def modem(config: Any, site: Site) -> Encoding:
    """Topics: the modem's name with `data`, and "packets": for each packet that came near, what became of it."""

    def encode(reading: Reading, copy: int) -> tuple[bytes, bytes | None]:
        fates = reading.extras["fates"][copy] if "fates" in reading.extras else ()
        text = [_line(f) for f in fates]
        said = serialize(TEXT, make(TEXT, data=json.dumps(text))) if text else None
        return multi_array(reading.data[copy]), said

    return Encoding((Topic("", MULTI_ARRAY), Topic(PACKETS, TEXT)), encode)


def _line(reception: Any) -> dict[str, Any]:
    values = {name: getattr(reception, name) for name in type(reception).__dataclass_fields__}
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in values.items()}
