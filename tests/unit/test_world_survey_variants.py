"""Surveys as the world's data centres and instruments write them: units, marks, names, orders; and what is refused."""

from __future__ import annotations

import gzip

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

from pelagos.errors import WorldError
from pelagos.world.bathymetry.bathymetry import BathymetryConfig
from pelagos.world.bathymetry.survey import rising
from pelagos.world.bathymetry.triangles import gridded
from pelagos.world.bathymetry.values import METRES, known_unit

netcdf = pytest.importorskip("netCDF4")
rasterio = pytest.importorskip("rasterio")
laspy = pytest.importorskip("laspy")
pyproj = pytest.importorskip("pyproj")

FOOT, US_FOOT = 0.3048, 1200 / 3937
GROUND = -30 + 5 * np.sin(np.arange(24) / 5)[:, None] + 3 * np.cos(np.arange(36) / 7)  # rows from the south


def build(path, **keys):
    return BathymetryConfig(path=str(path), **keys).build()


LOWEST, HIGHEST = GROUND.min(), GROUND.max()


def same(world, lowest=LOWEST, highest=HIGHEST, within=0.6):
    """Ground as high and low as the survey's: the default crop cuts its very edge off."""
    z = world.terrain.z
    assert z.min() == pytest.approx(lowest, abs=within)
    assert z.max() == pytest.approx(highest, abs=within)


def write_netcdf(path, z, *, names=("lat", "lon", "elevation"), lat=None, lon=None, axes=({}, {}), **attributes):
    lat = 44 + 0.001 * np.arange(len(z)) if lat is None else lat
    lon = 13 + 0.001 * np.arange(z.shape[1]) if lon is None else lon
    with netcdf.Dataset(path, "w") as data:
        for name, values, said in zip(names, (lat, lon), axes, strict=False):
            data.createDimension(name, len(values))
            axis = data.createVariable(name, "f8", (name,))
            axis.setncatts(said)
            axis[:] = values
        chosen = data.createVariable(names[2], "f8", names[:2])
        chosen.setncatts(attributes)
        chosen[:] = z
    return path


DEGREES = ({"units": "degrees_north"}, {"units": "degrees_east"})
NETCDF = {
    "feet": {"z": GROUND / FOOT, "units": "feet"},
    "fathoms down": {"z": -GROUND / 1.8288, "units": "fathoms", "positive": "down"},
    "kilometres": {"z": GROUND / 1000, "units": "km"},
    "gmt": {"z": GROUND, "names": ("y", "x", "z"), "axes": DEGREES},
    "standard names": {"z": GROUND, "names": ("p", "q", "z"),
                           "axes": ({"standard_name": "latitude"}, {"standard_name": "longitude"})},
    "a depth by its standard name": {"z": -GROUND, "names": ("lat", "lon", "Band1"),
                                         "standard_name": "sea_floor_depth_below_geoid"},
    "a depth by its long name": {"z": -GROUND, "names": ("lat", "lon", "m"), "long_name": "Water depth"},
    "east of Greenwich": {"z": GROUND, "lon": 359.98 + 0.001 * np.arange(36)},
    "marks": {"z": np.where(np.arange(36) == 7, -99999.0, GROUND)},
    "nines": {"z": np.where(np.arange(36) == 7, -9999.0, GROUND)},
}  # fmt: skip


@pytest.mark.parametrize("case", NETCDF)
def test_netcdf(case, tmp_path):
    same(build(write_netcdf(tmp_path / "a.nc", **NETCDF[case])))


def test_axes_without_known_names_need_a_coordinate_system(tmp_path):
    path = write_netcdf(tmp_path / "a.nc", GROUND, names=("LINES", "COLUMNS", "DEPTH"))
    with pytest.raises(WorldError, match="look like longitude and latitude: crs: EPSG:4326"):
        build(path)
    same(build(path, crs="EPSG:4326"))


