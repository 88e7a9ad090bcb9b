"""Vessels against the accelerations that Fossen's MSS toolbox gives for them, row by row.

Gate 1e-9 relative: both sides are sums of some dozen products in double precision; a sum that cancels is compared on
its column's scale. The tanker's rudder angle there is positive to port; revolutions there are by the minute.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pelagos import Vehicle

DATA = Path(__file__).parent / "data" / "mss"


def table(name: str) -> dict[str, np.ndarray]:
    head, *lines = (DATA / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    rows = np.array([[float(x) for x in line.split(",")] for line in lines])
    return dict(zip(head.split(","), rows.T, strict=True))


def stack(t: dict[str, np.ndarray], *names: str) -> np.ndarray:
    """Columns by name; "0" is a column of zeros, "-x" the negative of x."""
    zero = np.zeros(len(next(iter(t.values()))))
    return np.stack([zero if n == "0" else -t[n[1:]] if n[0] == "-" else t[n] for n in names], axis=-1)


def worst(got: np.ndarray, expected: np.ndarray) -> float:
    """Largest error, relative to each value, but to no less than 1e-3 of its column's largest."""
    scale = np.maximum(np.abs(expected), 1e-3 * np.abs(expected).max(axis=0))
    return float((np.abs(got - expected) / np.maximum(scale, 1e-30)).max())


def test_tanker_in_deep_and_shallow_water():
    """Depths of 22.5 m to deep: with 4 m of water under the keel z = 4.6, and the sway force of its own is at work."""
    t = table("tanker")
    t |= {name: t[name] / 60 for name in ("rpm", "rpm_c", "drpm")}
    assert set(t["depth"]) == {1e12, 60, 40, 26, 22.5}
    for depth in set(t["depth"]):
        rows = {name: values[t["depth"] == depth] for name, values in t.items()}
        water = {} if depth > 1e11 else {"added_mass": {"water_depth_m": depth}}
        ship = Vehicle.from_catalogue("tanker", **water)
        nu = stack(rows, "u", "v", "0", "0", "0", "r")
        got, rates = ship.accelerations(
            np.zeros((len(nu), 6)), nu, stack(rows, "-delta", "rpm"), stack(rows, "-delta_c", "rpm_c")
        )
        assert worst(got[:, [0, 1, 5]], stack(rows, "du", "dv", "dr")) < 1e-9
        assert worst(rates, stack(rows, "-ddelta", "drpm")) < 1e-9


def test_tanker_makes_sixteen_knots_at_eighty_revolutions():
    """Fossen 1994, Appendix E.1.3: design speed 8.23 m/s at 80 rpm; resistance and thrust meet there within 0.1 %."""
    ship = Vehicle.from_catalogue("tanker")
    u = np.array([8.21, 8.25])
    nu = np.stack([u, *np.zeros((5, 2))], axis=-1)
    helm = [[0.0, 80 / 60]]
    surge = ship.accelerations(np.zeros((1, 6)), nu, helm, helm)[0][:, 0]
    assert surge[0] > 0 > surge[1]


def test_water_above_the_keel_is_refused():
    from pelagos.errors import ScenarioError

    with pytest.raises(ScenarioError, match=r"water_depth_m 18 must be more than draught_m 18\.46"):
        Vehicle.from_catalogue("tanker", added_mass={"water_depth_m": 18.0})


def test_container_ship_with_heel():
    """Surge, sway, yaw and roll; of pitch and heave, which MSS has not, nothing comes back into them in one instant."""
    t = table("container")
    t |= {name: t[name] / 60 for name in ("rpm", "rpm_c", "drpm")}
    ship = Vehicle.from_catalogue("container")
    eta, nu = stack(t, "0", "0", "0", "phi", "0", "0"), stack(t, "u", "v", "0", "p", "0", "r")
    got, rates = ship.accelerations(eta, nu, stack(t, "delta", "rpm"), stack(t, "delta_c", "rpm_c"))
    assert worst(got[:, [0, 1, 5, 3]], stack(t, "du", "dv", "dr", "dp")) < 1e-9
    assert worst(rates, stack(t, "ddelta", "drpm")) < 1e-9
    assert (t["rpm"] / 0.3 < 1).any()  # both branches of the engine's time constant


