"""Parameters of a vehicle by name: their priors, and the compiled numbers that follow from them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from pelagos.errors import InputError, LookupFailed, ScenarioError, nearest
from pelagos.identification.constants import Place, numbers_of, values_at
from pelagos.identification.coordinates import COORDINATES
from pelagos.identification.plan import ParameterConfig
from pelagos.vehicles.build import build_model
from pelagos.vehicles.config import VehicleConfig
from pelagos.vehicles.model import Model

CURRENT: Final = ("current.north", "current.east")
"""Of the water, or for what flies of the air [m/s]."""
OUTSIDE: Final = (*CURRENT, *(f"offset.{name}" for name in COORDINATES))
"""What is identified and does not belong to the vehicle."""
Coordinates = Sequence[float] | NDArray[np.float64]
"""Of the search `(p,)`."""
_SPREAD: Final = math.log(3.0)
_STEP: Final = 1e-5  # of a parameter's coordinate, for the slope of compiled numbers


@dataclass(frozen=True)
class Parameter:
    """One number, as the search has it: its logarithm or itself.

    Attributes:
        name: in the plan.
        paths: keys of the vehicle, or of `OUTSIDE`.
        factors: of the value at each path.
        prior: value before.
        spread: standard deviation of the prior in the search's coordinate.
        low, high: bounds of the value.
        logarithmic: whether the coordinate is log |value|.
    """

    name: str
    paths: tuple[str, ...]
    factors: tuple[float, ...]
    prior: float
    spread: float
    low: float
    high: float
    logarithmic: bool

    def coordinate(self, value: float) -> float:
        """Of a value."""
        return math.log(abs(value)) if self.logarithmic else value

    def value(self, coordinate: float) -> float:
        """Of a coordinate, within the bounds."""
        value = math.copysign(math.exp(coordinate), self.prior) if self.logarithmic else coordinate
        return float(min(max(value, self.low), self.high))

    def slope(self, coordinate: float) -> float:
        """d value / d coordinate."""
        return self.value(coordinate) if self.logarithmic else 1.0


def parameters_of(
    given: Mapping[str, ParameterConfig], data: Mapping[str, Any], outside: Mapping[str, float] | None = None
) -> list[Parameter]:
    """Parameters of a plan, with priors from the vehicle's own keys.

    Args:
        given: by name; data: keys of the vehicle.
        outside: what is known of `OUTSIDE`; 0 where nothing is said.

    Raises:
        InputError: a path leads to no number of this vehicle (names the nearest), or the prior is not possible;
            or two have the same key.
    """
    owner: dict[str, str] = {}
    for name, config in given.items():
        for path in config.paths(name):
            if path in owner:
                both = (
                    f"{owner[path]} and {name} are the same key" if owner[path] != name else f"{name} has twice the key"
                )
                raise InputError(f"plan: parameters: {both}, {path}; leave one out")
            owner[path] = name
    return [_parameter(name, config, data, outside or {}) for name, config in given.items()]


def _parameter(name: str, config: ParameterConfig, data: Mapping[str, Any], outside: Mapping[str, float]) -> Parameter:
    paths = config.paths(name)
    factors = config.factors or (1.0,) * len(paths)
    where = f"plan: parameters.{name}"
    known = paths[0] in OUTSIDE and config.prior is None
    first = (outside.get(paths[0], 0.0) if paths[0] in OUTSIDE else _get(data, paths[0], where)) / factors[0]
    for path in paths[1:]:
        if path not in OUTSIDE:
            _get(data, path, where)
    prior = first if config.prior is None else config.prior
    log = config.scale == "log" and prior != 0 and not known
    if config.scale == "log" and prior == 0 and paths[0] not in OUTSIDE:
        raise InputError(f"{where}: its prior is 0: give another prior, or scale: linear with a spread")
    low = -math.inf if config.low is None else config.low
    high = math.inf if config.high is None else config.high
    if log:
        if fault := config.off_the_scale(prior):
            raise InputError(f"{where}: {fault}")
        low, high = (max(low, 1e-300), high) if prior > 0 else (low, min(high, -1e-300))
    if not low <= prior <= high:
        lowest, highest = (0.0 if log and bound in (1e-300, -1e-300) else bound for bound in (low, high))
        raise InputError(f"{where}: the prior {prior:.6g} is not between {lowest:g} and {highest:g}")
    spread = config.spread or (_SPREAD if log else 1.0 if known else abs(prior) or 1.0)
    return Parameter(name, paths, tuple(factors), prior, spread, low, high, log)


def _get(data: Mapping[str, Any], path: str, where: str) -> float:
    node: Any = data
    for k, key in enumerate(path.split(".")):
        known = _keys(node)
        if key not in known:
            before = ".".join(path.split(".")[:k])
            if before:
                raise LookupFailed(f"key below {before!r}", key, known, where=where)
            if key in ("current", "offset"):
                raise LookupFailed("key", path, OUTSIDE, where=where)
            all_known = [*known, *OUTSIDE]
            far = "" if nearest(key, all_known) else _near(data, path)
            raise LookupFailed("key", key, all_known, where=f"{where}: did you mean {far}?" if far else where)
        node = node[key] if isinstance(node, Mapping) else node[int(key)]
    if isinstance(node, bool) or not isinstance(node, (int, float)):
        raise InputError(f"{where}: {path} is not a number of this vehicle but {node!r}"[:300])
    return float(node)


def _near(data: Mapping[str, Any], path: str) -> str:
    """The number of a vehicle whose whole path, or whose path's last keys, are like this one; empty where none is."""
    paths = list(_numbers(data))
    if "." in path:
        known = {".".join(p.split(".")[k:]): p for p in reversed(paths) for k in range(p.count("."))}
    else:
        known = {key: p for p in reversed(paths) for key in p.split(".") if not key.isdigit()}
    found = nearest(path, known)
    return known[found] if found else ""


