"""A boat that crosses a river: bottom track against GPS, a bed that moves, a profile of the current."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Final

import matplotlib.pyplot as plt
import numpy as np
from page import Chapter, Row, absolute, relative, table
from river_record import (
    FOLDER,
    MOVING_S,
    SOURCE,
    STILL_S,
    TILT,
    Array,
    Pings,
    alignment,
    downstream,
    keep_tables,
    log_law,
    pings,
    profile,
    spreads,
    turned,
    way,
)

from pelagos.report import theme

if TYPE_CHECKING:
    from river_run import Crossing

TITLE: Final = "A crossing of a river"
LAST: Final = (MOVING_S[1] - 20.0, MOVING_S[1])
LATE: Final = (MOVING_S[1], 1e9)


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and (data / FOLDER).is_dir():
        keep_tables(data / FOLDER)
    p, kept = pings(), table("river_profile.csv")
    law = log_law(kept["part_of_depth"], kept["along_mps"])
    own = importlib.import_module("river_run").crossing(p, law[0])  # only now: its flow is that of the tables
    rows = [*_track_rows(p, own.still), *_bed_rows(p, own), *_water_rows(p, own, law)]
    return Chapter(TITLE, _ABOUT, SOURCE, rows, _MISSED, _picture(p, own), "river")


def _heading(p: Pings) -> Array:
    return p.heading + p.declination + alignment(p)


def _spread(values: Array) -> float:
    """Standard deviation by the median absolute deviation."""
    return float(1.4826 * np.median(np.abs(values - np.median(values))))


def _errors(p: Pings, span: tuple[float, float]) -> Array:
    found = p.error[p.within(span)]
    return found[np.isfinite(found)]


def _tail(values: Array) -> float:
    size = np.abs(values - np.median(values))
    return float(np.percentile(size, 95) / np.median(size))


def _jitter(p: Pings) -> float:
    """Spread of white noise in the ranges, by third differences, whose variance is 20 times its own [m]."""
    thirds = np.diff(p.ranges[p.within(STILL_S)], 3, axis=0)
    return float(np.mean([_spread(x[np.isfinite(x)]) for x in thirds.T]) / 20**0.5)


def made_good(p: Pings, log: Pings, span: tuple[float, float]) -> tuple[Array, Array]:
    """Way from the first to the last ping of a stretch, east and north [m]: by bottom track, and by GPS."""
    rows = np.flatnonzero(p.within(span))
    track = way(p, log.over_ground, _heading(p))
    return track[rows[-1]] - track[rows[0]], p.place[rows[-1]] - p.place[rows[0]]


def bed_speed(p: Pings, log: Pings, span: tuple[float, float]) -> tuple[float, float]:
    """Velocity that a log's lacks of GPS's, along the river and aside [m/s]."""
    rows = p.within(span) & log.seen
    lacks = (p.speed - turned(log.over_ground, _heading(p)))[rows].mean(axis=0)
    along = downstream(table("river_flow.csv"))
    return float(lacks @ along), float(lacks @ np.array([-along[1], along[0]]))


def _track_rows(p: Pings, own: Pings) -> list[Row]:
    measured, simulated = _errors(p, STILL_S), _errors(own, STILL_S)
    lengths = [100 * float(np.hypot(*a) / np.hypot(*b)) for a, b in (made_good(p, x, STILL_S) for x in (p, own))]
    off = [1e3 * float((turned(x.over_ground, _heading(p)) - p.speed)[p.within(STILL_S) & x.seen].std())
           for x in (p, own)]  # fmt: skip
    return [
        relative("error velocity of the bottom track, one ping, spread", "mm/s", 1e3 * _spread(measured),
                 1e3 * _spread(simulated), 20.0),
        relative("the same, 95th percentile of its size by the median", "", _tail(measured), _tail(simulated), 20.0),
        relative("ranges of the beams, spread from one ping to the next", "cm", 100 * _jitter(p), 100 * _jitter(own),
                 20.0),
        absolute("pings with a velocity over ground, still bed", "%", *(_share(x, STILL_S) for x in (p, own)), 2.0),
        absolute("beams lost, still bed", "%", *(_lost(x, STILL_S) for x in (p, own)), 2.0),
        absolute("way over still bed by bottom track, of that by GPS", "%", *lengths, 2.0),
        absolute("velocity over ground, a component, against that of GPS, rms", "mm/s", *off, None),
    ]  # fmt: skip


def _share(p: Pings, span: tuple[float, float]) -> float:
    return 100 * float(p.seen[p.within(span)].mean())


def _lost(p: Pings, span: tuple[float, float]) -> float:
    return 100 * float(p.lost[p.within(span)].mean())


def _bed_rows(p: Pings, own: Crossing) -> list[Row]:
    (along, aside), sand = (bed_speed(p, x, MOVING_S) for x in (p, own.sand))
    offs = [float(np.hypot(*np.subtract(*made_good(p, x, MOVING_S)))) for x in (p, own.sand)]
    return [
        relative("speed of the bed along the river, `bed_grain_mm` of fine sand", "m/s", along, sand[0], 20.0),
        relative("the same, the last 20 of the 103 s", "m/s", *(bed_speed(p, x, LAST)[0] for x in (p, own.sand)), 20.0),
        absolute("speed of the bed aside", "m/s", aside, sand[1], 0.1),
        relative("error velocity over moving bed, spread, of what is below the 0.1 m/s that the log lets through",
                 "mm/s", *(1e3 * _spread(_errors(x, MOVING_S)) for x in (p, own.sand)), 20.0),
        relative("way over moving bed, off by", "m", *offs, None),
        absolute("beams lost, moving bed", "%", *(_lost(x, MOVING_S) for x in (p, own.sand)), 2.0),
        absolute("pings with a velocity over ground, moving bed", "%", _share(p, MOVING_S), _share(own.sand, MOVING_S),
                 2.0),
        absolute("pings with a velocity over ground, last 119, 4.4 to 1.4 m deep", "%", _share(p, LATE),
                 _share(own.sand, LATE), 2.0),
    ]  # fmt: skip


def _water_rows(p: Pings, own: Crossing, law: tuple[float, float, float]) -> list[Row]:
    rows, kept = p.within(MOVING_S), table("river_water.csv")
    water, depth = own.water, np.nanmean(p.ranges, axis=1)[rows]
    found, (friction, _, power) = spreads(water, depth), log_law(*profile(water, depth))
    beam = 2 * np.cos(TILT)  # from the error of four beams' vertical velocity to one beam's
    return [
        relative("water, noise along a beam in a cell of 0.25 m, one ping", "mm/s",
                 1e3 * beam * float(kept["noise_up_mps"][0]), 1e3 * beam * found["noise_up"], 20.0),
        relative("water, vertical velocity in a cell, spread about the ping's mean", "mm/s",
                 1e3 * float(kept["up_mps"][0]), 1e3 * found["up"], 20.0),
        relative("water, velocity along the river, spread about profile and ping's mean", "mm/s",
                 1e3 * float(kept["along_mps"][0]), 1e3 * found["along"], 20.0),
        relative("profile, friction velocity by the logarithmic law", "mm/s", 1e3 * law[0], 1e3 * friction, None),
        relative("profile, exponent of the power law", "", law[2], power, None, "1/6: USGS's, for gauging"),
    ]  # fmt: skip


def _picture(p: Pings, own: Crossing) -> bytes:
    with theme.style():
        figure = theme.figure(10.5, 3.4)
        plan, histogram, shear = figure.subplots(1, 3, gridspec_kw={"width_ratios": [2.2, 1, 1]})
        rows = np.flatnonzero(p.within((STILL_S[0], MOVING_S[1])))
        start = p.place[rows[0]]
        plan.plot(*(p.place[rows] - start).T, color="0.7", lw=4, label="GPS")
        logs = (("measured", p, theme.SENSOR, "-"), ("simulated, fine sand", own.sand, theme.TRUTH, "-"),
                ("simulated, still bed", own.still, theme.TRUTH, "--"))  # fmt: skip
        for label, log, color, line in logs:
            track = way(p, log.over_ground, _heading(p))
            first = rows[0]
            if log is own.sand:  # from where the recorded bed begins to move
                first = np.flatnonzero(p.within(MOVING_S))[0]
            place = track - track[first] + (p.place[first] - start)
            plan.plot(*place[first : rows[-1] + 1].T, line, color=color, label=label)
        plan.set_xlabel("east [m]")
        plan.set_ylabel("north [m]")
        plan.set_aspect("equal")
        plan.legend()
        bins = np.linspace(-50, 50, 26)
        histogram.hist(1e3 * _errors(p, STILL_S), bins, density=True, color=theme.SENSOR, alpha=0.5, label="measured")
        histogram.hist(1e3 * _errors(own.still, STILL_S), bins, density=True, histtype="step", color=theme.TRUTH,
                       label="simulated")  # fmt: skip
        histogram.set_xlabel("error velocity [mm/s]")
        histogram.set_ylabel("share by mm/s")
        kept, inside = table("river_profile.csv"), p.within(MOVING_S)
        middles, speeds = profile(own.water, np.nanmean(p.ranges, axis=1)[inside])
        shear.plot(kept["along_mps"], kept["part_of_depth"], "o", ms=4, color=theme.SENSOR)
        shear.plot(speeds, middles, color=theme.TRUTH)
        shear.set_xlabel("along the river [m/s]")
        shear.set_ylabel("part of the depth")
        shear.set_ylim(1, 0)
        picture = theme.as_png(figure)
        plt.close(figure)
    return picture


_ABOUT: Final = """\
A boat goes from one bank to the other, 145 m, at 0.1 to 1.1 m/s, in 5 min and 580 pings. Its profiler tracks the
bottom, at 20 deg and one ping an ensemble; GPS (GGA, VTG) stands in the same ensembles. Over 73 s of the way, 7.2 to
8.6 m deep, the bed is still: bottom track and GPS agree. Then the bed moves, 1.1 m/s at last: the log, which takes it
for still, goes 67 m astray, up the river. Simulated are two `dvl`, at the recorded places and attitudes, over the bed
as the four beams sounded it: over still bed, and with `bed_grain_mm` of fine sand, which the river has there in parts
(Toniolo 2013, doi 10.4236/nr.2013.41003). Their noise is that of the sheet of the maker's log of 1200 kHz for vehicles.
An `adcp` with the noise of the maker's sheet for cells of 0.25 m looks into the recorded mean flow (speed and depth
across; by depth the logarithmic law that fits best) and its eddies: `turbulence`, whose strength and size follow from
friction velocity and depth (Nezu and Nakagawa 1993). Nuisances, fitted over still bed: the log stands 1.0 deg aside of
the compass, with the declination of 20.3 deg that the receiver tells, and the receiver's velocity is 0.3 s off the
log's clock. Where the bed moves is taken from the record; how fast, from the flow.
"""
_MISSED: Final = """\
Bottom track: over still bed the error velocity spreads by 8 mm/s in the first 54 s, and by 18 mm/s in the last 18, next
to where the bed moves: some of what is measured is the bed. The rest is the device: it was in the maker's mode for
shallow water (7), whose noise no sheet at hand tells; the sheet that is simulated is of another log of 1200 kHz. Ranges
scatter by 0.5 % (0.2 % simulated). The 25 mm/s against GPS are mostly the receiver's.

