"""What a survey's values mean and where they lie: marks, signs, units, axes, the part that is read, the grid of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.bathymetry.axes import choose, named, window
from pelagos.world.bathymetry.bathymetry import BathymetryConfig, _own_spacing, _require, _sensible
from pelagos.world.bathymetry.projection import from_latlon, to_latlon
from pelagos.world.bathymetry.read import Reading, _check_units, _reader
from pelagos.world.bathymetry.read_netcdf import read_netcdf
from pelagos.world.bathymetry.read_npz import read_npz
from pelagos.world.bathymetry.read_raster import read_raster
from pelagos.world.bathymetry.read_soundings import _named, _separator, read_soundings
from pelagos.world.bathymetry.regrid import Extent
from pelagos.world.bathymetry.survey import Grid, Soundings, closed
from pelagos.world.bathymetry.triangles import gridded
from pelagos.world.bathymetry.values import in_metres, upwards

LAT, LON = 44.0 + 0.01 * np.arange(4), 13.0 + 0.02 * np.arange(5)


def grid(z: Any, **more: Any) -> Grid:
    return Grid(LAT, LON, np.broadcast_to(np.asarray(z, dtype=float), (4, 5)).copy(), "EPSG:4326", "z", **more)


def with_one(z: float, odd: float) -> Grid:
    made = grid(z)
    made.z[1:] += np.arange(15).reshape(3, 5)
    made.z[0, 2] = odd
    return made


@pytest.mark.parametrize(("others", "odd", "lost"), [
    (-30.0, -9999.0, True), (-30.0, 9999.0, True), (-9600.0, -9999.0, False), (-9400.0, -9999.0, True),
    (-30.0, -9998.0, False), (-30.0, -11_999.0, False), (-30.0, 12_001.0, True), (-30.0, -12_001.0, True),
])  # fmt: skip
def test_a_usual_mark_far_from_all_other_values_is_no_value(others, odd, lost):
    """Nearer than 500 to another it is a depth; no ground is deeper or higher than 12 km."""
    found = in_metres("a.nc", with_one(others, odd), "auto")
    assert np.isnan(found.z[0, 2]) == lost
    assert np.isnan(found.z).sum() == lost
    told = [n for n in found.notes if "taken as missing" in n]
    assert told == ([f"1 values such as {odd:g} cannot be heights and were taken as missing"] if lost else [])


def test_marks_are_in_the_files_unit_and_soundings_without_a_value_go():
    z = np.array([-100.0, -9999.0, -120.0, np.nan, -50.0])
    u, v = np.arange(5.0), 10 + np.arange(5.0)
    found: Any = in_metres("a.xyz", Soundings(u, v, z, "EPSG:32633", "z", unit="feet"), "auto")
    assert found.u.tolist() == [0, 2, 4]
    assert found.v.tolist() == [10, 12, 14]
    assert found.z == pytest.approx(0.3048 * np.array([-100, -120, -50]))
    assert in_metres("a.xyz", Soundings(u, v, z, "EPSG:32633", "z", unit="feet"), "fathom").z[0] == pytest.approx(
        -182.88
    )


def test_values_of_which_most_cannot_be_are_refused():
    half = np.where(np.arange(20).reshape(4, 5) < 10, -30.0, -30_000.0)
    assert np.isnan(in_metres("a.nc", grid(half), "auto").z).sum() == 10
    half[1, 4] = 13_000
    with pytest.raises(WorldError, match=r"most values of 'z' \(median -15015 m\) cannot be heights"):
        in_metres("a.nc", grid(half), "auto")


@pytest.mark.parametrize(("name", "words", "said", "asked", "z", "down", "why"), [
    ("depth", "", None, "auto", 12.0, True, "look (median 12.00)"), ("depth", "", None, "auto", -12.0, False, "look"),
    ("deptho", "", None, "auto", 12.0, True, "look"), ("h", "", None, "auto", 12.0, True, "look"),
    ("H", "", None, "auto", 12.0, True, "look"), ("height", "", None, "auto", 12.0, False, "look"),
    ("Band1", "Water Depth", None, "auto", 12.0, True, "look"), ("z", "", None, "auto", 12.0, False, "look"),
    ("z", "", True, "auto", -12.0, True, "as the file says"), ("depth", "", False, "auto", 12.0, False, "the file"),
    ("depth", "", True, "up", 12.0, False, "as the scenario says"), ("z", "", False, "down", 12.0, True, "scenario"),
])  # fmt: skip
def test_which_way_values_count(name, words, said, asked, z, down, why):
    """The scenario's word before the file's, the file's before what its values look like."""
    survey = Grid(LAT, LON, np.full((4, 5), z), "EPSG:4326", name, said, words=words)
    found, told = upwards(survey, asked, 0.75)
    np.testing.assert_allclose(found.z, (-z if down else z) + 0.75)
    assert told.startswith("depths, down: " if down else "heights, up: ")
    assert why in told


