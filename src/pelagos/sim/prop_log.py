"""The log of a scenario's props: where they stood at each tick, on its way into a recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pelagos.math.so3 import rotate_back_np
from pelagos.messages.motion import ODOMETRY, TruthEncoder
from pelagos.sim.props import props_of
from pelagos.sim.record import Recorder
from pelagos.sim.record_together import Lane

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

Motion = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


class PropLog:
    """Keeps where props stand from the tick on at which they were put there, until it is written down."""

    def __init__(self, sim: Simulation, recorder: Recorder) -> None:
        self._sim, self._recorder = sim, recorder
        self._tracks = {name: _track(recorder, name) for name in sim.scenario.props}
        self._changes = -1
        self._since: list[tuple[int, dict[str, Motion]]] = []

    def look(self) -> None:
        """Note where props stand, if anything was moved: from the present tick on."""
        bodies = self._sim.bodies
        if bodies.changes == self._changes or not self._sim.scenario.props:
            return
        self._changes = bodies.changes
        now = {name: _motion(*(a.copy() for a in (b.position, b.attitude, b.velocity, b.angular_velocity)))
               for name, b in props_of(bodies).items()}  # fmt: skip
        self._since.append((self._sim.stepper.tick, now))

    def write(self, ticks: NDArray[np.int64]) -> None:
        """Write down where they were at some ticks up to the present one."""
        self.look()
        for i, (tick, motions) in enumerate(self._since):
            after = self._since[i + 1][0] if i + 1 < len(self._since) else np.inf
            mine = ticks[((ticks >= tick) | (i == 0)) & (ticks < after)]
            for name, motion in motions.items() if len(mine) else ():
                standing = [np.repeat(part[None], len(mine), axis=0) for part in motion]
                self._recorder.write_odometry(self._tracks[name], mine * self._sim.dt_ns, standing)
        self._since = self._since[-1:]


def _track(recorder: Recorder, name: str) -> list[tuple[TruthEncoder, int | Lane]]:
    """Topic "/props/NAME/odometry" of each copy."""
    frames = [f"{place}/{name}" for place in recorder.places("props")]
    return [(TruthEncoder(f), recorder.channel(f"/{f}/odometry", ODOMETRY, {"prop": name})) for f in frames]


def _motion(
    position: NDArray[np.float64], attitude: NDArray[np.float64], velocity: NDArray[np.float64],
    spin: NDArray[np.float64],
) -> Motion:  # fmt: skip
    return position, attitude, rotate_back_np(attitude, velocity), rotate_back_np(attitude, spin)
