"""What scenarios become: texts of YAML as data, changes by keys, members of groups, draws, legs, and the words for what
is wrong, each with its place."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from known import EXACT, check, on_one_scale
from pelagos.config import limits, rate, unit, vary
from pelagos.config.document import Document, parse_document
from pelagos.config.loader import load_scenario, to_yaml
from pelagos.config.override import change, with_value
from pelagos.config.scenario import Scenario
from pelagos.config.swarm import Draw, grid, group_of, member_names, topic_name
from pelagos.config.walk import annotation_at, data_path, fixed_length, value_at
from pelagos.errors import PelagosError


def known(case: str, found: dict[str, Any]) -> None:
    check("configs", case, {name: on_one_scale(v) for name, v in found.items()}, EXACT)


TEXT = """
# scalars as they are meant
a: 1e3
b: [yes, No, on, 12:30, 2026-06-01, 0x1f, 0o17, +7, -0.5, .5, 1., .inf, -.INF, "3", ~, null, true, FALSE, 1.5e-4]
base: &base {x: 1, y: -2.5, deep: [1, [2, 3], {z: 4}]}
other: &other {y: 7, w: text}
merged:
  <<: [*base, *other]
  x: 9
again: {<<: *base, deep: ~}
7: seven
long: >
  folded
  text
