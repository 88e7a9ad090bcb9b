"""The harbour: closed meshes, things in their places, free water for the survey, one world a seed."""

from __future__ import annotations

import hashlib
from collections import Counter

import numpy as np
import pytest
from pydantic import ValidationError

from pelagos.world.generate.harbour import HarbourConfig
from pelagos.world.mesh import Mesh


@pytest.fixture(scope="module")
def harbour():
    return HarbourConfig().build()


def digest(world):
    h = hashlib.sha256()
    for g in world.geometries:
        h.update(np.ascontiguousarray(g.vertices).tobytes() + g.faces.tobytes() + g.face_materials.tobytes())
        h.update(f"{g.name} {g.label} {g.instance}".encode())
    return h.hexdigest()


def test_everything_but_the_seabed_is_closed_and_faces_outwards(harbour):
    for g in harbour.geometries:
        mesh = Mesh(g.vertices, g.faces)
        assert g.name == "seabed" or (mesh.closed and mesh.volume > 0), g.name


def test_it_holds_what_was_asked_for(harbour):
    count = Counter(g.name for g in harbour.geometries)
    assert count["steel pile"] + count["batter pile"] + count["fender pile"] >= 40
    assert count["boulder"] == 110
    assert count["mooring buoy"] == 4
    assert {"sunken boat", "pipeline", "quay wall", "ladder", "pier deck", "tyre"} <= set(count)
    assert harbour.notes == ()
    assert 100_000 < harbour.triangles < 800_000
    assert {"piling", "boat", "pipe", "wall", "rock", "landscape"} <= set(harbour.labels.values())


def test_piles_stand_between_deck_and_seabed(harbour):
    for g in harbour.geometries:
        if g.name == "steel pile":
            foot = g.vertices[np.argmin(g.vertices[:, 2])]
            assert foot[2] < harbour.height(foot[0], foot[1]) - 1
            assert g.vertices[:, 2].max() > 0.5


def test_the_bed_is_as_deep_as_asked(harbour):
    z = harbour.terrain.z
    x, y = harbour.terrain.x, harbour.terrain.y
    basin = z[np.abs(x) < 85][:, (y > -60) & (y < 30)]
    assert abs(np.median(basin) + 15) < 0.5
    assert basin.min() > -18.5
    assert basin.max() < -12


def test_the_survey_box_is_free_from_4_5_m_above_the_bed_up(harbour):
    """Rays straight down from just below the surface meet nothing higher than that."""
    x, y = np.meshgrid(np.arange(-90, 90.1, 0.5), np.arange(-66, 44.1, 0.5), indexing="ij")
    origins = np.stack([x.ravel(), y.ravel(), np.full(x.size, -0.3)], axis=1)
    hits = harbour.cast(origins, (0, 0, -1), 40.0)
    assert hits.valid.all()
    above = hits.position[:, 2] - harbour.height(x.ravel(), y.ravel())
    assert above.max() < 4.5
    assert not harbour.near(np.array([[0.0, 0, -8], [-80, -60, -8], [80, 40, -8]]), 1.5).any()


def test_a_sonar_that_looks_at_the_pier_sees_piles(harbour):
    turn = np.radians(np.linspace(-60, 60, 512))
    rays = np.stack([np.sin(turn), np.cos(turn), np.zeros(512)], axis=1)
    hits = harbour.cast((0, 35, -9), rays, 60.0)
    names = {harbour.names[i] for i in np.unique(hits.instance[hits.valid])}
    assert "fender pile" in names
    assert "steel pile" in names
    assert 10 < hits.t[hits.valid].min() < 40


def test_the_pipe_hangs_free_in_its_span(harbour):
    """Somewhere along the pipe there is water between it and the bed: rays across, below its axis, pass under it."""
    pipe = next(g for g in harbour.geometries if g.name == "pipeline")
    gaps = []
    for x in np.arange(20, 40, 0.5):
        near = pipe.vertices[np.abs(pipe.vertices[:, 0] - x) < 0.6]
        low = near[np.argmin(near[:, 2])]
        gaps.append(low[2] - float(harbour.height(low[0], low[1])))
    assert max(gaps) > 0.4
    assert min(gaps) < 0.1


def test_same_seed_same_bytes_other_seed_other_bytes():
    small = {"length_m": 140, "width_m": 120, "grid_m": 1.0, "pier_length_m": 40, "boulders": 20, "debris": 12}
    a, b, c = (HarbourConfig(seed=s, **small).build() for s in (5, 5, 6))
    assert digest(a) == digest(b)
    assert digest(a) != digest(c)


def test_a_pier_longer_than_the_quay_is_refused():
    with pytest.raises(ValidationError, match="at most length_m - 60 = 160 m"):
        HarbourConfig(pier_length_m=200)