def test_a_grid_around_the_earth_is_closed_and_one_that_is_not_stays():
    z = np.arange(24.0).reshape(2, 12)
    whole = Grid(np.array([1.0, 2.0]), 15.0 + 30 * np.arange(12), z, "EPSG:4326", "z")
    found = closed(whole)
    assert found.v[-1] == 375.0
    np.testing.assert_array_equal(found.z, np.column_stack([z, z[:, 0]]))
    part = Grid(whole.u, whole.v[:-1], z[:, :-1], "EPSG:4326", "z")
    assert closed(part) is part


def test_an_array_is_chosen_by_its_name():
    path = Path("a.nc")
    assert choose(path, "Q", ["Q", "depth"]) == "Q"
    assert choose(path, None, ["time", "depth", "Elevation"]) == "Elevation"  # before depths, capitals or not
    assert choose(path, None, ["time", "DEPTHO", "h"]) == "DEPTHO"
    assert choose(path, None, ["slope"]) == "slope"
    assert named({"LONG": 1, "lon": 2, "Latitude": 3}, ("lon", "long")) == "lon"
    assert named({"LONG": 1}, ("lon", "long")) == "LONG"
    assert named({"x": 1}, ("lon",)) is None


@pytest.mark.parametrize(("box", "rows", "columns"), [
    ((10.25, 12.04, 20.9, 24.5), slice(49, 75), slice(11, 37)), ((4.9, 5.34, 17.9, 18.3), slice(0, 8), slice(0, 6)),
    ((70.0, 71.0, 60.0, 61.0), slice(196, 201), slice(156, 161)),
])  # fmt: skip
def test_the_part_that_is_read_has_four_nodes_around(box, rows, columns):
    """Rows from 5 to 25 deg N, columns from 18 to 50 deg E; a crop that lies elsewhere has its nearest node."""
    u, v = 5.0 + 0.1 * np.arange(201), 18.0 + 0.2 * np.arange(161)
    r, c = window(u, v, "EPSG:4326", Reading(None, None, "xyz", box))
    assert ((r.start, r.stop), (c.start, c.stop)) == ((rows.start, rows.stop), (columns.start, columns.stop))
    fall, _ = window(u[::-1], v, "EPSG:4326", Reading(None, None, "xyz", box))
    assert (fall.start, fall.stop) == (201 - rows.stop, 201 - rows.start)
    assert window(u, v, "EPSG:4326", Reading(None, None, "xyz", None)) == (slice(0, 201, 1), slice(0, 161, 1))
    assert window(u, v, "", Reading(None, None, "xyz", box)) == (slice(0, 201, 1), slice(0, 161, 1))


@pytest.mark.parametrize(("crs", "u", "v", "says"), [
    ("EPSG:4326", 90.005, 540.0, ""), ("EPSG:4326", 90.1, 13.0, "cannot be longitudes and latitudes"),
    ("EPSG:4326", 44.0, -541.0, "cannot be longitudes"), ("EPSG:32633", 89.0, 300.0, "look like degrees"),
    ("EPSG:32633", 91.0, 300.0, ""), ("EPSG:32633", 89.0, 361.0, ""),
])  # fmt: skip
def test_degrees_are_told_from_metres(crs, u, v, says):
    survey = Soundings(
        u - np.array([0.0, 2.0, 4.9]), v + np.array([0.0, -2.0, -4.0]) * np.sign(v), np.zeros(3), crs, "z"
    )
    if says:
        with pytest.raises(WorldError, match=says):
            _check_units(Path("a.xyz"), survey)
    else:
        _check_units(Path("a.xyz"), survey)
    wide = Soundings(np.array([80.0, 74.9]), np.array([13.0, 14.0]), np.zeros(2), "EPSG:32633", "z")
    _check_units(Path("a.xyz"), wide)  # 5 m apart: they may be metres


