"""Surveys: every format, every convention, and one clear error for everything that can be wrong."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.bathymetry.bathymetry import BathymetryConfig
from pelagos.world.bathymetry.regrid import fill

netcdf = pytest.importorskip("netCDF4")
rasterio = pytest.importorskip("rasterio")

REAL = Path(__file__).resolve().parents[3] / "shared" / "data" / "bathymetry"
LAT, LON = np.linspace(44.0, 44.2, 21), np.linspace(13.0, 13.3, 31)


def bed(lat, lon):
    """A bed that is a plane in latitude and longitude, so that bilinear interpolation is exact: -40 .. -10 m."""
    return -25 + 50 * (lat - 44.1) + 40 * (lon - 13.15)


def write_netcdf(path, z=None, *, name="elevation", lat=LAT, lon=LON, flip=False, transpose=False, attributes=None):
    z = bed(lat[:, None], lon[None, :]) if z is None else z
    with netcdf.Dataset(path, "w") as data:
        data.createDimension("lat", len(lat))
        data.createDimension("lon", len(lon))
        data.createVariable("lat", "f8", ("lat",))[:] = lat[::-1] if flip else lat
        data.createVariable("lon", "f8", ("lon",))[:] = lon
        z = z[::-1] if flip else z
        variable = data.createVariable(name, "f8", ("lon", "lat") if transpose else ("lat", "lon"), fill_value=-9999.0)
        variable[:] = z.T if transpose else z
        variable.setncatts(attributes or {})
    return path


def build(path, **keys):
    return BathymetryConfig(path=str(path), **keys).build()


CROP = {"centre_deg": (44.1, 13.15), "size_m": (2000.0, 1000.0), "resolution_m": 50.0}


def worst(world):
    """Greatest difference from the plane at the world's own nodes [m]."""
    t = world.terrain
    x, y = np.meshgrid(t.x, t.y, indexing="ij")
    lat, lon = world.origin.to_latlon(x, y)
    return np.abs(t.z - bed(lat, lon)).max()


@pytest.mark.parametrize("variant", [{}, {"flip": True}, {"transpose": True}, {"flip": True, "transpose": True}])
def test_netcdf_in_any_order(tmp_path, variant):
    world = build(write_netcdf(tmp_path / "a.nc", **variant), **CROP)
    assert world.terrain.z.shape == (41, 21)
    assert world.bounds[:, :2].tolist() == [[-1000, -500], [1000, 500]]
    assert worst(world) < 1e-9
    assert world.origin == GeoOrigin(44.1, 13.15)
    assert any("no holes" in n for n in world.notes)


def test_a_fine_grid_is_read_as_far_as_the_crop_goes(tmp_path):
    """11 m of latitude and 8 m of longitude from node to node: the edge lies a hundred nodes from the middle."""
    lat, lon = np.linspace(44.07, 44.13, 601), np.linspace(13.12, 13.18, 601)
    assert worst(build(write_netcdf(tmp_path / "a.nc", lat=lat, lon=lon), **CROP)) < 1e-9


def test_source_nodes_are_reproduced_to_float_precision(tmp_path):
    """A grid whose nodes fall on survey nodes carries the survey's own numbers."""
    z = np.random.default_rng(0).normal(-30, 5, (21, 31)).astype(np.float32).astype(np.float64)
    path = write_netcdf(tmp_path / "a.nc", z)
    for i, j in [(10, 15), (7, 20), (15, 9)]:
        world = build(path, centre_deg=(LAT[i], LON[j]), size_m=(400.0, 400.0), resolution_m=100.0)
        assert float(world.height(0, 0)) == pytest.approx(z[i, j], abs=1e-6)
        assert world.cast((0, 0, 0), (0, 0, -1)).position[0, 2] == pytest.approx(z[i, j], abs=2e-5)


