"""Missions of all agents: their guidance, and what it knows from sensors."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance import Guidance
from pelagos.sim.model import AgentModel, Model
from pelagos.sim.sampled import Sampled
from pelagos.sim.state import AgentState

GUIDANCE_RATE_HZ: Final = 10.0
GUIDING: Final = ("altimeter", "gps")  # the sensors that guidance listens to


@dataclass
class Feedback:
    """What guidance knows from sensors: the last altitude `(n,)` [m], and whether a fix came since it last asked."""

    altitude: NDArray[np.float64]
    gps: NDArray[np.bool_]


class Missions:
    """Guidance and feedback by agent.

    Attributes:
        period: ticks between two calls of guidance.
        guidance: by agent, those on a mission.
        feedback: by agent, all.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self.period = model.clock.period(GUIDANCE_RATE_HZ)
        self.guidance: dict[str, Guidance] = {}
        self.feedback: dict[str, Feedback] = {}

    @property
    def any(self) -> bool:
        """An agent is on a mission."""
        return bool(self.guidance)

    @property
    def done(self) -> bool:
        """There are missions, and all have ended."""
        return bool(self.guidance) and all(g.done for g in self.guidance.values())

    def memory(self) -> dict[str, Any]:
        """Where all missions stand; a copy."""
        return copy.deepcopy({"guidance": self.guidance, "feedback": self.feedback})

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        kept = copy.deepcopy(dict(memory))
        self.guidance, self.feedback = kept["guidance"], kept["feedback"]

    def begin(self, agent: AgentModel, state: AgentState) -> None:
        """An agent stands at its start; its mission begins, if it has one."""
        n = self._model.n
        self.feedback[agent.name] = Feedback(np.full(n, np.inf), np.zeros(n, dtype=bool))
        self.guidance.pop(agent.name, None)
        if agent.tasks:
            dt_s = self.period * self._model.clock.dt_ns * 1e-9
            self.guidance[agent.name] = Guidance.start(agent.tasks, state, dt_s=dt_s, length_m=_length(agent))

    def leave(self, agent: str) -> None:
        """End an agent's mission: it is commanded from outside."""
        self.guidance.pop(agent, None)

    def guided(self, agent: str, kind: str) -> bool:
        """Whether guidance waits for the readings of an agent's sensor of this type."""
        return agent in self.guidance and kind in GUIDING

    def commands(self, tick: int, rows: Mapping[str, NDArray[np.float64]]) -> Mapping[str, NDArray[np.float64]]:
        """Set-points `(n, k)` of the agents on a mission, of their motions; none between the ticks of guidance."""
        if tick % self.period:
            return {}
        asked = {}
        for name, guidance in self.guidance.items():
            feedback, row = self.feedback[name], rows[name]
            state = AgentState.of(row, np.empty((len(row), 0)))  # guidance does not ask for actuators
            t_s = tick * self._model.clock.dt_ns * 1e-9
            asked[name] = guidance.command(state, feedback.altitude, feedback.gps, t_s)
            feedback.gps[:] = False
        return asked

    def hear(self, sampled: Sampled) -> None:
        """Keep what guidance needs of a sensor's readings."""
        n, kind, m = self._model.n, sampled.model.config.type, sampled.measurement
        if kind not in GUIDING:
            return
        feedback = self.feedback[sampled.agent]
        if kind == "altimeter":
            altitude = np.asarray(m.data, dtype=np.float64).reshape(len(sampled.ticks), n, -1)[-1, :, 0]
            valid = np.isfinite(altitude) if m.valid is None else m.valid[-n:] & np.isfinite(altitude)
            feedback.altitude = np.where(valid, altitude, np.inf)
        elif m.valid is not None:
            feedback.gps |= m.valid.reshape(-1, n).any(axis=0)


def _length(agent: AgentModel) -> float:
    return float(np.ptp(agent.vehicle.hull.vertices[:, 0]))
