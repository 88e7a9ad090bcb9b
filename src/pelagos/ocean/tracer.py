"""Scalar fields: temperature, salinity, oxygen, a dye, anything that has one number at each place and time.

Components are summed. Positions are world NWU [m], t in seconds; values have whatever unit the quantity has.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal, Protocol, Self, TypeAlias

import drjit as dr
import numpy as np
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.errors import ScenarioError
from pelagos.jit import Array
from pelagos.math.lookup import locate
from pelagos.ocean.analytic_current import TideName, tide_omega
from pelagos.ocean.current import components
from pelagos.ocean.function import find_function
from pelagos.ocean.gridded import GridField, _Gridded
from pelagos.ocean.plume import DriftingPlumeConfig, PlumeConfig
from pelagos.ocean.site import Site
from pelagos.ocean.water_column import ProfileConfig


class ScalarField(Protocol):
    """One component, a Dr.Jit struct."""

    def value(self, position: Array, t: Array) -> Array:
        """`Float64` at `position` (`Array3f64` NWU [m]) and time `t` (`Float64` [s])."""
        ...


class UniformFieldConfig(Strict):
    """The same everywhere and always."""

    type: Literal["uniform"] = "uniform"
    """The kind of field."""
    value: float
    """The value."""

    def build(self, site: Site) -> ScalarField:
        """The component on the device."""
        return UniformField(dr.opaque(jit.Float64, self.value))


@jit.struct
class UniformField:
    """Attributes: constant: `Float64` (1)."""

    constant: Array

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`."""
        return self.constant


class ProfileFieldConfig(ProfileConfig):
    """A table against depth, linear between its rows, held beyond them."""

    type: Literal["profile"] = "profile"
    """The kind of field."""

    def build(self, site: Site) -> ScalarField:
        """The component on the device."""
        field = ProfileField(*(jit.Float64(np.array(a, dtype=np.float64)) for a in (self.depth_m, self.value)))
        jit.align(field)
        return field


@jit.struct
class ProfileField:
    """Attributes: depth [m] and rows, `Float64`, one entry a row."""

    depth: Array
    rows: Array

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`."""
        i, fraction = locate(self.depth, -position[2])
        low = dr.gather(jit.Float64, self.rows, i)
        return low + fraction * (dr.gather(jit.Float64, self.rows, i + 1) - low)


class GradientFieldConfig(Strict):
    """Linear in space: zero at the world's origin."""

    type: Literal["gradient"] = "gradient"
    """The kind of field."""
    per_m: float
    """Change with each metre along the direction [1/m]."""
    towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction of the increase [deg]."""
    per_m_down: float = 0.0
    """Change with each metre of depth [1/m]."""

    def build(self, site: Site) -> ScalarField:
        """The component on the device."""
        north, west = components(self.per_m, self.towards_deg)
        return GradientField(dr.opaque(jit.Array3f64, [north, west, -self.per_m_down]))


@jit.struct
class GradientField:
    """Attributes: slope: `Array3f64` (1) NWU [1/m]."""

    slope: Array

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`."""
        return dr.dot(self.slope, position)


class OscillationFieldConfig(Strict):
    """Goes up and down in time, the same everywhere: a tide, a day."""

    type: Literal["oscillation"] = "oscillation"
    """The kind of field."""
    amplitude: float
    """Half of the range."""
    constituent: TideName | None = None
    """Name of a tidal constituent, which gives the period; or give `period_h`."""
    period_h: float | None = Field(default=None, gt=0)
    """Period [h]; without a constituent."""
    phase_deg: float = 0.0
    """Phase lag: it is highest this much of a turn after t = 0 [deg]."""

    @model_validator(mode="after")
    def _period(self) -> Self:
        tide_omega(self.constituent, self.period_h)
        return self

    def build(self, site: Site) -> ScalarField:
        """The component on the device."""
        values = (self.amplitude, tide_omega(self.constituent, self.period_h), math.radians(self.phase_deg))
        return OscillationField(*(dr.opaque(jit.Float64, v) for v in values))


@jit.struct
class OscillationField:
    """Attributes: `Float64` (1): amplitude, omega [rad/s], phase [rad]."""

    amplitude: Array
    omega: Array
    phase: Array

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`."""
        return self.amplitude * dr.cos(self.omega * t - self.phase)


class PatchFieldConfig(Strict):
    """A Gaussian patch, such as a bloom or a lens of other water."""

    type: Literal["patch"] = "patch"
    """The kind of field."""
    center_m: tuple[float, float, float]
    """Centre: world x (north), y (west), z (up) [m]."""
    radius_m: float = Field(gt=0)
    """Horizontal distance at which 61 % is left (one standard deviation) [m]."""
    height_m: float = Field(gt=0)
    """The same, up and down [m]."""
    value: float
    """Value in the centre."""

    def build(self, site: Site) -> ScalarField:
        """The component on the device."""
        center = dr.opaque(jit.Array3f64, list(self.center_m))
        sharp = [1 / self.radius_m, 1 / self.radius_m, 1 / self.height_m]
        return PatchField(center, dr.opaque(jit.Array3f64, sharp), dr.opaque(jit.Float64, self.value))


