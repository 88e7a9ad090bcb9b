"""What each part of HoloOcean's interface makes of numbers that all differ: commands of agents, native sensors and
their values, surroundings, messages, tasks, Fossen's accelerations."""

import copy
import json
import math
import random
from types import SimpleNamespace

import numpy as np
import pytest
from holoocean_env import agent, opened

from known import DOUBLE, EXACT, check, on_one_scale
from pelagos.compat.holoocean import command as commands
from pelagos.compat.holoocean import frames, packagemanager, util
from pelagos.compat.holoocean.advice import Advice
from pelagos.compat.holoocean.agent_types import AGENT_TYPES
from pelagos.compat.holoocean.agents import AgentDefinition, ControlSchemes
from pelagos.compat.holoocean.bst_graph import BST_Visualizer
from pelagos.compat.holoocean.convert import _Unbuilt, converted
from pelagos.compat.holoocean.fossen_dynamics import FossenInterface, changes
from pelagos.compat.holoocean.lcm import SensorData
from pelagos.compat.holoocean.making import make
from pelagos.compat.holoocean.motion import AgentMotion
from pelagos.compat.holoocean.native_scenario import native_scenario, native_sensor, world_of
from pelagos.compat.holoocean.noise import Normal, Normals, stream
from pelagos.compat.holoocean.sensors import SensorDefinition, sensor_types
from pelagos.math.so3 import from_euler
from pelagos.sensors.sensor import Reading

pytestmark = pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")


def known(case, found, share=EXACT):
    check("holoocean_parts", case, {name: on_one_scale(v) for name, v in found.items()}, share)


def turned(*degrees):
    return np.array([float(c) for c in from_euler(*(math.radians(a) for a in degrees))])


POSES = [
    ([3.0, -4.0, 2.5], turned(25.0, -40.0, 110.0)),
    ([-2.0, 5.0, 1.5], turned(-150.0, 35.0, -75.0)),
    ([1.0, 0.7, 0.5], turned(0.0, 0.0, 20.0)),
]


@pytest.fixture(scope="module")
def test_world():
    from pelagos.world.build import build_world, world_config

    return build_world(world_config(world_of({"world": "TestWorld"})["world"]))


@pytest.mark.parametrize("kind", sorted(AGENT_TYPES))
def test_commands_of_agents(kind, test_world):
    """Every input alone, both signs; all unequal; beyond every limit; by every scheme and both dynamics."""
    found, about = {}, AGENT_TYPES[kind]
    for legacy in (False, True):
        definition = AgentDefinition("auv0", kind)
        definition.legacy = legacy
        made = definition.type(None, definition)
        made.current = (0.3, -0.2, 0.1)
        told = []
        for number, scheme in enumerate(about.schemes):
            made.set_control_scheme(number + len(about.schemes))
            rows = [*np.eye(scheme.size), *(-0.7 * np.eye(scheme.size))]
            steps = np.arange(1, scheme.size + 1)
            rows += [0.3 * steps * (-1.0) ** steps, -1e4 * (-1.0) ** steps * steps]
            for row in rows:
                made.act(row)
                told.append([made.mode, made.command()])
                if about.steps is not None and number == made.scheme:
                    action = scheme.within(np.abs(row) % 4 if scheme.discrete else row)
                    told += [
                        about.steps(test_world, SimpleNamespace(position=[np.array(p)], attitude=[q]), number, action)
                        for p, q in POSES
                    ]
            space = made.action_space
            told.append([space.shape, space.get_low(), space.get_high(), repr(space)])
        found["legacy" if legacy else "native"] = told
    found["listed"] = [[text, space.shape] for text, space in made.control_schemes]
    found["about"] = [about.vehicle, about.sockets, about.lamps, about.accel_limit, about.legacy]
    found["constants"] = [dict(about.constants)]
    known(f"commands {kind}", found)


