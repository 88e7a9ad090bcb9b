"""The compute device and the array types, chosen once, at first use.

`from pelagos import jit` costs nothing and needs no device. The first attribute that names an array type
(`jit.Float64`, `jit.mi`, ...) finds LLVM or CUDA, sets the Mitsuba variant, and keeps the types in this module.

Environment: `PELAGOS_DEVICE=auto|cpu|cuda` (default auto: CUDA when a device and OptiX are usable),
`PELAGOS_THREADS=N` (default all cores), `PELAGOS_LANES=4|8|16` (numbers that a kernel takes at once, at most; default
what the processor has), `DRJIT_LIBLLVM_PATH=FILE` (a libLLVM of your choice, 16 or newer).

Types, all differentiable: single precision for rays and images (`Float`, `Array2f`, `Array3f`, `Quaternion4f`),
double for vehicles and the ocean (`Float64`, `Array2f64`, `Array3f64`, `Array4f64`), `UInt32`, `UInt64`, `Int32`,
`Int64`, `Bool`.
"""

from __future__ import annotations

import dataclasses
import functools
import gc
import os
import threading
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias, TypeVar, cast, dataclass_transform

from pelagos.errors import DeviceError
from pelagos.kernel_check import explained, watched
from pelagos.llvm import find_llvm, limit_lanes
from pelagos.subnormals import FLUSHING, flush_subnormals, forget_threads

MAX_THREADS: Final = 1024
Device: TypeAlias = Literal["cpu", "cuda"]

# Dr.Jit's arrays overload every operator; naming them Any keeps physics readable, and the checks on shapes are tests.
Array: TypeAlias = Any

_NAMES: Final = {
    "Float": "Float32", "Array2f": "Array2f", "Array3f": "Array3f", "Array4f": "Array4f",
    "Quaternion4f": "Quaternion4f", "Float64": "Float64", "Array2f64": "Array2f64", "Array3f64": "Array3f64",
    "Array4f64": "Array4f64", "Matrix3f": "Matrix3f", "Matrix3f64": "Matrix3f64", "UInt32": "UInt32",
    "UInt64": "UInt64", "Int32": "Int", "Int64": "Int64", "Bool": "Bool", "Array3u": "Array3u",
    "ArrayXf": "ArrayXf", "ArrayXf64": "ArrayXf64", "TensorXf": "TensorXf", "TensorXf64": "TensorXf64",
    "Complex2f": "Complex2f", "Complex2f64": "Complex2f64",
}  # fmt: skip

if TYPE_CHECKING:
    mi: Any
    device: Device
    Float: Any
    Array2f: Any
    Array3f: Any
    Array4f: Any
    Quaternion4f: Any
    Float64: Any
    Array2f64: Any
    Array3f64: Any
    Array4f64: Any
    Matrix3f: Any
    Matrix3f64: Any
    UInt32: Any
    UInt64: Any
    Int32: Any
    Int64: Any
    Bool: Any
    Array3u: Any
    ArrayXf: Any
    ArrayXf64: Any
    TensorXf: Any
    TensorXf64: Any
    Complex2f: Any
    Complex2f64: Any


def __getattr__(name: str) -> Any:
    if name in _NAMES or name in ("mi", "device"):
        _start()
        return globals()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


_Class = TypeVar("_Class", bound=type)
_PAGE: Final = 4096  # bytes
_PACKET: Final = 256  # bytes, at least those of sixteen lanes of eight


@dataclass_transform(field_specifiers=(dataclasses.field,))
def struct(cls: _Class) -> _Class:
    """A dataclass of arrays (lists, numbers, other structs): what frozen functions and loops take and give back.

    An ordinary dataclass works too, but Dr.Jit asks Python for its fields whenever it passes one: 15-25 % of the time
    of a frozen call of some forty arrays. What it needs to walk a class natively is the table `DRJIT_STRUCT` and a way
    to make an empty object. A class with a property `size_key` says in one value what the sizes of its arrays follow
    from (lanes). The sizes of a struct stay what they were when a frozen function first saw it.
    """
    made: Any = dataclasses.dataclass(cls)
    fill = made.__init__

    @functools.wraps(fill)
    def construct(self: Any, *values: Any, **named: Any) -> None:
        if values or named:
            fill(self, *values, **named)

    made.__init__ = construct
    made.DRJIT_STRUCT = {field.name: object for field in dataclasses.fields(made)}
    return cls


_SLIMMED: Final[weakref.WeakValueDictionary[Any, type]] = weakref.WeakValueDictionary()
_Value = TypeVar("_Value")


def without_constants(value: _Value) -> _Value:
    """The same struct, of a class that holds what is no array: names, numbers, None, empty lists and dictionaries.

    Dr.Jit looks at each of them in every frozen call, 1.1 us apiece; at a class it looks once, for all of it. Structs
    in it, in its lists and in its dictionaries are made so likewise.
    """
    return cast(_Value, _free_of_constants(value))


