"""What vehicles refuse, and branches that few of them take."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from pydantic import ValidationError

from pelagos import jit
from pelagos.errors import InputError, LookupFailed, ScenarioError
from pelagos.hydro.algebra import norm
from pelagos.vehicles.actuators.ship import ShipRudderConfig
from pelagos.vehicles.actuators.third_order import VON_BENZON, Modes, ThirdOrder
from pelagos.vehicles.afloat_config import AfloatConfig, RadiationConfig
from pelagos.vehicles.cargo import Cargo
from pelagos.vehicles.control.overheard import Overheard
from pelagos.vehicles.envelope import EnvelopeConfig
from pelagos.vehicles.load import catalogue_data, catalogue_names
from pelagos.vehicles.nearby import planes_of
from pelagos.vehicles.page import _missions, main
from pelagos.vehicles.shape.floating_mesh import float_mesh, wet_part
from pelagos.vehicles.terms.damping import QuadraticDampingConfig
from pelagos.vehicles.terms.floating import FloatingDamping
from pelagos.vehicles.varied import varied
from pelagos.vehicles.vehicle import Vehicle
from pelagos.vehicles.wetness import Place

ENGINE = {
    "type": "engine_forces", "mass_kg": 16.0, "volume_m3": 0.0165, "inertia_kg_m2": [0.3, 1.2, 1.4],
    "drag_area_m2": 0.06, "damping_1_s": 0.3, "turn_damping_1_s": 0.4, "half_height_m": 0.9, "command": "pose",
}  # fmt: skip
TANK = {
    "type": "compartment",
    "size_m": [0.1, 0.1, 0.1],
    "position_m": [0.1, 0, 0],
    "hole_m": [0.1, 0, 0.05],
    "orifice_m2": 1e-4,
}
ROLL = {"type": "roll_damping", "draught_m": 0.2, "gravity_depth_m": 0.01, "block": 0.6, "midship": 0.95}
MATRIX = np.eye(6) + np.diag([0, 0, 0, 0, 0.1], 1)


@pytest.mark.parametrize(("name", "changes", "said"), [
    ("bluerov2", {"added_mass": {"type": "matrix", "matrix": MATRIX.tolist()}},
     r"added mass matrix must be symmetric \(or measured: true\)"),
    ("remus100", {"diameter_m": None}, "give diameter_m, or beam_m and height_m"),
    ("remus100", {"diameter_m": None, "beam_m": 0.2}, "give diameter_m, or beam_m and height_m"),
    ("quadrotor", {"actuators": {"tank": TANK}},
     r"actuators\.tank: a compartment floods in water; this vehicle's medium is air"),
    ("remus100", {"envelope": {"cruise_mps": 2.6, "top_mps": 2.5}}, r"cruise_mps 2\.6 must not be above top_mps 2\.5"),
    ("bluerov2", {"modes": {"m": {**ENGINE, "inertia_products_kg_m2": [0.7, 0, 0]}}},
     r"inertia_products_kg_m2 \(0\.7, 0\.0, 0\.0\) are too great for the moments"),
    ("bluerov2", {"terms": {"roll": ROLL}},
     "roll_damping is for hulls that float: no term gives this one a stiffness in roll"),
])  # fmt: skip
def test_vehicles_that_cannot_be_are_refused(name, changes, said):
    with pytest.raises((ScenarioError, InputError), match=re.compile(said, re.S)):
        Vehicle.from_catalogue(name, **changes)


def test_what_is_just_possible_is_taken():
    Vehicle.from_catalogue("remus100", diameter_m=None, beam_m=0.2, height_m=0.2)
    assert EnvelopeConfig(cruise_mps=2.5, top_mps=2.5).top_mps == 2.5
    Vehicle.from_catalogue("bluerov2", modes={"m": {**ENGINE, "inertia_products_kg_m2": [0.59, 0, 0]}})
    assert Vehicle.from_catalogue("remus100", actuators={"tank": TANK}).config.medium == "water"


@pytest.mark.parametrize(("name", "known"), [
    ("Xuu", True), ("Nd", True), ("Y0", True), ("X", False), ("Zu", False), ("Xw", False), ("Xu2", False), ("", False),
])  # fmt: skip
def test_derivatives_of_a_rudder_have_names(name, known):
    given = {"type": "ship_rudder", "derivatives": {name: 1.0}, "limit_deg": 35, "rate_deg_s": 2}
    given = {key: value for key, value in given.items() if key == "type" or key in ShipRudderConfig.model_fields}
    needed = {n for n, f in ShipRudderConfig.model_fields.items() if f.is_required()} - given.keys()
    given |= dict.fromkeys(needed, 10.0)
    if known:
        assert ShipRudderConfig(**given).derivatives == {name: 1.0}
    else:
        said = f"derivative '{name}' must be X, Y or N and then letters of u, v, r, d .or 0."
        with pytest.raises(ValidationError, match=said):
            ShipRudderConfig(**given)


def radiation(n: int = 4, **changes) -> RadiationConfig:
    whole = {"source": "a", "omega_radps": [0.2 * k + 0.1 for k in range(n)], "added_mass_infinite": np.eye(6).tolist(),
             "damping": np.zeros((n, 6, 6)).tolist()}  # fmt: skip
    return RadiationConfig(**{**whole, **changes})


@pytest.mark.parametrize(("changes", "said"), [
    ({"added_mass_infinite": np.eye(5).tolist()}, "added_mass_infinite must be 6 x 6 and damping 4 x 6 x 6, one"),
    ({"damping": np.zeros((3, 6, 6)).tolist()}, "added_mass_infinite must be 6 x 6 and damping 4 x 6 x 6"),
    ({"omega_radps": [0.1, 0.3, 0.3, 0.5]}, "omega_radps must increase"),
])  # fmt: skip
def test_coefficients_of_a_panel_method_have_their_shapes(changes, said):
    assert len(radiation().damping) == 4
    with pytest.raises(ValidationError, match=said):
        radiation(**changes)


@pytest.mark.parametrize(("key", "said"), [
    ("radiation", r"radiation 'marinr' is none of .*mariner.*\(did you mean 'mariner'\?\)"),
    ("drift", r"drift 'marinr' is none of .*mariner.*\(did you mean 'mariner'\?\)"),
])  # fmt: skip
def test_coefficients_of_the_catalogue_are_known_by_name(key, said):
    hull = {"length_m": 160.0, "beam_m": 23.0, "freeboard_m": 6.0}
    with pytest.raises(ValidationError, match=said):
        AfloatConfig(hulls=[hull], **{key: "marinr"})
    AfloatConfig(hulls=[hull], radiation="mariner")


def test_a_vehicle_of_the_catalogue_is_known_by_name():
    with pytest.raises(LookupFailed, match=r"unknown vehicle 'remus10' .did you mean 'remus100'"):
        catalogue_data("remus10")
    assert catalogue_data("remus100")["type"] == "remus100"


@pytest.mark.parametrize(("keys", "said"), [
    ({"size_m": (1, 1, 1)}, "size_m and center_m are those of a frame: give oblique: frame"),
    ({"center_m": (0, 0, 0.1)}, "size_m and center_m are those of a frame"),
    ({"oblique": "frame", "diagonal": (1, -2, 3, 0, 0, 0)}, "a frame's drag is 0 or more on each axis, not -2"),
    ({"oblique": "axes", "diagonal": (1, -2, 3, 0, 0, 0)}, ""),
    ({"oblique": "frame", "diagonal": (1, 0, 3, 0, 0, 0), "size_m": (1, 1, 1), "center_m": (0, 0, 0.1)}, ""),
])  # fmt: skip
def test_keys_of_a_frames_drag_are_those_of_a_frame(keys, said):
    given = {"type": "quadratic_damping", "diagonal": (1, 2, 3, 0, 0, 0), **keys}
    if said:
        with pytest.raises(ValidationError, match=said):
            QuadraticDampingConfig(**given)
    else:
        QuadraticDampingConfig(**given)


NUMBER = 3.0


def test_a_term_of_ones_own_is_a_function():
    with pytest.raises(InputError, match=f"the term '{__name__}:NUMBER' is not a function"):
        Vehicle.from_catalogue("remus100", terms={"mine": {"type": "function", "target": f"{__name__}:NUMBER"}})


def test_a_mesh_afloat_has_no_more_triangles_than_a_step_can_sum(tmp_path, monkeypatch):
    trimesh.creation.box((4.0, 2.0, 1.0)).export(tmp_path / "hull.stl")
    monkeypatch.setattr("pelagos.vehicles.shape.floating_mesh._MOST", 12)
    float_mesh(tmp_path / "hull.stl", 3.0)
    monkeypatch.setattr("pelagos.vehicles.shape.floating_mesh._MOST", 11)
    said = r"afloat\.mesh: .*hull\.stl has 12 triangles, more than 11; simplify it, the waves are longer"
    with pytest.raises(ScenarioError, match=said):
        float_mesh(tmp_path / "hull.stl", 3.0)


def test_a_mesh_in_the_air_displaces_nothing():
    box = trimesh.creation.box((4.0, 2.0, 1.0))
    for level, volume, middle in ((-0.5, 0.0, -0.5), (-0.2, 2.4, -0.35), (0.7, 8.0, 0.0)):
        found, centre = wet_part(np.array(box.vertices), np.array(box.faces), level)
        assert found == pytest.approx(volume)
        np.testing.assert_allclose(centre, [0, 0, middle], atol=1e-12)


def test_what_is_carried_floats_as_the_water_is_heavy():
    down = [0.0, 0.6, 0.8]
    cargo = Cargo(5.0, 2.0, [0.3, -0.2, 0.1], [[0.0] * 3] * 3)
    for heaviness, weight in ((None, 3.0), (1.025, 5 - 2 * 1.025)):
        flow = SimpleNamespace(wet=None, heaviness=heaviness, down=down)
        load = np.array([np.ravel(np.array(x))[0] for x in cargo.wrench(9.81, flow)], float)
        force = 9.81 * weight * np.array(down)
        np.testing.assert_allclose(load, [*force, *np.cross([0.3, -0.2, 0.1], force)], atol=1e-12)


def test_added_floating_damping_has_a_quadratic_part_where_there_is_one():
    nu = [0.5, -0.3, 0.2, 0.1, -0.2, 0.4]
    matrix = np.diag([1.0, 2, 3, 4, 5, 6]).tolist()
    load = lambda yaw: np.array(FloatingDamping(matrix, yaw).wrench(SimpleNamespace(nu_r=nu)), float)
    np.testing.assert_allclose(load(0.0), -np.arange(1, 7) * nu)
    np.testing.assert_allclose(load(7.0) - load(0.0), [0, 0, 0, 0, 0, -7 * 0.4 * 0.4], atol=1e-12)


def test_the_slowest_mode_is_real_or_oscillates():
    """The response to a step, 1 - |e^(p t)| after one time constant of its slowest mode."""
    modes = Modes.of(*VON_BENZON)
    assert ThirdOrder(modes, -1.0, 1.0).time_constant == pytest.approx(-1 / np.roots(VON_BENZON[1]).real.max())
    swinging = Modes.of((1.0,), tuple(np.poly([-5.0, -0.5 + 2j, -0.5 - 2j]).real))
    assert ThirdOrder(swinging, -1.0, 1.0).time_constant == pytest.approx(2.0)


def test_a_curve_thruster_says_its_thrust():
    curve = {"type": "curve_thruster", "position_m": [-0.4, 0.1, 0], "direction": [1, 0, 0], "time_constant_s": 0.1,
             "commands": [-1, 0, 1], "thrusts_n": [-20, 0, 30]}  # fmt: skip
    part = Vehicle.from_catalogue("remus100", actuators={"x": curve}).model.actuators["x"]
    assert part.thrust_limits == pytest.approx((-20, 30), rel=1e-3)
    found = np.array(part.thrust(jit.Float64([-0.5, 0.0, 0.5]), None))
    assert found == pytest.approx([-10, 0, 15], abs=0.3)


def test_a_heavier_body_turns_as_one_of_that_mass_and_inertia():
    """Whose Coriolis forces are those of the angular momentum alone."""
    heavy = {"mass_kg": 1.3 * 13.5, "inertia_kg_m2": [1.3 * 0.26, 1.3 * 0.23, 1.3 * 0.37]}
    light = Vehicle.from_catalogue("bluerov2_heavy", coriolis={"rigid": "angular"})
    expected = Vehicle.from_catalogue("bluerov2_heavy", coriolis={"rigid": "angular"}, mass=heavy).model.inertia.angular
    found = varied(light, {"mass": 1.3}).model.inertia.angular
    assert found is not None
    for a, b, before in zip(found, expected, light.model.inertia.angular, strict=True):
        np.testing.assert_allclose(np.array(a, float), np.array(b, float), atol=1e-12)
        assert before is not None


def test_accelerations_keep_few_recordings(monkeypatch):
    monkeypatch.setattr("pelagos.vehicles.books._KEPT", 1)
    vehicle = Vehicle.from_catalogue("remus100")
    rows = lambda n: [np.zeros((n, 6)), np.full((n, 6), 0.3), np.zeros((n, 3)), np.zeros((n, 3))]
    first = vehicle.accelerations(*rows(1))[0]
    for n in (2, 1, 3):
        np.testing.assert_allclose(vehicle.accelerations(*rows(n))[0], np.repeat(first, n, axis=0), rtol=1e-9)


def test_no_walls_are_no_planes():
    identity = np.eye(3).tolist()
    assert planes_of(None, [0.0, 0.0, 3.0], identity) == []
    walls = SimpleNamespace(points=[[2.0, 0.0, 0.0]], normals=[[-1.0, 0.0, 0.0]])
    (plane,) = planes_of(walls, [0.5, 0.0, 3.0], identity)
    assert float(np.ravel(np.array(plane.distance))[0]) == pytest.approx(1.5)


def test_a_mode_that_is_overheard_is_as_it_was():
    mode = SimpleNamespace(commands=("a", "b"), memory=3)
    heard = Overheard(mode, ("x",))
    assert (heard.commands, heard.memory) == (("a", "b"), 3)


def test_a_propellers_share_is_that_at_its_depth():
    flow = SimpleNamespace(wet=object(), immersion=jit.Float64([-1.0, 0.05, 3.0]), down=[0.0, 0.0, 1.0])
    place = Place("propeller", (0.0, 0.0, 0.1), 0.2)
    found = np.array(place.share(flow))
    np.testing.assert_array_equal(found, np.array(place.share_at(flow.immersion, flow.down)))
    assert found[0] == 0
    assert 0 < found[1] < 1
    assert found[2] == 1
    assert replace(place, keeps="always").share(flow) == 1


def test_pages_of_all_vehicles_are_written(tmp_path, monkeypatch):
    monkeypatch.setattr("pelagos.vehicles.page.page", lambda name: f"# {name}\n")
    main(str(tmp_path))
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {f"{n}.md": f"# {n}\n" for n in catalogue_names()}
    monkeypatch.setattr("pelagos.vehicles.page.mission_mode", lambda points: None)
    assert _missions(Vehicle.from_catalogue("remus100")) == ""


def test_lengths_of_numbers_and_of_arrays():
    assert norm([3.0, -4.0, 12.0]) == 13.0
    np.testing.assert_allclose(np.array(norm([jit.Float64([3.0, 0.0]), -4.0 * jit.Float64([1.0, 0.0]), 0.0])), [5, 0])
