"""The plan of a fit, as data: parameters, columns, and the way of fitting."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Field, ValidationError, field_validator, model_validator

from pelagos.config.described import Described
from pelagos.config.document import Document, Key, read_document
from pelagos.config.problem import scenario_error
from pelagos.errors import LookupFailed, ScenarioError
from pelagos.identification.coordinates import COORDINATES, UNITS
from pelagos.math.units import LENGTHS, SPEEDS

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Number = Annotated[float, Field(allow_inf_nan=False)]
Integrator = Literal["conservative", "semi_implicit", "runge_kutta"]
"""Ways of a vehicle's steps."""

_LENGTHS: Final = ("m", "cm", "mm", "km", "nmi", "ft")
UNIT_SCALES: Final[dict[str, float]] = {
    "": 1.0, **{unit: LENGTHS[unit] for unit in _LENGTHS}, "rad": 1.0, "deg": 3.141592653589793 / 180, **SPEEDS,
    "rad/s": 1.0, "deg/s": 3.141592653589793 / 180, "deg/min": 3.141592653589793 / 180 / 60, "s": 1.0, "min": 60.0,
    "h": 3600.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "rpm": 3.141592653589793 / 30, "Hz": 2 * 3.141592653589793,
    "N": 1.0, "kN": 1000.0,
}  # fmt: skip
"""Factors to SI units."""
UNITS_OF: Final[dict[str, tuple[str, ...]]] = {
    "m": _LENGTHS, "rad": ("rad", "deg"), "m/s": tuple(SPEEDS),
    "rad/s": ("rad/s", "deg/s", "deg/min", "rpm", "Hz"), "s": ("s", "ms", "us", "ns", "min", "h"),
}  # fmt: skip
"""Units of a kind, by its SI unit."""


_OF_COMMANDS: Final = tuple(unit for unit in UNIT_SCALES if unit and unit not in UNITS_OF["s"])
_SPOKEN: Final = {
    "degree": "deg", "radian": "rad", "meter": "m", "metre": "m", "millimeter": "mm", "millimetre": "mm",
    "centimeter": "cm", "centimetre": "cm", "kilometer": "km", "kilometre": "km", "nm": "nmi", "nautical mile": "nmi",
    "mile": "nmi", "feet": "ft", "foot": "ft", "knot": "kn", "kt": "kn", "mp": "m/s", "kmh": "km/h", "kph": "km/h",
    "sec": "s", "second": "s", "minute": "min", "hour": "h", "hr": "h", "msec": "ms", "millisecond": "ms",
    "usec": "us", "microsecond": "us", "nsec": "ns", "nanosecond": "ns", "newton": "N", "kilonewton": "kN",
    "hertz": "Hz", "rev/min": "rpm", "dp": "deg/s", "°": "deg", "°/": "deg/s", "°/min": "deg/min",
    "degree/min": "deg/min",
}  # fmt: skip
"""Units by other names that they go by, without the last s."""


class _Strict(Described):
    model_config = ConfigDict(frozen=True, extra="forbid")


class ColumnConfig(_Strict):
    """One column of the data: value = scale x unit x (column - zero)."""

    column: str
    """Its name in the file's first line; of a recording: topic and field, as `/auv0/pose.x`."""
    unit: str = ""
    """Of the column: m, cm, mm, km, nmi, ft, rad, deg, m/s, cm/s, mm/s, km/h, kn, rad/s, deg/s, deg/min, rpm, Hz, s,
    ms, us, ns, min, h, N, kN."""
    scale: Number = 1.0
    """A further factor, such as -1 for another direction."""
    zero: Number = 0.0
    """What the column shows where the quantity is 0, in the column's unit."""
    delay_s: Number = 0.0
    """How long after the event the row was written [s]."""

    @field_validator("scale")
    @classmethod
    def _some(cls, value: float) -> float:
        if value == 0:
            raise ValueError("a scale of 0 makes every row 0")
        return value

    @property
    def factor(self) -> float:
        """From the column to SI."""
        return self.scale * UNIT_SCALES[self.unit]


