"""What reports, charts and notebooks draw and say of a made-up mission: data of figures, numbers of tables."""

from __future__ import annotations

import base64
import io
import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import made_up
from known import DOUBLE, SINGLE, check
from pelagos.config.loader import load_scenario
from pelagos.drawing import notebook
from pelagos.drawing.png import png
from pelagos.messages.navigation import WRENCH_FIELDS
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.report import channel, charts, communication, legs, report, sonar, swarm, theme, track, water
from pelagos.report.mission import Mission, RecordedMotion, missions
from pelagos.report.navigation import dead_reckoning
from pelagos.report.statistics import run_statistics
from pelagos.report.world import world_page
from pelagos.sim.guidance.outcome import LegOutcome
from pelagos.sim.replay import Recording
from pelagos.world.build import build_world, world_config
from pelagos.world.preview import statistics
from shown import figure, page, parts

KINDS = (
    "imu", "dvl", "depth", "gps", "magnetometer", "altimeter", "multibeam", "imaging_sonar", "camera", "collision",
)  # fmt: skip
RUN: dict[str, Any] = {
    "simulated_s": 36.0, "wall_s": 12.5, "real_time_factor": 2.88, "ended": "missions", "seed": 7, "copies": 1,
    "triangles": 12345, "device": "it", "processor": "one", "threads": 2, "memory_mb": 512.7,
    "ms_per_call": {"auv0.dvl": 0.31, "physics": 1.7}, "seconds": {"physics": 3.5, "sensors": 5.25},
    "legs": {"auv0": [{"kind": "waypoints", "began_s": 0.5, "ended_s": 21.25, "off_m": 1.234, "late": False},
                      {"kind": "gps_fix", "began_s": 21.25, "ended_s": 30.0, "off_m": None, "late": True},
                      {"kind": "orbit", "began_s": 30.0, "ended_s": None, "off_m": 12.34, "late": False},
                      {"kind": "surface", "began_s": None, "ended_s": None, "off_m": None, "late": False}]},
}  # fmt: skip


@contextmanager
def drawn_figures() -> Iterator[list[Figure]]:
    """Figures that would become pictures; no picture is made of them."""
    found: list[Figure] = []

    def keep(drawn: Figure, **how: Any) -> bytes:
        found.append(drawn)
        return b"picture"

    with pytest.MonkeyPatch.context() as patch:
        for module in (theme, communication, channel):
            patch.setattr(module, "as_png", keep)
        yield found


@pytest.fixture(scope="module")
def scene() -> tuple[Any, Any]:
    scenario = load_scenario(made_up.scenario(())[0])
    world = build_world(scenario.located_world)
    return world, build_ocean(scenario.ocean, world, seed=7)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_up.record(tmp_path_factory.mktemp("reports") / "mission.mcap", KINDS)


@pytest.fixture(scope="module")
def mission(recording: Path) -> Mission:
    return missions(Recording(recording))[0]


def test_a_report(recording: Path, scene: Any, tmp_path: Path) -> None:
    world, ocean = scene
    with drawn_figures() as found:
        report.render_report(tmp_path, recording, world, RUN, ocean=ocean)
    said = json.loads((tmp_path / "stats.json").read_text())
    said["versions"], said["recording"]["bytes"] = {}, 0
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    body = re.sub(r"[\d.]+ MB|Written by .*?from|<td>(pelagos|python|drjit|mitsuba|numpy)</td><td>[^<]*</td>", "", text)
    kept = parts("stats", said) | page(body)
    for number, one in enumerate(found):
        kept |= {f"figure {number} {name}": values for name, values in figure(one).items()}
    check("reports", "a mission", kept, SINGLE)  # cameras' frames are chosen by their JPEG


def test_charts_of_otherwise_equipped_vehicles(recording: Path, scene: Any) -> None:
    """Without dead reckoning, with what other modules keep apart: long missions, a standing vehicle."""
    world, ocean = scene
    found: dict[str, Any] = {}
    for agent in missions(Recording(recording))[1:]:
        drawn, caption = track.track_map(agent, world, None)
        rows = charts.rows(agent, world, None)
        for name, one in (("map", drawn), ("charts", charts.against_truth(rows, duration_s=300.0))):
            found |= {f"{agent.name} {name} {k}": v for k, v in figure(one).items()}
        found |= parts(f"{agent.name} caption", caption)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(water, "_STILL_M", 1e6)
            section = water.section_along(agent, world)
        found[f"{agent.name} section"] = np.concatenate([section.along, section.depth, section.time, section.vehicle])
    alone, caption = track.track_map(first := missions(Recording(recording))[0], world, dead_reckoning(first))
    found |= {f"alone {k}": v for k, v in figure(alone).items()} | parts("alone caption", caption)
    found |= parts("water", water.water_statistics(missions(Recording(recording))[0], ocean))
    check("reports", "other vehicles", found, DOUBLE)


