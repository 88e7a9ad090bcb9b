"""Gradients through 200 steps equal central differences to 1e-5."""

from __future__ import annotations

from dataclasses import replace

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.vehicles.flow import make_flow, rotation_from_euler
from pelagos.vehicles.gradient import pull_back, rollout
from pelagos.vehicles.state import VehicleState
from pelagos.vehicles.vehicle import Vehicle

STEPS = 200
H = 0.02


def flat_step(vehicle, x, command, mode):
    k = len(vehicle.actuator_names)
    zero = jit.Array3f64(0.0)
    state = VehicleState(
        position=jit.Array3f64(*x[0:3]),
        attitude=jit.Array4f64(*x[3:7]),
        velocity=jit.Array3f64(*x[7:10]),
        angular_velocity=jit.Array3f64(*x[10:13]),
        acceleration=zero,
        angular_acceleration=zero,
        actuators=list(x[13 : 13 + k]),
        actuator_memory=[],
        radiation=[],
        mode=jit.Float64(0.0),
        controller=[jit.Float64(0.0)] * 20,
    )
    new = vehicle.step(state, command, None, jit.Float64(0.0), (zero, zero), H, mode)
    return [*new.position, *new.attitude, *new.velocity, *new.angular_velocity, *new.actuators]


def remus_step(state, parameters, inputs):
    remus = Vehicle.from_catalogue("remus100")
    lift = remus.model.terms["lift_drag"]
    polar = replace(lift.polar, parasitic=parameters[0], slope=parameters[1])
    model = replace(remus.model, terms={**remus.model.terms, "lift_drag": replace(lift, polar=polar)})
    return flat_step(remus.with_model(model), state, inputs, "actuators")


@pytest.mark.parametrize("axis", [0, 2])
def test_torpedo_position_by_parameters_and_commands(axis):
    remus = Vehicle.from_catalogue("remus100")
    polar = remus.model.terms["lift_drag"].polar
    parameters = [polar.parasitic, polar.slope]
    start = [0, 0, 50.0, 1, 0, 0, 0, 1.5, 0.02, 0.03, 0, 0, 0, 0, 0, 1000.0]
    command = [0.05, -0.04, 1300.0]

    def end(parameters, command):
        given = [[jit.Float64(c) for c in command] for _ in range(STEPS)]
        states = rollout(remus_step, start, [jit.Float64(p) for p in parameters], given)
        return states, given

    states, given = end(parameters, command)
    seed = [jit.Float64(1.0 if i == axis else 0.0) for i in range(len(states[-1]))]
    adjoint = [None] * STEPS + [seed]
    _, by_parameter, by_input = pull_back(remus_step, states, [jit.Float64(p) for p in parameters], given, adjoint)
    by_command = [sum(float(g[i][0]) for g in by_input) for i in range(3)]
    got = [float(g[0]) for g in by_parameter] + by_command[:2]

    values = [*parameters, *command]
    for i, gradient in enumerate(got):
        step = 1e-5 * max(abs(values[i]), 0.1)
        ends = []
        for sign in (1, -1):
            moved = list(values)
            moved[i] += sign * step
            ends.append(float(end(moved[:2], moved[2:])[0][-1][axis][0]))
        difference = (ends[0] - ends[1]) / (2 * step)
        assert gradient == pytest.approx(difference, rel=1e-5, abs=1e-7)


def test_gradients_by_mass_matrix_go_through_the_solver():
    """With entries that are arrays the mass matrix is solved for, and equals the inverse made on the host."""
    remus = Vehicle.from_catalogue("remus100")
    inertia = remus.model.inertia
    arrays = [[jit.Float64(x) if x else 0.0 for x in row] for row in inertia.rigid]
    wrench = [jit.Float64(float(i + 1)) for i in range(6)]
    solved = replace(inertia, rigid=arrays, inverse=None).accelerate(wrench)
    inverted = inertia.accelerate(wrench)
    for a, b in zip(solved, inverted, strict=True):
        assert float(jit.Float64(a)[0]) == pytest.approx(float(jit.Float64(b)[0]), rel=1e-12)
    assert np.isfinite(float(solved[0][0]))


@pytest.mark.parametrize(
    ("name", "term"), [("glider", "glide"), ("remus100", "lift_drag"), ("torpedo", "lift_drag"), ("fixed_wing", "wing")]
)
def test_slopes_of_lift_at_rest_are_numbers(name, term):
    """Runs begin at rest, where the angle of attack has no slope; forces go with the speed squared, or the speed times
    a rate, and so have none either."""
    nu = [jit.Float64(0.0) for _ in range(6)]
    dr.enable_grad(nu)
    for k, speed in enumerate(nu):
        dr.set_grad(speed, (-1.0) ** k * (1 + k))
    still = make_flow([0.0, 0.0, 30.0], rotation_from_euler(0.0, 0.0, 0.0), nu, [0.0] * 3)
    wrench = [x for x in Vehicle.from_catalogue(name).model.terms[term].wrench(still) if isinstance(x, jit.Float64)]
    dr.enqueue(dr.ADMode.Forward, nu)
    dr.traverse(dr.ADMode.Forward)
    assert [dr.grad(x)[0] for x in wrench] == pytest.approx([0.0] * len(wrench), abs=1e-3)  # at 3e-5 m/s, not at 0