def _free_of_constants(value: Any) -> Any:
    if isinstance(value, list):
        return [_free_of_constants(v) for v in value]
    if isinstance(value, dict):
        return {k: _free_of_constants(v) for k, v in value.items()}
    cls: Any = type(value)
    if not hasattr(cls, "DRJIT_STRUCT") or not hasattr(cls, "__dataclass_fields__"):
        return value
    parts = {name: _free_of_constants(getattr(value, name)) for name in cls.DRJIT_STRUCT}
    fixed = {
        k: v
        for k, v in parts.items()
        if v is None or isinstance(v, (str, int, float)) or (isinstance(v, (list, dict)) and not v)
    }
    key = (cls, tuple((k, repr(v)) for k, v in fixed.items()))
    arrays = {k: kind for k, kind in cls.DRJIT_STRUCT.items() if k not in fixed}
    body = {**fixed, "DRJIT_STRUCT": arrays, "__module__": cls.__module__}
    made = _SLIMMED.setdefault(key, type(cls.__name__, (cls,), body))()
    for name, part in parts.items():
        if name not in fixed:
            setattr(made, name, part)
    return made


def align(*values: Any) -> None:
    """Put arrays, and those in structs, lists and dictionaries, into memory of Dr.Jit's own, evaluated, in place.

    What is made of a NumPy array shares its memory, which may begin anywhere. Dr.Jit reads aligned memory faster, by
    other instructions: a kernel for the one must be compiled anew for the other. So all tables that are made once, and
    then go into kernels, are aligned.
    """
    import drjit as dr

    for value in values:
        kind = type(value)
        if dr.is_array_v(kind) and dr.depth_v(kind) > 1:
            for i in range(len(value)):
                part = value[i]
                align(part)
                value[i] = part
        elif dr.is_array_v(kind):
            if dr.is_mask_v(kind):
                value &= dr.opaque(kind, True)  # in place
            else:
                value += dr.opaque(kind, -0.0 if dr.is_float_v(kind) else 0)  # signs of 0 stay
            dr.make_opaque(value)  # each for itself: a kernel for several would know which of them were aligned
        elif hasattr(kind, "DRJIT_STRUCT"):
            align(*(getattr(value, name) for name in kind.DRJIT_STRUCT))
        elif isinstance(value, (list, tuple)):
            align(*value)
        elif isinstance(value, dict):
            align(*value.values())
    dr.sync_thread()  # the NumPy arrays may go


def from_numpy(kind: Any, values: Any) -> Array:
    """Flat values of a NumPy array in memory of Dr.Jit's own, see `align`."""
    import drjit as dr
    import numpy as np

    made = kind(padded(np.asarray(values).astype(np.dtype(dr.type_v(kind).name.lower()), copy=False)))
    align(made)
    return made


def to_rows(vectors: Array) -> Any:
    """Evaluated vectors as rows `(n, k)` of a NumPy array: component by component no kernel is needed for it."""
    import numpy as np

    return np.stack(np.broadcast_arrays(*(np.array(part) for part in vectors)), axis=-1)


def padded(values: Any) -> Any:
    """Flat values of a NumPy array, aligned, whose end is a packet of lanes or more away from that of its page.

    A kernel reads whole packets, and so beyond the end of shared memory, which crashes if the next page is nobody's.
    """
    import numpy as np

    flat = np.ascontiguousarray(values).reshape(-1)
    if flat.ctypes.data % _PACKET == 0 and (flat.ctypes.data + flat.nbytes - 1) % _PAGE < _PAGE - _PACKET:
        return flat
    room = np.empty(flat.nbytes + 2 * _PACKET, dtype=np.uint8)
    moved = room[-room.ctypes.data % _PACKET :][: flat.nbytes].view(flat.dtype)
    moved[:] = flat
    return moved


def freeze(function: Callable[..., Any], *scenes: Any) -> Callable[..., Any]:
    """`dr.freeze`, recorded anew for every combination of argument sizes, and never interrupted by garbage collection.

    With `scenes`, it is what `function(*scenes)` makes that is frozen: a frozen function sees only those scenes that
    its own body names. It checks all that its body names in every call (2 us a thing), so it names nothing else.

    A recording bakes in whatever was derived from a width (`dr.width`, `dr.concat`, `dr.ravel`, an allocated output);
    played back with other sizes it would write past the end of memory. And an array that shares memory with NumPy, if
    it is freed while something is recorded, ends the process.
    """
    import drjit as dr

    def seeing(*arguments: Any) -> Any:
        return watched(function, function(*scenes), *arguments)

    def blind(*arguments: Any, _function: Callable[..., Any] = function) -> Any:  # by default: a name would cost 2 us
        return watched(_function, _function, *arguments)

    frozen = dr.freeze(seeing if scenes else blind, state_fn=_Sizes(), warn_after=1000)

    def call(*arguments: Any) -> Any:
        collects = gc.isenabled()
        gc.disable()
        if threading.get_ident() not in FLUSHING:
            flush_subnormals()
        try:
            return frozen(*arguments)
        except RuntimeError as error:
            raise explained(error, function) from error
        finally:
            if collects:
                gc.enable()

    return call


