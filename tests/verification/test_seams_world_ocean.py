"""Signs and axes where the world and the ocean meet their data: inputs unequal on all axes, of both signs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pelagos import jit
from pelagos.math.geodesy import GeoOrigin
from pelagos.math.lookup import locate, sample
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.tide import TideConfig, make_tide
from pelagos.world.bathymetry import regrid
from pelagos.world.bathymetry.survey import Grid, Soundings
from pelagos.world.bathymetry.values import upwards
from pelagos.world.terrain import HeightField


@pytest.mark.parametrize(("a", "b"), [(0.3, -0.7), (-0.2, 0.5), (0.4, 0.1)])
def test_normals_of_a_tilted_plane(a: float, b: float) -> None:
    """z = a x + b y has the normal (-a, -b, 1) / sqrt(1 + a^2 + b^2) at every node; float32."""
    x, y = np.meshgrid(np.arange(5) * 2.5 - 3.0, np.arange(7) * 2.5 + 4.0, indexing="ij")
    field = HeightField(-3.0, 4.0, 2.5, a * x + b * y - 9.0)
    expected = np.array([-a, -b, 1.0]) / np.sqrt(1 + a * a + b * b)
    np.testing.assert_allclose(field.normals(), np.broadcast_to(expected, (5, 7, 3)), atol=2e-6)


def test_tide_is_late_by_its_phase() -> None:
    """h(t) = sum of A cos(2 pi t / T - phase), as tide tables have it: high water comes phase / 2 pi periods late."""
    given = [(1.3, 12.42, 40.0), (0.4, 5.7, -75.0)]
    tide = make_tide(tuple(TideConfig(amplitude_m=a, period_h=h, phase_deg=p) for a, h, p in given))
    t = np.array([0.0, 3000.0, 11_000.0, -7000.0])
    expected = sum(a * np.cos(2 * np.pi * t / (3600 * h) - np.radians(p)) for a, h, p in given)
    assert tide is not None
    np.testing.assert_allclose(np.array(tide.level(jit.Float64(t))), expected, atol=1e-12)


@pytest.mark.parametrize(("asked", "sign"), [("down", -1.0), ("up", 1.0)])
@pytest.mark.parametrize("offset", [0.8, -1.7])
def test_a_datum_offset_is_added_to_heights_whatever_the_file_counts(asked: str, sign: float, offset: float) -> None:
    """A depth of 12 m below chart datum, which lies `offset` above the mean sea surface, is -12 + offset high."""
    z = np.array([12.0, 3.5, -0.6])
    survey, _ = upwards(Soundings(z, z, z, "EPSG:4326", "v"), asked, offset)
    np.testing.assert_allclose(survey.z, sign * z + offset)


@pytest.mark.parametrize(("low", "high"), [((-20, -70), (40, -10)), ((-30, 5), (90, 35)), ((12, -95), (42, 45))])
def test_dense_soundings_become_the_mean_of_their_square(
    low: tuple[float, float], high: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Squares of 10 m from (low - margin) on, a fifth of the longer side: every mean lies in its square, none is lost
    or shared, and what lies farther away is left out.
    """
    monkeypatch.setattr(regrid, "_MANY", 5)
    origin = GeoOrigin(45.0, 13.0)
    rng = np.random.default_rng(2)
    margin = 0.2 * max(high[0] - low[0], high[1] - low[1])
    x, y = (rng.uniform(low[i] - 2 * margin, high[i] + 2 * margin, 900) for i in (0, 1))
    latitude, longitude = origin.to_latlon(x, y)
    z = 0.2 * x - 0.5 * y + 3.0
    survey = Soundings(latitude, longitude, z, "EPSG:4326", "dense")
    means = regrid.block_means(survey, origin, low=low, high=high, cell=10.0)
    mx, my = origin.to_xy(means.u, means.v)
    np.testing.assert_allclose(means.z, 0.2 * mx - 0.5 * my + 3.0, atol=1e-4)  # the plane's mean is on the plane
    start = np.array(low) - margin
    last = np.ceil((np.array(high) + margin - start) / 10.0) - 1
    within = lambda i, j: 0 <= i <= last[0] and 0 <= j <= last[1]
    cells = lambda px, py: set(zip(*(np.floor((np.array([px, py]).T - start) / 10.0).astype(int).T), strict=True))
    filled = {cell for cell in cells(x, y) if within(*cell)}
    assert len(means.z) == len(filled) < len(cells(x, y))
    assert cells(mx, my) == filled
    kept = sum(within(*cell) for cell in np.floor((np.array([x, y]).T - start) / 10.0))
    assert means.notes[-1].endswith(f"{len(filled)} for {kept}")


