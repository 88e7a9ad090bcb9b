"""Every public name of HoloOcean's interface is there, and takes the arguments that scripts give it by name."""

import importlib
import inspect

import pytest

from pelagos.compat import holoocean
from pelagos.compat.holoocean.navigation_sensors import DepthSensor
from pelagos.compat.holoocean.sensors import SensorDefinition, UnknownSensorType

NAMES = {
    "": """make(scenario_name scenario_cfg gl_version window_res verbose show_viewport ticks_per_sec frames_per_sec
        copy_state start_world) __version__ delete_all_octrees delete_world_octrees agents environments exceptions
        holoocean lcm packagemanager sensors fossen_dynamics spaces command util holooceanclient shmem weather
        tide_cycle time_cycle flashlight bst_graph joint_constraints tides fftwaves install installed_packages
        available_packages package_info world_info scenario_info get_scenario load_scenario_file prune remove
        remove_all_packages set_world_version""",
    "environments.HoloOceanEnvironment": """HoloOceanEnvironment(agent_definitions binary_path window_size start_world
        uuid gl_version verbose pre_start_steps show_viewport ticks_per_sec frames_per_sec copy_state scenario set_fps
        set_tps) reset() step(action ticks publish) act(agent_name action) tick(num_ticks publish tick_clock) info()
        add_agent(agent_def is_main_agent) spawn_agent(agent_def is_main_agent)
        set_control_scheme(agent_name control_scheme) get_joint_constraints(agent_name joint_name)
        get_reward_terminal() send_world_command(name num_params string_params) set_fps(fps) set_frames_per_sec(fps)
        set_ticks_per_sec(ticks_per_sec) should_render_viewport(render_viewport) move_viewport(location rotation)
        set_render_quality(render_quality should_keep_fps)
        spawn_prop(prop_type location rotation scale sim_physics material tag)
        draw_line(start end color thickness lifetime) draw_arrow(start end color thickness lifetime)
        draw_box(center extent color thickness lifetime) draw_point(loc color thickness lifetime) water_color(r g b)
        water_fog(fogDensity fogDepth color_R color_G color_B) air_fog(fogDensity fogDepth color_R color_G color_B)
        change_weather(weather_type) set_rain_parameters(vel_x vel_y vel_z spawnRate) change_time_of_day(hour)
        tide(adjustment absolute) turn_on_flashlight(flashlight_name) turn_off_flashlight(flashlight_name)
        set_ocean_currents(agent_name) set_ocean_current(agent_name)
        draw_debug_vector_field(vector_field_function location vector_field_dimensions spacing arrow_thickness
        arrow_size lifetime) centered_range(num_points spacing) initialize_bst_graphs() set_biomass_function(agent_name)
        set_salinity_function(agent_name) set_temperature_function(agent_name)
        send_acoustic_message(id_from id_to msg_type msg_data) send_optical_message(id_from id_to msg_data) beacons
        beacons_id beacons_status modems modems_id change_buoyancy debug_lines enable_world_collisions action_space
        _get_full_state() _get_single_state() __on_exit__() __enter__() __exit__()""",
    "agents": """SphereAgent UavAgent NavAgent AndroidAgent HandAgent TurtleAgent HoveringAUV ScubaDiver TorpedoAUV
        SurfaceVessel BlueROV2 CougUV FixedWing HuskyVehicle ControlSchemes AgentFactory
        AgentDefinition(agent_name agent_type sensors starting_loc starting_rot existing is_main_agent)""",
    "agents.HoloOceanAgent": """act(action) clear_action() set_control_scheme(index) teleport(location rotation)
        set_physics_state(location rotation velocity angular_velocity) add_sensors(sensor_defs)
        remove_sensors(sensor_defs) has_camera() action_space control_schemes""",
    "agents.ControlSchemes": """AUV_THRUSTERS AUV_CONTROL AUV_FORCES TAUV_FINS TAUV_FORCES SV_THRUSTERS SV_CONTROL
        SV_FORCES UAV_TORQUES UAV_ROLL_PITCH_YAW_RATE_ALT SPHERE_DISCRETE SPHERE_CONTINUOUS NAV_TARGET_LOCATION
        TURTLE_DIRECT_TORQUES ANDROID_DIRECT_TORQUES ANDROID_MAX_SCALED_TORQUES""",
    "sensors": """SensorDefinition(agent_name agent_type sensor_name sensor_type socket location rotation config
        existing lcm_channel tick_every) SensorFactory HoloOceanSensor IMUSensor DVLSensor DepthSensor GPSSensor
        MagnetometerSensor LocationSensor RotationSensor OrientationSensor PoseSensor VelocitySensor DynamicsSensor
        RangeFinderSensor CollisionSensor AbuseSensor WorldNumSensor BallLocationSensor JointRotationSensor
        PressureSensor RelativeSkeletalPositionSensor DistanceTask LocationTask FollowTask AvoidTask CupGameTask
        CleanUpTask RGBCamera CameraSensor DepthCamera SemanticSegmentationCamera ViewportCapture RaycastLidar
        RaycastSemanticLidar ImagingSonar ProfilingSonar SidescanSonar SinglebeamSonar RaycastImagingSonar
        GPUImagingSonar RaycastProfilingSonar GPUProfilingSonar RaycastSidescanSonar GPUSidescanSonar
        RaycastSinglebeamSonar GPUSinglebeamSonar SemanticRaycastSinglebeamSonar AcousticBeaconSensor OpticalModemSensor
        BSTSensor""",
    "sensors.SensorDefinition": "_sensor_keys_ _sonar_sensors _heavy_sensors",
    "sensors.CupGameTask": "start_game(num_shuffles speed seed)",
    "sensors.CleanUpTask": "start_task(num_trash use_table)",
    "sensors.BSTSensor": "biomass_model salinity_model temperature_model",
    "sensors.HoloOceanSensor": "data_shape dtype rotate(rotation) reset() set_ticks_per_capture(ticks_per_capture)",
    "spaces": """ActionSpace(shape buffer_shape) ContinuousActionSpace(shape low high sample_fn buffer_shape)
        DiscreteActionSpace(shape low high buffer_shape)""",
    "spaces.ActionSpace": "sample() shape get_low() get_high()",
    "fossen_dynamics": "FossenInterface(vehicle_names scenario multi_agent)",
    "fossen_dynamics.FossenInterface": """update set_u_control get_u_control get_control_mode set_control_mode
        set_goal(vehicle_name depth heading rpm) set_depth_goal set_heading_goal set_rpm_goal""",
    "weather.WeatherController": "get_weather() set_weather(weather_type)",
    "tide_cycle": "TideController(client amplitude frequency tide_type active)",
    "tides.TideController": """set_amplitude(amplitude) set_frequency(frequency) set_active(active)
        set_tide_type(tide_type) get_height()""",
    "time_cycle": "TimeController(client frequency hour active)",
    "time_cycle.TimeController": "set_frequency(frequency) set_hour(hour) set_active(active) get_time_of_day()",
    "flashlight": "FlashlightController(client flashlight_name)",
    "fftwaves.FFTWaveController": "fft_sea_state fft_wave_scalars fft_wave_cascades",
    "packagemanager": """available_packages() installed_packages() install(package_name url branch commit) remove
        remove_all_packages() prune() package_info world_info(world_name world_config base_indent)
        scenario_info(scenario_name scenario base_indent) get_scenario load_scenario_file get_binary_path_for_package
        get_binary_path_for_scenario get_package_config_for_scenario set_world_version _iter_packages
        _iter_scenarios""",
    "util": "get_holoocean_version() get_holoocean_path() get_os_key() human_readable_size convert_unicode",
    "lcm": "gen(lang path headers) SensorData(sensor_type channel)",
    "lcm.SensorData": "set_value(timestamp value)",
    "holoocean": "GL_VERSION make",
    "holoocean.GL_VERSION": "OPENGL4 OPENGL3",
    "holooceanclient": "HoloOceanClient(uuid)",
    "holooceanclient.HoloOceanClient": "acquire(timeout) release() malloc(key shape dtype)",
    "shmem": "Shmem(name shape dtype uuid)",
    "bst_graph": "BST_Visualizer(config biomass_function salinity_function temperature_function agent)",
    "bst_graph.BST_Visualizer": "update_position update_plots() show() close() update",
    "exceptions": "HoloOceanException HoloOceanConfigurationException TimeoutException NotFoundException",
    "command": """Command CommandsGroup CommandCenter(client) CustomCommand(name num_params string_params)
        SpawnAgentCommand DebugDrawCommand TeleportCameraCommand AddSensorCommand RemoveSensorCommand
        RotateSensorCommand OceanCurrentsCommand RenderViewportCommand RGBCameraRateCommand RaycastLidarRateCommand
        AdjustRenderQualityCommand WaterColorCommand TideCommand ChangeWeatherCommand SetRainParametersCommand
        ChangeTimeOfDayCommand AdjustFPSCommand AdjustTPSCommand TurnOnFlashlightCommand TurnOffFlashlightCommand
        AirFogCommand WaterFogCommand SendAcousticMessageCommand SendOpticalMessageCommand""",
    "command.CommandCenter": "enqueue_command handle_buffer() clear() queue_size",
}  # fmt: skip