def test_sonar_frames(mission: Mission) -> None:
    topic = "/auv0/imaging_sonar/image"
    frames = sonar.chosen_frames(mission, topic, count=4)
    found = {
        "t": [f.t for f in frames], "polar": [f.polar for f in frames], "azimuth": [f.azimuth for f in frames],
        "ranges": [f.ranges for f in frames], "rings": [sonar._ring_step(f) for f in (3.0, 17.0, 90.0, 2000.0)],
        "spokes": np.concatenate([sonar._spokes(np.radians(a)) for a in (5.0, 13.0, 30.0, 61.0)]),
    }  # fmt: skip
    drawn = sonar.frames_figure(mission, "imaging_sonar", frames)
    check("reports", "sonar frames", found | figure(drawn), DOUBLE)


def member(number: int) -> Any:
    """On a curved line of its own, nearest to others at other times; one feels two contacts."""
    t = np.linspace(0.0, 300.0, 61)
    turn = 0.03 * number * t / 10 + 0.4 * number
    p = np.stack([0.15 * t + 3 * np.cos(turn), 6.0 * number - 4.0 * np.sin(turn) - 9.0, -5.0 - 0.4 * number + 0.01 * t])
    force = np.zeros((len(t), len(WRENCH_FIELDS)))
    force[[19, 20, 25], 2] = -7.0 if number == 3 else 0.0
    return SimpleNamespace(
        name=f"auv_{number}", agent=f"auv_{number}", scenario={"agents": {"auv": {"count": 6}, "rov": {}}},
        motion=RecordedMotion(t, p.T, np.tile([1.0, 0, 0, 0], (len(t), 1)), 0.0 * p.T),
        channels=lambda kind, message: [SimpleNamespace(topic="/felt")] if kind == "collision" else [],
        recording=SimpleNamespace(channels={}, table=lambda topic, fields: (t, force)),
    )  # fmt: skip


def test_statistics_of_a_run() -> None:
    result: Any = SimpleNamespace(
        simulated_s=36.5, wall_s=12.25, real_time_factor=2.98, ended="time", counts={"auv0.imu": 7},
        ms_per_call={"auv0.imu": 0.25}, seconds_by_part={"physics": 1.5},
    )  # fmt: skip
    sim: Any = SimpleNamespace(seed=9, n=3, dt_ns=20_000_000, world=SimpleNamespace(triangles=321))
    said = run_statistics(sim, result)
    kept = {k: v for k, v in said.items() if k not in ("device", "processor", "threads", "memory_mb")}
    assert len(said) - len(kept) == 4
    check("reports", "statistics", parts("said", kept), DOUBLE)


def test_a_swarm(scene: Any) -> None:
    (group,) = swarm.swarms([member(i) for i in range(6)])
    numbers: dict[str, Any] = {}
    with drawn_figures() as drawn:
        section = swarm.swarm_section(group, scene[0], numbers)
    found = figure(drawn[0]) | parts("numbers", numbers) | parts("section", [section.title, section.text, section.body])
    check("reports", "a swarm", found, DOUBLE)


def test_packets(recording: Path) -> None:
    fates = ("received", "collision", "noise", "received", "half duplex", "multipath")
    lines = [
        {"time_ns": 10**9 * (3 + 7 * k) + k, "sender": f"a{k % 3}.modem", "receiver": f"a{(k * k + 1) % 4}.modem",
         "fate": fates[k % 6], "kind": "ack" if k == 4 else "data"} for k in range(17)
    ]  # fmt: skip
    said = [SimpleNamespace(message=SimpleNamespace(data=json.dumps(lines[i::2]))) for i in (0, 1)]
    topics = {"/env0/a0/modem/packets": None, "/env1/a0/modem/packets": None, "/env0/a0/modem/other": None}
    heard: Any = SimpleNamespace(channels=topics, messages=lambda topic: said, of_first=lambda t: t.startswith("/env0"))
    numbers: dict[str, Any] = {}
    with drawn_figures() as drawn:
        (section,) = communication.communication_section(heard, numbers)
    found = figure(drawn[0]) | parts("numbers", numbers) | parts("section", [section.text, section.body])
    check("reports", "packets", found, DOUBLE)


