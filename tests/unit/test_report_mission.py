"""What the report makes of a recording: numbers that are known because the mission was made up."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from report_mission import Seabed, path, record

from pelagos.math.geodesy import GeoOrigin
from pelagos.report import soundings
from pelagos.report.charts import rows
from pelagos.report.mission import Mission, RecordedMotion, missions
from pelagos.report.navigation import dead_reckoning, declination, fixes
from pelagos.report.statistics import sensor_table
from pelagos.sensors.navigation.magnetometer import MagnetometerConfig, earth_field_of
from pelagos.sim.replay import Recording


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Mission:
    file = record(tmp_path_factory.mktemp("mission") / "mission.mcap", seconds=100.0)
    return missions(Recording(file))[0]


def test_the_motion_comes_back_in_our_frames(mission: Mission) -> None:
    t, position, attitude, velocity, *_ = path(100.0)
    np.testing.assert_allclose(mission.motion.t, t[::4], atol=1e-9)
    np.testing.assert_allclose(mission.motion.position, position[::4], atol=1e-9)
    np.testing.assert_allclose(mission.motion.attitude, attitude[::4], atol=1e-12)
    np.testing.assert_allclose(mission.motion.velocity, velocity[::4], atol=1e-12)


def test_dead_reckoning_with_perfect_sensors_stays_on_the_track(mission: Mission) -> None:
    """DVL at 10 Hz interpolated to 20 Hz steps summed up by rectangles: less than a step (1.5 m/s * 0.05 s) off."""
    found = dead_reckoning(mission)
    assert found is not None
    assert found.start == "gps"
    assert found.distance[-1] == pytest.approx(150.0, abs=1.0)
    assert found.error.max() < 0.08
    truth = mission.motion.at(found.motion.t)
    np.testing.assert_allclose(found.motion.position[:, 2], truth.position[:, 2], atol=0.002)
    error = np.angle(np.exp(1j * (found.motion.euler - truth.euler)))
    assert np.degrees(np.abs(error)).max() < 0.1


def test_a_wrong_heading_shows_in_the_track(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A compass that is 2 degrees off puts a straight run off by 2 degrees of its length."""
    mission = missions(Recording(record(tmp_path / "m.mcap", seconds=20.0)))[0]
    monkeypatch.setattr("pelagos.report.navigation.declination", lambda m: declination(m) + np.radians(2.0))
    found = dead_reckoning(mission)
    assert found is not None
    k = int(np.searchsorted(found.motion.t, 6.0))  # hardly turned until then
    way = 1.5 * found.motion.t[k]
    assert found.error[k] == pytest.approx(way * np.radians(2.0), rel=0.15)


def test_fixes_are_where_the_vehicle_was(mission: Mission) -> None:
    t, p = fixes(mission)
    np.testing.assert_allclose(p, mission.motion.at(t).position, atol=1e-6)


def test_soundings_lie_on_the_seabed(mission: Mission) -> None:
    found = soundings.collect(mission)
    assert found is not None
    assert found.share == 1.0
    error = found.points[:, 2] - Seabed().height(found.points[:, 0], found.points[:, 1])
    assert np.abs(error).max() < 2e-3  # ranges are stored as float32


def test_noise_of_soundings_is_measured(tmp_path: Path) -> None:
    """Errors along slanted beams: the vertical part is sigma cos(angle), over +-60 degrees evenly, rms 0.841 sigma."""
    mission = missions(Recording(record(tmp_path / "m.mcap", kinds=("multibeam",), seconds=60.0, noise=1.0)))[0]
    found = soundings.collect(mission)
    assert found is not None
    result = soundings.accuracy(found.points, soundings.grid(found.points), Seabed().height)
    assert result is not None
    assert result.std == pytest.approx(0.02 * 0.841, rel=0.05)
    assert abs(result.bias) < 4 * result.std / np.sqrt(len(result.error))


