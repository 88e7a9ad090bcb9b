"""Copies of a vehicle with factors on its numbers: what each factor is on, in calm water and in waves."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos import jit
from pelagos.errors import LookupFailed
from pelagos.vehicles.flow import Flow, Seaway, make_flow, rotation_from_euler
from pelagos.vehicles.varied import Scaled, check_names, varied
from pelagos.vehicles.vehicle import Vehicle
from pelagos.vehicles.wetness import Wetness

HEAVIER, MORE = np.array([1.3, 0.9]), np.array([1.2, 1.7])


def numbers(values: Any) -> np.ndarray:
    return np.stack([np.broadcast_to(np.array(v, dtype=np.float64), 2) for v in values], axis=-1)


def flow(roll: float = 0.2, pitch: float = -0.3) -> Flow:
    turned = rotation_from_euler(*(jit.Float64(a) for a in (roll, pitch, 0.7)))
    return make_flow([jit.Float64(x) for x in (3.0, -2.0, 0.1)], turned, [jit.Float64(0.0)] * 6, [jit.Float64(0.0)] * 3)


@pytest.fixture(scope="module")
def otter() -> Vehicle:
    return Vehicle.from_catalogue("otter")


@pytest.mark.parametrize("waves", [False, True])
def test_a_hull_that_floats_has_other_masses_in_calm_water_and_in_waves(otter: Vehicle, waves: bool) -> None:
    """(f M_RB + a M_A)^-1 F, M_A at infinite frequency in waves, of two copies."""
    vehicle = otter
    copies = varied(vehicle, {"mass": jit.Float64(HEAVIER), "added_mass": jit.Float64(MORE)})
    assert vehicle.model.sea is not None
    at = replace(flow(), seaway=Seaway([0.0] * 6, [0.0] * 6)) if waves else flow()
    body, push = vehicle.config.body, np.array([30.0, -20.0, 50.0, 4.0, -9.0, 7.0])
    added = np.array(vehicle.model.sea.added) if waves else body.added
    found = numbers(copies.model.inertia_in(at).accelerate([jit.Float64(p) for p in push]))
    for k in range(2):
        assert found[k] == pytest.approx(np.linalg.solve(HEAVIER[k] * body.rigid + MORE[k] * added, push), rel=1e-9)
    sea = np.stack([numbers(row) for row in copies.model.sea.added], axis=1)
    assert sea == pytest.approx(MORE[:, None, None] * np.array(vehicle.model.sea.added), rel=1e-12)


def test_a_heavier_hull_sinks_deeper_and_heels_by_where_its_weight_is(otter: Vehicle) -> None:
    """(f - 1) W down at the centre of gravity, whatever the surface does; what balances the weight stays."""
    vehicle = otter
    copies = varied(vehicle, {"mass": jit.Float64(HEAVIER)})
    body, at = vehicle.config.body, flow()
    down = numbers(at.down)[0]
    for f, part in zip(HEAVIER, numbers(copies.model.terms["surplus weight"].wrench(at)), strict=True):
        force = (f - 1) * body.weight * down
        assert part == pytest.approx(np.concatenate([force, np.cross(body.center_of_gravity, force)]), rel=1e-12)
    for name, term in vehicle.model.terms.items():
        assert copies.model.terms[name] is term
    kept = copies.model.left(copies.model.terms["surplus weight"], [1.0] * 6, at)
    assert kept == [1.0] * 6  # out of the water too
    assert set(varied(vehicle, {"thrust": 1.2}).model.terms) == set(vehicle.model.terms)


def test_a_submerged_copy_weighs_more_and_pushes_and_follows_otherwise() -> None:
    vehicle = Vehicle.from_catalogue("remus100")
    keys = {"mass": 1.3, "lag": 2.5, "damping": 0.7}
    made = varied(vehicle, {k: v for k, v in keys.items() if k in ("mass", "lag")}).model
    for name, part in vehicle.model.actuators.items():
        assert made.actuators[name].lag.time_constant == pytest.approx(2.5 * part.lag.time_constant)
    weights = {n: t.weight for n, t in vehicle.model.terms.items() if hasattr(t, "weight")}
    assert weights
    for name, weight in weights.items():
        assert made.terms[name].weight == pytest.approx(1.3 * weight)
        assert made.terms[name].buoyancy == vehicle.model.terms[name].buoyancy
    assert "surplus weight" not in made.terms
    rov = Vehicle.from_catalogue("hovering_auv")
    strong = varied(rov, {"thrust": 1.4}).model
    for name, part in rov.model.actuators.items():
        assert np.array(strong.actuators[name].effect) == pytest.approx(1.4 * np.array(part.effect))
        assert strong.actuators[name].lag == part.lag
    scaled = next(n for n, t in vehicle.model.terms.items() if not hasattr(t, "weight"))
    at = replace(flow(), nu_r=[jit.Float64(v) for v in (1.1, -0.2, 0.3, 0.1, -0.2, 0.15)])
    one = numbers(vehicle.model.terms[scaled].wrench(at))
    assert numbers(varied(vehicle, {scaled: 0.7}).model.terms[scaled].wrench(at)) == pytest.approx(0.7 * one, rel=1e-12)


@pytest.mark.parametrize(("name", "term"), [("quadrotor", "drag"), ("remus100", "weight"), ("hovering_auv", "")])
def test_what_is_left_of_a_term_is_left_of_it_times_a_factor(name: str, term: str) -> None:
    """In the air the drag of what flies, in the water that of the wet part, of restoring forces all."""
    vehicle = Vehicle.from_catalogue(name)
    chosen = term if term in vehicle.model.terms else list(vehicle.model.terms)[-1]
    model, made = vehicle.model, varied(vehicle, {chosen: 0.7}).model
    at = replace(flow(), wet=Wetness(jit.Float64(0.25), jit.Float64(0.0)))
    load = [jit.Float64(v) for v in (1.0, -2.0, 3.0, -4.0, 5.0, 6.0)]
    plain = numbers(model.left(model.terms[chosen], load, at))
    assert numbers(made.left(made.terms[chosen], load, at)) == pytest.approx(plain)


def test_a_term_on_the_host_stays_there_and_images_are_refused() -> None:
    """A wall's added mass is no wrench that a factor could be on."""
    ship = {"type": "kvlcc2", "terms": {"wall": {"type": "bank", "draught_m": 20.8}}}
    with pytest.raises(LookupFailed, match="unknown parameter of the vehicle 'wall'"):
        check_names(Vehicle.from_dict(ship), ["wall"], "here")
    check_names(Vehicle.from_dict(ship), ["mass"], "here")
    assert Scaled(SimpleNamespace(on_host=True), 2.0).on_host
    assert not Scaled(SimpleNamespace(), 2.0).on_host
