"""Rules about tests and source: skips that nobody expects fail, every mutant fits, modules and functions are small."""

import importlib
import os
import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from definitions import module

pytest_plugins = ("pytester",)
ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src/pelagos"
LONGEST_MODULE, LONGEST_FUNCTION, MOST_PARAMETERS = 400, 60, 7  # lines, lines, what is not given by name
OF_OTHERS = ("cli/", "compat/holoocean/")  # a command's options, and the calls of another program
TAKES_MORE = {  # physics in its equation's order, recorded kernels and bodies of loops, by file; the list only shrinks
    "acoustics/bottom_detection.py": ["add"],
    "acoustics/echo.py": ["strip_span", "widened"],
    "acoustics/layered_rays.py": ["_bounced"],
    "optics/sight_line.py": ["step"],
    "raycast/caster.py": ["_hits"],
    "sensors/camera/camera.py": ["_kernel"],
    "sensors/camera/picture/ambient_light.py": ["_gathered"],
    "sensors/camera/picture/path_tracing.py": ["_extended", "path_traced"],
    "sensors/camera/picture/radiance.py": ["_behind_the_sea", "_surface_light", "radiance_along"],
    "sensors/camera/thermal_camera.py": ["_kernel"],
    "sensors/comms/hydrophone.py": ["_add"],
    "sensors/comms/link/water_paths.py": ["_blocked"],
    "sensors/noise.py": ["_bisect"],
    "sensors/sonar/ping/bottom_series.py": ["_raw"],
    "sensors/sonar/ping/echo_field.py": ["calibrated_echoes"],
    "sensors/sonar/ping/multipath.py": ["_echoes"],
    "sensors/sonar/ping/pulse_pairs.py": ["_water"],
    "sensors/sonar/ping/swath.py": ["_aim"],
    "sim/channel.py": ["__init__"],
    "sim/outbox.py": ["send"],
    "sim/touch.py": ["touch"],
    "sim/trajectory.py": ["select"],
    "vehicles/around.py": ["_seaway"],
    "vehicles/control/depth.py": ["stern_plane"],
    "vehicles/vehicle.py": ["step"],
}


@pytest.mark.parametrize(
    ("source", "workers", "status"),
    [
        ("import pytest\npytest.importorskip('no_such_package')\ndef test(): pass\n", "1", 1),
        ("import pytest\n@pytest.mark.skip(reason='some day')\ndef test(): pass\n", "0", 1),
        ("import pytest\n@pytest.mark.skip(reason='signals of POSIX')\ndef test(): pass\n", "0", 0),
    ],
)
def test_a_skip_that_nobody_expects_fails_the_run(pytester, monkeypatch, source, workers, status):
    monkeypatch.delenv("PELAGOS_ALLOW_SKIPS", raising=False)
    pytester.makeconftest((ROOT / "tests/conftest.py").read_text())
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT / "tests"), os.environ.get("PYTHONPATH", "")]))
    pytester.makepyfile(test_one=source, test_other="def test(): pass\n")
    result = pytester.runpytest_subprocess("-n", workers)
    assert result.ret == status
    assert ("unexpected skips fail the run" in result.stdout.str()) == bool(status)


def test_skips_can_be_allowed(pytester, monkeypatch):
    monkeypatch.setenv("PELAGOS_ALLOW_SKIPS", "1")
    pytester.makeconftest((ROOT / "tests/conftest.py").read_text())
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT / "tests"), os.environ.get("PYTHONPATH", "")]))
    pytester.makepyfile("import pytest\n@pytest.mark.skip(reason='some day')\ndef test(): pass\n")
    assert pytester.runpytest_subprocess("-n", "0").ret == 0


def test_every_mutant_fits_the_source():
    done = subprocess.run([sys.executable, ROOT / "scripts/mutants", "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert int(done.stdout.split()[0]) >= 200


def test_a_list_that_fits_no_more_is_read_all_the_same(tmp_path, monkeypatch):
    """So that each misfit is told in a line; tests are looked for where the text stands."""
    monkeypatch.syspath_prepend(ROOT / "scripts/mutants")
    fresh = importlib.import_module("fresh")
    place = lambda file, text: (str((fresh.SOURCES / file).read_text().index(text)),)
    monkeypatch.setattr(fresh, "_Tests", lambda: SimpleNamespace(of=place))
    (tmp_path / "one.toml").write_text(
        "[[module]]\nfile = 'errors.py'\nmutants = [['from __future__ ', 'x'], ['no such text', 'x'], ['e', 'a']]\n"
        "[[module]]\nfile = 'no/such/file.py'\nmutants = [['a', 'b']]\n"
    )
    found = fresh.with_tests(tmp_path / "one.toml")
    assert [bool(m.tests) for m in found] == [True, False, False, False]
    with pytest.raises(ValueError, match="'no such text' stands there 0 times, not once"):
        found[1].mutated()


@pytest.mark.parametrize("mutation", ["= (", "= 1\nreturn 1", "= 1\n\n        nonlocal message"])
def test_a_mutant_that_is_no_python_is_told(monkeypatch, mutation):
    """Though its definition alone is compiled."""
    monkeypatch.syspath_prepend(ROOT / "scripts/mutants")
    mutant = importlib.import_module("mutant").Mutant
    with pytest.raises(SyntaxError):
        mutant("errors", "errors.py", "self.message = message", f"self.message {mutation}", ()).mutated()
    assert "other = message" in mutant("errors", "errors.py", "self.message = message", "other = message", ()).mutated()


def test_some_mutants_are_of_as_many_files_as_there_can_be(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "scripts/mutants")
    spread = runpy.run_path(str(ROOT / "scripts/mutants/__main__.py"))["spread"]
    mutants = [SimpleNamespace(file=file, place=k) for k, file in enumerate("aaaabbc")]
    some = [[m.file for m in spread(mutants, 5, seed)] for seed in range(8)]
    assert all(set(files[:3]) == set(files[3:]) | {"c"} == set("abc") for files in some)
    assert len({tuple(m.place for m in spread(mutants, 5, seed)) for seed in range(8)}) > 4
    assert len(spread(mutants, 9, 0)) == 7


def test_modules_and_functions_fit_a_reader():
    modules, long = [], []
    for path in sorted(SOURCE.rglob("*.py")):
        name, found = path.relative_to(SOURCE), module(path)
        if found.lines > LONGEST_MODULE:
            modules.append(f"{name}: {found.lines} lines")
        functions = (d for d in found.definitions if d.positional is not None)
        long += [f"{name}: {function.name}" for function in functions if function.lines > LONGEST_FUNCTION]
    assert not modules, f"more than {LONGEST_MODULE} lines: which second noun has moved in?"
    assert not long, f"more than {LONGEST_FUNCTION} lines"


def test_more_than_seven_parameters_ask_for_a_struct():
    found = {}
    for path in sorted(SOURCE.rglob("*.py")):
        name = path.relative_to(SOURCE).as_posix()
        many = sorted(d.name for d in module(path).definitions if (d.positional or 0) > MOST_PARAMETERS)
        if many and not name.startswith(OF_OTHERS):
            found[name] = many
    assert found == {name: sorted(names) for name, names in TAKES_MORE.items()}