class _Sizes:
    """Names the combinations of argument sizes that a frozen function meets, each by an object of its own.

    Dr.Jit 1.5 looks only once at an object that it meets twice in one call. A number would not do for a name: Python
    has only one 2, and where an argument holds a 2 already, it would count as seen, whatever it stands for.

    To measure all arguments of a sonar's ping takes as long as its smallest kernels (20 us), and most of them are the
    same structs every time: these are measured once.
    """

    def __init__(self) -> None:
        self._names: dict[Any, object] = {}
        self._before: dict[int, tuple[weakref.ref[Any], Any]] = {}

    def __call__(self, *arguments: Any) -> object:
        found, known = [], self._before.get
        for place, argument in enumerate(arguments):
            before = known(place)
            if before is not None and before[0]() is argument:
                found.append(before[1])
                continue
            kind = _KINDS.get(type(argument)) or _kind_of(type(argument))
            if kind == "array":
                found.append(len(argument))
                continue
            found.append(argument.size_key if kind == "keyed" else _size(argument))
            if kind != "other":
                self._before[place] = weakref.ref(argument), found[-1]
        return self._names.setdefault(tuple(found), object())


_KINDS: Final[dict[type, str]] = {}  # how arguments of a type are measured


def _kind_of(argument: type) -> str:
    """ "array": by its length; "keyed": a struct with a `size_key`; "struct" another; "other": neither."""
    import drjit as dr

    kind = "other"
    if dr.is_array_v(argument):
        kind = "array" if dr.depth_v(argument) == 1 else "other"
    elif hasattr(argument, "DRJIT_STRUCT"):
        kind = "keyed" if hasattr(argument, "size_key") else "struct"
    return _KINDS.setdefault(argument, kind)


def new_scope() -> None:
    """Have what is computed so far stand before all that follows in a kernel.

    Dr.Jit writes each result's operations down after one another, as far back as they go. Where several results are
    long chains, taking all of them a stage at a time gives the processor something to do while one waits.
    """
    import drjit as dr

    dr.detail.new_scope(dr.backend_v(globals()["Float"]))


def sizes(value: Any) -> Any:
    """Widths of all arrays of a struct, with the structs' own classes, as one value to compare: a `size_key`.

    It walks the whole struct (10 us an array): a struct that is made once and passed often keeps what it gets.
    """
    import drjit as dr

    kind = type(value)
    if dr.is_array_v(kind):
        return dr.width(value)
    if hasattr(kind, "DRJIT_STRUCT"):
        return kind, tuple(sizes(getattr(value, name)) for name in kind.DRJIT_STRUCT)
    if isinstance(value, dict):
        return tuple((name, sizes(part)) for name, part in value.items())
    return tuple(map(sizes, value)) if isinstance(value, (list, tuple)) else None


def _size(argument: Any) -> Any:
    """The width of an argument, or of each of its parts where they differ; what it says itself as its `size_key`."""
    import drjit as dr

    if hasattr(type(argument), "size_key"):  # of an array itself one gets components for any name: swizzling
        return argument.size_key
    try:
        return dr.width(argument)
    except RuntimeError:
        parts = vars(argument).values() if hasattr(argument, "__dict__") else argument
        return tuple(_size(part) for part in parts)


def _start() -> None:
    """Choose the device, load Mitsuba, and fill this module with the types."""
    chosen = _choose_device()
    if chosen == "cpu":
        os.environ["DRJIT_LIBLLVM_PATH"] = str(find_llvm())
    import drjit as dr
    import mitsuba

    mitsuba.set_variant("cuda_ad_rgb" if chosen == "cuda" else "llvm_ad_rgb")
    threads = os.environ.get("PELAGOS_THREADS")
    if threads is not None:
        if not threads.isdecimal() or not 1 <= int(threads) <= MAX_THREADS:
            raise DeviceError(f"PELAGOS_THREADS must be a whole number from 1 to {MAX_THREADS}, not {threads!r}")
        dr.set_thread_count(int(threads))
    if chosen == "cpu" and "PELAGOS_LANES" in os.environ:
        limit_lanes(os.environ["PELAGOS_LANES"])
    flush_subnormals()
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=forget_threads)
    backend = dr.cuda.ad if chosen == "cuda" else dr.llvm.ad
    found = {ours: getattr(backend, theirs) for ours, theirs in _NAMES.items()}
    globals().update(found, mi=mitsuba, device=chosen)


def _choose_device() -> Device:
    asked = os.environ.get("PELAGOS_DEVICE", "auto").lower()
    if asked not in ("auto", "cpu", "cuda"):
        raise DeviceError(f"PELAGOS_DEVICE must be auto, cpu or cuda, not {asked!r}")
    if asked == "cpu":
        return "cpu"
    import drjit as dr

    usable = dr.has_backend(dr.JitBackend.CUDA)
    if asked == "cuda" and not usable:
        raise DeviceError("PELAGOS_DEVICE=cuda, but no usable NVIDIA GPU and driver were found; use PELAGOS_DEVICE=cpu")
    return "cuda" if usable else "cpu"
