"""Meaning of a survey's values: their unit, their sign, and which of them only say that there is none."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError
from pelagos.math.units import LENGTHS
from pelagos.world.bathymetry.survey import Grid, Soundings

Survey: TypeAlias = Grid | Soundings
Unit: TypeAlias = Literal["auto", "m", "cm", "km", "ft", "us_ft", "fathom"]

METRES: Final[dict[str, float]] = {**{unit: LENGTHS[unit] for unit in ("m", "cm", "km", "ft", "fathom")},
                                   "us_ft": 1200 / 3937}  # fmt: skip
"""Metres in a unit of heights. International foot and fathom; US survey foot as defined in 1893."""
_NAMES: Final[dict[str, tuple[str, ...]]] = {
    "m": ("m", "metre", "meter", "metres", "meters", "mt"),
    "cm": ("cm", "centimetre", "centimeter", "centimetres", "centimeters"),
    "km": ("km", "kilometre", "kilometer", "kilometres", "kilometers"),
    "ft": ("ft", "foot", "feet", "international foot", "international feet"),
    "us_ft": ("us_ft", "us ft", "us-ft", "ftus", "sft", "us survey foot", "us survey feet", "u.s. survey foot",
              "survey foot", "survey feet", "foot_us", "us foot", "us feet"),
    "fathom": ("fathom", "fathoms", "fm", "fth"),
}  # fmt: skip
_HIGHEST_M: Final = 12_000.0  # no ground on Earth is higher or deeper
_MARKS: Final = (-9999.0, 9999.0)  # that stand for "no value" in files that forget to say so
_ALONE: Final = 500.0  # how far from any other value such a mark is, in the file's unit


def known_unit(text: str) -> str | None:
    """The unit of heights that a file calls `text`; None where it is none."""
    plain = " ".join(text.strip().lower().replace("_", " ").split())
    found = (unit for unit, names in _NAMES.items() if plain in names or plain.replace(" ", "_") in names)
    return next(found, None)


def in_metres(path: str, survey: Survey, asked: str) -> Survey:
    """The survey with its values in metres, and NaN (or no sounding) where a value only says that there is none.

    Args:
        path: for messages.
        survey: as read.
        asked: the scenario's word on the unit, or "auto" for the file's.

    Raises:
        WorldError: most values cannot be heights on Earth.
    """
    unit, notes = asked, list(survey.notes)
    if asked == "auto":
        found = known_unit(survey.unit)
        unit = found or "m"
        if survey.unit and found is None and survey.unit not in ("1", "unknown"):
            notes.append(f"the unit {survey.unit!r} of the values is not known; they were taken as metres")
    factor = METRES[unit]
    if unit != "m":
        notes.append(f"values in {unit} were turned into metres, {factor:.7g} m each")
    values = factor * survey.z
    missing = _marks(survey.z) | (np.abs(values) > _HIGHEST_M)
    known = np.isfinite(survey.z)
    count = int((missing & known).sum())
    if count > 0.5 * known.sum():
        odd = float(np.nanmedian(survey.z))
        raise WorldError(
            f"bathymetry file {path}: most values of {survey.name!r} (median {odd:g} {unit}) cannot be heights on "
            "Earth; say their unit (unit: cm), or which array is meant (variable: NAME)"
        )
    if count:
        example = float(survey.z[missing & known][0])
        notes.append(f"{count} values such as {example:g} cannot be heights and were taken as missing")
    values = np.where(missing, np.nan, values)
    if isinstance(survey, Grid):
        return replace(survey, z=values, notes=tuple(notes))
    keep = np.isfinite(values)
    return replace(survey, u=survey.u[keep], v=survey.v[keep], z=values[keep], notes=tuple(notes))


def _marks(z: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Values that stand for "no value": a usual mark, far from every other value."""
    found = np.zeros(z.shape, dtype=bool)
    for mark in _MARKS:
        here = z == mark
        if here.any():
            others = z[np.isfinite(z) & ~here]
            if not (np.abs(others - mark) < _ALONE).any():
                found |= here
    return found


def upwards(survey: Survey, asked: str, offset: float) -> tuple[Survey, str]:
    """The survey with z upwards from the mean sea surface, and how its sign was decided.

    Args:
        survey: in metres.
        asked: "up", "down", or "auto": the file's own word, else depths where it calls positive values so.
        offset: added to every height [m].
    """
    if asked != "auto":
        down, why = asked == "down", "as the scenario says"
    elif survey.positive_down is not None:
        down, why = survey.positive_down, "as the file says"
    else:
        name, words = survey.name.lower(), survey.words.lower()
        named = "depth" in name or name in ("deptho", "h") or "depth" in words
        down = named and float(np.nanmedian(survey.z)) > 0
        why = f"as the values of {survey.name!r} look (median {np.nanmedian(survey.z):.2f})"
    z = (-survey.z if down else survey.z) + offset
    return replace(survey, z=z), f"{'depths, down' if down else 'heights, up'}: {why}"
