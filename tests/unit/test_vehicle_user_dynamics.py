"""A user's own dynamics: Dr.Jit and NumPy say the same, by module or by entry point, whole or as one force."""

from __future__ import annotations

import sys

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.errors import InputError
from pelagos.vehicles.vehicle import Vehicle


def tether(flow, parameters):
    pull = [-parameters["stiffness"] * p for p in flow.position]
    in_body = [sum(flow.rotation[i][j] * pull[i] for i in range(3)) for j in range(3)]
    return [*in_body, 0.0, 0.0, 1e-3 * flow.actuators["propeller"]]


def numpy_tether(flow, parameters):
    force = np.einsum("nji,nj->ni", flow.rotation, -parameters["stiffness"] * flow.position)
    rest = np.zeros_like(force)
    rest[:, 2] = 1e-3 * flow.actuators["propeller"]
    return np.hstack([force, rest])


def wrong_shape(flow, parameters):
    return np.zeros((3, 3))


def not_finite(flow, parameters):
    return [0.0, np.nan, 0.0, 0.0, 0.0, 0.0]


def decay(flow, parameters):
    """The whole of the dynamics: the velocity through the water dies out."""
    return -parameters["rate"] * flow.nu_r


def term(function, **more):
    return {"type": "function", "target": f"{__name__}:{function}", "parameters": {"stiffness": 5.0}, **more}


def flown(vehicle: dict, n: int = 3, seconds: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    start = {"position_m": [3.0, 1.0], "depth_m": 5.0, "heading_deg": 30.0}
    agent = {"vehicle": vehicle, "start": start, "control": "actuators", "command": [0.1, -0.05, 1200.0]}
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 50.0}, "agents": {"a": agent}}, n=n, trust=True)
    sim.run(seconds)
    return sim.state["a"].position, sim.state["a"].velocity


@pytest.mark.parametrize("integrator", ["semi_implicit", "runge_kutta"])
def test_numpy_and_drjit_move_a_fleet_alike(integrator):
    same = {"type": "remus100", "integrator": integrator}
    fast = flown({**same, "terms": {"mine": term("tether")}}, seconds=0.8)
    slow = flown({**same, "terms": {"mine": term("numpy_tether", arrays="numpy")}}, seconds=0.8)
    assert np.abs(fast[0] - slow[0]).max() < 1e-12
    assert np.abs(fast[1] - slow[1]).max() < 1e-12
    assert np.abs(fast[0] - flown(same, seconds=0.8)[0]).max() > 1e-3


def test_numpy_dynamics_in_the_books_accelerations():
    states = [[[10.0, 2, 3, 0.1, 0.2, 0.3]], [[1.0, 0, 0, 0, 0, 0]], [[0, 0, 1000.0]], [[0.0] * 3]]
    both = [
        Vehicle.from_catalogue("remus100", terms={"mine": t}).accelerations(*states)[0]
        for t in (term("tether"), term("numpy_tether", arrays="numpy"))
    ]
    assert both[0] == pytest.approx(both[1], abs=1e-12)


BARE = {
    "type": "custom",
    "length_m": 1.0,
    "diameter_m": 0.2,
    "mass": {
        "type": "explicit",
        "mass_kg": 20.0,
        "inertia_kg_m2": [0.1, 1.0, 1.0],
        "center_of_gravity_m": [0, 0, 0.05],
    },
    "added_mass": {"type": "diagonal", "diagonal": [2, 20, 20, 0.1, 1, 1]},
    "coriolis": {"rigid": "none"},
    "modes": {"actuators": {"type": "actuators"}},
    "default_mode": "actuators",
}


@pytest.mark.parametrize("arrays", ["drjit", "numpy"])
def test_the_acceleration_of_a_custom_vehicle_is_the_one_given(arrays):
    """Whatever the mass matrix, and in a current too."""
    mine = {"type": "function", "target": f"{__name__}:{'decay' if arrays == 'numpy' else 'decay_lists'}",
            "arrays": arrays, "gives": "acceleration", "parameters": {"rate": 0.7}}  # fmt: skip
    nu = np.array([[1.0, -0.5, 0.2, 0.1, -0.2, 0.3]])
    vehicle = Vehicle.from_dict({**BARE, "terms": {"mine": mine}})
    got, _ = vehicle.accelerations([[0, 0, 5, 0, 0, 0]], nu, [[]], [[]], current=(0.3, 0.0, 0.0))
    assert got == pytest.approx(-0.7 * (nu - [0.3, 0, 0, 0, 0, 0]), abs=1e-12)


def decay_lists(flow, parameters):
    return [-parameters["rate"] * v for v in flow.nu_r]


def test_dynamics_by_entry_point(tmp_path, monkeypatch):
    """A package that declares `pelagos.dynamics` entry points is found by the name that it gives."""
    (tmp_path / "my_dynamics.py").write_text("def f(flow, parameters):\n    return [7.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n")
    info = tmp_path / "my_dynamics-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-dynamics\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[pelagos.dynamics]\nsteady_push = my_dynamics:f\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    vehicle = Vehicle.from_catalogue("remus100", terms={"push": {"type": "function", "target": "steady_push"}})
    assert list(vehicle.model.terms["push"].wrench(None)) == [7.0, 0, 0, 0, 0, 0]
    with pytest.raises(InputError, match="steady_push"):
        Vehicle.from_catalogue("remus100", terms={"push": {"type": "function", "target": "steady_pusch"}})
    sys.modules.pop("my_dynamics", None)


@pytest.mark.parametrize(
    ("function", "message"), [("wrong_shape", r"\(1, 6\), not \(3, 3\)"), ("not_finite", "finite")]
)
def test_numpy_dynamics_that_cannot_be(function, message):
    vehicle = Vehicle.from_catalogue("remus100", terms={"mine": term(function, arrays="numpy")})
    with pytest.raises(InputError, match=message):
        vehicle.accelerations([[0.0] * 6], [[0.0] * 6], [[0.0] * 3], [[0.0] * 3])


def test_numpy_dynamics_cannot_be_recorded():
    """In a frozen step or a symbolic loop the function would be called once instead of in every step."""
    vehicle = Vehicle.from_catalogue("remus100", terms={"mine": term("numpy_tether", arrays="numpy")})
    state = vehicle.initial_state(np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]))
    command = [dr.opaque(jit.Float64, 0.1) for _ in range(3)]
    still = dr.zeros(jit.Array3f64, 1)

    def step(state, command, still, h):
        return vehicle.step(state, command, None, h, (still, still), h, "actuators")

    with pytest.raises(RuntimeError) as error:
        dr.freeze(step)(state, command, still, dr.opaque(jit.Float64, 0.01))
    assert "neither frozen nor" in str(error.value.__cause__)
