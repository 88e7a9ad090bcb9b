"""Standard manoeuvres of a vehicle, their numbers, and the limits that ships must keep."""

from __future__ import annotations

from pelagos.manoeuvres.measures import Measure, turning_measures, zigzag_measures
from pelagos.manoeuvres.standard import MANOEUVRES, run_manoeuvre
from pelagos.manoeuvres.trial import Track, Trial

__all__ = ["MANOEUVRES", "Measure", "Track", "Trial", "run_manoeuvre", "turning_measures", "zigzag_measures"]
