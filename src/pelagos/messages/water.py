"""Instruments that sample the water as ROS 2 messages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.encoding import Encoding, Site, Table, Topic, tabular
from pelagos.messages.ranging import TWIST_COVARIANCE
from pelagos.messages.store import diagonal, header, make, vector3
from pelagos.messages.template import STAMP, Template, fields, joined

CTD: Final = "pelagos_msgs/msg/Ctd"
WATER_PROPERTY: Final = "pelagos_msgs/msg/WaterProperty"
TEMPERATURE: Final = "sensor_msgs/msg/Temperature"
FLUID_PRESSURE: Final = "sensor_msgs/msg/FluidPressure"

CTD_FIELDS: Final = joined(
    STAMP, [f"{name}:float64" for name in ("conductivity", "temperature", "pressure", "salinity", "sound_speed")]
)
WATER_PROPERTY_FIELDS: Final = joined(STAMP, ["value:float64"])
TEMPERATURE_FIELDS: Final = joined(STAMP, ["temperature:float64"])
FLUID_PRESSURE_FIELDS: Final = joined(STAMP, ["fluid_pressure:float64"])
FLOW_FIELDS: Final = joined(STAMP, fields("twist.twist.linear", "x y z"))

ATMOSPHERE: Final = 101_325.0  # Pa; sensor_msgs/FluidPressure is absolute
_PROPERTIES: Final = {
    "sound_velocity": ("sound_speed", "m/s"),
    "fluorometer": ("chlorophyll", "mg/m^3"),
    "oxygen": ("oxygen", "umol/kg"),
    "turbidity": ("turbidity", "NTU"),
}
_Extras = Mapping[str, NDArray[Any]]


def ctd(config: Any, site: Site) -> Encoding:
    """pelagos_msgs/Ctd, and for programs that know only those, sensor_msgs/Temperature and FluidPressure (absolute)."""

    def all_of_it(data: NDArray[Any], extras: _Extras) -> NDArray[np.float64]:
        return np.concatenate([data, extras["salinity"][:, None], extras["sound_speed"][:, None]], axis=1)

    zero = dict.fromkeys(("conductivity", "temperature", "pressure", "salinity", "sound_speed"), 0.0)
    whole = make(CTD, header=header(site.frame), **zero)
    temperature_variance = _variance(config.temperature_noise_density, config.temperature_bias_std, config)
    pressure_variance = 1e8 * _variance(config.pressure_noise_density, config.pressure_bias_std, config)
    temperature = make(TEMPERATURE, header=header(site.frame), temperature=0.0, variance=temperature_variance)
    pressure = make(FLUID_PRESSURE, header=header(site.frame), fluid_pressure=0.0, variance=pressure_variance)
    return tabular(
        Table(Topic("ctd", CTD), Template(CTD, whole, CTD_FIELDS), all_of_it),
        Table(
            Topic("temperature", TEMPERATURE),
            Template(TEMPERATURE, temperature, TEMPERATURE_FIELDS),
            lambda data, extras: data[:, 1:2],
        ),
        Table(
            Topic("pressure", FLUID_PRESSURE),
            Template(FLUID_PRESSURE, pressure, FLUID_PRESSURE_FIELDS),
            lambda data, extras: 1e4 * data[:, 2:3] + ATMOSPHERE,
        ),
    )


def water_property(config: Any, site: Site) -> Encoding:
    """pelagos_msgs/WaterProperty: one number with its name and unit; a tracer's unit is the scenario's own."""
    quantity, unit = _PROPERTIES.get(config.type) or (config.tracer, "")
    message = make(
        WATER_PROPERTY,
        header=header(site.frame),
        quantity=quantity,
        unit=unit,
        value=0.0,
        variance=_variance(config.noise_density, config.bias_std, config) + config.drift_std**2,
    )
    template = Template(WATER_PROPERTY, message, WATER_PROPERTY_FIELDS)
    return tabular(
        Table(Topic(quantity if unit else "tracer", WATER_PROPERTY), template, lambda data, extras: data[:, None])
    )


def current_meter(config: Any, site: Site) -> Encoding:
    """geometry_msgs/TwistWithCovarianceStamped in the sensor frame: the water past the sensor [m/s]."""
    v = _variance(config.noise_density, config.bias_std, config) + config.drift_std**2
    message = make(
        TWIST_COVARIANCE,
        header=header(site.frame),
        twist=make(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=make("geometry_msgs/msg/Twist", linear=vector3(), angular=vector3()),
            covariance=diagonal(v, v, v, 1e6, 1e6, 1e6),  # of rotation nothing is known
        ),
    )
    template = Template(TWIST_COVARIANCE, message, FLOW_FIELDS)
    return tabular(Table(Topic("flow", TWIST_COVARIANCE), template, lambda data, extras: data))


def _variance(density: float, bias: float, config: Any) -> float:
    """Of one reading: white noise and the constant offset."""
    return float(density**2 * config.rate_hz + bias**2)
