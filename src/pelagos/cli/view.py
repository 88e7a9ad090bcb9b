"""`pelagos view`: a page in the browser on which a scenario runs, a recording plays, or a world stands."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
import webbrowser
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pelagos.cli.console import doing, out
from pelagos.cli.signals import Stopping
from pelagos.cli.trusted import load
from pelagos.errors import InputError

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation
    from pelagos.viewer.server import Server
    from pelagos.viewer.view import View

_IDLE_S: Final = 0.2


@dataclass(frozen=True)
class ViewOptions:
    """Options of the command line; see `pelagos view --help`."""

    world: bool = False
    host: str = "127.0.0.1"
    port: int | None = None
    browser: bool = True
    seed: int | None = None
    speed: float = 1.0
    paused: bool = False
    for_s: float | None = None
    trust: bool = False


def show(path: Path, changes: Sequence[str], options: ViewOptions) -> int:
    """Serve the page until Ctrl-C; the exit code.

    Raises:
        InputError: the scenario or recording cannot be shown, or the port is taken.
    """
    must_be_file(path)
    if not 0 <= options.speed <= 100:
        raise InputError(f"--speed is 0.1 to 100 times the clock, or 0 for as fast as it goes; not {options.speed:g}")
    from pelagos.viewer.server import Server

    with closing(Server(host=options.host, port=options.port)) as server:  # a taken port is told before all else
        return _show(path, changes, options, server)


def _show(path: Path, changes: Sequence[str], options: ViewOptions, server: Server) -> int:
    if path.suffix.lower() == ".mcap":
        if changes or options.world or options.seed is not None:
            raise InputError("a recording is shown as it is: leave out --set, --seed and --world")
        serve: Callable[[Stopping], None] = partial(_replay, path, options, server)
    elif options.world:
        serve = partial(_world, path, changes, options, server)
    else:
        serve = partial(_scenario, path, changes, options, server)
    with Stopping(words=("ending the view", "the view is being ended: its recording is on its way")) as stopping:
        serve(stopping)
    out.print("the view has ended", markup=False)
    return stopping.exit_code


def must_be_file(path: Path) -> None:
    """See that a scenario or a recording is there.

    Raises:
        InputError: there is none, or it is a folder; the message names the recording that lies in it.
    """
    if path.is_dir():
        inside = sorted(path.glob("*.mcap"), key=lambda p: (p.name != "mission.mcap", p.name))
        hint = f"its recording is {inside[0]}" if inside else "give a scenario, or a recording (.mcap)"
        raise InputError(f"{path}: this is a folder; {hint}")
    if not path.exists():
        raise InputError(f"{path}: there is no such file")


def _scenario(
    path: Path, changes: Sequence[str], options: ViewOptions, server: Server, stopping: Stopping
) -> None:  # fmt: skip
    overrides = {} if options.seed is None else {"seed": options.seed}
    with doing(f"loading {path}"):
        scenario = load(path, changes, overrides=overrides, trust=options.trust)
    server.say_loading(f"{scenario.name}: building the world, the vehicles and their sensors")
    say_where(server.url, options)  # a browser takes its time to begin, too
    with doing("building the world, the vehicles and their sensors"):
        from pelagos.sim.simulation import Simulation
        from pelagos.viewer.session import Session

        sim = Simulation.load(scenario)
        results = Path("results") / path.stem
        session = Session(sim, results=results, speed=options.speed, paused=options.paused, server=server)
    stopping.guard(session.pilot.stop_soon)
    _end_after(options.for_s, session.pilot.close)
    session.run()


def _replay(path: Path, options: ViewOptions, server: Server, stopping: Stopping) -> None:
    with doing(f"loading {path}"):
        from pelagos.viewer.replay import replay_view

        view = replay_view(path, server=server, paused=options.paused, speed=options.speed)
    _serve(view, options, stopping)


def _world(path: Path, changes: Sequence[str], options: ViewOptions, server: Server, stopping: Stopping) -> None:
    with doing(f"loading {path}"):
        scenario = load(path, changes, trust=options.trust)
    with doing("building the world"):
        from pelagos.viewer.still import world_view

        view = world_view(scenario, server=server)
    _serve(view, options, stopping)


def _serve(view: View, options: ViewOptions, stopping: Stopping) -> None:
    ended = threading.Event()
    stopping.guard(lambda: None)
    say_where(view.url, options)
    _end_after(options.for_s, ended.set)
    with view.start():
        while not (ended.is_set() or stopping.asked):
            time.sleep(_IDLE_S)


@contextmanager
def looked_at(sim: Simulation, *, view: bool, browser: bool = True) -> Iterator[None]:
    """Have a page open beside a run, if it is asked for."""
    if not view:
        yield
        return
    from pelagos.viewer.session import Watch

    with Watch(sim) as watch:
        say_where(watch.url, ViewOptions(browser=browser))
        with watch.live.at_work():
            yield


def say_where(url: str, options: ViewOptions) -> None:
    """Print the address, and open it in a browser if there is one."""
    out.print(f"the view: {url}", markup=False, soft_wrap=True)
    if options.host not in ("127.0.0.1", "localhost", "::1"):
        out.print("anybody who has this address can steer the vehicles; its token is printed only here", markup=False)
    opened = False
    if options.browser:
        if _has_display():
            with contextlib.suppress(webbrowser.Error, OSError):
                opened = webbrowser.open(url)
        if not opened:
            out.print("no browser was found here: open the address in one, or forward the port", markup=False)
    out.print("Ctrl-C ends it", markup=False)


def _has_display() -> bool:
    """True where a browser would have a screen: one of the terminal cannot show the page, and would take that."""
    known = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    return not sys.platform.startswith("linux") or any(os.environ.get(name) for name in known)


def _end_after(seconds: float | None, end: Any) -> None:
    if seconds is not None:
        timer = threading.Timer(seconds, end)
        timer.daemon = True
        timer.start()
