# ruff: noqa: E501 (tables of messages)
"""Scenarios as data: what is accepted, what is refused and in which words, and the round trip to a file."""

from __future__ import annotations

import json
import struct
import sys
from pathlib import Path
from types import ModuleType
from typing import Annotated, Literal

import drjit as dr
import pytest
import yaml
from pydantic import Field, ValidationError

from pelagos import jit
from pelagos.config import registry
from pelagos.config.document import parse_document
from pelagos.config.loader import check, load_scenario, to_yaml
from pelagos.config.path import ScenarioPath
from pelagos.config.rate import divides, rate_text
from pelagos.config.scenario import Scenario
from pelagos.config.strict import Strict
from pelagos.errors import InputError, ScenarioError
from pelagos.sensors.sensor import SensorConfig


class EchoConfig(SensorConfig):
    type: Literal["echo"]
    range_max_m: float = Field(default=30.0, gt=0)
    beams: int = Field(default=256, ge=1)
    window: Literal["hann", "flat"] = "hann"
    coherent: bool = True


class Echo:
    """An echo sounder for tests."""

    Config = EchoConfig


class RoundConfig(Strict):
    type: Literal["round"]
    radius_m: float | Literal["huge"] = 3.0


class SquareConfig(Strict):
    type: Literal["square"]
    side_m: float = 3.0


class PondConfig(Strict):
    """A pond for tests."""

    type: Literal["pond"]
    depth_m: float = Field(default=5.0, gt=0)
    chart: ScenarioPath | None = None
    shape: Annotated[RoundConfig | SquareConfig, Field(discriminator="type")] | None = None


class SeaConfig(Strict):
    salinity: float = 35.0


class BoatConfig(Strict):
    """A boat for tests."""

    type: Literal["boat"]
    mass_kg: float = 30.0


