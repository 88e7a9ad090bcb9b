"""A world alone, with names at what stands in it."""

from __future__ import annotations

import threading

from pelagos.config.scenario import Scenario
from pelagos.viewer.frame import ShownFrame, ShownPose
from pelagos.viewer.server import Server
from pelagos.viewer.view import Subject, View
from pelagos.world.build import build_world


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


def world_view(scenario: Scenario, *, server: Server | None = None) -> View:
    """The view of a scenario's world, served to this machine alone where no `server` is given.

    Raises:
        InputError: the world cannot be built.
    """
    world = build_world(scenario.located_world)
    bodies, poses = {}, {}
    for number, mover in enumerate(world.movers):
        bodies[mover.name] = mover.geometry(instance=world.next_instance + number, world=world)
        pose = mover.pose(0.0)
        poses[mover.name] = ShownPose(pose.position, pose.attitude)
    subject = Subject(
        scenario.name, world, kind="world", description=world.description or world.name, bodies=bodies
    )  # fmt: skip
    view = View(subject, Still(ShownFrame(0, {}, movers=poses)), server=server)
    view.scene.label_world()
    return view
