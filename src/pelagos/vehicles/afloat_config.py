"""Configuration of hulls that float in waves, and coefficients of panel methods for them."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pelagos.config.path import MeshPath
from pelagos.errors import did_you_mean
from pelagos.vehicles.diffraction import DiffractionConfig
from pelagos.vehicles.drift import DriftConfig
from pelagos.vehicles.part import PartConfig, Positive
from pelagos.vehicles.shape.pontoon import PontoonConfig

_CATALOGUE: Final = "pelagos.vehicles.catalogue"
_BEM: Final = ".bem.json"
_Three = tuple[float, float, float]
_Section = tuple[_Three, _Three, _Three]


class TransomConfig(PartConfig):
    """Section at which a hull is cut off astern: sway, heave and roll per length, FRD, over the water's density."""

    position_x_m: float = Field(lt=0, allow_inf_nan=False)
    """Forward of the origin [m]."""
    added_mass_infinite: _Section
    """`(3, 3)` at infinite frequency."""
    damping: tuple[_Section, ...]
    """`(frequencies, 3, 3)`, at those of the hull."""


class RadiationConfig(PartConfig):
    """Coefficients of a panel method about the origin at the waterline, FRD, deep water, over the water's density."""

    source: str
    """Program and version."""
    omega_radps: tuple[Positive, ...] = Field(min_length=4)
    """Frequencies, increasing [rad/s]."""
    added_mass_infinite: tuple[tuple[float, ...], ...]
    """`(6, 6)` at infinite frequency."""
    added_mass: tuple[tuple[tuple[float, ...], ...], ...] = ()
    """`(frequencies, 6, 6)`; not used in the time domain."""
    damping: tuple[tuple[tuple[float, ...], ...], ...]
    """`(frequencies, 6, 6)`."""
    drift: DriftConfig | None = None
    """Mean forces of second order; see `drift` of `afloat`."""
    diffraction: DiffractionConfig | None = None
    """Forces of first order of the waves that the hull scatters; without, added mass times the water's acceleration
    stands for them, which is right for waves longer than the hull."""

    transom: TransomConfig | None = None
    """Section at which the hull is cut off astern, for `forward_speed` of `afloat`; without, it ends in a point."""

    @model_validator(mode="after")
    def _shapes(self) -> Self:
        n = len(self.omega_radps)
        if np.shape(self.added_mass_infinite) != (6, 6) or np.shape(self.damping) != (n, 6, 6):
            raise ValueError(f"added_mass_infinite must be 6 x 6 and damping {n} x 6 x 6, one matrix a frequency")
        if (np.diff(self.omega_radps) <= 0).any():
            raise ValueError("omega_radps must increase")
        if self.transom is not None and np.shape(self.transom.damping) != (n, 3, 3):
            raise ValueError(f"the transom's damping must be {n} x 3 x 3, one matrix a frequency")
        return self


class AfloatConfig(PartConfig):
    """The hull in the water."""

    hulls: tuple[PontoonConfig, ...] = ()
    """All hulls; they carry the vehicle's weight at one draught, and lie level where the origin is at the surface."""
    mesh: MeshPath | None = None
    """Instead of `hulls`, a file with a closed mesh of at most 5000 triangles, forward-left-up [m]; it is moved up or
    down until its wet part carries the weight with the origin at the surface."""
    radiation: str | RadiationConfig | None = None
    """Coefficients, or the catalogue's file of them; without, added mass and damping of the vehicle stand for all."""
    drift: str | DriftConfig | None = None
    """Mean and slowly varying forces of second order: coefficients, or the catalogue's file that has them; without,
    none."""
    forward_speed: Literal["none", "strip"] = "none"
    """Speed ahead in radiation and diffraction, of hulls with `radiation`: none, coefficients of zero speed at the
    frequency of encounter; strip, with the terms of strip theory (Salvesen, Tuck and Faltinsen 1970), at the speed that
    the hull has through the water: slender hulls, Froude numbers up to 0.4."""
    calm_damping: tuple[str, ...] = ()
    """Names of the vehicle's terms that damp as waves do which its motion makes: they hold in calm water, and in waves
    `radiation` stands for them."""
    restoring: Literal["term", "hull"] = "term"
    """Restoring near rest, where the hydrostatic term and the hull's pressure differ: the term's (a measured or
    published stiffness) up to heaves of half the draught and tilts of 15 degrees, or the hull's throughout."""

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if (self.mesh is None) == (not self.hulls):
            raise ValueError("give either hulls or mesh")
        return self

    @model_validator(mode="after")
    def _known(self) -> Self:
        known = sorted(p.name.removesuffix(_BEM) for p in files(_CATALOGUE).iterdir() if p.name.endswith(_BEM))
        for key in ("radiation", "drift"):
            name = getattr(self, key)
            if isinstance(name, str) and name not in known:
                raise ValueError(f"{key} {name!r} is none of {', '.join(known)}{did_you_mean(name, known)}")
        if isinstance(self.drift, str) and _from_catalogue(self.drift).drift is None:
            having = [name for name in known if _from_catalogue(name).drift is not None]
            raise ValueError(f"{self.drift!r} has no drift coefficients that can be trusted; {', '.join(having)} have")
        return self

    @model_validator(mode="after")
    def _speed(self) -> Self:
        found = self.coefficients
        if self.forward_speed == "none":
            given = found is not None and (found.transom or (found.diffraction and found.diffraction.speed_mps))
            if given:
                raise ValueError("radiation has a transom or speeds of diffraction: they need forward_speed: strip")
        elif found is None:
            raise ValueError("forward_speed: strip needs radiation, whose terms it adds to")
        elif found.diffraction is not None and not found.diffraction.speed_mps:
            raise ValueError("forward_speed: strip needs diffraction at speed: give speed_mps there, or no diffraction")
        return self

    @model_validator(mode="after")
    def _stood_for(self) -> Self:
        if self.calm_damping and self.radiation is None:
            raise ValueError("calm_damping needs radiation, which stands for these terms in waves")
        return self

    @property
    def coefficients(self) -> RadiationConfig | None:
        """Read from the catalogue where a name is given."""
        return _from_catalogue(self.radiation) if isinstance(self.radiation, str) else self.radiation

    @property
    def drift_coefficients(self) -> DriftConfig | None:
        """Read from the catalogue where a name is given."""
        return _from_catalogue(self.drift).drift if isinstance(self.drift, str) else self.drift


@cache
def _from_catalogue(name: str) -> RadiationConfig:
    path = files(_CATALOGUE) / f"{name}{_BEM}"
    return RadiationConfig.model_validate(json.loads(path.read_text(encoding="utf-8")))
