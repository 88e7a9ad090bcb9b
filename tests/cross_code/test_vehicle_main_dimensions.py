"""Ships by their main dimensions alone: Clarke's regression as MSS computes it, and beside captive tests."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_vehicle_mss import table

import pelagos as pl
from pelagos.errors import ScenarioError
from pelagos.hydro.clarke import MainDimensions, clarke_derivatives

RHO = 1025.0


def ship(length: float, beam: float, draught: float, block: float, **changes: Any) -> dict[str, Any]:
    """A ship of these dimensions, with radius of gyration R66 and centre of gravity xg."""
    mass = RHO * length * beam * draught * block
    gyration, xg = changes.pop("R66", 0.25 * length), changes.pop("xg", 0.0)
    return {
        "type": "custom", "length_m": length, "beam_m": beam, "height_m": 1.6 * draught, "density_kg_m3": RHO,
        "mass": {
            "type": "explicit", "mass_kg": mass, "center_of_gravity_m": [xg, 0, 0],
            "inertia_kg_m2": [mass * (0.35 * beam) ** 2, mass * gyration**2, mass * gyration**2],
        },
        "added_mass": {
            "type": "clarke", "draught_m": draught, "heave_kg": mass, "roll_kg_m2": 0.02 * mass * beam**2,
            "pitch_kg_m2": 0.05 * mass * length**2,
        },
        "coriolis": {"added": "none"},
        "terms": {
            "hydrostatics": {
                "type": "hydrostatic", "heave_n_m": 7e3 * length * beam, "roll_n_m": mass, "pitch_n_m": 40 * mass,
            },
            "hull": {"type": "clarke", "draught_m": draught},
        },
        "default_mode": "actuators", "modes": {"actuators": {"type": "actuators"}}, **changes,
    }  # fmt: skip


def test_matrices_are_those_of_mss():
    """M, and N by the change of forces with a small drift and a small rate about a straight course (U - u: 1e-13).

    MSS's N is without the rigid body's m U r and m xg U r.
    """
    t = table("clarke83")
    for row in (dict(zip(t, values, strict=True)) for values in zip(*t.values(), strict=True)):
        form = {name: row[key] for name, key in (("length", "L"), ("beam", "B"), ("draught", "T"), ("block", "Cb"))}
        vehicle = pl.Vehicle.from_dict(ship(**form, R66=row["R66"], xg=row["xg"]))
        m, axes = vehicle.config.body.mass_matrix, np.ix_([1, 5], [1, 5])
        assert m[0, 0] == pytest.approx(row["M11"], rel=1e-12)
        assert m[axes] == pytest.approx(np.array([[row["M22"], row["M23"]], [row["M32"], row["M33"]]]), rel=1e-12)
        nu = np.array([[row["U"], 1e-6, 0, 0, 0, 0], [row["U"], 0, 0, 0, 0, -1e-8]])
        force = m @ vehicle.accelerations(np.zeros((2, 6)), nu, np.zeros((2, 0)), np.zeros((2, 0)))[0].T
        rigid = vehicle.config.body.rigid[0, 0] * row["U"] * np.array([[0, 1], [0, row["xg"]]])
        found = -force[[1, 5]] / [1e-6, -1e-8] - rigid
        assert found == pytest.approx(np.array([[row["N22"], row["N23"]], [row["N32"], row["N33"]]]), rel=1e-9)


@pytest.mark.parametrize("ahead", [5.0, -4.0])
def test_drift_and_rate_turn_round_as_they_must(ahead):
    """Both signs, and astern: sway and rate are damped, u r and u v change their sign with u; m r is the body's."""
    vehicle = pl.Vehicle.from_dict(ship(100.0, 20.0, 8.0, 0.7))
    found = clarke_derivatives(MainDimensions(100.0, 20.0, 8.0, 11200.0))
    v, r = -0.8, 0.01
    speed, scale = np.hypot(ahead, v), 0.5 * RHO * 100.0**2
    got = vehicle.accelerations([[0] * 6], [[ahead, v, 0, 0, 0, r]], [[]], [[]])[0][0]
    force = vehicle.config.body.mass_matrix @ got
    side = scale * (found.y_v * speed * v + found.y_r * 100 * ahead * r) - RHO * 11200.0 * ahead * r
    turn = scale * 100 * (found.n_v * ahead * v + found.n_r * 100 * speed * r)
    assert force[[1, 5]] == pytest.approx([side, turn], rel=1e-9)
    assert force[[0, 3]] == pytest.approx([RHO * 11200.0 * v * r, 0], abs=1e-3)
    assert found.y_v < 0
    assert found.n_r < 0