def test_depths_that_count_down(tmp_path):
    z = bed(LAT[:, None], LON[None, :])
    assert worst(build(write_netcdf(tmp_path / "a.nc", -z, name="depth"), **CROP)) < 1e-9
    assert worst(build(write_netcdf(tmp_path / "b.nc", z, name="depth"), **CROP)) < 1e-9
    assert worst(build(write_netcdf(tmp_path / "c.nc", -z, attributes={"positive": "down"}), **CROP)) < 1e-9
    assert worst(build(write_netcdf(tmp_path / "d.nc", -z), sign="down", **CROP)) < 1e-9
    shifted = build(write_netcdf(tmp_path / "e.nc", z), datum_offset_m=0.25, **CROP)
    assert float(shifted.height(0, 0)) == pytest.approx(bed(44.1, 13.15) + 0.25)


def test_geotiff_and_its_projection(tmp_path):
    """A plane in UTM metres, read through pyproj: its slope in the world differs only by scale and convergence."""
    from rasterio import Affine

    z = np.broadcast_to(-20 - 0.001 * np.arange(400)[None, :], (300, 400)).astype(np.float32)
    path = tmp_path / "a.tif"
    profile = {"driver": "GTiff", "width": 400, "height": 300, "count": 1, "dtype": "float32", "crs": "EPSG:32633"}
    with rasterio.open(path, "w", transform=Affine(10, 0, 350000, 0, -10, 4890000), **profile) as raster:
        raster.write(z, 1)
    import pyproj

    lon, lat = pyproj.Transformer.from_crs(32633, 4326, always_xy=True).transform(350000 + 2005, 4890000 - 1505)
    world = build(path, centre_deg=(lat, lon), size_m=(500, 500), resolution_m=10.0)
    assert float(world.height(0, 0)) == pytest.approx(float(z[150, 200]), abs=1e-4)
    slope = float(world.height(0, -200) - world.height(0, 200)) / 400
    assert slope == pytest.approx(-0.0001, rel=0.01)


def test_esri_ascii_with_a_hole_and_the_crs_from_the_scenario(tmp_path):
    rows = np.full((60, 60), -12.0)
    rows[20:30, 20:30] = -9999
    header = "ncols 60\nnrows 60\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\nNODATA_value -9999\n"
    path = tmp_path / "a.asc"
    path.write_text(header + "\n".join(" ".join(f"{v:g}" for v in row) for row in rows))
    with pytest.raises(WorldError, match="does not say its coordinate system"):
        build(path)
    world = build(path, crs="EPSG:32633", resolution_m=10.0)
    assert np.allclose(world.terrain.z, -12.0)
    note = next(n for n in world.notes if "filled" in n)
    assert int(note.split()[0]) > 60


def test_soundings_with_and_without_header(tmp_path):
    rng = np.random.default_rng(0)
    lat, lon = rng.uniform(44.08, 44.12, 4000), rng.uniform(13.12, 13.18, 4000)
    rows = [f"{a:.8f},{b:.8f},{bed(b, a):.6f}" for a, b in zip(lon, lat, strict=True)]
    plain, named = tmp_path / "a.xyz", tmp_path / "b.csv.gz"
    plain.write_text("\n".join(rows))
    with gzip.open(named, "wt") as file:
        file.write("lon;lat;elevation\n" + "\n".join(r.replace(",", ";") for r in rows))
    for path, crs in ((plain, "EPSG:4326"), (named, None)):
        world = build(path, crs=crs, centre_deg=(44.1, 13.15), size_m=(1000, 1000), resolution_m=25.0)
        assert worst(world) < 1e-3


def test_numpy_archive_with_longitudes_to_360(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, latitude=LAT, longitude=LON + 347 - 13, topo=bed(LAT[:, None], LON[None, :]))
    world = build(path, centre_deg=(44.1, 347.15 - 360), size_m=(1000, 1000), resolution_m=50.0)
    assert float(world.height(0, 0)) == pytest.approx(bed(44.1, 13.15))


def test_latitude_and_longitude_box(tmp_path):
    path = write_netcdf(tmp_path / "a.nc")
    world = build(path, latitude_range_deg=(44.05, 44.15), longitude_range_deg=(13.1, 13.2), resolution_m=100.0)
    south = world.origin.to_xy(44.05, 13.15)[0]
    assert world.bounds[0, 0] == pytest.approx(float(south), abs=100)
    assert worst(world) < 1e-9


