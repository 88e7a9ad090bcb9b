"""Ways of every agent by every control scheme, with Pelagos's dynamics and with HoloOcean's; readings of sensors."""

import numpy as np
import pytest
from holoocean_env import agent, opened

from known import check

SCHEMES = [
    ("HoveringAUV", 0), ("HoveringAUV", 1), ("HoveringAUV", 2), ("TorpedoAUV", 0), ("TorpedoAUV", 1), ("CougUV", 0),
    ("CougUV", 1), ("SurfaceVessel", 0), ("SurfaceVessel", 1), ("SurfaceVessel", 2), ("BlueROV2", 0), ("BlueROV2", 1),
    ("BlueROV2", 2), ("UavAgent", 0), ("UavAgent", 1), ("SphereAgent", 0), ("SphereAgent", 1), ("TurtleAgent", 0),
    ("HuskyVehicle", 0),
]  # fmt: skip
SENSORS = [
    {"sensor_type": "PoseSensor"}, {"sensor_type": "VelocitySensor"}, {"sensor_type": "LocationSensor"},
    {"sensor_type": "RotationSensor"}, {"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True}},
    {"sensor_type": "IMUSensor", "socket": "IMUSocket", "configuration": {"AccelSigma": 0.02, "AngVelSigma": 0.01}},
    {"sensor_type": "DVLSensor", "configuration": {"Elevation": 24.0, "VelSigma": 0.03, "ReturnRange": True}},
    {"sensor_type": "DepthSensor", "configuration": {"Sigma": 0.2}},
    {"sensor_type": "MagnetometerSensor"}, {"sensor_type": "GPSSensor", "configuration": {"Sigma": 0.4, "Depth": 30}},
    {"sensor_type": "RangeFinderSensor", "configuration": {"LaserMaxDistance": 40, "LaserCount": 7, "LaserAngle": -20}},
    {"sensor_type": "OrientationSensor"},
]  # fmt: skip


@pytest.mark.parametrize("legacy", [False, True])
@pytest.mark.parametrize(("kind", "scheme"), SCHEMES)
def test_ways(kind, scheme, legacy):
    dry = kind in ("UavAgent", "SphereAgent", "TurtleAgent", "HuskyVehicle")
    up = 3.0 if kind == "UavAgent" else 0.2 if dry else 0.0 if kind == "SurfaceVessel" else -10.0
    env = opened(
        agent(kind, [{"sensor_type": "PoseSensor"}, {"sensor_type": "VelocitySensor"}], scheme=scheme,
              location=(2.0, -3.0, up), rotation=[0.0, 0.0, 35.0]),
        seed=4, legacy_dynamics=legacy,
    )  # fmt: skip
    with env:
        space = env.agents["auv0"].action_space
        size = int(np.prod(space.shape))
        high = space.get_high() if hasattr(space, "get_high") else None
        most = np.broadcast_to(np.fmin(5.0, 3.0 if high is None else np.asarray(high, dtype=float)), size)
        action = np.array([0.3 * (-1) ** k * (1 + 0.2 * k) * most[k] for k in range(size)])
        begin, found = env.step(action), {"way": [], "turn": [], "velocity": []}
        for _ in range(3):
            state = env.step(action, ticks=25)
            moved = state["PoseSensor"] - begin["PoseSensor"]
            found["way"].append(moved[:3, 3])
            found["turn"].append(moved[:3, :3])
            found["velocity"].append(state["VelocitySensor"])
    check("holoocean", f"{kind} {scheme} {'legacy' if legacy else 'native'}", found)


def test_sensors():
    env = opened(agent("HoveringAUV", SENSORS, location=(2.0, -3.0, -12.0), rotation=[4.0, -3.0, 35.0]), seed=4)
    with env:
        found = {}
        for _ in range(12):
            state = env.step(np.array([3.0, -2.0, 4.0, -5.0, 6.0, -4.0, 2.0, 5.0]))
            for name, value in state.items():
                if isinstance(value, np.ndarray):
                    found.setdefault(name, []).append(np.ravel(value).astype(float))
        assert len(found) == len(SENSORS)
    check("holoocean", "sensors", {name: np.concatenate(values) for name, values in found.items()})
