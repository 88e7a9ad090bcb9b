"""Fields that are functions of your own, "module:function", written with Dr.Jit operations.

The function is called while a frozen call is recorded, so it must be pure: what it returns may depend on its
arguments only.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import drjit as dr

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.config.trust import CodeTarget
from pelagos.errors import ScenarioError
from pelagos.jit import Array
from pelagos.ocean.current import Current
from pelagos.ocean.site import Site


class PythonCurrentConfig(Strict):
    """A current given by a Python function (position, t) -> velocity."""

    type: Literal["python"] = "python"
    """The kind of current."""
    function: CodeTarget
    """ "module:function"; takes `Array3f64` NWU [m] and `Float64` [s], gives `Array3f64` NWU [m/s]."""

    def build(self, site: Site) -> Current:
        """The component on the device."""
        return FunctionCurrent(find_function(self.function, vector=True))


@dataclass
class FunctionCurrent:
    """Attributes: function: (position, t) -> velocity."""

    function: Callable[[Array, Array], Array]

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`."""
        return jit.Array3f64(self.function(position, t))


def find_function(name: str, *, vector: bool) -> Callable[[Array, Array], Array]:
    """Import a function and try it once.

    Raises:
        ScenarioError: it cannot be imported, fails, or does not give numbers.
    """
    module, _, attribute = name.partition(":")
    try:
        function = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError, ValueError) as error:
        raise ScenarioError(f"function {name!r} cannot be imported as 'module:function': {error}") from error
    position, t = jit.Array3f64(1.0, 2.0, -3.0), jit.Float64(1.0)
    try:
        found: Any = function(position, t)
        result = jit.Array3f64(found) if vector else jit.Float64(found)
        finite = bool(dr.all(dr.isfinite(result), axis=None))
    except Exception as error:
        raise ScenarioError(f"function {name!r} failed when tried: {type(error).__name__}: {error}") from error
    if not finite:
        raise ScenarioError(f"function {name!r} gives a value that is not finite at (1, 2, -3), t = 1")
    return function  # type: ignore[no-any-return]