def test_legs_on_a_terminal() -> None:
    one = [LegOutcome(**leg) for leg in RUN["legs"]["auv0"]]
    done = [LegOutcome("dive", 1.0, 11.4, 0.03), LegOutcome("waypoints", 11.4, 61.2, 7.9), LegOutcome("waypoints",
    61.2, 90.0, 3.0)]  # fmt: skip
    few = legs.legs_lines({"a": one, "b": done}, 41.6)
    many = legs.legs_lines({f"v{k}": one if k % 3 else done for k in range(17)}, 50.0)
    check(
        "reports",
        "legs",
        {"few": "\n".join(few), "many": "\n".join(many)} | parts("numbers", legs.legs_numbers({"a[1]": one})),
    )


def test_a_world_page(scene: Any, tmp_path: Path) -> None:
    (tmp_path / "map.png").write_bytes(png(np.arange(600, dtype=np.uint8).reshape(10, 20, 3)))
    stats = statistics(scene[0]) | {"generation_s": 1.25}
    text = world_page(scene[0], stats, tmp_path / "map.png", [("from afar", tmp_path / "map.png")], title="a place")
    check("reports", "a world's page", page(text) | parts("stats", stats), DOUBLE)


def test_a_channel() -> None:
    import pelagos as pl
    from pelagos.report.channel import draw_channel

    deep = {"type": "profile", "depth_m": [0.0, 12.0, 40.0], "value": [18.0, 11.0, 7.0]}
    world = build_world(world_config({"type": "flat", "depth_m": 34.0, "size_m": [900, 900]}))
    ocean = build_ocean(OceanConfig.model_validate({"temperature_c": [deep]}), world, seed=1)
    made = pl.channel(world, (0.0, 0.0, -7.0), (210.0, -90.0, -23.0), frequency_hz=18e3, ocean=ocean)
    with drawn_figures() as drawn:
        draw_channel(made, title="one to another")
    check("reports", "a channel", figure(drawn[0]), SINGLE)


def of_html(text: str) -> dict[str, Any]:
    """Numbers and words of a card; its pictures are tried by their figures."""
    return parts("card", re.sub(r'src="[^"]*"', "", text))


def test_notebooks(recording: Path, scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    figures: list[Figure] = []
    monkeypatch.setattr(notebook, "_figure", lambda drawn: figures.append(drawn) or "figure")
    found: dict[str, Any] = {}
    for kind, config in made_up.configs().items():
        reading = made_up.readings(kind, config, 2)[1]
        found |= {f"{kind} {k}": v for k, v in of_html(notebook.reading_html(reading)).items()}
        picture = notebook.reading_picture(reading)
        if picture is not None:
            found[f"{kind} picture"] = picture
    world = scene[0]
    places = {"auv0": (4.0, -7.0, 0.9), "rov": (-9.0, 3.0, 3.3)}
    figures.append(notebook.map_figure(world, places))
    found |= {f"world {k}": v for k, v in of_html(notebook.world_html(world)).items()}
    said = Recording(recording)
    found |= {
        f"recording {k}": v for k, v in of_html(notebook.recording_html(said).replace(str(recording), "")).items()
    }
    vehicle = scene_vehicle()
    found |= {f"vehicle {k}": v for k, v in of_html(notebook.vehicle_html(vehicle)).items()}
    state = {
        name: SimpleNamespace(position=np.array([[x, y, -3.3]]), euler=np.array([[0.1, 0.2, -turn]]),
                              velocity=np.array([[1.0, 0.4, -0.2]]))
        for name, (x, y, turn) in places.items()
    }  # fmt: skip
    sim = SimpleNamespace(
        state=state, scenario=SimpleNamespace(name="it"), time_ns=12_340_000_000, n=1, seed=5, world=world,
        stepper=SimpleNamespace(mode=lambda name: "depth_heading"),
    )  # fmt: skip
    found |= {f"simulation {k}": v for k, v in of_html(notebook.simulation_html(sim)).items()}
    for number, drawn in enumerate(figures):
        found |= {f"figure {number} {name}": values for name, values in figure(drawn).items()}
    check("reports", "notebooks", found, DOUBLE)


def scene_vehicle() -> Any:
    import pelagos as pl

    return pl.Vehicle.from_catalogue("remus100")


def test_pictures_of_notebooks_are_whole() -> None:
    """A picture goes through its own coding unchanged."""
    picture = (np.arange(12 * 17 * 3) * 7 % 251).astype(np.uint8).reshape(12, 17, 3)
    tag = notebook._image(picture)
    data = base64.b64decode(tag.split("base64,")[1].rstrip('">'))
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(data))), picture)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(png(picture)))), picture)
