"""Objects in notebooks: a picture and numbers, and names as text."""

from __future__ import annotations

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

import pelagos as pl
from pelagos.drawing.notebook import map_of
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


def test_track_lies_on_the_map_where_the_vehicle_was(sim):
    """North is up, west is left: a place in the north-west is in the upper left quarter."""
    low, high = sim.world.bounds[:, :2]
    track = np.array([low + 0.5 * (high - low) + [40.0, 60.0], low + 0.5 * (high - low) - [90.0, 140.0]])
    drawn = map_of(sim.world, track)
    rows, columns = np.nonzero((drawn == (255, 209, 102)).all(axis=-1))
    assert len(rows) == 8
    assert rows[0] < drawn.shape[0] / 2
    assert columns[0] < drawn.shape[1] / 2
    assert rows[-1] > drawn.shape[0] / 2
    assert columns[-1] > drawn.shape[1] / 2
