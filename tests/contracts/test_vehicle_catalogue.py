"""Every vehicle of the catalogue keeps the catalogue's promises, from the day it is added."""

from __future__ import annotations

import re
import sys
from importlib.resources import files
from pathlib import Path

import drjit as dr
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "verification"))
from vehicle_flight import Still, fly

from pelagos import jit
from pelagos.hydro.algebra import Array
from pelagos.vehicles.config import VehicleConfig
from pelagos.vehicles.load import catalogue_names
from pelagos.vehicles.vehicle import Vehicle

NAMES = catalogue_names()
WANTED = {
    "remus100", "torpedo", "couguv", "bluerov2_heavy", "bluerov2", "hovering_auv", "lrauv", "glider", "otter", "wamv",
    "surface_vessel", "mariner", "kvlcc2", "quadrotor", "fixed_wing", "tanker", "container", "npsauv",
    "supply", "frigate", "semisub", "dsrv", "zeefakkel", "navalvessel",
}  # fmt: skip
START = {
    "fixed_wing": {"nu": (25.0, 0, 1, 0, 0, 0), "position": (0, 0, -100)},
    "mariner": {"nu": (7.7, 0, 0, 0, 0, 0)},
    "kvlcc2": {"nu": (7.9, 0, 0, 0, 0, 0)},
    "tanker": {"nu": (8.2, 0, 0, 0, 0, 0)},
    "container": {"nu": (7.3, 0, 0, 0, 0, 0)},
    "frigate": {"nu": (9.0, 0, 0, 0, 0, 0)},
    "zeefakkel": {"nu": (5.0, 0, 0, 0, 0, 0)},
    "navalvessel": {"nu": (8.0, 0, 0, 0, 0, 0)},
}


def start(name):
    floats = Vehicle.from_catalogue(name).config.body.stiffness.any()
    return {"position": (0, 0, 0.0 if floats else 30.0)} | START.get(name, {})


def test_the_catalogue_is_complete():
    assert set(NAMES) >= WANTED


@pytest.mark.parametrize("name", NAMES)
def test_every_number_has_a_source_on_its_line(name):
    text = (files("pelagos.vehicles.catalogue") / f"{name}.yaml").read_text(encoding="utf-8")
    bare = []
    section = ""
    for line in text.splitlines():
        if re.match(r"^\w+:", line):
            section = line.split(":")[0]
        number = re.search(r"[:\[\s]-?\d+\.?\d*(e-?\d+)?\b", line.split("#")[0].split('"')[0])
        if number and "#" not in line and section not in ("sources", "title", "gravity_m_s2"):
            bare.append(line)
    assert bare == []


@pytest.mark.parametrize("name", NAMES)
def test_configuration_round_trips_through_json(name):
    config = Vehicle.from_catalogue(name).config
    assert VehicleConfig.model_validate_json(config.model_dump_json()) == config
    assert config.title
    assert config.sources


@pytest.mark.parametrize("name", NAMES)
def test_mass_matrix_is_positive_definite(name):
    body = Vehicle.from_catalogue(name).config.body
    assert np.linalg.eigvalsh((body.mass_matrix + body.mass_matrix.T) / 2).min() > 0
    if name not in ("mariner", "dsrv", "navalvessel"):  # published derivatives are measured, and not symmetric
        assert np.allclose(body.mass_matrix, body.mass_matrix.T)


