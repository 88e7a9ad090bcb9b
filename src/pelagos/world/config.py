"""Configuration that every kind of world shares."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Protocol, Self, TypeAlias

from pydantic import ConfigDict, Field, field_validator, model_validator

from pelagos.config.described import Described
from pelagos.world.by_hand import ThingConfig
from pelagos.world.mover import MoverConfig, checked

if TYPE_CHECKING:
    from pelagos.world.world import World


Positive: TypeAlias = Annotated[float, Field(gt=0)]
"""Greater than zero."""


class WorldConfig(Described):
    """Keys that every kind of world has: frozen data. Its own keys stand beside its builder, see `WorldKind`."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    TITLE: ClassVar[str] = ""
    """One line for `pelagos list worlds`."""
    PLACES_THINGS: ClassVar[bool] = False
    """Whether `build` places `things` itself; else they are added to what it built."""

    type: str
    """The kind of world: one of `pelagos list worlds`."""
    latitude_deg: float | None = Field(default=None, ge=-90, le=90)
    """WGS 84 latitude of the world's origin [deg]; where not given, the kind of world says."""
    longitude_deg: float | None = Field(default=None, ge=-180, le=180)
    """WGS 84 longitude of the world's origin [deg]; where not given, the kind of world says."""

    things: tuple[ThingConfig, ...] = ()
    """Primitives, mesh files and description files, placed one by one."""
    movers: tuple[MoverConfig, ...] = ()
    """Bodies that move on scripted paths: ships that pass, schools of fish, swinging chains."""
    labels: dict[str, int] = Field(default_factory=dict)
    """Semantic labels of your own, name to number 128 .. 254, for things, movers and what is spawned later."""

    @field_validator("labels")
    @classmethod
    def _free_numbers(cls, value: dict[str, int]) -> dict[str, int]:
        taken = [f"{name}: {number}" for name, number in value.items() if not 128 <= number <= 254]
        if taken:
            raise ValueError(f"labels of your own have numbers 128 .. 254, not {', '.join(taken)}")
        return value

    @field_validator("movers")
    @classmethod
    def _names(cls, value: tuple[MoverConfig, ...]) -> tuple[MoverConfig, ...]:
        checked(value)
        return value

    @model_validator(mode="after")
    def _whole_place(self) -> Self:
        if (self.latitude_deg is None) != (self.longitude_deg is None):
            raise ValueError("latitude_deg and longitude_deg go together")
        return self


class WorldKind(Protocol):
    """Kind of world: a `WorldConfig` that builds itself."""

    PLACES_THINGS: ClassVar[bool]

    @property
    def things(self) -> tuple[ThingConfig, ...]:
        """See `WorldConfig`."""

    @property
    def movers(self) -> tuple[MoverConfig, ...]:
        """See `WorldConfig`."""

    @property
    def labels(self) -> dict[str, int]:
        """See `WorldConfig`."""

    def build(self) -> World:
        """Build the world.

        Raises:
            WorldError: a file cannot be read, or the world cannot be made.
        """
