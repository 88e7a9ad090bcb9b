"""What `make` says on machines that lack something: the scripts are run with programs of pretence on the path."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="POSIX shell")


@pytest.fixture
def tools(tmp_path: Path) -> Path:
    """A folder that is the whole search path; `id` and `sh` are real."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name in ("sh", "env"):
        (folder / name).symlink_to(f"/usr/bin/{name}" if Path(f"/usr/bin/{name}").exists() else f"/bin/{name}")
    return folder


def pretend(tools: Path, name: str, script: str) -> None:
    path = tools / name
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)


def call(script: str, *arguments: str, tools: Path, folder: Path, **env: str) -> subprocess.CompletedProcess[str]:
    command = ["/bin/sh", str(ROOT / "scripts" / script), *arguments]
    return subprocess.run(
        command, env={"PATH": str(tools), **env}, cwd=folder, capture_output=True, text=True, check=False
    )


def test_no_python(tools: Path, tmp_path: Path) -> None:
    done = call("venv.sh", ".venv", tools=tools, folder=tmp_path)
    assert done.returncode == 1
    assert "needs Python 3.11 or newer, and none was found" in done.stderr


def test_old_python(tools: Path, tmp_path: Path) -> None:
    pretend(tools, "python3", "exit 1")  # says of itself that it is older than 3.11
    assert "needs Python 3.11" in call("venv.sh", ".venv", tools=tools, folder=tmp_path).stderr
    done = call("venv.sh", ".venv", tools=tools, folder=tmp_path, PYTHON="python3")
    assert done.stderr == "PYTHON=python3 is not a Python 3.11 or newer.\n"


def test_python_without_venv(tools: Path, tmp_path: Path) -> None:
    pretend(tools, "python3", 'case "$2" in *venv*) exit 1;; esac')
    done = call("venv.sh", ".venv", tools=tools, folder=tmp_path)
    assert done.returncode == 1
    assert "apt-get install python3-venv" in done.stderr


@pytest.fixture
def deviceless(tmp_path: Path) -> Path:
    """A folder whose .venv finds no usable LLVM until one has been installed."""
    python = tmp_path / ".venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.write_text("#!/bin/sh\n[ -e installed ] || { echo 'Pelagos needs LLVM' >&2; exit 1; }\n")
    python.chmod(0o755)
    return tmp_path


def test_no_apt_is_one_clear_sentence(tools: Path, deviceless: Path) -> None:
    done = call("llvm.sh", tools=tools, folder=deviceless)
    assert (done.returncode, done.stderr) == (1, "Pelagos needs LLVM\n")


def test_no_root_and_no_sudo(tools: Path, deviceless: Path) -> None:
    pretend(tools, "apt-get", "exit 0")
    pretend(tools, "id", "echo 1000")
    done = call("llvm.sh", tools=tools, folder=deviceless)
    assert done.returncode == 1
    assert "there is no sudo" in done.stderr


@pytest.mark.parametrize("user", ["0", "1000"])
def test_llvm_is_installed_through_apt(user: str, tools: Path, deviceless: Path) -> None:
    pretend(tools, "id", f"echo {user}")
    pretend(tools, "sudo", 'echo sudo >> asked; exec "$@"')
    pretend(tools, "apt-cache", '[ "$2" = libllvm19 ]')
    pretend(tools, "apt-get", 'echo "$@" >> asked; : > installed')
    done = call("llvm.sh", tools=tools, folder=deviceless)
    assert done.returncode == 0, done.stderr
    asked = (deviceless / "asked").read_text()
    assert "install -y -qq --no-install-recommends libllvm19" in asked
    assert ("sudo" in asked) == (user != "0")


def test_apt_without_a_usable_llvm(tools: Path, deviceless: Path) -> None:
    pretend(tools, "id", "echo 0")
    pretend(tools, "apt-cache", "exit 1")
    pretend(tools, "apt-get", "exit 0")
    done = call("llvm.sh", tools=tools, folder=deviceless)
    assert done.returncode == 1
    assert "apt knows no libllvm of version 16 to 20" in done.stderr


def test_a_usable_llvm_is_left_alone(tools: Path, deviceless: Path) -> None:
    (deviceless / "installed").touch()
    assert call("llvm.sh", tools=tools, folder=deviceless).returncode == 0


def test_make_knows_its_targets() -> None:
    shown = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for target in ("demo", "test", "venv", "check", "test-all", "bench"):
        assert f"make {target} " in shown
    assert os.access(ROOT / ".ci" / "run", os.X_OK)
    assert "make test" in (ROOT / ".ci" / "run").read_text()