def test_nodes_of_a_triangulated_model_are_soundings(tmp_path):
    at = np.random.default_rng(0).uniform(0, 0.03, (900, 2))
    with netcdf.Dataset(tmp_path / "model.nc", "w") as data:
        data.createDimension("node", 900)
        for name, values in (("lat", 44 + at[:, 0]), ("lon", 13 + at[:, 1]), ("h", 20 + 100 * at[:, 0])):
            data.createVariable(name, "f8", ("node",))[:] = values
    world = build(tmp_path / "model.nc")
    same(world, -23.0, -20.0, 0.2)
    assert any("900 soundings" in n for n in world.notes)


@pytest.mark.parametrize("order", [("y", "x"), ("x", "y"), ("t", "x", "y")])
def test_a_curved_grid_is_read_whatever_the_order_of_its_dimensions(order, tmp_path):
    """Latitude and longitude on rows and columns that are turned by 20 degrees and bent."""
    down, across = np.meshgrid(np.linspace(-0.02, 0.05, 41), np.linspace(-0.02, 0.05, 57), indexing="ij")
    lat, lon = 44 + 0.94 * down - 0.34 * across + across**2, 13 + 0.34 * down + 0.94 * across
    z = {"y": 0, "x": 1}
    depth = (20 + 100 * (lat - 44)).transpose([z[d] for d in order if d in z])
    with netcdf.Dataset(tmp_path / "model.nc", "w") as data:
        for name, size in (("y", 41), ("x", 57), ("t", 1)):
            data.createDimension(name, size)
        for name, values in (("lat", lat), ("lon", lon)):
            data.createVariable(name, "f8", ("y", "x"))[:] = values
        data.createVariable("h", "f8", order)[:] = depth[None] if "t" in order else depth
    world = build(tmp_path / "model.nc", centre_deg=(44.015, 13.015), size_m=(800.0, 800.0))
    x, y = np.random.default_rng(1).uniform(-350, 350, (2, 50))
    expected = -(20 + 100 * (np.asarray(world.origin.to_latlon(x, y))[0] - 44))
    assert np.ptp(expected) > 0.5
    np.testing.assert_allclose(world.height(x, y), expected, atol=0.02)


def test_a_grid_around_the_earth_has_no_seam(tmp_path):
    lat, lon = np.arange(-20.0, -13.9, 0.5), np.arange(-180.0, 180.0, 0.5)
    z = -3000 + 10 * lat[:, None] + 100 * np.cos(np.radians(lon))
    path = write_netcdf(tmp_path / "a.nc", z, lat=lat, lon=lon)
    world = build(path, centre_deg=(-17.0, 180.0), size_m=(200e3, 200e3), resolution_m=10e3)
    assert float(world.height(0, 0)) == pytest.approx(-3000 - 170 - 100, abs=0.5)
    assert any("no holes" in n for n in world.notes)
    with pytest.raises(WorldError, match="make no flat world"):
        build(path)


def write_tif(path, z, *, crs="EPSG:32633", east=400e3, north=4900e3, step=10.0, unit=None, scale=None, bands=1):
    transform = rasterio.Affine(step, 0.0, east, 0.0, -step, north)
    with rasterio.open(
        path, "w", driver="GTiff", height=len(z), width=z.shape[1], count=bands, dtype=z.dtype, crs=crs,
        transform=transform,
    ) as raster:  # fmt: skip
        for band in range(bands):
            raster.write(z[::-1], band + 1)
        if unit:
            raster.units = (unit,)
        if scale:
            raster.scales, raster.offsets = (scale[0],), (scale[1],)
    return path


