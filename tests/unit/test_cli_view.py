"""`pelagos view` and `pelagos video` from the command line: how they end, and what they refuse."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import threading
import time
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import urlsplit
from urllib.request import HTTPCookieProcessor, build_opener

import pytest
import yaml

from pelagos.cli import view as command
from pelagos.cli.run import Options, run_scenario
from pelagos.cli.video import VideoOptions, video
from pelagos.cli.view import ViewOptions, show
from pelagos.errors import InputError, PelagosError
from pelagos.sim.replay import Recording
from pelagos.viewer.server import Server

SCENARIO: dict[str, Any] = {
    "seed": 5, "world": {"type": "flat", "depth_m": 14.0},
    "agents": {"rov": {
        "vehicle": "bluerov2_heavy", "start": {"position_m": [2, -3], "depth_m": 6.0, "heading_deg": 50},
        "sensors": {"depth": {"type": "depth", "rate_hz": 10}},
    }},
}  # fmt: skip
SILENT = ViewOptions(port=0, browser=False)


@pytest.fixture
def heeded():
    """Ctrl-C as a terminal has it: processes in the background of a shell begin with it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeded")
def test_ctrl_c_ends_a_view_whose_browser_does_not_answer(tmp_path, monkeypatch, capsys):
    """The browser has the run recorded, and then neither reads nor says good-bye: 130, and the recording is whole."""
    from websockets.sync.client import connect

    path = tmp_path / "dive.yaml"
    path.write_text(yaml.safe_dump(SCENARIO), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    recording = tmp_path / "results" / "dive" / "view-1.mcap"
    failed: list[BaseException] = []
    ended, looking = threading.Event(), list[threading.Thread]()

    def look(url: str) -> None:
        try:
            with connect(
                url.replace("http://", "ws://").replace("/?", "/live?"), close_timeout=0.1, max_size=None
            ) as connection:
                while b'"type":"hello"' not in connection.recv(timeout=120):  # the page is there before the simulation
                    pass
                connection.send(json.dumps({"do": "record", "on": True}))
                while not (recording.exists() and recording.stat().st_size > 0):
                    time.sleep(0.02)
                os.kill(os.getpid(), signal.SIGINT)
                ended.wait(120)
        except BaseException as error:
            failed.append(error)
            os.kill(os.getpid(), signal.SIGINT)

    def say(url: str, options: ViewOptions) -> None:
        looking.append(threading.Thread(target=look, args=(url,)))
        looking[0].start()

    monkeypatch.setattr(command, "say_where", say)
    assert show(path, [], SILENT) == 130
    ended.set()
    looking[0].join()
    assert not failed
    assert Recording(recording).complete
    told = capsys.readouterr()
    assert "the view has ended" in told.out
    assert "ending the view" in told.err


@pytest.mark.usefixtures("heeded")
def test_ctrl_c_ends_a_replay_and_a_world(tmp_path, monkeypatch, capsys):
    path = tmp_path / "dive.yaml"
    path.write_text(yaml.safe_dump(SCENARIO), encoding="utf-8")

    def say(url: str, options: ViewOptions) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(command, "say_where", say)
    assert show(path, [], ViewOptions(port=0, world=True)) == 130
    told = capsys.readouterr().err.splitlines()  # no terminal: whoever reads the log knows what is waited for
    assert told[:2] == [f"loading {path} ...", "building the world ..."]
    monkeypatch.setattr(command, "say_where", lambda url, options: None)
    assert show(path, [], ViewOptions(port=0, world=True, for_s=0.05)) == 0


@pytest.mark.parametrize("make", [show, video], ids=["view", "video"])
@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.mcap", None, "missing.mcap: there is no such file"),
        ("empty.mcap", b"", "empty.mcap: is not an MCAP recording"),
        ("junk.mcap", bytes(range(256)) * 9, "junk.mcap: is not an MCAP recording"),
        ("folder", "mission.mcap", "folder: this is a folder; its recording is .*mission.mcap"),
        ("folder", "notes.txt", "folder: this is a folder; give a scenario, or a recording"),
    ],
)
def test_what_is_no_recording_is_wrong_input(make, name, content, message, tmp_path):
    """Exit code 2 of both commands: it is the user's file that is wrong."""
    path = tmp_path / name
    if isinstance(content, str):
        path.mkdir()
        (path / content).write_bytes(b"")
    elif content is not None:
        path.write_bytes(content)
    more: Any = ([], SILENT) if make is show else (tmp_path / "film.mp4", VideoOptions())
    with pytest.raises(InputError, match=message):
        make(path, *more)
    assert not list(Path(tmp_path).glob("*.mp4"))


