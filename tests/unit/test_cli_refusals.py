"""Refusals of commands before anything runs, by the words of each, and what commands say on a terminal."""

from __future__ import annotations

import io
import re
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from pelagos.cli import (
    console,
    dataset,
    fit,
    fit_noise,
    holoocean,
    learn,
    live_bar,
    signals,
    trusted,
    video,
    view,
    walk,
    world,
)
from pelagos.cli import main as commands
from pelagos.cli.check import _level
from pelagos.cli.explain import _range
from pelagos.cli.fit_noise import _keys_as_data
from pelagos.cli.manoeuvre import show_manoeuvre
from pelagos.cli.stages import Stages
from pelagos.config.mission.lines import Waypoints
from pelagos.errors import InputError, PelagosWarning
from pelagos.identification.noise_keys import KeyLine
from pelagos.manoeuvres.orders import Orders


def ship(out: Path) -> None:
    show_manoeuvre("otter", "stop", Orders(), out=out, as_json=False)


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (lambda p: dataset._chosen("x", 6), "--shard 'x': write I, a number from 0, or I/N"),
        (lambda p: dataset._chosen("1/", 6), "--shard '1/': write I, a number from 0, or I/N"),
        (lambda p: dataset._chosen("6", 6), "--shard 6: I is a number from 0 to 5"),
        (lambda p: dataset._chosen("-1", 6), "--shard -1: I is a number from 0 to 5"),
        (lambda p: dataset._chosen("4/4", 6), "--shard 4/4: I is a number from 0 to 3"),
        (lambda p: fit._agent({}, "", p), "has no agents, and so no vehicle to fit"),
        (lambda p: fit._agent({"a": 1, "b": 2}, "", p), "has 2 agents (a, b): say which with --agent"),
        (lambda p: fit._agent({"alpha": 1}, "alpa", p), "unknown agent 'alpa' (did you mean 'alpha'?)"),
        (lambda p: learn._pairs(["copies"]), "--set 'copies': write OPTION=VALUE"),
        (lambda p: learn._pairs(["=3"]), "--set '=3': write OPTION=VALUE"),
        (lambda p: learn._until("distance_m"), "--until 'distance_m': write METRIC=VALUE, such as distance_m=0.3"),
        (lambda p: learn.score("x", "y", episodes=0, seed=0, film=None, as_json=False, options=[]), "from 1 on, not 0"),
        (lambda p: holoocean._known("no_such_module_here"), "there is no module 'no_such_module_here' to run"),
        (lambda p: holoocean._known("no_such_package.part"), "there is no module 'no_such_package.part' to run"),
        (lambda p: holoocean.convert(p / "a.json", []), "give one file to write to: pelagos holoocean --convert"),
        (lambda p: holoocean.convert(p / "a.json", ["a", "b"]), "give one file to write to: pelagos holoocean --conv"),
        (lambda p: video.video(p, p, SimpleNamespace(chase=True, camera="eye", sonar=None, panels=False)),
         "one kind of film at a time, not --chase and --camera"),
        (lambda p: world._check([p / "dir.png"]), "dir.png: this is a folder; give a file"),
        (lambda p: world._check([p]), "give a new or empty folder"),
        (lambda p: world._check([p / "new", p / "no" / "it"]), "no does not exist"),
        (lambda p: view.show(p / "file.yaml", [], view.ViewOptions(speed=100.5)), "as fast as it goes; not 100.5"),
        (lambda p: view.show(p / "file.yaml", [], view.ViewOptions(speed=-0.1)), "as fast as it goes; not -0.1"),
        (lambda p: ship(p / "a.jpg"), "give a file that ends in .png, in a folder"),
        (lambda p: ship(p / "no" / "a.png"), "give a file that ends in .png, in a "),
    ],
)  # fmt: skip
def test_wrong_options_are_refused(ask: Callable[[Path], Any], told: str, tmp_path: Path) -> None:
    (tmp_path / "dir.png").mkdir()
    (tmp_path / "file.yaml").touch()
    with pytest.raises(InputError, match=re.escape(told)):
        ask(tmp_path)