TIF = {
    "a grid in feet": {"z": GROUND, "crs": "EPSG:2230", "east": 6.2e6, "north": 1.85e6, "step": 10 / US_FOOT},
    "heights in feet": {"z": GROUND / FOOT, "unit": "ft"},
    "heights in survey feet": {"z": GROUND / US_FOOT, "unit": "US survey foot"},
    "a vertical datum in survey feet": {"z": GROUND / US_FOOT, "crs": "EPSG:32618+6360"},
    "degrees of another datum": {"z": GROUND, "crs": "EPSG:4269", "east": -118.0, "north": 33.0, "step": 1e-4},
    "scaled integers": {"z": ((GROUND + 100) * 100).astype(np.int32), "scale": (0.01, -100.0)},
    "no-data that is not declared": {"z": np.where(np.arange(36) == 7, -3.4e38, GROUND)},
}  # fmt: skip


@pytest.mark.parametrize("case", TIF)
def test_rasters(case, tmp_path):
    world = build(write_tif(tmp_path / "a.tif", **TIF[case]))
    same(world)
    size = np.ptp(world.bounds[:, :2], axis=0)
    assert size == pytest.approx([230.0, 350.0], rel=0.1)


def test_a_raster_larger_than_memory_is_thinned(tmp_path, monkeypatch):
    monkeypatch.setattr("pelagos.world.bathymetry.axes._MOST", 200)
    path = write_tif(tmp_path / "a.tif", GROUND)
    world = build(path)
    assert any("one node in 3 was read" in n for n in world.notes)
    same(world, within=1.5)


def test_the_smallest_grid(tmp_path):
    world = build(write_tif(tmp_path / "a.tif", GROUND[:2, :2]))
    same(world, GROUND[:2, :2].min(), GROUND[:2, :2].max(), 0.3)


PLACES = np.random.default_rng(1).uniform(0, 200, (300, 2))
EAST, NORTH, HEIGHT = 400e3 + PLACES[:, 0], 4900e3 + PLACES[:, 1], -30 + PLACES[:, 0] / 20


def rows(form, header="", columns=(EAST, NORTH, HEIGHT)):
    return header + "\n".join(form.format(*row) for row in zip(*columns, strict=True)) + "\n"


TEXT = {
    "decimal commas": rows("{:.2f};{:.2f};{:.3f}", "E;N;Z\n").replace(".", ","),
    "decimal commas and blanks": rows("{:.2f} {:.2f} {:.3f}").replace(".", ","),
    "units in the header": rows("{:.2f}, {:.2f}, {:.3f}", "Easting (m), Northing (m), Depth (m)\n",
                                (EAST, NORTH, -HEIGHT)),
    "another order": rows("{:.3f}\t{:.2f}\t{:.2f}", "depth [m]\ty\tx\n", (-HEIGHT, NORTH, EAST)),
    "feet by the header": rows("{:.2f},{:.2f},{:.3f}", "x,y,depth_ft\n", (EAST, NORTH, -HEIGHT / FOOT)),
    "words beside numbers": rows("line {0:.0f},{0:.2f},{1:.2f},{2:.3f},ok", "name,x,y,z,flag\n"),
    "quotes": rows('"{:.2f}","{:.2f}","{:.3f}"', '"x","y","z"\n'),
    "comments and blank lines": "# made by a tool\n\n# x y z\n" + rows("{:.2f} {:.2f} {:.3f}") + "\n\n# end\n",
    "blank lines amid soundings": rows("{:.2f} {:.2f} {:.3f}").replace("\n", "\n\n", 40).replace("\n\n", "\n \t \n", 9),
    "empty rows of a spreadsheet": rows("{:.2f},{:.2f},{:.3f}", "x,y,z\n").replace("\n", "\n,,\n", 7),
    "a cell left empty": rows("{:.2f},{:.2f},{:.3f}", "x,y,z\n") + "400001,4900001,\n",
    "a mark for no value": rows("{:.2f},{:.2f},{:.3f}", "x,y,z\n") + "400001,4900001,-9999\n",
}  # fmt: skip


