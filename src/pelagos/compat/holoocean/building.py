"""The native simulation of an environment: made for its agents, and told at every tick what scripts asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.compat.holoocean.frames import quaternion_of
from pelagos.compat.holoocean.native_scenario import lcm_of, native_scenario
from pelagos.config.loader import load_scenario
from pelagos.errors import ScenarioError
from pelagos.sim.simulation import Simulation

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment


def build(env: HoloOceanEnvironment, *, fresh: bool = False, warm: int = 0) -> None:
    """The native simulation of the present agents; with `fresh` from the start, else from where they are."""
    env._stale = False
    kept = None if fresh or env._sim is None else _kept(env._sim)
    turn = lcm_of(s.tick_every for a in env.agents.values() for s in a.sensors.values())
    first = -(-(warm + 1) // turn) * turn - (warm + 1)
    env._lead = first + warm + 1 - env._num_ticks
    native = native_scenario(env, env.agents.values())
    starts = {
        a.native_name: {
            "position": a.definition.starting_loc, "attitude": quaternion_of(a.definition.starting_rot)
        }
        for a in env.agents.values()
    }  # fmt: skip
    same = {**native, "agents": {n: {**a, "start": None} for n, a in native["agents"].items()}}
    if env._sim is None or same != env._native:
        try:
            env._sim = Simulation.load(load_scenario(native), seed=native["seed"])
        except ScenarioError as error:
            raise HoloOceanException(f"this scenario cannot be: {error}") from error
        env._native = same
    if kept is not None:
        starts |= {name: state for name, state in kept.items() if name in starts}
    env._sim.reset(state=starts, tick=first, episode=env._resets)
    for agent in env.agents.values():
        agent.changed = True
    env._restore_surroundings(fresh=fresh)


def _kept(sim: Simulation) -> dict[str, Any]:
    names = ("position", "attitude", "velocity", "angular_velocity")
    return {name: {k: getattr(state, k) for k in names} for name, state in sim.state.items()}


def hand_over(env: HoloOceanEnvironment) -> None:
    """Hand over what was asked since the last tick."""
    sim = env.pelagos
    env._change_surroundings(sim)
    commands = {}
    for agent in env.agents.values():
        if agent.place:
            sim.set_state(agent.native_name, **agent.native_place())
            env.motions.pop(agent.name, None)
        step = agent.step_of_tick()
        if step:
            sim.set_state(agent.native_name, **step)
        if agent.changed:
            native, mode = agent.native_name, agent.mode
            if sim.stepper.mode(native) != mode:
                sim.set_mode(native, mode)
            commands[native] = agent.command()
            agent.changed = False
    if commands:
        sim.command(commands)
