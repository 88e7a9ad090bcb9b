"""Noise that a vehicle radiates, as sonars near it hear it."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from pelagos.config.strict import Strict

ShipClass: TypeAlias = Literal[
    "fishing", "tug", "naval", "recreational", "government", "cruise", "passenger", "bulker", "containership",
    "vehicle_carrier", "tanker", "dredger", "other",
]  # fmt: skip


class ShipNoise(Strict):
    """A ship's spectrum by class, length and speed through the water, as MacGillivray and de Jong found it (2021)."""

    type: Literal["ship"] = "ship"
    """The kind of noise."""
    ship_class: ShipClass = "other"
    """Class of the ship."""
    length_m: float = Field(gt=0, le=500)
    """Length of the ship [m]."""


class ThrusterNoise(Strict):
    """Propellers whose spectral level is known at one frequency and one speed: it falls by 20 dB a decade of frequency
    and rises by 60 dB a decade of speed through the water; and noise that is there at rest too."""

    type: Literal["thrusters"] = "thrusters"
    """The kind of noise."""
    level_db: float = Field(ge=-50, le=250)
    """Spectral source level at that frequency and speed [dB re 1 uPa^2/Hz at 1 m]."""
    frequency_hz: float = Field(default=10_000.0, gt=0)
    """Frequency at which it is known [Hz]."""
    speed_mps: float = Field(default=1.5, gt=0)
    """Speed through the water at which it is known [m/s]."""
    idle_db: float | None = Field(default=None, ge=-50, le=250)
    """Spectral source level of all that hums at any speed, at the same frequency; absent: nothing does."""


RadiatedNoise: TypeAlias = Annotated[ShipNoise | ThrusterNoise, Field(discriminator="type")]