def test_options_at_their_limits_are_taken(tmp_path: Path) -> None:
    assert dataset._chosen("5", 6) == range(5, 6, 6)
    assert [list(dataset._chosen(f"{i}/4", 6)) for i in range(4)] == [[0, 4], [1, 5], [2], [3]]
    assert fit._agent({"a": 1}, "", tmp_path) == "a"
    assert fit._agent({"a": 1, "b": 2}, "b", tmp_path) == "b"
    assert learn._pairs(["a=1", "b=c=d", "e="]) == {"a": 1, "b": "c=d", "e": None}
    assert (learn._until(None), learn._until("distance_m=-0.5")) == (None, ("distance_m", -0.5))
    holoocean._known("json.decoder")


def test_a_program_of_others_gets_its_arguments_and_tells_its_errors_from_its_own_line_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    keys = (holoocean.LEGACY, holoocean.STRICT, holoocean.SEED)
    for key in keys:
        monkeypatch.setenv(key, "")
    monkeypatch.setattr(holoocean, "install", lambda: None)
    monkeypatch.setattr(sys, "argv", [])
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "told_on.py").write_text(
        f"import os, sys\nprint(sys.argv[1:], *(os.environ[k] for k in {keys!r}))\n"
        "def f(): return 1 / len(sys.argv[2:])\nf()\n"
    )
    run = holoocean.run_program
    run(["told_on.py", "--a", "b"], module=None, legacy_dynamics=True, seed=0, strict=False)
    run(["--a", "b"], module="told_on", legacy_dynamics=False, seed=None, strict=True)
    assert capsys.readouterr().out == "['--a', 'b'] 1  0\n['--a', 'b'] 1 1 0\n"
    for words, module in ((["told_on.py"], None), ([], "told_on")):
        with pytest.raises(SystemExit) as caught:
            run(words, module=module, legacy_dynamics=False, seed=None, strict=False)
        told = capsys.readouterr().err
        assert caught.value.code == 1
        assert told.splitlines()[1].endswith('told_on.py", line 4, in <module>')
        assert told.endswith("ZeroDivisionError: division by zero\n")
        assert "runpy" not in told
    for words, text in (([], "give a script: pelagos holoocean SCRIPT.py"), (["no.py"], "there is no script no.py")):
        with pytest.raises(InputError, match=re.escape(text)):
            run(words, module=None, legacy_dynamics=False, seed=None, strict=False)


@pytest.mark.parametrize(
    ("given", "apart"),
    [
        ("holoocean -m pack.mod --x 1", "holoocean -m pack.mod -- --x 1"),
        ("holoocean --seed 3 -m pack.mod --x", "holoocean --seed 3 -m pack.mod -- --x"),
        ("holoocean --strict a.py --seed 3", "holoocean --strict -- a.py --seed 3"),
        ("holoocean -- a.py", "holoocean -- a.py"),
        ("run -m a", "run -m a"),
    ],
)
def test_arguments_of_a_program_are_its_own(given: str, apart: str) -> None:
    assert commands._program_apart(given.split()) == apart.split()


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (KeyboardInterrupt(), 130),
        (RuntimeError("drjit: KeyboardInterrupt: while recording"), 130),
        (RuntimeError("odd"), None),
        (OSError(13, "Permission denied", "a.yaml"), 1),
    ],
)
def test_an_end_has_its_code(error: BaseException, code: int | None, monkeypatch: pytest.MonkeyPatch) -> None:
    def end(*_: Any, **__: Any) -> None:
        raise error

    monkeypatch.setattr(commands, "app", end)
    with pytest.raises(SystemExit if code else RuntimeError) as caught:
        commands.main(["list"])
    assert getattr(caught.value, "code", None) == code
    with pytest.raises(SystemExit if isinstance(error, KeyboardInterrupt) else type(error)):
        commands.main(["list", "--debug"])


def test_an_interrupt_is_found_behind_other_errors() -> None:
    one, two, three = RuntimeError("a"), ValueError("b"), KeyboardInterrupt()
    one.__cause__, two.__context__ = two, three
    assert signals.interrupted(one)
    two.__context__ = one  # in a ring
    assert not signals.interrupted(one)
    assert not signals.interrupted(None)


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> io.StringIO:
    said = io.StringIO()
    screen = Console(file=said, force_terminal=True, width=100, color_system=None)
    for module in (console, live_bar):
        monkeypatch.setattr(module, "err", screen)
    return said


