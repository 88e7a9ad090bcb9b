"""`write_report`: report.html and stats.json of a run. This page is the report's table of contents."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pelagos.files import write_whole
from pelagos.messages.sonar_image import PROJECTED_IMAGE
from pelagos.report import charts, pictures, sonar, soundings, survey, theme, track, water
from pelagos.report.communication import communication_section
from pelagos.report.legs import FlownLegs, flown_legs, legs_numbers, legs_table
from pelagos.report.mission import Mission, missions
from pelagos.report.movers import mover_tracks, movers_section
from pelagos.report.navigation import dead_reckoning, known
from pelagos.report.page import Section, Tile, image, page, photographs
from pelagos.report.statistics import recording_statistics, run_statistics
from pelagos.report.swarm import swarm_section, swarms
from pelagos.report.tables import parts_table, run_table, sensors_table
from pelagos.sim.replay import Recording

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean
    from pelagos.sim.run import RunResult
    from pelagos.sim.simulation import Simulation


def write_report(
    folder: Path, recording: Path, sim: Simulation, result: RunResult, *, legs: FlownLegs | None = None
) -> Path:
    """Write `report.html` and `stats.json` of a run that has just ended; legs: see `flown_legs`, found where None.

    Raises:
        RecordingError: the recording cannot be read.
    """
    numbers = run_statistics(sim, result) | {"legs": legs_numbers(flown_legs(sim, recording) if legs is None else legs)}
    return render_report(folder, recording, sim.world, numbers, ocean=sim.model.ocean)


def render_report(
    folder: Path, recording: Path, world: Any, run: Mapping[str, Any], *, ocean: Ocean | None = None
) -> Path:
    """Write `report.html` and `stats.json` from a recording, the world it was made in, and the run's statistics.

    Args:
        folder: where the two files go.
        recording: the MCAP file.
        world: with `height(x, y)`, `cast`, `bounds`, `name`, `notes` (see `World`).
        run: see `run_statistics`; may be empty.
        ocean: that of the run, for pictures of its water; none without it.

    Returns:
        The page.

    Raises:
        RecordingError: the recording cannot be read.
    """
    found = Recording(recording)
    agents = missions(found)
    numbers: dict[str, Any] = {**run, **recording_statistics(found, agents)}
    groups = swarms(agents)
    together = {member.agent for group in groups for member in group.members}
    sections = [swarm_section(group, world, numbers) for group in groups]
    sections += [s for m in agents if m.agent not in together for s in _sections(m, world, ocean, numbers)]
    sections += communication_section(found, numbers)
    sections += [parts_table(numbers), run_table(numbers, found)]
    first = agents[0] if agents else None
    scenario = first.scenario if first is not None else {}
    name = str(scenario.get("name", found.path.stem))
    text = page(
        title=name[:1].upper() + name[1:],
        kind="Pelagos mission report",
        text=str(scenario.get("description", "")),
        tiles=_tiles(agents, numbers),
        sections=sections,
        foot=f"Written by Pelagos {numbers['versions'].get('pelagos', '')} from {found.path.name}.",
    )
    write_whole(folder / "stats.json", json.dumps(_finite(numbers), indent=2) + "\n")
    report = folder / "report.html"
    write_whole(report, text)
    return report


def _sections(mission: Mission, world: Any, ocean: Ocean | None, numbers: dict[str, Any]) -> list[Section]:
    """Sections about one agent."""
    if len(mission.motion.t) < 2:
        return [sensors_table(mission, numbers)]
    reckoned = dead_reckoning(mission)
    if reckoned is not None:
        numbers.setdefault("dead_reckoning", {})[mission.name] = {
            "way_m": float(reckoned.distance[-1]), "final_error_m": float(reckoned.error[-1]),
            "drift_m": float(reckoned.drift[-1]),
        }  # fmt: skip
    solved = known(mission)
    if solved is not None:
        numbers.setdefault("navigation", {})[mission.name] = {
            "kind": solved.kind, "rms_error_m": float(np.sqrt((solved.error**2).mean())),
            "final_error_m": float(solved.error[-1]),
        }  # fmt: skip
    drawn, caption = track.track_map(mission, world, reckoned, solved)
    sections = [Section(f"Track of {mission.name}", caption, _figure(drawn, "true and dead-reckoned track"))]
    sections += legs_table(mission.name, numbers)
    sections += movers_section(mission, mover_tracks(mission.recording))
    sections += _survey(mission, world, numbers)
    sections += _water(mission, world, ocean, numbers)
    sections += [
        _sonar(mission, c.topic, c.about["sensor"]) for c in mission.channels("imaging_sonar", PROJECTED_IMAGE)
    ]
    sections += [_camera(mission, topic) for topic in pictures.camera_topics(mission)]
    duration = float(mission.motion.t[-1])
    panels = charts.against_truth(charts.rows(mission, world, reckoned), duration_s=duration)
    text = "Readings as recorded; on the right the errors against the truth, as mean ± standard deviation."
    sections.append(Section("Navigation sensors against the truth", text, _figure(panels, "sensors against truth")))
    sections.append(sensors_table(mission, numbers))
    return sections


def _survey(mission: Mission, world: Any, numbers: dict[str, Any]) -> list[Section]:
    sounded = soundings.collect(mission)
    if sounded is None:
        return []
    cells = soundings.grid(sounded.points)
    found = soundings.accuracy(sounded.points, cells, world.height)
    numbers.setdefault("soundings", {})[mission.name] = {
        "count": len(sounded.points),
        "with_bottom": sounded.share,
        **({} if found is None else {"bias_m": found.bias, "std_m": found.std, "elsewhere": found.elsewhere}),
    }
    drawn, caption = survey.survey_maps(sounded, cells, found, world, mission)
    return [Section("Multibeam map", caption, _figure(drawn, "map of the soundings beside the true terrain"))]


def _water(mission: Mission, world: Any, ocean: Ocean | None, numbers: dict[str, Any]) -> list[Section]:
    """Current and water masses, where the scenario has them."""
    if ocean is None:
        return []
    sections = []
    files = water.gridded_files(mission, ocean)
    current = water.current_figure(mission, world, ocean)
    if current is not None:
        said = current[1] + water.files_text([f for f in files if f["field"] == "current"])
        sections.append(Section("Current", said, _figure(current[0], "map and section of the current")))
    masses = water.water_figure(mission, world, ocean, mission.scenario)
    if masses is not None:
        said = masses[1] + water.files_text([f for f in files if f["field"] != "current"])
        sections.append(Section("Water along the track", said, _figure(masses[0], "sections of the water")))
    if sections:
        numbers.setdefault("water", {})[mission.name] = water.water_statistics(mission, ocean)
    if files:
        numbers["water"][mission.name]["files"] = files
    return sections


def _sonar(mission: Mission, topic: str, sensor: str) -> Section:
    frames = sonar.chosen_frames(mission, topic)
    drawn = sonar.frames_figure(mission, sensor, frames)
    text = f"{mission.recording.count(topic):,} pings; shown are the frames with the most to see, one of each part."
    return Section(f"Imaging sonar: {sensor}", text, _figure(drawn, "sonar frames", night=True))


def _camera(mission: Mission, topic: str) -> Section:
    shown = []
    for t, data in pictures.chosen_pictures(mission, topic):
        pose = mission.motion.at(np.array([t]))
        caption = f"t = {t:.1f} s, depth {-pose.position[0, 2]:.1f} m"
        shown.append((theme.data_uri(data, "image/jpeg"), caption))
    sensor = mission.recording.channels[topic].about["sensor"]
    text = (
        f"{mission.recording.count(topic):,} frames, as recorded; shown is the one with the most contrast of each part."
    )
    return Section(f"Camera: {sensor}", text, photographs(shown))


def _tiles(agents: list[Mission], numbers: Mapping[str, Any]) -> list[Tile]:
    tiles = []
    if numbers.get("simulated_s"):
        tiles.append(Tile(f"{numbers['simulated_s']:.0f}", "s", "simulated"))
        tiles.append(Tile(f"{numbers['real_time_factor']:.2f}", "×", "real time"))
    if len(agents) > 1:
        tiles.append(Tile(str(len(agents)), "", "vehicles"))
    elif agents and len(agents[0].motion.t) > 1:
        position = agents[0].motion.position
        way = float(np.linalg.norm(np.diff(position, axis=0), axis=1).sum())
        tiles.append(Tile(f"{way:.0f}", "m", "travelled"))
        tiles.append(Tile(f"{-position[:, 2].min():.1f}", "m", "greatest depth"))
    for count in (s["count"] for s in numbers.get("soundings", {}).values()):
        tiles.append(Tile(f"{count:,}", "", "soundings"))
    tiles.append(Tile(f"{numbers['recording']['messages']:,}", "", "messages recorded"))
    if "seed" in numbers:
        tiles.append(Tile(str(numbers["seed"]), "", "seed"))
    return tiles


def _figure(drawn: Any, alternative: str, *, night: bool = False) -> str:
    return image(theme.data_uri(theme.as_png(drawn)), alternative, night=night)


def _finite(value: Any) -> Any:
    """The same without numbers that JSON does not have."""
    if isinstance(value, Mapping):
        return {str(k): _finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