def test_naval_vessel_with_heel():
    """Hull alone, ahead and astern, engines stopped; held in heave and pitch, which MSS has not.

    MSS's Nbauv multiplies phi |u phi|, where Ybauv and Kbauv, and its name, say phi |u v|.
    """
    t = table("navalvessel")
    ship = Vehicle.from_catalogue("navalvessel")
    assert (t["u"] < 0).any()
    idle = np.zeros((len(t["u"]), 2))
    got = ship.accelerations(stack(t, "0", "0", "0", "phi", "0", "0"), stack(t, *"uv0p0r"), idle, idle)[0]
    axes = np.ix_([0, 1, 3, 5], [0, 1, 3, 5])
    m = ship.config.body.mass_matrix
    force = (m @ got.T)[[0, 1, 3, 5]]
    lacks = -214000 * t["phi"] * (np.abs(t["u"] * t["v"]) - np.abs(t["u"] * t["phi"]))
    held = np.linalg.solve(m[axes], force - np.outer([0, 0, 0, 1], lacks)).T
    assert worst(held, stack(t, "du", "dv", "dp", "dr")) < 1e-9
    assert np.abs(lacks).max() > 1e4


def test_naval_vessel_keeps_its_nominal_speed_and_heels_outwards():
    """MSS: U_nom 8 m/s; two rudders of 1.5 m^2, CL 0.054 a degree, 23.79 m aft of the origin and 1.55 m below it."""
    ship = Vehicle.from_catalogue("navalvessel")
    still, m = np.zeros((1, 6)), ship.config.body.mass_matrix
    turns = [[0.0, 6.444]]
    surge = [ship.accelerations(still, [[u, 0, 0, 0, 0, 0]], turns, turns)[0][0, 0] for u in (7.98, 8.02)]
    assert surge[0] > 0 > surge[1]
    small = np.radians(1.0)
    nu = [[8.0, 0, 0, 0, 0, 0]]
    ahead, turned = (m @ ship.accelerations(still, nu, a, a)[0][0] for a in ([[0.0, 6.444]], [[small, 6.444]]))
    lift = 0.5 * 1014 * 3.0 * 0.054 * 64  # at 1 degree
    assert (turned - ahead)[[1, 3, 5]] == pytest.approx([-lift, 1.55 * lift, 23.79 * lift], rel=1e-3)


def test_naval_vessels_rudders_fall_below_the_published_slope():
    """3.094 sin cos: 2 % below 0.054 a degree at 10 deg and 10 % at 23 deg, either side; none astern."""
    ship = Vehicle.from_catalogue("navalvessel")
    helm = np.array([0.0, 10.0, -10.0, 23.0, -23.0])
    states = np.stack([np.radians(helm), np.full(5, 6.444)], axis=1)
    for ahead, short in ((8.0, [0.02, 0.02, 0.104, 0.104]), (-2.0, [1.0] * 4)):
        nu = np.tile([ahead, 0.0, 0.0, 0.0, 0.0, 0.0], (5, 1))
        side = (ship.accelerations(np.zeros((5, 6)), nu, states, states)[0] @ ship.config.body.mass_matrix.T)[:, 1]
        lift = -0.5 * 1014 * 3.0 * ahead**2 * 0.054 * helm[1:]
        assert 1 - (side[1:] - side[0]) / lift == pytest.approx(short, abs=3e-3)


