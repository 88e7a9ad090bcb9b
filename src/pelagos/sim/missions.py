"""Missions of all agents: their guidance, and what it knows from navigation and sensors."""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import CommandError
from pelagos.sim.batch import SensorModel
from pelagos.sim.control import family_of
from pelagos.sim.crew import Crew, crews_of
from pelagos.sim.feedback import Feedback, down_lookers, keys_of, newest_row
from pelagos.sim.guidance.aboard import Aboard, Fix
from pelagos.sim.guidance.guidance import Guidance
from pelagos.sim.guidance.squad import Squad, shape_of
from pelagos.sim.guidance.steering.choice import steering_of
from pelagos.sim.guidance.steering.steering import Steering
from pelagos.sim.model import AgentModel, Model
from pelagos.sim.navigator import External, Navigator, fix_of, navigator_of, renewed
from pelagos.sim.sampled import Sampled
from pelagos.sim.state import AgentState

GUIDANCE_RATE_HZ: Final = 10.0
KEPT: Final = 32  # solutions, of three seconds: a log writes them down at least every second


@dataclass(frozen=True)
class Solution:
    """A solution of navigation at a tick: position `(n, 3)` NWU [m], attitude `(n, 4)`, velocity `(n, 3)` NWU [m/s],
    rate `(n, 3)` body FLU [rad/s].
    """

    tick: int
    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]
    rate: NDArray[np.float64]


