"""What every kind of world has in its configuration."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel, ConfigDict, Field, field_validator

from pelagos.world.mover import MoverConfig, checked

if TYPE_CHECKING:
    from pelagos.world.world import World


class WorldConfig(BaseModel):
    """A kind of world: frozen data that can build itself. Its own keys stand beside its builder."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    TITLE: ClassVar[str] = ""
    """One line for `pelagos list worlds`."""

    type: str
    """The kind of world: one of `pelagos list worlds`."""
    latitude_deg: float | None = Field(default=None, ge=-90, le=90)
    """WGS 84 latitude of the world's origin [deg]; where not given, the kind of world says."""
    longitude_deg: float | None = Field(default=None, ge=-180, le=180)
    """WGS 84 longitude of the world's origin [deg]; where not given, the kind of world says."""

    movers: tuple[MoverConfig, ...] = ()
    """Bodies that move on scripted paths: ships that pass, schools of fish, swinging chains."""

    @field_validator("movers")
    @classmethod
    def _names(cls, value: tuple[MoverConfig, ...]) -> tuple[MoverConfig, ...]:
        checked(value)
        return value

    def build(self) -> World:
        """Build the world."""
        raise NotImplementedError
