"""Mistakes of a kernel's author, each told with its cure when the kernel is recorded."""

from __future__ import annotations

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.errors import KernelError
from pelagos.sensors.recorded import Program, Results


def settled(*values: float):
    array = jit.Float64(list(values))
    dr.make_opaque(array)
    return array


class Gauge:
    def __init__(self) -> None:
        self.gain = settled(2.0, -3.0, 4.0)
        self.tables = {"offset": [settled(1.0, 2.0, 5.0)]}
        self.count = 0

    def scaled(self, x) -> Results:
        return {"y": x * self.gain}

    def shifted(self, x) -> Results:
        return {"y": x + self.tables["offset"][0]}

    def counting(self, x) -> Results:
        self.count += 1
        return {"y": x + self.count}

    def good(self, x, gain) -> Results:
        vector = jit.Array3f64(x, -x, x * gain)
        return {"y": x * gain, "v": vector, "above": x > 0, "row": jit.UInt32(dr.abs(x)), "single": jit.Float(x)}


@pytest.mark.parametrize(
    ("kernel", "named"), [("scaled", r"'self\.gain' of Gauge"), ("shifted", r"'self\.tables' of Gauge")]
)
def test_an_array_that_is_no_argument_is_named(kernel: str, named: str) -> None:
    with pytest.raises(KernelError, match=f"kernel Gauge.{kernel} uses {named}.*pass it in the call"):
        Program(getattr(Gauge(), kernel))(settled(1.0, 2.0, 3.0))


def test_an_array_of_a_closure_is_named() -> None:
    table = settled(1.0, -2.0, 3.0)
    with pytest.raises(KernelError, match=r"uses 'table', a variable around it"):
        Program(lambda x: {"y": x * table})(settled(1.0, 2.0, 3.0))


def test_a_kernel_that_keeps_something_is_refused() -> None:
    with pytest.raises(KernelError, match=r"sets 'self\.count' of Gauge"):
        Program(Gauge().counting)(settled(1.0, 2.0, 3.0))


def test_results_come_back_by_name_with_shape_and_type() -> None:
    gauge = Gauge()
    program = Program(gauge.good)
    for scale in (1.0, -2.0, 1.0):  # recorded once, replayed twice
        x = np.array([1.5, -2.5, 3.25]) * scale
        found = program(settled(*x), gauge.gain)
        np.testing.assert_array_equal(found["y"], x * [2.0, -3.0, 4.0])
        np.testing.assert_array_equal(found["v"], np.stack([x, -x, x * [2.0, -3.0, 4.0]], axis=1))
        assert found["above"].tolist() == (x > 0).tolist()
        assert found["row"].tolist() == np.abs(x).astype(int).tolist()
        assert [found[n].dtype for n in ("y", "v", "above", "row", "single")] == ["f8", "f8", "?", "u4", "f4"]


def test_other_errors_of_a_kernel_pass_unchanged() -> None:
    with pytest.raises(ZeroDivisionError):
        Program(lambda x: {"y": x * (1 / 0)})(settled(1.0))


CALLS = 0


def test_a_kernel_that_changes_a_variable_of_its_module_is_refused() -> None:
    def counting(x) -> Results:
        global CALLS
        CALLS += 1
        return {"y": x + CALLS}

    with pytest.raises(KernelError, match=r"sets 'CALLS', a variable around it"):
        Program(counting)(settled(1.0, 2.0, 3.0))


def test_a_kernel_that_adds_to_a_list_around_it_is_refused() -> None:
    seen: list[int] = []
    with pytest.raises(KernelError, match=r"sets 'seen', a variable around it"):
        Program(lambda x: seen.append(3) or {"y": x + len(seen)})(settled(1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    ("kernel", "cure"),
    [
        (lambda x: {"y": x if x > 2.0 else -x}, "dr.select"),
        (lambda x: {"y": x * x[1]}, "dr.gather"),
        (lambda x: {"y": np.arange(3.0)}, "result 'y' of a kernel is of type numpy.ndarray"),
        (lambda x: {"y": 3.0}, "result 'y' of a kernel is of type builtins.float"),
        (lambda x: {"y": ()}, "result 'y' of a kernel is of type builtins.tuple"),
        (lambda x: (x, x), "returns its results by name"),
        (lambda x: None, "returns its results by name, .* not None"),
    ],
)
def test_what_a_kernel_may_not_do_is_told_with_its_cure(kernel, cure: str) -> None:
    with pytest.raises(KernelError, match=cure):
        Program(kernel)(settled(1.0, 2.0, 3.0))