class Missions:
    """Guidance, navigation and feedback by agent.

    Attributes:
        period: ticks between two calls of guidance.
        guidance: by agent, those on a mission.
        navigators: by agent, those whose navigation is not the truth.
        feedback: by agent, all.
        solutions: by agent with a navigator, its last solutions, for the log of a run.
        changes: how often an agent's mission or navigation has begun or ended: what `guided` says stands until then.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self.period = model.clock.period(GUIDANCE_RATE_HZ)
        self.guidance: dict[str, Guidance] = {}
        self.navigators: dict[str, Navigator] = {}
        self.feedback: dict[str, Feedback] = {}
        self.solutions: dict[str, deque[Solution]] = {}
        self.changes = 0
        self._squads: tuple[int, Sequence[Squad]] = (-1, ())
        self._crews: tuple[int, Mapping[str, Crew]] = (-1, {})
        self._rows: tuple[int, dict[tuple[str, str], list[int]]] = (-1, {})

    @property
    def any(self) -> bool:
        """Something is to be asked at the rate of guidance."""
        return bool(self.guidance) or bool(self.navigators)

    @property
    def done(self) -> bool:
        """There are missions, and all have ended."""
        return bool(self.guidance) and all(g.done for g in self.guidance.values())

    def memory(self) -> dict[str, Any]:
        """State of all missions and navigators: plain values and arrays, copies."""
        self._settle()
        return copy.deepcopy({
            "guidance": {name: g.memory() for name, g in self.guidance.items()},
            "navigators": {name: n.memory() for name, n in self.navigators.items()},
            "feedback": {
                name: {"altitude": f.altitude, "gps": f.gps, "readings": f.readings}
                for name, f in self.feedback.items()
            },
        })  # fmt: skip

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        kept = copy.deepcopy(dict(memory))
        for agent in self._model.agents.values():  # as at any start: all that is kept is then another
            self.begin(agent, _nowhere(self._model.n))
        self.changes += 1
        self.guidance = {name: self.guidance[name] for name in kept["guidance"]}
        for name, guidance in self.guidance.items():
            guidance.recall(kept["guidance"][name])
        for name, navigator in self.navigators.items():
            navigator.recall(kept["navigators"][name])
        for name, feedback in self.feedback.items():
            for key, values in kept["feedback"][name].items():
                setattr(feedback, key, values)

    def begin(self, agent: AgentModel, state: AgentState, tick: int = 0) -> None:
        """An agent stands at its start; its mission and its navigation begin, if it has any."""
        self._settle()
        self.changes += 1
        n, name = self._model.n, agent.name
        feedback = Feedback(np.full(n, np.inf), np.zeros(n, dtype=bool), down=down_lookers(agent))
        self.feedback[name] = feedback
        self.guidance.pop(name, None)
        self.navigators.pop(name, None)
        navigator = navigator_of(agent, self._model, state)
        if navigator is not None:
            self.navigators[name] = navigator
            self.solutions[name] = deque(maxlen=KEPT)
        if not agent.tasks:
            return
        for key in keys_of(agent):
            feedback.keys.setdefault(key.partition(".")[0], []).append(key)
            feedback.readings[key] = np.full((n, 1), np.nan)
        steering = _steering(agent, n)
        names = agent.vehicle.set_points(agent.mode)
        aboard = self._aboard(name, fix_of(state) if navigator is None else navigator.fix, tick, {})
        self.guidance[name] = Guidance(agent.tasks, steering, names, aboard)

    def restart(self, states: Mapping[str, AgentState], where: NDArray[np.bool_], tick: int) -> None:
        """Missions and navigation begin anew in some copies, where agents are still on their missions.

        Args:
            states: where every agent stands now.
            where: `(n,)` the copies.
            tick: now; at a tick of guidance, where an agent navigates by an estimator.
        """
        if not self.any:
            for feedback in self.feedback.values():
                feedback.altitude = np.where(where, np.inf, feedback.altitude)
                feedback.gps &= ~where
            return
        self._advance(tick)  # so that copies that go on and those that begin have nothing left to take in
        before = self.memory()
        for agent in self._model.agents.values():
            self.begin(agent, states[agent.name], tick)
            if agent.name not in before["guidance"]:
                self.leave(agent.name)
        fresh = self.memory()
        self.recall({kind: {
            name: self.navigators[name].renewed(kept, fresh[kind][name], where) if kind == "navigators"
            else renewed(kept, fresh[kind][name], where) for name, kept in before[kind].items()
        } for kind in before})  # fmt: skip

    def refuse_restart(self, tick: int) -> None:
        """Refuse that some copies begin anew at a tick at which estimators have readings left to take in.

        Raises:
            CommandError: they have.
        """
        estimated = [name for name, navigator in self.navigators.items() if not isinstance(navigator, External)]
        if tick % self.period and estimated:
            dt_s = self._model.clock.dt_ns * 1e-9
            raise CommandError(
                f"reset(where=...) at {tick * dt_s:.6g} s: {estimated[0]} navigates by an estimator, whose copies "
                f"begin anew every {self.period * dt_s:.6g} s only; step to a multiple of that, or reset all copies"
            )

    def leave(self, agent: str) -> None:
        """End an agent's mission: it is commanded from outside."""
        self.changes += 1
        self.guidance.pop(agent, None)

    def guided(self, agent: str, sensor: str) -> bool:
        """Whether guidance or navigation waits for the readings of an agent's sensor."""
        if agent in self.navigators and sensor in self.navigators[agent].listens:
            return True
        if agent not in self.guidance:
            return False
        feedback = self.feedback[agent]
        return sensor in feedback.down or sensor in feedback.keys or self._model.agents[agent].sensors[sensor].fixes

    def commands(self, tick: int, rows: Mapping[str, NDArray[np.float64]]) -> Mapping[str, NDArray[np.float64]]:
        """Set-points `(n, k)` of the agents on a mission, of their motions; none between the ticks of guidance."""
        if tick % self.period:
            return {}
        self._navigate(tick)
        asked: dict[str, NDArray[np.float64]] = {}
        for squad in self._squads_now(tick, rows):
            if squad.in_step:
                asked |= squad.command(*self._together(squad.members, tick, rows, squad.followed))
        true: dict[str, Fix] = {}
        for name, guidance in self.guidance.items():
            if name in asked:
                continue
            for who in (name, *guidance.followed):
                if who not in true:
                    true[who] = fix_of(_state(rows[who]))
            known = self._known(name) or true[name]
            aboard = self._aboard(name, known, tick, {who: true[who] for who in guidance.followed})
            truth = None if known is true[name] else self._aboard(name, true[name], tick, {})
            asked[name] = guidance.command(aboard, truth)
        for name in asked:
            self.feedback[name].gps[:] = False
        return asked

    def _advance(self, tick: int) -> None:
        """Bring all navigation to a tick."""
        crews = self._crews_now()
        for crew in dict.fromkeys(crews.values()):
            crew.advance(tick)
        for name, navigator in self.navigators.items():
            if name not in crews:
                navigator.advance(tick)

    def _navigate(self, tick: int) -> None:
        """Bring all navigation to a tick, and keep the solutions."""
        self._advance(tick)
        crews = self._crews_now()
        for crew in dict.fromkeys(crews.values()):
            parts = *crew.whole.motion, crew.whole.rate
            for name in crew.members:
                own = crew.lanes(name)
                self.solutions[name].append(Solution(tick, *(values[own] for values in parts)))
        for name, navigator in self.navigators.items():
            if name not in crews:
                self.solutions[name].append(Solution(tick, *navigator.motion, navigator.rate))

    def _crews_now(self) -> Mapping[str, Crew]:
        """By agent, estimators that go on together, found anew where a mission or navigation has begun or ended."""
        if self._crews[0] != self.changes:
            self._settle()
            batches = {
                name: (agent.batch.name, agent.member, len(agent.batch.members))
                for name, agent in self._model.agents.items()
                if name in self.navigators
            }
            found = crews_of(self.navigators, batches, self._model.n) if batches else ()
            self._crews = self.changes, {name: crew for crew in found for name in crew.members}
        return self._crews[1]

    def _settle(self) -> None:
        """Give every navigator its state, where a crew has it."""
        crews, self._crews = self._crews[1], (-1, {})
        for crew in dict.fromkeys(crews.values()):
            crew.settle()

    def _squads_now(self, tick: int, rows: Mapping[str, NDArray[np.float64]]) -> Sequence[Squad]:
        """Agents that are guided together, found anew where a mission has begun or ended."""
        if self._squads[0] != self.changes:
            groups: dict[Hashable, dict[str, Guidance]] = {}
            for name, guidance in self.guidance.items():
                kind = self._model.agents[name].batch.name, name in self.navigators, shape_of(guidance)
                groups.setdefault(kind, {})[name] = guidance
            self._squads = self.changes, [self._squad(g, tick, rows) for g in groups.values() if len(g) > 1]
        return self._squads[1]

    def _squad(self, members: dict[str, Guidance], tick: int, rows: Mapping[str, NDArray[np.float64]]) -> Squad:
        agent, aboard = self._model.agents[next(iter(members))], self._together(members, tick, rows, {})[0]
        return Squad(members, _steering(agent, len(aboard)), agent.vehicle.set_points(agent.mode), aboard)

    def _together(
        self,
        names: Collection[str],
        tick: int,
        rows: Mapping[str, NDArray[np.float64]],
        followed: Mapping[str, Sequence[str]],
    ) -> tuple[Aboard, Aboard | None]:
        """Knowledge of the agents of a squad, lane after lane, and the truth where that is another.

        Of those that they follow they know the truth.
        """

        def true(agents: Collection[str]) -> Fix:
            return fix_of(_state(np.concatenate([rows[name] for name in agents])))

        each, dt_s = [self.feedback[name] for name in names], self._model.clock.dt_ns * 1e-9
        truth = Aboard(
            own=true(names),
            t_s=tick * dt_s,
            dt_s=self.period * dt_s,
            altitude=np.concatenate([f.altitude for f in each]),
            fixed=np.concatenate([f.gps for f in each]),
            readings={key: np.concatenate([f.readings[key] for f in each]) for key in each[0].readings},
            others={who: true(these) for who, these in followed.items()},
        )
        known = self._all_known(names)
        return (truth, None) if known is None else (replace(truth, own=known), truth)

    def _all_known(self, names: Collection[str]) -> Fix | None:
        """Solutions of agents, lane after lane; None where they know the truth."""
        first = next(iter(names))
        if first not in self.navigators:
            return None
        crew = self._crews_now().get(first)
        if crew is not None and crew.members == tuple(names):
            return crew.fix
        fixes = [self._known(name) for name in names]
        return Fix(*(np.concatenate([getattr(fix, k) for fix in fixes]) for k in ("position", "heading", "velocity")))

    def hear(self, sampled: Sampled) -> None:
        """Keep what guidance and navigation need of a sensor's readings."""
        if len(sampled.members) > 1:
            for crew in dict.fromkeys(self._crews_now().values()):
                if crew.members[0] in sampled.members and sampled.model.name in crew.listens:
                    crew.hear(sampled)
            for member in self._listeners(sampled.members, sampled.model):
                self.hear(sampled.of(member, self._model.n))
            return
        name, agent = sampled.model.name, sampled.members[0]
        if agent in self.navigators and name in self.navigators[agent].listens and agent not in self._crews_now():
            self.navigators[agent].hear(sampled)
        feedback = self.feedback[agent]
        if name in feedback.down:
            found = newest_row(sampled, feedback.down[name], self._model.n)[:, 0]
            feedback.altitude = np.where(np.isfinite(found), found, np.inf)
        if sampled.model.fixes and sampled.measurement.valid is not None:
            feedback.gps |= sampled.measurement.valid.reshape(-1, self._model.n).any(axis=0)
        for key in feedback.keys.get(name, ()):
            feedback.readings[key] = newest_row(sampled, key.partition(".")[2], self._model.n)

    def _listeners(self, members: Sequence[str], sensor: SensorModel) -> Sequence[int]:
        """Rows of the members whose readings are kept, which stay the same until an agent begins anew."""
        if self._rows[0] != self.changes:
            self._rows = self.changes, {}
        known, key = self._rows[1], (members[0], sensor.name)
        if key not in known:
            known[key] = [row for row, agent in enumerate(members) if self._listens(agent, sensor)]
        return known[key]

    def _listens(self, agent: str, sensor: SensorModel) -> bool:
        """Whether readings of an agent's sensor are kept."""
        feedback, name = self.feedback[agent], sensor.name
        if name in feedback.down or name in feedback.keys or sensor.fixes:
            return True
        alone = agent in self.navigators and agent not in self._crews_now()
        return alone and name in self.navigators[agent].listens

    def _known(self, name: str) -> Fix | None:
        """The newest solution of an agent; None where it knows the truth."""
        crew, navigator = self._crews_now().get(name), self.navigators.get(name)
        if crew is not None:
            return crew.fix_of(name)
        return None if navigator is None else navigator.fix

    def _aboard(self, name: str, fix: Fix, tick: int, others: Mapping[str, Fix]) -> Aboard:
        feedback, dt_s = self.feedback[name], self._model.clock.dt_ns * 1e-9
        return Aboard(
            own=fix, t_s=tick * dt_s, dt_s=self.period * dt_s, altitude=feedback.altitude, fixed=feedback.gps,
            readings=feedback.readings, others=others,
        )  # fmt: skip


def _state(row: NDArray[np.float64]) -> AgentState:
    return AgentState.of(row, np.empty((len(row), 0)))  # guidance does not ask for actuators


def _nowhere(n: int) -> AgentState:
    zero = np.zeros((n, 3))
    return AgentState(zero, np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)), zero, zero, zero, zero, np.empty((n, 0)))


def _steering(agent: AgentModel, lanes: int) -> Steering:
    family, envelope = family_of(agent.vehicle, agent.mode), agent.vehicle.config.envelope
    return steering_of(family, envelope, _length(agent), lanes)


def _length(agent: AgentModel) -> float:
    return float(np.ptp(agent.vehicle.hull.vertices[:, 0]))
