"""HoloOcean's sensor of biomass, salinity and temperature."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.compat.holoocean.sensor import HoloOceanSensor
from pelagos.ocean.biology import patches, plankton_column, step_column
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.motion import AgentMotion

Field = Callable[..., Any]
_LEAST_M: Final = 0.001  # depth at which biomass begins
_PLANKTON: Final = {
    "surface_biomass": "surface", "max_biomass": "peak", "peak_depth": "peak_m", "width_factor": "width_m",
    "photic_zone_depth": "photic_m", "biocline_sharpness": "sharpness_m", "deep_biomass": "deep",
}  # fmt: skip
_STEPS: Final = {
    "salinity": ("surface_psu", 33.0, "deep_psu", 34.5, "halocline", 100.0, 20.0),
    "temperature": ("surface_temp", 23.0, "deep_temp", 4.0, "thermocline", 100.0, 20.0),
}
_KEYS: Final = frozenset(
    {
        *_PLANKTON, "max_concentration_depth", "biomass_attenuation_exponent", "Sigma", "Cov", "surface_psu",
        "deep_psu", "halocline_depth", "halocline_thickness", "surface_temp", "deep_temp", "thermocline_depth",
        "thermocline_thickness", *(f"{n}_{k}" for n in ("biomass", *_STEPS) for k in ("clusters", "function", "range")),
    }
)  # fmt: skip


class BSTSensor(HoloOceanSensor):
    """Biomass [kg/m^3], salinity [psu] and temperature [deg C] where it is, 0 in the air; there at every tick."""

    sensor_type = "BSTSensor"
    keys = _KEYS
    every_tick = True

    @property
    def data_shape(self) -> Sequence[int]:
        return [3]

    def setup(self) -> None:
        self._noise = self.noise("", 3)
        self.fields: dict[str, Field] = {
            "biomass": self.config.get("biomass_function") or self.biomass_model(**self.config),
            "salinity": self.config.get("salinity_function") or self.salinity_model(**self.config),
            "temperature": self.config.get("temperature_function") or self.temperature_model(**self.config),
        }

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        at = self.point(motion) + self._noise.draw(self.stream)
        return np.array([_finite(field, at) for field in self.fields.values()], dtype=np.float32)

    @staticmethod
    def biomass_model(**keys: Any) -> Field:
        """Biomass as a function of locations `(3,)` or `(n, 3)`."""
        column = {native: float(keys[key]) for key, native in _PLANKTON.items() if key in keys}
        clusters = keys.get("biomass_clusters") or []

        def field(location: Any) -> Any:
            at = np.asarray(location, dtype=np.float64)
            depth = np.maximum(-at[..., 2], _LEAST_M)
            return np.where(at[..., 2] > 0, 0.0, _single(plankton_column(depth, **column)) + patches(at, clusters))

        return field

    @staticmethod
    def salinity_model(**keys: Any) -> Field:
        """Salinity as a function of locations."""
        return _stepped("salinity", keys)

    @staticmethod
    def temperature_model(**keys: Any) -> Field:
        """Temperature as a function of locations."""
        return _stepped("temperature", keys)


def _stepped(name: str, keys: Any) -> Field:
    surface, high, deep, low, cline, middle, thickness = _STEPS[name]
    column = {
        "surface": float(keys.get(surface, high)), "deep": float(keys.get(deep, low)),
        "middle_m": float(keys.get(f"{cline}_depth", middle)),
        "thickness_m": float(keys.get(f"{cline}_thickness", thickness)),
    }  # fmt: skip
    clusters = keys.get(f"{name}_clusters") or []

    def field(location: Any) -> Any:
        at = np.asarray(location, dtype=np.float64)
        depth = np.maximum(-at[..., 2], 0.0)
        return np.where(at[..., 2] > 0, 0.0, _single(step_column(depth, **column)) + patches(at, clusters))

    return field


def _single(column: NDArray[np.float64]) -> NDArray[np.float32]:
    """A column in single precision, which HoloOcean's numbers show to the last bit."""
    return column.astype(np.float32)


def _finite(field: Field, location: Any) -> float:
    """A field's value; 0 where a script's own function fails, as HoloOcean has it."""
    try:
        value = float(np.ravel(field(location=location))[0])
    except Exception:
        return 0.0
    return value if np.isfinite(value) else 0.0