def test_a_ship_keeps_its_course_or_not_as_its_derivatives_say():
    """Eigenvalues of sway and yaw straight ahead, with the rigid body's own m U r and m xG U r, which MSS's N lacks."""
    speed, xg, form = 7.0, 4.0, MainDimensions(200.0, 32.0, 11.0, 0.78 * 200 * 32 * 11)
    vehicle = pl.Vehicle.from_dict(ship(200.0, 32.0, 11.0, 0.78, xg=xg, coriolis={"added": "none"}))
    found, m, scale = clarke_derivatives(form), RHO * form.volume, 0.5 * RHO * 200.0**2 * speed
    damping = np.array([
        [-scale * found.y_v, m * speed - scale * 200 * found.y_r],
        [-scale * 200 * found.n_v, m * xg * speed - scale * 200**2 * found.n_r],
    ])  # fmt: skip
    mass = vehicle.config.body.mass_matrix[np.ix_([1, 5], [1, 5])]
    nu = np.array([[speed, s * v, 0, 0, 0, s * r] for v, r in ((1e-4, 0.0), (0.0, 1e-7)) for s in (1, -1)])
    a = vehicle.accelerations(np.zeros((4, 6)), nu, np.zeros((4, 0)), np.zeros((4, 0)))[0][:, [1, 5]]
    measured = np.stack([(a[0] - a[1]) / 2e-4, (a[2] - a[3]) / 2e-7], axis=-1)
    roots = [np.sort(np.linalg.eigvals(x)) for x in (measured, -np.linalg.solve(mass, damping))]
    assert roots[0] == pytest.approx(roots[1], rel=1e-6)
    assert roots[1][0] < 0 < roots[1][1]  # a full form without a skeg: unstable on its course


CAPTIVE = {
    # KVLCC2: Yasukawa and Yoshimura 2015, by rho/2 L d; Mariner: Chislett and Stroem-Tejsen 1965, less the mass's part
    "kvlcc2": (
        MainDimensions(320.0, 58.0, 20.8, 312600.0),
        {"y_vdot": -0.0145, "n_rdot": -0.00072, "y_v": -0.0205, "y_r": 0.0054, "n_v": -0.0089, "n_r": -0.0032},
        0.25,
    ),
    "mariner": (
        MainDimensions(160.93, 23.17, 8.2, 16630.0),
        {"y_vdot": -0.00748, "n_rdot": -0.000438, "y_v": -0.0116, "y_r": 0.00299, "n_r": -0.00184},
        0.25,
    ),
}


@pytest.mark.parametrize("name", CAPTIVE)
def test_captive_tests_are_met_within_a_quarter(name):
    form, measured, most = CAPTIVE[name]
    found = clarke_derivatives(form)
    for key, value in measured.items():
        assert getattr(found, key) == pytest.approx(value, rel=most), key


def test_forms_beyond_the_regression_are_refused():
    for dimensions, said in (
        ((100.0, 25.0, 8.0, 0.7), r"length over beam is 4; the regression of Clarke 1983 is for 4\.5 to 9"),
        ((100.0, 16.0, 3.0, 0.7), r"beam over draught is 5\.33; the regression of Clarke 1983 is for 2 to 4"),
        ((100.0, 16.0, 6.0, 0.4), r"block coefficient is 0\.4; the regression of Clarke 1983 is for 0\.5 to 0\.85"),
    ):
        with pytest.raises(ScenarioError, match=said):
            pl.Vehicle.from_dict(ship(*dimensions))
        plain = {"type": "diagonal", "diagonal": [1e5] * 6}
        with pytest.raises(ScenarioError, match=f"clarke: {said}"):
            _ = pl.Vehicle.from_dict(ship(*dimensions, added_mass=plain)).model
    with pytest.raises(ScenarioError, match=r"'hull' are without the rigid body's .*\{rigid: momentum, added: none\}"):
        pl.Vehicle.from_dict(ship(160, 25, 8, 0.7, coriolis={"rigid": "none", "added": "none"}))
    twice = {**ship(160, 25, 8, 0.7)["terms"], "again": {"type": "clarke", "draught_m": 8}}
    with pytest.raises(ScenarioError, match="terms hull and again are both of type clarke: a hull has one side force"):
        pl.Vehicle.from_dict(ship(160, 25, 8, 0.7, terms=twice))
    with pytest.raises(ScenarioError, match="'hull' contain the Coriolis forces of the added mass"):
        pl.Vehicle.from_dict(ship(100.0, 16.0, 6.0, 0.7, coriolis={"rigid": "momentum"}))
    other = ship(100.0, 16.0, 6.0, 0.7)
    other["added_mass"]["draught_m"] = 6.5
    with pytest.raises(ScenarioError, match=r"'hull' has draught_m 6 and added_mass 6\.5: a ship has one draught"):
        pl.Vehicle.from_dict(other)
    sunk = ship(100.0, 16.0, 6.0, 0.7) | {"terms": {"hull": {"type": "clarke", "draught_m": 6}}}
    with pytest.raises(ScenarioError, match="no term makes this vehicle float"):
        _ = pl.Vehicle.from_dict(sunk).model
