"""HoloOcean's packages, worlds and shipped scenarios, and its package manager."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pelagos.compat.holoocean import packagemanager, util
from pelagos.compat.holoocean.exceptions import HoloOceanException, NotFoundException
from pelagos.compat.holoocean.worlds import native_world, package_configs
from pelagos.config.scenario import Scenario
from pelagos.world.build import world_config

SCENARIOS = {  # holoocean-docs, pages of the worlds: agent, sensors besides the base set
    "Dam-Hovering": ("HoveringAUV", []),
    "Dam-HoveringCamera": ("HoveringAUV", ["LeftCamera", "RightCamera"]),
    "Dam-HoveringImagingSonar": ("HoveringAUV", ["ImagingSonar"]),
    "OpenWater-Hovering": ("HoveringAUV", []),
    "OpenWater-HoveringCamera": ("HoveringAUV", ["LeftCamera", "RightCamera"]),
    "OpenWater-HoveringImagingSonar": ("HoveringAUV", ["ImagingSonar"]),
    "OpenWater-Torpedo": ("TorpedoAUV", []),
    "OpenWater-TorpedoProfilingSonar": ("TorpedoAUV", ["ProfilingSonar"]),
    "OpenWater-TorpedoSidescanSonar": ("TorpedoAUV", ["SidescanSonar"]),
    "OpenWater-TorpedoSinglebeamSonar": ("TorpedoAUV", ["SinglebeamSonar"]),
    "PierHarbor-Hovering": ("HoveringAUV", []),
    "PierHarbor-HoveringCamera": ("HoveringAUV", ["LeftCamera", "RightCamera"]),
    "PierHarbor-HoveringImagingSonar": ("HoveringAUV", ["ImagingSonar"]),
    "PierHarbor-Torpedo": ("TorpedoAUV", []),
    "SimpleUnderwater-Hovering": ("HoveringAUV", []),
    "SimpleUnderwater-Torpedo": ("TorpedoAUV", []),
    "Rooms-DataGen": ("TurtleAgent", ["LocationSensor", "RotationSensor", "RangeFinderSensor"]),
}
BASE = ["IMUSensor", "GPSSensor", "DVLSensor", "DepthSensor", "PoseSensor", "VelocitySensor"]


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HOLODECKPATH", str(tmp_path))


def _names(scenario):
    return [s.get("sensor_name", s["sensor_type"]) for s in scenario["agents"][0]["sensors"]]


def test_the_seventeen_scenarios_ship_and_no_others():
    found = {
        f"{s['world']}-{s['name']}"
        for config, _ in packagemanager._iter_packages()
        for world in config["worlds"]
        for s, _ in packagemanager._iter_scenarios(world["name"])
    }
    assert found == set(SCENARIOS)


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_shipped_scenario_has_its_agent_and_its_sensors(name):
    scenario = packagemanager.get_scenario(name)
    agent, extra = SCENARIOS[name]
    assert len(scenario["agents"]) == 1
    assert scenario["agents"][0]["agent_type"] == agent
    base = (
        []
        if agent == "TurtleAgent"
        else [b for b in BASE if (name, b) != ("OpenWater-TorpedoSidescanSonar", "DepthSensor")]
    )
    assert _names(scenario) == base + extra  # a sonar stands last, where scripts look for it
    assert scenario["main_agent"] == scenario["agents"][0]["agent_name"]
    fastest = max((s.get("Hz", 0) for s in scenario["agents"][0]["sensors"]), default=0)
    assert scenario["ticks_per_sec"] >= fastest
    for sensor in scenario["agents"][0]["sensors"]:
        assert scenario["ticks_per_sec"] % sensor.get("Hz", 1) == 0  # no rate is rounded


def test_a_scenario_is_a_fresh_copy():
    packagemanager.get_scenario("Dam-Hovering")["agents"].clear()
    assert packagemanager.get_scenario("Dam-Hovering")["agents"]


@pytest.mark.parametrize(
    ("package", "world"), [(p, w["name"]) for p, c in package_configs().items() for w in c["worlds"]]
)
def test_every_world_is_a_native_scenario_in_the_making(package, world):
    fragment = native_world(package, world)
    assert native_world("", world) == fragment
    whole = Scenario.model_validate({"name": "x", **fragment, "agents": {"a": {"vehicle": "bluerov2"}}})
    assert whole.world is not None
    world_config(fragment["world"])
    fragment["world"].clear()
    assert native_world(package, world)["world"]


@pytest.mark.parametrize(
    ("package", "world", "kind", "message"),
    [
        ("Ocaen", "Dam", NotFoundException, "did you mean 'Ocean'"),
        ("Ocean", "OpenWatr", HoloOceanException, "did you mean 'OpenWater'"),
        ("Ocean", "TestWorld", HoloOceanException, "it is in 'TestWorlds'"),
    ],
)
def test_unknown_worlds_are_refused_with_the_nearest(package, world, kind, message):
    with pytest.raises(kind, match=message):
        native_world(package, world)


def test_own_scenarios_are_found_beside_the_shipped_ones(tmp_path):
    folder = tmp_path / util.VERSION / "worlds" / "Ocean"
    folder.mkdir(parents=True)
    mine = packagemanager.get_scenario("Dam-Hovering") | {"name": "Mine"}
    (folder / "Dam-Mine.json").write_text(json.dumps(mine))
    (folder / "Dam-Hovering.json").write_text("{}")
    (folder / "Dam-Broken.json").write_text("{")
    assert packagemanager.get_scenario("Dam-Mine") == mine
    assert packagemanager.get_scenario("Dam-Hovering")["agents"]
    with pytest.raises(HoloOceanException, match=r"Dam-Broken.json: not JSON: .*line 1"):
        packagemanager.get_scenario("Dam-Broken")


def test_information_is_printed(capsys):
    packagemanager.package_info("Ocean")
    told = capsys.readouterr().out
    assert all(name in told for name in SCENARIOS)
    packagemanager.world_info("Rooms", base_indent=3)
    assert capsys.readouterr().out.startswith("   Rooms\n")
    packagemanager.scenario_info("Dam-HoveringCamera")
    assert "LeftCamera (RGBCamera)" in capsys.readouterr().out


def test_nothing_is_downloaded_or_removed(capsys):
    assert packagemanager.installed_packages() == packagemanager.available_packages()
    assert {"Ocean", "TestWorlds", "BusinessCampus"} == set(packagemanager.installed_packages())
    packagemanager.install("Ocean", branch="develop")
    assert "nothing to install (branch: without effect)" in capsys.readouterr().out
    packagemanager.install("Ocen")
    assert "did you mean 'Ocean'" in capsys.readouterr().out
    packagemanager.remove_all_packages()
    packagemanager.prune()
    assert set(packagemanager.installed_packages()) == set(packagemanager.available_packages())


@pytest.mark.parametrize(
    ("call", "kind", "message"),
    [
        (lambda: packagemanager.get_scenario("Pier-Hovering"), FileNotFoundError, "PierHarbor-Hovering"),
        (lambda: packagemanager.scenario_info("Dam-Hoverin"), FileNotFoundError, "Dam-Hovering"),
        (lambda: packagemanager.world_info("Damm"), HoloOceanException, "did you mean 'Dam'"),
        (lambda: packagemanager.get_binary_path_for_package("Sea"), NotFoundException, "no package 'Sea'"),
        (lambda: packagemanager.get_package_config_for_scenario({"world": "Moon"}), HoloOceanException, "a world"),
        (lambda: packagemanager.get_package_config_for_scenario({}), KeyError, "world"),
        (lambda: packagemanager.load_scenario_file("nowhere.json"), FileNotFoundError, "nowhere"),
    ],
)  # fmt: skip
def test_what_is_not_there_is_refused_by_holooceans_exceptions(call, kind, message):
    with pytest.raises(kind, match=message):
        call()


def test_the_package_of_a_scenario():
    assert packagemanager.get_package_config_for_scenario({"world": "TestWorld"})["name"] == "TestWorlds"
    entry = packagemanager.get_package_config_for_scenario({"world": "TestWorld"})["worlds"][-1]
    assert (entry["env_min"], entry["env_max"], entry["pre_start_steps"]) == ([-40, -40, -10], [40, 40, 10], 20)
    assert packagemanager.get_binary_path_for_scenario("Dam-Hovering").endswith("Ocean")


def test_versions_share_worlds_from_2_1_on():
    given = ("2.0.1", "2.1.3", "2.3.2", "develop")
    assert [packagemanager.set_world_version(v) for v in given] == ["2.0.1", "2.1.0", "2.3.0", "develop"]


def test_helpers(tmp_path, monkeypatch):
    assert util.get_holoocean_path() == str(tmp_path / util.VERSION)
    monkeypatch.setenv("HOLODECKPATH", "")  # counts as none
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert Path(util.get_holoocean_path()) == tmp_path / "home" / ".local" / "share" / "holoocean" / util.VERSION
    assert util.human_readable_size(1536) == "1.5 KB"
    assert util.human_readable_size(12) == "12.0 B"
    assert util.convert_unicode({"a": 1}) == {"a": 1}
