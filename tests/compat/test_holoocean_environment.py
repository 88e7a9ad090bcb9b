"""HoloOcean's interface: what a script gets, after the descriptions of HoloOcean's own tests."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import pelagos.compat.holoocean as holoocean
from pelagos.compat.holoocean.advice import HoloOceanWarning
from pelagos.compat.holoocean.environments import HoloOceanEnvironment
from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException, HoloOceanException
from pelagos.compat.holoocean.frames import degrees_of, matrix_of

NAVIGATION = [
    {"sensor_type": "IMUSensor", "socket": "IMUSocket", "Hz": 15, "configuration": {"ReturnBias": True}},
    {"sensor_type": "DVLSensor", "socket": "DVLSocket"},
    {"sensor_type": "LocationSensor"},
    {"sensor_type": "RotationSensor"},
    {"sensor_type": "PoseSensor"},
    {"sensor_type": "DepthSensor"},
    {"sensor_type": "MagnetometerSensor", "configuration": {"MagneticVector": [0.3, -0.2, 0.5]}},
    {"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True, "UseRPY": True}},
]


def agent(kind="HoveringAUV", sensors=(), *, name="auv0", scheme=0, location=(0, 0, -10), **more):
    sensors = [{**s, "configuration": dict(s.get("configuration") or {})} for s in sensors]
    return {
        "agent_name": name, "agent_type": kind, "sensors": sensors, "control_scheme": scheme,
        "location": list(location), **more,
    }  # fmt: skip


def make(*agents, tps=30, **more):
    scenario = {"name": "t", "world": "TestWorld", "package_name": "TestWorlds", "ticks_per_sec": tps, "agents": agents}
    keys = {k: more.pop(k) for k in ("seed", "legacy_dynamics", "strict") if k in more}
    keys.setdefault("seed", 0)
    return holoocean.make(scenario_cfg={**scenario, "agents": list(agents), **more}, **keys)


def test_one_agent_gives_a_flat_state_with_every_sensor_at_the_first_tick_and_then_at_its_rate():
    env = make(agent(sensors=NAVIGATION, rotation=[20.0, -30.0, 70.0]))
    states = [env.tick() for _ in range(4)]
    assert [s["t"] for s in states] == [k / 30 for k in range(4)]
    assert ["IMUSensor" in s for s in states] == [True, False, True, False]
    first = states[0]
    shapes = {
        "IMUSensor": (4, 3),
        "DVLSensor": (7,),
        "PoseSensor": (4, 4),
        "DepthSensor": (1,),
        "DynamicsSensor": (18,),
    }
    assert {k: first[k].shape for k in shapes} == shapes
    np.testing.assert_allclose(first["PoseSensor"][:3, :3], matrix_of(first["RotationSensor"]), atol=1e-6)
    np.testing.assert_allclose(degrees_of(matrix_of([20.0, -30.0, 70.0])), [20.0, -30.0, 70.0])
    np.testing.assert_allclose(first["DepthSensor"], first["LocationSensor"][2:])
    field = first["PoseSensor"][:3, :3].T @ [0.3, -0.2, 0.5]
    np.testing.assert_allclose(first["MagnetometerSensor"], field, atol=1e-6)


def test_an_acceleration_scheme_gives_what_was_asked_in_the_world_frame():
    env = make(agent(sensors=NAVIGATION, scheme=2))
    state = [env.step([1, 2, 3, 0.1, 0.2, 0.3]) for _ in range(20)][-1]
    dynamics = state["DynamicsSensor"]
    np.testing.assert_allclose(dynamics[:3], [1, 2, 3], rtol=1e-5)
    np.testing.assert_allclose(dynamics[9:12], [0.1, 0.2, 0.3], rtol=1e-4)  # in single precision, over differences


def test_a_pose_is_reached():
    env = make(agent(sensors=NAVIGATION, scheme=1))
    state = env.step([2, 2, -12, 0, 20, 45], ticks=200)
    np.testing.assert_allclose(state["LocationSensor"], [2, 2, -12], rtol=0.1)
    assert abs(state["RotationSensor"][2] - 45) < 5


def test_several_agents_are_nested_and_teleport_keeps_the_motion_in_the_world():
    env = make(
        agent(sensors=NAVIGATION[2:5], scheme=2), agent(sensors=NAVIGATION[2:3], name="auv1", location=(9, 4, -8))
    )
    env.act("auv0", [1.0, 0, 0, 0, 0, 0])
    env.tick(30)
    env.act("auv0", np.zeros(6))
    env.agents["auv0"].teleport([3.0, -4.0, -7.0], [0, 0, 90])
    here = env.tick()["auv0"]
    there = env.tick()["auv0"]
    np.testing.assert_allclose(here["RotationSensor"], [0, 0, 90], atol=1e-4)
    speed = 30 * (there["LocationSensor"] - here["LocationSensor"])
    assert speed[0] > 0.9
    assert abs(speed[1]) < 1e-4
    assert set(env.tick()) == {"auv0", "auv1", "t"}


def test_beacons_answer_after_the_time_of_sound():
    def beacon(number):
        return {"sensor_type": "AcousticBeaconSensor", "configuration": {"id": number}}

    env = make(agent(sensors=[beacon(0)]), agent(sensors=[beacon(1)], name="auv1", location=(100, 0, -10)))
    env.send_acoustic_message(0, 1, "MSG_REQX", {"any": "thing"})
    heard = [
        (k, n, s[n]["AcousticBeaconSensor"]) for k in range(8) if (s := env.tick()) for n in ("auv0", "auv1") if s[n]
    ]
    ticks = round(100 * 30 / 1500)
    assert [(k, n) for k, n, _ in heard] == [(ticks, "auv1"), (2 * ticks + 1, "auv0")]
    assert heard[0][2][:3] == ["MSG_REQX", 0, {"any": "thing"}]
    np.testing.assert_allclose(heard[1][2][3:], [0.0, 0.0, 100.0, -10.0], atol=1e-6)
    assert env.beacons_status == ["Idle", "Idle"]


def test_biology_is_that_of_the_reference_numbers():
    clusters = [{"position": [10, 10, -10], "strength": 2, "falloff": 10}]
    config = {f"{name}_clusters": clusters for name in ("biomass", "salinity", "temperature")}
    env = make(
        agent(sensors=[{"sensor_type": "BSTSensor", "socket": "COM", "configuration": config}], location=(5, 10, -10))
    )
    np.testing.assert_allclose(env.tick()["BSTSensor"], [2.365897, 34.238064, 24.01283], rtol=2e-6)


def test_the_same_seed_gives_the_same_numbers():
    def run(seed):
        noisy = [{"sensor_type": "LocationSensor", "configuration": {"Sigma": 0.1}}]
        env = make(agent(sensors=noisy, location_randomization=[1, 2, 3]), seed=seed)
        return np.stack([env.tick()["LocationSensor"] for _ in range(3)])

    assert (run(7) == run(7)).all()
    assert (run(7) != run(8)).all()


def test_without_a_seed_every_environment_draws_one_that_repeats_its_noise():
    def run(seed):
        noisy = [{"sensor_type": "LocationSensor", "configuration": {"Sigma": 0.1}}]
        env = make(agent(sensors=noisy), seed=seed)
        assert env.pelagos.seed == env.seed
        return env.seed, np.stack([env.tick()["LocationSensor"] for _ in range(3)])

    (first, seen), (second, other) = run(None), run(None)
    assert first != second
    assert (seen != other).all()
    assert (run(first)[1] == seen).all()


def test_what_is_wrong_is_refused_by_holooceans_names():
    with pytest.raises(HoloOceanException, match="IMUSensor"):
        make(agent(sensors=[{"sensor_type": "ImuSensor"}]))
    with pytest.raises(ValueError, match="above ticks_per_sec"):
        make(agent(sensors=[{"sensor_type": "IMUSensor", "Hz": 60}]))
    with pytest.raises(KeyError, match="UavAgent"):
        make(agent("UAV"))
    both = {"Sigma": 1, "Cov": 1}
    with pytest.raises(ValueError, match="not both"):
        make(agent(sensors=[{"sensor_type": "LocationSensor", "configuration": both}]))
    typo = [{"sensor_type": "IMUSensor", "configuration": {"AccelSigm": 1}}]
    with pytest.raises(HoloOceanConfigurationException, match="AccelSigma"):
        make(agent(sensors=typo), strict=True)
    with pytest.warns(HoloOceanWarning, match="AccelSigma"):
        env = make(agent(sensors=typo))
    with pytest.raises(HoloOceanException, match="at most 8"):
        env.act("auv0", np.ones(9))
    with pytest.raises(TypeError):
        env.draw_line((0, 0, 0), [1, 1, 1])
    with pytest.raises(HoloOceanException, match="sphere"):
        env.spawn_prop("spere")


@pytest.mark.parametrize("legacy", [False, True])
@pytest.mark.parametrize("names", [("auv0",), ("auv0", "auv1")])
def test_a_current_is_gone_after_a_reset(names, legacy):
    where = [{"sensor_type": "LocationSensor"}]
    starts = [agent(name=n, sensors=where, location=(-60, 5.0 * k, -10)) for k, n in enumerate(names)]
    env = make(*starts, legacy_dynamics=legacy)

    def drifted():
        state = env.tick(40)
        return np.stack([(state if len(names) == 1 else state[n])["LocationSensor"] for n in names])

    still = drifted()
    env.reset()
    for name in names:
        env.set_ocean_currents(name, [0.8, -0.3, 0.1])
    assert ((drifted() - still) @ [1, -1, 1] > 0.01).all()
    env.reset()
    np.testing.assert_allclose(drifted(), still, atol=1e-6)


def test_a_current_of_one_vehicle_moves_no_other():
    where = [{"sensor_type": "LocationSensor"}]
    names = ("auv0", "auv1")
    env = make(*(agent(name=n, sensors=where, location=(-60, 5.0 * k, -10)) for k, n in enumerate(names)))

    def drifted():
        state = env.tick(40)
        return np.stack([state[n]["LocationSensor"] for n in names])

    still = drifted()
    env.reset()
    env.set_ocean_currents("auv1", [0.8, -0.3, 0.1])
    first, second = (drifted() - still) @ [1, -1, 1]
    assert abs(first) < 1e-6
    assert second > 0.01


def test_an_unknown_main_agent_is_told_of():
    with pytest.warns(HoloOceanWarning, match=r"main_agent.*'auv1'.*did you mean 'auv0'"):
        assert make(agent(), main_agent="auv1")._agent is None
    with pytest.raises(HoloOceanConfigurationException, match="did you mean 'auv0'"):
        make(agent(), main_agent="auv1", strict=True)


@pytest.mark.parametrize("key", ["location", "rotation", "location_randomization"])
def test_a_place_has_three_numbers(key):
    with pytest.raises(HoloOceanException, match=rf"agent auv0: {key} is three finite numbers, not \[1, 2, -3, 4\]"):
        make({**agent(), key: [1, 2, -3, 4]})
    sensor = {"sensor_type": "PoseSensor", "sensor_name": "P", "location": [0.1, 0.2]}
    with pytest.raises(HoloOceanException, match=r"auv0.P: location is three finite numbers, not \[0.1, 0.2\]"):
        make({**agent(), "sensors": [sensor]})


def test_noise_of_another_size_is_refused_with_its_sensor_and_key():
    for key, wrong in (("AccelSigma", [0.1, 0.2]), ("AccelCov", [0.1, 0.2]), ("AngVelSigma", [[1, 2], [3, 4]])):
        imu = {"sensor_type": "IMUSensor", "sensor_name": "I", "configuration": {key: wrong}}
        with pytest.raises(ValueError, match=rf"auv0.I: {key} is a number.* 3 .*not \[") as caught:
            make(agent(sensors=[imu]))
        assert "nditer" not in str(caught.value)


def test_names_that_are_not_there_are_said_with_those_that_are():
    stations = [{"sensor_type": t, "configuration": {"id": 3}} for t in ("AcousticBeaconSensor", "OpticalModemSensor")]
    env = make(agent(sensors=stations))
    for ask, words in (
        (lambda: env.send_acoustic_message(0, 3, "OWAY", "x"), "acoustic beacon with the id 0; there is 3 of auv0"),
        (lambda: env.send_acoustic_message(3, [3, 4], "OWAY", "x"), "acoustic beacon with the id 4; there is 3 of"),
        (lambda: env.send_optical_message(5, 3, "x"), "optical modem with the id 5; there is 3 of auv0"),
        (lambda: env.send_optical_message(3, 6, "x"), "optical modem with the id 6; there is 3 of auv0"),
        (lambda: env.set_ocean_currents("auv", [1, 2, 3]), r"agent 'auv' \(did you mean 'auv0'\?\); there is auv0"),
        (lambda: env.act("nobody", [0]), "agent 'nobody'; there is auv0"),
        (lambda: env.set_biomass_function("auv0", None), "sensor of auv0 'BSTSensor'"),
    ):
        with pytest.raises(KeyError, match=f"^there is no {words}"):
            ask()
    with pytest.raises(HoloOceanException, match=r"auv0: a current .* three finite numbers, not \[1, 2\]"):
        env.set_ocean_currents("auv0", [1, 2])
    assert env.beacons_status == ["Idle"]


def test_a_script_imports_holoocean_and_nothing_is_shadowed_without_being_asked(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import sys, holoocean\n"
        "from holoocean.environments import HoloOceanEnvironment\n"
        "from holoocean.fossen_dynamics import FossenInterface\n"
        "import holoocean.sensors, holoocean.command, holoocean.lcm, holoocean.spaces, holoocean.packagemanager\n"
        "assert holoocean.sensors.SensorDefinition._sonar_sensors\n"
        "print(holoocean.__version__, 'TestWorlds' in holoocean.installed_packages(), sys.argv[1:])\n"
    )
    run = [sys.executable, "-m", "pelagos", "holoocean", str(script), "-x", "--seed"]
    done = subprocess.run(run, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "2.3.0 True ['-x', '--seed']", done.stderr
    plain = subprocess.run(
        [sys.executable, "-c", "import pelagos, holoocean"], capture_output=True, text=True, check=False
    )
    assert "No module named 'holoocean'" in plain.stderr or "pelagos" not in plain.stderr


def test_a_programs_errors_are_told_from_its_own_first_line_on(tmp_path, monkeypatch, capsys):
    from pelagos.cli.main import main

    (tmp_path / "wrong.py").write_text("import holoocean\ndef f():\n    return 1 / 0\nf()\n")
    (tmp_path / "list.json").write_text("[1]")
    (tmp_path / "bare.json").write_text('{"name": "x"}')

    def run(*arguments):
        command = [sys.executable, "-m", "pelagos", "holoocean", *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
        return done.returncode, done.stderr

    status, text = run("wrong.py")
    assert status == 1
    assert [line.split(",")[0].strip() for line in text.splitlines() if "File" in line] == ['File "wrong.py"'] * 2
    assert run("-m", "no_such_module") == (2, "wrong input: there is no module 'no_such_module' to run\n")
    monkeypatch.chdir(tmp_path)
    for name, word in (("list", "a scenario is a mapping, not a list"), ("bare", "the key 'agents' is missing")):
        with pytest.raises(SystemExit) as ended:
            main(["holoocean", "--convert", f"{name}.json", "out.yaml"])
        assert ended.value.code == 2
        assert word in capsys.readouterr().err


def test_a_scenario_becomes_a_native_one(tmp_path):
    import json

    from pelagos.cli.main import main
    from pelagos.config.loader import load_scenario

    scenario = holoocean.get_scenario("Dam-Hovering")
    path, out = tmp_path / "Dam-Hovering.json", tmp_path / "out.yaml"
    path.write_text(json.dumps(scenario))
    with pytest.raises(SystemExit) as ended:
        main(["holoocean", "--convert", str(path), str(out)])
    assert ended.value.code in (0, None)
    native = load_scenario(out)
    assert native.agents["auv0"].sensors["DVLSensor"].type == "dvl"
    assert out.read_text().startswith("# From HoloOcean's Dam-Hovering.json")


def test_sensors_count_on_over_ticks_without_a_look():
    sensors = [SimpleNamespace(tick_every=every, tick_count=count) for every, count in ((5, 3), (1, 0), (4, 2))]
    agent = SimpleNamespace(sensors=dict(enumerate(sensors)))
    env = SimpleNamespace(_num_ticks=10, _total_ticks=30, agents={"it": agent})
    HoloOceanEnvironment._count(env, 7)
    assert (env._num_ticks, env._total_ticks) == (17, 37)
    assert [s.tick_count for s in sensors] == [0, 0, 1]
