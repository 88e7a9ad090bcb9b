"""Commands of a record in the units that actuators are commanded in."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from pelagos.errors import InputError, LookupFailed
from pelagos.identification.plan import UNIT_SCALES, UNITS_OF, Plan
from pelagos.identification.record import Record
from pelagos.vehicles.model import Model

_SCALES: Final = {**UNIT_SCALES, "1/s": UNIT_SCALES["Hz"]}
"""Factors to SI units, of an actuator's unit."""


def in_own_units(record: Record, plan: Plan, model: Model) -> Record:
    """The record with each command whose column has a unit in the unit of its actuator, such as rpm, not in SI.

    Raises:
        InputError: the column's unit is of another kind than the actuator's.
        LookupFailed: there are commands of an actuator that the vehicle has not.
    """
    commands = dict(record.commands)
    for name in commands:
        if name not in model.actuators:
            raise LookupFailed("actuator", name, model.actuators, where="plan: commands")
    for name, column in plan.commands.items():
        own = model.actuators[name].unit if name in commands else ""
        if not (column.unit and own):
            continue
        allowed = _units_like(own)
        if column.unit not in allowed:
            cure = (
                f"give {', '.join(allowed)}" if allowed else "leave unit out, and give scale and zero where they differ"
            )
            raise InputError(
                f"plan: commands.{name}: the unit {column.unit} is of another kind than that of its commands, {own}; "
                f"{cure}"
            )
        commands[name] = commands[name] / _SCALES[own]
    return replace(record, commands=commands)


def _units_like(own: str) -> tuple[str, ...]:
    """Units of a plan of the same kind as an actuator's; none where no plan can say it."""
    alike = {**UNITS_OF, "1/s": UNITS_OF["rad/s"], "rpm": UNITS_OF["rad/s"], "N": ("N", "kN")}
    return alike.get(own, ())