def entries(text):
    """Names, with their arguments where these are listed."""
    words, found = " ".join(text.split()), []
    while words:
        cut = min((i for i in (words.find("("), words.find(" ")) if i >= 0), default=len(words))
        name, listed = words[:cut], cut < len(words) and words[cut] == "("
        end = words.index(")", cut) + 1 if listed else cut
        found.append((name, words[cut + 1 : end - 1].split() if listed else None))
        words = words[end:].strip()
    return found


def thing(path):
    found = holoocean
    for i, part in enumerate(path.split(".") if path else ()):
        found = importlib.import_module(f"{holoocean.__name__}.{part}") if i == 0 else getattr(found, part)
    return found


@pytest.mark.parametrize("path", NAMES)
def test_a_name_is_there_and_takes_its_arguments(path):
    for name, arguments in entries(NAMES[path]):
        home = thing(path)
        found = home if name == getattr(home, "__name__", "") else getattr(home, name)
        if arguments is not None:
            taken = [p for p in inspect.signature(found).parameters if p != "self"]
            assert taken[: len(arguments)] == arguments, f"{path}.{name}"


def test_the_starred_names_are_those_of_holoocean():
    listed = "agents environments exceptions holoocean lcm make packagemanager sensors fossen_dynamics"
    assert set(listed.split()) <= set(holoocean.__all__)