"""
CHANGES = (
    "agents.a.start.heading_deg=90",
    "agents.a.start.position_m.1=-4.5",
    "agents.a.vehicle.mass.mass_kg=31",
    "ocean.currents=[{type: uniform, speed_mps: 0.3}]",
    "agents.a.sensors.imu.rate_hz=1e2",
    "name=yes",
    "agents.a.mission.0.depth_m=7",
    "record.state_rate_hz=25",
    " seed = 3",
)
WRONG_CHANGES = (
    "agents.a.start",
    "=3",
    "agents..start=1",
    "agents.b.count=3",
    "agents.a.sensors.imv.rate_hz=3",
    "seed.more=3",
    "agents.a.mission.x.depth_m=3",
    "agents.a.mission.5.depth_m=3",
    "name=[1",
)
BASE: dict[str, Any] = {
    "world": {"type": "flat", "depth_m": 30.0},
    "tick_rate_hz": 120,
    "seed": 7,
    "agents": {
        "a": {
            "vehicle": "bluerov2",
            "start": {"position_m": [3.0, -2.0], "depth_m": 4.0},
            "sensors": {"imu": {"type": "imu", "rate_hz": 60}},
            "mission": [{"type": "dive", "depth_m": 5}],
        }
    },
}


def document() -> Document:
    return Document(BASE, {("agents",): "it.yaml:3", ("agents", "a"): "it.yaml:4", (): "it.yaml"}, Path("/somewhere"))


def test_texts_and_changes() -> None:
    read = parse_document(TEXT, "it.yaml", Path("/somewhere"))
    changed = document()
    found: dict[str, Any] = {"data": read.data, "places": [[str(k), v] for k, v in read.places.items()]}
    for text in CHANGES:
        changed = change(changed, text)
    changed = with_value(changed, "agents.a.start", {"heading_deg": 3}, place="override x")
    found["changed"] = [changed.data, [[str(k), v] for k, v in changed.places.items()], BASE]
    found["where"] = [
        changed.where(k)
        for k in (
            (),
            ("agents", "a"),
            ("agents", "a", "start"),
            ("agents", "a", "start", "heading_deg"),
            ("agents", "a", "sensors", "imu", "rate_hz"),
            ("x", 1),
        )
    ]
    found["wrong"] = [refusal(lambda t=t: change(document(), t)) for t in WRONG_CHANGES]
    found["bad texts"] = [
        refusal(lambda t=t: parse_document(t, "it.yaml", Path("/somewhere")))
        for t in (
            "a: 1\nb: 2\na: 3",
            "a: {<<: 3}",
            "? [1, 2]\n: 3",
            "a: !!python/none 3",
            f"a: {'9' * 40}",
            "a: !x {b: 1}",
            "a: &a\n  <<: *a",
        )
    ]
    known("texts", found)


def refusal(do: Any) -> str:
    """Complaint of a call, without lists of all that is known, which grow; empty without one."""
    try:
        do()
    except PelagosError as error:
        return re.sub(r"(known|allowed|Known|vehicles|modes): .*", "", str(error))
    return ""


EARTH = {"latitude_deg": -33.25, "longitude_deg": -151.5}
LEGS: list[dict[str, Any]] = [
    {"type": "dive", "depth_m": 5.0, "speed_mps": 0.7},
    {"type": "dive", "altitude_m": 4.0},
    {"type": "waypoints", "points": [[1.0, -2.0], [3.0, 4.0]], "depth_m": 3.0, "acceptance_m": 2.5},
    {
        "type": "lawnmower",
        "corner": [5.0, -6.0],
        "length_m": 70.0,
        "width_m": 30.0,
        "spacing_m": 9.0,
        "heading_deg": 35.0,
    },
    {"type": "surface"},
    {"type": "gps_fix", "timeout_s": 12.0},
    {"type": "hold", "seconds": 3.0},
    {"type": "goto", "points": [[1.0, -2.0, -3.0], [4.0, 5.0]], "face": [9.0, -8.0]},
    {"type": "station_keeping", "point": [7.0, -5.0], "seconds": 40.0, "heading_deg": -20.0, "radius_m": 8.0},
    {
        "type": "orbit",
        "center": [6.0, -4.0],
        "radius_m": 11.0,
        "turns": 1.5,
        "direction": "counterclockwise",
        "look": "center",
    },
    {"type": "survey", "area": [[0.0, 0.0], [30.0, 5.0], [20.0, -25.0]], "swath_deg": 110.0, "overlap": 0.3},
    {"type": "follow", "pipeline": "pipe", "until": {"sensor": "imu", "component": 2, "above": 9.0, "below": -3.0}},
    {"type": "profile", "lower_depth_m": 22.0, "cycles": 3, "heading_deg": 70.0, "glide_deg": 31.0},
    {"type": "profile", "upper_depth_m": 5.0, "lower_depth_m": 22.0, "point": [40.0, -9.0]},
    {"type": "drift", "seconds": 30.0},
    {"type": "dock", "point": [3.0, 4.0, -5.0], "heading_deg": 100.0},
    {"type": "land", "point": [2.0, -7.0], "sink_mps": 0.15},
    {"type": "repeat", "times": 2, "last": 3},
]
GROUP: dict[str, Any] = {
    "vehicle": "remus100",
    "count": 6,
    "mission": LEGS,
    "mission_from": "start",
    "start": {"position_m": [10.0, -20.0], "depth_m": 3.0, "heading_deg": 15.0, "spacing_m": [4.0, -7.0]},
    "sensors": {
        "imu": {"type": "imu", "rate_hz": 60},
        "dvl": {"type": "dvl", "rate_hz": 10, "position_m": [0.1, 0.2, 0.3]},
    },
    "distributions": {
        "start.heading_deg": {"uniform": [-40.0, 60.0]},
        "start.position_m.0": {"normal": [5.0, 2.0]},
        "sensors.dvl.position_m.1": {"choice": [-0.4, 0.1, 0.7]},
        "sensors.imu.gyroscope_bias_std": {"normal": [1e-3, 1e-4]},
    },
    "overrides": {
        2: {"start": {"speed_mps": 1.5}, "sensors": {"imu": {"rate_hz": 40}}, "control": "actuators"},
        4: {"mission": [{"type": "surface"}]},
    },
    "navigation": {"type": "ekf", "start_heading_std_deg": 2.5, "beacons": {"a.m": [1.0, -2.0, -3.0]}},
    "radiated_noise": {"type": "thrusters", "level_db": 140.0, "idle_db": 90.0},
}
FULL: dict[str, Any] = {
    "name": "full",
    "seed": 11,
    "tick_rate_hz": 120,
    "duration_s": 33.0,
    "origin": {"latitude_deg": -33.25, "longitude_deg": 208.5},
    "world": {"type": "flat", "depth_m": 30.0},
    "ocean": {
        "waves": [{"type": "pierson_moskowitz", "wind_mps": 7.0, "towards_deg": 35.0}],
        "currents": [{"type": "uniform", "speed_mps": 0.4, "towards_deg": 70.0}],
    },
    "agents": {"auv": GROUP, "rov": {**BASE["agents"]["a"], "radiated_noise": {"type": "ship", "length_m": 40.0}}},
    "props": {
        "crate": {
            "shape": "box",
            "position_m": [1.0, -2.0, -3.0],
            "size_m": [1.0, 2.0, 0.5],
            "material": "wood",
            "orientation_deg": [5.0, -10.0, 35.0],
        }
    },
    "vary": {
        "agents.rov.start.heading_deg": {"uniform": [-90.0, 45.0]},
        "agents.rov.factors.mass": {"normal": [1.0, 0.1]},
        "agents.rov.sensors.imu.orientation_deg.2": {"choice": [1.0, -4.0]},
        "agents.rov.sensors.imu.error": {"uniform": [0, 3]},
        "ocean.current_mps.1": {"uniform": [-0.4, 0.2]},
        "ocean.turbidity": {"choice": [0.5, 4.0]},
        "ocean.waves.0.wind_mps": {"uniform": [3.0, 9.0]},
        "props.crate.position_m.2": {"uniform": [-9.0, -2.0]},
    },
    "bridges": {"ros": "ros2", "gps": {"type": "mavlink", "agent": "rov", "rate_hz": 5.0}},
}


def test_a_scenario_of_everything() -> None:
    scenario = load_scenario(FULL, overrides={"agents.rov.start.pitch_deg": 4.0}, changes=["duration_s=44"])
    given = scenario.model_dump(mode="json", exclude_unset=True)
    found: dict[str, Any] = {key: given[key] for key in given if key not in ("agents", "world", "ocean")}
    for name, member in scenario.members.items():
        data = member.model_dump(mode="json", exclude_unset=True)
        found[name] = {key: value for key, value in data.items() if key != "vehicle"}
    found["about"] = [
        scenario.dt_ns,
        scenario.record.state_rate_hz,
        scenario.located_world.latitude_deg,
        scenario.located_world.longitude_deg,
        list(scenario.members),
    ]
    placed = scenario.placed({("agents",): "it:3", ("agents", "auv", "start"): "it:5", (): "it"})
    found["where"] = [
        placed.where("agents", "auv[3]", "start", "heading_deg"),
        placed.where("agents", "rov"),
        placed.where("seed"),
        scenario.where("seed"),
    ]
    found["alone"] = list(scenario.with_agents({"rov": scenario.agents["rov"]}).members)
    assert load_scenario(parse_document(to_yaml(scenario), "it", Path()).data) == scenario
    known("a scenario of everything", found)


@pytest.mark.parametrize("tick_rate_hz", [30, 50, 70, 120, 200, 333.0, 1000])
def test_rates(tick_rate_hz: float) -> None:
    scenario = load_scenario({"world": {"type": "flat"}, "tick_rate_hz": tick_rate_hz})
    rates = (1.0, 7.0, 10.0, 15.0, 33.3, 50.0, 90.0, 1e-4, tick_rate_hz / 7, 5000.0)
    known(
        f"rates in {tick_rate_hz:g} Hz",
        {
            "state": [scenario.record.state_rate_hz, scenario.dt_ns],
            "divides": [rate.divides(r, tick_rate_hz) for r in rates],
            "texts": [rate.rate_text(r, tick_rate_hz) for r in rates],
        },
    )


def test_draws_grids_units_and_limits() -> None:
    draws = [
        Draw(uniform=(-3.0, 8.0)),
        Draw(normal=(2.0, 0.5)),
        Draw(choice=(4.0, -1.0, 2.5)),
        Draw(uniform=(2.0, 2.0)),
    ]
    keys = [
        "start.position_m.0",
        "a_m",
        "range_max_mm",
        "speed_mps",
        "x_deg",
        "seed",
        "k_n_m",
        "rate_hz",
        "turn_degps",
        "temperature_c",
        "density_kg_m3",
        "force_n",
        "parameters",
        "wavelength_nm",
        "gain_db",
        "anything",
        "volume_m3",
        "latitude_deg",
        "t_us",
        "mass_kg",
        "power_w",
    ]
    texts = [
        ("range_m", "40 ft"),
        ("range_m", "2 nmi"),
        ("range_m", "3 fathom"),
        ("speed_mps", "7 kn"),
        ("speed_mps", "36 km/h"),
        ("time_s", "3 min"),
        ("time_s", "250 ms"),
        ("rate_hz", "2 kHz"),
        ("f_khz", "900 hz"),
        ("turn_deg", "1 rad"),
        ("mass_kg", "3 lb"),
        ("range_m", "3 s"),
        ("range_m", "many"),
        ("x", "3 m"),
        ("range_m", "1e2 CM"),
        ("range_m", "1.2.3 m"),
        ("range_m", "1e400 ft"),
        ("rate_hz", "5 mHz"),
        ("rate_hz", "5 MHz"),
    ]
    schema: dict[str, Any] = {
        "properties": {
            "range_m": {"type": "number"},
            "count": {"type": "integer", "minimum": 3},
            "heading_deg": {"type": "number", "maximum": 5},
        },
        "$defs": {"it": {"anyOf": [{"type": "number"}]}},
    }
    limits.bound(schema)
    scenario = load_scenario(FULL)
    waves = scenario.ocean.waves[0]
    found: dict[str, Any] = {
        "draws": [
            [d.draw(seed, name) for seed in (0, 7) for name in ("auv[0].x", "auv[1].x", "auv[0].y")] for d in draws
        ],
        "steps": [[d.steps(5), d.steps(2), d.below_zero] for d in draws],
        "grids": [grid(7, None, 2.0), grid(6, (2, 3), (1.5, -2.0)), grid(3, (1, 3), None)],
        "names": [member_names("auv", 3), member_names("b", None), group_of("auv[12]"), topic_name("auv[3]")],
        "units": [[unit.unit_of(k), unit.symbol_of(k)] for k in keys],
        "in unit": [unit.in_unit_of(k, t) for k, t in texts],
        "ranges": [limits.range_of(k) for k in keys],
        "schema": schema,
        "outside": [limits.outside_text(("a", "x_m", 3), v, (-2.0, 5.5)) for v in (7.25, float("inf"))],
        "beyond": [
            list(limits.beyond(v, "range_m")) for v in ([1.0, 2e8, {"x_deg": -4e4, "y": [float("nan")]}], 3, True)
        ],
        "varied": [vary.parse(key) for key in FULL["vary"]],
        "turbidities": [vary.turbidities(d) for d in draws],
        "system": [vary.with_number(waves, "wind_mps", 8.5), vary.with_number(waves, "towards_deg", -20.0)],
        "walked": [
            data_path(FULL, ("agents", "auv", "start", "position_m", 1)),
            data_path(FULL, ("world", "flat", "x"), missing=True),
            value_at(FULL, ("agents", "auv", "mission", 3, "corner")),
            value_at(FULL, ("x", 3)),
            fixed_length(annotation_at(Scenario, FULL, ("props", "crate", "position_m"))),
            fixed_length(annotation_at(Scenario, FULL, ("agents", "auv", "start", "grid"))),
        ],
    }
    known("draws and units", found)


def changed(dotted: str, value: Any) -> Document:
    return with_value(Document(FULL, {(): "it"}), dotted, value, place="it:3")


WRONG: list[tuple[str, Any]] = [
    ("agents.rov.start.heading_deg", "90"),
    ("agents.rov.start.heading_deg", "1 rad"),
    ("agents.rov.start.heading_deg", 361),
    ("agents.rov.start.haeding_deg", 3),
    ("agents.rov.start.depth_m", "7 ft"),
    ("agents.rov.start.depth_m", "deep"),
    ("agents.rov.start.altitude_m", 4.0),
    ("agents.rov.start.position_m", [1.0]),
    ("agents.rov.start.position_m", 7),
    ("agents.rov.start.anywhere", 1),
    ("agents.rov.start.anywhere", "yes"),
    ("agents.rov.start", 3),
    ("agents.rov.start.grid", [1, 2]),
    ("agents.rov.vehicle", "blurov2"),
    ("agents.rov.vehicle", {"mass": 3}),
    ("agents.rov.command", [0.0]),
    ("agents.rov.sensors.imu", {"type": "imv"}),
    ("agents.rov.sensors.imu", {"rate_hz": 3}),
    ("agents.rov.sensors.imu.rate_hz", 7),
    ("agents.rov.sensors", {"i-mu": {"type": "imu"}}),
    ("agents.rov.sensors.imu.rate_hz", 1e9),
    ("agents", {"1a": {}}),
    ("agents.rov.mission", [{"type": "dive"}]),
    ("agents.rov.mission", [{"type": "dvie"}]),
    ("agents.rov.mission", [{"type": "drift"}]),
    ("agents.rov.mission", [{"type": "survey", "area": [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]}]),
    ("agents.rov.mission", [{"type": "goto", "points": [[1.0, 2.0, 3.0]], "depth_m": 3.0}]),
    ("agents.rov.mission", [{"type": "orbit", "center": [1, 2], "radius_m": 3, "look": "middle"}]),
    ("agents.rov.mission", [{"type": "profile", "lower_depth_m": 2.0, "cycles": 1}]),
    ("agents.rov.mission", [{"type": "follow", "wall": "a", "agent": "b", "seconds": 3.0}]),
    ("agents.rov.mission", [{"type": "land", "depth_m": 3.0}]),
    ("agents.rov.count", 3),
    ("agents.rov.overrides", {0: {}}),
    ("agents.rov.distributions", {"start.heading_deg": {"uniform": [3, 1]}}),
    ("agents.auv.overrides", {9: {"control": "x"}}),
    ("agents.auv.start.grid", [1, 2]),
    ("agents.auv.start.grid", [0, 9]),
    ("agents.auv.distributions", {"start.x": {"choice": [3.0]}}),
    ("agents.auv.distributions", {"vehicle": {"choice": [3.0]}}),
    ("agents.auv.distributions", {"start.heading_deg": {"normal": [3, -1]}}),
    ("agents.auv.distributions", {"start.heading_deg": {"normal": [3, 1], "choice": [1.0]}}),
    ("agents.auv.overrides", {1: {"start": {"heading": 3}}}),
    ("agents.auv.mission", [{"type": "waypoints", "points": [EARTH]}]),
    ("origin.latitude_deg", 151.0),
    ("origin.longitude_deg", 700.0),
    ("origin.latitude_deg", 1e-300),
    ("world.latitude_deg", 3.0),
    ("world.type", "flt"),
    ("seed", -1),
    ("seed", 1.5),
    ("seed", True),
    ("name", 3),
    ("name", ""),
    ("tick_rate_hz", 0),
    ("tick_rate_hz", float("nan")),
    ("duration_s", "3 min"),
    ("duration_s", 1e12),
    ("vary", {"agents.rov.start.x": {"choice": [3.0]}}),
    ("vary", {"agents.auv.start.heading_deg": {"choice": [3.0]}}),
    ("vary", {"agents.rov.sensors.imv.error": {"choice": [3.0]}}),
    ("vary", {"agents.rov.sensors.imu.eror": {"choice": [3.0]}}),
    ("vary", {"ocean.waves.1.wind_mps": {"choice": [3.0]}}),
    ("vary", {"ocean.waves.0.wind": {"choice": [3.0]}}),
    ("vary", {"ocean.turbidity": {"choice": [-3.0]}}),
    ("vary", {"seed": {"choice": [3.0]}}),
    ("vary", {"props.create.position_m.0": {"choice": [3.0]}}),
    ("vary", {"agents.usv.start.heading_deg": {"choice": [1.0]}}),
    ("props", {"rov": {"shape": "box", "position_m": [0, 0, 0]}}),
    ("props.crate.shape", "mesh"),
    ("props.crate.size_m", 0.0),
    ("props", {"c": {"shape": "corner_reflector", "position_m": [0, 0, 0], "size_m": [1.0, 1.0, 1.0]}}),
    ("bridges.ros", "ros3"),
    ("record.groups", "apart"),
    ("agents.rov.navigation", "ekff"),
    ("agents.rov.radiated_noise", {"type": "ship"}),
    ("agents.rov.radiated_noise", {"type": "ship", "length_m": 40, "ship_class": "tugg"}),
    ("agents", []),
    ("ocean.waves", 3),
]


def test_words_for_what_is_wrong() -> None:
    from pelagos.config.loader import check as checked

    said = [refusal(lambda d=d, v=v: checked(changed(d, v))) for d, v in WRONG]
    assert all(said), [case for case, text in zip(WRONG, said, strict=True) if not text]
    assert not [text for text in said if "nput should" in text]  # pydantic's words, which change
    by_key: dict[str, list[str]] = {}
    for (dotted, _), text in zip(WRONG, said, strict=True):
        by_key.setdefault(dotted.split(".")[0], []).append(text)
    known("wrong", by_key)