def _numbers(node: Any, path: str = "") -> Iterator[str]:
    """Paths of all numbers below a key."""
    if isinstance(node, (int, float)) and not isinstance(node, bool):
        yield path
    for key in _keys(node):
        yield from _numbers(node[key] if isinstance(node, Mapping) else node[int(key)], f"{path}.{key}".strip("."))


def _keys(node: Any) -> list[str]:
    if isinstance(node, Mapping):
        return [str(key) for key in node]
    return [str(k) for k in range(len(node))] if isinstance(node, (list, tuple)) else []


def changed(data: Mapping[str, Any], parameters: Sequence[Parameter], values: Sequence[float]) -> dict[str, Any]:
    """The vehicle's keys with values of the parameters."""
    new: dict[str, Any] = deepcopy(dict(data))
    for parameter, value in zip(parameters, values, strict=True):
        for path, factor in zip(parameter.paths, parameter.factors, strict=True):
            if path in OUTSIDE:
                continue
            *above, last = path.split(".")
            node: Any = new
            for key in above:
                node = node[key] if isinstance(node, dict) else node[int(key)]
            if isinstance(node, dict):
                node[last] = value * factor
            else:
                node[int(last)] = value * factor
    return new


@dataclass
class Compiled:
    """Numbers of the model that depend on the parameters, and what lies outside of it.

    Attributes:
        places: of the numbers in the model.
        values: now `(c,)`.
        outside: current north, east, and twelve offsets `(14,)`.
        slopes: of `values` and then `outside` by the search's coordinates `(c + 14, p)`.
    """

    places: list[Place]
    values: NDArray[np.float64]
    outside: NDArray[np.float64]
    slopes: NDArray[np.float64]


