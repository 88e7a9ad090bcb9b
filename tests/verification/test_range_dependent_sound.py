"""Sound through water that changes along the way: circles in a horizontal gradient, a front, and BELLHOP."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import pelagos as pl
from pelagos.acoustics.eigenrays import eigenrays
from pelagos.acoustics.section import Section
from pelagos.acoustics.transmission_loss import field
from pelagos.sensors.sonar.ping.water_survey import survey

START, REACH = 1500.0, 2000.0  # [m/s], [m]


def columns(count: int, reach: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Middles and beginnings of columns from end to end."""
    x = np.linspace(0.0, reach, count)
    return x, np.concatenate([[0.0], 0.5 * (x[1:] + x[:-1])])


def circle(gradient: float, source: float, angle: float) -> float:
    """Depth at REACH of a ray in c = START + gradient x: a circle about a point where c would vanish."""
    across = -START / gradient
    centre = source - across * math.cos(angle) / math.sin(angle)  # the radius is at right angles to the ray
    radius2 = across**2 + (source - centre) ** 2
    return centre + math.copysign(math.sqrt(radius2 - (REACH - across) ** 2), source - centre)


@pytest.mark.parametrize("gradient", [0.02, -0.015])
def test_rays_in_a_horizontal_gradient_are_circles(gradient: float) -> None:
    """Time by the formula of a linear gradient (it holds for any direction), angle and spreading of the circle.

    Columns are of second order: time, angle and level of three times as many are nine times as good, within a half.
    """
    source, receiver = 1000.0, 1500.0
    way = math.hypot(REACH, receiver - source)
    time = math.acosh(1 + (gradient * way) ** 2 / (2 * START * (START + gradient * REACH))) / abs(gradient)
    low, high = 0.05, 0.6
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if circle(gradient, source, middle) < receiver else (low, middle)
    angle, step = 0.5 * (low + high), 1e-4
    slope = (circle(gradient, source, angle + step) - circle(gradient, source, angle - step)) / (2 * step)
    there = START + gradient * REACH
    arrives = math.sqrt(1 - (math.sin(angle) * there / START) ** 2)  # cosine, by Snell's law at vertical faces
    loss = -10 * math.log10(math.cos(angle) * there / (START * REACH * slope * arrives))
    errors = []
    for count in (9, 25, 73):
        x, begins = columns(count, REACH)
        speed = np.repeat((START + gradient * x)[:, None], 2, axis=1)
        section = Section(np.array([0.0, 3000.0]), speed, bottom_depth=np.array([5000.0]), begins=begins, frequency=1e5)
        a = eigenrays([section], np.array([source]), np.array([receiver]), np.array([REACH]))
        (k,) = np.flatnonzero((a.surface == 0) & (a.bottom == 0))
        errors.append([a.delay[k] - time, a.departure[k] - angle, a.loss_db[k] - loss])
    coarse, middle, fine = np.abs(errors)
    assert (fine < [5e-8, 1e-9, 1e-6]).all()
    np.testing.assert_allclose([coarse[0] / middle[0], middle[0] / fine[0]], 9.0, rtol=0.02)


