"""What worlds and their files refuse, and what they say of what is odd."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from zipfile import ZipFile

import netCDF4
import numpy as np
import pytest
import rasterio
import trimesh
from matplotlib.figure import Figure
from pydantic import ValidationError

from pelagos.errors import CommandError, LookupFailed, WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.world import shapes
from pelagos.world.bathymetry.bathymetry import BathymetryConfig, _notes
from pelagos.world.bathymetry.detail import spectrum
from pelagos.world.bathymetry.nodes import survey_nodes
from pelagos.world.bathymetry.read import Reading, read_survey
from pelagos.world.bathymetry.read_las import _crs
from pelagos.world.bathymetry.regrid import extent
from pelagos.world.bathymetry.survey import Grid, Soundings
from pelagos.world.bathymetry.values import in_metres
from pelagos.world.body import Prop
from pelagos.world.build import build_world, world_config
from pelagos.world.doubt import doubts
from pelagos.world.export import _beside, _plan, load, save
from pelagos.world.files import read_mesh
from pelagos.world.generate.draw import Distribution
from pelagos.world.generate.grade import GradeConfig
from pelagos.world.generate.harbour import _Harbour
from pelagos.world.generate.objects import ObjectConfig, Placer
from pelagos.world.generate.route import route
from pelagos.world.generate.scatter import Places
from pelagos.world.label import label_number
from pelagos.world.large.clearance import GroundClearance
from pelagos.world.large.field import _beneath
from pelagos.world.large.large import LargeConfig
from pelagos.world.large.picture import pictured
from pelagos.world.large.source import FileSource, grid_file_shape
from pelagos.world.large.stream import Stream
from pelagos.world.large.survey import survey_source
from pelagos.world.material import MATERIALS
from pelagos.world.mover import MoverConfig
from pelagos.world.path import WaypointPath
from pelagos.world.placement import _seen_from_behind
from pelagos.world.preview import _draw_paths, _shown
from pelagos.world.robots.read import read_description
from pelagos.world.sheet import summary
from pelagos.world.size import refuse_large
from pelagos.world.terrain import HeightField
from pelagos.world.viewpoint import _close, _encloses, _mostly_seen, _Object, _whole, viewpoints
from pelagos.world.world import World

LAT, LON = np.linspace(44.0, 44.2, 5), np.linspace(13.0, 13.3, 4)


def archive(path: Path, **arrays: np.ndarray) -> Path:
    np.savez(path, **arrays)
    return path


def dataset(path: Path, variables: dict, sizes: dict) -> Path:
    """Variables by name: (dimensions, values)."""
    with netCDF4.Dataset(path, "w") as data:
        for name, size in sizes.items():
            data.createDimension(name, size)
        for name, (dimensions, values) in variables.items():
            data.createVariable(name, "f8", dimensions)[:] = values
    return path


def raster(path: Path, transform, bands: int = 1) -> Path:
    profile = {"driver": "GTiff", "width": 4, "height": 5, "count": bands, "dtype": "float32", "crs": "EPSG:32633"}
    with rasterio.open(path, "w", transform=transform, **profile) as file:
        for k in range(bands):
            file.write(np.full((5, 4), -10.0 * (k + 1), np.float32), k + 1)
    return path


def text(path: Path, content: str) -> Path:
    path.write_text(content)
    return path


Z = np.arange(20.0).reshape(5, 4) - 40
UPRIGHT = rasterio.Affine(10, 0, 350_000, 0, -10, 4_890_000)
TURNED = rasterio.Affine(10, 2, 350_000, 2, -10, 4_890_000)
ROWS = "x,y,z\n" + "".join(f"{350_000 + 10 * k},{4_890_000 + 7 * k},{-k}\n" for k in range(9))
SURVEYS = {
    "no axes": (lambda t: archive(t / "a.npz", lat=LAT, east=LON, z=Z), {},
                r"has no axes named lat, lon or y, x; it has: lat, east, z"),
    "another shape": (lambda t: archive(t / "a.npz", lat=LAT, lon=LON, z=Z.T), {},
                      r"'z' is \(4, 5\), but its axes lat, lon have 5, 4"),
    "none": (lambda t: archive(t / "a.npz", lat=LAT, lon=LON), {}, "holds no array on two axes; say which one is"),
    "several": (lambda t: archive(t / "a.npz", lat=LAT, lon=LON, one=Z, two=Z), {},
                "holds one, two; say which one is meant: variable: NAME"),
    "one of several": (lambda t: archive(t / "a.npz", lat=LAT, lon=LON, one=Z, two=2 * Z), {"variable": "two"}, ""),
    "known of several": (lambda t: archive(t / "a.npz", lat=LAT, lon=LON, one=Z, depth=2 * Z), {}, ""),
    "no coordinates": (lambda t: dataset(t / "a.nc", {"z": (("p", "q"), Z)}, {"p": 5, "q": 4}), {},
                       "has no coordinates named lat, lon or y, x; it has: z"),
    "nothing": (lambda t: dataset(t / "a.nc", {}, {}), {}, "named lat, lon or y, x; it has: nothing"),
    "three dimensions": (
        lambda t: dataset(t / "a.nc", {"lat": (("lat",), LAT), "lon": (("lon",), LON), "z": (("lat", "k"), Z)},
                          {"lat": 5, "lon": 4, "k": 4}), {}, r"'z' has dimensions \('lat', 'k'\), not lat and lon"),
    "turned": (lambda t: raster(t / "a.tif", TURNED), {}, "is a rotated raster; turn it upright first: gdalwarp IN"),
    "band 3": (lambda t: raster(t / "a.tif", UPRIGHT, 2), {"variable": "3"},
               "has no band '3'; it has 2 bands"),
    "band 0": (lambda t: raster(t / "a.tif", UPRIGHT, 2), {"variable": "0"}, "no band '0'"),
    "exchanged": (lambda t: text(t / "a.csv", "lat,lon,z\n100,13,-3\n101,14,-4\n102,12,-5\n"), {},
                  "its latitudes run to 102; are the columns exchanged"),
    "order": (lambda t: text(t / "a.xyz", ROWS[6:]), {"columns": "xxz", "crs": "EPSG:32633"},
              "columns must be an order of x, y and z such as 'xyz', not 'xxz'"),
}  # fmt: skip


@pytest.mark.parametrize("case", SURVEYS)
def test_surveys_that_cannot_be_read_are_refused(case, tmp_path):
    make, keys, said = SURVEYS[case]
    reading = Reading(**{"variable": None, "crs": None, "columns": "xyz", "box": None, "unit": "auto", **keys})
    if said:
        with pytest.raises(WorldError, match=rf"bathymetry file .*a\.\w+.*{said}"):
            read_survey(str(make(tmp_path)), reading)
    else:
        np.testing.assert_array_equal(read_survey(str(make(tmp_path)), reading).z, 2 * Z)


@pytest.mark.parametrize(("band", "depth"), [(None, 10), ("1", 10), ("2", 20)])
def test_a_band_is_read_by_its_number(band, depth, tmp_path):
    path = raster(tmp_path / "a.tif", UPRIGHT, 2)
    found = read_survey(str(path), Reading(band, None, "xyz", None))
    assert (found.z == -depth).all()


@pytest.mark.parametrize(("package", "name"), [
    ("laspy", "a.las"), ("netCDF4", "a.nc"), ("rasterio", "a.tif"),
])  # fmt: skip
def test_a_package_that_is_missing_is_named(package, name, tmp_path, monkeypatch):
    (tmp_path / name).write_bytes(b"x" * 400)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(WorldError, match=rf"bathymetry file .*{name} needs the package {package.lower()}; "):
        read_survey(str(tmp_path / name), Reading(None, None, "xyz", None))


@pytest.mark.parametrize(("keys", "said"), [
    ({"latitude_range_deg": (44, 45)}, "latitude_range_deg and longitude_range_deg go together: give both, or neither"),
    ({"longitude_range_deg": (13, 14)}, "latitude_range_deg and longitude_range_deg go together"),
    ({"latitude_range_deg": (44, 45), "longitude_range_deg": (14, 14)}, r"longitude_range_deg must rise, not \[14"),
    ({"centre_deg": (44, 13), "size_m": (100, 0)}, r"size_m must be greater than zero, not \[100"),
    ({"centre_deg": (44, 13), "size_m": (-5, 100)}, r"size_m must be greater than zero, not \[-5"),
])  # fmt: skip
def test_crops_that_cannot_be_are_refused(keys, said):
    with pytest.raises(ValidationError, match=said):
        BathymetryConfig(path="a.nc", **keys)
    BathymetryConfig(path="a.nc", latitude_range_deg=(44, 45), longitude_range_deg=(13, 14))


def test_a_spectrum_needs_a_relief_of_enough_nodes():
    relief = np.random.default_rng(3).normal(size=(60, 60))
    assert spectrum(relief[:16, :16], (10.0, 10.0)).level > 0
    for z, has in ((relief[:15], "15 x 60"), (relief[:, :15], "60 x 15")):
        with pytest.raises(WorldError, match=f"of 16 x 16 nodes or more to measure its spectrum, not {has}; take a"):
            spectrum(z, (10.0, 10.0))
    slope = np.broadcast_to(0.1 * np.arange(60.0)[:, None], (60, 60))
    with pytest.raises(WorldError, match="this survey has none; leave detail out"):
        spectrum(slope, (10.0, 10.0))


def test_a_survey_lies_on_earth_and_its_crop_has_nodes():
    origin = GeoOrigin(44.1, 13.15)
    grid = Grid(LAT, LON, Z, "EPSG:4326", "z")
    nodes, holes = survey_nodes(grid, origin, middle=(0.0, 0.0), size=(30_000.0, 30_000.0))
    assert nodes.z.shape == (5, 4)
    assert holes == 0
    with pytest.raises(WorldError, match="the crop holds 1 x 0 nodes of the survey; nodes: survey needs 2 x 2 or more"):
        survey_nodes(grid, origin, middle=(0.0, 0.0), size=(2000.0, 2000.0))
    assert extent(grid).holds(44.2, 13.3)
    assert not extent(grid).holds(44.21, 13.3)
    with pytest.raises(
        WorldError, match="the survey do not fit its coordinate system 'EPSG:32633'; is it the right one"
    ):
        extent(Soundings(np.array([1e12, 2e12]), np.array([1e12, 2e12]), np.zeros(2), "EPSG:32633", "z"))


@pytest.mark.parametrize(("unit", "asked", "factor", "said"), [
    ("furlong", "auto", 1, "the unit 'furlong' of the values is not known; they were taken as metres"),
    ("furlong", "m", 1, ""), ("1", "auto", 1, ""), ("unknown", "auto", 1, ""), ("", "auto", 1, ""),
    ("ft", "auto", 0.3048, "values in ft were turned into metres, 0.3048 m each"),
])  # fmt: skip
def test_units_that_are_not_known_are_told(unit, asked, factor, said):
    found = in_metres("a.nc", Grid(LAT, LON, Z, "EPSG:4326", "z", unit=unit), asked)
    np.testing.assert_allclose(found.z, factor * Z)
    assert list(found.notes) == ([said] if said else [])


def test_nodes_far_from_any_sounding_are_told():
    """Soundings 10 m apart on a line: most nodes of a square of 400 m are far from all of them."""
    origin = GeoOrigin(44.1, 13.15)
    lat, lon = origin.to_latlon(np.arange(-200.0, 200.0, 10.0), np.zeros(40))
    ground = HeightField(-200.0, -200.0, 10.0, np.full((41, 41), -9.0))
    line = Soundings(lat, lon, np.full(40, -9.0), "EPSG:4326", "z")
    (told,) = [n for n in _notes(ground, line, origin, 0, "depths") if "from any sounding" in n]
    count, share = int(told.split()[0]), float(told.split("(")[1].split()[0])
    assert 0.5 * 41 * 41 < count < 41 * 41
    assert share == pytest.approx(100 * count / 41**2, abs=0.05)
    lat, lon = origin.to_latlon(*(a.ravel() for a in np.meshgrid(ground.x, ground.y, indexing="ij")))
    dense = Soundings(lat, lon, np.full(41 * 41, -9.0), "EPSG:4326", "z")
    assert not [n for n in _notes(ground, dense, origin, 0, "depths") if "from any sounding" in n]


@pytest.mark.parametrize(("make", "error", "said"), [
    (lambda: Prop("mesh"), CommandError, "a prop of shape 'mesh' needs the path of a mesh file: Prop.'mesh', path="),
    (lambda: read_mesh(Path(__file__)), WorldError, r"the format '\.py' is not read; known: \.\w+, "),
    (lambda: read_description(Path("no_such.urdf")), WorldError, r"description file no_such\.urdf does not exist"),
    (lambda: Distribution(loguniform=(0, 2)), ValueError, "loguniform needs values greater than zero"),
    (lambda: Distribution(lognormal=(0, 0.3)), ValueError, "lognormal needs a median greater than zero"),
    (lambda: Distribution(lognormal=(1, -0.3)), ValueError, r"deviation of lognormal must be at least 0, not -0\.3"),
    (lambda: GradeConfig(at_m=(0, 0), depth_m=5), ValueError, "give radius_m of a disc, or size_m of a rectangle"),
    (lambda: GradeConfig(at_m=(0, 0), depth_m=5, radius_m=3, size_m=(4, 4)), ValueError, "give radius_m of a disc"),
    (lambda: WaypointPath(points_m=[(0, 0, 1), (0, 0, 1), (2, 0, 0)], speed_mps=1), ValueError,
     "two points that follow each other are the same"),
    (lambda: WaypointPath(points_m=[(0, 0, 1), (2, 0, 0)], speed_mps=1, at_end="loop"), ValueError,
     "a loop needs three points or more, the first not given again at the end"),
    (lambda: WaypointPath(points_m=[(0, 0, 1), (2, 0, 0), (2, 2, 0), (0, 0, 1)], speed_mps=1, at_end="loop"),
     ValueError,
     "a loop needs three points or more, the first not given again"),
])  # fmt: skip
def test_parts_of_worlds_that_cannot_be_are_refused(make, error, said):
    with pytest.raises(error, match=said):
        make()


def test_what_is_just_possible_is_taken():
    assert Distribution(loguniform=(0.1, 2)).range == (0.1, 2)
    assert Distribution(normal=(5, 0.5)).range == (4, 6)
    low, high = Distribution(lognormal=(3, 0.4)).range
    assert (low, high) == (0, pytest.approx(3 * np.exp(0.8)))
    assert Distribution(choice=(3, 1, 2)).range == (1, 3)
    points = [(0, 0, 1), (2, 0, 0), (2, 2, 0)]
    WaypointPath(points_m=points, speed_mps=1, at_end="loop")
    WaypointPath(points_m=[*points, points[0]], speed_mps=1)


def test_a_label_of_a_scenario_may_be_spelt_as_holoocean_does():
    own = {"old_anchor": 77, "Buoy Line": 78}
    assert [label_number(n, own) for n in ("old_anchor", "OldAnchor", "old anchor", "Buoy Line")] == [77, 77, 77, 78]
    with pytest.raises(LookupFailed, match="did you mean 'old_anchor'"):
        label_number("old_ancor", own)


def test_a_mesh_that_is_inside_out_is_told():
    box = shapes.box((1.0, 2.0, 3.0))
    assert doubts(box, "a box") == []
    turned = type(box)(box.vertices, box.faces[:, ::-1])
    assert doubts(turned, "a box") == ["a box is inside out: its faces look inwards"]


def test_faces_through_each_other_are_not_counted_where_there_are_too_many(monkeypatch):
    a, b = shapes.box((1.0, 1.0, 1.0)), shapes.box((1.0, 1.0, 1.0)).moved((0.3, 0.2, 0.1))
    both = type(a)(np.concatenate([a.vertices, b.vertices]), np.concatenate([a.faces, b.faces + len(a.vertices)]))
    assert any("intersects itself" in d for d in doubts(both, "boxes"))
    monkeypatch.setattr("pelagos.world.doubt._MOST_PAIRS", 10)
    assert doubts(both, "boxes") == []


ROBOTS = {
    "other mesh": ("<mujoco><worldbody><geom type='mesh' mesh='hull'/></worldbody></mujoco>",
                   "a geom names the mesh 'hull', which no <asset> has a file for"),
    "asset without file": ("<mujoco><asset><mesh name='hull'/></asset><worldbody><geom type='mesh' mesh='hull'/>"
                           "</worldbody></mujoco>", "'hull', which no <asset> has a file for"),
    "include": ("<mujoco><include file='no_such.xml'/></mujoco>", r"'no_such\.xml' that is included was not found in"),
    "itself": ("<mujoco><include file='robot.xml'/></mujoco>", r"'robot\.xml' that is included was not found in"),
    "numbers": ("<mujoco><worldbody><geom type='capsule' size='1' fromto='0 0 0 1 1'/></worldbody></mujoco>",
                "'0 0 0 1 1' is not 6 numbers"),
    "more numbers": ("<mujoco><worldbody><geom type='capsule' size='1' fromto='0 0 0 1 1 2 2'/></worldbody></mujoco>",
                     "'0 0 0 1 1 2 2' is not 6 numbers"),
    "height field": ("<mujoco><worldbody><geom type='hfield' hfield='a'/></worldbody></mujoco>",
                     "holds no visual shapes that are read"),
    "heightmap": ("<sdf><model name='m'><link name='l'><visual name='v'><geometry><heightmap/></geometry></visual>"
                  "</link></model></sdf>", "holds no visual shapes that are read"),
}  # fmt: skip


@pytest.mark.parametrize("case", ROBOTS)
def test_descriptions_that_cannot_be_read_are_refused(case, tmp_path):
    source, said = ROBOTS[case]
    with pytest.raises(WorldError, match=said):
        read_description(text(tmp_path / "robot.xml", source))


def test_a_mover_from_a_file_needs_one(tmp_path):
    mover = MoverConfig(name="buoy", body="file", path=WaypointPath(points_m=[(0, 0, 0), (1, 0, 0)], speed_mps=1))
    with pytest.raises(LookupFailed, match=r"buoy: .*mesh file of a mover.*file: PATH"):
        mover._parts()
    cube = text(tmp_path / "box.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n")
    ((mesh, material),), _ = mover.model_copy(update={"file": cube, "size_m": 3.0})._parts()
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(6)
    assert material == "steel"


def test_saved_worlds_of_another_format_or_with_broken_movers_are_refused(tmp_path):
    path = save(build_world(world_config({"type": "flat"})), tmp_path / "world.npz")
    whole = dict(np.load(path))
    about = bytes(whole["about"]).decode()
    form = about.split('"format": ')[1].split(",")[0]

    def changed(old: str, new: str) -> Path:
        assert old in about
        arrays = {**whole, "about": np.frombuffer(about.replace(old, new).encode(), np.uint8)}
        return archive(tmp_path / "other.npz", **arrays)

    with pytest.raises(WorldError, match=rf"other\.npz has format 99; this version reads {form}"):
        load(changed(f'"format": {form}', '"format": 99'))
    with pytest.raises(WorldError, match=r"other\.npz: its movers cannot be read \("):
        load(changed('"movers": []', '"movers": [{"name": 3}]'))
    assert load(changed(form, form)).bounds[0][2] == load(path).bounds[0][2]


def test_a_sheet_counts_twelve_kinds():
    stats = {
        "extent_m": [10.0, 20.0, 3.0], "ground_z_m": [-3.0, -2.0, -1.0], "area_m2": 200.0,
        "movers": {}, "materials": [], "triangles": 5, "mesh_mb": 1.0, "latitude_deg": 44.0, "longitude_deg": 13.0,
    }  # fmt: skip
    objects = lambda kinds: dict(summary({**stats, "objects": {f"kind{k}": k + 1 for k in range(kinds)}}))["objects"]
    assert objects(12).endswith("12 kind11")
    assert objects(13).startswith("91: 1 kind0, ")
    assert objects(13).endswith("12 kind11, ...")


def large(**changes):
    return build_world(world_config({"type": "large", "size_m": [4000, 3000], "resolution_m": 10.0, **changes}))


@pytest.fixture(scope="module")
def sea():
    return large()


def test_the_ground_of_a_large_world_between_its_nodes(sea):
    """Bilinear in a cell: its middle has the mean of its corners."""
    x, y = np.array([-1990.0, 500.0, 730.0]), np.array([-1480.0, 20.0, 990.0])
    corners = np.mean([sea.ground.surface(x + a, y + b) for a in (0, 10) for b in (0, 10)], axis=0)
    for ground in (sea.ground, sea.terrain):
        np.testing.assert_allclose(ground.height(x, y), sea.ground.surface(x, y), atol=1e-9)
        np.testing.assert_allclose(ground.height(x + 5, y + 5), corners, atol=1e-9)
    assert np.isnan(sea.ground.height(np.array([9999.0]), np.array([0.0]))).all()


def test_ground_is_not_near_where_there_is_none(sea, monkeypatch):
    near = GroundClearance(sea.ground)
    deep = np.array([[2100.0, 0.0, -5000.0], [0.0, 1700.0, -5000.0], [2100.0, 1700.0, -5000.0], [0.0, 0.0, -5000.0]])
    np.testing.assert_array_equal(near.near(deep, 50.0), [False, False, False, True])
    np.testing.assert_array_equal(near.near(deep, 110.0), [True, False, False, True])
    monkeypatch.setattr("pelagos.world.large.clearance._KEPT", 1)
    places = np.array([[-1900.0, -1400.0, 0.0], [1900.0, 1400.0, 0.0]])
    places[:, 2] = sea.ground.surface(*places[:, :2].T) + 3
    few = GroundClearance(sea.ground)
    for _ in range(2):
        np.testing.assert_array_equal(few.near(places, 0.5), [False, False])
        np.testing.assert_array_equal(few.near(places, 20.0), [True, True])
    assert len(few._known) == 1


def test_ground_beneath_a_field_is_coarser_where_it_is_large(sea, monkeypatch):
    low, high = np.array([-400.0, -300.0]), np.array([400.0, 300.0])
    fine = _beneath(sea.ground, low, high)
    assert fine.spacing == 10
    monkeypatch.setattr("pelagos.world.large.field._MAX_NODES", 81 * 61)
    assert _beneath(sea.ground, low, high).spacing == 10
    monkeypatch.setattr("pelagos.world.large.field._MAX_NODES", 81 * 61 - 1)
    coarse = _beneath(sea.ground, low, high)
    assert coarse.spacing == 20
    np.testing.assert_allclose(coarse.z, fine.z[::2, ::2], atol=1e-9)


def test_files_of_heights_that_cannot_be_ground_are_refused(tmp_path):
    for z, has in (
        (np.zeros((3, 4), int), r"int64 \(3, 4\)"),
        (np.zeros(4), r"float64 \(4,\)"),
        (np.zeros((1, 4)), r"\(1, 4\)"),
    ):
        np.save(tmp_path / "z.npy", z)
        with pytest.raises(WorldError, match=f"a large ground needs float32 or float64 heights .nx, ny., not .*{has}"):
            grid_file_shape(tmp_path / "z.npy")
    z = np.zeros((6, 5), np.float32)
    z[2, 3] = np.nan
    np.save(tmp_path / "hole.npy", z)
    source = FileSource(tmp_path / "hole.npy", x0=0.0, y0=0.0, spacing=10.0)
    assert source.heights(np.array([20.0]), np.array([20.0])) == 0
    with pytest.raises(WorldError, match=r"hole\.npy: the value at node \(2, 3\) is not finite"):
        source.heights(np.array([10.0, 20.0]), np.array([0.0, 30.0]))
    np.save(tmp_path / "hill.npy", np.zeros((11, 21)))
    inset = {"centre_m": [0, 0], "resolution_m": 5.0, "path": str(tmp_path / "hill.npy")}
    with pytest.raises(WorldError, match=r"11 x 21 nodes, which over size_m \[100.*\] are 10 m apart along x and 5 m"):
        large(insets=[{**inset, "size_m": [100, 100]}])


def test_a_survey_of_a_large_world_covers_its_origin_and_fits_into_memory(tmp_path, monkeypatch):
    path = archive(tmp_path / "a.npz", lat=LAT, lon=LON, z=Z)
    source = lambda path, lat: survey_source(
        LargeConfig(ground={"kind": "survey", "path": str(path)}, size_m=(400, 300)).ground,
        GeoOrigin(lat, 13.1), x0=-200.0, y0=-150.0, cells=(4, 3), spacing=100.0,
    )  # fmt: skip
    source(path, 44.1)
    with pytest.raises(
        WorldError, match=r"a\.npz covers .*, not the world's origin at 44\.3, 13\.1; set latitude_deg and"
    ):
        source(path, 44.3)
    lat, lon = np.meshgrid(np.linspace(44.09, 44.11, 9), np.linspace(13.09, 13.11, 9))
    rows = "".join(f"{a:.6f},{b:.6f},-9\n" for a, b in zip(lat.ravel(), lon.ravel(), strict=True))
    dots = text(tmp_path / "dots.csv", "lat,lon,z\n" + rows)
    monkeypatch.setattr("pelagos.world.large.survey._MAX_SOUNDING_NODES", 20)
    source(dots, 44.1)
    monkeypatch.setattr("pelagos.world.large.survey._MAX_SOUNDING_NODES", 19)
    with pytest.raises(
        WorldError, match=r"soundings would need a grid of 20 nodes in memory \(at most 19\); grid them"
    ):
        source(dots, 44.1)


def test_a_ground_follows_its_memory_and_no_place_that_is_nowhere(sea):
    stream = Stream(sea.ground)
    stream.follow(np.array([[700.0, -300.0]]))
    memory, there = stream.memory(), stream.view
    stream.follow(np.array([[-1500.0, 900.0]]))
    assert np.abs(stream.view.places - there.places).max() > 500
    stream.recall(memory)
    stream.follow(np.array([[700.0, -300.0]]))
    np.testing.assert_array_equal(stream.view.places, there.places)
    stream.recall(None)
    assert stream.memory() is None
    with pytest.raises(WorldError, match="a large ground cannot follow a place that is not finite"):
        stream.follow(np.array([[0.0, np.nan]]))


def test_cells_of_a_ground_may_have_their_materials():
    field = HeightField(0.0, 0.0, 2.0, np.zeros((3, 4)))
    rows = np.arange(6).reshape(2, 3)
    made = field.geometry(material=rows, label=1, instance=2)
    middle = made.vertices[made.faces].mean(axis=1)[:, :2]
    cell = (middle // 2).astype(int)
    np.testing.assert_array_equal(made.material, rows[cell[:, 0], cell[:, 1]])
    assert made.material.dtype == np.uint32
    assert field.geometry(material=3, label=1, instance=2).material == 3


def test_archives_may_hold_more_than_arrays(tmp_path):
    path = archive(tmp_path / "a.npz", z=Z)
    with ZipFile(path, "a") as file:
        file.writestr("readme.txt", "of 2024")
        header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (9999999999,), }".ljust(117) + b"\n"
        file.writestr("last.npy", b"\x93NUMPY\x01\x00v\x00" + header)
    with pytest.raises(WorldError, match=r"thing .*a\.npz: array 'last' says that it has 80 GB, and has"):
        refuse_large(path, "thing")


def test_a_point_cloud_has_as_many_points_as_it_says_and_a_system_that_can_be_read(tmp_path, monkeypatch):
    (tmp_path / "a.las").write_bytes(b"LASF" + bytes(400))
    monkeypatch.setattr("pelagos.world.bathymetry.read_las._refuse_lying", lambda path: None)
    cloud = SimpleNamespace(points=[1, 2, 3], header=SimpleNamespace(point_count=5))
    monkeypatch.setattr("laspy.read", lambda path: cloud)
    with pytest.raises(WorldError, match=r"a\.las cannot be read; it holds 3 of 5 points: it is cut short"):
        read_survey(str(tmp_path / "a.las"), Reading(None, None, "xyz", None))

    def without_pyproj():
        raise ImportError("pyproj")

    with pytest.raises(WorldError, match="the coordinate system of a LAS file needs the package pyproj; "):
        _crs(SimpleNamespace(parse_crs=without_pyproj))
    assert _crs(SimpleNamespace(parse_crs=lambda: None)) == ("", "", "")


def test_nodes_of_a_survey_stand_where_it_says():
    origin = GeoOrigin(44.1, 13.15)
    nodes, _ = survey_nodes(Grid(LAT, LON, Z, "EPSG:4326", "z"), origin, middle=(0.0, 0.0), size=(30_000.0, 30_000.0))
    lat, lon = origin.to_latlon(*np.moveaxis(_plan(nodes), -1, 0))
    np.testing.assert_allclose(lat, np.broadcast_to(LAT[:, None], (5, 4)), atol=1e-9)
    np.testing.assert_allclose(lon, np.broadcast_to(LON[::-1], (5, 4)), atol=1e-9)


def test_meshes_that_keep_numbers_in_other_files_become_one_file(tmp_path):
    box = shapes.box((1.0, 2.0, 3.0)).moved((0.5, 0.0, -2.0))
    for name, data in trimesh.Trimesh(box.vertices, box.faces).export(file_type="gltf").items():
        (tmp_path / name.replace("model", "buoy")).write_bytes(data)
    name = _beside(tmp_path / "world.npz", "m0", tmp_path / "buoy.gltf")
    assert name == "world_m0.ply"
    found = read_mesh(tmp_path / name)
    whole = read_mesh(tmp_path / "buoy.gltf")
    np.testing.assert_allclose(np.sort(found.vertices, axis=0), np.sort(whole.vertices, axis=0), atol=1e-6)
    assert _beside(tmp_path / "world.npz", "m1", tmp_path / name) == "world_m1.ply"
    assert (tmp_path / "world_m1.ply").read_bytes() == (tmp_path / name).read_bytes()


def test_a_route_runs_from_edge_to_edge_through_deep_water_only():
    def found(depth: float):
        ground = HeightField(-50.0, -40.0, 10.0, np.full((11, 9), -depth))
        return route(Places((-50.0, 50.0), (-40.0, 40.0)), ground, np.random.default_rng(3), 1.5)

    path = found(2.1)
    ends = np.abs(path[[0, -1]]) - [47, 37]
    assert np.abs(ends).min(axis=1) == pytest.approx(0, abs=1e-9)
    assert found(2.0) is None


def shaft(world: World) -> World:
    """A floor of 4 m by 4 m, walls of 40 m about it."""
    meshes = [shapes.box((4.0, 4.0, 0.2)), *(shapes.box((0.2, 4.4, 40.0)).moved((x, 0.0, 20.0)) for x in (-2.1, 2.1))]
    meshes += [shapes.box((4.4, 0.2, 40.0)).moved((0.0, y, 20.0)) for y in (-2.1, 2.1)]
    parts = [Geometry(m.vertices, m.faces, 0, 1, k + 1, None, f"part {k}") for k, m in enumerate(meshes)]
    return replace(world, geometries=tuple(parts), _live={})


def test_a_shaft_is_seen_from_inside_and_nothing_from_nowhere():
    empty = World((), tuple(MATERIALS.values()))
    assert viewpoints(empty) == []
    turned, _ = _seen_from_behind(empty, np.zeros(3), np.eye(3))
    assert not turned.any()
    deep = shaft(empty)
    assert not _mostly_seen(deep, np.array([-3.0, -2.0, 5.0]), 4.4)
    assert _mostly_seen(deep, np.array([0.1, 0.1, 39.0]), 4.4)
    middle = np.array([0.0, 0.0, 0.1])
    view = _whole(deep, middle, 4.4)
    assert view.name == "inside"
    assert (np.abs(view.eye[:2]) < 2).all()
    assert np.hypot(*view.eye[:2]) > 1.8
    assert 0 < view.eye[2] < 40
    assert _mostly_seen(empty, middle, 1.0)


def test_the_way_of_a_mover_is_drawn_with_its_name_where_it_is_on_the_map():
    class Mover:
        name = "ferry"

        def pose(self, t):
            return SimpleNamespace(position=np.array([-30.0 + 0.5 * t, 7.0, 0.0]))

    axes = Figure().add_subplot()
    bounds = np.array([[-20.0, -10.0, -5.0], [20.0, 10.0, 0.0]])
    _draw_paths(axes, SimpleNamespace(bounds=bounds, movers=(Mover(),), paused=()))
    white, red = axes.lines
    np.testing.assert_allclose(white.get_xdata(), 7)
    np.testing.assert_array_equal(red.get_ydata(), white.get_ydata())
    assert red.get_ydata()[0] == -30
    (name,) = axes.texts
    assert name.get_text() == "ferry"
    assert name.xy[0] == 7
    assert -20 < name.xy[1] < -20 + 0.51 * (red.get_ydata()[1] - red.get_ydata()[0]) / 0.5
    _draw_paths(axes, SimpleNamespace(bounds=bounds + 900, movers=(), paused=(Mover(),)))
    assert (len(axes.lines), len(axes.texts)) == (4, 1)


def test_copies_beyond_what_a_picture_holds_are_left_out_evenly(monkeypatch):
    class Copy(PlacedGeometry):
        def __init__(self):
            pass

        faces = np.zeros((10, 3))

    copies, stone = [Copy() for _ in range(9)], object()
    world = SimpleNamespace(geometries=(*copies[:4], stone, *copies[4:]))
    monkeypatch.setattr("pelagos.world.preview._MOST_FACES", 90)
    assert _shown(world) == list(world.geometries)
    monkeypatch.setattr("pelagos.world.preview._MOST_FACES", 89)
    assert _shown(world) == [copies[0], copies[2], stone, copies[4], copies[6], copies[8]]


def test_a_harbour_says_what_found_no_place(monkeypatch):
    monkeypatch.setattr(Places, "find", lambda *_, **__: None)
    site = SimpleNamespace(notes=[])
    harbour = SimpleNamespace(
        rng={k: np.random.default_rng(k) for k in (5, 6)}, c=SimpleNamespace(boulders=2, debris=1), site=site,
        places=Places((-9.0, 9.0), (-9.0, 9.0)), pier=SimpleNamespace(fender_y=3.0),
    )  # fmt: skip
    _Harbour._boulders(harbour, None)
    _Harbour._debris(harbour, None)
    assert site.notes[:2] == [f"boulder {k} of 2 found no free place" for k in (1, 2)]
    assert site.notes[2].endswith(" 1 of 1 found no free place")


def test_a_thing_that_cannot_be_seen_is_looked_at_from_above():
    """In the middle of a box that is larger than all places to look from."""
    box = shapes.box((40.0, 40.0, 40.0))
    shell = Geometry(box.vertices, box.faces, 0, 1, 1, None, "box")
    cube = shapes.box((1.0, 1.0, 1.0))
    small = Geometry(cube.vertices, cube.faces, 0, 1, 2, None, "thing")
    empty = World((), tuple(MATERIALS.values()))
    seen = _close(replace(empty, geometries=(small,), _live={}), "thing", np.zeros(3), 20.0)
    lost = _close(replace(empty, geometries=(shell, small), _live={}), "thing", np.zeros(3), 20.0)
    assert seen.eye[2] == pytest.approx(1.5 * 20 * 0.45)
    np.testing.assert_allclose(lost.eye, [-12, -8, 44])
    assert _encloses(_Object("pipe supports", np.zeros(3), np.ones(3)), np.full(3, -50.0), np.full(3, 50.0))
    assert not _encloses(_Object("wreck", np.zeros(3), np.ones(3)), np.full(3, -50.0), np.full(3, 50.0))


def test_lines_that_find_no_route_are_not_placed(monkeypatch):
    monkeypatch.setattr("pelagos.world.generate.objects.route", lambda *_: None)
    placer = SimpleNamespace(places=None, ground=None)
    assert Placer._lines(placer, ObjectConfig(kind="cable", count=3), 3, np.random.default_rng(1)) == 0


def test_ground_is_coarser_where_too_many_places_ask_for_it(sea, monkeypatch):
    stream = Stream(sea.ground)
    places = np.array([[700.0, -300.0], [-1500.0, 900.0], [1200.0, 1100.0]])
    monkeypatch.setattr("pelagos.world.large.stream._MOST", 2)
    with pytest.raises(WorldError, match="3 places spread over 2700 m x 1400 m need more ground at full"):
        stream.follow(places)
    stream.follow(places[:2])


def test_a_picture_of_too_many_places_shows_the_first(monkeypatch):
    places = [[500, -300], [-800, 700], [1000, 900]]
    insets = [{"centre_m": p, "size_m": [100, 100], "resolution_m": 1.25, "relief_m": 2.0} for p in places]
    asked, peek = [], Stream.peek

    def few(self, places):
        asked.append(places.copy())
        if len(places) > 1:
            raise WorldError("too many")
        return peek(self, places)

    monkeypatch.setattr(Stream, "peek", few)
    assert pictured(large(insets=insets)).ground is None
    assert [len(a) for a in asked] == [3, 1]
    np.testing.assert_array_equal(asked[0][:1], asked[1])
