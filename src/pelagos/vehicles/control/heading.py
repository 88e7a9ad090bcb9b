"""Heading by a rudder: integral sliding mode with a third-order reference model.

Source: F21 Chapters 12 (reference models) and 16 (integral sliding mode), as in Fossen's Python Vehicle Simulator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from pelagos.jit import Array
from pelagos.vehicles.control.angle import saturate, smallest_angle
from pelagos.vehicles.control.reference import ReferenceModel
from pelagos.vehicles.part import NonNegative, PartConfig, Positive


class HeadingGains(PartConfig):
    """Gains and limits of the heading loop."""

    nomoto_gain: Positive
    """K of the Nomoto model, yaw rate by deflection [1/s]."""
    nomoto_time_s: Positive
    """T of the Nomoto model [s]."""
    bandwidth: Positive
    """lambda: how fast the error decays on the sliding surface [rad/s]."""
    boundary: Positive
    """phi_b: thickness of the boundary layer [rad/s]."""
    k_damping: NonNegative
    """K_d [-]."""
    k_switch: NonNegative
    """K_sigma [rad/s]."""
    reference_rad_s: Positive
    """Natural frequency of the reference model [rad/s]."""
    reference_damping: Positive
    """Damping ratio of the reference model [-]."""
    rate_limit_deg_s: Positive
    """Largest yaw rate of the reference [deg/s]."""
    short_way: bool = True
    """The reference turns the short way round, and headings wrap; otherwise angles count on."""
    rudder_limit_deg: Positive | None = None
    """The integrator stands still while more than this is asked of the rudder [deg]; None: it never does."""


@dataclass(frozen=True)
class HeadingMemory:
    """Integral of the heading error [rad s]; heading [rad], rate [rad/s], acceleration [rad/s^2] of the reference."""

    integral: Array
    heading: Array
    rate: Array
    acceleration: Array


def rudder(
    gains: HeadingGains, memory: HeadingMemory, setpoint: Array, heading: Array, r: Array, h: Array
) -> tuple[Array, HeadingMemory]:
    """Deflection [rad] that brings the vehicle to a compass heading [rad]; r: yaw rate [rad/s]; h: step [s]."""
    k = gains.bandwidth
    error = smallest_angle(heading - memory.heading)
    rate_error = r - memory.rate
    virtual = memory.rate - 2 * k * error - k * k * memory.integral
    virtual_rate = memory.acceleration - 2 * k * rate_error - k * k * error
    surface = rate_error + 2 * k * error + k * k * memory.integral
    deflection = (
        gains.nomoto_time_s * virtual_rate
        + virtual
        - gains.k_damping * surface
        - gains.k_switch * saturate(surface / gains.boundary)
    ) / gains.nomoto_gain
    step = h * error
    if gains.rudder_limit_deg is not None:
        free = dr.abs(deflection) < math.radians(gains.rudder_limit_deg)
        step = dr.select(free | (deflection * error > 0), step, 0.0)
    reference = ReferenceModel(
        gains.reference_rad_s, gains.reference_damping, math.radians(gains.rate_limit_deg_s), gains.short_way
    )
    x, v, a = reference.step(memory.heading, memory.rate, memory.acceleration, setpoint, h)
    return deflection, HeadingMemory(memory.integral + step, x, v, a)
