"""Surveys beyond the square grid: point clouds, BAG, a survey's own nodes, invented detail that says so."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from pelagos.errors import WorldError
from pelagos.world.bathymetry.bathymetry import BathymetryConfig
from pelagos.world.bathymetry.detail import Spectrum, spectrum
from pelagos.world.bathymetry.nodes import SurveyNodes
from pelagos.world.export import load, save
from pelagos.world.generate.relief import fractal

rasterio = pytest.importorskip("rasterio")
pyproj = pytest.importorskip("pyproj")

UTM33 = pyproj.Transformer.from_crs(32633, 4326, always_xy=True)
EAST, NORTH, STEP = 350_000.0, 4_890_000.0, 10.0


def build(path, **keys):
    return BathymetryConfig(path=str(path), **keys).build()


def relief(nodes=(80, 96), slope=3.2, seed=4):
    rng = np.random.default_rng(seed)
    field = fractal(nodes, STEP, rng, slope=slope, longest=400.0, shortest=2 * STEP)
    return np.float32(-30 + 3 * field).astype(np.float64)


def write_raster(path, z, driver="GTiff"):
    """Row 0 is the northernmost."""
    bands = 2 if driver == "BAG" else 1
    profile = {"driver": driver, "width": z.shape[1], "height": z.shape[0], "count": bands, "dtype": "float32"}
    place = rasterio.Affine(STEP, 0, EAST, 0, -STEP, NORTH + STEP * z.shape[0])
    with rasterio.open(path, "w", crs="EPSG:32633", transform=place, **profile) as raster:
        raster.write(z[::-1].astype(np.float32), 1)
        if bands == 2:
            raster.write(np.full(z.shape, 0.3, np.float32), 2)
    return path


def latlon(i, j):
    lon, lat = UTM33.transform(EAST + STEP * (np.asarray(j) + 0.5), NORTH + STEP * (np.asarray(i) + 0.5))
    return lat, lon


def write_las(path, x, y, z, *, classes=None, crs="EPSG:32633"):
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = [1e-3] * 3, [EAST, NORTH, 0.0]
    if crs:
        header.add_crs(pyproj.CRS(crs))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = x, y, z
    if classes is not None:
        cloud.classification = classes
    cloud.write(path)
    return path


def cloud(count=4000, seed=1):
    rng = np.random.default_rng(seed)
    x, y = EAST + rng.uniform(0, 400, count), NORTH + rng.uniform(0, 300, count)
    return x, y, -20 + 0.01 * (x - EAST) - 0.02 * (y - NORTH)


MIDDLE = {
    "centre_deg": tuple(float(a) for a in UTM33.transform(EAST + 200, NORTH + 150)[::-1]),
    "size_m": (160.0, 160.0),
}


@pytest.mark.parametrize("name", ["a.las", "a.laz"])
def test_point_clouds(tmp_path, name):
    """A plane in LAS with 1 mm of quantisation; the crop stands 150 m and 200 m into it."""
    if name.endswith("laz"):
        pytest.importorskip("lazrs")
    world = build(write_las(tmp_path / name, *cloud()), resolution_m=10.0, **MIDDLE)
    assert float(world.height(0, 0)) == pytest.approx(-20 + 2.0 - 3.0, abs=2e-3)
    assert any("4000 soundings" in n for n in world.notes)


def test_noise_and_water_surface_are_left_out(tmp_path):
    x, y, z = cloud()
    classes = np.full(len(z), 2, dtype=np.uint8)
    z[::10], classes[::10] = 0.0, 9
    z[1::50], classes[1::50] = -500.0, 7
    world = build(write_las(tmp_path / "a.las", x, y, z, classes=classes), resolution_m=10.0, **MIDDLE)
    assert float(world.height(0, 0)) == pytest.approx(-21.0, abs=0.01)
    assert world.terrain.z.max() < -10
    assert world.terrain.z.min() > -40


def test_broken_and_unplaced_point_clouds_are_refused(tmp_path):
    path = write_las(tmp_path / "a.las", *cloud())
    (tmp_path / "cut.las").write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    (tmp_path / "text.las").write_text("x y z\n1 2 3\n")
    with pytest.raises(WorldError, match="cannot be read"):
        build(tmp_path / "cut.las", resolution_m=10.0)
    with pytest.raises(WorldError, match="cannot be read"):
        build(tmp_path / "text.las", resolution_m=10.0)
    with pytest.raises(WorldError, match="does not say its coordinate system"):
        build(write_las(tmp_path / "b.las", *cloud(), crs=None), resolution_m=10.0)


def test_bag_is_read_as_gdal_reads_it(tmp_path):
    if "BAG" not in rasterio.drivers.raster_driver_extensions().values() and not _gdal_has("BAG"):
        pytest.skip("this GDAL is built without BAG")
    z = relief()
    lat, lon = latlon(40, 50)
    keys = {"centre_deg": (float(lat), float(lon)), "size_m": (200.0, 200.0), "resolution_m": 10.0}
    bag = build(write_raster(tmp_path / "a.bag", z, "BAG"), **keys)
    tif = build(write_raster(tmp_path / "a.tif", z), **keys)
    assert np.abs(bag.terrain.z - tif.terrain.z).max() < 1e-6
    assert float(bag.height(0, 0)) == pytest.approx(z[40, 50], abs=1e-6)


def _gdal_has(driver):
    with rasterio.Env() as env:
        return driver in env.drivers()


def test_the_surveys_own_nodes_keep_their_values(tmp_path):
    """Every node inside the crop is a node of the world at the survey's own height, and rays find it."""
    z = relief()
    lat, lon = latlon(40, 50)
    keys = {"centre_deg": (float(lat), float(lon)), "size_m": (300.0, 400.0), "nodes": "survey"}
    world = build(write_raster(tmp_path / "a.tif", z), **keys)
    field = world.terrain
    assert isinstance(field, SurveyNodes)
    i, j = np.meshgrid(np.arange(26, 55), np.arange(31, 70), indexing="ij")
    x, y = world.origin.to_xy(*latlon(i, j))
    assert np.abs(world.height(x, y) - z[i, j]).max() < 1e-6
    assert np.isin(field.z, z).all()  # the very numbers
    x, y, known = (a[1:-1, 1:-1].ravel() for a in (x, y, z[i, j]))  # beside the outermost there is nothing to hit
    hits = world.cast(np.stack([x, y, np.zeros(x.size)], axis=1), (0, 0, -1))
    assert hits.valid.all()
    assert np.abs(hits.position[:, 2] - known).max() < 1e-3  # single precision over 40 m, and slope 0.3


