"""Rules about the tests themselves: skips that nobody expects fail, and every mutant of the lists fits the source."""

import subprocess
import sys
from pathlib import Path

import pytest

pytest_plugins = ("pytester",)
ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("source", "workers", "status"),
    [
        ("import pytest\npytest.importorskip('no_such_package')\ndef test(): pass\n", "2", 1),
        ("import pytest\n@pytest.mark.skip(reason='some day')\ndef test(): pass\n", "0", 1),
        ("import pytest\n@pytest.mark.skip(reason='signals of POSIX')\ndef test(): pass\n", "2", 0),
    ],
)
def test_a_skip_that_nobody_expects_fails_the_run(pytester, monkeypatch, source, workers, status):
    monkeypatch.delenv("PELAGOS_ALLOW_SKIPS", raising=False)
    pytester.makeconftest((ROOT / "tests/conftest.py").read_text())
    pytester.makepyfile(test_one=source, test_other="def test(): pass\n")
    result = pytester.runpytest_subprocess("-n", workers)
    assert result.ret == status
    assert ("unexpected skips fail the run" in result.stdout.str()) == bool(status)


def test_skips_can_be_allowed(pytester, monkeypatch):
    monkeypatch.setenv("PELAGOS_ALLOW_SKIPS", "1")
    pytester.makeconftest((ROOT / "tests/conftest.py").read_text())
    pytester.makepyfile("import pytest\n@pytest.mark.skip(reason='some day')\ndef test(): pass\n")
    assert pytester.runpytest_subprocess("-n", "0").ret == 0


def test_every_mutant_fits_the_source():
    done = subprocess.run([sys.executable, ROOT / "scripts/mutants", "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert int(done.stdout.split()[0]) >= 200
