"""Objects in notebooks: a picture and numbers, and names as text."""

from __future__ import annotations

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

import pelagos as pl
from pelagos.drawing.notebook import map_figure, reading_picture, series_figure, tracks_figure
from pelagos.sensors.sensor import Reading
from pelagos.sim.replay import Recording

SCENARIO = {
    "name": "<script>alert(1)</script>", "seed": 2, "world": {"type": "flat", "depth_m": 14.0},
    "agents": {"auv0": {
        "vehicle": "remus100", "start": {"position_m": [3, -7], "depth_m": 4.5, "heading_deg": 70},
        "sensors": {
            "depth": {"type": "depth", "rate_hz": 10},
            "sonar": {"type": "imaging_sonar", "rate_hz": 5, "beams": 16, "bins": 32},
        },
    }},
}  # fmt: skip


@pytest.fixture(scope="module")
def sim() -> pl.Simulation:
    return pl.Simulation.load(SCENARIO)


def picture(html: str) -> np.ndarray:
    found = re.search(r'src="data:image/png;base64,([^"]+)"', html)
    assert found is not None
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(found[1]))).convert("RGB"), dtype=float)


def test_every_object_has_a_picture_and_its_numbers(sim, tmp_path):
    result = sim.run(0.5, record=tmp_path / "short.mcap")
    reading = result.observations["auv0"]["sonar"]
    fan = picture(reading._repr_html_())
    assert fan.std() > 5  # a fan with echoes
    assert fan[-1, 0].max() == 0  # outside of the sector
    depth = result.observations["auv0"]["depth"]._repr_html_()
    assert f"{float(result.observations['auv0']['depth'].data[0, ...].ravel()[0]):.6g}" in depth
    shown = sim._repr_html_()
    assert "<script>" not in shown
    assert "&lt;script&gt;" in shown
    assert "70°" in shown or "69°" in shown
    assert picture(sim.world._repr_html_()).size
    assert picture(sim.model.agents["auv0"].vehicle._repr_html_()).std() > 5
    recording = Recording(tmp_path / "short.mcap")._repr_html_()
    assert "/auv0/truth" in recording
    assert picture(recording).std() > 5


def traces(port, starboard):
    """The picture's columns `(bins,)` of brightness, of a reading of two traces."""
    data = np.array([[port, starboard]])
    reading = Reading(data, np.zeros_like(data), 0, "auv0/side", np.array([True]), {}, "sidescan")
    return reading_picture(reading)[0].astype(int).sum(axis=-1)


def test_what_is_missing_is_dark_whatever_the_rest_is():
    """Port is drawn from its far end inwards; levels in decibels are negative, those of an empty band all NaN."""
    shown = traces([-40.0, np.nan, -70.0, np.inf], [-55.0, -30.0, -np.inf, -80.0])
    infinite, far, none, near, first, loudest, minus, faintest = shown
    assert none == minus == faintest == shown.min()
    assert infinite == loudest == shown.max()
    assert far < first < near
    assert len(set(traces([np.nan] * 4, [np.nan] * 4))) == 1
    kept = traces([0.0, 0.5, 1.0, np.nan], [0.25, 0.75, 1.0, 0.0])
    assert kept[0] == kept[3] == kept[7] == kept.min()
    assert kept[4] < kept[2] < kept[5] < kept[1] == kept[6]


def test_vehicles_lie_on_the_map_where_they_are_and_point_where_they_head(sim):
    """North is up, west is left: north 31, west 57, heading 40 deg, is in the upper left and points up and right."""
    axes = map_figure(sim.world, {"auv0": (31.0, 57.0, np.radians(40.0))}).axes[0]
    (line,) = [x for x in axes.lines if len(x.get_xdata()) == 1]
    assert line.get_xydata().tolist() == [[-57.0, 31.0]]
    tip = line.get_marker().vertices[0]
    assert np.degrees(np.arctan2(tip[0], tip[1])) == pytest.approx(40.0)
    left, right, south, north = axes.images[0].get_extent()
    assert (left, right, south, north) == pytest.approx((-500, 500, -500, 500))


def made(kind: str, values: np.ndarray, truth: np.ndarray, **extras: np.ndarray) -> Reading:
    return Reading(values[None], truth[None], 2_500_000_000, "auv0/it", np.array([True]), extras, kind)


def test_numbers_have_names_and_units_and_what_is_no_number_is_a_dash():
    shown = made("dvl", np.array([1.25, -0.5, np.nan]), np.array([1.24, -0.52, 0.0625]))._repr_html_()
    for text in ("velocity x [m/s]</td><td>1.25</td><td>1.24", "velocity y [m/s]</td><td>-0.5</td><td>-0.52",
                 "velocity z [m/s]</td><td>–</td><td>0.0625"):  # fmt: skip
        assert text in shown
    nothing = Reading(np.zeros((1, 3)), np.zeros((1, 3)), 0, "auv0/gps", np.array([False]), {}, "gps")
    assert "no reading" in nothing._repr_html_()


def test_a_multibeam_is_a_section_across_the_track():
    """A flat bottom 9 m below is a level line; port is on the left."""
    angle = np.radians(np.linspace(61, -60, 40))
    axes = series_figure(made("multibeam", 9.2 / np.cos(angle), 9.0 / np.cos(angle), angle=angle)).axes[0]
    truth, reading = (line.get_xydata() for line in axes.lines)
    assert truth[:, 1] == pytest.approx(-9.0)
    assert reading[:, 1] == pytest.approx(-9.2)
    assert truth[0, 0] == pytest.approx(9.0 * np.tan(np.radians(61)))
    assert np.diff(axes.get_xlim()) < 0
    plain = series_figure(made("hydrophone", np.arange(30.0), np.arange(30.0) - 2)).axes[0]
    assert plain.lines[0].get_xydata()[7].tolist() == [7, 5]


def test_readings_of_a_run_say_their_kind(sim):
    found = sim.observe("auv0", (2.0, -3.0, -5.0))
    assert {name: r.kind for name, r in found.items()} == {"depth": "depth", "sonar": "imaging_sonar"}


def test_a_straight_track_is_drawn_as_wide_as_it_is_long(sim, tmp_path):
    sim.reset()
    sim.run(1.0, record=tmp_path / "straight.mcap")
    above, deep = tracks_figure(Recording(tmp_path / "straight.mcap"), ["/auv0/truth"]).axes
    assert np.ptp(above.get_xlim()) == pytest.approx(np.ptp(above.get_ylim()))
    assert np.ptp(above.get_xlim()) >= 10.0
    assert above.lines[0].get_xydata()[0] == pytest.approx([7.0, 3.0], abs=0.1)  # started at north 3, west -7
    assert deep.lines[0].get_xydata()[[0, -1], 0] == pytest.approx([0.0, 1.0], abs=0.11)
    assert deep.lines[0].get_xydata()[0, 1] == pytest.approx(4.5, abs=0.1)