def test_rays_agree_with_the_height_between_nodes(tmp_path):
    lat, lon = latlon(40, 50)
    keys = {"centre_deg": (float(lat), float(lon)), "size_m": (300.0, 400.0), "nodes": "survey"}
    world = build(write_raster(tmp_path / "a.tif", relief()), **keys)
    xy = np.random.default_rng(0).uniform(-120, 120, (500, 2))
    hits = world.cast(np.column_stack([xy, np.zeros(500)]), (0, 0, -1))
    assert np.abs(hits.position[:, 2] - world.height(xy[:, 0], xy[:, 1])).max() < 2e-3
    assert (hits.normal[:, 2] > 0.5).all()
    assert np.isnan(world.height(5000, 0))


def test_a_world_on_survey_nodes_is_saved_and_read_back(tmp_path):
    lat, lon = latlon(40, 50)
    keys = {"centre_deg": (float(lat), float(lon)), "size_m": (300.0, 400.0), "nodes": "survey"}
    world = build(write_raster(tmp_path / "a.tif", relief()), **keys)
    again = load(save(world, tmp_path / "world.npz"))
    xy = np.random.default_rng(0).uniform(-120, 120, (2, 50))
    assert np.array_equal(again.height(*xy), world.height(*xy))


@pytest.mark.parametrize("slope", [2.4, 3.2, 4.0])
def test_a_known_spectrum_is_measured(slope):
    """Slope within 0.35 and root mean square within 30 % on 160 x 160 nodes: eight rings of 20 to 3000 samples each."""
    field = fractal((160, 160), 5.0, np.random.default_rng(1), slope=slope, longest=200.0, shortest=10.0)
    found = spectrum(field, (5.0, 5.0))
    assert found.slope == pytest.approx(slope, abs=0.35)
    assert found.rms(200.0, 10.0) == pytest.approx(1.0, rel=0.3)