def test_cells_hold_the_mean_of_their_soundings() -> None:
    rng = np.random.Generator(np.random.PCG64(3))
    points = np.concatenate([rng.uniform(0, 50, (40_000, 2)), rng.normal(-10, 0.1, (40_000, 1))], axis=1)
    cells = soundings.grid(points, cells=50)
    assert cells.cell == 1.0
    assert int(cells.count.sum()) == pytest.approx(40_000, rel=0.02)
    i, j = 20, 30
    inside = (np.abs(points[:, 0] - cells.x[i]) < 0.5) & (np.abs(points[:, 1] - cells.y[j]) < 0.5)
    assert cells.count[i, j] == inside.sum()
    assert cells.mean[i, j] == pytest.approx(points[inside, 2].mean())


def test_rows_compare_like_with_like(mission: Mission) -> None:
    found = {row.title: row for row in rows(mission, Seabed(), dead_reckoning(mission))}
    assert list(found) == [
        "depth", "altitude above the seabed", "forward speed over ground", "heading", "pitch, nose up",
        "roll, to starboard",
    ]  # fmt: skip
    for row in found.values():
        for series in row.series:
            error = series.value - series.truth
            if row.wraps:
                error = (error + 180) % 360 - 180
            assert np.nanmax(np.abs(error)) < 0.15, (row.title, series.name)


def test_the_sensor_table_counts(mission: Mission) -> None:
    table = {row["sensor"]: row for row in sensor_table(mission)}
    assert table["imu"]["count"] == 20_000
    assert table["imu"]["recorded_hz"] == pytest.approx(200.0)
    assert table["dvl"]["messages"] == [
        "geometry_msgs/msg/TwistWithCovarianceStamped", "marine_acoustic_msgs/msg/Dvl",
    ]  # fmt: skip
    assert table["gps"]["count"] == 10


@pytest.mark.parametrize("east_deg", [7.5, -21.0])
def test_a_declination_that_is_written_is_that_of_the_sensor(east_deg: float) -> None:
    """East of true north is clockwise from above; else it is that of the Earth at the origin."""
    written = {"intensity_t": 5e-5, "declination_deg": east_deg, "inclination_deg": 60.0}
    about = {"latitude_deg": "45.0", "longitude_deg": "12.5"}
    for keys in (written, {}):
        made: Any = SimpleNamespace(
            channels=lambda kind, message: [SimpleNamespace(about={"sensor": "compass"})],
            config=lambda name, keys=keys: keys if name == "compass" else {}, recording=SimpleNamespace(metadata=about),
        )  # fmt: skip
        field = earth_field_of(MagnetometerConfig(**keys), GeoOrigin(45.0, 12.5))
        assert declination(made) == pytest.approx(np.arctan2(field[1], field[0]), rel=1e-9)


def test_a_mission_without_motion_has_none_at_any_time() -> None:
    none = RecordedMotion(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)))
    assert len(none.at(np.array([1.0, 2.0])).position) == 0


@pytest.mark.parametrize(
    ("agent", "rate"),
    [("left_wing_12", 3.0), ("env0/left_wing_0", 3.0), ("scout_3", 8.0), ("env2/scout_1", 5.0), ("left_wing", 3.0)],
)
def test_sensors_of_members_are_those_of_their_group(agent: str, rate: float) -> None:
    """A member is GROUP_NUMBER, where the group's name may have underscores and an agent may be called so itself."""
    rates = {"left": 1.0, "left_wing": 3.0, "scout": 5.0, "scout_3": 8.0}
    agents = {name: {"sensors": {"imu": {"rate_hz": r}}} for name, r in rates.items()}
    kept = {"scenario.yaml": yaml.safe_dump({"agents": agents}).encode()}
    recording: Any = SimpleNamespace(attachments=kept)
    assert Mission(recording, agent).config("imu") == {"rate_hz": rate}
    assert Mission(recording, agent).config("dvl") == {}
    assert Mission(recording, "wing_12").config("imu") == {}