def test_a_file_is_read_by_how_it_begins(tmp_path):
    for name, begins, reader, what in (
        ("a.nc", b"\x89HDF\r\n\x1a\n", read_netcdf, ""), ("b.nc", b"II*\0 more", read_raster, "begins as TIFF"),
        ("c.grd", b"DSBBxxxx", read_raster, "begins as Surfer"), ("d.xyz", b"PK\3\4xxxx", read_npz, "begins as NumPy"),
        ("e.asc", b"ncols 43", read_raster, ""), ("f.txt", b"1 2 3 4 5", read_soundings, ""),
        ("g.txt", b"NCOLS 43", read_raster, "begins as ESRI ASCII"), ("h.tif", b"CDF\x01xxxx", read_netcdf, "NetCDF"),
    ):  # fmt: skip
        (tmp_path / name).write_bytes(begins)
        found, told = _reader(tmp_path / name, Path(name).suffix)
        assert found is reader, name
        assert bool(told) == bool(what)
        assert all(what in note and note.startswith(f"{name} is named") for note in told)


def test_longitudes_come_as_near_to_the_survey_as_they_can():
    lat, lon = np.array([1.0, 2.0, 3.0]), np.array([-179.0, 10.0, 179.5])
    u, v = from_latlon("EPSG:4326", lat, lon, near=200.0)
    assert u.tolist() == lat.tolist()
    assert v.tolist() == [181.0, 370.0, 179.5]
    assert from_latlon("EPSG:4326", lat, lon)[1].tolist() == lon.tolist()
    assert to_latlon("EPSG:4326", lat, np.array([181.0, -180.0, 539.5]))[1] == pytest.approx([-179.0, -180.0, 179.5])


@pytest.mark.parametrize(("spacing", "size", "found"), [
    (7.0, (100.0, 300.0), 7.0), (0.01, (100.0, 300.0), 0.06), (90.0, (100.0, 300.0), 25.0), (90, (300.0, 100.0), 25.0),
])  # fmt: skip
def test_a_spacing_is_such_that_a_crop_can_be_built_of_it(spacing, size, found):
    """At least 4 cells along the shorter side and at most 5000 along the longer."""
    assert _sensible(spacing, size) == pytest.approx(found)


def test_a_grids_own_spacing_is_that_of_its_closer_nodes():
    origin = GeoOrigin(44.02, 13.03)
    assert _own_spacing(grid(-9.0), origin, (1.0, 1.0)) == 1110.0  # 0.01 deg of latitude; 0.02 of longitude are 1604 m
    narrow = Grid(LAT, 13.0 + 0.005 * np.arange(5), np.zeros((4, 5)), "EPSG:4326", "z")
    assert _own_spacing(narrow, origin, (1.0, 1.0)) == pytest.approx(
        111_320 * 0.005 * np.cos(np.radians(44.015)), rel=5e-3
    )
    assert _own_spacing(Soundings(LAT, LAT, LAT, "EPSG:4326", "z"), origin, (300.0, 800.0)) == 2.0


def test_cells_are_rounded_where_a_crop_was_asked_for_and_else_cut():
    some = BathymetryConfig(path="a.nc", centre_deg=(44, 13), size_m=(9, 9))
    boxed = BathymetryConfig(path="a.nc", latitude_range_deg=(44, 45), longitude_range_deg=(13, 14))
    for config in (some, boxed):
        assert config._cells((104.0, 96.0), 10.0) == (10, 10)
        assert config._cells((106.0, 4.0), 10.0) == (11, 1)
    assert BathymetryConfig(path="a.nc")._cells((109.0, 199.999995), 10.0) == (10, 20)
    with pytest.raises(WorldError, match=r"5000 m x 9000 m at 1 m are \d+ nodes; use resolution_m: 1\.06 or more"):
        some._cells((5000.0, 9000.0), 1.0)


def test_a_crop_is_read_a_little_beyond_its_edges_and_farther_for_a_spectrum():
    crop = {"path": "a.nc", "centre_deg": (60.0, 13.0), "size_m": (20_000.0, 4000.0)}
    for detail, share in ((None, 0.55), ({"seed": 1}, 3.0)):
        south, north, west, east = BathymetryConfig(**crop, detail=detail)._box()
        assert [60 - south, north - 60] == pytest.approx([share * 20_000 / 111_412] * 2, rel=2e-3)
        assert [13 - west, east - 13] == pytest.approx([share * 4000 / 55_800] * 2, rel=2e-2)
    assert BathymetryConfig(path="a.nc")._box() is None
    ranges = {"latitude_range_deg": (1, 2), "longitude_range_deg": (3, 5)}
    assert BathymetryConfig(path="a.nc", **ranges)._box() == (1, 2, 3, 5)


