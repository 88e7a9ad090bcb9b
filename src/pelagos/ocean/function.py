"""Fields that are functions of your own, "module:function", written with Dr.Jit operations.

The function is called while a frozen call is recorded, so it must be pure: what it returns may depend on its
arguments only. Values that it reads from its module or from a function around it are refused; modules, classes and
other functions (of which those of the same module are looked at too) are not.
"""

from __future__ import annotations

import builtins
import dis
import importlib
from collections.abc import Callable
from dataclasses import dataclass
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, Final, Literal

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
    outside = sorted(_read_outside(function))
    if outside:
        raise ScenarioError(
            f"function {name!r} reads {', '.join(outside)} from outside of itself: recorded once, it would never see a "
            "change; make it a constant within the function or a default of an argument (or see `sim.ocean.set`)"
        )
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


def _read_outside(function: object, seen: frozenset[object] = frozenset()) -> set[str]:
    """Names of the values that a function, and those of its module that it calls, read from outside of themselves."""
    if not isinstance(function, FunctionType) or function in seen:
        return set()
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    used = {name: cell.cell_contents for name, cell in cells}
    for name in _globals_of(function.__code__):
        if name in function.__globals__:
            used[name] = function.__globals__[name]
        elif not hasattr(builtins, name):
            used[name] = None
    found = {name for name, value in used.items() if not isinstance(value, _CALLED)}
    for value in used.values():
        if isinstance(value, FunctionType) and value.__globals__ is function.__globals__:
            found |= _read_outside(value, seen | {function})
    return found


def _globals_of(code: CodeType) -> set[str]:
    """Names that a function's code, with all functions in it, looks up in its module."""
    names = {i.argval for i in dis.get_instructions(code) if i.opname in ("LOAD_GLOBAL", "LOAD_NAME")}
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names |= _globals_of(constant)
    return names


_CALLED: Final = (ModuleType, FunctionType, BuiltinFunctionType, type)
