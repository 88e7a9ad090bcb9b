"""Parts that legs share: level, speed, places on Earth, and a reading that ends a leg."""

from __future__ import annotations

from typing import ClassVar, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pelagos.config.strict import Strict


class EarthPoint(Strict):
    """A place on Earth (WGS 84)."""

    latitude_deg: float = Field(ge=-90, le=90)
    """Geographic latitude, north positive [deg]."""
    longitude_deg: float = Field(ge=-360, le=360)
    """Geographic longitude, east positive [deg]."""


Place = tuple[float, float] | EarthPoint


class Until(Strict):
    """A reading that ends a leg: the sensor's number lies above or below a limit."""

    sensor: str = Field(min_length=1)
    """Name of a sensor that the vehicle carries."""
    value: str | None = None
    """Name of the array of the reading, such as `altitude` of a DVL; its `data` where not given."""
    component: int = Field(default=0, ge=0)
    """Number of the component, from 0, where the reading has several."""
    above: float | None = None
    """The leg ends when the reading is above this, in the sensor's unit."""
    below: float | None = None
    """The leg ends when the reading is below this, in the sensor's unit."""

    @model_validator(mode="after")
    def _limited(self) -> Self:
        if self.above is None and self.below is None:
            raise PydanticCustomError("until", "give 'above', 'below' or both")
        return self


class BaseLeg(Strict):
    """A leg of a mission."""

    type: str
    """The kind of leg."""
    until: Until | None = None
    """A reading that ends the leg before its own end."""


class Levelled(BaseLeg):
    """A leg that is run at one depth, altitude or height; the present one where none is given."""

    NEEDS_LEVEL: ClassVar[bool] = False

    depth_m: float | None = Field(default=None, ge=0)
    """Depth below the mean sea surface [m]; this or `altitude_m`."""
    altitude_m: float | None = Field(default=None, gt=0)
    """Altitude above the seabed, measured by an altimeter or DVL [m]; this or `depth_m`."""
    height_m: float | None = Field(default=None, gt=0)
    """Height above the mean sea surface, for vehicles that fly [m]."""

    @model_validator(mode="after")
    def _one_level(self) -> Self:
        given = [name for name in ("depth_m", "altitude_m", "height_m") if getattr(self, name) is not None]
        if len(given) > 1 or (self.NEEDS_LEVEL and not given):
            how = "neither" if not given else "both" if len(given) == 2 else "all"
            either = "'depth_m' or 'altitude_m'" if "height_m" not in given else "'depth_m', 'altitude_m' or 'height_m'"
            raise PydanticCustomError("level", "give either {either}; {how} given", {"either": either, "how": how})
        return self


class Timed(Levelled):
    """A leg that goes on for a time, or until a reading says that it is over."""

    seconds: float | None = Field(default=None, gt=0)
    """How long [s]; without it, `until` ends the leg."""

    @model_validator(mode="after")
    def _ends(self) -> Self:
        if self.seconds is None and self.until is None:
            raise PydanticCustomError("end", "give 'seconds' or 'until': nothing else ends this leg")
        return self
