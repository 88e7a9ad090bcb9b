"""Groups of agents at the face of a simulation: what is given to a group, or asked of it, goes by its members."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import CommandError, LookupFailed
from pelagos.sim.bodies import rows, unit_rows
from pelagos.sim.model import AgentModel, Model

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

_WIDTHS: Final = {"position": 3, "attitude": 4, "velocity": 3, "angular_velocity": 3}


def one_agent(model: Model, name: str) -> AgentModel:
    """A single agent.

    Raises:
        CommandError: there is none of this name, or it is a group's.
    """
    agent = model.agents.get(name) if isinstance(name, str) else None
    if agent is not None:
        return agent
    count = model.groups.get(name) if isinstance(name, str) else None
    if count is not None:
        raise CommandError(f"{name} is a group of {count}: name one member, {name}[0] to {name}[{count - 1}]")
    raise CommandError(str(LookupFailed("agent", name, [*model.agents, *model.groups])))


def by_member(values: object, members: list[str], n: int, what: str) -> list[NDArray[np.float64]]:
    """Parts `(k,)` or `(n, k)` of what is given to a group: `(k,)`, `(members, k)` or `(n, members, k)`.

    Raises:
        CommandError: another shape, or no numbers.
    """
    shapes = f"(k,), ({len(members)}, k) or ({n}, {len(members)}, k)"
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise CommandError(f"{what} of a group is numbers of shape {shapes}; given {values!r}") from None
    fits = array.ndim == 1 or (array.ndim in (2, 3) and array.shape[-2] == len(members))
    if not fits or (array.ndim == 3 and array.shape[0] != n):
        raise CommandError(f"{what} of a group has shape {shapes}; given {array.shape}")
    return [array if array.ndim == 1 else array[..., i, :] for i in range(len(members))]


def by_agent(commands: Mapping[str, Any], model: Model, n: int) -> dict[str, Any]:
    """Commands by single agent, those of groups by their members."""
    found: dict[str, Any] = {}
    for name, values in commands.items():
        members = model.group(name)
        if members is None:
            found[name] = values
        else:
            found |= zip(members, by_member(values, members, n, f"{name}: a command"), strict=True)
    return found


def held_command(sim: Simulation, name: str) -> NDArray[np.float64]:
    """`(n, k)` the command that an agent holds; of a group `(n, members, k)`.

    Raises:
        CommandError: there is no such agent, or members are in control modes with other set-points.
    """
    members = sim.model.group(name)
    if members is None:
        return sim.stepper.command_values(one_agent(sim.model, name).name)
    modes = {member: sim.stepper.mode(member) for member in members}
    names = {member: sim.model.agents[member].vehicle.command_names(mode) for member, mode in modes.items()}
    other = next((member for member in members if names[member] != names[members[0]]), None)
    if other is not None:
        raise CommandError(
            f"{name}: members hold other set-points, {members[0]} in {modes[members[0]]!r} and {other} in "
            f"{modes[other]!r}; ask them one by one"
        )
    return np.stack([sim.stepper.command_values(member) for member in members], axis=1)


def place(sim: Simulation, name: str, where: NDArray[np.bool_], given: Mapping[str, object]) -> None:
    """See `Simulation.set_state`; parts that are None stay as they are."""
    members, n = sim.model.group(name), sim.n
    given = {key: value for key, value in given.items() if value is not None}
    parts: dict[str, Sequence[object]]
    if members is None:
        members, parts = [one_agent(sim.model, name).name], {key: [value] for key, value in given.items()}
    else:
        parts = {key: by_member(value, members, n, f"{name}: {key}") for key, value in given.items()}
    now, placed = sim.state, {}
    for i, member in enumerate(members):
        what, mine = f"{member}: ", now[member]
        placed[member] = {
            key: getattr(mine, key) if key not in parts
            else unit_rows(parts[key][i], n, what + key) if key == "attitude"
            else rows(parts[key][i], n, width, what + key)
            for key, width in _WIDTHS.items()
        }  # fmt: skip
    sim.stepper.set_states(placed, where)
