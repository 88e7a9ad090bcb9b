"""Vehicles and noise from measurements: parameters by gradients through the simulated motion."""

from __future__ import annotations

from pelagos.identification.fit import Fit, fit
from pelagos.identification.plan import Plan, load_plan
from pelagos.identification.record import Record, read_record

__all__ = ["Fit", "Plan", "Record", "fit", "load_plan", "read_record"]
