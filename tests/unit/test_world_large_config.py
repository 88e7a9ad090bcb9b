"""Large worlds: what their configuration accepts, and what it says about the rest."""

from __future__ import annotations

from types import SimpleNamespace

import netCDF4
import numpy as np
import pytest

from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.build import build_world, world_config
from pelagos.world.large.large import LargeConfig, _inset_source
from pelagos.world.large.stream import DETAILS, Stream, details, reached
from pelagos.world.large.survey import survey_source

SMALL = {"type": "large", "size_m": [4000, 3000], "resolution_m": 10.0}


def _config(**changes):
    return world_config({**SMALL, **changes})


def _built(**changes):
    return build_world(_config(**changes))


def test_a_file_of_heights_is_read_where_it_is_needed(tmp_path):
    z = np.random.default_rng(0).uniform(-90, -80, (401, 301)).astype(np.float32)
    np.save(tmp_path / "z.npy", z)
    world = _built(ground={"kind": "file", "path": str(tmp_path / "z.npy")})
    i, j = np.array([0, 7, 200, 400]), np.array([0, 9, 150, 300])
    np.testing.assert_array_equal(world.height(-2000 + 10.0 * i, -1500 + 10.0 * j), z[i, j].astype(np.float64))
    hits = world.cast(np.column_stack([-2000 + 10.0 * i[1:3], -1500 + 10.0 * j[1:3], [0, 0]]), (0, 0, -1), 200)
    np.testing.assert_allclose(-hits.t, z[i, j][1:3], atol=1e-3)


def test_an_inset_from_a_file_lies_in_the_ground(tmp_path):
    np.save(tmp_path / "hill.npy", np.full((113, 81), -33.0))
    inset = {"centre_m": [500, 0], "size_m": [140, 100], "resolution_m": 1.25, "path": str(tmp_path / "hill.npy")}
    world = _built(insets=[inset])
    assert float(world.height(500.0, 0.0)) == -33.0
    assert float(world.height(500.0, 38.0)) == -33.0  # up to the rim, a tenth of the shorter side wide
    plain = _built()
    assert float(world.height(500.0, 50.0)) == pytest.approx(float(plain.height(500.0, 50.0)), abs=1e-9)
    half_way = (-33.0 + float(plain.height(565.0, 0.0))) / 2
    assert float(world.height(565.0, 0.0)) == pytest.approx(half_way, abs=1e-4)
    assert -float(world.cast([500.0, 0.0, 0.0], (0, 0, -1), 500).t[0]) == pytest.approx(-33.0, abs=1e-3)


def test_insets_have_detail_of_their_own():
    """Two of one size differ in what lies on the ground between them, and either lies where its own index puts it."""
    places = [[500, -300], [-800, 700]]
    insets = [{"centre_m": p, "size_m": [100, 100], "resolution_m": 1.25, "relief_m": 2.0} for p in places]
    sources = [_inset_source(_config(insets=insets).insets[k], k, np.zeros(2), 10.0, "insets") for k in (0, 1, 0)]
    x, y = np.meshgrid(np.arange(-30, 30, 2.5), np.arange(-20, 25, 2.5))
    first, second, again = (source.heights(x, y) for source in sources)
    np.testing.assert_array_equal(first, again)
    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.5
    assert min(first.std(), second.std()) > 0.05


def test_a_survey_is_ground_too():
    survey = {"kind": "survey", "path": "matplotlib:topobathy.npz"}
    world = _built(ground=survey, latitude_deg=48.835, longitude_deg=-122.95)
    again = build_world(
        world_config(
            {
                "type": "bathymetry",
                "path": "matplotlib:topobathy.npz",
                "centre_deg": [48.835, -122.95],
                "size_m": [4000, 3000],
                "resolution_m": 10.0,
            }
        )
    )
    x, y = np.meshgrid(np.arange(-1500, 1500, 110.0), np.arange(-1000, 1000, 130.0))
    np.testing.assert_allclose(world.height(x, y), again.height(x, y), atol=1e-6)


