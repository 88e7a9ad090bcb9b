"""What every vehicle of the catalogue must do, checked the day it is added."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl
from cases import KIN
from pelagos.manoeuvres.standard import PUSHING
from pelagos.vehicles.load import catalogue_names

NAMES = sorted(catalogue_names())
AFLOAT = {
    "otter", "wamv", "surface_vessel", "mariner", "kvlcc2", "tanker", "container", "supply", "semisub", "frigate",
    "zeefakkel", "navalvessel",
}  # fmt: skip
IN_AIR = {"quadrotor", "fixed_wing"}


@pytest.fixture(params=NAMES)
def vehicle(request) -> pl.Vehicle:
    return pl.Vehicle.from_catalogue(request.param)


def test_mass_matrix_is_symmetric_and_positive_definite(vehicle):
    m = vehicle.config.body.mass_matrix
    measured = getattr(vehicle.config.added_mass, "measured", False)  # towing tanks find coefficients one by one
    assert measured or np.allclose(m, m.T, atol=1e-9 * np.abs(m).max())
    assert np.linalg.eigvalsh((m + m.T) / 2).min() > 0


def test_still_water_takes_energy_from_every_motion(vehicle):
    # nu^T M (a(nu) - a(0)) is the power of all that depends on speed; Coriolis forces do no work, the rest must take it
    if vehicle.name in ("mariner", "kvlcc2", "tanker", "npsauv", "dsrv"):
        pytest.skip("regressions of tank trials, about one speed: no balance of energy")
    nu = np.random.default_rng(3).normal(size=(200, 6)) * [1.0, 0.3, 0.3, 0.2, 0.2, 0.2]
    depth = -20.0 if vehicle.name in IN_AIR else 0.0 if vehicle.name in AFLOAT else 10.0
    eta = np.tile([0.0, 0.0, depth, 0.0, 0.0, 0.0], (200, 1))
    still = np.zeros((200, len(vehicle.actuator_names)))
    gained = vehicle.accelerations(eta, nu, still, still)[0] - vehicle.accelerations(eta, 0 * nu, still, still)[0]
    assert (np.einsum("ni,ij,nj->n", nu, vehicle.config.body.mass_matrix, gained) < 0).all()


def test_actuators_with_a_thrust_at_their_limits_are_of_the_types_that_messages_name(vehicle):
    kinds = {name: config.type for name, config in vehicle.config.actuators.items()}
    pushing = [name for name, actuator in vehicle.model.actuators.items() if hasattr(actuator, "thrust_limits")]
    assert pushing == [name for name, kind in kinds.items() if kind in PUSHING]


def test_hull_is_sound(vehicle):
    hull = vehicle.hull
    assert hull.faces.max() < len(hull.vertices)
    assert np.isfinite(hull.vertices).all()
    assert int(np.max(hull.face_materials)) < len(vehicle.materials)
    assert np.linalg.norm(hull.vertices, axis=1).max() <= vehicle.bounding_radius_m + 1e-9
    starts, vectors = vehicle.probes
    assert len(starts) == len(vectors) >= 8
    assert (np.linalg.norm(vectors, axis=1) > 1e-3).all()


@pytest.mark.parametrize(
    "vehicle", [pytest.param(n, marks=pytest.mark.slow) if n in KIN else n for n in NAMES], indirect=True
)
def test_every_mode_runs_for_a_fleet_and_equals_a_fleet_of_one(vehicle):
    for mode in vehicle.modes:
        scenario = {
            "world": {"type": "flat", "depth_m": 60.0},
            "agents": {
                "it": {
                    "vehicle": vehicle.name,
                    "control": mode,
                    "start": {
                        "position_m": [0.0, 0.0],
                        "depth_m": 0.0 if vehicle.name in AFLOAT | IN_AIR else 5.0,
                    },
                }
            },
        }
        fleet, alone = pl.Simulation.load(scenario, n=3), pl.Simulation.load(scenario)
        fleet.run(0.5)
        alone.run(0.5)
        assert np.isfinite(fleet.state["it"].position).all(), mode
        assert fleet.state["it"].position[1].tobytes() == alone.state["it"].position[0].tobytes(), mode
        assert fleet.state["it"].velocity[2].tobytes() == alone.state["it"].velocity[0].tobytes(), mode


@pytest.mark.parametrize("name", [name for name in NAMES if name not in AFLOAT | IN_AIR])
def test_the_seabed_holds_it(name):
    """Thrown down at 2 m/s from just above the seabed, it touches and does not pass; nothing explodes."""
    vehicle = pl.Vehicle.from_catalogue(name)
    lowest, highest = (float(f(vehicle.hull.vertices[:, 2])) for f in (np.min, np.max))
    sim = pl.Simulation.load(
        {
            "world": {"type": "flat", "depth_m": 20.0},
            "agents": {"it": {"vehicle": name, "control": vehicle.modes[0], "start": {"position_m": [0.0, 0.0]}}},
        }
    )
    sim.set_state("it", position=(0.0, 0.0, -20.0 - lowest + 0.05), attitude=(1, 0, 0, 0), velocity=(0.3, 0.0, -2.0))
    fastest, deepest = 0.0, np.inf
    for _ in range(30):
        sim.run(0.1)
        state = sim.state["it"]
        fastest = max(fastest, float(np.linalg.norm(state.velocity)))
        deepest = min(deepest, float(state.position[0, 2]) + lowest + 20.0)
    assert deepest > -0.25 * (highest - lowest)  # skids and feet between two probes may sink in
    assert fastest < 3.0
