"""A world alone, with names at what stands in it."""

from __future__ import annotations

import threading

import numpy as np

from pelagos.config.scenario import Scenario
from pelagos.raycast.geometry import Geometry
from pelagos.sim.props import attitude_of, geometry_of
from pelagos.viewer.frame import ShownFrame, ShownPose
from pelagos.viewer.server import Server
from pelagos.viewer.view import Subject, View
from pelagos.world.build import build_world
from pelagos.world.world import World


class Still:
    """One frame, in which movers stand where they begin."""

    def __init__(self, frame: ShownFrame) -> None:
        self._frame: ShownFrame | None = frame
        self._wait = threading.Event()

    def take(self, wait_s: float = 0.5) -> ShownFrame | None:
        """The frame, once."""
        frame, self._frame = self._frame, None
        if frame is None:
            self._wait.wait(wait_s)
        return frame


def standing(scenario: Scenario, world: World) -> dict[str, Geometry]:
    """Geometries of a world's movers and a scenario's props, by name, in their own frames."""
    movers = {m.name: m.geometry(instance=world.next_instance + i, world=world) for i, m in enumerate(world.movers)}
    first = world.next_instance + len(movers)
    return movers | {name: geometry_of(p, first + i, world) for i, (name, p) in enumerate(scenario.props.items())}


def world_view(scenario: Scenario, *, server: Server | None = None) -> View:
    """The view of a scenario's world, served to this machine alone where no `server` is given.

    Raises:
        InputError: the world cannot be built.
    """
    world = build_world(scenario.located_world)
    bodies = standing(scenario, world)
    poses = {m.name: ShownPose(m.pose(0.0).position, m.pose(0.0).attitude) for m in world.movers}
    poses |= {
        n: ShownPose(np.array(p.position_m), np.array(attitude_of(p.orientation_deg)))
        for n, p in scenario.props.items()
    }
    subject = Subject(
        scenario.name, world, kind="world", description=world.description or world.name, bodies=bodies
    )  # fmt: skip
    view = View(subject, Still(ShownFrame(0, {}, movers=poses)), server=server)
    view.scene.label_world()
    return view
