"""HoloOcean's sensors by their names: definitions, and what builds them.

Sensors that report the true motion (pose, location, depth, ...) read it from the simulation's state; all that look,
listen or feel are native sensors. HoloOcean's statistical noise keys are drawn here, on the native truth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from typing import Any, ClassVar, Final

import numpy as np

from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.compat.holoocean.frames import degrees_of, matrix_of
from pelagos.compat.holoocean.sensor import HoloOceanSensor

_HOMES: Final = (
    "cameras", "comms_sensors", "contact_sensors", "lidars", "navigation_sensors", "sonars", "task_sensors",
    "water_sensors",
)  # fmt: skip
"""Modules in which the sensors' classes are."""
HEAVY: Final = ("RGBCamera", "RaycastLidar", "RaycastSemanticLidar")


class UnknownSensorType(HoloOceanException, KeyError):
    """No such sensor type: a KeyError, as HoloOcean raises it, with words."""

    __str__ = Exception.__str__


class SensorDefinition:
    """Definition of a sensor before it is built.

    Attributes:
        mount: place [m] and turn [deg] in the body's frame, socket included.
    """

    _sonar_sensors: ClassVar[list[str]] = ["ImagingSonar", "ProfilingSonar", "SidescanSonar", "SinglebeamSonar"]
    _heavy_sensors: ClassVar[list[str]] = [*_sonar_sensors, *HEAVY]
    _sensor_keys_: ClassVar[dict[str, type[HoloOceanSensor]]] = {}

    def __init__(
        self,
        agent_name: str,
        agent_type: str,
        sensor_name: str | None,
        sensor_type: str | type[HoloOceanSensor],
        socket: str = "",
        location: Sequence[float] = (0, 0, 0),
        rotation: Sequence[float] = (0, 0, 0),
        config: Mapping[str, Any] | None = None,
        existing: bool = False,
        lcm_channel: str | None = None,
        tick_every: int | None = None,
    ) -> None:
        self.agent_name, self.agent_type = agent_name, agent_type
        self.type = _sensor_type(sensor_type)
        self.sensor_name = sensor_name or self.type.sensor_type
        self.socket, self.location, self.rotation = socket or "", tuple(location), tuple(rotation)
        self.config = {} if config is None else dict(config)
        self.existing, self.lcm_channel, self.tick_every = existing, lcm_channel, tick_every
        self.twist: Sequence[float] | None = None

    @property
    def mount(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Place [m] and turn [deg], body axes."""
        from pelagos.compat.holoocean.agents import kind_of

        place, turn = kind_of(self.agent_type).sockets.get(self.socket, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
        socket = matrix_of(turn)
        at = np.array(place) + socket @ np.asarray(self.location, dtype=np.float64)
        turned = socket @ matrix_of(self.rotation if self.twist is None else self.twist)
        return tuple(float(v) for v in at), tuple(float(v) for v in degrees_of(turned))  # type: ignore[return-value]


def _sensor_type(given: str | type[HoloOceanSensor]) -> type[HoloOceanSensor]:
    if isinstance(given, type):
        return given
    known = sensor_types()
    if given not in known:
        from pelagos.errors import did_you_mean

        raise UnknownSensorType(f"there is no sensor type {given!r}{did_you_mean(str(given), known)}")
    return known[given]


def sensor_types() -> dict[str, type[HoloOceanSensor]]:
    """Every sensor type by its name: HoloOcean's, and what a script has put into `SensorDefinition._sensor_keys_`.

    A class of a script's own is no type by being defined, as in HoloOcean: give the class itself, or put it there.
    """
    for name, one in _shipped().items():
        SensorDefinition._sensor_keys_.setdefault(name, one)
    return SensorDefinition._sensor_keys_


@cache
def _shipped() -> dict[str, type[HoloOceanSensor]]:
    found: dict[str, type[HoloOceanSensor]] = {}
    for name in _HOMES:
        home = import_module(f"pelagos.compat.holoocean.{name}")
        for one in vars(home).values():
            own = isinstance(one, type) and issubclass(one, HoloOceanSensor) and one.__module__ == home.__name__
            if own and one.sensor_type:
                found[one.sensor_type] = one
    return found


class SensorFactory:
    """Builds sensors from their definitions."""

    @staticmethod
    def build_sensor(client: Any, sensor_def: SensorDefinition) -> HoloOceanSensor:
        """The sensor."""
        return sensor_def.type(client, sensor_def, sensor_def.agent_type)


def __getattr__(name: str) -> Any:
    """A sensor's class by its name: `from holoocean.sensors import RGBCamera`."""
    if name.startswith("_") or name not in sensor_types():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return sensor_types()[name]
