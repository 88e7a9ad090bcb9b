"""The numbers of a manoeuvre, from its track. Source: IMO, "Standards for ship manoeuvrability", MSC.137(76), 2002."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from pelagos.errors import InputError

Floats = NDArray[np.float64]
ADVANCE: Final = 4.5
"""Largest advance in lengths (MSC.137(76), 5.3.1)."""
TACTICAL: Final = 5.0
"""Largest tactical diameter in lengths (MSC.137(76), 5.3.1)."""
INITIAL: Final = 2.5
"""Most lengths run until 10 deg of heading, with 10 deg of rudder (MSC.137(76), 5.3.2)."""
OVERSHOOT_20: Final = 25.0
"""Largest first overshoot of a 20/20 zig-zag [deg] (MSC.137(76), 5.3.3.3)."""
FULL_HELM: Final = 35.0
"""Helm of the turning test [deg], to which its limits belong (MSC.137(76), 5.1.2)."""
STOPPING: Final = 15.0
"""Longest track in lengths of a full astern stop (MSC.137(76), 5.3.4); 20 for ships of large displacement."""


@dataclass(frozen=True)
class Measure:
    """One number: name, value, unit, and the limit that it must not exceed (None: none)."""

    name: str
    value: float
    unit: str
    limit: float | None = None

    @property
    def kept(self) -> bool | None:
        """Whether the limit is kept; None without one."""
        return None if self.limit is None else self.value <= self.limit


def first_overshoot_limit(lengths_time_s: float) -> float:
    """Of a 10/10 zig-zag [deg], by length over speed [s] (MSC.137(76), 5.3.3.1)."""
    return float(np.clip(5 + 0.5 * lengths_time_s, 10.0, 20.0))


def second_overshoot_limit(lengths_time_s: float) -> float:
    """Of a 10/10 zig-zag [deg], by length over speed [s] (MSC.137(76), 5.3.3.2)."""
    return float(np.clip(17.5 + 0.75 * lengths_time_s, 25.0, 40.0))


def _when(time: Floats, values: Floats, level: float) -> float:
    """First time at which rising `values` reach a level, by straight lines."""
    beyond = np.flatnonzero(values >= level)
    if not len(beyond):
        raise InputError(
            f"the heading reaches {values.max():.3g} deg of the {level:g} deg that this number needs: run it longer"
        )
    k = int(beyond[0])
    if k == 0:
        return float(time[0])
    share = (level - values[k - 1]) / (values[k] - values[k - 1])
    return float(time[k - 1] + share * (time[k] - time[k - 1]))


def turning_measures(
    time: Floats, north: Floats, east: Floats, heading_deg: Floats, *, ordered_s: float, length_m: float,
    limited: bool = True,
) -> list[Measure]:  # fmt: skip
    """Of a turning circle, from the moment at which the helm was ordered.

    Args:
        time: `(n,)` [s]; north, east: of the ship's middle `(n,)` [m]; heading_deg: unwrapped `(n,)`.
        ordered_s: when; length_m: of the ship; limited: whether the limits hold, which are those of full helm.

    Raises:
        InputError: the ship did not turn far enough.
    """
    x0, y0, psi0 = (float(np.interp(ordered_s, time, v)) for v in (north, east, heading_deg))
    side = 1.0 if heading_deg[-1] > psi0 else -1.0
    turned = side * (heading_deg - psi0)
    c, s = np.cos(np.radians(psi0)), np.sin(np.radians(psi0))
    along, across = (north - x0) * c + (east - y0) * s, side * (-(north - x0) * s + (east - y0) * c)
    after = time >= ordered_s
    at = {a: _when(time[after], turned[after], a) for a in (90.0, 180.0, 360.0) if a < 360 or turned[-1] >= 360}
    found = [
        Measure("advance", float(np.interp(at[90.0], time, along)) / length_m, "L", ADVANCE if limited else None),
        Measure("transfer", float(np.interp(at[90.0], time, across)) / length_m, "L"),
        Measure(
            "tactical diameter",
            float(np.interp(at[180.0], time, across)) / length_m,
            "L",
            TACTICAL if limited else None,
        ),
        Measure("time to 90 deg", at[90.0] - ordered_s, "s"),
        Measure("time to 180 deg", at[180.0] - ordered_s, "s"),
    ]
    speed = np.hypot(np.gradient(north, time), np.gradient(east, time))
    if 360.0 in at:
        last = time > time[-1] - 0.2 * (time[-1] - at[180.0])
        rate = np.polyfit(time[last], np.radians(turned[last]), 1)[0]
        steady = float(speed[last].mean())
        found += [
            Measure("steady diameter", 2 * steady / float(rate) / length_m, "L"),
            Measure("speed in the turn / before", steady / float(np.interp(ordered_s, time, speed)), ""),
        ]
    return found


def overshoots(time: Floats, heading_deg: Floats, switched_s: Floats, angle_deg: float) -> list[float]:
    """Angles by which the heading goes on after each reversal of the helm but the last [deg]."""
    found = []
    for start, end in pairwise(switched_s):
        part = heading_deg[(time >= start) & (time <= end)]
        side = 1.0 if np.interp(start, time, heading_deg) > 0 else -1.0
        found.append(float((side * part).max()) - angle_deg)
    return found


def zigzag_measures(
    time: Floats, heading_deg: Floats, switched_s: Floats, *, rudder_deg: float, angle_deg: float, length_m: float,
    speed_m_s: float, run_lengths: float,
) -> list[Measure]:  # fmt: skip
    """Of a zig-zag.

    Args:
        time, heading_deg: `(n,)` [s], [deg] from the first course; switched_s: when the helm was reversed.
        rudder_deg, angle_deg: of the manoeuvre; length_m, speed_m_s: of the ship before it.
        run_lengths: way until the first reversal, in lengths.
    """
    seconds = length_m / speed_m_s
    ten = rudder_deg == angle_deg == 10.0
    limits: list[float | None] = [None, None]
    if ten:
        limits = [first_overshoot_limit(seconds), second_overshoot_limit(seconds)]
    elif rudder_deg == angle_deg == 20.0:
        limits = [OVERSHOOT_20, None]
    found = [Measure("way until the first reversal", run_lengths, "L", INITIAL if ten else None)]
    for k, over in enumerate(overshoots(time, heading_deg, switched_s, angle_deg)):
        words = ("first", "second", "third", "fourth")[k] if k < 4 else f"{k + 1}th"
        found.append(Measure(f"{words} overshoot", over, "deg", limits[k] if k < 2 else None))
    if len(switched_s) > 3:
        found.append(Measure("period", float(switched_s[3] - switched_s[1]), "s"))
    return found


def stop_measures(north: Floats, east: Floats, *, heading_deg: float, length_m: float) -> list[Measure]:
    """Of a stop, from the order to the standstill: track, reach ahead and to the side (MSC/Circ.1053, 2.2.4).

    Args:
        north, east: of the ship's middle `(n,)` [m]; heading_deg: at the order; length_m: of the ship.
    """
    c, s = float(np.cos(np.radians(heading_deg))), float(np.sin(np.radians(heading_deg)))
    dn, de = float(north[-1] - north[0]), float(east[-1] - east[0])
    return [
        Measure("stopping track", float(np.hypot(np.diff(north), np.diff(east)).sum()) / length_m, "L", STOPPING),
        Measure("head reach", (dn * c + de * s) / length_m, "L"),
        Measure("side reach, to starboard", (-dn * s + de * c) / length_m, "L"),
    ]


@dataclass(frozen=True)
class HalfCycles:
    """Of a free decay, its extremes and what lies between them.

    Attributes:
        time, angle: of the extremes `(k,)` [s], [rad].
        amplitude: mean of each half cycle `(k - 1,)` [rad].
        ratio: its damping ratio `(k - 1,)` [-].
    """

    time: Floats
    angle: Floats
    amplitude: Floats
    ratio: Floats

    @property
    def growth(self) -> tuple[float, float] | None:
        """Damping ratio at small angles and its growth with the amplitude [1/rad], by least squares.

        None where the growth does not stand out of the scatter, with 95 % (Student's t): what would be carried on to
        small angles is scatter then.
        """
        free = len(self.ratio) - 2
        if free < 1:
            return None
        (slope, zero), spread = np.polyfit(self.amplitude, self.ratio, 1, cov=True)
        told = abs(slope) > stdtrit(free, 0.975) * np.sqrt(spread[0, 0])
        return (float(zero), float(slope)) if told else None


def half_cycles(time: Floats, angle: Floats) -> HalfCycles:
    """Half cycles of a free decay; an extreme is that of the parabola through the largest sample and its neighbours.

    The angle of rest is halfway between the last ones on either side; extremes below 2 % of the largest are left out.
    """
    turns = np.flatnonzero(np.diff(np.sign(np.diff(angle))) != 0) + 1
    before, at, after = (angle[turns + k] for k in (-1, 0, 1))
    bend = before - 2 * at + after
    share = np.where(bend != 0, 0.5 * (before - after) / np.where(bend != 0, bend, 1.0), 0.0)  # of a sample
    when = time[turns] + share * np.where(share > 0, time[turns + 1] - time[turns], time[turns] - time[turns - 1])
    largest = at - 0.25 * (before - after) * share
    last = largest[-max(3, int((turns >= 0.9 * len(angle)).sum())) :]
    halfway = (last[:-2] + 2 * last[1:-1] + last[2:]) / 4  # even where the swing decays
    middle = float(np.mean(halfway)) if len(halfway) else float(np.mean(angle))
    kept = np.abs(largest - middle) > 0.02 * np.abs(angle - middle).max()
    when, largest = when[kept], largest[kept]
    size = np.abs(largest - middle)
    return HalfCycles(when, largest, np.sqrt(size[:-1] * size[1:]), np.log(size[:-1] / size[1:]) / np.pi)


def decay_measures(time: Floats, angle: Floats) -> list[Measure]:
    """Period, linear and quadratic damping of a free decay, from its extremes; see `HalfCycles.growth`.

    a_(k+1) = a_k exp(-pi zeta') with zeta'(a) = zeta + c a, over half cycles (Y. Himeno, "Prediction of ship roll
    damping", University of Michigan report 239, 1981, Section 2).

    Raises:
        InputError: fewer than four extremes, which are three half cycles.
    """
    found = half_cycles(time, angle)
    if len(found.time) < 4:
        raise InputError(
            f"the motion turns {len(found.time)} times, too few for its damping: overdamped, or too short a run"
        )
    measures = [
        Measure("period", 2 * float(np.diff(found.time).mean()), "s"),
        Measure("damping ratio, mean", float(found.ratio.mean()), ""),
    ]
    if found.growth is not None:
        small, growth = found.growth
        measures += [
            Measure("damping ratio at small angles", small, ""),
            Measure("its growth with the angle", growth, "1/rad"),
        ]
    return measures
