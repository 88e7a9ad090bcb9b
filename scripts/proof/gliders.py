"""Glides of a Slocum and of a Seaglider: vertical speed from buoyancy engine, pitch and density of the water."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import drjit as dr
import matplotlib.pyplot as plt
import numpy as np
from page import Chapter, Row, at_most, relative, table

from pelagos import jit
from pelagos.report import theme
from pelagos.vehicles.terms.glide import Glide, GlideConfig
from pelagos.vehicles.vehicle import Vehicle

FOLDER: Final = "06_glider_slocum_comet"
TITLE: Final = "Gliders in the sea"
SOURCE: Final = (
    "Slocum *comet*, Baltic Sea, 2016 (smerckel/gliderflight, MIT); Seaglider SG249, Washington shelf, 2024 "
    "(iop-apl-uw/basestation3, BSD 3-clause). Kept: tables/slocum.csv, tables/seaglider.csv."
)
GRAVITY: Final = 9.81


@dataclass(frozen=True)
class Flowing:
    """nu_r: velocity through the water (6)."""

    nu_r: list[Any]


@dataclass(frozen=True)
class Glides:
    """Samples of steady glides: which dive, time [s], depth [m], vertical speed upward [m/s], pitch [rad] (nose up),
    density of the water [kg/m^3], displaced volume of the engine [m^3].
    """

    dive: np.ndarray
    time: np.ndarray
    depth: np.ndarray
    rise: np.ndarray
    pitch: np.ndarray
    density: np.ndarray
    engine: np.ndarray

    def some(self, chosen: np.ndarray) -> Glides:
        """Chosen samples."""
        return Glides(*(getattr(self, n)[chosen] for n in self.__dataclass_fields__))


def read(name: str) -> Glides:
    """A kept table."""
    t = table(name)
    return Glides(t["dive"], t["time_s"], t["depth_m"], t["rise_m_s"], t["pitch_rad"], t["density"], t["engine_m3"])


def glider(terms: dict[str, float]) -> Glide:
    """The hull of the catalogue's glider with other coefficients, as arrays: others are then no other kernel."""
    known = Vehicle.from_catalogue("glider").config.terms["glide"].model_dump(exclude={"type"})
    numbers = {k: dr.opaque(jit.Float64, v) for k, v in {**known, **terms}.items()}
    return Glide(GlideConfig.model_construct(**numbers))