@pytest.mark.parametrize("case", TEXT)
def test_text(case, tmp_path):
    (tmp_path / "a.csv").write_text(TEXT[case])
    world = build(tmp_path / "a.csv", crs="EPSG:32633", resolution_m=5.0)
    same(world, -30.0, -20.0, 0.3)


def test_the_scenario_may_say_the_unit(tmp_path):
    (tmp_path / "a.xyz").write_text(rows("{:.2f} {:.2f} {:.3f}", columns=(EAST, NORTH, HEIGHT / US_FOOT)))
    world = build(tmp_path / "a.xyz", crs="EPSG:32633", resolution_m=5.0, unit="us_ft")
    same(world, -30.0, -20.0, 0.3)
    assert any("us_ft were turned into metres" in n for n in world.notes)


def test_units_by_any_name():
    """1 fathom = 6 ft; the US survey foot is 2 ppm longer than the international one."""
    assert METRES["fathom"] == pytest.approx(6 * METRES["ft"], rel=1e-12)
    assert METRES["us_ft"] / METRES["ft"] - 1 == pytest.approx(2e-6, rel=1e-3)
    assert [known_unit(u) for u in ("Metres", "US survey foot", "feet", "us_survey_foot", "furlong")] == [
        "m", "us_ft", "ft", "us_ft", None
    ]  # fmt: skip


@pytest.mark.parametrize("vertical", ["", "+6360"])
def test_point_clouds_in_feet(tmp_path, vertical):
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = [0.001] * 3, [6.2e6, 1.85e6, 0]
    header.add_crs(pyproj.CRS.from_user_input("EPSG:2230" + vertical))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y = 6.2e6 + PLACES[:, 0] / US_FOOT, 1.85e6 + PLACES[:, 1] / US_FOOT
    cloud.z = HEIGHT / US_FOOT
    cloud.write(tmp_path / "a.las")
    same(build(tmp_path / "a.las", resolution_m=5.0), -30.0, -20.0, 0.3)


def test_a_file_with_another_formats_name_is_read_as_what_it_is(tmp_path):
    write_tif(tmp_path / "a.tif", GROUND).rename(tmp_path / "a.nc")
    world = build(tmp_path / "a.nc")
    same(world)
    assert any("begins as TIFF" in n for n in world.notes)


def test_surfer_grids(tmp_path):
    head = f"DSAA\n36 24\n400000 400350\n4900000 4900230\n{GROUND.min()} {GROUND.max()}\n"
    (tmp_path / "a.grd").write_text(head + "\n".join(" ".join(f"{v:.3f}" for v in row) for row in GROUND))
    same(build(tmp_path / "a.grd", crs="EPSG:32633"))


def _unreferenced(folder):
    options = {"driver": "GTiff", "height": 9, "width": 9, "count": 1, "dtype": "float32"}
    with pytest.warns(rasterio.errors.NotGeoreferencedWarning):
        rasterio.open(folder / "a.tif", "w", **options).close()
    return folder / "a.tif"


def _corrupt(folder):
    packed = bytearray(gzip.compress(b"1 2 -3\n3 2 -3\n" * 3000 + PLACES.tobytes()))
    packed[300:320] = b"x" * 20
    (folder / "a.csv.gz").write_bytes(bytes(packed))
    return folder / "a.csv.gz"


def _text(folder, content):
    (folder / "a.xyz").write_text(content)
    return folder / "a.xyz"


