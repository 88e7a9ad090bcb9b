"""Legs of missions as they were flown: a line for each vehicle on the terminal, a table in the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from pelagos.config.swarm import topic_name
from pelagos.report.mission import missions
from pelagos.report.page import Section, table
from pelagos.sim.control import family_of
from pelagos.sim.guidance.outcome import Flown, LegOutcome, Track, outcomes
from pelagos.sim.replay import Recording

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

FlownLegs: TypeAlias = Mapping[str, Sequence[LegOutcome]]

MOST_LINES: Final = 8  # of vehicles that are told one by one
MOST_TRACKS: Final = 100  # of vehicles whose tracks are looked at
_NO_TRACK: Final = Track(np.zeros(0), np.zeros((0, 3)))


def flown_legs(sim: Simulation, recording: Path) -> dict[str, list[LegOutcome]]:
    """Outcome of every leg of the agents that are on their missions, in the first copy.

    Raises:
        RecordingError: the recording cannot be read.
    """
    guided = sim.stepper.missions.guidance
    tracks = _tracks(recording, list(guided), sim.n) if 0 < len(guided) <= MOST_TRACKS else {}
    found = {}
    for name, guidance in guided.items():
        agent = sim.model.agents[name]
        flown = Flown(
            guidance.steps, [leg.type for leg in agent.config.mission], float(guidance.begun[0]), guidance.ended[0],
            int(guidance.progress.task[0]), family_of(agent.vehicle, agent.mode).stops,
        )  # fmt: skip
        found[name] = outcomes(flown, tracks.get(topic_name(name), _NO_TRACK))
    return found


def _tracks(recording: Path, agents: Sequence[str], copies: int) -> dict[str, Track]:
    """True tracks in the first copy by agent, as topics name it."""
    places = [("" if copies == 1 else "env0/") + topic_name(agent) for agent in agents]
    kept = Recording(recording, topics={f"/{place}/truth" for place in places})
    return {m.name: Track(m.motion.t, m.motion.position) for m in missions(kept)}


def legs_lines(flown: FlownLegs, ended_s: float) -> list[str]:
    """Lines that tell missions on a terminal; ended_s: when the run did [s]."""
    if len(flown) <= MOST_LINES:
        return [f"{name}: {_told(legs, ended_s)}" for name, legs in flown.items()]
    open_ = [name for name, legs in flown.items() if legs[-1].ended_s is None]
    text = f"{len(flown) - len(open_)} of {len(flown)} missions done"
    if open_:
        more = f" and {len(open_) - MOST_LINES} more" if len(open_) > MOST_LINES else ""
        text += f"; under way: {', '.join(open_[:MOST_LINES])}{more}"
    return [text + _within([leg for legs in flown.values() for leg in legs])]


def _told(legs: Sequence[LegOutcome], ended_s: float) -> str:
    done = [leg for leg in legs if leg.ended_s is not None]
    text = f"{len(done)} of {len(legs)} legs"
    last = done[-1].ended_s if done else None
    if len(done) == len(legs) and last is not None and legs[0].began_s is not None:
        text += f", {last - legs[0].began_s:.0f} s"
    elif len(done) < len(legs):
        leg = legs[len(done)]
        since = ended_s - (leg.began_s or 0.0)
        text += f"; leg {len(done) + 1} ({leg.kind}) had taken {since:.0f} s when the run ended"
    for number, leg in enumerate(legs, 1):
        if leg.late:
            text += f"; leg {number} ({leg.kind}) ended by its time, without a fix"
    return text + _within(legs)


def _within(legs: Sequence[LegOutcome]) -> str:
    """Largest distances from the way, by kind of leg."""
    most: dict[str, float] = {}
    for leg in legs:
        if leg.off_m is not None:
            most[leg.kind] = max(leg.off_m, most.get(leg.kind, 0.0))
    told = [f"{kind} within {_metres(off)}" for kind, off in most.items()]
    return "; " + ", ".join(told) if told else ""


def _metres(value: float) -> str:
    return f"{value:.2f} m" if value < 10 else f"{value:.0f} m"


def legs_numbers(flown: FlownLegs) -> dict[str, list[dict[str, Any]]]:
    """The same for `stats.json`."""
    return {topic_name(name): [asdict(leg) for leg in legs] for name, legs in flown.items()}


def legs_table(name: str, numbers: Mapping[str, Any]) -> list[Section]:
    """Table of a mission's legs; none where there was no mission."""
    rows = [
        [
            str(number), leg["kind"], _seconds(leg["began_s"]), _seconds(leg["ended_s"]),
            "-" if leg["off_m"] is None else _metres(leg["off_m"]), _state(leg),
        ]
        for number, leg in enumerate(numbers.get("legs", {}).get(name, ()), 1)
    ]  # fmt: skip
    if not rows:
        return []
    text = (
        "Largest distance from the way, by the true track: across lines from their middles on (from the points, where "
        "a leg has no line), from the circle after a quarter turn, from the place that was to be kept."
    )
    head = ["leg", "", "began [s]", "ended [s]", "within", ""]
    return [Section(f"Mission of {name}", text, table(head, rows, numbers=(0, 2, 3, 4), code=(1,)))]


def _state(leg: Mapping[str, Any]) -> str:
    if leg["ended_s"] is not None:
        return "ended by its time, without a fix" if leg["late"] else "done"
    return "not begun" if leg["began_s"] is None else "under way when the run ended"


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