def test_the_integral_of_a_power_law():
    """S = k^-2: the mean square is 2 pi ln(longest / shortest); k^-4: pi (longest^2 - shortest^2)."""
    assert Spectrum(1.0, 2.0).rms(20.0, 5.0) == pytest.approx(np.sqrt(2 * np.pi * np.log(4)))
    assert Spectrum(1.0, 4.0).rms(20.0, 5.0) == pytest.approx(np.sqrt(np.pi * (400 - 25)))


def test_detail_is_seeded_marked_and_leaves_the_survey(tmp_path):
    path = write_raster(tmp_path / "a.tif", relief())
    lat, lon = latlon(40, 48)
    keys = {"centre_deg": (float(lat), float(lon)), "size_m": (300.0, 300.0), "resolution_m": 1.0}
    plain, one, same, other = (
        build(path, detail=None if s is None else {"seed": s}, **keys) for s in (None, 1, 1, 2)
    )  # fmt: skip
    added = one.terrain.z - plain.terrain.z
    assert np.array_equal(one.terrain.z, same.terrain.z)
    assert not np.array_equal(one.terrain.z, other.terrain.z)
    assert any(n.startswith("invented") for n in one.notes)
    assert not any(n.startswith("invented") for n in plain.notes)
    assert added.std() > 0.01
    i, j = np.meshgrid(np.arange(28, 52), np.arange(36, 60), indexing="ij")
    x, y = one.origin.to_xy(*latlon(i, j))
    moved = np.abs(one.height(x, y) - plain.height(x, y))
    assert np.sqrt((moved**2).mean()) < 0.25 * added.std()


def test_detail_continues_the_spectrum(tmp_path):
    """Power below the survey's shortest wavelength, 20 m, follows the survey's law: rings of 3 800 and 7 100 waves, of
    which the window leaves some 400, scatter by 5 %. Near 20 m the survey's own nodes take a share away.
    """
    path = write_raster(tmp_path / "a.tif", relief(nodes=(120, 120)))
    lat, lon = latlon(60, 60)
    keys = {"centre_deg": (float(lat), float(lon)), "size_m": (600.0, 600.0), "resolution_m": 2.5}
    plain, fine = build(path, **keys), build(path, detail={"seed": 3}, **keys)
    law = spectrum(relief(nodes=(120, 120)), (STEP, STEP))
    added = fine.terrain.z - plain.terrain.z
    window = np.hanning(added.shape[0])[:, None] * np.hanning(added.shape[1])
    power = np.abs(np.fft.fft2(added * window)) ** 2 * 2.5**2 / (window**2).sum()
    k = np.hypot(np.fft.fftfreq(added.shape[0], 2.5)[:, None], np.fft.fftfreq(added.shape[1], 2.5))
    for wavelength, least in ((16.0, 0.6), (11.0, 0.85), (8.0, 0.85)):
        ring = np.abs(k * wavelength - 1) < 0.1
        assert least < power[ring].mean() / (law.level * wavelength**law.slope) < 1.15


@pytest.mark.parametrize(
    ("keys", "says"),
    [({"detail": {"seed": 1}, "resolution_m": 10.0}, "set resolution_m below"),
     ({"nodes": "survey", "resolution_m": 1.0}, "leave resolution_m"),
     ({"detail": {"strength": 0}}, "greater than 0")],
)  # fmt: skip
def test_contradictions(tmp_path, keys, says):
    lat, lon = latlon(40, 48)
    with pytest.raises((WorldError, ValidationError), match=says):
        build(write_raster(tmp_path / "a.tif", relief()), centre_deg=(float(lat), float(lon)), size_m=(200.0, 200.0),
              **keys)  # fmt: skip


def test_soundings_have_no_nodes_of_their_own(tmp_path):
    with pytest.raises(WorldError, match="needs a grid"):
        build(write_las(tmp_path / "a.las", *cloud()), nodes="survey", **MIDDLE)
