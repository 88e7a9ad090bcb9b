"""Checks of what a recorded kernel may do: take arrays as arguments only, and change nothing besides its results.

Dr.Jit records a kernel when it first meets arguments of a size, and from then on replays the recording: an array that
the kernel names but is not given is not in it, and a change to an object happens in the recording alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from types import FunctionType, MethodType
from typing import Any, Final

from pelagos.errors import KernelError

_VARIABLE: Final = re.compile(r"Variable r(\d+)\[\d+\].* was created before recording")
_DEPTH: Final = 5  # closures within closures that are looked into
_READ: Final = "jit_var_read()"
_TRUTH: Final = "implicit conversion to 'bool'"


def watched(owner: Callable[..., Any], kernel: Callable[..., Any], *arguments: Any) -> Any:
    """Run a kernel that is being recorded.

    Raises:
        KernelError: it has changed an attribute of an object that it belongs to, or a variable around it.
    """
    before = [(thing, _contents(vars(thing))) for thing in _objects(owner)]
    around = _variables_around(owner)
    result = kernel(*arguments)
    for thing, attributes in before:
        for name, content in _contents(vars(thing)).items():
            if name not in attributes or attributes[name] != content:
                raise KernelError(_kept(owner, f"sets 'self.{name}' of {type(thing).__name__}"))
    for variable, content in _variables_around(owner).items():
        if variable in around and around[variable] != content:
            raise KernelError(_kept(owner, f"sets '{variable[1]}', a variable around it,"))
    return result


def explained(error: RuntimeError, owner: Callable[..., Any]) -> BaseException:
    """An error of Dr.Jit in other words: what the kernel itself raised, or what a recorded kernel may not do."""
    cause: BaseException | None = error
    innermost: BaseException = error
    while cause is not None:
        if not isinstance(cause, RuntimeError) or isinstance(cause, (NotImplementedError, RecursionError)):
            return cause
        innermost = cause
        if found := _VARIABLE.search(str(cause)):
            name = next(_names_of(owner, int(found[1])), "an array made before it was recorded")
            return KernelError(
                f"{_called(owner)} uses {name}, which is none of its arguments. A recorded kernel sees only arrays "
                "that it is given: pass it in the call, or make it a Python number"
            )
        cause = cause.__cause__ or cause.__context__
    if _TRUTH in str(innermost):
        return KernelError(
            f"{_called(owner)} asks an array whether it is true (`if`, `while`, `and`, `or`, `not`, `min`, `max`), but "
            "each lane has an answer of its own: choose by dr.select(mask, a, b), and join masks by & | ~"
        )
    if _READ in str(innermost):
        return KernelError(
            f"{_called(owner)} reads the value of an array (`array[0]`, `print`, `float`, `if`), but values exist only "
            "when a recorded kernel runs: choose by dr.select, pick by dr.gather, and return what you want to see"
        )
    return error


def _kept(owner: Callable[..., Any], what: str) -> str:
    return (
        f"{_called(owner)} {what} while it is recorded: that would happen in the recording only, never again. A kernel "
        "keeps nothing; what changes from reading to reading follows from its arguments (motion.tick, motion.t_ns)"
    )


def _contents(variables: Mapping[str, Any]) -> dict[str, Any]:
    """Identity of each variable's value, and of the members of lists, sets and dictionaries."""
    return {name: _identity(value) for name, value in variables.items()}


def _identity(value: Any) -> Any:
    if isinstance(value, dict):
        return id(value), tuple(value), tuple(map(id, value.values()))
    return (id(value), tuple(map(id, value))) if isinstance(value, (list, set)) else id(value)


def _variables_around(owner: Callable[..., Any]) -> dict[tuple[int, str], Any]:
    """Identity of what the functions of a kernel find in variables of their modules, and of functions around them."""
    found: dict[tuple[int, str], Any] = {}
    for place, inner in enumerate(_functions(owner)):
        around = {name: inner.__globals__[name] for name in inner.__code__.co_names if name in inner.__globals__}
        cells = zip(inner.__code__.co_freevars, inner.__closure__ or (), strict=True)
        around |= {name: _content(cell) for name, cell in cells}
        found |= {(place, name): content for name, content in _contents(around).items()}
    return found


def _called(owner: Callable[..., Any]) -> str:
    """Name of a kernel in error messages: that of the method or function in the innermost closure."""
    inner = [f for f in _functions(owner) if f.__module__ != __name__]
    return f"the kernel {inner[-1].__qualname__}" if inner else "a kernel"


def _functions(function: Any, depth: int = _DEPTH) -> Iterator[Any]:
    """A function, and those that its closure names."""
    if isinstance(function, MethodType):
        yield function.__func__
    elif isinstance(function, FunctionType):
        yield function
        for cell in function.__closure__ or () if depth else ():
            yield from _functions(_content(cell), depth - 1)


def _content(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # not yet set
        return None


def _objects(function: Any, depth: int = _DEPTH) -> Iterator[Any]:
    """Objects whose methods a function is, or calls by its closure; those of this package's own machinery not."""
    if isinstance(function, MethodType):
        if hasattr(function.__self__, "__dict__") and not isinstance(function.__self__, type):
            yield function.__self__
    elif isinstance(function, FunctionType) and depth:
        for cell in function.__closure__ or ():
            yield from _objects(_content(cell), depth - 1)


def _names_of(function: Any, index: int) -> Iterator[str]:
    """Ways by which a function reaches the array with an index of Dr.Jit: "'self.gain'", "'table' of its closure"."""
    for thing in _objects(function):
        for name, value in vars(thing).items():
            if index in _indices(value):
                yield f"'self.{name}' of {type(thing).__name__}"
    for inner in _functions(function):
        for name, cell in zip(inner.__code__.co_freevars, inner.__closure__ or (), strict=True):
            if index in _indices(_content(cell)):
                yield f"'{name}', a variable around it"
        for name in inner.__code__.co_names:
            if index in _indices(inner.__globals__.get(name)):
                yield f"'{name}', a variable of its module"


def _indices(value: Any, depth: int = 3) -> set[int]:
    """Dr.Jit's indices of an array, or of all arrays in a struct, list or dictionary."""
    import drjit as dr

    if dr.is_array_v(value):
        if dr.depth_v(value) > 1:
            return {i for part in value for i in _indices(part)}
        return {value.index & 0xFFFFFFFF} if hasattr(value, "index") else set()
    if depth == 0:
        return set()
    if isinstance(value, (list, tuple)):
        return {i for part in value for i in _indices(part, depth - 1)}
    if isinstance(value, dict):
        return {i for part in value.values() for i in _indices(part, depth - 1)}
    if hasattr(type(value), "DRJIT_STRUCT"):
        return {i for part in vars(value).values() for i in _indices(part, depth - 1)}
    return set()