Moving bed: the mean speed is that of van Rijn's grains under the skin friction of the recorded flow, 0.61 m/s (grains
of 0.125 and 0.25 mm: 14 % less, 15 % more). Its course is not: measured from 0.16 m/s at the beginning to 1.09 m/s at
the end, simulated 0.54 to 0.67. A bed that is part gravel and part sand, over which a log tracks a mean of what lies
and what moves, would be slower than grains; sand in suspension over it, which 1200 kHz hear, faster. Neither is in
`dvl`. The same goes for what is lost: of 65 pings without a velocity 60 have four good beams and were refused, since
their error velocity was beyond 0.1 m/s: beams track patches that move differently. The eddies of the simulated flow
make them do so, 41 % less; real eddies at the bed are twice as strong as in the mean over the depth, which these are.
Of single beams 3 to 11 % are lost there, which the others make up for. At the far bank, over moving sand less than 4.4
m below, 80 of 117 lost pings have no beam that correlates; a simulated echo always does.

Water: the sheet is for the maker's mode 1; the recorded pings are of mode 12, with a short lag (8 cm) and an untold
number of subpings. In sheets of broadband profilers the noise of a cell falls with its height, not with its root (14.0,
7.0, 3.6, 1.8 cm/s at 0.25 to 2 m), for which there is `noise_cell_exponent`; by its default the sheet's figure for 1 m
would make 7.3 cm/s at 0.25 m. The profile is that of the logarithmic law, with 0.995 of correlation; no row of it is
judged, for the simulated flow is the recorded one: what it tests is the profiler. Along the river eddies are weaker
than recorded, as they must be where all three components have the same rms.
"""
