"""Variables of a NetCDF file: found by standard or usual name, in our units, without gaps. Host only."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import ScenarioError, did_you_mean

QUANTITIES: Final[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "east": (("eastward_sea_water_velocity", "sea_water_x_velocity"), ("uo", "water_u", "u_eastward", "u", "ucur")),
    "north": (("northward_sea_water_velocity", "sea_water_y_velocity"), ("vo", "water_v", "v_northward", "v", "vcur")),
    "up": (("upward_sea_water_velocity",), ("wo", "water_w", "w")),
    "temperature": (
        ("sea_water_temperature", "sea_water_potential_temperature", "sea_surface_temperature"),
        ("thetao", "water_temp", "temp", "temperature", "t"),
    ),
    "salinity": (("sea_water_practical_salinity", "sea_water_salinity"), ("so", "salinity", "salt", "s")),
    "oxygen": (("mole_concentration_of_dissolved_molecular_oxygen_in_sea_water",), ("o2", "oxygen")),
    "chlorophyll": (("mass_concentration_of_chlorophyll_a_in_sea_water",), ("chl", "chlorophyll")),
}
"""Standard names and usual names of what we know."""

METRES: Final = ("m", "metre", "meter", "metres", "meters")
_VELOCITY: Final = {
    "m s-1": 1.0,
    "m/s": 1.0,
    "m.s-1": 1.0,
    "meter second-1": 1.0,
    "m s^-1": 1.0,
    "cm/s": 0.01,
    "cm s-1": 0.01,
}
_OXYGEN_VOLUME: Final = 1000.0 / 1025.0  # umol/l in umol/kg, for water of 1025 kg/m^3: within 1 % in the ocean
_UNITS: Final[dict[str, tuple[str, dict[str, float]]]] = {
    "salinity": (
        "1, psu or g kg-1",
        {
            **dict.fromkeys(("1", "0.001", "1e-3", "1e-03", "psu", "pss", "pss-78", "ppt", "gkg-1", "g/kg"), 1.0),
            **dict.fromkeys(("kgkg-1", "kg/kg"), 1000.0),
        },
    ),
    "oxygen": (
        "umol kg-1, mmol m-3, mol m-3, ml l-1 or mg l-1",
        {
            **dict.fromkeys(("umolkg-1", "umol/kg", "micromolkg-1", "micromol/kg", "micromoles/kg"), 1.0),
            **dict.fromkeys(("mmolm-3", "mmol/m3", "umoll-1", "umol/l", "micromol/l"), _OXYGEN_VOLUME),
            **dict.fromkeys(("molm-3", "mol/m3", "mmoll-1", "mmol/l"), 1000.0 * _OXYGEN_VOLUME),
            **dict.fromkeys(("mll-1", "ml/l"), 44.6596 * _OXYGEN_VOLUME),  # 22.3916 l/mol at standard conditions
            **dict.fromkeys(("mgl-1", "mg/l", "gm-3", "g/m3"), 1000.0 / 31.9988 * _OXYGEN_VOLUME),  # molar mass [g]
        },
    ),
    "chlorophyll": (
        "mg m-3, ug l-1 or kg m-3",
        {
            **dict.fromkeys(("mgm-3", "mg/m3", "milligramm-3", "ugl-1", "ug/l", "microgram/l"), 1.0),
            **dict.fromkeys(("gm-3", "g/m3", "mgl-1", "mg/l"), 1e3),
            **dict.fromkeys(("kgm-3", "kg/m3"), 1e6),
        },
    ),
}
"""Names of units for a message, and factors to ours by units without blanks and signs of powers."""

_LIMITS: Final = ("valid_range", "valid_min", "valid_max")
_CALENDARS: Final = ("standard", "gregorian", "proleptic_gregorian")
_TEMPERATURE: Final = ("degc", "degree_c", "degrees_c", "celsius", "deg_c", "degree_celsius", "degrees_celsius", "°c")


def find_variable(data: Any, path: Path, label: str, name: str | None) -> Any:
    """The variable of a name, or that which looks like a label of `QUANTITIES`.

    Raises:
        ScenarioError: there is none.
    """
    if name is not None:
        if name not in data.data_vars:
            names = [str(v) for v in data.data_vars]
            raise ScenarioError(
                f"{path} has no variable {name!r}{did_you_mean(name, names)}; it has {', '.join(names)}"
            )
        return data[name]
    standard, usual = QUANTITIES.get(label, ((), (label,)))
    for variable in data.data_vars.values():
        if variable.attrs.get("standard_name") in standard:
            return variable
    lower = {str(v).lower(): v for v in data.data_vars}
    for candidate in usual:
        if candidate in lower:
            return data[lower[candidate]]
    has = ", ".join(str(v) for v in data.data_vars) or "nothing"
    raise ScenarioError(f"{path}: no variable looks like {label!r}; name it in the scenario. The file has {has}")


def seconds_of(data: Any, path: Path, dimension: str | None, start: str | None) -> NDArray[np.float64]:
    """Times of a dimension since `start` (ISO 8601), or since its earliest, [s]; one zero where there is none.

    Raises:
        ScenarioError: times that are not of the standard calendar, or a start outside.
    """
    if dimension is None:
        return np.zeros(1)
    if dimension not in data.coords:
        raise ScenarioError(f"{path}: the dimension {dimension!r} has no coordinate values")
    values = data[dimension].values
    if not np.issubdtype(values.dtype, np.datetime64):
        calendar = getattr(values.flat[0], "calendar", None)
        what = f"its calendar is {calendar!r}" if calendar else "it has no units like 'hours since 2020-01-01'"
        raise ScenarioError(
            f"{path}: the times of {dimension!r} cannot be used: {what}; needed is the standard calendar"
        )
    try:
        origin = values.min() if start is None else _moment(start)
    except ValueError as error:
        raise ScenarioError(f"start {start!r} is not an ISO time such as 2024-05-01T12:00:00") from error
    seconds: NDArray[np.float64] = (values - origin) / np.timedelta64(1, "ns") * 1e-9
    if len(seconds) > 1 and not seconds.min() <= 0 <= seconds.max():
        first, last = (np.datetime_as_string(v, unit="s") for v in (values.min(), values.max()))
        raise ScenarioError(f"{path} covers {first} to {last}, and start {start} lies outside")
    return seconds


def _moment(start: str) -> np.datetime64:
    """An ISO time in UTC, from whatever zone."""
    try:
        moment = datetime.fromisoformat(start)
    except ValueError:
        return np.datetime64(start, "ns")  # such as a month
    if moment.tzinfo is not None:
        moment = moment.astimezone(UTC).replace(tzinfo=None)
    return np.datetime64(moment, "ns")


def depths_of(data: Any, path: Path, dimension: str | None) -> NDArray[np.float64]:
    """Depths of a dimension [m], downwards, as they follow each other in the file; one zero where there is none.

    Raises:
        ScenarioError: it has no values, or they are not in metres.
    """
    if dimension is None:
        return np.zeros(1)
    if dimension not in data.coords:
        raise ScenarioError(
            f"{path}: the dimension {dimension!r} has no coordinate values; depths in metres are needed"
        )
    coordinate = data[dimension]
    units = str(coordinate.attrs.get("units", "")).lower()
    if units not in METRES:
        given = f"in {units!r}" if units else "without units"
        raise ScenarioError(f"{path}: depths of {dimension!r} must be in metres (units: m), not {given}")
    values = np.asarray(coordinate.values, dtype=np.float64)
    upwards = coordinate.attrs.get("positive", "down") == "up" or (values.max() <= 0 and values.min() < 0)
    return -values if upwards else values


def check_times(data: Any, path: Path) -> None:
    """See that times, not decoded yet, can be understood.

    Raises:
        ScenarioError: units that are no "hours since ...", or a calendar that no clock goes by.
    """
    import xarray

    for name, variable in data.variables.items():
        units, calendar = str(variable.attrs.get("units", "")), str(variable.attrs.get("calendar", "standard")).lower()
        if " since " not in units:
            continue
        if calendar not in _CALENDARS:
            raise ScenarioError(
                f"{path}: the times of {str(name)!r} have the calendar {calendar!r}; needed is the standard one (model "
                "years of other lengths have no date: choose one, and write the calendar and units into the file)"
            )
        try:
            xarray.decode_cf(xarray.Dataset({"time": variable[{d: slice(1) for d in variable.dims}]}))
        except ValueError as error:
            raise ScenarioError(
                f"{path}: cannot read the units {units!r} of {str(name)!r}; expected such as 'hours since 2020-01-01'"
            ) from error


def in_our_units(values: NDArray[np.float64], label: str, variable: Any, path: Path) -> NDArray[np.float64]:
    """To m/s, degC, umol/kg and mg/m^3 by the variable's units, which velocities and temperatures must have.

    Values beyond the variable's valid range are none.

    Raises:
        ScenarioError: units that are lacking or not known.
    """
    values = np.where(_valid(values, variable), values, np.nan)
    units = variable.attrs.get("units")
    if label in _UNITS:
        expected, factors = _UNITS[label]
        text = re.sub(r"[\s^]|\*\*", "", str(units or "").lower().replace("\u00b5", "u").replace("\u03bc", "u"))
        if not text:
            return values
        if text in factors:
            return values * factors[text]
        raise ScenarioError(f"{path}: cannot read the units {units!r} of {variable.name!r}; known: {expected}")
    if label not in ("east", "north", "up", "temperature"):
        return values
    if units is None:
        raise ScenarioError(
            f"{path}: the variable {variable.name!r} has no units; write them into the file (CF: units)"
        )
    text = str(units).strip().lower()
    if label == "temperature":
        if text in ("k", "kelvin", "degk", "degrees_k"):
            return values - 273.15
        if text in _TEMPERATURE:
            return values
    elif text in _VELOCITY:
        return values * _VELOCITY[text]
    expected = "degC or K" if label == "temperature" else "m s-1"
    raise ScenarioError(f"{path}: cannot read the units {units!r} of {variable.name!r}; known: {expected}")


def _valid(values: NDArray[np.float64], variable: Any) -> NDArray[np.bool_]:
    """Values within the variable's valid range (CF 1.11, Section 2.5.1).

    The range is of packed values, but where it has the type of the scale and the data another.
    """
    limits = np.full(2, np.nan)
    for name, places in (("valid_range", (0, 1)), ("valid_min", (0,)), ("valid_max", (1,))):
        if name in variable.attrs:
            limits[list(places)] = np.ravel(variable.attrs[name])[: len(places)]
    packing = variable.encoding
    scale, offset = (float(packing.get(k, v)) for k, v in (("scale_factor", 1.0), ("add_offset", 0.0)))
    given = np.asarray(next((variable.attrs[k] for k in _LIMITS if k in variable.attrs), 0.0)).dtype
    if np.issubdtype(packing.get("dtype", np.float64), np.floating) or not np.issubdtype(given, np.floating):
        limits = np.sort(limits * scale + offset) if scale < 0 else limits * scale + offset
    slack = 1e-6 * np.abs(limits)  # of limits in single precision
    return np.asarray(~(values < limits[0] - slack[0]) & ~(values > limits[1] + slack[1]))


def cell_of(row: NDArray[np.float64], column: NDArray[np.float64], *, metric: bool) -> tuple[float, float]:
    """Height and width of a grid's median cell, in one unit of length: of latitudes and longitudes [deg], or metres."""
    height, width = (float(np.median(np.abs(np.diff(line)))) if len(line) > 1 else 1.0 for line in (row, column))
    return height, width if metric else width * max(float(np.cos(np.radians(np.mean(row)))), 1e-6)


def without_gaps(
    values: NDArray[np.float64], missing: NDArray[np.bool_], *, zero: bool, cell: tuple[float, float]
) -> NDArray[np.float64]:
    """Land and gaps: still water for velocities; for the rest the nearest value of the level, by cells of this height
    and width, else of the level above.
    """
    if not missing.any():
        return values
    if zero:
        return np.where(missing, 0.0, values)
    from scipy.ndimage import distance_transform_edt

    out = values.copy()
    for t in range(out.shape[0]):
        for k in range(out.shape[1]):
            gap = missing[t, k]
            if gap.all():
                out[t, k] = out[t, k - 1] if k > 0 else np.nan
            elif gap.any():
                i, j = distance_transform_edt(gap, sampling=cell, return_distances=False, return_indices=True)
                out[t, k] = out[t, k][i, j]
    open_ = ~np.isfinite(out)
    return np.where(open_, float(np.nanmean(out)), out) if open_.any() else out