REFUSED = {
    "a picture": (lambda t: write_tif(t / "a.tif", np.full((9, 9), 90, np.uint8), bands=3), {}, "is a picture"),
    "one pixel": (lambda t: write_tif(t / "a.tif", GROUND[:1, :1]), {}, "fewer than 2 values"),
    "no place on Earth": (_unreferenced, {"crs": "EPSG:32633"}, "does not say where on Earth"),
    "no such band": (lambda t: write_tif(t / "a.tif", GROUND), {"variable": "7"}, "it has 1 bands"),
    "metres for degrees": (lambda t: write_tif(t / "a.tif", GROUND), {"crs": "EPSG:4326"}, "if these are metres"),
    "positive depths": (lambda t: write_tif(t / "a.tif", -GROUND), {}, "say sign: down"),
    "millimetres": (lambda t: write_tif(t / "a.tif", GROUND * 1000), {}, "cannot be heights on Earth; say their unit"),
    "damaged gzip": (_corrupt, {"crs": "EPSG:32633"}, "damaged or cut short"),
    "one place": (lambda t: _text(t, "400000 4900000 -3\n" * 9), {"crs": "EPSG:32633"}, "covers no area"),
    "a damaged row behind empty ones": (
        lambda t: _text(t, "1,2,-3\n\n,,\n4,5,-6\n7,x,-9\n"), {"crs": "EPSG:32633"}, "line 5: '7,x,-9' holds no x"),
    "two columns": (lambda t: _text(t, "400000 4900000\n" * 9), {"crs": "EPSG:32633"}, "has 2 columns"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused(case, tmp_path):
    make, keys, message = REFUSED[case]
    with pytest.raises(WorldError, match=message):
        build(make(tmp_path), **keys)


@pytest.mark.parametrize(("count", "nodes"), [(3, 40), (40, 300), (4000, 50)])
def test_triangles_fill_the_nodes_that_lie_in_them(count, nodes, monkeypatch):
    """The same as SciPy's search for the triangle of every node; boxes of nodes larger than a portion are split."""
    monkeypatch.setattr("pelagos.world.bathymetry.triangles._AT_ONCE", 1000)
    rng = np.random.default_rng(count)
    points = rng.normal(0, 100, (count, 2))
    values = np.sin(points[:, 0] / 20) * points[:, 1]
    x, y = np.linspace(-200, 200, nodes), np.linspace(-150, 220, nodes + 7)
    found = gridded(points, values, x, y)
    wanted = LinearNDInterpolator(points, values)(*np.meshgrid(x, y, indexing="ij"))
    np.testing.assert_allclose(found, wanted, atol=1e-9)
    assert np.isfinite(found).any()


def test_points_on_a_line_have_no_triangles():
    line = np.arange(9.0)[:, None] * [1.0, 2.0]
    assert np.isnan(gridded(line, line[:, 0], np.arange(5.0), np.arange(5.0))).all()


def test_dense_soundings_are_averaged(tmp_path, monkeypatch):
    """A plane stays a plane: the mean of soundings stands at the mean of their places."""
    monkeypatch.setattr("pelagos.world.bathymetry.regrid._MANY", 100)
    (tmp_path / "a.xyz").write_text(rows("{:.4f} {:.4f} {:.5f}"))
    world = build(tmp_path / "a.xyz", crs="EPSG:32633", resolution_m=20.0)
    note = next(n for n in world.notes if "soundings are dense" in n)
    assert int(note.split()[-3]) < 200
    x, y = np.meshgrid([-60.0, 0.0, 40.0], [-50.0, 0.0, 50.0])
    east, _ = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:32633").transform(*world.origin.to_latlon(x, y))
    np.testing.assert_allclose(world.height(x, y), -30 + (east - 400e3) / 20, atol=0.02)


@pytest.mark.parametrize(("flip_u", "flip_v"), [(False, False), (True, False), (False, True), (True, True)])
def test_falling_axes_turn_with_their_values(flip_u, flip_v):
    u, v, z = np.array([1.0, 2.0, 4.0]), np.array([-3.0, 5.0]), np.arange(6.0).reshape(3, 2) ** 2
    given = (u[::-1] if flip_u else u, v[::-1] if flip_v else v, z[:: -1 if flip_u else 1, :: -1 if flip_v else 1])
    for found, expected in zip(rising(*given), (u, v, z), strict=True):
        np.testing.assert_array_equal(found, expected)
