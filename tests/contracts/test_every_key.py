"""Nothing is accepted that is then ignored: every number of every term, actuator and control mode changes what it does.

Each part of each vehicle of the catalogue is evaluated in the same motions of both signs, before and after one of its
numbers has moved away from what it is. A key counts as heard if it makes a difference in any vehicle.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from pydantic import BaseModel, ValidationError

import pelagos as pl
from pelagos import jit
from pelagos.errors import InputError
from pelagos.vehicles.actuators.t200 import t200_tables
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow, Supply
from pelagos.vehicles.load import catalogue_names
from pelagos.vehicles.wetness import Wetness

DEAF = {
    "actuators.ship_engine.service_hz": "trials and missions order it; the engine itself turns as it is told",
    "terms.hydrostatic.center_of_flotation_m.2": "heave, roll and pitch act through x and y of that point alone",
}
"""Keys that no motion below hears, and why."""
SKIPPED: dict[tuple[str, str], str] = {}
"""Parts that cannot be evaluated alone, and why."""
STATES = 12


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
    )  # fmt: skip


def numbers(config: BaseModel) -> Iterator[tuple[str, Any]]:
    """Each number or row of numbers of a part, with another in its place."""
    for key, value in config.model_dump().items():
        if isinstance(value, bool) or value is None or isinstance(value, str):
            continue
        if isinstance(value, (int, float)):
            if "limit" in key:
                yield key, 0.1 * value
            yield key, value * 1.17 + (0.05 if value == 0 else 0.0) if isinstance(value, float) else value + 1
        elif isinstance(value, (list, tuple)) and value and all(isinstance(v, (int, float)) for v in value):
            for k, v in enumerate(value):
                yield f"{key}.{k}", [*value[:k], v * 1.17 + (0.05 if v == 0 else 0.0), *value[k + 1 :]]
                if len(value) > 2 and sorted(value) == list(value):  # a table's axis, which must go on rising
                    yield f"{key}.{k}", [*value[:k], v + 0.01 * abs(v), *value[k + 1 :]]


def changed(config: BaseModel, key: str, value: Any) -> BaseModel | None:
    """The part with another number, None where that is refused."""
    try:
        return type(config).model_validate(config.model_dump() | {key.split(".")[0]: value})
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
    """Force and moment at states of both signs, and where the state goes from there in a step."""
    made = config.build(plant.body)
    rng, found = np.random.default_rng(3), []
    low, high = (float(getattr(made.lag, end, sign)) for end, sign in (("low", -1.0), ("high", 1.0)))
    for _ in range(2):
        state, command = (jit.Float64(rng.uniform(1.3 * low, 1.3 * high, STATES)) for _ in range(2))
        found += made.wrench(made.lag.limited(state), flow)
        kept = [jit.Float64(np.zeros(STATES))] * made.lag.memory
        found += made.lag.after(state, kept, command, jit.Float64(0.05))
        found += made.lag.after(state, kept, state + 0.01 * command, jit.Float64(0.05))
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


def heard(kind: str, config: BaseModel, plant: Plant, flow: Flow, known: Set[str]) -> Iterator[tuple[str, bool]]:
    """Each key of a part that is not `known`, and whether its change is felt; all are evaluated in one kernel."""
    plain, moved = KINDS[kind](config, plant, flow), []
    for key, value in numbers(config):
        now = getattr(config, key, None)
        for tried in (value, 0.95 * now) if isinstance(now, float) and now != 0 else (value,):  # or the other way
            other = None if key in known else changed(config, key, tried)
            try:
                found = None if other is None else KINDS[kind](other, plant, flow)
            except InputError:  # beyond what a published formula holds for
                continue
            if found is not None:
                moved.append((key, found))
                break
    dr.eval(plain, [found for _, found in moved])
    before = [np.array(v) for v in plain]
    for key, found in moved:
        after = [np.array(v) for v in found]
        same = all(
            np.array_equal(*np.broadcast_arrays(a, b), equal_nan=True) for a, b in zip(before, after, strict=True)
        )
        yield key, not same


@pytest.mark.parametrize("kind", ["terms", "actuators", pytest.param("modes", marks=pytest.mark.slow)])
def test_every_number_of_a_part_changes_what_it_does(kind: str) -> None:
    felt: dict[str, dict[str, bool]] = {}
    for name in sorted(catalogue_names()):
        vehicle = pl.Vehicle.from_catalogue(name)
        plant = Plant(vehicle.model, vehicle.config.body)
        flow = flows(max(vehicle.config.length_m**0.5, 1.0) * (8.0 if vehicle.config.medium == "air" else 1.0))
        if vehicle.config.battery is not None:
            tables = t200_tables(vehicle.config.battery.open_circuit_v)
            flow.supply = Supply(jit.Float64(np.linspace(12.3, 16.1, STATES)), tables)
        flow.actuators = {n: jit.Float64(between(a.lag)) for n, a in vehicle.model.actuators.items()}
        for part in getattr(vehicle.config, kind).values():
            if part is not None and (kind, part.type) not in SKIPPED:
                known = felt.setdefault(part.type, {})
                for key, is_felt in heard(kind, part, plant, flow, {k for k, v in known.items() if v}):
                    known[key] = known.get(key, False) or is_felt
    keys = {f"{kind}.{part}.{key}": is_felt for part, known in felt.items() for key, is_felt in known.items()}
    assert len(keys) > 40
    deaf = sorted(at for at, is_felt in keys.items() if not is_felt)
    assert deaf == sorted(at for at in DEAF if at.startswith(kind)), "\n".join(deaf)