def test_commands_take_their_numbers_by_name():
    from pelagos.compat.holoocean.command import CustomCommand, DebugDrawCommand, TideCommand

    assert TideCommand(adjustment=3.5, absolute=True).to_json() == TideCommand(3.5, True).to_json()
    drawn = DebugDrawCommand(0, [1, 2, 3], end=[4, 5, 6], color=[7, 8, 9], thickness=10, lifetime=11)
    assert drawn.numbers == [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]
    assert CustomCommand("Flood", [1, 2], ["fast"]).strings == ["Flood", "fast"]


def test_a_flashlight_controller_takes_its_numbers_in_order_and_by_its_setters():
    from pelagos.compat.holoocean.flashlight import FlashlightController

    class Lamps:
        def turn_on_flashlight(self, name, **keys):
            self.told = name, keys

    lamps = Lamps()
    controller = FlashlightController(lamps, "flashlight2", 700, 33, angle_yaw=5)
    controller.set_angle_pitch(-12)
    controller.set_flashlight()
    assert lamps.told == ("flashlight2", {"intensity": 700, "beam_width": 33, "angle_yaw": 5, "angle_pitch": -12})


def test_a_scripts_own_class_replaces_no_type(monkeypatch):
    """As in HoloOcean a class is given itself, or put into `_sensor_keys_`, before the first environment or later."""
    own = type("OwnDepth", (DepthSensor,), {})
    other = type("Other", (DepthSensor,), {"sensor_type": "OtherDepth"})
    monkeypatch.setattr(SensorDefinition, "_sensor_keys_", {})
    assert SensorDefinition("a", "SphereAgent", "s", "DepthSensor").type is DepthSensor
    assert SensorDefinition("a", "SphereAgent", "s", own).type is own
    with pytest.raises(UnknownSensorType, match="no sensor type 'OtherDepth'"):
        SensorDefinition("a", "SphereAgent", "s", "OtherDepth")
    monkeypatch.setattr(SensorDefinition, "_sensor_keys_", {"OtherDepth": other})
    assert SensorDefinition("a", "SphereAgent", "s", "OtherDepth").type is other
    assert SensorDefinition("a", "SphereAgent", "s", "DepthSensor").type is DepthSensor