def test_few_soundings_about_a_crop_stay_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 300 along a line, 10 m apart, those on 200 m of it and a fifth more at both ends."""
    monkeypatch.setattr(regrid, "_MANY", 100)
    origin = GeoOrigin(45.0, 13.0)
    y = np.arange(300) * 10.0 - 1000.0 + 0.5
    latitude, longitude = origin.to_latlon(0 * y + 3.0, y)
    survey = Soundings(latitude, longitude, 0.1 * y, "EPSG:4326", "line")
    near = regrid.block_means(survey, origin, low=(-50.0, 300.0), high=(50.0, 500.0), cell=10.0)
    assert near.z == pytest.approx(0.1 * y[(y > 260) & (y < 540)], abs=1e-12)
    assert near.notes == survey.notes


def test_soundings_at_one_place_count_as_their_mean() -> None:
    """A plane, each of whose soundings is there twice or three times: d too high, d too low, and as it is."""
    origin = GeoOrigin(45.0, 13.0)
    x, y = (a.ravel() for a in np.meshgrid(np.arange(8) * 10.0 - 4.0, np.arange(5) * 10.0 - 207.0))
    z, d = 0.3 * x - 0.2 * y - 20.0, 1.0 + 0.05 * x
    where = np.concatenate([np.arange(40), np.arange(40), np.arange(0, 40, 3)])
    heights = np.concatenate([z + d, z - d, z[::3]])
    latitude, longitude = origin.to_latlon(x[where], y[where])
    survey = Soundings(latitude, longitude, heights, "EPSG:4326", "twice")
    found = regrid.sample(survey, origin, np.array([3.0, 21.0, 55.0]), np.array([-199.0, -172.0]))
    expected = 0.3 * np.array([3.0, 21.0, 55.0])[:, None] - 0.2 * np.array([-199.0, -172.0]) - 20.0
    np.testing.assert_allclose(found, expected, atol=1e-4)
    two = Soundings(*origin.to_latlon(np.array([3.0, 9.0]), np.array([-199.0, -190.0])), z[:2], "EPSG:4326", "two")
    assert np.isnan(regrid.sample(two, origin, np.array([3.0, 21.0]), np.array([-199.0, -172.0]))).all()


@pytest.mark.parametrize(("turn", "sign"), [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)])
def test_the_extent_of_a_grid_is_that_of_its_sides(turn: int, sign: float) -> None:
    """In polar stereographic coordinates a rectangle beside the pole comes nearest to it in the middle of a side."""
    pyproj = pytest.importorskip("pyproj")
    near, far, half = 1.0e6, 1.2e6, 3.0e5
    across, along = np.linspace(*sorted((sign * near, sign * far)), 5), np.linspace(-half, half, 7)
    u, v = (along, across) if turn else (across, along)
    found = regrid.extent(Grid(u, v, np.zeros((len(u), len(v))), "EPSG:3413", "z"))
    back = pyproj.Transformer.from_crs("EPSG:3413", "EPSG:4326", always_xy=True)
    north = back.transform(*((sign * near, 0.0) if turn else (0.0, sign * near)))[1]  # easting first
    south = back.transform(*((sign * far, half) if turn else (half, sign * far)))[1]
    assert (found.north, found.south) == pytest.approx((north, south), abs=1e-6)
    assert found.holds(0.5 * (north + south), found.west)


def test_places_on_the_edge_of_an_axis_up_to_rounding_are_on_it() -> None:
    axis = np.array([0.0, 1.0, 3.0, 7.0])
    at = np.array([0.0, 7.0, -1e-10, 7.0 + 1e-10, -0.1, 7.1, 2.0, 6.0])
    np.testing.assert_allclose(regrid.fractional(axis, at), [0.0, 3.0, 0.0, 3.0, -1.0, -1.0, 1.5, 2.75])


@pytest.mark.parametrize(("lattice", "far"), [(4.0, 40.0), (0.5, 24.0)])
def test_nodes_are_far_from_soundings_beyond_ten_of_their_distances_or_two_cells(lattice: float, far: float) -> None:
    """A patch on the ground's corner and one beside it, a tenth of its length off, that counts too; one half of its
    length off does not.
    """
    origin, ground = GeoOrigin(45.0, 13.0), HeightField(-20.0, 10.0, 12.0, np.zeros((16, 6)))  # 180 m by 60 m
    patch = np.stack(np.meshgrid(np.arange(9), np.arange(7)), axis=-1).reshape(-1, 2) * lattice
    counted = np.concatenate([patch + np.array([-18.0, 11.0]), patch + np.array([120.0, 88.0])])
    x, y = np.concatenate([counted, patch + np.array([60.0, 160.0])]).T
    survey = Soundings(*origin.to_latlon(x, y), 0 * x, "EPSG:4326", "patches")
    nodes = np.stack(np.meshgrid(ground.x, ground.y), axis=-1).reshape(-1, 1, 2)
    ways = np.linalg.norm(nodes - counted, axis=-1).min(axis=1)
    number, said = regrid.far_from_soundings(survey, origin, ground)
    assert said == pytest.approx(far, rel=1e-5)
    assert number == (ways > far).sum() > 0
    assert (ways < far).sum() > 5
    assert regrid.usual_distance(survey, origin, ground) == pytest.approx(lattice, rel=1e-5)


def test_lookup_is_linear_between_entries_and_held_at_both_ends() -> None:
    table = jit.Float64([2.0, -1.0, 5.0, 11.0])
    at = jit.Float64([-3.0, 0.0, 0.25, 1.5, 2.75, 3.0, 9.0])
    np.testing.assert_allclose(np.array(sample(table, at)), [2.0, 2.0, 1.25, 2.0, 9.5, 11.0, 11.0], atol=1e-12)
    cell, share = locate(jit.Float64([-4.0, -1.0, 0.5, 6.5]), jit.Float64([-9.0, -3.25, 0.0, 2.0, 6.5, 8.0]))
    assert np.array(cell).tolist() == [0, 0, 1, 2, 2, 2]
    np.testing.assert_allclose(np.array(share), [0.0, 0.25, 2 / 3, 0.25, 1.0, 1.0], atol=1e-12)


class TestNetcdf:
    """A file in metres whose fields differ along every axis, read where x is north, y west, and z up."""

    xarray = pytest.importorskip("xarray")
    netcdf4 = pytest.importorskip("netCDF4")

    def ocean(self, path: Path, depth: list[float], attributes: dict[str, str]):
        north, east = np.linspace(-40.0, 60.0, 6), np.linspace(-30.0, 50.0, 5)
        z, n, e = np.meshgrid(np.abs(depth), north, east, indexing="ij")
        axes = ("depth", "y", "x")
        named = lambda way: {"units": "m s-1", "standard_name": f"{way}_sea_water_velocity"}
        data = self.xarray.Dataset(
            {
                "uo": (axes, 0.01 * n - 0.003 * e + 0.02 * z, named("eastward")),
                "vo": (axes, 0.002 * n + 0.005 * e - 0.01 * z, named("northward")),
            },
            coords={
                "depth": ("depth", depth, {"units": "m"} | attributes),
                "y": ("y", north, {"units": "m", "axis": "Y"}),
                "x": ("x", east, {"units": "m", "axis": "X"}),
            },
        )  # fmt: skip
        data.to_netcdf(path)
        config = {"currents": {"type": "gridded", "file": str(path)}}
        return build_ocean(OceanConfig.model_validate(config), None)

    @pytest.mark.parametrize(
        ("depth", "attributes"),
        [([0.0, 4.0, 20.0], {"positive": "down"}), ([0.0, -4.0, -20.0], {"positive": "up"}), ([0.0, -4.0, -20.0], {})],
    )
    def test_metres_north_and_east_and_depths_of_either_sign(self, tmp_path: Path, depth, attributes) -> None:
        ocean = self.ocean(tmp_path / "grid.nc", depth, attributes)
        x, y, z = np.array([13.0, -21.0, 37.0]), np.array([-17.0, 22.0, 5.0]), np.array([-2.0, -7.5, -15.0])
        found = np.array(ocean.current(jit.Array3f64(x, y, z), jit.Float64([0.0, 0.0, 0.0]))).T
        north, east, down = x, -y, -z
        eastward = 0.01 * north - 0.003 * east + 0.02 * down
        northward = 0.002 * north + 0.005 * east - 0.01 * down
        np.testing.assert_allclose(found, np.stack([northward, -eastward, 0 * x], axis=1), atol=1e-9)
