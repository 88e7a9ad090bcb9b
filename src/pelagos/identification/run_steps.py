"""Steps of the run that a recording is of: the motion that it holds is theirs, not that of the vehicle itself."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Final, get_args

import yaml

from pelagos.config.swarm import group_of
from pelagos.identification.plan import Integrator, Plan
from pelagos.sim.record import SCENARIO
from pelagos.sim.replay import Recording

SHORTEST_STEP_S: Final = 1e-3 * (1 - 1e-9)
"""Of the simulation [s]: its error is far below what any record shows."""
MOST: Final = 16
"""Substeps that a fit takes by itself."""
_SAME: Final = 1e-6  # of a step


@dataclass(frozen=True)
class RunSteps:
    """Way of a run's steps, `VehicleConfig.integrator`, and their length [s]."""

    integrator: str
    tick_s: float

    def are(self, integrator: str, step_s: float) -> bool:
        """True for steps of the same way and length."""
        return integrator == self.integrator and abs(step_s - self.tick_s) <= _SAME * self.tick_s

    def ticks(self, step_s: float) -> int | None:
        """Number of ticks in a step of so many seconds; None where it is no whole one."""
        found = round(step_s / self.tick_s)
        return found if found and abs(found * self.tick_s - step_s) <= _SAME * step_s else None

    def grid_s(self, spacing_s: float, usual_s: float) -> float:
        """Step of the grid of rows that are so far apart [s]: whole ticks, where they come near to the usual step."""
        rows = self.ticks(spacing_s) or 0
        whole = [d * self.tick_s for d in range(1, rows + 1) if rows % d == 0]
        return max((h for h in whole if 0.5 * usual_s < h <= usual_s * (1 + _SAME)), default=usual_s)


def run_steps(recording: Recording, columns: Collection[str]) -> RunSteps | None:
    """Steps of the vehicle whose columns, a topic and its fields each, a recording of `pelagos run` has.

    None where the recording is another program's, the columns are no vehicle's, or of several that differ, and for
    steps that are so short that their error is nothing.
    """
    agents = {
        str(channel.about["agent"])
        for topic, channel in recording.channels.items()
        if "agent" in channel.about and any(name == topic or name.startswith(f"{topic}.") for name in columns)
    }
    text, tick_ns = recording.attachments.get(SCENARIO), recording.metadata.get("dt_ns", "")
    if not (agents and text and tick_ns.isdigit() and 1e-9 * int(tick_ns) >= SHORTEST_STEP_S):
        return None
    told = {_integrator(_scenario(text), agent) for agent in agents}
    (integrator,) = told if len(told) == 1 else ("",)
    return RunSteps(integrator, 1e-9 * int(tick_ns)) if integrator in get_args(Integrator) else None


def _scenario(text: bytes) -> Any:
    try:
        return yaml.load(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except yaml.YAMLError:  # damaged
        return None


def _integrator(scenario: Any, agent: str) -> str:
    """The word of a scenario, as it was recorded, on an agent's vehicle; empty where there is none."""
    entry, number = _at(scenario, "agents", group_of(agent)), agent.partition("[")[2].rstrip("]")
    own = _at(entry, "overrides", int(number), "vehicle") if number.isdigit() else None
    told = _at(own, "integrator")
    if own is not None and not told and (not isinstance(own, Mapping) or "type" in own):
        return ""  # another vehicle than the group's, whose word the scenario leaves to the catalogue
    return str(told or _at(entry, "vehicle", "integrator") or "")


def _at(node: Any, *keys: str | int) -> Any:
    for key in keys:
        node = node.get(key) if isinstance(node, Mapping) else None
    return node


def says_its_steps(plan: Plan) -> bool:
    """True for a plan that says anything of the fit's steps."""
    said = (plan.integrator, plan.substeps, plan.step_s, plan.vehicle.get("integrator"))
    return any(word is not None for word in said)


def in_run_steps(plan: Plan, run: RunSteps | None, grid_s: float) -> Plan:
    """A plan that says nothing of steps with those of the run, where they are few in one of the record's grid [s]."""
    ticks = None if run is None or says_its_steps(plan) else run.ticks(grid_s)
    if run is None or ticks is None or ticks > MOST:
        return plan
    return plan.model_copy(update={"integrator": run.integrator, "substeps": ticks})
