"""Feed-forward of drag and of the current: the wrench that keeps a body at a velocity through water that moves.

Source: F21 Section 15.3 (reference feed-forward of a model-based controller); the terms are those of the vehicle's own
equation of motion, so that body lift, Munk's moment and buoyancy are part of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Vector, add, matvec, minus, scaled, transpose
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.model import Model

CURRENT_TIME_S: Final = 5.0
"""Time constant of the low-pass filter of the current that control laws know [s]: waves pass, a current does not."""


def current_of(flow: Flow) -> list[Array]:
    """Velocity of the water at the vehicle, NED (3) [m/s]."""
    return matvec(flow.rotation, add(flow.nu[:3], minus(flow.nu_r[:3])))


def filtered_current(memory: Sequence[Array], flow: Flow, h: Array) -> list[Array]:
    """The slow part of the water's velocity, NED (3) [m/s], after one step of h [s]."""
    share = 1 - dr.exp(-h / CURRENT_TIME_S)
    return add(memory, scaled(share, add(current_of(flow), minus(memory))))


def holding_wrench(model: Model, flow: Flow, nu: Vector, current: Vector) -> list[Array]:
    """Wrench (6) that actuators must add, FRD [N], [N m], for no acceleration at velocity `nu` (6).

    Forces are those at the wanted velocity: at the actual one they would undo drag faster than thrusters follow.
    Moments are those at the actual way through the water, which is another where the thrust does not suffice: what a
    current would do to a vehicle that holds must not tilt one that is carried along.

    Args:
        model: the vehicle's equation of motion.
        flow: where it is, and how it lies.
        nu: wanted velocity over ground, body axes [m/s], [rad/s].
        current: velocity of the water, NED (3) [m/s].
    """
    wanted = _balance(model, flow, nu, current)
    actual = _balance(model, flow, [*flow.nu[:3], *nu[3:]], current)
    return [*wanted[:3], *actual[3:]]


def _balance(model: Model, flow: Flow, nu: Vector, current: Vector) -> list[Array]:
    water = matvec(transpose(flow.rotation), current)
    nu_r = [*add(nu[:3], minus(water)), *nu[3:]]
    there = replace(flow, nu=list(nu), nu_r=nu_r, seaway=None, midway=None)  # no step of the integrator's is foreseen
    none = [0 * v for v in flow.nu]
    wrenches = [term.wrench(there) for term in model.terms.values()]
    return minus(add(none, model.inertia.coriolis(there), *wrenches))