def _column(given: Any) -> Any:
    """A name alone is a column in SI units."""
    if isinstance(given, str):
        return {"column": given}
    if isinstance(given, (Mapping, ColumnConfig)):
        return given
    raise ValueError(f"give the name of a column, or {{column, unit, scale, zero, delay_s}}, not {given!r}")


Column = Annotated[ColumnConfig, BeforeValidator(_column)]


class DropOut(_Strict):
    """Rows in which a device saw nothing: all these columns have the value."""

    columns: Annotated[tuple[str, ...], Field(min_length=1)]
    """Names in the file."""
    value: Number = 0.0
    """What the device writes then."""


class ParameterConfig(_Strict):
    """A number of the vehicle that is identified."""

    path: str | tuple[str, ...] = ""
    """Keys of the vehicle from the top, such as `terms.damping.diagonal.0`; several are kept equal (up to `factors`);
    or `current.north`, `current.east` [m/s], `offset.heading` and the like. Left out: the parameter's name."""
    factors: tuple[Number, ...] | None = None
    """Of the paths, where they are not all 1."""
    prior: Number | None = None
    """What is believed before; left out: the vehicle's own value."""
    spread: Positive | None = None
    """Standard deviation of the prior: of the logarithm where the parameter is positive and `scale` is log, else in its
    unit. Left out: ln 3, or the prior's own size."""
    low: Number | None = None
    """Least value."""
    high: Number | None = None
    """Largest value."""
    scale: Literal["log", "linear"] = "log"
    """Log: the sign of the prior is kept, and bounds have it too. A prior of 0, or a bound, needs linear."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.low is not None and self.high is not None and self.low >= self.high:
            raise ValueError(f"low {self.low:g} must be below high {self.high:g}")
        if self.scale == "log" and "scale" in self.model_fields_set and (fault := self.off_the_scale(self.prior)):
            raise ValueError(fault)
        paths = 1 if isinstance(self.path, str) else len(self.path)
        if self.factors is not None and len(self.factors) != paths:
            raise ValueError(f"factors: {len(self.factors)} of them, but the number of paths is {paths}; give one each")
        return self

    def off_the_scale(self, prior: float | None) -> str:
        """The fault of bounds that a log scale about a prior does not reach, in words; empty where there is none."""
        told = {"prior": prior or None, "low": self.low, "high": self.high}
        given = {key: value for key, value in told.items() if value is not None}
        for key, value in given.items():
            first, sign = next(iter(given.items()))
            if value == 0:
                return f"{key} 0 is on no log scale: leave it out, give another, or give scale: linear"
            if (value > 0) != (sign > 0):
                return (
                    f"{first} {sign:g} and {key} {value:g} have different signs, and a log scale keeps that of the "
                    f"prior: leave {key} out, give it {'above' if sign > 0 else 'below'} 0, or give scale: linear"
                )
        return ""

    def paths(self, name: str) -> tuple[str, ...]:
        """Paths of the identified quantities."""
        return (self.path or name,) if isinstance(self.path, str) else self.path


class Plan(_Strict):
    """Columns, parameters and the way of fitting."""

    time: Column = ColumnConfig(column="t")
    """[s]"""
    columns: dict[str, Column] = Field(default_factory=dict)
    """By coordinate: north, east, depth [m], roll, pitch, heading [rad], u, v, w [m/s], p, q, r [rad/s]. Left out: of a
    recording of `pelagos run` the true motion."""
    commands: dict[str, Column] = Field(default_factory=dict)
    """By actuator; one that is left out is commanded 0. No `commands` at all: of a recording of `pelagos run` those it
    holds (`record: {commands: true}`)."""
    dropouts: tuple[DropOut, ...] = ()
    """Rows to leave out."""
    gaps: Literal["refuse", "split"] = "refuse"
    """What to do where rows are missing for longer than `gap_s`."""
    gap_s: Positive | None = None
    """Longest hole that is bridged [s]; left out: five steps."""
    windows_s: tuple[tuple[float, float], ...] = ()
    """Parts of the record that are used, from and to [s]; left out: all of it."""
    step_s: Positive | None = None
    """Of the simulation [s]; left out: the record's own, divided until it is at most 0.1 s."""
    integrator: Integrator | Literal["vehicle"] | None = None
    """Way of the fit's steps; the fitted vehicle keeps its own way, which is `vehicle` here. Left out: that under
    `vehicle:` of this plan; of a recording of `pelagos run` that of the run; or `runge_kutta`, whose error is of fourth
    order."""
    substeps: Annotated[int, Field(ge=1, le=60_000)] | None = None
    """Steps of the simulation in one of `step_s`, none shorter than 1 ms; left out: 1, doubled until the steps shift no
    parameter by more than a tenth of its interval's half; of a recording of `pelagos run` its ticks, if nothing is said
    of steps and they are 16 or fewer."""
    smooth_s: Positive = 0.6
    """Length of the parabolas through poses whose slope stands for a velocity that is not measured [s]."""
    segment_s: Positive = 15.0
    """Length of a shot [s]: each begins anew, at a state that is found with the parameters."""
    preroll_s: Positive | None = None
    """Time before a shot from which its actuators follow their commands [s], at most the record's; left out: 3, or as
    long as the slowest actuator takes to within a hundred-thousandth of its command."""
    actuators_from: Literal["commands", "rest", "unknown"] = "commands"
    """States of the actuators at the record's first row: at their commands; at rest, in the state 0; or unknown, so
    that shots begin after `preroll_s`. Left out, of a recording of `pelagos run`: rest if it begins with the run, else
    unknown; where the plan has columns and no commands, unknown."""
    train: Annotated[float, Field(gt=0, le=1)] = 0.7
    """Share of the shots that are fitted; the last ones are for the test."""
    fit_to: tuple[str, ...] = ()
    """Coordinates whose differences count; left out: all that have a column. Velocities without a column are slopes."""
    continuity: dict[str, Positive] = Field(default_factory=dict)
    """Coordinates at which a shot's end must meet the next shot's beginning, with the tolerance [SI]."""
    start: dict[str, Number] = Field(default_factory=dict)
    """Coordinates without a column when a shot begins [SI], such as the depth that was kept; left out: 0."""
    start_spread: dict[str, Positive] = Field(default_factory=dict)
    """Standard deviation about `start` [SI]; left out: 1 m, 0.1 rad (heading 1), 0.3 m/s, 0.1 rad/s. Each shot's own
    value is found with the parameters where what is fitted depends on it."""
    loss: Literal["huber", "squares"] = "huber"
    """Huber's: what is further off than 1.345 standard deviations counts linearly."""
    sigma: dict[str, Positive] = Field(default_factory=dict)
    """Standard deviation of what is fitted [SI]; left out: that of the residuals."""
    parameters: dict[str, ParameterConfig] = Field(default_factory=dict)
    """What is identified."""
    bootstrap: Annotated[int, Field(ge=0, le=100_000)] = 1000
    """Number of resamplings of the shots."""
    iterations: Annotated[int, Field(ge=1, le=500)] = 40
    """Most steps of the search."""
    vehicle: dict[str, Any] = Field(default_factory=dict)
    """Changes to the scenario's vehicle before the fit, such as the rotor speed of this run."""

    @field_validator("columns", "sigma", "continuity", "start", "start_spread")
    @classmethod
    def _coordinates(cls, value: dict[str, Any]) -> dict[str, Any]:
        for name in value:
            if name not in COORDINATES:
                raise ValueError(str(LookupFailed("coordinate", name, COORDINATES)))
        return value

    @property
    def fitted(self) -> tuple[str, ...]:
        """Coordinates whose differences count, in the order of the columns of differences."""
        return self.fit_to or tuple(n for n in COORDINATES if n in self.columns)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        self._units_fit()
        self._columns_differ()
        own = self.vehicle.get("integrator", self.integrator)
        if self.integrator not in (None, "vehicle", own):
            raise ValueError(f"integrator: {self.integrator} here, but {own} under vehicle; leave one out")
        for k, name in enumerate(self.fit_to):
            if name not in COORDINATES:
                raise ValueError(f"fit_to: {LookupFailed('coordinate', name, COORDINATES)}")
            if name in self.fit_to[:k]:
                raise ValueError(f"fit_to: {name} is named twice")
        for name in self.sigma:
            if name not in self.fitted:
                raise ValueError(f"sigma: {name} is not fitted, only {', '.join(self.fitted)}; leave it out")
        for key, given in (("start", self.start), ("start_spread", self.start_spread)):
            for name in given:
                if name in self.columns:
                    raise ValueError(f"{key}: {name} has a column, which says where a shot begins; leave it out")
        for start, end in self.windows_s:
            if not start < end:
                raise ValueError(f"windows_s: {start:g} is not before {end:g}")
        for (start, end), (later, last) in pairwise(sorted(self.windows_s)):
            if later < end:
                raise ValueError(f"windows_s: {later:g} to {last:g} begins before {start:g} to {end:g} ends")
        return self

    def _units_fit(self) -> None:
        """Refuse unknown units and those of another kind; a command's kind is its actuator's, but never time."""
        kinds = [("time", self.time, UNITS_OF["s"])]
        kinds += [(f"columns.{n}", c, UNITS_OF[UNITS[COORDINATES.index(n)]]) for n, c in self.columns.items()]
        kinds += [(f"commands.{n}", c, _OF_COMMANDS) for n, c in self.commands.items()]
        for key, given, allowed in kinds:
            if given.unit and given.unit not in allowed:
                raise ValueError(f"{key}: {_not_a_unit(given.unit, allowed)}; give {', '.join(allowed)}")
        if self.time.delay_s:
            raise ValueError("time: delay_s belongs to columns and commands, not to the time itself")

    def _columns_differ(self) -> None:
        """Refuse a column of the data that would be two things at once; one command may go to several actuators."""
        taken = {self.time.column: "time"}
        for key, given in self.columns.items():
            if given.column in taken:
                raise ValueError(
                    f"columns.{key}: {given.column!r} is {taken[given.column]} already; name another column"
                )
            taken[given.column] = f"columns.{key}"
        for key, given in self.commands.items():
            if given.column in taken:
                raise ValueError(
                    f"commands.{key}: {given.column!r} is {taken[given.column]} already; name another column"
                )


