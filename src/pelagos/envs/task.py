"""The contract of a task: where episodes begin, what is seen, what is rewarded, when they end.

A task is written in the arithmetic of arrays, one lane a copy. It is called once, while the environment is recorded,
and compiled with the vehicle's physics into one kernel: branches on values are `dr.select`, and a number that should
differ from episode to episode is drawn and kept in the memory.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from pelagos.envs.draws import Draws
from pelagos.envs.view import View
from pelagos.jit import Array


@dataclass
class Sea:
    """Change of the ocean's waves for an episode; arrays or numbers.

    Attributes:
        scale: factor on all heights, 0 or more.
        turn_rad: angle that they are turned by about the origin, counter-clockwise from above.
        moment_s: time of the ocean at which the episode begins [s]: each has phases of its own.
    """

    scale: Array = 1.0
    turn_rad: Array = 0.0
    moment_s: Array = 0.0


@dataclass
class Start:
    """Beginning of an episode; components are arrays or numbers.

    Attributes:
        position: world NWU (3) [m].
        attitude: (w, x, y, z), body FLU to world; level with the bow north where not given.
        velocity: over ground, body FLU (3) [m/s].
        angular_velocity: body FLU (3) [rad/s].
        memory: what the task keeps from step to step, by name; the names are the same in every episode.
        current: of the water, world NWU (3) [m/s], in place of the ocean's; None: the ocean's.
        sea: see `Sea`; None: the same waves in every episode.
    """

    position: list[Array]
    attitude: list[Array] = field(default_factory=lambda: [1.0, 0.0, 0.0, 0.0])
    velocity: list[Array] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    angular_velocity: list[Array] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    memory: dict[str, Array] = field(default_factory=dict)
    current: list[Array] | None = None
    sea: Sea | None = None


@dataclass
class Outcome:
    """Outcome of a step.

    Attributes:
        reward: of the step.
        terminated: whether the episode ends here for good, `Bool`; the limit of time is not the task's matter.
        memory: what changed of the task's memory, by name.
        metrics: numbers that people want to see, by name, such as the distance to the goal [m].
    """

    reward: Array
    terminated: Array = False
    memory: dict[str, Array] = field(default_factory=dict)
    metrics: dict[str, Array] = field(default_factory=dict)


class Task(Protocol):
    """See the module. A class that names this one as its base has these defaults.

    Attributes:
        vehicle: of the catalogue, or what a scenario writes under `vehicle:`.
        control: mode in which the vehicle takes commands; its default where empty.
        actions: how many numbers between -1 and 1 an action has; as many as the mode has set-points where 0.
        rate_hz: of decisions.
        tick_rate_hz: of the physics, a multiple of `rate_hz`.
        seconds: an episode lasts at most [s].
        ocean: what a scenario writes under `ocean:`.
        vary: factors on the vehicle's parameters, (least, largest), even between them, drawn every episode; keys are
            `mass`, `added_mass`, `thrust`, `lag`, or the name of a term such as `quadratic_damping`.
        observations: what each number of an observation is.
    """

    vehicle: str | Mapping[str, Any]
    control: str = ""
    actions: int = 0
    rate_hz: float = 20.0
    tick_rate_hz: float = 100.0
    seconds: float = 10.0
    ocean: Mapping[str, Any] = {}
    vary: Mapping[str, tuple[float, float]] = {}
    observations: tuple[str, ...]

    def draw(self, random: Draws) -> Start:
        """The beginning of an episode."""
        ...

    def observe(self, now: View, random: Draws) -> list[Array]:
        """Observation of the policy, one number for each of `observations`."""
        ...

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """Reward of the step that led here, with the action (each number -1 .. 1) that was taken."""
        ...

    def command(self, action: list[Array], now: View) -> list[Array]:
        """Set-points of the control mode for an action; the action itself where not given."""
        return action
