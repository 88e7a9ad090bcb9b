"""Recorded programs: a kernel is recorded once, and its results come back by name in one transfer.

Each transfer from the device to NumPy costs as much as a small kernel. So a program packs all results of its kernel
into one array of rows, one row a lane, and hands them back under the names and with the types that the kernel gave.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import KernelError
from pelagos.jit import Array

Results: TypeAlias = Mapping[str, Array | Sequence[Array]]
"""By name: one value a lane, or several (a sequence, or a vector such as `Array3f64`)."""


class Program:
    """A kernel with named results.

    Args:
        kernel: from Dr.Jit arrays to `Results`. It is recorded when it first meets arguments of a size; what it does
            besides its results (to `self`, say) would happen in the recording only, and is refused.
        record: turns a function of arrays into its recorded form: `jit.freeze`, or what a scene or a sonar offers.
    """

    def __init__(
        self, kernel: Callable[..., Results], record: Callable[[Callable[..., Any]], Callable[..., Any]] | None = None
    ) -> None:
        self._layout: dict[str, tuple[int, np.dtype[Any], bool]] = {}

        def packed(*arguments: Any) -> Array:
            return self._packed(kernel(*arguments))

        self._recorded = (jit.freeze if record is None else record)(packed)

    def __call__(self, *arguments: Any) -> dict[str, NDArray[Any]]:
        """Results by name: `(m,)` of one value a lane, `(m, k)` of k values.

        Double for `Float64`, single for `Float`, `bool` for masks, `uint32` for `UInt32`.
        """
        rows = self._recorded(*arguments).numpy().reshape(-1, sum(size for size, _, _ in self._layout.values()))
        found: dict[str, NDArray[Any]] = {}
        first = 0
        for name, (size, kind, single) in self._layout.items():
            values = rows[:, first] if single else rows[:, first : first + size]
            found[name] = values > 0.5 if kind == np.bool_ else values.astype(kind, copy=False)
            first += size
        return found

    def _packed(self, results: Results) -> Array:
        """All results as one `Float64` of rows, lane after lane; remembers what is where."""
        if not isinstance(results, Mapping):
            raise KernelError(
                f'a kernel returns its results by name, {{"data": ..., "truth": ...}}, not {_kind_of(results)}'
            )
        columns: list[Array] = []
        for name, values in results.items():
            single = dr.is_array_v(values) and dr.depth_v(values) == 1
            if not dr.is_array_v(values) and not _is_sequence_of_arrays(values):
                raise KernelError(
                    f"result {name!r} of a kernel is {_kind_of(values)}: give an array of Dr.Jit with one value a lane "
                    "(jit.Float64(3.0) for a constant), or a sequence of such"
                )
            parts = [values] if single else list(values)
            self._layout[name] = (len(parts), _kind(parts[0]), bool(single))
            columns += (jit.Float64(dr.select(p, 1.0, 0.0)) if dr.is_mask_v(p) else jit.Float64(p) for p in parts)
        return dr.ravel(jit.ArrayXf64(columns))


def _kind(column: Array) -> np.dtype[Any]:
    """The NumPy type of a column, which a row of doubles keeps exactly."""
    if dr.is_mask_v(column):
        return np.dtype(np.bool_)
    if dr.is_integral_v(column):
        return np.dtype(np.uint32)
    return np.dtype(np.float32 if dr.itemsize_v(column) == 4 else np.float64)


def _is_sequence_of_arrays(values: Any) -> bool:
    return isinstance(values, Sequence) and len(values) > 0 and all(dr.is_array_v(v) for v in values)


def _kind_of(value: Any) -> str:
    """Type of a value in an error message."""
    return "None" if value is None else f"of type {type(value).__module__}.{type(value).__qualname__}"
