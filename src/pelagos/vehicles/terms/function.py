"""A term that a user writes: a function named in the scenario."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal

from pydantic import Field, field_validator

from pelagos.errors import InputError
from pelagos.hydro.algebra import Vector
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, PartConfig

UserTerm = Callable[[Flow, Mapping[str, float]], Vector]
"""`f(flow, parameters) -> (X, Y, Z, K, M, N)`, FRD about the origin [N], [N m], in Dr.Jit arithmetic.

`flow` is what every term sees (`pelagos.vehicles.flow.Flow`: position, rotation, nu, nu_r, ...); each entry of its
result is a number or an array with one lane a vehicle. The function is traced once: it may not branch on values.
"""


class FunctionConfig(PartConfig):
    """Your own force: `target: my_module:my_function`."""

    type: Literal["function"]
    target: str
    """"module:function"; the module must be importable."""
    parameters: dict[str, float] = Field(default_factory=dict)
    """Handed to the function."""

    @field_validator("target")
    @classmethod
    def _form(cls, value: str) -> str:
        module, colon, name = value.partition(":")
        if not (colon and module and name.isidentifier()):
            raise ValueError(f"write module:function, such as my_package.forces:tether, not {value!r}")
        return value

    def build(self, body: Body) -> Function:
        """The term.

        Raises:
            InputError: the module cannot be imported, or has no such function.
        """
        module, _, name = self.target.partition(":")
        try:
            function = getattr(import_module(module), name)
        except (ImportError, AttributeError) as error:
            raise InputError(f"the term {self.target!r} cannot be loaded: {error}") from error
        if not callable(function):
            raise InputError(f"the term {self.target!r} is not a function")
        return Function(function, self.parameters)


@dataclass(frozen=True)
class Function:
    """function: the user's; parameters: handed to it."""

    function: UserTerm
    parameters: Mapping[str, Any]

    def wrench(self, flow: Flow) -> Vector:
        """What the function says (6).

        Raises:
            InputError: it does not return six entries.
        """
        load = self.function(flow, self.parameters)
        if len(load) != 6:
            raise InputError(f"{self.function.__name__} must return six entries (X, Y, Z, K, M, N), not {len(load)}")
        return load