def _not_a_unit(unit: str, allowed: Sequence[str]) -> str:
    """The fault of a unit that is none of those allowed, with the nearest."""
    if unit in UNIT_SCALES:
        return f"the unit {unit} is of another kind"
    spoken = _SPOKEN.get(unit.lower().rstrip("s"), "")
    plain = unit.lower().rstrip("s")
    written = [other for other in allowed if other.lower().rstrip("s") == plain]
    near = [spoken] if spoken in allowed else written or get_close_matches(unit, allowed, n=1)
    return f"unknown unit {unit!r}" + (f" (did you mean {near[0]!r}?)" if near else "")


def load_plan(source: str | Path | Mapping[str, Any], *, recording: str | Path | None = None, agent: str = "") -> Plan:
    """Read and check a plan.

    Args:
        source: a YAML file, or its keys.
        recording: a recording of `pelagos run`, which then has columns and commands that the plan does not name.
        agent: whose they are.

    Raises:
        ScenarioError: names the file, the key, what was given and what is allowed.
        InputError: the recording lacks the commands, or the agent.
    """
    where = str(source) if isinstance(source, (str, Path)) else "plan"
    data: Any = source
    places: dict[Key, str] = {}
    if not isinstance(source, (str, Path, Mapping)):
        raise ScenarioError(f"must be a file or a mapping of keys, not {type(source).__name__}", where=where)
    if not isinstance(source, Mapping):
        document = read_document(Path(source))
        data, places = document.data, document.places
        if not isinstance(data, Mapping):
            raise ScenarioError("must be a mapping of keys", where=where)
    if recording is not None:
        from pelagos.identification.own_run import completed

        data = completed(dict(data), Path(recording), agent)
    if not data.get("columns"):
        raise ScenarioError("columns: name at least one that was measured, such as heading: psi", where=where)
    if "commands" not in data:
        raise ScenarioError("commands: name the column of each actuator, or give {} for none", where=where)
    try:
        return Plan.model_validate(dict(data))
    except ValidationError as error:
        raise scenario_error(error, Document(data, {**places, (): where}), Plan) from None
