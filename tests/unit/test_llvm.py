"""Which libLLVM is taken of those that are installed."""

from __future__ import annotations

import os

import pytest

from pelagos.errors import DeviceError
from pelagos.llvm import find_llvm, llvm_version


@pytest.fixture
def search(tmp_path, monkeypatch):
    """Folders with libraries of these names, in the order in which they are looked through."""

    def make(*folders):
        paths = []
        for k, names in enumerate(folders):
            paths.append(tmp_path / f"f{k}")
            paths[-1].mkdir()
            for name in names:
                (paths[-1] / name).touch()
        monkeypatch.delenv("DRJIT_LIBLLVM_PATH", raising=False)
        monkeypatch.setenv("PELAGOS_LLVM_SEARCH", os.pathsep.join(["", *map(str, paths)]))
        return paths

    return make


def test_the_newest_of_all_folders_is_taken(search):
    first, second, _ = search(
        ["libLLVM-17.so.1"], ["libLLVM.so.19.1", "libLLVM-14.so"], ["libLLVM.18.dylib", "LLVM-C.dll"]
    )
    assert find_llvm() == second / "libLLVM.so.19.1"
    (second / "libLLVM.so.19.1").unlink()
    (second.parent / "f2" / "libLLVM.18.dylib").unlink()
    assert find_llvm() == first / "libLLVM-17.so.1"


def test_old_ones_are_named_and_not_taken(search):
    (folder,) = search(["libLLVM-14.so", "libLLVM-15.so.1"])
    with pytest.raises(DeviceError, match=r"needs LLVM 16 or newer.* \(found only version 15\)"):
        find_llvm()
    (folder / "libLLVM-16.so").touch()
    assert find_llvm() == folder / "libLLVM-16.so"


def test_a_library_that_is_named_must_be_there_and_load(search, monkeypatch):
    (folder,) = search(["libLLVM-19.so", "libLLVM-15.so"])
    for name, words in (
        ("libLLVM-20.so", "missing"),
        ("libLLVM-15.so", "older than"),
        ("libLLVM-19.so", "cannot be loaded"),
    ):
        monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(folder / name))
        with pytest.raises(DeviceError, match=f"{name}.*{words}"):
            find_llvm()


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("libLLVM-16.so.1", 16),
        ("libLLVM.so.19.1", 19),
        ("libLLVM.so", None),
        ("llvm-18/lib/libLLVM.so", 18),
        ("llvm@20/libLLVM.dylib", 20),
    ],
)
def test_versions_of_names(name, version, tmp_path):
    assert llvm_version(tmp_path / name) == version
