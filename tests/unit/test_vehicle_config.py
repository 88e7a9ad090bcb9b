"""A vehicle as data: changes, variants, refusals, terms of the user's own."""

from __future__ import annotations

import re

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.errors import CommandError, InputError, LookupFailed, ScenarioError
from pelagos.vehicles.blame import blame
from pelagos.vehicles.shape.parts import ShapePart
from pelagos.vehicles.vehicle import Vehicle


def test_every_number_may_be_changed():
    vehicle = Vehicle.from_catalogue("remus100", mass={"mass_kg": 33.0}, terms={"damping": {"yaw_s": 2.0}})
    assert vehicle.config.body.rigid[0, 0] == 33.0
    assert vehicle.config.terms["damping"].yaw_s == 2.0
    assert vehicle.config.terms["damping"].surge_s == 20


def test_a_term_is_left_out_by_null():
    vehicle = Vehicle.from_catalogue("remus100", terms={"lift_drag": None})
    assert list(vehicle.model.terms) == ["damping", "cross_flow", "restoring"]


def test_variants_are_used_as_a_whole():
    vehicle = Vehicle.from_catalogue("bluerov2_heavy", variant="wu_2018")
    assert vehicle.config.mass.mass_kg == 11.5
    assert vehicle.config.terms["linear_damping"].diagonal[0] == 4.03
    with pytest.raises(ScenarioError, match="did you mean 'wu_2018'"):
        Vehicle.from_catalogue("bluerov2_heavy", variant="wu2018")


@pytest.mark.parametrize("given", [["shallow"], {"shallow": 1}, 3])
def test_a_variant_is_one_name(given):
    with pytest.raises(ScenarioError, match=r"variant: give one name of drift_tests, shallow, sections, not "):
        Vehicle.from_dict({"type": "kvlcc2", "variant": given})
    scenario = {"world": {"type": "flat"}, "agents": {"s": {"vehicle": {"type": "kvlcc2", "variant": given}}}}
    with pytest.raises(ScenarioError, match=r"agents\.s\.vehicle: variant: give one name of drift_tests"):
        pl.Simulation.load(scenario)


def test_a_file_of_a_vehicle_is_told_the_line(tmp_path):
    path = tmp_path / "ship.yaml"
    path.write_text("type: kvlcc2\nterms:\n  roll:\n    draugt_m: 20\nlength_m: -3\n")
    with pytest.raises(ScenarioError) as error:
        Vehicle.from_yaml(path)
    assert f"{path}:4: terms.roll.draugt_m: unknown key 'draugt_m' (did you mean 'draught_m'?)" in str(error.value)
    assert f"{path}:5: length_m: must be greater than 0 [m], not -3" in str(error.value)


def test_a_custom_vehicle_has_no_variant():
    own = Vehicle.from_catalogue("otter").config.model_dump(mode="json") | {"type": "custom", "variant": "fast"}
    with pytest.raises(ScenarioError, match="variant 'fast': vehicles of the catalogue have variants, custom has none"):
        Vehicle.from_dict(own)


def test_an_unknown_key_of_a_changed_part_is_told_the_keys_of_that_part():
    """The part's `type` is the catalogue's, or its variant's, and not written in the change."""
    changed = {"type": "kvlcc2", "variant": "shallow", "terms": {"squat": {"sinkag": 1.0}}}
    words = r"terms\.squat\.sinkag: unknown key 'sinkag' .did you mean 'sinkage'.*; known: type, sinkage, trim"
    with pytest.raises(ScenarioError, match=words):
        Vehicle.from_dict(changed)
    with pytest.raises(ScenarioError, match=words):
        pl.Simulation.load({"world": {"type": "flat"}, "agents": {"s": {"vehicle": changed}}})


