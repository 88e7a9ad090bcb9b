"""libLLVM, by which Dr.Jit compiles for the processor: found, or said how to install, and held to fewer lanes."""

from __future__ import annotations

import os
import platform
import re
from pathlib import Path
from typing import Final

from pelagos.errors import DeviceError

MIN_LLVM: Final = 16  # 14 is refused by Dr.Jit, 15 aborts the process on AVX-512 machines
LANES: Final = ("4", "8", "16")  # of PELAGOS_LANES
_CALLS: Final = ("_Z21jit_llvm_vector_widthv", "_Z19jit_llvm_target_cpuv", "_Z24jit_llvm_target_featuresv",
                 "_Z19jit_llvm_set_targetPKcS0_j")  # fmt: skip


def find_llvm() -> Path:
    """The newest installed libLLVM that Dr.Jit can use.

    Raises:
        DeviceError: none is installed, or `DRJIT_LIBLLVM_PATH` names one that cannot be used.
    """
    named = os.environ.get("DRJIT_LIBLLVM_PATH")
    if named:
        version = llvm_version(Path(named))
        if not Path(named).exists() or (version is not None and version < MIN_LLVM):
            raise DeviceError(
                f"DRJIT_LIBLLVM_PATH={named} is missing or older than LLVM {MIN_LLVM}. {_how_to_install()}"
            )
        _refuse_unusable(Path(named))
        return Path(named)
    found = [(v, p) for p in _candidates() if (v := llvm_version(p)) is not None]
    usable = [(v, p) for v, p in found if v >= MIN_LLVM]
    if not usable:
        old = f" (found only version {max(v for v, _ in found)})" if found else ""
        raise DeviceError(
            f"Pelagos needs LLVM {MIN_LLVM} or newer on the CPU, and none was found{old}. {_how_to_install()}"
        )
    return max(usable, key=lambda pair: pair[0])[1]


def _refuse_unusable(path: Path) -> None:
    """Raises DeviceError where a file is no library that this process can load, or another than a recent libLLVM."""
    import ctypes

    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise DeviceError(f"DRJIT_LIBLLVM_PATH={path} cannot be loaded: {error}. {_how_to_install()}") from None
    if not hasattr(library, "LLVMGetVersion"):  # in the C interface since LLVM 16
        raise DeviceError(f"DRJIT_LIBLLVM_PATH={path} is no libLLVM {MIN_LLVM} or newer. {_how_to_install()}")


def llvm_version(path: Path) -> int | None:
    """The major version that a libLLVM's file name, or the target of its link, states; None if it states none."""
    for name in (path.name, path.resolve().name):
        match = re.search(r"LLVM(?:-C)?[-.]?(?:so\.|dylib\.)?(\d+)", name)
        if match:
            return int(match[1])
    match = re.search(r"llvm[@-]?(\d+)", str(path.resolve()))
    return int(match[1]) if match else None


def _candidates() -> list[Path]:
    roots = os.environ.get("PELAGOS_LLVM_SEARCH")
    if roots is not None:
        folders = [Path(r) for r in roots.split(os.pathsep) if r]
    else:
        folders = [Path(p) for p in (
            "/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib", "/usr/local/lib",
            "/opt/homebrew/opt/llvm/lib", "/usr/local/opt/llvm/lib", "C:/Program Files/LLVM/bin")]  # fmt: skip
        folders += sorted(Path("/usr/lib").glob("llvm*/lib")) + sorted(Path("/opt/homebrew/Cellar").glob("llvm*/*/lib"))
    patterns = ("libLLVM*.so*", "libLLVM*.dylib", "LLVM-C.dll")
    return [p for folder in folders for pattern in patterns for p in sorted(folder.glob(pattern))]


def limit_lanes(told: str) -> None:
    """Have Dr.Jit compile for at most so many numbers at once: for AVX-512's sixteen it takes up to three times as long
    as for eight, AVX2's, in kernels that have not enough registers for pairs of eight doubles.

    Dr.Jit has the call in C++ alone, so that it is called in its library by its mangled name.

    Raises:
        DeviceError: another number than `LANES`, or a Dr.Jit whose library has no such call.
    """
    import ctypes

    import drjit

    if told not in LANES:
        raise DeviceError(f"PELAGOS_LANES must be {', '.join(LANES[:-1])} or {LANES[-1]}, not {told!r}")
    libraries = [*Path(drjit.__file__).parent.glob("*drjit-core.*")]
    library = ctypes.CDLL(str(libraries[0])) if libraries else None
    if not all(hasattr(library, name) for name in _CALLS):
        raise DeviceError(f"PELAGOS_LANES={told}: Dr.Jit {drjit.__version__} lets nobody choose here; unset it")
    width, cpu, features, set_target = (getattr(library, name) for name in _CALLS)
    cpu.restype = features.restype = ctypes.c_char_p
    set_target.argtypes, set_target.restype = (ctypes.c_char_p, ctypes.c_char_p, ctypes.c_uint32), None
    if width() > int(told):
        set_target(cpu(), features(), int(told))


def _how_to_install() -> str:
    system = platform.system()
    if system == "Darwin":
        return "Install it with: brew install llvm"
    if system == "Windows":
        return "Install LLVM from its Windows installer, then set DRJIT_LIBLLVM_PATH to LLVM-C.dll"
    return (
        "On Debian or Ubuntu: apt-get install libllvm19 (Fedora: dnf install llvm-libs). "
        "Or set DRJIT_LIBLLVM_PATH to your libLLVM"
    )