@jit.struct
class PatchField:
    """Attributes: center and sharpness: `Array3f64` (1) [m], [1/m]; peak: `Float64` (1)."""

    center: Array
    sharpness: Array
    peak: Array

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`."""
        away = (position - self.center) * self.sharpness
        return self.peak * dr.exp(-0.5 * dr.squared_norm(away))


class FrontFieldConfig(Strict):
    """A front: a step of finite width between two waters."""

    type: Literal["front"] = "front"
    """The kind of field."""
    through_m: tuple[float, float] = (0.0, 0.0)
    """A point of the front: world x (north), y (west) [m]."""
    towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction across the front, in which the value rises [deg]."""
    step: float
    """Difference between far behind and far ahead."""
    width_m: float = Field(gt=0)
    """From 12 % to 88 % of the step (tanh) [m]."""

    def build(self, site: Site) -> ScalarField:
        """The component on the device."""
        values = (*self.through_m, *components(1.0, self.towards_deg), self.step, 2 / self.width_m)
        return FrontField(*(dr.opaque(jit.Float64, v) for v in values))


@jit.struct
class FrontField:
    """Attributes: `Float64` (1): point x, y [m], direction (north, west), step, sharpness [1/m]."""

    x: Array
    y: Array
    north: Array
    west: Array
    step: Array
    sharpness: Array

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`."""
        ahead = (position[0] - self.x) * self.north + (position[1] - self.y) * self.west
        return self.step * 0.5 * (1 + dr.tanh(ahead * self.sharpness))


class GriddedFieldConfig(_Gridded):
    """A variable of a NetCDF file."""

    type: Literal["gridded"] = "gridded"
    """The kind of field."""
    quantity: str | None = None
    """Quantity to read: temperature, salinity, oxygen, chlorophyll, or the variable's own name; where not given, that
    which the field is given for, in `tracers` the tracer's name."""
    variable: str | None = None
    """Name of the variable in the file; found by its standard name where not given."""

    @property
    def quantities(self) -> list[tuple[str, str | None]]:
        """See `GriddedCurrentConfig`."""
        if self.quantity is None and self.variable is None:
            raise ScenarioError("say which quantity to read from the file", where="quantity")
        return [(self.quantity or str(self.variable), self.variable)]

    def build(self, site: Site) -> ScalarField:
        """The component on the device."""
        return GriddedField(self.read(site))


@jit.struct
class GriddedField:
    """Attributes: field: one channel."""

    field: GridField

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`."""
        return self.field.at(position, t)[0]


class PythonFieldConfig(Strict):
    """A field given by a Python function (position, t) -> value."""

    type: Literal["python"] = "python"
    """The kind of field."""
    function: str
    """ "module:function"; takes `Array3f64` NWU [m] and `Float64` [s], gives `Float64`."""

    def build(self, site: Site) -> ScalarField:
        """The component on the device."""
        return FunctionField(find_function(self.function, vector=False))


@dataclass
class FunctionField:
    """Attributes: function: (position, t) -> value."""

    function: Callable[[Array, Array], Array]

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`."""
        return jit.Float64(self.function(position, t))


FieldConfig: TypeAlias = Annotated[
    UniformFieldConfig
    | ProfileFieldConfig
    | GradientFieldConfig
    | OscillationFieldConfig
    | PatchFieldConfig
    | FrontFieldConfig
    | GriddedFieldConfig
    | PythonFieldConfig
    | PlumeConfig
    | DriftingPlumeConfig,
    Field(discriminator="type"),
]

FieldsConfig: TypeAlias = float | ProfileConfig | tuple[FieldConfig, ...]
"""A number, a table against depth, or a list of components that are summed."""


def given_for(value: FieldsConfig, quantity: str) -> FieldsConfig:
    """The same, where files are searched for this quantity unless they say another."""
    if not isinstance(value, tuple):
        return value
    return tuple(
        c.model_copy(update={"quantity": quantity}) if isinstance(c, GriddedFieldConfig) and c.quantity is None else c
        for c in value
    )


def total(fields: list[ScalarField], position: Array, t: Array) -> Array:
    """Sum of all components, `Float64`."""
    value = jit.Float64(0.0)
    for field in fields:
        value = value + field.value(position, t)
    return value


def components_of(value: FieldsConfig) -> tuple[FieldConfig, ...]:
    """A number or a table as components."""
    if isinstance(value, ProfileConfig):
        return (ProfileFieldConfig(depth_m=value.depth_m, value=value.value),)
    return (UniformFieldConfig(value=value),) if isinstance(value, float | int) else value
