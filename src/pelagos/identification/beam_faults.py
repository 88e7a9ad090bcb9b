"""Faults of a velocity log's record that its four beams show themselves.

Of beams in order around the vertical b1 - b2 + b3 - b4 holds nothing of any velocity. A beam that does not read its
own speed, pings that are no speeds and an offset that comes and goes stand in it far above the noise.
"""

from __future__ import annotations

import warnings
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from pelagos.errors import InputError, PelagosWarning
from pelagos.identification.coordinates import normal_size

Floats = NDArray[np.float64]
AROUND: Final = np.array([1.0, -1.0, 1.0, -1.0])
"""Signs of beams in order around the vertical that leave nothing of a velocity."""
OTHERS: Final = np.array([[1.0, 1.0, 1.0, 1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0]])
"""Signs of the other sums, each with the noise of the first and independent of it."""
STRAY: Final = 10.0
"""Standard deviations from which a reading is no noise: normal noise goes so far once in 1e23."""
_ZEROS: Final = 0.005  # share of pings
_OFTEN: Final = 10  # times as frequent as any other reading
_STILL: Final = 0.02  # share of pings
_FINE: Final = 2.0  # steps of the output in a standard deviation, from which each of its levels is rare
_NEIGHBOURS: Final = 101  # pings of about the same speed, which have about the same noise
_FOLLOWS: Final = 0.5  # share of the squares that goes with the velocity
_ASTRAY: Final = 0.2  # of a beam's speed: more than angles, mounting and sound speed make
_MOVES: Final = 4.0  # times the noise
_NAMED: Final = 0.9  # cosine between what is left and what a fault of one beam leaves
_WANDERS: Final = 0.5  # of the variance that is new in every ping; 1 of white noise
_NOISIEST: Final = 0.5  # m/s: more than single pings of the longest range have


def refuse_constant(table: Floats) -> None:
    """Refuse beams `(n, 4)` that never change."""
    if np.nanmax(np.ptp(table, axis=0), initial=0.0) == 0:
        return  # all of them: what is left says so
    for k, beam in enumerate(table.T):
        known = beam[np.isfinite(beam)]
        if len(known) > 1 and np.ptp(known) == 0:
            raise InputError(f"beam {k + 1} reads {known[0] + 0.0:g} in every ping: it measures nothing")


def refuse_zeros(whole: Floats, left: Floats) -> None:
    """Refuse beams `(n, 4)` that write 0 where they are lost: by the other three, or as 0 is far too frequent."""
    middle = left - np.median(left)
    noise = max(normal_size(middle), _least(np.abs(middle)))
    for k, beam in enumerate(whole.T):
        stray = (beam == 0) & (np.abs(left) > STRAY * noise)
        if stray.mean() > _ZEROS:
            raise InputError(
                f"beam {k + 1} reads exactly 0 in {int(stray.sum())} pings in which the other three say otherwise, "
                f"the first in row {int(np.argmax(stray)) + 1} of those with four beams: leave lost cells empty"
            )
        levels, counts = np.unique(beam, return_counts=True)
        zeros, usual = int((beam == 0).sum()), int(counts[levels != 0].max(initial=0))
        fine = 0.5 * noise > _FINE * _step_of(levels)  # otherwise what rests may well read 0
        if fine and zeros > max(_STILL * len(beam), _OFTEN * usual):
            raise InputError(
                f"beam {k + 1} reads exactly 0 in {zeros} pings, and every other number in {usual} at most: leave lost "
                "cells empty"
            )


def standing_out(whole: Floats, left: Floats) -> NDArray[np.bool_]:
    """Pings `(n,)` that are far off those of about the same speed, whose noise is about the same.

    The speed is that of the second fastest beam: a fault of one beam does not change it.
    """
    order = np.argsort(np.sort(np.abs(whole), axis=1)[:, 2], kind="stable")
    off = np.abs(left - np.median(left))
    usual = 1.4826 * median_filter(off[order], size=min(_NEIGHBOURS, len(off)), mode="mirror")
    found = np.zeros(len(off), dtype=bool)
    found[order] = off[order] > STRAY * np.maximum(usual, _least(off))
    return found


def refuse_contradicted(whole: Floats, left: Floats) -> bool:
    """Refuse a beam of another sign, unit or meaning than the other three; warn of one that is off by less.

    A beam that reads f times its speed v leaves (f - 1) v, and changes the other sums by (f - 1) v too.

    Returns:
        whether it warned.
    """
    others = whole @ OTHERS.T
    share = np.linalg.lstsq(others, left, rcond=None)[0]
    follows = others @ share
    if float((follows**2).sum()) < _FOLLOWS * float((left**2).sum()):
        return False
    moves = _MOVES * 0.5 * float((np.diff(left) ** 2).mean())  # of what is left or of another sum
    named = share @ OTHERS / np.sqrt(3) / np.linalg.norm(share)  # (4,): cosines to what a fault of each beam leaves
    k = int(np.argmax(np.abs(named)))
    by_three = whole[:, k] - AROUND[k] * left  # the speed along it, as the other three beams have it
    if float((by_three**2).mean()) < 0.75 * moves:
        return False  # at rest: an offset of this beam
    off = float(np.sqrt((follows**2).mean() / (whole**2).mean()))
    text = f"b1 - b2 + b3 - b4 goes with the velocity, with {off:.2g} of a beam's"
    every_way = float(np.linalg.eigvalsh(others.T @ others / len(others))[0]) > moves
    if every_way and abs(named[k]) > _NAMED:
        part = float(AROUND[k] * (share @ OTHERS[:, k])) * 4 / 3
        text = f"beam {k + 1} reads {1 + part / (1 - 0.75 * part):.3g} times what the other three say"
    if off > _ASTRAY:
        raise InputError(f"{text}: another sign, unit or order, or not a beam?")
    warnings.warn(f"{text}: angles or scales? The noise has it too", PelagosWarning, stacklevel=3)
    return True


def warn_of_wandering(left: Floats) -> None:
    """Warn of an offset that changes slower than from ping to ping."""
    new = 0.5 * float((np.diff(left) ** 2).mean()) / float(left.var())
    if new < _WANDERS:
        text = (
            f"only {new:.2g} of the variance of b1 - b2 + b3 - b4 is new in every ping: a beam has an offset or scale "
            "that changes, which the noise holds too"
        )
        warnings.warn(text, PelagosWarning, stacklevel=3)


def warn_of_noise(noise_mps: float) -> None:
    """Warn of a noise that no log has."""
    if noise_mps > _NOISIEST:
        text = f"noise of {noise_mps:.3g} m/s a ping is more than any log has; in mm/s? Give m/s"
        warnings.warn(text, PelagosWarning, stacklevel=3)


def _least(off: Floats) -> float:
    """Least size but 0: the step of a coarse output, in which most may be equal; next to nothing of a fine one."""
    return float(off[off > 1e-6 * off.max()].min())


def _step_of(levels: Floats) -> float:
    """Step of the output, of which all `levels` are multiples; 0 where there is none."""
    if len(levels) < 2:
        return 0.0
    step = float(np.diff(levels).min())
    multiples = levels / step
    return step if np.abs(multiples - np.round(multiples)).max() < 0.05 else 0.0