DYNAMICS = {"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True, "UseRPY": False}}
TUNED = {
    "dynamics": {
        "rho": 1021.0,
        "length": 1.7,
        "diam": 0.21,
        "r_bg": [0.01, 0.002, 0.03],
        "Cd": 0.44,
        "e": 0.65,
        "T_surge": 21.0,
        "T_sway": 19.0,
        "T_yaw": 1.3,
        "zeta_roll": 0.33,
        "zeta_pitch": 0.77,
        "r44": 0.31,
        "K_nomoto": 0.21,
        "area_fraction": 0.68,
        "mass": 16.0,
    },
    "actuator": {
        "nMax": 1700,
        "T_n": 0.9,
        "D_prop": 0.15,
        "t_prop": 0.11,
        "KT_0": 0.48,
        "fin_area": 0.0071,
        "CL_delta": 0.52,
        "deltaMax_fin_deg": 17,
        "T_delta": 0.13,
        "fin_center": 0.073,
    },
    "autopilot": {
        "depth": {
            "wn_d_z": 0.21,
            "Kp_z": 0.14,
            "T_z": 90,
            "Kp_theta": 41.0,
            "Kd_theta": 16.0,
            "Ki_theta": 0.6,
            "K_w": 0.1,
            "theta_max_deg": 31,
        },
        "heading": {
            "wn_d": 1.1,
            "zeta_d": 0.9,
            "lam": 0.12,
            "phi_b": 0.11,
            "K_d": 0.55,
            "K_sigma": 0.051,
            "r_max": 0.9,
        },
    },
}
MODES = {"torpedo": ["manualControl", "depthHeadingAutopilot"], "otter": ["stepInput", "headingAutopilot"]}


@pytest.mark.parametrize(
    ("kind", "mode", "tuned"),
    [*((kind, mode, False) for kind, modes in MODES.items() for mode in modes), ("torpedo", "headingAutopilot", True)],
)
def test_fossens_accelerations(kind, mode, tuned):
    """Of a vehicle that is tilted, moves and turns about all axes."""
    more = {"fossen_model": kind, "control_mode": mode, **(TUNED if tuned else {})}
    one = agent("TorpedoAUV", [DYNAMICS], **more)
    fossen = FossenInterface("auv0", {"ticks_per_sec": 50, "agents": [one]})
    if mode in ("manualControl", "stepInput"):
        fossen.set_u_control("auv0", [-0.1, 0.07, 0.15, -0.05, 900.0] if kind == "torpedo" else [60.0, -35.0])
    else:
        fossen.set_goal("auv0", depth=6.5, heading=-75.0, rpm=None if kind == "otter" else 1100.0)
    found = []
    for k, (position, q) in enumerate(POSES):
        w, x, y, z = q
        still = [0.0, 0.0, 0.0]
        seen = [*still, 1.1, -0.4, 0.25 * k, *position[:2], -5.0 - k, *still, 0.3, -0.2, 0.4 - 0.3 * k, -x, -y, -z, -w]
        found.append(fossen.update("auv0", {"DynamicsSensor": np.array(seen)}))
    vehicle = fossen.vehicles["auv0"]
    known(
        f"Fossen {kind} {mode}{' tuned' if tuned else ''}",
        {
            "accelerations": found,
            "command": vehicle.command(),
            "native": vehicle.native,
            "changes": changes(one, Advice()),
            "held": [fossen.get_u_control("auv0"), fossen.get_control_mode("auv0")],
        },
    )


# sensors


SONAR = {
    "RangeMin": 0.7,
    "RangeMax": 12.5,
    "RangeBins": 24,
    "AddSigma": 0.11,
    "MultCov": 0.04,
    "RangeSigma": 0.03,
    "WaterSpeedSound": 1491.0,
    "WaterDensity": 1003.0,
}
FAN = {**SONAR, "Azimuth": 96.0, "AzimuthBins": 16, "Elevation": 17.0, "AzimuthStreaks": 1, "MultiPath": True}
SIMPLE = {"physics": "holoocean", "AzimuthStreaks": 0, "MultiPath": False, "ScaleNoise": True}
LENS = {
    "CaptureWidth": 24,
    "CaptureHeight": 16,
    "FovAngle": 77.0,
    "Aperture": 2.8,
    "FocalDistance": 350.0,
    "DepthBlurRadius": 1.5,
    "BladeCount": 6,
    "BloomIntensity": 0.3,
    "LensFlareIntensity": 0.2,
    "WhiteTemp": 5100.0,
    "WhiteTint": 0.1,
    "ChromAberrIntensity": 2.0,
    "ChromAberrOffset": 0.3,
    "DepthOfFieldMinFstop": 1.4,
    "MotionBlurIntensity": 0.4,
    "MotionBlurMinObjectScreenSize": 3.0,
}
FILM = {"FilmSlope": 0.8, "FilmToe": 0.5, "FilmShoulder": 0.25, "FilmBlackClip": 0.01, "FilmWhiteClip": 0.03}
LIDAR = {
    "Channels": 9,
    "Range": 77.0,
    "PointsPerSecond": 4400,
    "RotationFrequency": 7.0,
    "UpperFovLimit": 13.0,
    "LowerFovLimit": -21.0,
    "HorizontalFov": 140.0,
    "SaveWaterPoints": True,
}
NOISE3 = [[0.04, 0.01, 0.0], [0.01, 0.09, 0.02], [0.0, 0.02, 0.16]]
CLUSTER = [[[1.0, -2.0, -4.0], 1.7, 3.0], [[-5.0, 3.0, -9.0], -0.9, 2.0]]
OPTIONS = {
    "LocationSensor": [{"Sigma": [0.1, 0.2, 0.4]}, {"Cov": NOISE3}],
    "DepthSensor": [{"Sigma": 0.2}, {"Cov": [0.09]}],
    "GPSSensor": [{"Sigma": 0.4, "Depth": 30, "DepthSigma": 0.5}, {"Depth": -3.0}],
    "MagnetometerSensor": [{"MagneticVector": [0.3, -1.2, 2.5], "Sigma": 0.1}, {"MagnetixVector": [0.5, 0.1, -0.7]}],
    "DynamicsSensor": [{"UseCOM": False, "UseRPY": False}, {"UseCOM": False}, {"UseCOM": True, "UseRPY": False}],
    "IMUSensor": [
        {
            "AccelSigma": 0.02,
            "AngVelSigma": [0.01, 0.02, 0.03],
            "AccelBiasSigma": 0.1,
            "AngVelBiasCov": 0.01,
            "ReturnBias": True,
        },
        {"AccelCov": NOISE3},
    ],
    "DVLSensor": [
        {"Elevation": 24.0, "VelSigma": 0.03, "RangeSigma": [0.1, 0.2, 0.3, 0.4], "MaxRange": 33.0},
        {"ReturnRange": False, "VelCov": [0.01, 0.02, 0.03, 0.04]},
    ],
    "RangeFinderSensor": [{"LaserMaxDistance": 40, "LaserCount": 7, "LaserAngle": -20}],
    "AbuseSensor": [{"AccelerationLimit": 0.5}],
    "WorldNumSensor": [{"Key": "it"}],
    "BSTSensor": [
        {
            "Sigma": 0.3,
            "surface_biomass": 0.4,
            "max_biomass": 1.9,
            "peak_depth": 7.0,
            "width_factor": 4.0,
            "photic_zone_depth": 31.0,
            "deep_biomass": 0.2,
            "biomass_clusters": CLUSTER[:0],
            "surface_psu": 31.0,
            "deep_psu": 36.0,
            "halocline_depth": 6.0,
            "halocline_thickness": 3.0,
            "surface_temp": 21.0,
            "deep_temp": 3.0,
            "thermocline_depth": 9.0,
            "thermocline_thickness": 5.0,
        },
    ],
    "RGBCamera": [{"CaptureWidth": 24, "CaptureHeight": 16, "FovAngle": 175.0}],
    "ViewportCapture": [{"CaptureWidth": 24, "CaptureHeight": 16}],
    "CameraSensor": [
        {**LENS, "ExposureMethod": "AEM_Manual", "ISO": 320, "ShutterSpeed": 90, "ExposureCompensation": 1.5, **FILM},
        {
            **LENS,
            "ExposureSpeedUp": 2.0,
            "ExposureSpeedDown": 1.5,
            "ExposureMinBrightness": -3.0,
            "ExposureMaxBrightness": 9.0,
            "ExposureCompensation": 3.0,
            "TargetGamma": 2.4,
        },
        {"CaptureWidth": 24, "CaptureHeight": 16, "DepthOfFieldMinFstop": 9.0, "Aperature": 5.6},
    ],
    "DepthCamera": [{"CaptureWidth": 24, "CaptureHeight": 16}],
    "SemanticSegmentationCamera": [{"CaptureWidth": 24, "CaptureHeight": 16}],
    "RaycastLidar": [
        {
            **LIDAR,
            "AtmospAttenRate": 0.3,
            "DropOffGenRate": 0.2,
            "DropOffIntensityLimit": 0.7,
            "DropOffAtZeroIntensity": 0.35,
            "NoiseStdDev": 0.02,
        }
    ],
    "RaycastSemanticLidar": [{**LIDAR, "PointsPerSecond": 3}],
    **{
        f"{p}{n}Sonar": [FAN, {**FAN, **SIMPLE}]
        for p in ("", "Raycast", "GPU")
        for n in ("Imaging", "Profiling", "Sidescan")
    },
    **{f"{p}SinglebeamSonar": [{**SONAR, "OpeningAngle": 23.0}, {**SONAR, **SIMPLE}] for p in ("", "Raycast", "GPU")},
    "SemanticRaycastSinglebeamSonar": [{**SONAR, "UseIds": True}, {**SONAR, "UseTags": True}],
    "AcousticBeaconSensor": [{"id": 4, "MaxDistance": 9.0, "DistanceSigma": 0.3}],
    "OpticalModemSensor": [{"id": 6, "LaserAngle": 40, "AngleSigma": 2.0, "MaxDistance": 9.0}],
    "DistanceTask": [
        {"GoalLocation": [1.0, 2.0, -3.0], "Interval": 0.7, "GoalDistance": 9.5},
        {"MaximizeDistance": True, "GoalDistance": 0.4, "Interval": 0.2},
    ],
    "LocationTask": [
        {"GoalLocation": [1.0, 2.0, -3.0], "GoalDistance": 14.0, "NegativeReward": True, "HasTerminal": True},
        {"GoalActor": "other", "LocationActor": "auv0", "GoalDistance": 2.0},
    ],
    "FollowTask": [{"ToFollow": "other", "MinDistance": 21.0}],
    "AvoidTask": [{"ToAvoid": "other", "MinDistance": 17.0}],
}
REFUSED = ("JointRotationSensor", "PressureSensor", "RelativeSkeletalPositionSensor", "CupGameTask", "CleanUpTask")
SEEING = ("Camera", "Capture", "Lidar", "Sonar")


@pytest.fixture(scope="module")
def unbuilt():
    """An environment without a simulation, with two agents that move."""
    scenario = {
        "name": "parts",
        "world": "TestWorld",
        "main_agent": "auv0",
        "ticks_per_sec": 60,
        "agents": [agent("HoveringAUV"), agent("BlueROV2", name="other")],
    }
    env = _Unbuilt(scenario=scenario, seed=11)
    env.motions = {}
    begin_appearance = env._begin_appearance
    begin_appearance()
    env.world_numbers = {"it": 4.5}
    return env


def motions(k):
    """Of both agents at step k, each after a step from another motion."""
    found = {}
    for i, name in enumerate(("auv0", "other")):
        position, q = POSES[(i + k) % 2]
        rows = []
        for step in (0, 1):
            row = np.zeros(32)
            row[:3] = np.array(position) * [1, 1, -3] + 0.1 * step + 0.4 * k
            row[3:7], row[7:10] = q, np.array([1.2, -0.5, 0.3]) + 0.02 * step * (i + 1)
            row[10:13] = np.array([0.4, -0.3, 0.7]) * (1 + 0.05 * step) * (1 - 2 * i)
            rows.append(row)
        found[name] = AgentMotion(rows[1], AgentMotion(rows[0], None, 1 / 60), 1 / 60)
    return found


def reading_for(sensor, native):
    """Numbers of the shape that the native sensor gives."""
    rng = np.random.default_rng(3)
    kind, bins = native["type"], native.get("bins", 0)
    extras = {}
    if kind in ("imu", "range_finder"):
        data = rng.uniform(1, 9, (1, 6 if kind == "imu" else len(native["azimuth_deg"])))
        if kind == "range_finder":
            data[0, -1] = np.nan
    elif kind == "collision":
        data = np.array([[True]])
    elif kind == "camera":
        data = rng.integers(0, 255, (1, 16, 24, 3), dtype=np.uint8)
    elif kind == "depth_camera":
        data = rng.uniform(1, 900, (1, 16, 24)).astype(np.float32)
        data[0, 2, 3:5] = np.inf, 1234.0
    elif kind == "semantic_camera":
        data, extras = rng.integers(0, 9, (1, 16, 24)), {"palette": rng.integers(0, 255, (9, 3), dtype=np.uint8)}
    elif kind in ("lidar", "semantic_lidar"):
        data = rng.uniform(-9, 9, (1, 3, 5, 4)).astype(np.float32)
        data[0, 1, 2] = np.nan
        if kind == "semantic_lidar":
            extras = {"instance": np.arange(15).reshape(1, 3, 5), "label": np.arange(15).reshape(1, 3, 5) % 4}
    elif kind == "sidescan" or (kind == "incidence_sonar" and native["beams"] == 2):
        data = rng.uniform(0, 1, (1, 2, bins))
    elif "beams" in native and native["beams"] > 1:
        data = rng.uniform(0, 1, (1, native["beams"], bins))
    elif kind == "incidence_sonar":
        data = rng.uniform(0, 1, (1, 1, bins))
    else:
        data = rng.uniform(0, 1, (1, bins))
        extras = {"label": np.arange(bins)[None] % 5, "instance": np.arange(bins)[None] + 3}
    if sensor.sensor_type in ("RaycastSidescanSonar", "GPUSidescanSonar"):
        data = rng.uniform(0, 1, (1, 2, bins))
    return Reading(data, data, 0, "", np.ones(1, bool), extras)


@pytest.mark.parametrize("kind", sorted(set(sensor_types()) - set(REFUSED)))
def test_values_and_native_keys_of_sensors(unbuilt, kind):
    """From a turned mount in a socket, with every option, on a vehicle that is tilted and turns."""
    env, found = unbuilt, {}
    unbuilt._stations.clear()
    for number, options in enumerate([{}, *OPTIONS.get(kind, [])]):
        if not options and kind in ("FollowTask", "AvoidTask"):
            continue
        options = options or (
            {"CaptureWidth": 24, "CaptureHeight": 16} if "Camera" in kind or "Capture" in kind else {}
        )
        definition = SensorDefinition(
            "auv0",
            "HoveringAUV",
            f"it{number}",
            kind,
            ("DVLSocket", "IMUSocket", "SonarSocket")[number % 3],
            (0.3, -0.2, 0.1),
            (12.0, -25.0, 40.0),
            copy.deepcopy(options),
            tick_every=2 + number,
        )
        sensor = env._sensor(definition)
        native = native_sensor(env, sensor)
        said = [
            sensor.data_shape,
            np.dtype(sensor.dtype).name,
            sensor.always,
            sensor.every_tick,
            native,
            sensor.native_name,
        ]
        values = []
        env._total_ticks = 0
        for k in range(3):
            env.motions = motions(k)
            env._total_ticks += 3
            reading = None if native is None else reading_for(sensor, native)
            if native is None or not any(word in kind for word in SEEING) or k == 0:
                values.append(sensor.value(env.motions["auv0"], reading))
        found[f"{number} keys"], found[f"{number} values"] = said, values
        sensor.definition.twist = (10.0, 20.0, -30.0)
        found[f"{number} keys"].append(sensor.definition.mount)
    known(kind, found)


def test_noise_and_frames():
    found = {}
    for name, config in {
        "sigma": {"Sigma": 0.3},
        "sigmas": {"Sigma": [0.1, 0.2, 0.3]},
        "cov": {"Cov": 0.09},
        "covs": {"Cov": [0.1, 0.2, 0.4]},
        "matrix": {"Cov": NOISE3},
        "none": {},
    }.items():
        noise, source = Normal(config, "", 3, advice=Advice()), stream(5, "a", name)
        found[name] = [noise.draw(source) for _ in range(4)]
    parts = [Normal(c, "", 3) for c in ({"Sigma": 0.3}, {}, {"Cov": NOISE3})]
    found["together"] = [Normals(parts).draw(stream(5, "b")), Normals(parts[:2]).draw(stream(5, "c"))]
    turns = [(25.0, -40.0, 110.0), (-150.0, 35.0, -75.0), (10.0, 90.0, 20.0), (10.0, -90.0, 20.0)]
    found["frames"] = [
        [frames.matrix_of(t), frames.degrees_of(frames.matrix_of(t)), frames.start_of([1, -2, 3], t)] for t in turns
    ]
    found["quaternions"] = [frames.quaternion_of(t) for t in turns]
    known("noise and frames", found)


# scenarios and surroundings


SCENARIOS = {
    "tide": {"tide_cycle": {"active": True, "amplitude": -1.5, "frequency": 700}, "weather": {"type": 2}},
    "tide of 2.4": {
        "tide": {"amplitude": 1.2, "period": 90.0, "level": 0.5, "offset": -0.2, "max_rate": 1},
        "time_cycle": {"hour": 8.5},
    },
    "waves": {"fft_waves": {"sea_state": 4, "wind_direction": 35.0}, "time_cycle": {"hour": 16.0, "active": False}},
    "wind": {"fft_waves": {"WindSpeed": 7.5, "WindDirection": -60.0}, "weather": {"type": 1}},
    "lamps": {
        "flashlight": [
            {
                "flashlight_name": "flashlight2",
                "intensity": 3000,
                "beam_width": 31,
                "angle_pitch": 12,
                "angle_yaw": -20,
                "location_x_offset": 0.1,
                "location_y_offset": -0.2,
                "location_z_offset": 0.3,
                "color_R": 0.9,
                "color_G": 0.7,
                "color_B": 0.4,
            }
        ]
    },
}


def scenario_of(more):
    sensors = [
        {"sensor_type": "RGBCamera", "Hz": 15, "configuration": {"CaptureWidth": 24, "CaptureHeight": 16}},
        {
            "sensor_type": "IMUSensor",
            "socket": "IMUSocket",
            "rotation": [5.0, -6.0, 7.0],
            "location": [0.1, 0.2, -0.3],
            "configuration": {"AccelSigma": 0.2, "AccelBiasSigma": 0.03, "AngVelSigma": 0.01},
        },
        {"sensor_type": "DVLSensor", "configuration": {"Elevation": 25.0, "MaxRange": 31.0, "VelSigma": 0.02}},
        {"sensor_type": "GPSSensor", "configuration": {"Sigma": 0.4}, "Hz": 20},
        {
            "sensor_type": "RaycastLidar",
            "Hz": 10,
            "configuration": {"RandomSeed": 7, "Channels": 4, "PointsPerSecond": 400},
        },
        {"sensor_type": "DepthSensor"},
        {"sensor_type": "PoseSensor", "Hz": 10},
        {"sensor_type": "MagnetometerSensor"},
        {"sensor_type": "LocationSensor", "configuration": {"Sigma": 0.1, "Cov": None}},
    ]
    one = agent("HoveringAUV", sensors, location=(2.0, -3.0, -10.0), rotation=[4.0, -7.0, 35.0], scheme=2)
    two = agent(
        "TorpedoAUV",
        name="b-2",
        location=(12.0, 3.0, -11.0),
        rotation=[0.0, 12.0, -160.0],
        scheme=5,
        legacy_dynamics=True,
        location_randomization=[1.0, 2.0, 0.0],
        rotation_randomization=[0.0, 3.0, 40.0],
    )
    return {
        "name": "my scene",
        "world": "Dam",
        "package_name": "Ocean",
        "main_agent": "auv0",
        "ticks_per_sec": 60,
        "agents": [one, two],
        **more,
    }


@pytest.mark.parametrize("name", sorted(SCENARIOS))
def test_scenarios_as_native_ones(name, tmp_path):
    env = _Unbuilt(scenario=copy.deepcopy(scenario_of(SCENARIOS[name])), seed=4)
    env._begin_appearance()
    env._lead = 137
    native = native_scenario(env, env.agents.values())
    path = tmp_path / "it.json"
    path.write_text(json.dumps(scenario_of(SCENARIOS[name])))
    text = converted(path) if name in ("wind", "tide") else ""
    lamps = [env.flashlights.native(a) for a in env.agents]
    env.turn_on_flashlight("flashlight1", 800, 20, angle_yaw=15)
    env.turn_on_flashlight("auv0", "flashlight3", 900, 95, 0.1, 0.2, 0.3, 80, -80)
    lamps += [env.flashlights.native(a) for a in env.agents]
    env.turn_off_flashlight("flashlight3", "auv0")
    lamps += [env.flashlights.native(a) for a in env.agents]
    known(
        f"scenario {name}",
        {
            "native": {k: v for k, v in native.items() if k != "agents"},
            "agents": native["agents"],
            "text": text,
            "lamps": lamps,
            "level": [
                env.sea_level,
                env.tide_cycle.get_height(),
                env.time_cycle.get_time_of_day(),
                env.weather.get_weather(),
            ],
        },
    )


def test_surroundings():
    """What scripts ask of sea, sky and props, as the native simulation has it afterwards."""
    env = opened(
        agent("HoveringAUV", [{"sensor_type": "PoseSensor"}], location=(2.0, -3.0, -6.0)),
        agent("BlueROV2", name="b", location=(4.0, 1.0, -5.0)),
        seed=4,
    )
    found = {}
    with env:

        def told(name, *more):
            env.tick()
            sim = env.pelagos
            ocean = sim.scenario.ocean
            kept = {k: ocean.model_dump(mode="json")[k] for k in ("weather", "sun", "water_type", "turbidity")}
            found[name] = [kept, env.sea_level, *more]

        env.weather.set_weather(2)
        env.change_time_of_day(9.5)
        told("rain in the morning", env.weather.get_weather())
        env.set_rain_parameters(1.0, 2.0, 3.0, 1700)
        env.time_cycle.set_hour(15.0)
        env.air_fog(4.0)
        told("fog", env.time_cycle.get_time_of_day())
        env.water_fog(3.0, 2.0, 0.3, 0.8, 0.5)
        env.tide(1.5)
        env.tide(-0.4, False)
        told("turbid", env.tide_cycle.get_height())
        env.water_fog(0.0)
        env.air_fog(0.0)
        for color in ((1, 2, 7), (1, 2, 3.5), (1, 2, 1.9), (1, 2, 0.5)):
            env.water_color(*color)
            found[f"water {color[2]}"] = [env._pending["water_type"]]
        env.set_ocean_currents("auv0", [0.4, -0.3, 0.1])
        told("clear", env.pelagos.stepper.own_current is not None)
        env.spawn_prop("Box", [3.0, -2.0, -4.0], [10.0, 20.0, -35.0], [1.0, 2.0, 0.5], material="gold")
        env.spawn_prop("cone", [5.0, 2.0, -3.0], scale=0.7, sim_physics=True)
        env.draw_line([0, 1, 2], [3, 4, 5])
        env.draw_arrow([0, 1, 2], [3, -4, 5], [1, 2, 3], 4, 0)
        env.draw_box([1, 1, 2], [3, 4, 1], lifetime=2)
        env.draw_point([7, 8, -9], thickness=3)
        env.draw_debug_vector_field(lambda p: 0.1 * p, [1, 2, 3], [30, 20, 10], 10.0, arrow_size=2.0)
        env.tick(4)
        bodies = [[b.name, np.array(b.position), np.array(b.attitude)] for b in env.pelagos.bodies.bodies]
        found["props"] = [bodies, [dict(d) for d in env.drawings], env.centered_range(4, 0.7)]
        a = env.agents["auv0"]
        moves = []
        a.teleport([1.0, 2.0, -5.0], [25.0, -40.0, 110.0])
        env.tick()
        a.set_physics_state([2.0, -1.0, -4.0], [-15.0, 30.0, -70.0], [0.5, -0.3, 0.2], [20.0, -10.0, 30.0])
        moves.append(copy.deepcopy(a.native_place()))
        a.set_physics_state([2.0, -1.0, -4.0], [-15.0, 30.0, -70.0], [0.5, -0.3, 0.2], [20.0, -10.0, 30.0])
        env.tick()
        a.teleport(rotation=[5.0, 10.0, 15.0])
        moves.append(copy.deepcopy(a.native_place()))
        a.teleport(location=[5.0, 10.0, -3.0])
        moves.append(copy.deepcopy(a.native_place()))
        env.tide_cycle.set_amplitude(1.2)
        env.tide_cycle.set_period(7.0)
        env.tide_cycle.set_active(True)
        env.tick(3)
        found["tide"] = [env.sea_level, env._lead, env._native["ocean"]["tide"], env.tide_cycle.get_height()]
        found["moves"] = [moves, env.tick()["auv0"]["PoseSensor"], env.info()]
    known("surroundings", found, DOUBLE)


def test_messages_through_the_water():
    """Beacons and modems of three vehicles, each message in its own shape, lost and heard ones."""

    def one(name, number, location, rotation, **optical):
        beacon = {
            "sensor_type": "AcousticBeaconSensor",
            "location": [0.2, -0.1, 0.3],
            "configuration": {"id": number, "MaxDistance": 60.0, "CheckVisible": number == 2},
        }
        modem = {
            "sensor_type": "OpticalModemSensor",
            "rotation": [0.0, 0.0, 10.0],
            "configuration": {"id": number, "MaxDistance": 30.0, "LaserAngle": 50, **optical},
        }
        return agent("HoveringAUV", [beacon, modem], name=name, location=location, rotation=rotation)

    env = opened(
        one("a", 1, (2.0, -3.0, -10.0), [10.0, 5.0, 20.0]),
        one("b", 2, (14.0, 5.0, -12.0), [-8.0, 4.0, -160.0]),
        one("c", 5, (-60.0, 30.0, -30.0), [0.0, 15.0, 100.0], LaserAngle=5),
        seed=4,
        ticks_per_sec=1000,
    )
    found = []
    with env:
        for kind, to in (("OWAY", -1), ("OWAYU", [2, 5]), ("MSG_REQ", 2), ("MSG_REQU", 2), ("MSG_REQX", 1)):
            sender = 2 if kind == "MSG_REQX" else 1
            env.send_acoustic_message(sender, to, kind, [3, "word"])
            env.send_optical_message(1, 2, 17)
            env.send_optical_message(2, -1, "light")
            found.append([kind, env.beacons_id, env.beacons_status])
            for tick in range(90):
                state = env.tick()
                for name in ("a", "b", "c"):
                    heard = {k: v for k, v in state[name].items() if k != "t"}
                    if heard:
                        found.append([tick, name, heard])
            found.append(env.beacons_status)
    known("beacons and modems", {"heard": found, "times": [row[0] for row in found if isinstance(row[0], int)]}, DOUBLE)


def test_structures_maps_and_commands(monkeypatch):
    rows = np.arange(12.0).reshape(4, 3) - 5.5
    values = {
        "DVLSensor": [np.arange(7) - 2.5, np.arange(3) + 0.5],
        "IMUSensor": [rows[:2], rows],
        "AcousticBeaconSensor": [
            ["OWAY", 3, "x"],
            ["MSG_RESPX", 3, "x", 0.1, -0.2, 14.5, -9.0],
            ["OWAYU", 1, 0, 0.3, 0.4],
            ["MSG_REQX", 2, 0, 0.5, -0.6, -7.0],
        ],
        "RangeFinderSensor": [np.array([4.5, -1.0, 7.25])],
        "RotationSensor": [np.array([10.0, -20.0, 30.0])],
        "PoseSensor": [np.arange(16.0).reshape(4, 4) - 3.5],
        "DepthSensor": [np.array([-7.5])],
        "ImagingSonar": [np.arange(6.0).reshape(2, 3)],
        "RGBCamera": [np.arange(24, dtype=np.uint8).reshape(2, 3, 4)],
        "GPSSensor": [rows[0]],
        "OrientationSensor": [rows[:3]],
    }
    found = {}
    for kind, given in values.items():
        message, raw = SensorData(kind, "here"), []
        for k, value in enumerate(given):
            message.set_value(1234.7 + k, value)
            raw.append([message.encode(), message.timestamp])
        found[kind] = raw
    keys = OPTIONS["BSTSensor"][0]
    shown = BST_Visualizer(
        {"agents": [{"agent_name": "a", "sensors": [{"sensor_type": "BSTSensor", "configuration": keys}]}]},
        salinity_func=lambda at: at[0] - 2 * at[1] + 3 * at[2],
    )
    shown.update_position([3.0, -7.0, -20.0])
    found["maps"] = [shown.maps()[name][::6, ::4] for name in shown.maps()]
    group, center = commands.CommandsGroup(), commands.CommandCenter()
    for made in (
        commands.TeleportCameraCommand([1, -2.5, 3], [4.0, True, "x"]),
        commands.CustomCommand("go", [1, 2], ["a"]),
        commands.DebugDrawCommand(7, named=[8, "y"]),
    ):
        made.add_number_parameters([9, -1.5])
        made.add_string_parameters("z")
        group.add_command(made)
        center.enqueue_command(made)
    found["commands"] = [group.to_json(), group.size, center.queue_size]
    found["sizes"] = [util.human_readable_size(s) for s in (12, 1536.0, -7e6, 3e13)]
    found["versions"] = [packagemanager.set_world_version(v) for v in ("2.3.4", "2.0.1", "1.9", "3.1.7", "x.1.2")]
    found["schemes"] = [{k: v for k, v in vars(ControlSchemes).items() if k.isupper()}]
    known("structures", found)


def test_packages_and_scenarios_that_come_along(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("HOLODECKPATH", str(tmp_path))
    packagemanager.package_info("Ocean")
    packagemanager.install("Ocean", branch="x")
    packagemanager.scenario_info("Dam-Hovering")
    told = capsys.readouterr().out
    scenarios = {name: packagemanager.get_scenario(name) for name in sorted(packagemanager._files())}
    starts = {}
    for world in ("Dam", "TestWorld"):
        scenario = scenario_of(
            {"world": world, "package_name": packagemanager.get_package_config_for_scenario({"world": world})["name"]}
        )
        monkeypatch.setattr(
            "pelagos.compat.holoocean.making.HoloOceanEnvironment",
            lambda scenario, **keys: [scenario["env_min"], scenario["env_max"], keys],
        )
        starts[world] = make(scenario_cfg=scenario, ticks_per_sec=70, seed=9)
    known("packages", {"told": told, "scenarios": scenarios, "made": starts, "random": random.Random(3).random()})


def test_a_tide_that_goes_from_the_beginning():
    """Its phase counts from the script's first tick, sensors of several rates or not."""
    sensors = [{"sensor_type": "DepthSensor", "Hz": 7}, {"sensor_type": "IMUSensor", "Hz": 20}]
    tide = {"active": True, "amplitude": 1.2, "frequency": 400}
    with opened(agent("HoveringAUV", sensors), seed=4, ticks_per_sec=60, tide_cycle=tide) as env:
        found = [env._lead, env._native["ocean"]["tide"], env.sea_level]
        found += [[env.tick()["t"], env.sea_level] for _ in range(4)]
        env.tide_cycle.set_frequency(300)
        env.tick(2)
        found += [env._lead, env._native["ocean"]["tide"], env.sea_level]
    known("a tide", {"found": found}, DOUBLE)