def steady(hull: Glide, pitch: np.ndarray, net_n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocity ahead and downward in body axes `(n,)` [m/s] at which the hull's force balances net buoyancy [N]."""
    n = len(pitch)
    ahead, down = np.full(n, 0.3), np.where(net_n > 0, -0.02, 0.02)

    def force(u: np.ndarray, w: np.ndarray) -> np.ndarray:
        zero = dr.zeros(jit.Float64, n)
        load = hull.wrench(Flowing([jit.Float64(u), zero, jit.Float64(w), zero, zero, zero]))  # type: ignore[arg-type]
        # net buoyancy acts upward: ahead by the sine of the pitch, and against the body's downward axis
        return np.stack([np.array(load[0]) + net_n * np.sin(pitch), np.array(load[2]) - net_n * np.cos(pitch)], -1)

    for _ in range(40):
        f, h = force(ahead, down), 1e-5
        fu, fw = (force(ahead + h, down) - f) / h, (force(ahead, down + h) - f) / h
        det = fu[:, 0] * fw[:, 1] - fu[:, 1] * fw[:, 0]
        du = -(f[:, 0] * fw[:, 1] - f[:, 1] * fw[:, 0]) / det
        dw = -(fu[:, 0] * f[:, 1] - fu[:, 1] * f[:, 0]) / det
        scale = np.minimum(1.0, 0.05 / np.maximum(np.hypot(du, dw), 1e-9))
        ahead, down = np.clip(ahead + scale * du, 0.02, 1.5), np.clip(down + scale * dw, -0.3, 0.3)
        if max(np.abs(du).max(), np.abs(dw).max()) < 1e-6:
            break
    return ahead, down


def rise(hull: Glide, pitch: np.ndarray, net_n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertical speed upward [m/s] and glide angle [rad] of a steady glide."""
    u, w = steady(hull, pitch, net_n)
    angle = pitch - np.arctan2(w, u)
    return np.hypot(u, w) * np.sin(angle), angle


# -- Slocum ------------------------------------------------------------------------------------------------------------

SLOCUM_KG: Final = 70.0  # nominal; only the difference to its buoyancy counts, which dive 0 calibrates
AREA: Final = 0.1  # reference area of the coefficients below [m^2]
LIFT: Final = 3.7 + 2.4  # wings and hull [1/rad], Merckelbach, Smeed, Griffiths 2010, J. Atmos. Oceanic Technol. 27
INDUCED: Final = 0.78 + 2.1  # drag by angle of attack squared, the same source [1/rad^2]


def slocum(drag: float) -> Glide:
    """The Slocum with a parasite drag coefficient."""
    half = 0.5 * 1006.0 * AREA
    return glider({"lift": half * LIFT, "drag_0": half * drag, "drag": half * INDUCED})


def slocum_net(g: Glides, litres: float) -> np.ndarray:
    """Net buoyancy [N]; litres: of displaced volume beyond that which floats `SLOCUM_KG` at 1006 kg/m^3."""
    return GRAVITY * (g.density * (SLOCUM_KG / 1006.0 + 1e-3 * litres + g.engine) - SLOCUM_KG)


def slocum_calibrated(g: Glides) -> tuple[float, float]:
    """Parasite drag and displaced volume by least squares of the vertical speed."""
    drag, litres = 0.15, 0.0
    for _ in range(4):  # Gauss and Newton
        here = slocum(drag)
        off = rise(here, g.pitch, slocum_net(g, litres))[0] - g.rise
        by_litres = rise(here, g.pitch, slocum_net(g, litres + 0.01))[0] - g.rise - off
        by_drag = rise(slocum(1.02 * drag), g.pitch, slocum_net(g, litres))[0] - g.rise - off
        step = np.linalg.lstsq(np.stack([by_drag / (0.02 * drag), by_litres / 0.01], -1), -off, rcond=None)[0]
        drag, litres = max(drag + float(step[0]), 0.03), litres + float(step[1])
    return drag, litres


def slocum_pitch(train: Glides, train_battery: np.ndarray, g: Glides, battery: np.ndarray) -> np.ndarray:
    """Pitch by where battery and engine stand: tan(pitch) is linear in both; three numbers of the first yo."""
    rows = np.stack([np.ones_like(train_battery), train_battery, train.engine * 1e4], -1)
    known = np.linalg.lstsq(rows, np.tan(train.pitch), rcond=None)[0]
    return np.arctan(np.stack([np.ones_like(battery), battery, g.engine * 1e4], -1) @ known)


# -- Seaglider ---------------------------------------------------------------------------------------------------------

SEAGLIDER: Final = {
    "mass": 73.125,
    "volume_cc": 71828.234 - 0.2453 * (3000 - 500),
    "length": 1.8,
    "a": 0.0050119,
    "b": 0.0034167,
    "c": 5.7e-6,
    "compress": 8.63627e-7,
    "expand": 7.05e-5,
}
"""As its operators regressed them before; compressibility beyond that of the water, whose density is taken at no
pressure [1/dbar], expansion [1/K]."""


def seaglider() -> Glide:
    """Lift q L^2 a alpha and drag q L^2 (b + c alpha^2), alpha [deg]: Eriksen et al. 2001, IEEE J. Oceanic Eng. 26."""
    half, degree = 0.5 * 1027.5 * SEAGLIDER["length"] ** 2, 180 / np.pi
    return glider(
        {
            "lift": half * SEAGLIDER["a"] * degree,
            "drag_0": half * SEAGLIDER["b"],
            "drag": half * SEAGLIDER["c"] * degree**2,
        }
    )


def seaglider_net(g: Glides, temperature: np.ndarray, bias_cc: float) -> np.ndarray:
    """Net buoyancy [N]."""
    k = SEAGLIDER
    cc = (k["volume_cc"] - bias_cc + 1e6 * g.engine) * np.exp(
        -k["compress"] * g.depth * 1.01 + k["expand"] * (temperature - 15)
    )
    return GRAVITY * (g.density * cc * 1e-6 - k["mass"])


def seaglider_bias(g: Glides, temperature: np.ndarray) -> float:
    """Error of the displaced volume [cm^3] by least squares of the vertical speed."""
    bias = 0.0
    for _ in range(4):  # Gauss and Newton
        off = rise(seaglider(), g.pitch, seaglider_net(g, temperature, bias))[0] - g.rise
        by_bias = rise(seaglider(), g.pitch, seaglider_net(g, temperature, bias + 0.5))[0] - g.rise - off
        bias -= 0.5 * float(off @ by_bias / (by_bias @ by_bias))
    return bias


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and all((data / f).is_dir() for f in (FOLDER, "07_glider_seaglider")):
        from gliders_tables import keep_tables

        keep_tables(data)
    rows: list[Row] = []
    comet, battery = read("slocum.csv"), table("slocum.csv")["battery_in"]
    first, rest = comet.dive == 0, comet.dive > 0
    drag, litres = slocum_calibrated(comet.some(first))
    seen = comet.some(rest)
    by_pitch, _ = rise(slocum(drag), seen.pitch, slocum_net(seen, litres))
    pitch = slocum_pitch(comet.some(first), battery[first], seen, battery[rest])
    by_command, _ = rise(slocum(drag), pitch, slocum_net(seen, litres))
    others = "about 1 cm/s (Merckelbach et al. 2010)"
    rows += [
        at_most(
            "Slocum, vertical speed by measured pitch, rms, two unseen yos",
            _rms(by_pitch - seen.rise) * 100,
            "cm/s",
            1.0,
            others,
        ),
        at_most(
            "Slocum, pitch by position of battery and engine, rms", np.degrees(_rms(pitch - seen.pitch)), "deg", 2.0
        ),
        at_most(
            "Slocum, vertical speed by commands alone, rms", _rms(by_command - seen.rise) * 100, "cm/s", 1.0, others
        ),
    ]
    sea, kept = read("seaglider.csv"), table("seaglider.csv")
    test, tenth = sea.dive == 12, sea.dive == 10
    bias = seaglider_bias(sea.some(tenth), kept["temperature_c"][tenth])
    deep = sea.some(test)
    speed, angle = rise(seaglider(), deep.pitch, seaglider_net(deep, kept["temperature_c"][test], bias))
    own = _rms(kept["operators_m_s"][test] - deep.rise) * 100
    others = f"{own:.2f} cm/s: the operators' own model, offset regressed on this dive"
    rows += [
        at_most(
            "Seaglider, vertical speed, rms, unseen dive to 990 m", _rms(speed - deep.rise) * 100, "cm/s", 1.0, others
        ),
        relative(
            "Seaglider, mean speed of descent", "m/s", -deep.rise[deep.rise < 0].mean(), -speed[deep.rise < 0].mean(), 5
        ),
        relative(
            "Seaglider, mean speed of ascent", "m/s", deep.rise[deep.rise > 0].mean(), speed[deep.rise > 0].mean(), 5
        ),
        at_most(
            "Seaglider, glide angle against the operators' own solution, rms",
            np.degrees(_rms(angle - kept["glide_rad"][test])),
            "deg",
            2.0,
        ),
    ]
    return Chapter(
        TITLE,
        _ABOUT.format(drag=drag, litres=litres, bias=bias),
        SOURCE,
        rows,
        _MISSED,
        _drawn(seen, by_pitch, by_command, deep, speed),
        "gliders",
    )


_ABOUT: Final = """\
Steady glides: the hull's lift and drag of the `glide` term balance net buoyancy, sample by sample, with the volume of
the buoyancy engine, the density of the water that the glider's own CTD found, and its pitch. Turns at top and bottom,
and the upper 5 m, are left out; measured vertical speed is the slope of pressure. Slocum: lift and induced drag are
published for the class; two numbers are calibrated on the first yo: parasite drag {drag:.3f} and displaced volume
{litres:+.2f} l. Seaglider: mass, volume, compressibility and drag as its operators regressed them from earlier dives,
and one number of dive 10, the offset of the displaced volume, {bias:.1f} cm3 (operators: 8.5); dive 12 is predicted.
"""
_MISSED: Final = """\
The Seaglider misses by 1 cm/s, as its operators' own model does on this dive: what is left wanders by 2 to 4 cm/s over
tens of minutes, which is the water's own vertical motion (internal waves over the slope), not the glider's.
"""


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(x**2)))


def _drawn(seen: Glides, pitch: np.ndarray, command: np.ndarray, deep: Glides, speed: np.ndarray) -> bytes:
    with theme.style():
        figure = theme.figure(10.5, 3.4)
        left, right = figure.subplots(1, 2)
        for axes, g, title in ((left, seen, "Slocum comet, Baltic"), (right, deep, "Seaglider SG249")):
            axes.plot(g.time / 60, g.rise * 100, ".", ms=3, color=theme.SENSOR, label="measured")
            axes.set_title(title)
            axes.set_xlabel("time [min]")
            axes.set_ylabel("vertical speed [cm/s]")
        left.plot(seen.time / 60, pitch * 100, ".", ms=2, color=theme.TRUTH, label="simulated, by pitch")
        left.plot(seen.time / 60, command * 100, ".", ms=1.5, color=theme.SECOND, label="by commands alone")
        right.plot(deep.time / 60, speed * 100, ".", ms=2, color=theme.TRUTH, label="simulated")
        left.legend()
        right.legend()
        made = theme.as_png(figure)
        plt.close(figure)
        return made