@pytest.fixture(autouse=True)
def components(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small components of every kind, so that these tests are about the scenario alone."""
    module = ModuleType("pelagos_test_components")
    vars(module).update(Echo=Echo, Pond=PondConfig, Sea=SeaConfig, Boat=BoatConfig)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    table = {
        "sensor": {"echo": "Echo"},
        "world": {"pond": "Pond"},
        "ocean": {"standard": "Sea"},
        "vehicle": {"boat": "Boat"},
    }
    named = {kind: {name: f"{module.__name__}:{cls}" for name, cls in row.items()} for kind, row in table.items()}
    monkeypatch.setattr(registry, "BUILT_IN", named)
    monkeypatch.setattr(registry, "CATALOGUES", {})


GOOD = """\
name: pond
world:
  type: pond
duration_s: 1e2
agents:
  auv0:
    vehicle: boat
    start: {position_m: [0, 0], depth_m: 2, heading_deg: 90}
    mission:
      - {type: dive, depth_m: 3}
      - {type: waypoints, points: [[1, 2], [3, 4]], altitude_m: 3}
      - {type: lawnmower, corner: [0, 0], length_m: 50, width_m: 20, spacing_m: 10, altitude_m: 4, speed_mps: 1.5}
      - {type: surface}
      - {type: gps_fix}
      - {type: hold, seconds: 5}
    sensors:
      echo: {type: echo, rate_hz: 5}
"""


def load(text: str, *changes: str) -> Scenario:
    from pelagos.config.override import change

    document = parse_document(text, "a.yaml", Path("/somewhere"))
    for one in changes:
        document = change(document, one)
    return check(document)


def refused(old: str, new: str) -> str:
    assert old in GOOD
    with pytest.raises(ScenarioError) as caught:
        load(GOOD.replace(old, new))
    return str(caught.value)


def test_good_scenario_has_its_values_and_defaults() -> None:
    scenario = load(GOOD)
    agent = scenario.agents["auv0"]
    assert scenario.duration_s == 100.0
    assert scenario.tick_rate_hz == 200.0
    assert scenario.dt_ns == 5_000_000
    assert scenario.ocean == SeaConfig()
    assert agent.vehicle == BoatConfig(type="boat")
    assert agent.sensors["echo"] == EchoConfig(type="echo", rate_hz=5)
    assert [leg.type for leg in agent.mission] == ["dive", "waypoints", "lawnmower", "surface", "gps_fix", "hold"]


def as_json(scenario: Scenario) -> str:
    return json.dumps(yaml.safe_load(to_yaml(scenario)))


@pytest.mark.parametrize("write", [to_yaml, as_json])
def test_round_trip(write: object) -> None:
    scenario = load(GOOD)
    assert callable(write)
    again = load(write(scenario))
    assert again == scenario
    assert write(again) == write(scenario)
    assert load_scenario(scenario.model_dump()) == scenario


def test_resolved_scenario_writes_defaults_out() -> None:
    assert "range_max_m: 30.0" in to_yaml(load(GOOD))
    assert "salinity: 35.0" in to_yaml(load(GOOD))


def test_scenario_is_frozen() -> None:
    with pytest.raises(ValidationError):
        load(GOOD).name = "other"  # type: ignore[misc]


UNKNOWN = [
    ("duration_s", "durations_s", "a.yaml:4: durations_s: unknown key 'durations_s' (did you mean 'duration_s'?)"),
    ("rate_hz: 5", "rate_hz: 5, range_mx_m: 3", "a.yaml:17: agents.auv0.sensors.echo.range_mx_m: unknown key 'range_mx_m' (did you mean 'range_max_m'?)"),
    ("sensors:", "sensor:", "a.yaml:16: agents.auv0.sensor: unknown key 'sensor' (did you mean 'sensors'?)"),
    ("depth_m: 3}", "deph_m: 3}", "a.yaml:10: agents.auv0.mission.0.deph_m: unknown key 'deph_m' (did you mean 'depth_m'?)"),
    ("vehicle: boat", "vehicle: {type: boat, mas_kg: 3}", "a.yaml:7: agents.auv0.vehicle.mas_kg: unknown key 'mas_kg' (did you mean 'mass_kg'?)"),
    ("type: pond", "type: pond\n  shape: {type: square, sides_m: 3}", "a.yaml:4: world.shape.sides_m: unknown key 'sides_m' (did you mean 'side_m'?)"),
    ("type: echo", "type: ehco", "a.yaml:17: agents.auv0.sensors.echo.type: unknown sensor 'ehco' (did you mean 'echo'?); known: echo"),
    ("vehicle: boat", "vehicle: boot", "a.yaml:7: agents.auv0.vehicle: unknown vehicle 'boot' (did you mean 'boat'?); known: boat"),
    ("type: pond", "type: pound", "a.yaml:3: world.type: unknown world 'pound' (did you mean 'pond'?); known: pond"),
    ("type: dive", "type: div", "a.yaml:10: agents.auv0.mission.0: unknown type 'div' (did you mean 'dive'?)"),
    ("type: pond", "type: pond\n  shape: {type: cube}", "a.yaml:4: world.shape: unknown type 'cube'"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), UNKNOWN)
def test_unknown_names_say_where_and_what_was_meant(old: str, new: str, message: str) -> None:
    assert message in refused(old, new)


WRONG = [
    ("1e2", "40 min", "expected a number of seconds [s], not '40 min'; write 2400"),
    ("1e2", "'40'", "expected a number of seconds [s], not '40'; write it without quotes"),
    ("1e2", "long", "not 'long'; the unit is in the key's name, write the number alone"),
    ("1e2", "true", "expected a number of seconds [s], not true"),
    ("1e2", ".nan", "expected a finite number [s], not nan"),
    ("1e2", ".inf", "expected a finite number [s], not inf"),
    ("1e2", "", "expected a number of seconds [s], not nothing"),
    ("1e2", "-3", "must be greater than 0 [s], not -3"),
    ("1e2", "[3]", "expected a number of seconds [s], not [3]"),
    ("rate_hz: 5", "rate_hz: 5, range_max_m: 40 ft", "expected a number of metres [m], not '40 ft'; write 12.192"),
    ("rate_hz: 5", "rate_hz: 5, range_max_m: 40m", "expected a number of metres [m], not '40m'; write 40"),
    ("rate_hz: 5", "rate_hz: 5, beams: 2.5", "expected a whole number, not 2.5"),
    ("rate_hz: 5", "rate_hz: 5, beams: 0", "must be at least 1, not 0"),
    ("rate_hz: 5", "rate_hz: 5, window: han", "'han' is not allowed (did you mean 'hann'?); allowed: hann, flat"),
    ("rate_hz: 5", "rate_hz: 5, coherent: 1", "expected true or false, not 1"),
    ("rate_hz: 5", "rate_hz: 5, coherent: yes", "expected true or false, not 'yes'"),
    ("type: echo, ", "", "required key 'type' is missing; it names the sensor: echo"),
    (", rate_hz: 5", "", "a.yaml:17: agents.auv0.sensors.echo.rate_hz: required key 'rate_hz' is missing [Hz]"),
    ("{type: echo, rate_hz: 5}", "echo", "a sensor is a mapping with a key 'type', not 'echo'; write {type: echo}"),
    ("vehicle: boat", "vehicle: 3", "a vehicle is a mapping with a key 'type', not 3"),
    ("name: pond", "name: 5", "expected text, not 5"),
    ("[0, 0], depth", "[0], depth", "expected at least 2 values [m], not 1: [0]"),
    ("[0, 0], depth", "[0, 0, 0], depth", "the height is given 2 times: 'depth_m', z of 'position_m'"),
    ("depth_m: 3}", "depth_m: 3, altitude_m: 3}", "a.yaml:10: agents.auv0.mission.0: give either 'depth_m' or 'altitude_m'; both given"),
    (", depth_m: 3}", "}", "give either 'depth_m' or 'altitude_m'; neither given"),
    ("points: [[1, 2], [3, 4]]", "points: [[1, 2], [3]]", "a.yaml:11: agents.auv0.mission.1.points.1: expected 2 values, not 1: [3]"),
    ("points: [[1, 2], [3, 4]]", "points: [1, 2]", "agents.auv0.mission.1.points.0: expected a list, not 1"),
    ("rate_hz: 5", "rate_hz: 5, position_m: [1]", "position_m: expected 3 values [m], not 1: [1]"),
    ("rate_hz: 5", "rate_hz: 5, position_m: [1, 2, 3, 4]", "position_m: expected at most 3 values [m], not 4: [1, 2, 3, 4]"),
    ("points: [[1, 2], [3, 4]]", "points: []", "expected at least 1 value, not 0: []"),
    ("auv0:", "auv-0:", "'auv-0' cannot be the name of an agent: use letters, digits and underscores, a letter first"),
    ("      echo:", "      3:", "3 cannot be the name of an agent's sensor"),
    ("world:\n  type: pond\n", "", "a.yaml: world: required key 'world' is missing"),
    ("name: pond", "origin: {latitude_deg: 112.3, longitude_deg: 45}", "are latitude and longitude swapped?"),
    ("vehicle: boat", "vehicle: boat\n    command: [1]", "give either 'mission' or 'command', not both"),
    ("type: pond", "type: pond\n  shape: {type: round, radius_m: big}", "not 'big'"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_wrong_values_say_what_was_given_and_what_is_allowed(old: str, new: str, message: str) -> None:
    assert message in refused(old, new)


RATES = [
    ("rate_hz: 5", "rate_hz: 3", "3 Hz does not divide the tick rate of 200 Hz; the nearest that do are 2.5 or 3.125 Hz"),
    ("rate_hz: 5", "rate_hz: 300", "300 Hz is faster than the tick rate of 200 Hz"),
    ("name: pond", "record: {state_rate_hz: 60}", "a.yaml:1: record.state_rate_hz: 60 Hz does not divide"),
    ("name: pond", "tick_rate_hz: 32", "a.yaml:17: agents.auv0.sensors.echo.rate_hz: 5 Hz does not divide the tick rate of 32 Hz"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), RATES)
def test_rates_divide_the_tick_rate(old: str, new: str, message: str) -> None:
    assert message in refused(old, new)


@pytest.mark.parametrize("tick_rate", [10.0, 30.0, 50.0, 60.0, 120.0, 200.0, 1000.0, 7.0])
def test_rate_of_recorded_motion_suits_the_tick_rate(tick_rate: float) -> None:
    scenario = load(GOOD, f"tick_rate_hz={tick_rate}", f"agents.auv0.sensors.echo.rate_hz={tick_rate}")
    assert divides(scenario.record.state_rate_hz, tick_rate)
    assert scenario.record.state_rate_hz <= 50.0
    faster = tick_rate / max(1, round(tick_rate / scenario.record.state_rate_hz) - 1)
    assert faster > 50.0 or scenario.record.state_rate_hz == tick_rate  # none is nearer


def test_rates_that_are_no_decimal_numbers_divide() -> None:
    assert divides(200 / 3, 200)
    assert divides(66.6666667, 200)
    assert not divides(66.67, 200)
    assert "2.941 Hz" in rate_text(2.941, 200)


FILES = [
    ("name: pond", "name: pond\nname: sea", "a.yaml:2: the key 'name' is written twice; first on line 1"),
    ("name: pond", "\tname: pond", "a.yaml:1: not valid YAML"),
    ("name: pond", "name: 'pond", "not valid YAML"),
    ("name: pond", "name: !!python/object:os.system pond", "is not understood here"),
    ("name: pond", "&x name: pond\n? [1, 2]\n: 3", "a key must be a single word"),
]


@pytest.mark.parametrize(("old", "new", "message"), FILES)
def test_bad_yaml(old: str, new: str, message: str) -> None:
    assert message in refused(old, new)


def test_all_mistakes_are_reported_at_once() -> None:
    text = refused("type: echo, rate_hz: 5", "type: echo, rate_hz: -5, beams: many")
    assert text.startswith("2 things are wrong:\n")
    assert text.count("a.yaml:17: ") == 2


@pytest.mark.parametrize("text", ["", "# nothing here\n"])
def test_empty_file(text: str) -> None:
    with pytest.raises(ScenarioError, match=r"a\.yaml: the file is empty"):
        load(text)


@pytest.mark.parametrize("text", ["- a\n- b\n", "just words"])
def test_not_a_mapping(text: str) -> None:
    with pytest.raises(ScenarioError, match="a scenario is a mapping of keys"):
        load(text)


def test_missing_file_names_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "survey.yaml").write_text(GOOD)
    with pytest.raises(ScenarioError, match=r"there is no such file \(did you mean 'survey.yaml'\?\)"):
        load_scenario(tmp_path / "surveey.yaml")
    with pytest.raises(ScenarioError, match="this is a folder"):
        load_scenario(tmp_path)


def test_binary_file(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(b"name: \xff\xfe")
    with pytest.raises(ScenarioError, match="not a text file in UTF-8"):
        load_scenario(path)


def test_yaml_merge_keys_and_anchors() -> None:
    text = GOOD.replace(
        "echo: {type: echo, rate_hz: 5}", "echo: &e {type: echo, rate_hz: 5}\n      far: {<<: *e, range_max_m: 90}"
    )
    sensors = load(text).agents["auv0"].sensors
    assert sensors["far"] == EchoConfig(type="echo", rate_hz=5, range_max_m=90)


def test_yaml_reads_words_as_words() -> None:
    document = parse_document("a: no\nb: 12:30\nc: 2026-01-01\nd: 1e3\ne: 0x10\nf: ~\ng: '5'", "a.yaml", Path())
    assert document.data == {"a": "no", "b": "12:30", "c": "2026-01-01", "d": 1000.0, "e": 16, "f": None, "g": "5"}


def test_recursive_yaml_is_refused() -> None:
    with pytest.raises(ScenarioError, match="nested too deeply"):
        load("a: &a [*a]")


def test_changes() -> None:
    scenario = load(
        GOOD,
        "agents.auv0.sensors.echo.range_max_m=40",
        "agents.auv0.mission.0.depth_m=8",
        "agents.auv0.vehicle.mass_kg=31",
    )
    agent = scenario.agents["auv0"]
    assert agent.sensors["echo"].range_max_m == 40
    assert agent.mission[0].depth_m == 8  # type: ignore[union-attr]
    assert agent.vehicle == BoatConfig(type="boat", mass_kg=31)


BAD_CHANGES = [
    ("agents.auv0.sensors.echo.range_max=40", "--set agents.auv0.sensors.echo.range_max=40: unknown key 'range_max' (did you mean 'range_max_m'?)"),
    ("agents.auv0.sensors.echo.range_max_m=40 ft", "not '40 ft'; write 12.192"),
    ("agents.auv0.mission.7.depth_m=4", "agents.auv0.mission is a list of 6; name an item by its number from 0, not '7'"),
    ("duration_s.x=4", "duration_s is a value (100.0) and has no key 'x'"),
    ("duration_s", "give a change as key.path=value"),
    ("=4", "give a change as key.path=value"),
    ("agents.auv1.start.depth_m=4", "--set agents.auv1.start.depth_m=4: unknown agent 'auv1' (did you mean 'auv0'?)"),
    ("agents.auv0.sensors.ecko.rate_hz=4", "unknown sensor 'ecko' (did you mean 'echo'?); known: echo"),
    ("agents.auv0.sensors.echo.rate_hz=3", "--set agents.auv0.sensors.echo.rate_hz=3: 3 Hz does not divide"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "message"), BAD_CHANGES)
def test_bad_changes(change: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        load(GOOD, change)
    assert message in str(caught.value)


def test_overrides_from_python() -> None:
    scenario = load_scenario(load(GOOD), overrides={"duration_s": 5.0, "agents.auv0.sensors.echo.beams": 16})
    assert (scenario.duration_s, scenario.agents["auv0"].sensors["echo"].beams) == (5.0, 16)
    with pytest.raises(ScenarioError, match="override duration_s: expected a number of seconds"):
        load_scenario(scenario, overrides={"duration_s": "5"})


def test_paths_start_from_the_scenario_folder(tmp_path: Path) -> None:
    path = tmp_path / "scenarios" / "a.yaml"
    path.parent.mkdir()
    path.write_text(GOOD.replace("type: pond", "type: pond\n  chart: ../charts/a.nc"))
    assert load_scenario(path).world.chart == tmp_path / "charts" / "a.nc"


def test_where() -> None:
    scenario = load(GOOD)
    assert scenario.where("agents", "auv0", "start") == "a.yaml:8: agents.auv0.start"
    assert scenario.where("agents", "auv0", "start", "speed_mps") == "a.yaml:8: agents.auv0.start.speed_mps"
    assert scenario.where() == "a.yaml"


def test_mapping_without_a_file_names_keys_alone() -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario({"world": {"type": "pond", "dpth_m": 3}})
    assert str(caught.value).startswith("world.dpth_m: unknown key")


@pytest.mark.parametrize("flushed", [False, True], ids=["as Python", "after a kernel of Dr.Jit"])
def test_a_number_too_small_to_be_meant_is_refused(flushed):
    if flushed:
        dr.eval(jit.Float(1.0) + jit.Float(2.0))  # from now on 5e-324 == 0 in this thread
    (least,) = struct.unpack("<d", b"\x01" + bytes(7))  # 5e-324, which is read as 0 where a kernel has run before
    agents = {"a": {"vehicle": {"type": "boat", "beam_m": -least}}}
    with pytest.raises(ScenarioError, match=r"agents\.a\.vehicle\.beam_m: .* is too small to be meant; at least 1e-60"):
        load_scenario({"world": {"type": "pond"}, "agents": agents})
