"""A state that is not finite any more: the error that ends a run, with the last state that was."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import SimulationError
from pelagos.sim.model import AgentModel
from pelagos.vehicles.blame import blame


class NotFinite(SimulationError):
    """A state is not finite any more; carries the last one that was.

    Attributes:
        agent, copy, t_s: which vehicle, and when [s].
        state: `(CHANNELS,)` the last finite motion.
        command: the command that was held.
    """

    def __init__(
        self,
        agent: AgentModel,
        copy: int,
        t_s: float,
        state: NDArray[np.float64],
        command: NDArray[np.float64],
        lacking: Sequence[str] = (),
    ) -> None:
        self.agent, self.copy, self.t_s, self.state, self.command = agent.name, copy, t_s, state, command
        if lacking:
            term = f"{' and '.join(lacking)} ends before that place or moment (outside: error)"
        else:
            term = blame(agent.vehicle, state[0:3], state[3:7], state[7:10], state[10:13])
        position, velocity = np.array2string(state[0:3], precision=3), np.array2string(state[7:10], precision=3)
        super().__init__(
            f"{agent.name} (copy {copy}) has no finite state at t = {t_s:.3f} s; {term}; just before it was "
            f"at {position} m with {velocity} m/s, commanded {np.array2string(command, precision=4)}"
        )
