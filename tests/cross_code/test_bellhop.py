"""Rays and fields against BELLHOP itself (M. B. Porter), which the package `pelagic` brings."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pelagos.acoustics.eigenrays import eigenrays
from pelagos.acoustics.section import Section
from pelagos.acoustics.transmission_loss import field

pelagic = pytest.importorskip("pelagic")

DICKINS_DEPTH = np.array(
    [0, 5, 10, 15, 20, 25, 30, 35, 38, 50, 70, 100, 140, 160, 170, 200, 215, 250, 300, 370, 450, 500, 700, 900, 1000,
     1250, 1500, 2000, 2500, 3000], float
)  # fmt: skip
DICKINS_SPEED = np.array(
    [1476.7, 1476.7, 1476.7, 1476.7, 1476.7, 1476.7, 1476.7, 1476.7, 1476.7, 1472.6, 1468.8, 1467.2, 1471.6, 1473.6,
     1473.6, 1472.7, 1472.2, 1471.6, 1471.6, 1472.0, 1472.7, 1473.1, 1474.9, 1477.0, 1478.1, 1480.7, 1483.8, 1490.5,
     1498.3, 1506.5]
)  # fmt: skip


def bellhop(folder: Path, section: Section, source: float, depths: NDArray[Any], ranges: NDArray[Any], *, task: str,
            angle_deg: float, beams: int, sediment: tuple[float, float, float], step: float = 0.0) -> Any:  # fmt: skip
    """Its result for a section; `sediment`: sound speed [m/s], density ratio, attenuation [dB/m/kHz]; `step` [m]."""
    speed, density, attenuation = sediment
    lowest = section.depth[-1]
    lines = [
        "'section'", f"{section.frequency}", "1", "'CVF'", f"0 0.0 {lowest}",
        *(f"{d} {c} /" for d, c in zip(section.depth, section.speed, strict=True)),
        "'A*' 0.0", f"{lowest} {speed} 0.0 {density} {attenuation} 0.0 /", "1", f"{source} /",
        f"{len(depths)}", f"{depths[0]} {depths[-1]} /", f"{len(ranges)}", f"{ranges[0] / 1e3} {ranges[-1] / 1e3} /",
        f"'{task}'", f"{beams}", f"{-angle_deg} {angle_deg} /", f"{step} {lowest * 1.1} {ranges[-1] / 1e3 * 1.01}",
    ]  # fmt: skip
    (folder / "case.env").write_text("\n".join(lines) + "\n")
    nodes = [(x / 1e3, z) for x, z in zip(section.bottom_x, section.bottom_depth, strict=True)]
    if nodes[-1][0] < ranges[-1] / 1e3:
        nodes.append((ranges[-1] / 1e3 * 1.02, nodes[-1][1]))
    (folder / "case.bty").write_text(f"'L'\n{len(nodes)}\n" + "\n".join(f"{x} {z}" for x, z in nodes) + "\n")
    return pelagic.bellhop.load(str(folder / "case.env")).run()


def section_over(depth: NDArray[Any], speed: NDArray[Any], x: NDArray[Any], z: NDArray[Any], frequency: float,
                 sediment: tuple[float, float, float]) -> Section:  # fmt: skip
    """A section over one sediment; loss is the imaginary over the real wavenumber."""
    loss = sediment[2] * frequency / 1e3 / (20 / math.log(10)) / (2 * np.pi * frequency / sediment[0])
    ratio = sediment[0] / np.interp(z, depth, speed)
    return Section(depth, speed, x, z, density_ratio=sediment[1], sound_speed_ratio=ratio, loss=loss,
                   frequency=frequency)  # fmt: skip


def test_arrivals_in_a_munk_profile(tmp_path: Path) -> None:
    """The same arrivals, in time within 0.1 ms in 67 s (its steps of 50 m) and in level within 0.1 dB."""
    depth = np.arange(0.0, 5001.0, 200.0)
    scaled = 2 * (depth - 1300) / 1300
    speed = 1500 * (1 + 0.00737 * (scaled - 1 + np.exp(-scaled)))
    section = section_over(depth, speed, np.zeros(1), np.array([5000.0]), 50.0, (1600.0, 1.0, 0.0))
    theirs = bellhop(tmp_path, section, 1000.0, np.array([800.0]), np.array([1e5]), task="A", angle_deg=25.0,
                     beams=2001, sediment=(1600.0, 1.0, 0.0), step=50.0).arrivals  # fmt: skip
    ours = eigenrays([section], np.array([1000.0]), np.array([800.0]), np.array([1e5]))
    loud = np.asarray(theirs.amplitude) > 10 ** (-110 / 20)
    times, angles = np.asarray(theirs.travel_time_s)[loud], np.asarray(theirs.source_angle_degrees)[loud]
    sizes = np.asarray(theirs.amplitude)[loud]
    checked = 0
    for k in range(10):
        near = np.abs(angles - np.degrees(ours.departure[k])) < 0.03
        assert near.any()
        best = np.flatnonzero(near)[np.argmin(np.abs(times[near] - ours.delay[k]))]
        assert times[best] == pytest.approx(ours.delay[k], abs=1e-4)
        pair = np.flatnonzero(near & (np.abs(times - times[best]) < 1e-4))  # two neighbouring beams share an eigenray
        checked += abs(20 * np.log10(sizes[pair].sum()) + ours.loss_db[k]) < 0.1
    assert checked >= 8


@pytest.mark.parametrize("case", ["dickins", "parabola", "ellipse"])
def test_fields_over_uneven_bottoms(case: str, tmp_path: Path) -> None:
    """Incoherent loss within 1 dB rms of BELLHOP wherever less than 110 dB is lost, below the surface.

    The ellipse's ends turn rays back, which both follow. Its fan is as wide as may be: beyond a fan's edge both have
    only the tails of its last beams, which they cut off at other places.
    """
    if case == "dickins":
        x = np.linspace(0.0, 1e5, 401)
        z = np.interp(x, [0, 10e3, 20e3, 30e3, 100e3], [3000, 3000, 500, 3000, 3000])
        depth, speed, source, angle, sediment = DICKINS_DEPTH, DICKINS_SPEED, 18.0, 45.0, (1550.0, 1.5, 0.5)
        rows, reach, columns, frequency = np.arange(0.0, 3001.0, 30.0), 1e5, 250, 230.0
    else:
        speed, sediment, frequency = np.array([1500.0, 1500.0]), (1800.0, 1.8, 0.1), 200.0
        if case == "parabola":
            x = np.linspace(0.0, 20e3, 300)
            z, reach, columns, source = 250.0 * np.sqrt(1 + 0.8e-3 * x), 20e3, 200, 20.0
        else:
            x = np.linspace(0.0, 10e3, 200)
            z, reach, columns, source = 1000 + 500 * np.sqrt(1 - (x / 5e3 - 1) ** 2), 10e3, 200, 500.0
        angle = 60.0 if case == "parabola" else 88.0
        depth, rows = np.array([0.0, 1.02 * z.max()]), np.arange(0.0, z.max(), 20.0)
    section = section_over(depth, speed, x, z, frequency, sediment)
    made = field(section, source, reach=reach, columns=columns, depths=rows, widest=math.radians(angle), beams=2000)
    ranges = np.linspace(0.0, reach, columns + 1)
    theirs = bellhop(tmp_path, section, source, rows, ranges, task="IB", angle_deg=angle, beams=2000, sediment=sediment)
    other = np.asarray(theirs.field.transmission_loss()).squeeze().T[1:, 1:]
    mine = made.incoherent_loss_db[:, 1:]
    wet = rows[1:][None, :] < np.interp(made.x, x, z)[:, None] - 1.0
    compared = wet & (other < 110) & (mine < 110)
    error = (mine - other)[compared]
    assert compared.mean() > 0.5
    assert abs(np.median(error)) < 0.1
    assert np.sqrt(np.mean(error**2)) < (0.1 if case == "ellipse" else 1.0)
