"""Which encoding a sensor's readings get: by the sensor's type."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pelagos.messages.encoding import Encoding, Site
from pelagos.messages.numbers import numbers

ENCODERS: dict[str, Callable[[Any, Site], Encoding]] = {}


def encoder(config: Any, site: Site) -> Encoding:
    """The encoding of a sensor with this configuration; plain numbers where its type has no message of its own."""
    return ENCODERS.get(config.type, numbers)(config, site)
