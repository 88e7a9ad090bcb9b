"""Drift of floating hulls: coefficients of a panel method against analytic cases, and what the simulator makes of them.

`data/capytaine_barge_drift.json` is made by `scripts/bem.py`'s functions: a box of 10 m x 4 m and 1 m of draught.
"""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy.special import h1vp, jvp
from test_vehicle_seakeeping import BARGE

import pelagos as pl
from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.vehicles.drift import DriftConfig, compile_drift

RHO, G = 1000.0, 9.81
TABLE: dict[str, Any] = json.loads((Path(__file__).parent / "data/capytaine_barge_drift.json").read_text())
DRIFT = {k: v for k, v in TABLE.items() if k != "source"}
WHOLE = {k: v for k, v in DRIFT.items() if k != "own"}

_SCRIPT = importlib.util.spec_from_file_location("drift", Path(__file__).parents[2] / "scripts/drift.py")
assert _SCRIPT is not None
_MODULE = importlib.util.module_from_spec(_SCRIPT)
assert _SCRIPT.loader is not None
_SCRIPT.loader.exec_module(_MODULE)
own_force = _MODULE.own_force

# ka, surge force over rho on a held cylinder of 1 m radius that stands in 2 m of water, N m^3 / kg per m^2 of amplitude
# squared: `solve` of scripts/bem.py with Capytaine 3.0.0, 40 x 12 and 60 x 18 panels
CYLINDER = [
    (0.3, 1.417266, 1.397416), (0.5, 4.555798, 4.494664), (0.8, 7.780356, 7.702014), (1.0, 7.675659, 7.617229),
    (1.5, 6.164725, 6.140559), (2.0, 6.296458, 6.274549),
]  # fmt: skip


@pytest.mark.parametrize(("ka", "coarse", "fine"), CYLINDER)
def test_panel_method_against_the_standing_cylinder(ka: float, coarse: float, fine: float) -> None:
    """R. C. MacCamy and R. A. Fuchs, Beach Erosion Board TM 69 (1954): the scattered wave's far field, and from it the
    momentum. Flat panels make the circle smaller, and the error falls with their size: two meshes, 40 and 60 around,
    extrapolated to none: 1 %.
    """
    depth = 2.0
    orders = np.arange(30)
    phase = 1 - 2 * jvp(orders, ka) / h1vp(orders, ka)
    group = 0.5 * (1 + 2 * ka * depth / np.sinh(2 * ka * depth))  # group over phase velocity
    exact = 0.5 * G * group / ka * np.sum(np.abs(np.diff(phase)) ** 2)
    assert fine == pytest.approx(exact, rel=0.04)
    assert fine + (fine - coarse) * 40 / 20 == pytest.approx(exact, rel=0.01)


def test_short_waves_are_turned_back_by_a_wall() -> None:
    """rho g a^2 / 2 on each metre of a wall that throws a wave back (Maruo 1960). At 3.2 rad/s waves are 6 m long: the
    bow throws back nearly all, and 1 m of draught lets exp(-2 k d) = 12 % of the energy pass below the sides, and ends
    add to them: 10 %.
    """
    force = np.array(TABLE["force"])[-1]
    assert -force[-1, 0] / (0.5 * G * 4.0) == pytest.approx(1.0, abs=0.1)  # head sea
    assert force[6, 1] / (0.5 * G * 10.0) == pytest.approx(1.0, abs=0.1)  # beam sea


def pushes(waves: Any, drift: Any, seconds: np.ndarray, heading_deg: float = 0.0) -> np.ndarray:
    """`(times, 3)`."""
    c, s = (jit.Float64(f(np.radians(heading_deg))) for f in (np.cos, np.sin))
    zero = 0 * jit.Float64(seconds)
    found = drift.push(waves, drift.rows.on_device(), zero, zero, (c + zero, s + zero), jit.Float64(seconds))
    return np.array([np.array(f) for f in found]).T


def sea(*waves: dict[str, Any], seed: int = 1) -> Any:
    return build_ocean(OceanConfig.model_validate({"waves": list(waves)}), seed=seed).waves


@pytest.mark.parametrize(("towards", "heading"), [(0, 0), (90, 0), (270, 0), (45, 0), (45, 300), (200, 30)])
def test_a_regular_wave_pushes_steadily(towards: float, heading: float) -> None:
    """By a^2 D, at a tabulated heading and frequency; from port as from starboard."""
    drift = compile_drift(DriftConfig.model_validate(WHOLE))
    wave = {"type": "regular", "height_m": 0.6, "period_s": 2 * np.pi / 2.4, "towards_deg": towards}
    found = pushes(sea(wave), drift, np.linspace(0, 30, 50), heading)
    assert np.ptp(found, axis=0) == pytest.approx(0.0, abs=1e-9)
    relative = (towards - heading + 180) % 360 - 180
    at = np.interp(abs(relative), DRIFT["heading_deg"], np.arange(13))
    table = np.array(DRIFT["force"])[DRIFT["omega_radps"].index(2.4)]
    expected = np.array([np.interp(at, np.arange(13), table[:, k]) for k in range(3)]) * 0.09
    expected[1:] *= np.sign(relative) if relative else 1.0
    # the nearest of 384 frequencies up to 3.2 rad/s lies up to 0.004 off, 2 % of a row
    assert found[0] == pytest.approx(expected, abs=0.03 * np.abs(table).max() * 0.09)


