"""HoloOcean's force model against the numbers that HoloOcean's own tests expect (2.3, BYU FRoSt Lab, MIT licence).

Six accelerations for each agent after 20 ticks at 30 Hz. Moments of inertia are not published and fitted: of the two
agents with fins three numbers of six, and then the others are met to 6e-6; for the last digits, and for the hovering
agents, the products of inertia are fitted too.
"""

import numpy as np
import pytest

from pelagos.compat.holoocean.environments import HoloOceanEnvironment
from pelagos.compat.holoocean.torpedo_agents import FIN_AT
from pelagos.vehicles.vehicle import Vehicle

DYNAMICS = {"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True, "UseRPY": True}}
FINS = [30, -20, -10, 30, 50]
GOLDENS = {
    "HoveringAUV": ([-5, 5, -10, -10, -5, 5, -10, -10],
                    [-0.0476728, 0.03966415, -0.42882535, -0.64573175, 0.779148, -0.6961151]),
    "BlueROV2": ([-2, 3, -4, -5, -2, 0, -4, -5],
                 [-0.07624035, 0.29059425, -0.42171726, -2.6503966, 3.901235, -0.6542496]),
    "TorpedoAUV": (FINS, [0.7525106, -0.01888119, 0.01457546, -0.00471005, 0.03474867, 0.03910198]),
    "CougUV": (FINS, [0.7550211, -0.01134963, 0.00689677, -0.01918183, 0.12382517, 0.14500453]),
}  # fmt: skip


def opened(kind, *, location=(0, 0, -10), tps=30, legacy=True):
    agent = {
        "agent_name": "auv0", "agent_type": kind, "sensors": [dict(DYNAMICS)], "control_scheme": 0,
        "location": list(location),
    }  # fmt: skip
    scenario = {"name": "t", "world": "TestWorld", "ticks_per_sec": tps, "agents": [agent], "legacy_dynamics": legacy}
    return HoloOceanEnvironment(scenario=scenario, show_viewport=False)


def accelerations(env, action=None, *, ticks):
    for _ in range(ticks):
        state = env.tick() if action is None else env.step(np.array(action))
    return np.r_[state["DynamicsSensor"][:3], state["DynamicsSensor"][9:12]]


@pytest.mark.parametrize("kind", GOLDENS)
def test_thrusters_and_fins(kind):
    action, expected = GOLDENS[kind]
    with opened(kind) as env:
        np.testing.assert_allclose(accelerations(env, action, ticks=20), expected, rtol=1e-5, atol=1e-8)


def test_the_surface_vessel_to_the_digits_that_are_given():
    with opened("SurfaceVessel", location=(10, 10, 0.15)) as env:
        found = accelerations(env, [-50, -100], ticks=20)
    np.testing.assert_allclose(found[[0, 1, 3, 4, 5]], [-0.091, 0.002, -1.3e-3, -2.3e-6, -2.1e-2], atol=1e-3)


def test_a_current_of_1_m_s_from_every_side():
    with opened("HoveringAUV", location=(18.5, -25.5, -10), tps=60) as env:
        for axis in range(3):
            current = [0.0, 0.0, 0.0]
            assert not accelerations(env, ticks=1).any()
            current[axis] = 1.0
            env.set_ocean_currents("auv0", current)
            expected = np.zeros(6)
            expected[axis] = 0.06320982
            np.testing.assert_allclose(accelerations(env, ticks=1), expected, rtol=1e-5, atol=1e-8)
            env.reset()


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "expected"), [(0, 0.00199408), (1, 0.00197457)])
def test_a_current_pushes_a_floating_vessel(axis, expected):
    with opened("SurfaceVessel", location=(18.5, -25.5, 0), tps=60) as env:
        env.tick(500)
        env.set_ocean_currents("auv0", [float(axis == 0), float(axis == 1), 0.0])
        np.testing.assert_allclose(accelerations(env, ticks=10)[axis], expected, rtol=0.02)


@pytest.mark.parametrize("legacy", [False, True])
@pytest.mark.parametrize("kind", ["TorpedoAUV", "CougUV"])
@pytest.mark.parametrize(
    ("fins", "axis", "sign"),
    [
        ((20, 0, -20, 0), 1, 1), ((-20, 0, 20, 0), 1, -1),  # the nose goes down by the planes alone,
        ((0, 20, 0, -20), 2, -1), ((0, -20, 0, 20), 2, 1),  # to the right by the rudders alone;
        ((20, 0, 20, 0), 0, -1), ((0, 20, 0, 20), 0, -1), ((20, 20, 20, 20), 0, -1), ((-20, -20, -20, -20), 0, 1),
    ],
)  # fmt: skip
def test_fins_turn_the_body_the_same_way_in_both_dynamics(kind, fins, axis, sign, legacy):
    """Angles are right-handed about the outward axis: opposite fins work together where their angles differ in sign."""

    def turned(angles):
        with opened(kind, legacy=legacy) as env:
            env.act("auv0", [*angles, 100])
            env.tick(25)
            turn = np.array(env.pelagos.state["auv0"].angular_velocity[0])
        return turn

    by_fins = sign * (turned(fins) - turned((0, 0, 0, 0)))  # a hull that is not trimmed pitches without them too
    others = np.delete(by_fins, axis)
    assert by_fins[axis] > 1e-3
    assert (np.abs(others) < 0.5 * by_fins[axis]).all(), by_fins  # rudders push above the centre of gravity


def test_the_native_fins_stand_where_the_adapter_has_them():
    for kind in ("torpedo", "couguv"):
        fins = Vehicle.from_dict({"type": kind}).config.actuators
        assert [fins[FIN_AT[place]].angle_deg for place in ("right", "bottom", "left", "top")] == [0, 90, 180, 270]