def test_land_and_sea(tmp_path):
    z = bed(LAT[:, None], LON[None, :]) + 25
    world = build(write_netcdf(tmp_path / "a.nc", z), **CROP)
    assert (world.terrain.z > 0).any()
    assert any("land" in n for n in world.notes)


def test_holes_are_filled_from_their_rims_and_counted():
    x = np.arange(30.0)
    plane = 0.5 * x[:, None] - 0.25 * x
    torn = plane.copy()
    torn[10:15, 12:20] = np.nan
    filled, count = fill(torn)
    assert count == 40
    assert np.allclose(filled, plane)


def test_a_margin_has_the_heights_of_the_nearest_nodes():
    """Beside a survey of slanted and stepped edges: any of those that no other is nearer than, by all distances."""
    i, j = (v.ravel() for v in np.meshgrid(np.arange(34), np.arange(26), indexing="ij"))
    height = -30.0 + np.random.default_rng(5).permutation(i.size).reshape(34, 26)
    surveyed = (np.hypot(i - 15.3, 1.7 * (j - 11.8)) < 9.0).reshape(34, 26)
    filled, count = fill(np.where(surveyed, height, np.nan))
    assert count == (~surveyed).sum()
    known = surveyed.ravel()
    far = np.hypot(i[:, None] - i[known], j[:, None] - j[known])  # (nodes, surveyed)
    source = {h: k for k, h in enumerate(height.ravel()[known])}
    outside = [k for k in np.flatnonzero(~known) if filled.flat[k] in source]
    assert len(outside) > 0.9 * count  # the rest lies in the hull, between rims
    for k in outside:
        assert far[k, source[filled.flat[k]]] == far[k].min()


def test_holes_without_a_rim_cannot_be_filled():
    with pytest.raises(WorldError, match="no value anywhere in the crop"):
        fill(np.full((7, 9), np.nan))


def text(folder, content):
    (folder / "t.xyz").write_text(content)
    return folder / "t.xyz"


def cut(path, to):
    path.write_bytes(path.read_bytes()[:to])
    return path


PLACE = {"size_m": (100.0, 100.0)}
BAD = {
    "missing": (lambda t: t / "elevatoin.nc", {}, r"does not exist \(did you mean 'elevation.nc'"),
    "empty": (lambda t: (t / "e.nc").write_bytes(b"") or t / "e.nc", {}, "is empty"),
    "all nan": (lambda t: write_netcdf(t / "n.nc", np.full((21, 31), np.nan)), {}, "all 651 values of 'elevation'"),
    "truncated netcdf": (lambda t: cut(write_netcdf(t / "t.nc"), 3000), {}, "damaged or cut short"),
    "not netcdf": (lambda t: (t / "x.nc").write_text("hello") and t / "x.nc", {}, "cannot be read"),
    "unknown format": (lambda t: (t / "x.mp3").write_text("hello") and t / "x.mp3", {}, r"'\.mp3' is not read"),
    "outside": (lambda t: t / "elevation.nc", {"centre_deg": (50.0, 13.0)} | PLACE,
                r"outside the data, which cover latitude 44\.00000 \.\. 44\.20000"),
    "exchanged": (lambda t: t / "elevation.nc", {"centre_deg": (13.1, 44.1)} | PLACE, "look exchanged"),
    "no such latitude": (lambda t: t / "elevation.nc", {"centre_deg": (123.0, 48.0)} | PLACE, "not on Earth"),
    "variable": (lambda t: t / "elevation.nc", {"variable": "elevatoin"}, "did you mean 'elevation'"),
    "exchanged axes": (lambda t: write_netcdf(t / "s.nc", np.zeros((31, 21)), lat=LON * 9, lon=LAT), {}, "no latitude"),
    "dry": (lambda t: write_netcdf(t / "l.nc", np.full((21, 31), 12.0)), {}, "wholly above the sea"),
    "crs": (lambda t: t / "elevation.nc", {"crs": "EPSG:nonsense"}, "not a coordinate system"),
    "too fine": (lambda t: t / "elevation.nc", {"resolution_m": 0.5}, "use resolution_m"),
    "no sample": (lambda t: "matplotlib:nothing.npz", {}, "ships no sample"),
    "torn text": (lambda t: text(t, "1 2 3\n1 2 3\n1 2\n"), {"crs": "EPSG:32633"}, "line 3"),
    "words": (lambda t: text(t, "so long\n"), {"crs": "EPSG:32633"}, "no row of numbers"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_one_clear_error(case, tmp_path):
    make, keys, message = BAD[case]
    write_netcdf(tmp_path / "elevation.nc")
    with pytest.raises(WorldError, match=message):
        build(make(tmp_path), **keys)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"centre_deg": (44, 13)}, "go together"),
        ({"latitude_range_deg": (44.2, 44.0), "longitude_range_deg": (13, 14)}, "must rise"),
        (
            {"centre_deg": (44, 13), "size_m": (1, 1), "latitude_range_deg": (44, 45), "longitude_range_deg": (1, 2)},
            "once",
        ),
        ({"resolution_m": -1}, "greater than 0"),
        ({"resolution": 5}, "Extra inputs"),
    ],
)
def test_contradictions_are_refused_before_any_file_is_opened(keys, message):
    with pytest.raises(ValidationError, match=message):
        BathymetryConfig(path="a.nc", **keys)