def test_an_irregular_sea_pushes_slowly_with_the_mean_of_its_components() -> None:
    """The mean over a long time is sum a^2 D (uneven frequencies: to 1 / (T df)), and nothing is faster than groups."""
    drift = compile_drift(DriftConfig.model_validate(WHOLE))
    waves = sea({"type": "jonswap", "significant_height_m": 1.0, "peak_period_s": 3.0, "towards_deg": 180,
                 "spreading": None, "components_count": 60})  # fmt: skip
    rows = np.array(waves.table).reshape(-1, 8)
    rows = rows[rows[:, 4] > 0]
    d = np.interp(2 * np.pi * rows[:, 2], drift.rows.step * np.arange(384), drift.rows.rows[:, -1, 0])
    t = np.arange(0, 40_000, 0.5)
    force = pushes(waves, drift, t)[:, 0]
    assert force.mean() == pytest.approx(np.sum(rows[:, 4] ** 2 * d), rel=0.03)
    assert np.abs(pushes(waves, drift, t[:50])[:, 1]).max() < 1e-9


def test_frozen_is_plain() -> None:
    drift = compile_drift(DriftConfig.model_validate(DRIFT))
    waves = sea({"type": "sea_state", "state": 3})
    table = drift.rows.on_device()
    frozen = jit.freeze(lambda w, d, x, t: drift.push(w, d, x, x, (0 * x + 1.0, 0 * x), t))
    for t in (1.0, 2.0, 3.0):
        x, now = jit.Float64([0.0, 5.0, 9.0]), dr.opaque(jit.Float64, t)
        plain = drift.push(waves, table, x, x, (0 * x + 1.0, 0 * x), now)
        assert np.array_equal(np.array(frozen(waves, table, x, now)), np.array(plain))


# w [rad/s], heading of the wave [deg]: own force of the pressure model and the whole are far apart, or alike
@pytest.mark.parametrize(("omega", "heading", "axis"), [(1.8, 0.0, 0), (2.0, 180.0, 0), (2.4, 90.0, 1)])
def test_a_barge_on_a_spring_feels_the_panel_methods_drift(omega: float, heading: float, axis: int) -> None:
    """What the pressure on the moving hull has by itself and what is added make the whole, when the barge moves freely
    in a low wave: within 5 % of the larger of the two (the table between its rows, and the settling of the spring).
    """
    vehicle = {
        **BARGE,
        "terms": {**BARGE["terms"], "roll": {"type": "linear_damping", "diagonal": [0, 0, 0, 4e4, 0, 0]}},
        "modes": {"wrench": {"type": "wrench"}},
        "default_mode": "wrench",
        "afloat": {**BARGE["afloat"], "drift": DRIFT},
    }
    found = own_force(vehicle, 40_000.0, 40_000.0 * 2.6**2, omega, [heading], 20.0)[0, axis]
    row = DRIFT["omega_radps"].index(omega), DRIFT["heading_deg"].index(heading), axis
    whole, own = (np.array(DRIFT[key])[row] for key in ("force", "own"))
    assert found == pytest.approx(whole, abs=0.05 * max(abs(whole), abs(own), abs(whole - own)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"heading_deg": [0, 90]}, "13 x 2 x 3|force must be"),
        ({"heading_deg": [*range(0, 121, 10)]}, "evenly from 0 to 180"),
        ({"omega_radps": DRIFT["omega_radps"][::-1]}, "increase"),
    ],
)
def test_bad_coefficients(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        DriftConfig.model_validate({**DRIFT, **change})


@pytest.mark.parametrize("name", ["wamv", "otter"])
def test_pressure_does_not_push_a_hull_of_the_catalogue_twice(name: str) -> None:
    """What the pressure on the moving hull pushes by itself is measured and taken off: abeam, where a wave is long for
    the hull, it is several times the whole."""
    file = Path(pl.__file__).parent / f"vehicles/catalogue/{name}.bem.json"
    drift = DriftConfig.model_validate(json.loads(file.read_text())["drift"])
    own, whole = np.array(drift.own), np.array(drift.force)
    assert own.shape == whole.shape
    long = np.array(drift.omega_radps) < 4.0
    assert own[long, 6, 1].max() > 2 * whole[long, 6, 1].max() > 0


def test_catalogue_says_what_it_has() -> None:
    with pytest.raises(pl.PelagosError, match=r"surface_vessel.*no drift coefficients.*wamv"):
        pl.Vehicle.from_dict({"type": "surface_vessel", "afloat": {"drift": "surface_vessel"}})
