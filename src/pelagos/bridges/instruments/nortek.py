"""Nortek DVL: the bottom-track sentence $PNORBT7, as a pure function.

Source: Nortek, DVL Integrator's Guide (N3015-011), data format 358: time [s since 1970], dt1, dt2 [ms], velocity [m/s],
figure of merit [m/s], vertical distance of each beam [m]. Velocity x forward, y right, z down, of the instrument.
"""

from __future__ import annotations

from datetime import datetime

from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.bridges.instruments.nmea import clock, sentence

INVALID_MPS = -32.768
"""What the instrument sends for a velocity that it does not know."""


def bottom_track(dvl: DvlVelocity, epoch: datetime, down: tuple[float, ...]) -> bytes:
    """$PNORBT7; `down` is the downward part of each beam's direction."""
    x, y, z = dvl.velocity or (INVALID_MPS,) * 3
    distances = ",".join(
        f"{r * d:.2f}" if good else "0.00" for r, d, good in zip(dvl.ranges_m, down, dvl.beam_valid, strict=True)
    )
    seconds = clock(dvl.t_ns, epoch).timestamp()
    return sentence(f"PNORBT7,{seconds:.4f},0.000,0.000,{x:.4f},{y:.4f},{z:.4f},{dvl.merit_mps:.5f},{distances}")