def stream(depth: NDArray[np.float64], x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Munk's profile whose axis rises from 1300 to 900 m over 40 km, as across the Gulf Stream [m/s]; `(x, depth)`."""
    axis = 1300.0 - 400.0 * 0.5 * (1.0 + np.tanh((x - 50e3) / 15e3))[:, None]
    scaled = 2 * (depth - axis) / 1300.0
    return np.asarray(1500.0 * (1 + 0.00737 * (scaled - 1 + np.exp(-scaled))))


def test_arrivals_across_a_stream_are_bellhops(tmp_path: Path) -> None:
    """100 km across a stream, with BELLHOP's own quadrilateral water: refracted rays agree within 0.1 ms in 67 s, their
    levels mostly within 1 dB (its steps of 50 m, our 101 columns of 1 km).
    """
    pelagic = pytest.importorskip("pelagic")
    depth, reach = np.arange(0.0, 5001.0, 100.0), 1e5
    x, begins = columns(101, reach)
    grid = stream(depth, x)
    lines = [
        "'stream'", "50.0", "1", "'QVF'", "0 0.0 5000.0",
        *(f"{d} {c} /" for d, c in zip(depth, grid[0], strict=True)),
        "'A' 0.0", "5000.0 1600.0 0.0 1.0 0.0 0.0 /", "1", "1000.0 /", "1", "800.0 /", "1", "100.0 /", "'A'", "2001",
        "-14 14 /", "50.0 5500.0 101.0",
    ]  # fmt: skip
    (tmp_path / "case.env").write_text("\n".join(lines) + "\n")
    wide, x_wide = np.vstack([grid[:1], grid, grid[-1:]]), [-5.0, *(x / 1e3), 105.0]
    rows = "\n".join(" ".join(f"{c:.6f}" for c in row) for row in wide.T)
    (tmp_path / "case.ssp").write_text(f"{len(x_wide)}\n{' '.join(str(v) for v in x_wide)}\n{rows}\n")
    theirs = pelagic.bellhop.load(str(tmp_path / "case.env")).run().arrivals
    section = Section(depth, grid, bottom_depth=np.array([5000.0]), begins=begins, frequency=50.0,
                      sound_speed_ratio=1600 / float(grid[0, -1]))  # fmt: skip
    ours = eigenrays([section], np.array([1000.0]), np.array([800.0]), np.array([reach]))
    times, angles = np.asarray(theirs.travel_time_s), np.asarray(theirs.source_angle_degrees)
    sizes = np.asarray(theirs.amplitude)
    refracted = np.flatnonzero((ours.surface == 0) & (ours.bottom == 0))
    assert len(refracted) >= 4
    times_off, levels_off = [], []
    for k in refracted:
        near = np.flatnonzero(np.abs(angles - np.degrees(ours.departure[k])) < 0.1)
        assert len(near)
        best = near[np.argmin(np.abs(times[near] - ours.delay[k]))]
        times_off.append(times[best] - ours.delay[k])
        pair = near[np.abs(times[near] - times[best]) < 1e-4]
        levels_off.append(20 * np.log10(sizes[pair].sum()) + ours.loss_db[k])
    assert np.abs(times_off).max() < 1e-4
    assert np.median(np.abs(levels_off)) < 0.5
    assert np.mean(np.abs(levels_off) < 1.0) >= 0.75  # two are at a caustic, which ours widen by the Fresnel zone


def test_sound_takes_its_time_in_the_water_it_meets() -> None:
    """A front of 8 degC across a harbour's mouth: along a level path of 1.2 km in shallow water the first arrival takes
    the integral of dx/c, asked of the ocean itself at 600 places.
    """
    front = {"type": "front", "through_m": [350, 0], "towards_deg": 10, "step": -8.0, "width_m": 120.0}
    made: dict[str, Any] = {
        "tick_rate_hz": 20,
        "world": {"type": "flat", "depth_m": 300.0, "size_m": [4000.0, 4000.0]},
        "ocean": {"temperature_c": [{"type": "uniform", "value": 16.0}, front]},
        "agents": {"a": {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 150}}},
    }
    sim = pl.Simulation.load(made)
    source, receiver = np.array([0.0, 30.0, -150.0]), np.array([1200.0, -90.0, -149.0])
    a = pl.channel(sim, tuple(source), tuple(receiver)).arrivals()
    share = (np.arange(600) + 0.5) / 600
    place = source + share[:, None] * (receiver - source)
    from pelagos import jit

    at = jit.Array3f64(*(jit.Float64(np.ascontiguousarray(v)) for v in place.T))
    c = np.array(sim.ocean.fields.sound_speed(at, jit.Float64(0.0)))
    way = float(np.linalg.norm(receiver - source))
    assert np.ptp(c) > 20.0
    pressure, middle = 0.0165, float(c.mean())  # [1/s], by which sound speed grows with depth: Fermat's way is shorter
    bent = pressure**2 * way**3 / (24 * middle**3)
    assert a.delay[0] == pytest.approx(way * float(np.mean(1.0 / c)) - bent, abs=1e-6)
    assert a.doppler[0] == 1.0
    back = pl.channel(sim, tuple(receiver), tuple(source)).arrivals()
    assert back.delay[0] == pytest.approx(a.delay[0], abs=1e-9)
    sideways = 10 * math.log10(c[0] / c[-1])  # spreading to the side counts as r, as in BELLHOP: see Jensen, 3.3.5.1
    assert back.loss_db[0] == pytest.approx(a.loss_db[0] - sideways, abs=0.02)


def test_fields_are_reciprocal_across_a_stream() -> None:
    """Level at the receiver from the source is that at the source from the receiver (incoherent, mean over 200 m of
    depth): both ways through the same water, which one sees turned around.
    """
    depth, reach = np.arange(0.0, 5001.0, 100.0), 60e3
    x, begins = columns(61, reach)
    grid = stream(depth, x + 20e3)
    ends = (1000.0, 800.0)
    level = []
    for speed, (here, there) in ((grid, ends), (grid[::-1], ends[::-1])):
        section = Section(depth, speed, bottom_depth=np.array([5000.0]), begins=begins, frequency=50.0)
        rows = np.linspace(there - 100, there + 100, 21)
        made = field(section, here, reach=reach, columns=60, depths=rows, widest=math.radians(13), beams=1500)
        level.append(10 * np.log10(made.intensity[-1].mean()))
    assert level[0] == pytest.approx(level[1], abs=1.0)


@pytest.mark.parametrize("slope", [1e-3, -4e-4])
def test_water_is_looked_at_over_the_whole_first_day(slope: float) -> None:
    """A gradient that grows from nothing at the start to `slope` over a reach after 24 hours: no less is found, and no
    more than by the places at 1.92 reaches from the middle, 0.2 %."""
    reach, day = 50.0, 86400.0
    ocean = SimpleNamespace(sound_speed=lambda at, t: START * (1 + slope * at.x / reach * t / day))
    context: Any = SimpleNamespace(ocean=ocean, world=SimpleNamespace(geometries=()))
    assert survey(context, reach, -20.0).variation == pytest.approx(abs(slope), rel=3e-3)