@pytest.mark.parametrize(
    ("changes", "options"),
    [([], {"seed": 0}), ([], {"seed": 7}), ([], {"world": True}), (["seed=3"], {}), (["seed=3"], {"seed": 0})],
)
def test_a_recording_is_shown_as_it_is_or_not_at_all(changes, options, tmp_path, monkeypatch):
    """A seed, a change and --world are for scenarios; the file is not even looked into."""
    path = tmp_path / "dive.MCAP"
    path.write_bytes(b"x")
    played: list[Path] = []
    monkeypatch.setattr(command, "_replay", lambda path, *_: played.append(path))
    with pytest.raises(InputError, match="leave out --set, --seed and --world"):
        show(path, changes, ViewOptions(port=0, browser=False, **options))
    assert not played
    assert show(path, [], ViewOptions(port=0, browser=False, speed=0.0, paused=True)) == 0
    assert played == [path]


def test_a_scenario_is_viewed_with_the_seed_that_is_given(tmp_path, monkeypatch):
    path, seeds = tmp_path / "dive.yaml", list[int]()
    path.write_text(yaml.safe_dump(SCENARIO), encoding="utf-8")

    def begin(scenario: Any) -> None:
        seeds.append(scenario.seed)
        raise InputError("enough")

    monkeypatch.setattr("pelagos.sim.simulation.Simulation.load", begin)
    for changes, seed in ([], 0), ([], 9), ([], None), (["seed=3"], None):
        with pytest.raises(InputError, match="enough"):
            show(path, changes, ViewOptions(port=0, browser=False, seed=seed))
    assert seeds == [0, 9, 5, 3]


def test_no_browser_is_told_in_a_sentence(monkeypatch, capsys):
    """A machine without a screen: no browser of the terminal is begun."""
    opened: list[str] = []
    monkeypatch.setattr(command.webbrowser, "open", lambda url: bool(opened.append(url)))
    monkeypatch.setattr(command.sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    command.say_where("http://127.0.0.1:1/?token=x", ViewOptions())
    assert "no browser was found here: open the address in one" in capsys.readouterr().out
    assert not opened
    monkeypatch.setenv("DISPLAY", ":0")
    command.say_where("http://127.0.0.1:1/?token=x", ViewOptions())
    assert opened == ["http://127.0.0.1:1/?token=x"]
    assert "no browser was found here" in capsys.readouterr().out  # `open` gave False


def test_a_run_is_looked_at_without_a_browser_where_none_is_wanted(monkeypatch, tmp_path):
    """`run --view --no-browser` prints the address alone; without --view it would be ignored, and is refused."""
    said: list[ViewOptions] = []
    monkeypatch.setattr(command, "say_where", lambda url, options: said.append(options))
    page = contextlib.nullcontext(SimpleNamespace(url="http://a", live=SimpleNamespace(at_work=contextlib.nullcontext)))
    monkeypatch.setattr("pelagos.viewer.session.Watch", lambda sim: page)
    sim: Any = None
    for browser in (True, False):
        with command.looked_at(sim, view=True, browser=browser):
            assert said[-1].browser is browser
    with pytest.raises(InputError, match="--no-browser is about the page of --view"):
        run_scenario(tmp_path / "x.yaml", [], Options(browser=False))
    for view, browser in ((True, False), (True, True), (False, True)):  # come as far as to look for the file
        with pytest.raises(PelagosError, match=r"x\.yaml"):
            run_scenario(tmp_path / "x.yaml", [], Options(view=view, browser=browser))


def test_a_port_that_is_taken_is_told_before_anything_is_built(tmp_path, monkeypatch):
    path = tmp_path / "dive.yaml"
    path.write_text(yaml.safe_dump(SCENARIO), encoding="utf-8")
    monkeypatch.setattr(command, "load", lambda *_, **__: pytest.fail("the scenario was loaded first"))
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port} is taken: give --port another number"):
            show(path, [], ViewOptions(port=port, browser=False))


def test_whoever_listens_everywhere_is_told_an_address_that_others_can_open():
    with closing(Server(host="0.0.0.0", port=0)) as server:
        name = urlsplit(server.url).hostname
        assert name not in (None, "0.0.0.0")
        with socket.socket() as probe:
            probe.bind((name, 0))  # it is this machine's own
        with build_opener(HTTPCookieProcessor()).open(server.url) as page:
            assert b"<title>Pelagos</title>" in page.read()
