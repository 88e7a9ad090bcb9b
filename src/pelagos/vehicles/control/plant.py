"""The plant that control laws are built for."""

from __future__ import annotations

from dataclasses import dataclass

from pelagos.vehicles.model import Model
from pelagos.vehicles.part import Body


@dataclass(frozen=True)
class Plant:
    """A vehicle as its control laws know it.

    Attributes:
        model: its equation of motion.
        body: the constants behind it.
    """

    model: Model
    body: Body
