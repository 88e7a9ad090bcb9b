"""`Speaker`: one instrument on a port, and `Place`, where it is."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Any, Final, Protocol

from pelagos.sim.simulation import Simulation

SOUND_MPS: Final = 1500.0
WATER_KG_M3: Final = 1025.0


@dataclass(frozen=True)
class Place:
    """Place of an instrument: the simulation, its agent, its configuration, and the date at simulation time 0."""

    sim: Simulation
    agent: str
    config: Any
    epoch: datetime


class Speaker(Protocol):
    """One instrument.

    Attributes:
        tells_loss: it speaks also when its sensor has measured nothing, as a DVL without bottom lock does.
    """

    tells_loss: bool

    def begin(self) -> None:
        """A run begins, again after a reset: the clock stands at its beginning."""
        ...

    def hear(self, reading: Any) -> bytes:
        """Messages that follow a reading of its sensor."""
        ...

    def answer(self, raw: bytes) -> bytes:
        """Answer to a request."""
        ...


class Silent:
    """An instrument that takes no requests."""

    tells_loss = False

    def __init__(self, place: Place) -> None:
        self.place = place

    def begin(self) -> None:
        """Nothing is kept."""

    def answer(self, raw: bytes) -> bytes:
        """Nothing."""
        return b""
