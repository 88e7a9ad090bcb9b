"""A term that a user writes: a function named in the scenario, or brought by an installed package."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, field_validator

from pelagos import jit
from pelagos.config.trust import CodeTarget
from pelagos.errors import InputError, LookupFailed
from pelagos.hydro.algebra import Matrix, Vector, matvec
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, PartConfig, numbers
from pelagos.vehicles.wetness import Keeps

GROUP: Final = "pelagos.dynamics"
"""The group of entry points in which packages name their functions."""

UserTerm = Callable[[Flow, Mapping[str, float]], Vector]
"""`f(flow, parameters) -> (X, Y, Z, K, M, N)`, FRD about the origin [N], [N m], in Dr.Jit arithmetic.

`flow` is what every term sees (`pelagos.vehicles.flow.Flow`: position, rotation, nu, nu_r, actuators, ...); each entry
of its result is a number or an array with one lane a vehicle. The function is traced once: it may not branch on values.
"""

NumpyTerm = Callable[["NumpyFlow", Mapping[str, float]], ArrayLike]
"""`f(flow, parameters) -> (n, 6)` (or `(6,)`), the same in NumPy, with any Python in it; called in every step."""


@dataclass(frozen=True)
class NumpyFlow:
    """Flow past n vehicles as a function in NumPy sees it, NED and FRD, float64.

    Attributes:
        position: `(n, 3)` of the body's origin [m].
        immersion: `(n,)` depth below the water's surface [m].
        rotation: `(n, 3, 3)` FRD -> NED.
        nu: `(n, 6)` velocity over ground [m/s], [rad/s].
        nu_r: `(n, 6)` velocity relative to the water.
        actuators: by name, `(n,)` states as forces see them.
    """

    position: NDArray[np.float64]
    immersion: NDArray[np.float64]
    rotation: NDArray[np.float64]
    nu: NDArray[np.float64]
    nu_r: NDArray[np.float64]
    actuators: Mapping[str, NDArray[np.float64]]

    @staticmethod
    def of(flow: Flow) -> NumpyFlow:
        """`flow` brought to the host."""
        flat = [*flow.position, flow.immersion, *(x for row in flow.rotation for x in row), *flow.nu, *flow.nu_r]
        table = _columns([*flat, *flow.actuators.values()])
        rotation = table[:, 4:13].reshape(-1, 3, 3)
        actuators = dict(zip(flow.actuators, table[:, 25:].T, strict=True))
        return NumpyFlow(table[:, 0:3], table[:, 3], rotation, table[:, 13:19], table[:, 19:25], actuators)


class FunctionConfig(PartConfig):
    """Your own force, or your own dynamics."""

    type: Literal["function"]
    target: CodeTarget
    """"module:function" that can be imported, or the name of an entry point in the group "pelagos.dynamics"."""
    arrays: Literal["drjit", "numpy"] = "drjit"
    """What the function computes with: Dr.Jit, traced once and fast, or NumPy, called in every step and far slower."""
    gives: Literal["wrench", "acceleration"] = "wrench"
    """Force and moment [N], [N m], or the acceleration that they cause with the vehicle's whole mass matrix [m/s^2],
    [rad/s^2]; without other terms, and with `coriolis: {rigid: none}`, that is all of the dynamics."""
    parameters: dict[str, float] = Field(default_factory=dict)
    """Handed to the function."""

    @field_validator("target")
    @classmethod
    def _form(cls, value: str) -> str:
        module, colon, name = value.partition(":")
        if not module or (colon and not name.isidentifier()):
            raise ValueError(f"write module:function, such as my_package.forces:tether, not {value!r}")
        return value

    def build(self, body: Body) -> Function | NumpyFunction:
        """The term.

        Raises:
            InputError: the module cannot be imported, or has no such function.
            LookupFailed: no package brings a function of this name.
        """
        function = _load(self.target)
        mass = numbers(body.mass_matrix) if self.gives == "acceleration" else None
        kind = NumpyFunction if self.arrays == "numpy" else Function
        return kind(function, self.parameters, mass)


@dataclass(frozen=True)
class Function:
    """function: the user's; parameters: handed to it; mass: M `(6, 6)` where it gives an acceleration."""

    keeps: ClassVar[Keeps] = "always"

    function: UserTerm
    parameters: Mapping[str, Any]
    mass: Matrix | None = None

    def wrench(self, flow: Flow) -> Vector:
        """Wrench of the function (6).

        Raises:
            InputError: it does not return six entries.
        """
        load = self.function(flow, self.parameters)
        if len(load) != 6:
            raise InputError(f"{_name(self.function)} must return six entries (X, Y, Z, K, M, N), not {len(load)}")
        return _force(load, flow, self.mass)


@dataclass(frozen=True)
class NumpyFunction:
    """function: the user's, on the host; parameters, mass: as for `Function`."""

    keeps: ClassVar[Keeps] = "always"

    function: NumpyTerm
    parameters: Mapping[str, Any]
    mass: Matrix | None = None
    on_host: bool = True

    def wrench(self, flow: Flow) -> Vector:
        """Wrench of the function (6), now: a step that contains it cannot be recorded.

        Raises:
            InputError: it does not return `(n, 6)`, or something is not finite; or the step is being recorded.
        """
        name = _name(self.function)
        if dr.flag(dr.JitFlag.FreezingScope) or dr.flag(dr.JitFlag.SymbolicScope):
            raise InputError(f"{name} computes with NumPy: a step with it can be neither frozen nor in a symbolic loop")
        seen = NumpyFlow.of(flow)
        n = len(seen.position)
        load = np.asarray(self.function(seen, self.parameters), dtype=np.float64)
        if load.shape not in ((n, 6), (6,)):
            raise InputError(f"{name} must return the shape ({n}, 6), not {load.shape}")
        if not np.isfinite(load).all():
            raise InputError(f"{name} returned a value that is not finite: {load[~np.isfinite(load)][0]}")
        columns = np.ascontiguousarray(np.broadcast_to(load, (n, 6)).T)
        return _force([jit.Float64(column) for column in columns], flow, self.mass)


def _force(load: Vector, flow: Flow, mass: Matrix | None) -> Vector:
    """The wrench: `load` itself, or what makes it the vehicle's acceleration."""
    if mass is None:
        return load
    return matvec(mass, [a - c for a, c in zip(load, flow.current_rate, strict=True)])


def _load(target: str) -> Callable[..., Any]:
    module, colon, name = target.partition(":")
    try:
        if colon:
            function = getattr(import_module(module), name)
        else:
            brought = {point.name: point for point in entry_points(group=GROUP)}
            if target not in brought:
                raise LookupFailed("dynamics", target, brought)
            function = brought[target].load()
    except (ImportError, AttributeError) as error:
        raise InputError(f"the term {target!r} cannot be loaded: {error}") from error
    if not callable(function):
        raise InputError(f"the term {target!r} is not a function")
    return function  # type: ignore[no-any-return]


def _name(function: Callable[..., Any]) -> str:
    return getattr(function, "__name__", repr(function))


def _columns(entries: list[Array]) -> NDArray[np.float64]:
    """`(n, k)` of k entries, numbers or arrays."""
    arrays = [jit.Float64(e) for e in entries]
    dr.eval(arrays)
    host = [np.array(a) for a in arrays]
    n = max(len(a) for a in host)
    return np.stack([np.broadcast_to(a, (n,)) for a in host], axis=-1)
