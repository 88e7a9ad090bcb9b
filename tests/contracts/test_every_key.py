"""Nothing is accepted that is then ignored: every key of every term, actuator and control mode changes what it does.

Each part of each vehicle of the catalogue, and each of `sample_parts`, is evaluated in the same motions of both signs,
before and after one of its numbers, switches or choices has moved away from what it is. A key counts as heard if it
makes a difference in any vehicle.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from other_values import others
from pydantic import BaseModel, ValidationError
from sample_parts import UNIONS, kinds, parts

from known import DOUBLE, check, flat
from pelagos import jit
from pelagos.errors import InputError
from pelagos.hydro.images import Plane
from pelagos.vehicles.actuators.t200 import t200_tables
from pelagos.vehicles.cargo import Carrier
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow, Supply
from pelagos.vehicles.wetness import Wetness

DEAF = {
    "actuators.ship_engine.service_hz": "trials and missions order it; the engine itself turns as it is told",
    "modes.engine_forces.command=place": "refused beside thrusters; see tests of HoloOcean's agents",
    "modes.engine_forces.command=pose": "as place",
    "terms.hydrostatic.center_of_flotation_m.2": "heave, roll and pitch act through x and y of that point alone",
    "terms.roll_damping.sections=hull": "refused beside the numbers of a form; see test_roll_sections",
}
"""Keys that no motion below hears, or that allow no other value, and why."""
STATES = 12
TOGETHER = 2
"""Changes that one kernel evaluates: large ones take long to compile."""


def flows(fast: float) -> Flow:
    """Motions of both signs, unequal in all components, in a current and in waves: twelve lanes."""
    rng = np.random.default_rng(7)
    nu = rng.uniform(-1, 1, (6, STATES)) * np.array([[fast, 0.3 * fast, 0.3 * fast, 0.5, 0.4, 0.6]]).T
    nu[0, : STATES // 2] = np.abs(nu[0, : STATES // 2])
    water = rng.uniform(-0.3, 0.3, (6, STATES)) * np.array([[1.0, 1, 1, 0.02, 0.02, 0.02]]).T
    nu[:, 4::5], water[:, 4::5] = 0.01 * nu[:, 4::5], 0.01 * water[:, 4::5]
    roll, pitch, yaw = rng.uniform(-1, 1, (3, STATES)) * np.array([[0.5], [0.4], [3.0]])
    yaw[4::5] *= 0.05  # near their course: a helm that is hard over hears no gain
    (cr, cp, cy), (sr, sp, sy) = ([f(a) for a in (roll, pitch, yaw)] for f in (np.cos, np.sin))
    rotation = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    place = rng.uniform(-1, 1, (3, STATES)) * np.array([[9.0], [7.0], [0.4]]) + np.array([[0.0], [0.0], [0.3]])
    place[2, ::3] += 20.0
    lanes = lambda rows: [jit.Float64(np.ascontiguousarray(r)) for r in rows]
    surface = 0.2 * rng.normal(size=(2, STATES))
    air = lanes(rng.uniform(-9, 9, (3, STATES)))
    return Flow(
        position=lanes(place), immersion=jit.Float64(place[2].copy()), rotation=[lanes(row) for row in rotation],
        nu=lanes(nu), nu_r=lanes(nu - water), current_rate=lanes(0.1 * water), surface=lanes(surface),
        air=lambda height: [a * (1.0 + 0.02 * height) for a in air], step=jit.Float64(0.05),
        water_acceleration=lanes(0.1 * water), wet=Wetness(*lanes(rng.uniform(0.2, 0.9, (2, STATES)))),
        planes=(Plane(jit.Float64(np.linspace(23.0, 41.0, STATES)), [-x for x in lanes(rotation[2])], 1.0),),
    )  # fmt: skip


def moves(config: BaseModel) -> Iterator[tuple[str, str, Any]]:
    """Each number, switch and choice of a part with another in its place: `(path, key, whole new value)`."""
    schema = type(config).model_json_schema()
    for key, value in config.model_dump(mode="json").items():
        if key == "type":
            continue
        if isinstance(value, float) and "limit" in key:
            yield key, key, 0.1 * value
        for path, moved in others(schema["properties"][key], schema.get("$defs", {}), value):
            yield f"{key}{path}", key, moved


def changed(config: BaseModel, key: str, value: Any) -> BaseModel | None:
    """The part with another value of a key, None where that is refused."""
    try:
        return type(config).model_validate(config.model_dump(mode="json") | {key: value})
    except ValidationError:
        return None


def of_term(config: Any, plant: Plant, flow: Flow) -> list[Any]:
    """Force and moment; a body floats as its own hydrostatics say."""
    body = plant.body
    if hasattr(config, "stiffness"):
        body = replace(body, stiffness=config.stiffness(body))
    return list(config.build(body).wrench(flow))


def between(lag: Any) -> np.ndarray:
    """States of an actuator that others look at, of both signs where it has them."""
    low, high = (float(getattr(lag, end, sign)) for end, sign in (("low", -1.0), ("high", 1.0)))
    return np.random.default_rng(5).uniform(0.9 * low, 0.9 * high, STATES)


def of_actuator(config: Any, plant: Plant, flow: Flow) -> list[Any]:
    """Force and moment at states of both signs, mass aboard, and where the state goes from there in a step: at the
    start of an episode and late in it, to a command far off and to one nearby.
    """
    made = config.build(plant.body)
    law = made.follower(flow) if isinstance(made, Carrier) else made.lag
    rng = np.random.default_rng(3)
    low, high = (float(getattr(law, end, sign)) for end, sign in (("low", -1.0), ("high", 1.0)))
    states, commands = rng.uniform(1.3 * low, 1.3 * high, (2, STATES))
    late, near = np.tile([0.0, 9.0], STATES // 2), np.arange(STATES) // 2 % 2 == 0
    state, command = jit.Float64(states), jit.Float64(np.where(near, states + 0.01 * commands, commands))
    kept = [jit.Float64(late * rng.uniform(0, 1, STATES)) for _ in range(law.memory)]
    found = [*made.wrench(law.limited(state), flow), *law.rates(state, kept, command)]
    found += law.after(state, kept, command, jit.Float64(0.05))
    if isinstance(made, Carrier):
        aboard, taken = made.cargo(law.limited(state), flow), made.taken(state, command, flow)
        found += [aboard.mass, aboard.displaced, *aboard.center, *(x for row in aboard.inertia for x in row)]
        found += [taken.mass]
    found += [jit.Float64(np.full(STATES, float(v))) for v in (*made.site.point, made.site.size)]  # for its wetness
    if hasattr(made, "command"):
        found.append(made.command(jit.Float64(rng.uniform(-20, 20, STATES))))
    return found


def of_mode(config: Any, plant: Plant, flow: Flow) -> list[Any]:
    """What it asks for in two steps on end, set-points near and far, and what it keeps in mind."""
    law = config.build(plant)
    rng, found = np.random.default_rng(3), []
    for size in (0.5, 20.0):
        memory = [
            m + jit.Float64(0.5 * rng.normal(size=STATES)) for m in law.start(flow)
        ]  # in the midst of a manoeuvre
        command = [jit.Float64(size * rng.uniform(-1, 1, STATES)) for _ in law.commands]
        for step in (0.004, 2.0):  # limits of rates take a while
            demand, memory = law.act(memory, flow, command, jit.Float64(step))
            found += [*demand.actuators.values(), *(demand.wrench or []), *(demand.acceleration or []), *memory]
    return found


KINDS = {"terms": of_term, "actuators": of_actuator, "modes": of_mode}


def heard(
    kind: str, config: BaseModel, plant: Plant, flow: Flow, known: Set[str], numbers: dict[str, Any]
) -> Iterator[tuple[str, bool]]:
    """Each key of a part that is not `known`, and whether its change is felt; all are evaluated in one kernel.

    What comes of each change is put down in `numbers`.
    """
    plain, moved, tried, refused = KINDS[kind](config, plant, flow), [], set(), set()
    for path, key, value in moves(config):
        if path in known or path in tried:
            continue
        refused.add(path)
        other = changed(config, key, value)
        try:
            found = None if other is None else KINDS[kind](other, plant, flow)
        except InputError:  # beyond what a published formula holds for
            continue
        if found is not None:
            tried.add(path)
            moved.append((path, found))
    for few in (moved[k : k + TOGETHER] for k in range(0, len(moved), TOGETHER)):
        dr.eval(plain, [found for _, found in few])
    before = [np.array(v) for v in plain]
    numbers[""] = flat(before)
    yield from ((key, False) for key in refused - tried)
    for key, found in moved:
        after = [np.array(v) for v in found]
        numbers[key] = flat(after)
        same = len(before) == len(after) and all(
            np.array_equal(*np.broadcast_arrays(a, b), equal_nan=True) for a, b in zip(before, after, strict=True)
        )
        yield key, not same


@pytest.mark.parametrize("group", sorted(UNIONS))
def test_every_kind_of_part_has_a_sample(group: str) -> None:
    found = {part.type for _, of_it in parts(group) for part in of_it}  # type: ignore[attr-defined]
    assert not kinds(group) - found, "no vehicle of the catalogue has it: give a part of it in sample_parts.SAMPLES"


@pytest.mark.parametrize("group", ["terms", "actuators", pytest.param("modes", marks=pytest.mark.slow)])
def test_every_key_of_a_part_changes_what_it_does_as_known(group: str) -> None:
    felt: dict[str, dict[str, bool]] = {}
    told: dict[str, Any] = {}
    for vehicle, of_it in parts(group):
        plant = Plant(vehicle.model, vehicle.config.body)
        flow = flows(max(vehicle.config.length_m**0.5, 1.0) * (8.0 if vehicle.config.medium == "air" else 1.0))
        if vehicle.config.battery is not None:
            tables = t200_tables(vehicle.config.battery.open_circuit_v)
            flow.supply = Supply(jit.Float64(np.linspace(12.3, 16.1, STATES)), tables)
        flow.actuators = {n: jit.Float64(between(a.lag)) for n, a in vehicle.model.actuators.items()}
        for part in of_it:
            known = felt.setdefault(part.type, {})  # type: ignore[attr-defined]
            numbers: dict[str, Any] = {}
            for key, is_felt in heard(group, part, plant, flow, {k for k, v in known.items() if v}, numbers):
                known[key] = known.get(key, False) or is_felt
            told |= {f"{len(told)} {part.type} {key}".strip(): v for key, v in numbers.items()}  # type: ignore[attr-defined]
    keys = {f"{group}.{part}.{key}": is_felt for part, known in felt.items() for key, is_felt in known.items()}
    assert len(keys) > 40
    check("keys_of_parts", group, told, DOUBLE)
    deaf = sorted(at for at, is_felt in keys.items() if not is_felt)
    assert deaf == sorted(at for at in DEAF if at.startswith(group)), "\n".join(deaf)