def test_a_place_outside_of_a_survey_is_told_and_longitudes_are_taken_round_the_earth():
    covered = Extent(south=-10.0, north=30.0, west=100.0, east=140.0)
    for place in ((5.0, 110.0), (30.3, 110.0), (5.0, 99.7), (5.0, 470.0), (5.0, -250.0)):
        _require("a.nc", covered, [place])
    for place in ((30.5, 110.0), (5.0, 99.5), (5.0, 141.0), (-10.5, 110.0)):
        with pytest.raises(WorldError, match="outside the data") as told:
            _require("a.nc", covered, [(5.0, 110.0), place])
        assert "exchanged" not in str(told.value)
    with pytest.raises(WorldError, match="look exchanged: 20, 110 lies inside") as told:
        _require("a.nc", Extent(10.0, 40.0, 100.0, 140.0), [(110.0, 20.0)])


@pytest.mark.parametrize(("line", "mark", "comma"), [
    ("1;2;3", ";", False), ("1,5;2,5;3,5", ";", True), ("1.5;2,5;3", ";", False), ("1\t2\t3", "\t", False),
    ("1,5\t2,5\t3", "\t", True), ("1,2,3", ",", False), ("1,5 2,5 3,5", None, True), ("1,5 2,5", ",", False),
    ("1 2 3", None, False), ("-1,5 +2,5 3,5", None, True), ("1,5 2 3,5", ",", False),
])  # fmt: skip
def test_columns_are_told_apart(line, mark, comma):
    assert _separator(line) == (mark, comma)


@pytest.mark.parametrize(("header", "order"), [
    (["lon", "lat", "depth"], {"v": 0, "u": 1, "z": 2}), (["N", "E", "Z"], {"u": 0, "v": 1, "z": 2}),
    (["id", "x_utm", "y_utm", "z"], {"z": 3, "v": 1, "u": 2}), (["depth", "z", "x", "y"], {"z": 0, "v": 2, "u": 3}),
    (["x", "n m", "z"], None), (["east coordinate", "northing (m)", "water depth"], {"v": 0, "u": 1, "z": 2}),
    (["long x", "lat", "elev"], {"u": 1, "v": 0, "z": 2}),
])  # fmt: skip
def test_columns_are_found_by_their_names(header, order):
    assert _named(header) == order


@pytest.mark.parametrize(("text", "says"), [
    ("1\n2\n", "has 1 columns of numbers; x, y and z need 3"), ("1 2\nso far\n", "has 2 columns of numbers"),
    ("1 2\n3\n", "has 2 columns"), ("so far\nx y z\n", "holds no row of numbers"),
])  # fmt: skip
def test_text_of_too_few_columns_is_told_from_text_of_none(text, says, tmp_path):
    (tmp_path / "a.xyz").write_text(text)
    with pytest.raises(WorldError, match=says):
        read_soundings(tmp_path / "a.xyz", Reading(None, None, "xyz", None))


def test_a_header_may_stand_off_from_its_rows(tmp_path):
    (tmp_path / "a.csv").write_text("made by hand\ndepth,lat,lon\n\n \n12.5,44.1,13.2\n14.5,44.3,13.7\n")
    found = read_soundings(tmp_path / "a.csv", Reading(None, None, "xyz", None))
    assert (found.u.tolist(), found.v.tolist(), found.z.tolist()) == ([44.1, 44.3], [13.2, 13.7], [12.5, 14.5])
    assert (found.name, found.crs) == ("depth", "EPSG:4326")


@pytest.mark.parametrize(("limits", "said"), [((80.0, 95.0), "95"), ((-91.0, -80.0), "-91"), ((-97.0, 95.0), "-97")])
def test_a_range_of_latitudes_ends_at_a_pole(limits, said):
    config = BathymetryConfig(path="a.nc", latitude_range_deg=limits, longitude_range_deg=(13, 14))
    with pytest.raises(WorldError, match=f"latitude {said} is not on Earth"):
        config.build()


def test_nodes_on_the_edges_and_corners_of_triangles_have_their_values():
    """Soundings on a lattice, which is that of the nodes turned over: no node is missed, and a plane stays one."""
    i, j = (v.ravel() for v in np.meshgrid(np.arange(7.0), np.arange(9.0), indexing="ij"))
    for turn in (1.0, -1.0):
        points = np.stack([3 + 2 * turn * i, -5 + 3 * turn * j], axis=1)
        values = 0.5 * points[:, 0] - 0.25 * points[:, 1] + 7
        x, y = np.unique(points[:, 0]), np.unique(points[:, 1])
        found = gridded(points, values, x, y)
        np.testing.assert_allclose(found, 0.5 * x[:, None] - 0.25 * y + 7, atol=1e-9)
