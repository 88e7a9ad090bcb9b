"""libLLVM, by which Dr.Jit compiles for the processor: found, or said how to install."""

from __future__ import annotations

import os
import platform
import re
from pathlib import Path
from typing import Final

from pelagos.errors import DeviceError

MIN_LLVM: Final = 16  # 14 is refused by Dr.Jit, 15 aborts the process on AVX-512 machines


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
