"""Depth by a stern plane: PI from depth to pitch, PID on pitch.

Source: F21 Chapter 15 (successive loop closure) as in Fossen's Python Vehicle Simulator, with limits that it has not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from pelagos.jit import Array
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.part import NonNegative, Number, PartConfig, Positive


class DepthGains(PartConfig):
    """Gains and limits of the depth loop."""

    reference_rad_s: Positive
    """Cut-off of the low-pass filter of the depth set-point [rad/s]."""
    kp_depth: NonNegative
    """Pitch by depth error [rad/m]."""
    integral_s: Positive
    """Integral time of the depth loop [s]."""
    kp_pitch: NonNegative
    """Deflection by pitch error [-]."""
    kd_pitch: NonNegative
    """Deflection by pitch rate [s]."""
    ki_pitch: NonNegative
    """Deflection by the integral of the pitch error [1/s]."""
    k_heave: Number
    """Deflection by heave velocity [rad s/m]."""
    pitch_limit_deg: Positive | None = None
    """Largest pitch that is asked for [deg]; None: no limit."""
    dive_beyond_m: Positive | None = None
    """Distance from the set-point beyond which the largest pitch is asked for [m]; None: no such distance."""
    plane_limit_deg: Positive | None = None
    """Integrators stand still while more than this is asked of the plane [deg]; None: they never do."""


@dataclass(frozen=True)
class DepthMemory:
    """Filtered set-point [m], integrals of the depth error [m s] and of the pitch error [rad s]."""

    reference: Array
    depth_integral: Array
    pitch_integral: Array


def stern_plane(
    gains: DepthGains, memory: DepthMemory, setpoint: Array, depth: Array, pitch: Array, w: Array, q: Array, h: Array
) -> tuple[Array, DepthMemory]:
    """Deflection [rad] that brings the vehicle to a depth [m], nose up by positive pitch [rad].

    Args:
        gains: numbers.
        memory: from the step before.
        setpoint, depth: positive down [m].
        pitch: [rad].
        w, q: heave velocity [m/s], pitch rate [rad/s].
        h: step [s].
    """
    keep = dr.exp(-gains.reference_rad_s * h) if not isinstance(h, float) else math.exp(-gains.reference_rad_s * h)
    reference = keep * memory.reference + (1 - keep) * setpoint
    error = depth - reference
    asked = gains.kp_depth * (error + memory.depth_integral / gains.integral_s)
    pitch_wanted = asked
    if gains.pitch_limit_deg is not None:
        limit = math.radians(gains.pitch_limit_deg)
        pitch_wanted = dr.clip(asked, -limit, limit)
        if gains.dive_beyond_m is not None:
            left = depth - setpoint
            pitch_wanted = dr.select(dr.abs(left) > gains.dive_beyond_m, dr.copysign(limit, left), pitch_wanted)
    pitch_error = smallest_angle(pitch - pitch_wanted)
    inner = (
        -gains.kp_pitch * pitch_error - gains.kd_pitch * q - gains.ki_pitch * memory.pitch_integral - gains.k_heave * w
    )
    depth_step, pitch_step = h * error, h * pitch_error
    if gains.plane_limit_deg is not None:
        free = dr.abs(inner) < math.radians(gains.plane_limit_deg)
        pitch_step = dr.select(free | (inner * pitch_error > 0), pitch_step, 0.0)
        depth_step = dr.select(free & (asked == pitch_wanted), depth_step, 0.0)
    return -inner, DepthMemory(reference, memory.depth_integral + depth_step, memory.pitch_integral + pitch_step)