@pytest.mark.parametrize("name", NAMES)
def test_hull_and_probes(name):
    vehicle = Vehicle.from_catalogue(name)
    hull, (starts, vectors) = vehicle.hull, vehicle.probes
    assert hull.faces.max() < len(hull.vertices)
    assert np.linalg.norm(hull.vertex_normals, axis=1) == pytest.approx(1.0, abs=1e-5)
    size = np.ptp(hull.vertices, axis=0)
    config = vehicle.config
    propellers = 0.17 if name == "quadrotor" else 0.0  # discs stand out of the frame that its length counts
    assert size[0] == pytest.approx(config.length_m * (1 + propellers), rel=0.06)
    if config.beam_m is not None:
        assert size[1] == pytest.approx(config.beam_m * (1 + propellers), rel=0.07)
    tips = starts + vectors
    weights = np.random.default_rng(0).dirichlet([1, 1, 1], size=(len(hull.faces), 20))
    surface = np.concatenate([hull.vertices, (weights @ hull.vertices[hull.faces]).reshape(-1, 3)])
    near = [np.linalg.norm(surface - tip, axis=1).min() for tip in tips]
    assert max(near) < 0.06 * size.max()
    assert vehicle.bounding_radius_m >= np.linalg.norm(tips, axis=1).max() - 0.05 * size.max()


@pytest.mark.parametrize("name", NAMES)
def test_default_mode_holds_for_a_minute_in_a_current(name):
    vehicle = Vehicle.from_catalogue(name)
    idle = {"depth": 30.0, "z": -30.0, "height": 100.0, "airspeed": 25.0, "upper_depth": 10.0, "glide_pitch": 0.4}
    idle |= {"speed": 1.0}
    command = [idle.get(c, 0.0) for c in vehicle.command_names()]
    flight = fly(vehicle, 60.0, h=0.02, command=command, ocean=Still((0.1, 0.1, 0.0)), **start(name))
    assert np.isfinite(flight.nu).all()
    assert np.abs(flight.euler[:, :2]).max() < 1.2
    assert np.linalg.norm(flight.nu[-1, :3]) < 40


@pytest.mark.parametrize("name", NAMES)
def test_every_mode_steps_and_fleets_equal_single_vehicles(name):
    """Copy 1 of 3 moves as one alone does, bit for bit; and the accelerations are finite."""
    vehicle = Vehicle.from_catalogue(name)
    random = np.random.default_rng(3)
    position = random.uniform(-1, 1, (3, 3)) - [0, 0, 20]
    attitude = np.array([[1.0, 0.01, 0.02, 0.1]] * 3) / np.linalg.norm([1.0, 0.01, 0.02, 0.1])
    velocity = np.array([[5.0, 0, 0]] * 3) * (1 + 0.1 * random.uniform(size=(3, 1)))
    for mode in vehicle.modes:
        k = len(vehicle.command_names(mode))
        command = random.uniform(0.1, 0.5, (3, k))
        many = _steps(vehicle, mode, position, attitude, velocity, command)
        one = _steps(vehicle, mode, position[1:2], attitude[1:2], velocity[1:2], command[1:2])
        assert np.isfinite(many).all(), mode
        assert np.array_equal(many[:, 1:2], one), mode


def _steps(vehicle, mode, position, attitude, velocity, command) -> np.ndarray:
    n = len(position)
    state = vehicle.initial_state(position, attitude, velocity)
    given = [jit.Float64(np.ascontiguousarray(c)) for c in command.T]
    still: Array = dr.zeros(jit.Array3f64, n)
    for k in range(3):
        state = vehicle.step(state, given, None, jit.Float64(0.02 * k), (still, still), jit.Float64(0.02), mode)
        dr.eval(state)
    rows = [*state.position, *state.velocity, *state.angular_velocity]
    return np.array([np.broadcast_to(np.array(r), n) for r in rows])


@pytest.mark.parametrize("name", NAMES)
def test_accelerations_have_the_books_shapes(name):
    vehicle = Vehicle.from_catalogue(name)
    k = len(vehicle.actuator_names)
    eta, nu = np.zeros((2, 6)), np.tile([5.0, 0, 0, 0, 0, 0], (2, 1))
    nu_dot, act_dot = vehicle.accelerations(eta, nu, np.zeros((2, k)), np.zeros((2, k)), current=(0.1, 0, 0))
    assert nu_dot.shape == (2, 6)
    assert act_dot.shape == (2, k)
    assert np.isfinite(nu_dot).all()
    assert (act_dot == 0).all()
    assert np.array_equal(nu_dot[0], nu_dot[1])