def corrected(t: dict[str, np.ndarray], mass: float, ix: float, iz: float, zg: float) -> np.ndarray:
    """Heave force [N] and pitch moment [N m] that MSS's npsauv lacks to be the rigid body and the strips of its paper.

    Its rigid body's m (v p - u q - zG (p^2 + q^2)) in heave and (Iz - Ix) p r in pitch have the other sign, as M_RB and
    the energy of a free body say; its strips pitch with w + x q, where they heave with w - x q.
    """
    u, v, w, p, q, r = (t[k] for k in "uvwpqr")
    heave = -2 * mass * (v * p - u * q - zg * (p * p + q * q))
    pitch = 2 * (iz - ix) * p * r
    for x in np.linspace(-2.65, 2.65, 11):
        a, c = v + x * r, w - x * q
        drag = 512.5 * 0.53 * 0.53 * (0.5 * a**2 + 0.6 * c**2) / (np.hypot(a, c) + 1e-6)
        pitch = pitch + x * drag * (c + (w + x * q))
    return np.stack([0 * u, 0 * u, heave, 0 * u, pitch, 0 * u], axis=-1)


def test_npsauv_in_six_degrees_of_freedom():
    """All derivatives, four planes, the race and cross-flow, at once; where MSS errs, by what it lacks.

    MSS adds 1e-10 to the speed and to sqrt(C_t1 + 1) - 1 = 0.055: 2e-9 of the race, and of drag, 20 times the surge.
    """
    t = table("npsauv")
    auv = Vehicle.from_catalogue("npsauv")
    eta = stack(t, "0", "0", "0", "phi", "theta", "psi")
    states = ("delta_r", "delta_s", "delta_bp", "delta_bs", "rpm")
    got, rates = auv.accelerations(
        eta, stack(t, *"uvwpqr"), stack(t, *states), stack(t, *(f"{name}_c" for name in states))
    )
    m = auv.config.body.mass_matrix
    lacks = corrected(t, 53400 / 9.81, 2038.0, 13587.0, 0.061)
    expected = stack(t, *(f"d{k}" for k in "uvwpqr")) + np.linalg.solve(m, lacks.T).T
    assert worst(got, expected) < 5e-8
    assert worst(rates, stack(t, *(f"d{name}" for name in states))) < 1e-9


def fastest_growth(name: str, speed: float, states: list[float], water: dict[str, float]) -> float:
    """Largest real part of the eigenvalues of sway and yaw straight ahead [1/s], by central differences."""
    ship = Vehicle.from_catalogue(name, **({"added_mass": water} if water else {}))
    steps = np.array([1e-4, 1e-7])
    nu = np.tile([speed, 0, 0, 0, 0, 0], (4, 1)).astype(float)
    nu[:2, 1], nu[2:, 5] = [steps[0], -steps[0]], [steps[1], -steps[1]]
    a = ship.accelerations(np.zeros((1, 6)), nu, [states], [states])[0][:, [1, 5]]
    return float(np.linalg.eigvals(np.stack([a[0] - a[1], a[2] - a[3]]).T / (2 * steps)).real.max())


def test_the_loaded_tanker_is_unstable_on_its_course():
    """Clarke, Patterson, Wooderson, Trans. RINA 115:89 (1973): trials of this class, the Esso Bernicia of 193 000 dwt,
    found it unstable on its course when loaded, in deep water. With 1.5 m under the keel the terms in z steady it.
    """
    assert 0 < fastest_growth("tanker", 8.23, [0.0, 80 / 60], {}) < 0.01
    assert fastest_growth("tanker", 8.23, [0.0, 80 / 60], {"water_depth_m": 20.0}) < 0


@pytest.mark.slow  # 30 s
@pytest.mark.parametrize(
    ("name", "advance", "diameter"),
    [("tanker", 3.25, 3.12), ("container", 3.24, 4.17), ("frigate", 2.62, 2.78), ("navalvessel", 3.41, 5.09)],
)
def test_turning_circles(name, advance, diameter):
    """As the page on manoeuvres has them: within IMO's limits, and at them for the naval vessel, at 23 deg of helm."""
    from pelagos.manoeuvres import run_manoeuvre

    found = {m.name: m.value for m in run_manoeuvre({"type": name}, "turning").measures}
    assert found["advance"] == pytest.approx(advance, abs=0.03)
    assert found["tactical diameter"] == pytest.approx(diameter, abs=0.03)
    assert found["advance"] < 4.5
    assert found["tactical diameter"] < 5.1
