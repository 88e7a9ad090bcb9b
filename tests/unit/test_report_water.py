"""The report's pictures of the water: sampled where and when the vehicle was, and only where there is something."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_mission import Seabed, path, record
from test_report_page import parsed

from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.report import water
from pelagos.report.mission import Mission, missions
from pelagos.report.report import render_report
from pelagos.sim.replay import Recording

STRATIFIED = {"depth_m": [0, 10, 20], "value": [20, 12, 10]}
SHEAR = {"type": "profile", "depth_m": [0, 20], "speed_mps": [0.5, 0.1], "towards_deg": [90, 90]}


def sea(**said: Any) -> Any:
    return build_ocean(OceanConfig.model_validate(said), seed=1)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("water") / "mission.mcap", kinds=("depth",), seconds=40.0)


@pytest.fixture(scope="module")
def mission(recorded: Path) -> Mission:
    return missions(Recording(recorded))[0]


def test_section_follows_the_track_and_ends_at_the_seabed(mission: Mission) -> None:
    section = water.section_along(mission, Seabed())
    t, position, *_ = path(40.0)
    way = float(np.linalg.norm(np.diff(position[:, :2], axis=0), axis=1).sum())
    assert section.along[-1] == pytest.approx(way, rel=0.01)
    at = np.argmin(np.abs(t - section.time[80]))
    assert np.allclose(section.place[80], position[at, :2], atol=0.02)  # 5 ms at 1.5 m/s, and the truth's 20 ms
    assert np.allclose(section.bed, -Seabed().height(section.place[:, 0], section.place[:, 1]))
    assert section.depth[-1] <= 1.04 * section.bed.max() + 1e-9


def test_section_holds_what_the_ocean_has_there(mission: Mission) -> None:
    section = water.section_along(mission, Seabed())
    ocean = sea(temperature_c=STRATIFIED, currents=[SHEAR])
    temperature = section.sampled(ocean.temperature)
    flow = section.sampled(ocean.current)
    expected = np.interp(section.depth, STRATIFIED["depth_m"], STRATIFIED["value"])
    inside = np.isfinite(temperature)
    assert inside[section.depth < section.bed.min()].all()
    assert np.allclose(temperature[inside], np.broadcast_to(expected[:, None], inside.shape)[inside], atol=1e-9)
    assert np.allclose(-flow[0, :, 1], 0.5)  # the surface: 0.5 m/s to the east
    assert np.allclose(flow[0, :, 0], 0.0, atol=1e-12)


def test_a_vehicle_that_stays_has_a_section_over_time(mission: Mission, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(water, "_STILL_M", 1e6)
    section = water.section_along(mission, Seabed())
    assert section.label == "time [s]"
    assert np.array_equal(section.along, section.time)


def test_changing_currents_are_drawn_twice(mission: Mission) -> None:
    steady = water.current_figure(mission, Seabed(), sea(currents=[SHEAR]))
    tide = {"type": "tidal", "period_h": 160 / 3600, "speed_mps": 0.3, "towards_deg": 0}  # a quarter of it in 40 s
    turning = water.current_figure(mission, Seabed(), sea(currents=[tide]))
    assert steady is not None
    assert turning is not None
    assert "changes" in turning[1]
    assert "changes" not in steady[1]
    assert len(turning[0].axes) == len(steady[0].axes) + 1
    assert "0.50 m/s" in steady[1]


def test_statistics_of_the_way(mission: Mission) -> None:
    found = water.water_statistics(mission, sea(temperature_c=STRATIFIED, currents=[SHEAR], tracers={"dye": 2.0}))
    assert found["dye"] == {"least": 2.0, "mean": 2.0, "greatest": 2.0}
    depth = -mission.motion.position[:, 2]
    assert found["temperature_c"]["least"] == pytest.approx(20 - 0.8 * depth.max(), abs=0.02)
    assert found["current_mps"]["greatest"] == pytest.approx(0.5 - 0.02 * depth.min(), abs=1e-3)


def test_files_and_what_lay_beyond_them_are_reported(mission: Mission, tmp_path: Path) -> None:
    """A file that covers the first half of the mission only, held at its last moment: half of the way is beyond."""
    xarray = pytest.importorskip("xarray")
    half = 0.5 * float(mission.motion.t[-1])
    axes = ("time", "latitude", "longitude")
    metres = {"units": "m"}
    data = xarray.Dataset(
        {name: (axes, np.full((2, 2, 2), 0.1), {"units": "m s-1"}) for name in ("uo", "vo")},
        coords={
            "time": ("time", [0.0, half], {"units": "seconds since 2024-01-01"}),
            "latitude": ("latitude", [-1e4, 1e4], {**metres, "standard_name": "projection_y_coordinate"}),
            "longitude": ("longitude", [-1e4, 1e4], {**metres, "standard_name": "projection_x_coordinate"}),
        },
    )
    data.to_netcdf(tmp_path / "half.nc")
    ocean = sea(currents={"type": "gridded", "file": str(tmp_path / "half.nc"), "outside": "clamp"})
    files = water.gridded_files(mission, ocean)
    assert [(f["field"], f["file"], f["outside"]) for f in files] == [("current", "half.nc", "clamp")]
    assert files[0]["share_beyond"] == pytest.approx(0.5, abs=0.02)
    assert "Current from half.nc (outside: clamp): 50 % of the way lay beyond it, the value" in water.files_text(files)
    assert water.gridded_files(mission, sea(currents=[SHEAR])) == []


@pytest.mark.parametrize(
    ("said", "titles", "drawn"),
    [
        ({}, [], False),
        ({"currents": [SHEAR]}, ["Current"], False),
        ({"temperature_c": STRATIFIED}, ["Water along the track"], False),
        ({"currents": [SHEAR], "tracers": {"dye": STRATIFIED}}, ["Current", "Water along the track"], True),
    ],
)
def test_sections_only_where_the_scenario_has_them(
    tmp_path: Path,
    recorded: Path,
    said: dict[str, Any],
    titles: list[str],
    drawn: bool,
    request: pytest.FixtureRequest,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if not drawn:
        request.getfixturevalue("no_pictures")
    monkeypatch.setattr(Mission, "scenario", {"ocean": said})
    render_report(tmp_path, recorded, Seabed(), {}, ocean=sea(**said))
    shown = parsed(tmp_path / "report.html").titles
    assert [t for t in shown if t in ("Current", "Water along the track")] == titles
    numbers = json.loads((tmp_path / "stats.json").read_text(encoding="utf-8"))
    assert ("water" in numbers) == bool(titles)
