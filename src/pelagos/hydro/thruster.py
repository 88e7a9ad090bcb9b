"""Propellers and thrusters: thrust and torque along the shaft."""

from __future__ import annotations

import drjit as dr

from pelagos.jit import Array


def open_water(
    density: float, diameter: float, at_rest: float, at_limit: float, limit: float, *, torque: bool
) -> tuple[float, float]:
    """(a, b) of `thrust` or of the torque for coefficients that are linear in the advance number.

    KT (KQ) is `at_rest` at J = 0 and `at_limit` at J = `limit`. Source: B. Allen, W. S. Vorus, T. Prestero,
    "Propulsion system performance enhancements on REMUS AUVs", OCEANS 2000, doi 10.1109/OCEANS.2000.882209.
    """
    power = 5 if torque else 4
    return density * diameter**power * at_rest, density * diameter ** (power - 1) * (at_limit - at_rest) / limit


def open_water_load(coefficients: tuple[Array, Array], revolutions: Array, advance_speed: Array) -> Array:
    """a |n| n + b Va |n| for n > 0, a |n| n for n <= 0: thrust [N] or torque [N m]. F21 Chapter 9.

    Args:
        coefficients: from `open_water`.
        revolutions: n [1/s].
        advance_speed: Va [m/s].
    """
    a, b = coefficients
    size = dr.abs(revolutions)
    return size * (a * revolutions + dr.select(revolutions > 0, b * advance_speed, 0.0))


def quadratic_thrust(forward: Array, reverse: Array, speed: Array) -> Array:
    """k |n| n [N] with one k ahead and one astern [N s^2], speed in the unit of k; F21 Chapter 9."""
    square = speed * dr.abs(speed)  # inside `select`: of two numbers it would be single precision
    return dr.select(speed > 0, forward * square, reverse * square)