def test_missing_pyproj_is_named(tmp_path, monkeypatch):
    import builtins

    from pelagos.world.bathymetry import projection

    real = builtins.__import__

    def without(name, *rest, **keys):
        if name == "pyproj":
            raise ImportError(name)
        return real(name, *rest, **keys)

    projection._transformer.cache_clear()
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(WorldError, match=r"pip install 'pelagos\[bathymetry\]'"):
        projection.to_latlon("EPSG:3004", np.zeros(1), np.zeros(1))


def test_the_salish_sea_that_ships_inside_matplotlib():
    world = build("matplotlib:topobathy.npz", centre_deg=(48.8, -123.0), size_m=(10000, 10000), resolution_m=100.0)
    assert -400 < world.bounds[0, 2] < -100
    assert world.terrain.z.shape == (101, 101)


@pytest.mark.skipif(not REAL.is_dir(), reason="the real surveys are not on this machine")
def test_real_surveys():
    survey = REAL / "north_adriatic_1_128deg.nc"
    adriatic = build(survey, centre_deg=(44.9, 13.2), size_m=(4000, 4000), resolution_m=20.0)
    assert -45 < adriatic.bounds[0, 2] < -35
    with netcdf.Dataset(survey) as data:
        i, j = 150, 130
        lat, lon, z = (float(data[n][k]) for n, k in (("latitude", i), ("longitude", j), ("depth", (i, j))))
    node = build(survey, centre_deg=(lat, lon), size_m=(100, 100), resolution_m=10.0)
    assert float(node.height(0, 0)) == pytest.approx(z, abs=1e-5)
    lagoon = REAL / "venice_lagoon_corila2003_soundings.csv.gz"
    venice = build(lagoon, crs="EPSG:3004", centre_deg=(45.335, 12.33), size_m=(1000, 1000), resolution_m=5.0)
    assert -50 < venice.bounds[0, 2] < -15


def test_soundings_are_averaged_about_the_crop_wherever_the_origin_is(tmp_path, monkeypatch):
    """The origin 3 km north and 5 km east of the crop's middle; a grid of 60 m about soundings each 110 m."""
    lat, lon = np.meshgrid(np.linspace(44.06, 44.14, 81), np.linspace(13.08, 13.22, 101), indexing="ij")
    rows = "".join(
        f"{a:.6f},{b:.6f},{z:.4f}\n" for a, b, z in zip(*(v.ravel() for v in (lat, lon, bed(lat, lon))), strict=True)
    )
    (tmp_path / "s.csv").write_text("lat,lon,z\n" + rows)
    monkeypatch.setattr("pelagos.world.bathymetry.regrid._MANY", 100)
    world = build(tmp_path / "s.csv", **CROP | {"latitude_deg": 44.127, "longitude_deg": 13.2125, "resolution_m": 60.0})
    middle = world.origin.to_xy(*CROP["centre_deg"])
    assert np.hypot(*middle) > 5000
    np.testing.assert_allclose(world.bounds[:, :2].mean(axis=0), middle, atol=60)
    assert worst(world) < 0.02
