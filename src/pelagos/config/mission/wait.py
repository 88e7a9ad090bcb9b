"""Legs that pass time: hold a course, drift, wait for a fix; and the repetition of legs before."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from pelagos.config.mission.part import BaseLeg, Timed


class Hold(BaseLeg):
    """Go on with heading and depth as they are, for a time."""

    type: Literal["hold"] = "hold"
    """The kind of leg."""
    seconds: float = Field(gt=0)
    """How long [s]."""


class GpsFix(BaseLeg):
    """Wait at the surface for a position fix."""

    type: Literal["gps_fix"] = "gps_fix"
    """The kind of leg."""
    timeout_s: float = Field(default=30.0, gt=0)
    """Go on without a fix after this time [s]."""


class Drift(Timed):
    """Let the water carry the vehicle: no thrust ahead or sideways; thrusters that lift keep the depth."""

    type: Literal["drift"] = "drift"
    """The kind of leg."""


class Repeat(BaseLeg):
    """Do the legs before this one again."""

    type: Literal["repeat"] = "repeat"
    """The kind of leg."""
    times: int = Field(ge=1, le=1000)
    """How many times more."""
    last: int | None = Field(default=None, ge=1)
    """How many legs before this one; all where not given."""