def test_a_terminal_gets_bars_boxes_and_colours(terminal: io.StringIO) -> None:
    console.show_error("wrong input", "no such [file]")
    console.show_warning("odd", PelagosWarning, "a.py", 3)
    with console.doing("loading it"):
        pass
    with dataset.Bar("samples") as bar:
        bar(2, 9)
        bar(5, 9)
    with Stages(3) as stage:
        stage("drawing the map")
        stage("writing")
    text = terminal.getvalue()
    assert re.search(r"╭─ wrong input ─+╮\n│ no such \[file\] +│", text)
    assert "warning: odd" in text
    assert "loading it" in text
    assert "5/9" in text
    assert "writing" in text
    assert "1/3" in text


def test_what_others_warn_of_has_its_place(capsys: pytest.CaptureFixture[str]) -> None:
    console.show_warning("odd", UserWarning, "a.py", 3)
    assert capsys.readouterr().err == warnings.formatwarning("odd", UserWarning, "a.py", 3)


def test_only_what_is_trusted_finds_modules_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Once, and behind all others."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    path = tmp_path / "it.yaml"
    path.write_text("world: {type: flat}\nagents: {a: {vehicle: remus100}}\n")
    before = [*sys.path]
    trusted.load(path)
    assert sys.path == before
    for _ in range(2):
        trusted.load(path, trust=True)
        assert sys.path == [*before, str(tmp_path)]


def test_functions_that_ran_are_walked_once_in_order() -> None:
    found, result = walk.walked(lambda: [_range(np.arange(3)), _range(np.arange(4))])
    assert [(p.room, p.name) for p in found if p.room.startswith("cli/explain")] == [("cli/explain.py", "_range")]
    assert result[1] == ("0", "1.5", "3")


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ([True, False, True, True], ("0", "0.75", "1")),
        ([np.nan, np.inf], ("none", "none", "none")),
        ([np.nan, -2.0, 4.0], ("-2", "1", "4")),
        ([3 + 4j, 0j], ("0", "2.5", "5")),
    ],
)
def test_a_range_in_words(values: list[Any], told: tuple[str, str, str]) -> None:
    assert _range(np.array(values)) == told


def test_levels_of_legs_in_words() -> None:
    leg = lambda **keys: Waypoints(points=((1.0, 2.0),), **keys)
    found = [_level(leg(**{key: 3.5})) for key in ("height_m", "altitude_m", "depth_m")]
    assert found == ["3.5 m height", "3.5 m altitude", "3.5 m depth"]


def test_keys_of_noise_that_was_not_seen_are_told_as_zero() -> None:
    """What is unknown, and what has no key, is left out."""
    keys = [KeyLine("noise_std_m", 0.0, "m", "not seen"), KeyLine("drift_std_m", 0.5, "m"),
            KeyLine("scale_error", None, "1", "unknown"), KeyLine("", None, "m", "no key for it")]  # fmt: skip
    assert _keys_as_data(keys) == {
        "keys": {"noise_std_m": 0.0, "drift_std_m": 0.5}, "units": {"noise_std_m": "m", "drift_std_m": "m"},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("means", "told"),
    [
        ((0.3, -0.4, -9.8), ""),
        ((0.03, -0.04, 1.0), "make 1.001 m/s^2 together, and gravity is 9.81:"),  # in g
        ((30.0, -40.0, 1000.0), "make 1001 m/s^2"),  # in mg
        ((0.2, -0.3, 0.3), ""),  # gravity taken off
        ((4.0, -7.0, 6.6), "make 10.42 m/s^2"),  # 6 % too much
        ((4.0, -7.0, 6.2), ""),  # 4 %: an offset
        ((0.0, -5.5, 7.4), "make 9.22 m/s^2"),
        ((0.0, 6.0, -7.3), ""),
        ((0.0, 1.0), ""),
    ],
)
def test_accelerometers_at_rest_that_do_not_feel_gravity_are_told_of(means: tuple[float, ...], told: str) -> None:
    axes: Any = [SimpleNamespace(mean=mean) for mean in means]
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        fit_noise._warn_of_gravity(axes, Path("it.csv"))
    assert [told in str(w.message) for w in said] == [True] * bool(told)
