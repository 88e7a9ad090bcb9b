"""A simulation, its view and its pilot together: what `pelagos view SCENARIO` and `Simulation.view()` are."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError
from pelagos.sim.guidance.outline import outline
from pelagos.sim.simulation import Simulation
from pelagos.viewer.currents import arrows
from pelagos.viewer.live import Live
from pelagos.viewer.orders import Orders, plain_name
from pelagos.viewer.pilot import Pilot
from pelagos.viewer.section import sections
from pelagos.viewer.server import Server
from pelagos.viewer.soundings import Soundings, vehicle_place, water_of
from pelagos.viewer.view import Subject, View

WATCHING: Final = ("pause", "section")
"""What browsers may ask for of a run that somebody else steps."""


def subject_of(sim: Simulation) -> Subject:
    """Subject of a simulation."""
    agents = sim.model.agents
    sensors = {f"{a}.{s}": m.config for a, agent in agents.items() for s, m in agent.sensors.items()}
    starts, height = sim.state, sim.world.height
    plans = {n: outline(a.tasks, starts[n].position[0], height) for n, a in agents.items() if a.tasks}
    ocean = sim.ocean.fields
    return Subject(
        sim.scenario.name, sim.world, {n: a.vehicle for n, a in agents.items()}, sensors,
        {n: p for n, p in plans.items() if len(p) > 1}, sim.scenario.description, water=water_of(sim),
        currents=currents_of(sim), sections=sections(ocean),
    )  # fmt: skip


def currents_of(sim: Simulation) -> NDArray[np.float32]:
    """Arrows of the current of now, at the depth of the first vehicle, or of 2 m."""
    return arrows(sim.ocean.fields, sim.world, sim.time_ns * 1e-9, -float(vehicle_place(sim)[2]))


class Session:
    """A simulation that is stepped for its view; `run` it in the thread that may use the device.

    Args:
        sim: what to step.
        results: the folder that recordings go to; results/NAME where not given.
        speed, paused: how the run begins.
        server: what listens; one of this machine alone where not given.
    """

    def __init__(
        self, sim: Simulation, *, results: Path | None = None, speed: float = 1.0, paused: bool = False,
        server: Server | None = None,
    ) -> None:  # fmt: skip
        self.live = Live(sim)
        self.pilot = Pilot(sim, self.live, speed=speed, paused=paused)
        self.live.status = self._status
        folder = Path("results") / plain_name(sim.scenario.name) if results is None else results
        orders = Orders(self.pilot, folder)
        self.view = View(subject_of(sim), self.live, orders, server=server)
        self.view.waited_s = self.live.waited_s
        self.soundings = orders.soundings = Soundings(sim, self.view)
        self.view.show_bodies_of(sim.bodies)
        self.pilot.say = lambda text, kind: self.view.hub.say(text, kind=kind)
        self._thread: threading.Thread | None = None

    @property
    def url(self) -> str:
        """Address of the page."""
        return self.view.url

    def run(self) -> None:
        """Step and serve until `close`, or Ctrl-C."""
        with self.live.looked_at():
            self.view.start()
            try:
                self.pilot.run()
            finally:
                self.pilot.end_recording()
                self.view.close()

    def start(self) -> Session:
        """The same in a thread of its own."""
        self._thread = threading.Thread(target=self.run, name="pelagos pilot", daemon=True)
        self._thread.start()
        return self

    def close(self) -> None:
        """End it."""
        self.pilot.close()
        if self._thread is not None:
            self._thread.join(timeout=30.0)
        self.view.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        return self.view._repr_html_()

    def _status(self) -> Mapping[str, Any]:
        """With every frame, in the thread that steps."""
        self.soundings.look()
        self.view.survey()
        return self.pilot.status()


class Watching:
    """Orders of browsers to a run that somebody else steps: to hold it, to let it go on, a section."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self.soundings: Soundings | None = None
        self.say: Callable[[str], None] = lambda text: None

    @property
    def known(self) -> tuple[str, ...]:
        """See `View`."""
        return WATCHING

    def obey(self, message: Mapping[str, Any]) -> bool:
        """See `View`."""
        if message.get("do") == "section" and self.soundings is not None:
            try:
                self.soundings.ask(message.get("what"), message.get("along", "north"))
            except InputError as error:
                self.say(str(error))
            return True
        if message.get("do") != "pause":
            return False
        if message.get("paused", not self._sim.paused):
            self._sim.pause()
        else:
            self._sim.resume()
        return True


class Watch:
    """The view of a simulation that somebody else steps or runs: `with Watch(sim): sim.run(...)`.

    Args:
        sim: what is looked at.
        host, port: where to listen.
    """

    def __init__(self, sim: Simulation, *, host: str = "127.0.0.1", port: int | None = None) -> None:
        self._sim, self.live = sim, Live(sim)
        self.live.status = self._status
        watching = Watching(sim)
        self.view = View(subject_of(sim), self.live, watching, server=Server(host=host, port=port))
        self.view.waited_s = lambda: 0.0 if sim.paused else self.live.waited_s()
        self.soundings = watching.soundings = Soundings(sim, self.view)
        watching.say = lambda text: self.view.hub.say(text, kind="error")
        self.view.show_bodies_of(sim.bodies)
        self._watching = contextlib.ExitStack()
        self._watching.enter_context(self.live.looked_at())
        self._watching.enter_context(sim.watch(self.live.heard))
        self.live.show()
        self.view.start()

    @property
    def url(self) -> str:
        """Address of the page."""
        return self.view.url

    def close(self) -> None:
        """Look away."""
        self.view.close()
        self._watching.close()

    def __enter__(self) -> Watch:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        return self.view._repr_html_()

    def _status(self) -> Mapping[str, Any]:
        self.soundings.look()
        self.view.survey()
        return {"paused": self._sim.paused, "seed": self._sim.seed}


def view_of(sim: Simulation, *, drive: bool = False, host: str = "127.0.0.1", port: int | None = None) -> Any:
    """See `Simulation.view`.

    Raises:
        InputError: the port is taken.
    """
    if not isinstance(sim, Simulation):
        raise InputError(f"a simulation is what can be viewed, not a {type(sim).__name__}")
    if drive:
        return Session(sim, server=Server(host=host, port=port)).start()
    return Watch(sim, host=host, port=port)