@pytest.mark.parametrize("south", [False, True])
def test_a_survey_is_read_as_far_as_the_worlds_bent_edges_go(south, tmp_path):
    """At 60 degrees the middle of an edge of 200 km lies y^2 tan(lat) / 2R = 1.4 km nearer the pole than its ends."""
    sign = -1.0 if south else 1.0
    lat, lon = sign * np.arange(59.0, 61.0, 0.002), np.arange(11.0, 15.5, 0.02)
    lat = lat[::-1] if south else lat
    with netCDF4.Dataset(tmp_path / "a.nc", "w") as data:
        for name, values in (("lat", lat), ("lon", lon)):
            data.createDimension(name, len(values))
            data.createVariable(name, "f8", (name,))[:] = values
        data.createVariable("elevation", "f8", ("lat", "lon"))[:] = -100 + 40 * np.abs(lat[:, None]) + 0 * lon[None, :]
    origin = GeoOrigin(sign * 60.0, 13.2)
    ground = LargeConfig(ground={"kind": "survey", "path": str(tmp_path / "a.nc")}, size_m=(2e5, 2e5)).ground
    source = survey_source(ground, origin, x0=-1e5, y0=-1e5, cells=(200, 200), spacing=1000.0)
    x, y = np.meshgrid([-1e5, -99.3e3, 99.3e3, 1e5], [-1e5, -47e3, 0.0, 33e3, 1e5])
    expected = -100 + 40 * np.abs(origin.to_latlon(x, y)[0])
    np.testing.assert_allclose(source.heights(x, y), expected, atol=1e-6)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"size_m": [4003, 3000]}, "whole number .* of cells .* nearest: 4000"),
        ({"memory_mb": 300}, "leaves no room for the ground; allow at least"),
        ({"insets": [{"centre_m": [0, 0], "size_m": [50, 50], "resolution_m": 10}]}, "must be finer than the world's"),
        ({"insets": [{"centre_m": [2000, 0], "size_m": [50, 50], "resolution_m": 1}]}, "does not lie in the world"),
        ({"ground": {"kind": "file", "path": "/nowhere/z.npy"}}, "does not exist"),
    ],
)
def test_what_cannot_be_is_refused_with_words(changes, words):
    with pytest.raises(WorldError, match=words):
        _built(**changes)


def test_a_file_of_another_size_names_the_size_that_fits(tmp_path):
    np.save(tmp_path / "z.npy", np.zeros((11, 21)))
    with pytest.raises(WorldError, match=r"11 x 21 nodes.*size_m: \[100.0, 200.0\]"):
        _built(ground={"kind": "file", "path": str(tmp_path / "z.npy")})
    (tmp_path / "cut.npy").write_bytes(b"\x93NUMPY")
    with pytest.raises(WorldError, match="damaged or cut short"):
        _built(ground={"kind": "file", "path": str(tmp_path / "cut.npy")})


def test_full_resolution_goes_as_far_as_asked():
    """Fewer triangles stand in the scene, and 100 m from the vehicle rays still hit every node of the ground."""
    far, near = _built(), _built(reach_m=100.0)
    count = {name: len(w.scene().tables.static.corner) // 3 for name, w in (("far", far), ("near", near))}
    assert count["near"] < 0.5 * count["far"]
    x = np.arange(-90.0, 91.0, 10.0)
    hits = near.cast(np.stack([x, 0 * x, 0 * x], axis=1), (0.0, 0.0, -1.0), 1000.0)
    np.testing.assert_allclose(hits.position[:, 2], near.ground.surface(x, 0 * x), atol=1e-3)
    said = [n for n in _built(reach_m=1e6).notes if "does not fit into memory_mb" in n]
    assert len(said) == 1


def test_a_streamed_world_stands_at_full_resolution_about_its_last_inset_first():
    places = [[500, -300], [-800, 700]]
    insets = [{"centre_m": p, "size_m": [100, 100], "resolution_m": 1.25, "relief_m": 2.0} for p in places]
    view = Stream(_built(insets=insets).ground).view
    assert np.abs(view.places - places[1]).max() < 200  # rounded to half of the reach of full resolution


@pytest.mark.parametrize(("reach", "first"), [
    (np.inf, 8.0), (1537.0, 8.0), (1535.0, 8.0), (1151.0, 6.0), (400.0, 2.5), (385.0, 2.5), (383.0, 2.0), (10.0, 1.0),
])  # fmt: skip
def test_no_more_detail_is_tried_than_reaches_as_far_as_asked(reach, first):
    """Six tenths of 2 x 16 cells of 10 m, times the detail: 192 m for 1; all the coarser ones are tried after it."""
    ground = SimpleNamespace(spacing=10.0, reach=reach)
    found = details(ground)
    assert found[0] == first
    assert found == DETAILS[DETAILS.index(first) :]
    assert reached(ground, 2.5) == pytest.approx(480.0)


def test_the_radius_of_full_resolution_is_an_insets_own_about_it():
    """2 x 16 cells times the detail: 640 m beside insets, and 80 m where one of an eighth of the spacing is near."""
    stream = object.__new__(Stream)
    inset = SimpleNamespace(low=(100.0, -50.0), high=(180.0, 30.0), level=-3)
    wide = SimpleNamespace(low=(400.0, -900.0), high=(500.0, 900.0), level=-1)
    ground = SimpleNamespace(insets=[wide, inset], spacing=10.0, spacing_at=lambda level: 10.0 * 2.0**level)
    stream.ground = ground
    places = np.array([[140.0, 0.0], [21.0, -129.0], [19.0, 0.0], [140.0, 111.0], [450.0, 0.0], [179.0, 29.0],
                       [-900.0, 0.0], [819.0, 1219.0]])  # fmt: skip
    found = stream._radius(places, 2.0)
    assert found.tolist() == [80, 80, 640, 320, 320, 80, 640, 320]