NATIVE = {
    "type": "engine_forces", "mass_kg": 16.0, "volume_m3": 0.0165, "inertia_kg_m2": [0.3, 1.2, 1.4],
    "drag_area_m2": 0.06, "damping_1_s": 0.3, "turn_damping_1_s": 0.4, "half_height_m": 0.9,
}  # fmt: skip
FORCE = {"type": "force_thruster", "position_m": [-0.4, 0.1, 0], "direction": [1, 0, 0], "time_constant_s": 0.1}
SQUARE = {**FORCE, "type": "thruster", "forward": 0.01, "reverse": 0.008}
CURVE = {**FORCE, "type": "curve_thruster", "commands": [-1, 0, 1], "thrusts_n": [-20, 0, 30]}
SLIDE, BLADDER = {"type": "moving_mass", "mass_kg": 3, "rate_m_s": 0.1}, {"type": "buoyancy_engine", "rate_m3_s": 1e-5}
FINS = [{"position_m": [-0.7, 0.1, 0.05], "lift": [0.0, 0.6, 0.8]}]
PUSHED = {**NATIVE, "thrusters": [{"position_m": [-0.4, 0.2, 0.1], "direction": [0.8, 0.36, -0.48], "limit_n": 9.0}]}


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("remus100", {"mass": {"mass_kg": -5}}, "mass.*greater than 0"),
        ("bluerov2", {"mass": {"inertia_kg_m2": [0.1, 0.1, 0.9]}}, "triangle inequality"),
        ("bluerov2", {"mass": {"inertia_kg_m2": [0.1, 0.1, -0.1]}}, "must be positive"),
        ("remus100", {"mass": {"center_of_buoyancy_m": [0, 0, -0.5]}}, "centre of buoyancy.*outside the hull"),
        ("remus100", {"mass": {"center_of_gravity_m": [2, 0, 0]}}, "centre of gravity.*outside the hull"),
        ("remus100", {"actuators": {"rudder": {"area_m2": 0}}}, "area_m2.*greater than 0"),
        ("remus100", {"hull": {"fins": [{"angle_deg": 0, "x_m": 0, "span_m": 0, "chord_m": 0.1}]}}, "span_m"),
        ("remus100", {"lenght_m": 2.0}, "lenght_m.*did you mean 'length_m'"),
        ("remus100", {"default_mode": "depth"}, "default_mode 'depth' is none of"),
        ("bluerov2", {"modes": {"m": {**PUSHED, "command": "pose"}}}, "leave out 'thrusters'"),
        ("bluerov2", {"modes": {"m": {**PUSHED, "command": "place"}}}, "two 'thrusters', left and right, not 1"),
        ("bluerov2", {"modes": {"m": {**NATIVE, "command": "pose", "fins": FINS}}}, "'pose' moves no fins"),
        ("remus100", {"actuators": {"rudder": None}}, "uses the actuator 'rudder'"),
        ("bluerov2", {"battery": None}, "need a battery"),
        ("bluerov2", {"added_mass": {"diagonal": [-20, 5, 5, 1, 1, 1]}}, "not positive definite"),
        ("otter", {"actuators": {"left_propeller": {"direction": [0, 0, 0]}}}, "direction must not be 0"),
        ("remus100", {"density_kg_m3": float("nan")}, "density_kg_m3"),
        ("remus100", {"actuators": {"x": {**SQUARE, "low": 40, "high": 40}}}, "low 40 must be below high 40"),
        ("remus100", {"actuators": {"x": {**FORCE, "low_n": 25, "high_n": 25}}}, "low_n 25 must be below high_n 25"),
        ("remus100", {"actuators": {"x": {**FORCE, "low_n": 30, "high_n": 25}}}, "low_n 30 must be below high_n 25"),
        ("remus100", {"actuators": {"x": {**CURVE, "commands": [-1, 1, 1]}}}, "commands must rise from point to point"),
        ("remus100", {"actuators": {"x": {**CURVE, "thrusts_n": [5, 5, 9]}}}, "thrusts_n must rise from point to"),
        ("remus100", {"actuators": {"x": {**SLIDE, "low_m": 0.1, "high_m": -0.1}}}, "low_m 0.1 must be below high_m"),
        (
            "remus100",
            {"actuators": {"x": {**BLADDER, "position_m": [0, 0, 0], "low_m3": 0, "high_m3": 0}}},
            "low_m3 0 must be below high_m3 0",
        ),
        ("remus100", {"actuators": {"x": {"type": "channel", "low": 2, "high": 2}}}, "low 2 must be below high 2"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(name, changes, message):
    with pytest.raises(ScenarioError, match=re.compile(message, re.S)):
        Vehicle.from_catalogue(name, **changes)


def test_an_unknown_vehicle_is_refused_with_the_nearest():
    with pytest.raises(LookupFailed, match="did you mean 'remus100'"):
        Vehicle.from_catalogue("remus10")


def test_yaml_files(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("type: remus100\ndensity_kg_m3: 1000\n")
    assert Vehicle.from_yaml(path).config.density_kg_m3 == 1000
    path.write_text("- 1\n")
    with pytest.raises(ScenarioError, match="mapping"):
        Vehicle.from_yaml(path)
    with pytest.raises(ScenarioError, match="no such file"):
        Vehicle.from_yaml(tmp_path / "none.yaml")


def test_a_strangers_vehicle_runs_no_code_unless_told(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("type: remus100\nterms: {drag: {type: function, target: 'os:getcwd'}}\n")
    with pytest.raises(ScenarioError, match="code that the scenario wants to run"):
        Vehicle.from_yaml(path)


@pytest.mark.parametrize(
    ("argument", "value", "message"),
    [
        ("eta", np.zeros((1, 5)), r"eta must have the shape \(n, 6\)"),
        ("nu", [[np.nan] * 6], "nu has values that are not finite"),
        ("command", np.zeros((3, 3)), "has 3 rows|has 2 rows"),
    ],
)
def test_accelerations_refuse_bad_arrays(argument, value, message):
    arguments = {
        "eta": np.zeros((2, 6)),
        "nu": np.zeros((2, 6)),
        "actuators": np.zeros((2, 3)),
        "command": np.zeros((2, 3)),
    } | {argument: value}
    with pytest.raises(CommandError, match=message):
        Vehicle.from_catalogue("remus100").accelerations(**arguments)


def tether(flow, parameters):
    """A user's own force: a tether that pulls back to the origin with so many newtons a metre."""
    pull = [-parameters["stiffness"] * p for p in flow.position]
    in_body = [sum(flow.rotation[i][j] * pull[i] for i in range(3)) for j in range(3)]
    return [*in_body, 0.0, 0.0, 0.0]


def broken(flow, parameters):
    return [0.0]


def test_a_users_own_force_by_module_and_function():
    term = {"type": "function", "target": f"{__name__}:tether", "parameters": {"stiffness": 5.0}}
    pulled = Vehicle.from_catalogue("remus100", terms={"tether": term})
    free = Vehicle.from_catalogue("remus100")
    eta = [[10.0, 0, 0, 0, 0, 0]]
    zero = [[0.0] * 3]
    more = pulled.accelerations(eta, [[0.0] * 6], zero, zero)[0] - free.accelerations(eta, [[0.0] * 6], zero, zero)[0]
    assert more[0, 0] == pytest.approx(-50.0 * free.model.inertia.inverse[0][0])


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("no_such_module:f", "cannot be loaded"),
        (f"{__name__}:nothing", "cannot be loaded"),
        ("nonsense", "unknown dynamics"),
        (":f", "module:function"),
    ],
)
def test_a_users_force_that_cannot_be_found(target, message):
    with pytest.raises(InputError, match=message):
        Vehicle.from_catalogue("remus100", terms={"mine": {"type": "function", "target": target}})


def test_a_users_force_of_the_wrong_size():
    vehicle = Vehicle.from_catalogue("remus100", terms={"mine": {"type": "function", "target": f"{__name__}:broken"}})
    with pytest.raises(InputError, match="six entries"):
        vehicle.model.terms["mine"].wrench(None)


def test_a_frozen_step_asks_for_its_tables():
    """Arrays made inside a recording would end the process; the step says so instead."""
    rov = Vehicle.from_catalogue("bluerov2")
    state = rov.initial_state(np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]))
    command = [dr.opaque(jit.Float64, 0.1) for _ in rov.command_names("actuators")]
    still = dr.zeros(jit.Array3f64, 1)
    frozen = dr.freeze(lambda s, c, w: rov.step(s, c, None, jit.Float64(0.0), (w, w), 0.01, "actuators"))
    with pytest.raises(RuntimeError) as raised:
        frozen(state, command, still)
    assert isinstance(raised.value.__cause__, CommandError)
    assert "must be handed" in str(raised.value.__cause__)


def test_blame_names_the_largest_term():
    remus = Vehicle.from_catalogue("remus100")
    said = blame(remus, np.zeros(3), np.array([1.0, 0, 0, 0]), np.array([50.0, 0, 0]), np.zeros(3))
    assert said.startswith("largest term: lift_drag")
    said = blame(remus, np.zeros(3), np.array([1.0, 0, 0, 0]), np.array([np.nan, 0, 0]), np.zeros(3))
    assert said.startswith("not finite: ")


def test_the_mirrored_part_is_the_first_ones_image():
    """Each corner of the second box is that of the first with y reversed, also where it is turned about all axes."""
    part = ShapePart(
        type="box", size_m=(0.8, 0.3, 0.2), position_m=(0.4, 0.6, -0.1), turn_deg=(20.0, -35.0, 50.0), mirror=True
    )
    first, second = (np.round(mesh.vertices, 9) for mesh in part.meshes())
    image = {tuple(corner) for corner in np.round(first * [1, -1, 1], 9).tolist()}
    assert {tuple(corner) for corner in second.tolist()} == image
    assert len(image) == 8
    assert len(part.model_copy(update={"mirror": False}).meshes()) == 1
