"""Interface texts of services and of command messages that are not part of ROS 2's common interfaces.

Names and fields are those of std_srvs, of simulation_interfaces 2.1 (the standard that simulators share,
https://github.com/ros-simulation/simulation_interfaces) and of holoocean_interfaces (Brigham Young University), so that
their clients understand our answers. pelagos_msgs is our own.
"""

from __future__ import annotations

from typing import Any, Final

COMMANDS: Final = {
    "holoocean_interfaces/msg/AgentCommand": "std_msgs/Header header\nfloat64[] command\n",
    "holoocean_interfaces/msg/DesiredCommand": "std_msgs/Header header\nfloat64 data\n",
    "holoocean_interfaces/msg/SensorCommand": "string agent_name\nstring sensor_name\nfloat64[3] rotation\n",
    "holoocean_interfaces/msg/DVLSensorRange": "std_msgs/Header header\nfloat32[4] range\n",
    "simulation_interfaces/msg/Resource": "string uri\nstring resource_string\n",
    "simulation_interfaces/msg/Result": (
        "uint8 RESULT_FEATURE_UNSUPPORTED = 0\nuint8 RESULT_OK = 1\nuint8 RESULT_NOT_FOUND = 2\n"
        "uint8 RESULT_INCORRECT_STATE = 3\nuint8 RESULT_OPERATION_FAILED = 4\nuint8 result\nstring error_message\n"
    ),
    "simulation_interfaces/msg/SimulationState": (
        "uint8 STATE_STOPPED = 0\nuint8 STATE_PLAYING = 1\nuint8 STATE_PAUSED = 2\nuint8 STATE_QUITTING = 3\n"
        "uint8 STATE_NO_WORLD = 4\nuint8 STATE_LOADING_WORLD = 5\nuint8 state\n"
    ),
    "simulation_interfaces/msg/SimulatorFeatures": (
        "uint16[] features\nstring[] spawn_formats\nstring custom_info\n"
    ),
    "simulation_interfaces/msg/EntityState": (
        "std_msgs/Header header\ngeometry_msgs/Pose pose\ngeometry_msgs/Twist twist\ngeometry_msgs/Accel acceleration\n"
    ),
    "simulation_interfaces/msg/EntityCategory": "uint8 category\n",
    "simulation_interfaces/msg/TagsFilter": "string[] tags\nuint8 filter_mode\n",
    "simulation_interfaces/msg/Bounds": "uint8 type\ngeometry_msgs/Vector3[] points\n",
    "simulation_interfaces/msg/EntityFilters": (
        "string filter\nEntityCategory[] categories\nTagsFilter tags\nBounds bounds\n"
    ),
}  # fmt: skip

SERVICES: Final = {
    "std_srvs/srv/Empty": ("", ""),
    "std_srvs/srv/SetBool": ("bool data\n", "bool success\nstring message\n"),
    "std_srvs/srv/Trigger": ("", "bool success\nstring message\n"),
    "simulation_interfaces/srv/ResetSimulation": ("uint8 scope\n", "Result result\n"),
    "simulation_interfaces/srv/StepSimulation": ("uint64 steps\n", "Result result\n"),
    "simulation_interfaces/srv/GetSimulationState": ("", "SimulationState state\nResult result\n"),
    "simulation_interfaces/srv/SetSimulationState": ("SimulationState state\n", "Result result\n"),
    "simulation_interfaces/srv/GetSimulatorFeatures": ("", "SimulatorFeatures features\n"),
    "simulation_interfaces/srv/GetEntities": ("EntityFilters filters\n", "Result result\nstring[] entities\n"),
    "simulation_interfaces/srv/GetEntityState": ("string entity\n", "Result result\nEntityState state\n"),
    "simulation_interfaces/srv/SetEntityState": (
        "string entity\nEntityState state\nbool set_pose\nbool set_twist\nbool set_acceleration\n", "Result result\n",
    ),
    "simulation_interfaces/srv/SpawnEntity": (
        "string name\nbool allow_renaming\nResource entity_resource\nstring entity_namespace\n"
        "geometry_msgs/PoseStamped initial_pose\n",
        "Result result\nstring entity_name\n",
    ),
    "simulation_interfaces/srv/DeleteEntity": ("string entity\n", "Result result\n"),
    "holoocean_interfaces/srv/SetControlMode": (
        "string vehicle_name\nint32 mode\n", "bool success\nstring message\n",
    ),
    "pelagos_msgs/srv/SetControlMode": ("string agent\nstring mode\n", "bool success\nstring message\n"),
    "pelagos_msgs/srv/SetOcean": (
        "# `name` is a property of the water (current [m/s] in `map`, ENU; turbidity, a factor)\n"
        "string name\nfloat64[] values\n",
        "bool success\nstring message\n",
    ),
}  # fmt: skip

_EMPTY: Final = "uint8 structure_needs_at_least_one_member\n"


def definitions() -> dict[str, Any]:
    """Every type of this file, as a typestore of rosbags takes them; "pkg/srv/X_Request" names half of a service."""
    from rosbags.typesys import get_types_from_msg

    found: dict[str, Any] = {}
    for name, text in COMMANDS.items():
        found.update(get_types_from_msg(text, name))
    for name, halves in SERVICES.items():
        package, _, short = name.split("/")
        for half, text in zip(("Request", "Response"), halves, strict=True):
            (parsed,) = get_types_from_msg(text or _EMPTY, f"{package}/msg/{short}_{half}").values()
            found[f"{name}_{half}"] = parsed
    return found