class Family:
    """Models of one vehicle, by the values of its parameters.

    Attributes:
        parameters: in order.
        data: the vehicle's keys.
        model: at the priors; its structure is that of all.
        places: numbers that depend on a parameter.
        outside: what is known of `OUTSIDE`, where no parameter says it.
    """

    def __init__(
        self, data: Mapping[str, Any], parameters: Sequence[Parameter], outside: Mapping[str, float] | None = None
    ) -> None:
        self.parameters = list(parameters)
        self.outside = dict(outside or {})
        self.data = listed(data)
        self._inside = [p for p in self.parameters if any(path not in OUTSIDE for path in p.paths)]
        start = [p.coordinate(p.prior) for p in self.parameters]
        self.model = self.model_at(start)
        self.places = self._find_places(start)

    @property
    def flows(self) -> bool:
        """True where there is a current, known or sought: without one no step has to carry it."""
        sought = any(path in CURRENT for p in self.parameters for path in p.paths)
        return sought or any(self.outside.get(path) for path in CURRENT)

    def values(self, at: Coordinates) -> list[float]:
        """Values of the parameters at coordinates of the search."""
        return [p.value(x) for p, x in zip(self.parameters, at, strict=True)]

    def config_at(self, at: Coordinates) -> VehicleConfig:
        """The vehicle at coordinates of the search.

        Raises:
            InputError: there is no such vehicle (the bounds allow too much).
        """
        try:
            return VehicleConfig.model_validate(changed(self.data, self.parameters, self.values(at)))
        except ValidationError as error:
            text = "; ".join(str(e["msg"]) for e in error.errors())
            told = ", ".join(f"{p.name} {v:.4g}" for p, v in zip(self.parameters, self.values(at), strict=True))
            raise ScenarioError(f"no vehicle has {told}: {text}; give bounds", where="plan: parameters") from None

    def model_at(self, at: Coordinates) -> Model:
        """Its equation of motion; mass matrices are solved with, not inverted before."""
        model = build_model(self.config_at(at))
        return replace(model, inertia=replace(model.inertia, inverse=None))

    def compiled(self, at: Coordinates) -> Compiled:
        """Numbers and slopes at coordinates of the search; slopes by central differences of the compiled numbers."""
        centre = values_at(self.model_at(at), self.places)
        slopes = np.zeros((len(self.places) + len(OUTSIDE), len(self.parameters)))
        for k, parameter in enumerate(self.parameters):
            if parameter in self._inside:
                above, below = (values_at(self.model_at(_moved(at, k, s)), self.places) for s in (_STEP, -_STEP))
                slopes[: len(self.places), k] = (above - below) / (2 * _STEP)
            for path, factor in zip(parameter.paths, parameter.factors, strict=True):
                if path in OUTSIDE:
                    slopes[len(self.places) + OUTSIDE.index(path), k] = factor * parameter.slope(at[k])
        return Compiled(self.places, centre, self.outside_at(at), slopes)

    def compiled_values(self, at: Coordinates) -> Compiled:
        """Numbers without slopes."""
        values = values_at(self.model_at(at), self.places)
        slopes = np.zeros((len(self.places) + len(OUTSIDE), len(self.parameters)))
        return Compiled(self.places, values, self.outside_at(at), slopes)

    def outside_at(self, at: Coordinates) -> NDArray[np.float64]:
        """Current and offsets `(14,)`."""
        found = np.array([self.outside.get(path, 0.0) for path in OUTSIDE])
        for parameter, value in zip(self.parameters, self.values(at), strict=True):
            for path, factor in zip(parameter.paths, parameter.factors, strict=True):
                if path in OUTSIDE:
                    found[OUTSIDE.index(path)] = value * factor
        return found

    def _find_places(self, start: Coordinates) -> list[Place]:
        here = dict(numbers_of(self.model))
        found: dict[Place, None] = {}
        for k, parameter in enumerate(self.parameters):
            if parameter not in self._inside:
                continue
            moved = dict(numbers_of(self.model_at(_moved(start, k, 1e-3))))
            if moved.keys() != here.keys():
                raise InputError(
                    f"plan: parameters.{parameter.name}: it changes the kind of the model, not only numbers"
                )
            mine = [place for place in here if moved[place] != here[place]]
            if not mine:
                raise InputError(f"plan: parameters.{parameter.name}: nothing in this vehicle's motion depends on it")
            tables = [place for place in mine if any(isinstance(x, str) and x.startswith("[") for x in place)]
            if tables:
                raise InputError(f"plan: parameters.{parameter.name}: it goes into a table, which has no gradient")
            found.update(dict.fromkeys(mine))
        return list(found)


def _moved(at: Coordinates, k: int, by: float) -> list[float]:
    return [x + by * (i == k) for i, x in enumerate(at)]


def listed(node: Any) -> Any:
    """Tuples as lists, all the way down."""
    if isinstance(node, Mapping):
        return {key: listed(value) for key, value in node.items()}
    return [listed(value) for value in node] if isinstance(node, (list, tuple)) else node
