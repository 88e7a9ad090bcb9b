"""Fields from NetCDF: exact at the grid's points, linear between, and clear about what is outside or wrong."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pelagos import jit
from pelagos.errors import ScenarioError, ValidityWarning
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.gridded import GriddedCurrentConfig
from pelagos.ocean.site import Site
from pelagos.ocean.tracer import GriddedFieldConfig

xarray = pytest.importorskip("xarray")
pytest.importorskip("netCDF4")

ORIGIN = GeoOrigin(45.0, 13.0)
LAT, LON = np.linspace(44.9, 45.1, 11), np.linspace(12.8, 13.2, 9)
DEPTH, HOURS = np.array([0.5, 5.0, 20.0, 60.0]), np.array([0, 6, 12.0])


def dataset(**changes):
    """CMEMS-like: u = 0.1 + lat part + time part, v linear in longitude and depth; times from 2024-05-01."""
    shape = (len(HOURS), len(DEPTH), len(LAT), len(LON))
    t, z, la, lo = np.meshgrid(HOURS, DEPTH, LAT, LON, indexing="ij")
    u = 0.1 + 2 * (la - 45) + 0.01 * t
    v = 3 * (lo - 13) - 0.002 * z
    temperature = 20 - 0.1 * z + 0 * t
    data = xarray.Dataset(
        {
            "uo": (
                ("time", "depth", "latitude", "longitude"),
                u,
                {"units": "m s-1", "standard_name": "eastward_sea_water_velocity"},
            ),
            "vo": (
                ("time", "depth", "latitude", "longitude"),
                v,
                {"units": "m s-1", "standard_name": "northward_sea_water_velocity"},
            ),
            "thetao": (("time", "depth", "latitude", "longitude"), temperature, {"units": "degrees_C"}),
        },
        coords={
            "time": ("time", HOURS, {"units": "hours since 2024-05-01", "calendar": "standard"}),
            "depth": ("depth", DEPTH, {"units": "m", "positive": "down"}),
            "latitude": ("latitude", LAT, {"units": "degrees_north"}),
            "longitude": ("longitude", LON, {"units": "degrees_east"}),
        },
    )
    assert data.uo.shape == shape
    return data


def write(path: Path, data) -> Path:
    data.to_netcdf(path)
    return path


def build(path: Path, **more):
    config = OceanConfig.model_validate({"currents": {"type": "gridded", "file": str(path), **more}})
    return build_ocean(config, SimpleNamespace(origin=ORIGIN))


def current(sea, lat, lon, depth, t=0.0) -> np.ndarray:
    lat, lon, depth = np.broadcast_arrays(lat, lon, depth)
    x, y = ORIGIN.to_xy(lat, lon)
    place = jit.Array3f64(*(jit.Float64(np.ravel(v).astype(float)) for v in (x, y, -depth)))
    along, west, up = np.array(sea.current(place, jit.Float64(t)))
    angle = convergence(lat.ravel(), lon.ravel())
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([s * along - c * west, c * along + s * west, up], -1)


def convergence(lat, lon) -> np.ndarray:
    """Of the meridians, from true north to the world's x, positive to the east [rad]: J. P. Snyder, Map Projections - A
    Working Manual (1987), Eq. 8-9; the ellipsoid changes it by 1e-10 so near."""
    return np.arctan(np.tan(np.radians(lon - ORIGIN.longitude)) * np.sin(np.radians(lat)))


def test_nodes_are_exact(tmp_path: Path) -> None:
    """Rounding and the map from metres to degrees (2e-9 deg, 0.2 mm) leave 1e-8 m/s."""
    sea = build(write(tmp_path / "a.nc", dataset()))
    for hour in HOURS:
        la, lo, z = np.meshgrid(LAT, LON, DEPTH, indexing="ij")
        found = current(sea, la.ravel(), lo.ravel(), z.ravel(), t=hour * 3600)
        assert found[:, 0] == pytest.approx((0.1 + 2 * (la - 45) + 0.01 * hour).ravel(), abs=1e-8)
        assert found[:, 1] == pytest.approx((3 * (lo - 13) - 0.002 * z).ravel(), abs=1e-8)


def test_true_north_is_not_x_away_from_the_origin(tmp_path: Path) -> None:
    """30 km to the east and west at 70 degrees, meridians lean by 0.74 degrees: a stream to the true north, and one to
    the east, of the world's axes; an independent bearing is that of a step of latitude on the map.
    """
    lat, lon = np.linspace(69.9, 70.1, 5), np.linspace(11.0, 15.0, 81)
    stream = np.ones((2, 5, 81))
    axes = ("time", "latitude", "longitude")
    data = xarray.Dataset(
        {"uo": (axes, -0.3 * stream, {"units": "m/s"}), "vo": (axes, 0.8 * stream, {"units": "m/s"})},
        coords={
            "time": ("time", HOURS[:2], {"units": "hours since 2024-05-01"}),
            "latitude": ("latitude", lat, {"units": "degrees_north"}),
            "longitude": ("longitude", lon, {"units": "degrees_east"}),
        },
    )
    path, origin = write(tmp_path / "a.nc", data), GeoOrigin(70.0, 13.0)
    config = OceanConfig.model_validate({"currents": {"type": "gridded", "file": str(path)}})
    sea = build_ocean(config, SimpleNamespace(origin=origin))
    for place in ((70.02, 13.78), (69.97, 12.2)):
        x, y = origin.to_xy(*place)
        found = np.array(sea.current(jit.Array3f64(float(x), float(y), -2.0), jit.Float64(0.0))).ravel()
        ahead = np.subtract(origin.to_xy(place[0] + 1e-4, place[1]), (x, y))
        north = ahead / np.hypot(*ahead)
        east = np.array([north[1], -north[0]])  # x north, y west: to the right of north
        np.testing.assert_allclose(found[:2], 0.8 * north - 0.3 * east, atol=1e-6)
        assert abs(found[1] - 0.3) > 0.008  # and not the file's own numbers


def test_rows_nearest_to_the_pole(tmp_path: Path) -> None:
    """The edge of a world 300 km wide at 70 degrees reaches 4.9 km farther north in its middle than at its corners: it
    is read, and a file that ends between is refused."""
    lat, lon = np.linspace(68.2, 71.6, 800), np.linspace(8.0, 18.0, 41)
    shape = (len(lat), len(lon))
    origin = GeoOrigin(70.0, 13.0)
    world = SimpleNamespace(origin=origin, bounds=np.array([[-150e3, -150e3, -60.0], [150e3, 150e3, 0.0]]))
    data = xarray.Dataset(
        {"temp": (("lat", "lon"), np.broadcast_to(lat[:, None] - 60.0, shape), {"units": "degC"})},
        coords={
            "lat": ("lat", lat, {"units": "degrees_north"}),
            "lon": ("lon", lon, {"units": "degrees_east"}),
        },
    )
    path = write(tmp_path / "a.nc", data)
    config = OceanConfig.model_validate({"temperature_c": [{"type": "gridded", "file": str(path)}]})
    sea = build_ocean(config, world)
    place = jit.Array3f64(jit.Float64([149_900.0, 149_900.0]), jit.Float64([0.0, -40e3]), -2.0)
    north = origin.to_latlon(np.full(2, 149_900.0), np.array([0.0, -40e3]))[0]
    np.testing.assert_allclose(np.array(sea.temperature(place, jit.Float64(0.0))), north - 60.0, atol=1e-7)
    write(tmp_path / "b.nc", data.isel(lat=lat < 71.33))
    short = OceanConfig.model_validate({"temperature_c": [{"type": "gridded", "file": str(tmp_path / "b.nc")}]})
    with pytest.raises(ScenarioError, match="covers latitude"):
        build_ocean(short, world)


def test_times_that_fall_and_starts_of_any_zone(tmp_path: Path) -> None:
    """The same field backwards; 08:00 in a zone two hours ahead is 06:00 in UTC, without a warning."""
    data = dataset().isel(time=slice(None, None, -1))
    path = write(tmp_path / "a.nc", data)
    assert current(build(path), 45, 13, 5.0, t=3 * 3600.0)[0, 0] == pytest.approx(0.1 + 0.03, abs=1e-8)
    for start in ("2024-05-01T08:00:00+02:00", "2024-05-01T06:00:00Z", "2024-05-01T06:00"):
        sea = build(path, start=start)
        assert current(sea, 45, 13, 5.0)[0, 0] == pytest.approx(0.1 + 0.06, abs=1e-8)
    shuffled = write(tmp_path / "b.nc", dataset().isel(time=[0, 2, 1]))
    with pytest.raises(ScenarioError, match="time does not increase"):
        build(shuffled)


def test_upward_velocity_where_it_is_named(tmp_path: Path) -> None:
    data = dataset()
    data["wo"] = (data.uo * 0 + 0.01 * data.latitude).assign_attrs(units="m s-1")
    sea = build(write(tmp_path / "a.nc", data), up_variable="wo")
    assert current(sea, 45.02, 13.0, 5.0)[0] == pytest.approx([0.14, -0.01, 0.4502], abs=1e-8)


def test_between_nodes_it_is_linear(tmp_path: Path) -> None:
    """First order in each coordinate: a quadratic is off by h^2/8 of its second derivative in the middle of a cell."""
    sea = build(write(tmp_path / "a.nc", dataset()))
    assert current(sea, 45.013, 12.987, 11.0, t=1800.0)[0, :2] == pytest.approx(
        [0.1 + 2 * 0.013 + 0.005, 3 * -0.013 - 0.022],
        abs=2e-5,  # what north turns by in a cell, 6e-4, times its step/4
    )
    data = dataset()
    data["uo"] = data.uo.copy(data=np.broadcast_to(((LAT - 45) ** 2)[:, None], data.uo.shape))
    sea = build(write(tmp_path / "b.nc", data))
    assert current(sea, 45.01, 13.0, 5.0)[0, 0] == pytest.approx(0.01**2 + 0.02**2 / 4, abs=1e-9)
    found = [current(sea, 45.0 + d, 13.0, 5.0)[0, 0] for d in (0.0, 0.02)]
    assert found == pytest.approx([0, 0.02**2], abs=1e-9)


def test_start_and_depths_beyond_the_levels(tmp_path: Path) -> None:
    sea = build(write(tmp_path / "a.nc", dataset()), start="2024-05-01T06:00:00")
    assert current(sea, 45, 13, 0.5)[0, 0] == pytest.approx(0.1 + 0.06, abs=1e-8)
    shallow, deep = current(sea, 45, 13, np.array([0.0, 500.0]))
    assert shallow[1] == pytest.approx(-0.002 * 0.5, abs=1e-8)
    assert deep[1] == pytest.approx(-0.002 * 60, abs=1e-8)


def test_outside_is_an_error_or_held_or_fades(tmp_path: Path) -> None:
    path = write(tmp_path / "a.nc", dataset())
    spot = (45.11, 13.0, 5.0)  # half a cell beyond the northern edge
    assert np.isnan(current(build(path), *spot)).any()
    assert current(build(path, outside="clamp"), *spot)[0, 0] == pytest.approx(0.3, abs=1e-8)
    assert current(build(path, outside="fade"), *spot)[0, 0] == pytest.approx(0.15, abs=1e-6)
    assert current(build(path, outside="fade"), 45.3, 13.0, 5.0)[0] == pytest.approx([0, 0, 0])
    assert np.isnan(current(build(path), 45, 13, 5, t=13 * 3600)).any()
    assert current(build(path, outside="clamp"), 45, 13, 5, t=99 * 3600)[0, 0] == pytest.approx(0.22, abs=1e-8)


def test_world_must_be_covered(tmp_path: Path) -> None:
    path = write(tmp_path / "a.nc", dataset())
    world = SimpleNamespace(origin=ORIGIN, bounds=np.array([(-20_000.0, -100, -30), (100, 100, 0)]))
    config = {"type": "gridded", "file": str(path)}
    with pytest.raises(ScenarioError, match=r"covers latitude 44\.9000 to 45\.1000, and the world reaches from 44\.8"):
        build_ocean(OceanConfig.model_validate({"currents": config}), world)
    with pytest.warns(ValidityWarning, match="beyond it the value at its edge holds"):
        build_ocean(OceanConfig.model_validate({"currents": {**config, "outside": "clamp"}}), world)


def test_run_must_be_covered(tmp_path: Path) -> None:
    path = write(tmp_path / "a.nc", dataset())
    config = OceanConfig.model_validate(
        {"currents": {"type": "gridded", "file": str(path), "start": "2024-05-01T06:00"}}
    )
    world = SimpleNamespace(origin=ORIGIN)
    build_ocean(config, world, duration_s=6 * 3600)
    with pytest.raises(ScenarioError, match="ends 21600 s after the start, and the run lasts 30000 s"):
        build_ocean(config, world, duration_s=30_000)


def test_land_is_still_and_scalars_are_filled_from_the_nearest(tmp_path: Path) -> None:
    data = dataset()
    land = np.zeros(data.uo.shape, dtype=bool)
    land[:, :, :3] = True
    land[:, 3] = True
    for name in ("uo", "vo", "thetao"):
        data[name] = data[name].where(~land)
    path = write(tmp_path / "a.nc", data)
    sea = build(path)
    assert current(sea, LAT[1], 13.0, 5.0)[0] == pytest.approx([0, 0, 0], abs=1e-9)
    field = [{"type": "gridded", "file": str(path), "quantity": "temperature"}]
    sea = build_ocean(OceanConfig.model_validate({"temperature_c": field}), SimpleNamespace(origin=ORIGIN))
    x, y = ORIGIN.to_xy(np.array([LAT[0], 45.0]), np.array([13.0, 13.0]))
    place = jit.Array3f64(jit.Float64(x), jit.Float64(y), jit.Float64([-5.0, -60.0]))
    assert np.array(sea.temperature(place, jit.Float64(0.0))) == pytest.approx([19.5, 18.0], abs=1e-6)


def test_a_file_is_searched_for_what_it_is_given_for(tmp_path: Path) -> None:
    data = dataset()
    for name, value, unit in (("thetao", 283.65, "K"), ("so", 34.2, "1"), ("dye", 0.7, "1"), ("odd", 0.3, "1")):
        data[name] = (0 * data.thetao + value).assign_attrs(units=unit, standard_name="", long_name=name)
    file = {"type": "gridded", "file": str(write(tmp_path / "a.nc", data))}
    tracers = {"dye": [file], "tint": [{**file, "variable": "odd"}], "salt": [{**file, "quantity": "salinity"}]}
    config = OceanConfig.model_validate({"temperature_c": [file], "salinity": [file], "tracers": tracers})
    sea = build_ocean(config, SimpleNamespace(origin=ORIGIN))
    place, now = jit.Array3f64(30.0, -40.0, -6.0), jit.Float64(0.0)
    found = [sea.temperature(place, now), sea.salinity(place, now), *(sea.tracer(n, place, now) for n in tracers)]
    assert [float(v[0]) for v in found] == pytest.approx([10.5, 34.2, 0.7, 0.3, 34.2], abs=1e-5)  # single precision
    assert OceanConfig.model_validate(config.model_dump(mode="json", exclude_unset=True)) == config


@pytest.mark.parametrize("longitude", [0.02, -0.3, 179.9, -179.95])
def test_a_global_grid_has_no_edge_at_greenwich_nor_at_the_date_line(tmp_path: Path, longitude: float) -> None:
    """Columns from 0 to 360, the last of them the first again; v of sin(longitude) is linear over half a degree to
    (pi / 360)^2 / 8 = 1e-5.
    """
    lat, lon = np.linspace(50.0, 52.0, 5), np.linspace(0.0, 360.0, 721)
    v = np.broadcast_to(np.sin(np.radians(lon)), (1, 1, 5, 721))
    dims = ("time", "depth", "latitude", "longitude")
    data = xarray.Dataset(
        {
            "uo": (dims, 0 * v, {"units": "m s-1", "standard_name": "eastward_sea_water_velocity"}),
            "vo": (dims, v, {"units": "m s-1", "standard_name": "northward_sea_water_velocity"}),
        },
        coords={
            "time": ("time", HOURS[:1], {"units": "hours since 2024-05-01", "calendar": "standard"}),
            "depth": ("depth", DEPTH[:1], {"units": "m", "positive": "down"}),
            "latitude": ("latitude", lat, {"units": "degrees_north"}),
            "longitude": ("longitude", lon, {"units": "degrees_east"}),
        },
    )
    origin = GeoOrigin(51.0, longitude)
    config = OceanConfig.model_validate({"currents": {"type": "gridded", "file": str(write(tmp_path / "g.nc", data))}})
    bounds = np.array([(-1000.0, -40_000.0, -30.0), (1000.0, 40_000.0, 0.0)])
    sea = build_ocean(config, SimpleNamespace(origin=origin, bounds=bounds))
    for apart in (-0.4, 0.0, 0.35):
        x, y = origin.to_xy(np.array([51.0]), np.array([longitude + apart]))
        found = np.array(sea.current(jit.Array3f64(jit.Float64(x), jit.Float64(y), -0.5), jit.Float64(0.0)))
        assert found[0, 0] == pytest.approx(np.sin(np.radians(longitude + apart)), abs=2e-5)


def test_potential_temperature_becomes_that_of_the_water_at_its_depth(tmp_path: Path) -> None:
    """CMEMS' `thetao`. TEOS-10's third cast-1 level: SA 34.705, CT 4.841880 at 909 dbar is 4.9176 degC in situ."""
    gsw = pytest.importorskip("gsw")
    data = dataset().assign_coords(depth=("depth", [0.5, 5.0, 20.0, 901.8572643], {"units": "m", "positive": "down"}))
    potential = gsw.pt_from_CT(34.70523685, 4.841880415)
    data["thetao"] = (0 * data.thetao + potential).assign_attrs(
        units="degrees_C", standard_name="sea_water_potential_temperature"
    )
    path = write(tmp_path / "a.nc", data)
    config = OceanConfig.model_validate(
        {"temperature_c": [{"type": "gridded", "file": str(path), "quantity": "temperature"}]}
    )
    sea = build_ocean(config, SimpleNamespace(origin=ORIGIN))
    place = jit.Array3f64(0.0, 0.0, jit.Float64([-0.5, -901.8572643]))
    found = np.array(sea.temperature(place, jit.Float64(0.0)))
    assert found == pytest.approx([potential, 4.9176], abs=1e-3)
    assert found[1] - found[0] > 0.05


@pytest.mark.parametrize(
    "change",
    ["descending", "hycom", "no_time", "surface_only", "360", "cm/s", "kelvin", "metres"],
)
def test_other_conventions(tmp_path: Path, change: str) -> None:
    data, expected, t = dataset(), 0.1 + 2 * 0.013, 0.0
    if change == "descending":
        data = data.isel(latitude=slice(None, None, -1), depth=slice(None, None, -1))
    elif change == "hycom":
        data = data.rename(uo="water_u", vo="water_v", latitude="lat", longitude="lon")
        for name in ("water_u", "water_v"):
            del data[name].attrs["standard_name"]
    elif change == "no_time":
        data = data.isel(time=0, drop=True)
    elif change == "surface_only":
        data = data.isel(depth=0, drop=True)
    elif change == "360":
        data = data.assign_coords(longitude=("longitude", LON + 360, data.longitude.attrs))
    elif change == "cm/s":
        data["uo"] = (data.uo * 100).assign_attrs(units="cm/s")
        data["vo"] = (data.vo * 100).assign_attrs(units="cm/s")
    elif change == "metres":
        north, east = np.arange(-5000.0, 5001, 1000), np.arange(-4000.0, 4001, 1000)
        data = data.rename(latitude="y", longitude="x")
        data = data.assign_coords(y=("y", north, {"units": "m"}), x=("x", east, {"units": "m"}))
        expected = 0.1 + 2 * (0.02 * 1.445)
    path = write(tmp_path / "a.nc", data)
    if change == "metres":
        place = jit.Array3f64(1445.0, 300.0, -5.0)
        north = (
            3 * (0.05 * -0.3) - 0.002 * 5.0
        )  # 300 m to the west of the middle, columns of 0.05 degrees each kilometre
        found = np.array(build(path).current(place, jit.Float64(t)))[:, 0]
        assert found == pytest.approx([north, -expected, 0.0], abs=1e-9)
        return
    found = current(build(path), 45.013, 13.0, 5.0, t=t)
    assert found[0, 0] == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("missing", "no file"),
        ("not netcdf", "is not a NetCDF file"),
        ("cut short", "damaged or cut short"),
        ("folder", "is a folder"),
        ("noleap", "calendar 'noleap'"),
        ("time units", "cannot read the units 'fortnights since last tuesday'"),
        ("no time units", "no units like"),
        ("depth units", "'dbar'"),
        ("no depth units", "without units"),
        ("no units", "no units"),
        ("strange units", "furlong"),
        ("calendar", "calendar"),
        ("no velocity", "no variable looks like"),
        ("sigma", "s_rho"),
        ("empty", "no value"),
        ("start", "lies outside"),
        ("bad start", "ISO"),
        ("wrong name", "did you mean 'uo'"),
        ("member", "cannot tell what the dimension 'member' of 'uo' is; expected time, depth, latitude and longitude"),
        ("no latitude", r"'uo' has no coordinate of latitude \(dimensions: time, depth, longitude\)"),
        ("no longitude", r"'uo' has no coordinate of longitude \(dimensions: time, depth, latitude\)"),
        ("no latitudes", "the dimension 'latitude' has no coordinate values$"),
        ("one row", "the coordinate 'latitude' has 1 entries; at least two are needed"),
        ("y without units", "the coordinate 'y' has no units; known: degrees_north, m"),
        ("no depths", "the dimension 'depth' has no coordinate values; depths in metres are needed"),
        ("no times", "the dimension 'time' has no coordinate values"),
        ("to and fro", "the coordinate of latitude does not increase from entry to entry"),
        ("twice", "the coordinate of depth does not increase from entry to entry"),
        ("times again", "the coordinate of time does not increase from entry to entry"),
        ("hole", "the coordinate of longitude does not increase from entry to entry"),
        ("large", "0 million values of each variable fall into the world; cut the file, at most 0 million"),
    ],
)
def test_bad_files(tmp_path: Path, change: str, message: str, monkeypatch) -> None:
    data, path, more = dataset(), tmp_path / "currents.nc", {}
    if change == "no units":
        del data.uo.attrs["units"]
    elif change == "strange units":
        data.uo.attrs["units"] = "furlong/fortnight"
    elif change == "calendar":
        data = data.assign_coords(time=("time", HOURS, {"units": "hours since 2024-02-30", "calendar": "360_day"}))
    elif change == "noleap":
        data = data.assign_coords(time=("time", HOURS, {"units": "hours since 2024-02-20", "calendar": "noleap"}))
    elif change == "time units":
        data = data.assign_coords(time=("time", HOURS, {"units": "fortnights since last tuesday"}))
    elif change == "no time units":
        data = data.assign_coords(time=("time", HOURS))
    elif change == "depth units":
        data.depth.attrs["units"] = "dbar"
    elif change == "no depth units":
        del data.depth.attrs["units"]
    elif change == "no velocity":
        data = data.drop_vars("uo")
    elif change == "sigma":
        data = data.drop_vars("depth").rename(depth="s_rho")
    elif change == "empty":
        data["uo"] = data.uo * np.nan
        data.uo.attrs = {"units": "m s-1"}
    elif change == "start":
        more = {"start": "2025-01-01"}
    elif change == "bad start":
        more = {"start": "yesterday"}
    elif change == "wrong name":
        more = {"east_variable": "u0"}
    elif change == "member":
        data["uo"] = data.uo.expand_dims(member=2).assign_attrs(data.uo.attrs)
    elif change in ("no latitude", "no longitude"):
        data = data.isel({change[3:]: 0}, drop=True)
    elif change in ("no latitudes", "no depths", "no times"):
        data = data.drop_vars(change[3:-1])
    elif change == "one row":
        data = data.isel(latitude=[4])
    elif change == "y without units":
        data = data.rename(latitude="y").assign_coords(y=("y", LAT))
    elif change == "to and fro":
        data = data.isel(latitude=[0, 1, 2, 4, 3, 5])
    elif change == "twice":
        data = data.isel(depth=[0, 1, 1, 2])
    elif change == "times again":
        data = data.isel(time=[0, 1, 1])
    elif change == "hole":
        data = data.assign_coords(longitude=("longitude", np.where(LON > 13.1, np.nan, LON), data.longitude.attrs))
    elif change == "large":
        monkeypatch.setattr("pelagos.ocean.netcdf._BIGGEST", 3 * 4 * 11 * 9 - 1)
    if change == "not netcdf":
        path.write_text("no data here")
    elif change == "folder":
        path.mkdir()
    elif change != "missing":
        write(path, data)
    if change == "cut short":
        path.write_bytes(path.read_bytes()[:9000])
    with pytest.raises(ScenarioError, match=message):
        build(path, **more)


@pytest.mark.parametrize(
    ("name", "units", "value", "expected"),
    [
        ("salinity", "kg kg-1", 0.0351, 35.1),
        ("salinity", "1e-3", 35.1, 35.1),
        ("oxygen", "umol kg-1", 250.0, 250.0),
        ("oxygen", "mmol m-3", 250.0, 250.0 / 1.025),
        ("oxygen", "mol m^-3", 0.25, 250.0 / 1.025),
        ("oxygen", "ml/l", 5.6, 5.6 / 22.3916e-3 / 1.025),
        ("oxygen", "mg/L", 8.0, 8.0 / 31.9988e-3 / 1.025),
        ("chlorophyll", "\u00b5g/l", 2.5, 2.5),
        ("chlorophyll", "kg m-3", 2.5e-6, 2.5),
    ],
)
def test_units_of_what_water_carries(tmp_path: Path, name: str, units: str, value: float, expected: float) -> None:
    """By molar mass and volume, in water of 1025 kg/m^3."""
    axes = ("depth", "latitude", "longitude")
    field = (axes, np.full((len(DEPTH), len(LAT), len(LON)), value), {"units": units})
    path = write(tmp_path / "a.nc", dataset().drop_vars(["uo", "vo", "thetao"]).assign({name: field}))
    gridded = [{"type": "gridded", "file": str(path)}]
    config = OceanConfig.model_validate({"salinity": gridded} if name == "salinity" else {"tracers": {name: gridded}})
    sea, place = build_ocean(config, SimpleNamespace(origin=ORIGIN)), jit.Array3f64(0.0, 0.0, -5.0)
    found = sea.salinity(place, jit.Float64(0.0)) if name == "salinity" else sea.tracer(name, place, jit.Float64(0.0))
    assert np.array(found) == pytest.approx(expected, rel=1e-5)


def test_unknown_units_and_speeds_that_no_water_has_are_refused(tmp_path: Path) -> None:
    data = dataset()
    data["so"] = data.thetao.assign_attrs(units="furlongs")
    config = OceanConfig.model_validate(
        {"salinity": [{"type": "gridded", "file": str(write(tmp_path / "a.nc", data))}]}
    )
    with pytest.raises(ScenarioError, match="cannot read the units 'furlongs' of 'so'; known: 1, psu or g kg-1"):
        build_ocean(config, SimpleNamespace(origin=ORIGIN))
    data = dataset()
    data["uo"] = data.uo.where(data.longitude < 13.1, -9999.0).assign_attrs(data.uo.attrs)
    with pytest.raises(ScenarioError, match=r"b.nc has speeds of up to 1e\+04 m/s; a mark for missing values"):
        build(write(tmp_path / "b.nc", data))


@pytest.mark.parametrize("packed", [True, False])
def test_values_beyond_the_valid_range_are_gaps(tmp_path: Path, packed: bool) -> None:
    """The range of packed values is packed too: here 0.35 m/s is 350. What lies beyond it is land."""
    data = dataset()
    data["uo"] = data.uo.where(data.longitude < 13.1, 1.5).assign_attrs(data.uo.attrs)
    data.uo.attrs |= {"valid_min": np.int16(-350), "valid_max": np.int16(350)} if packed else {"valid_max": 0.35}
    encoding = {"uo": {"dtype": "int16", "scale_factor": 1e-3, "_FillValue": np.int16(-32768)}} if packed else {}
    data.to_netcdf(tmp_path / "a.nc", encoding=encoding)
    sea = build(tmp_path / "a.nc")
    assert current(sea, 45.02, 13.0, 5.0)[0, 0] == pytest.approx(0.14, abs=1e-6)
    assert abs(current(sea, 45.0, 13.2, 5.0)[0, 0]) < 0.01


def test_gaps_take_the_value_that_is_nearest_in_metres(tmp_path: Path) -> None:
    """At 60 degrees a cell of 0.02 by 0.01 degrees is 2.2 km by 0.56 km: two cells aside are nearer than one ahead."""
    lat, lon = np.linspace(59.9, 60.1, 11), np.linspace(12.95, 13.05, 11)
    values = np.arange(121.0).reshape(11, 11) / 10.0
    gap = np.zeros((11, 11), bool)
    gap[5, 3:6] = True  # beside it columns 2 and 6, above and below it rows 4 and 6
    field = (("lat", "lon"), np.where(gap, np.nan, values), {"units": "degC"})
    data = xarray.Dataset(
        {"temp": field},
        coords={
            "lat": ("lat", lat, {"units": "degrees_north"}),
            "lon": ("lon", lon, {"units": "degrees_east"}),
        },
    )
    path, origin = write(tmp_path / "a.nc", data), GeoOrigin(60.0, 13.0)
    config = OceanConfig.model_validate({"temperature_c": [{"type": "gridded", "file": str(path)}]})
    sea = build_ocean(config, SimpleNamespace(origin=origin))
    for column, nearest in ((3, 2), (5, 6)):
        x, y = origin.to_xy(lat[5], lon[column])
        found = np.array(sea.temperature(jit.Array3f64(float(x), float(y), -1.0), jit.Float64(0.0)))
        assert found == pytest.approx(values[5, nearest], abs=1e-6)
    x, y = origin.to_xy(lat[5], lon[4])
    found = np.array(sea.temperature(jit.Array3f64(float(x), float(y), -1.0), jit.Float64(0.0))).item()
    assert min(abs(found - values[5, k]) for k in (2, 6)) < 1e-6


def test_as_many_values_as_may_be(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("pelagos.ocean.netcdf._BIGGEST", 3 * 4 * 11 * 9)
    build(write(tmp_path / "a.nc", dataset()))


def test_a_file_is_checked_without_a_device(tmp_path: Path) -> None:
    """As a run would read it: only `outside: error` refuses a world that it does not cover."""
    path = write(tmp_path / "a.nc", dataset())
    site = lambda south: Site(ORIGIN, ((-south, -100.0, -30.0), (100.0, 100.0, 0.0)))
    config = {"type": "gridded", "file": str(path)}
    for south, outside in ((100.0, "error"), (20_000.0, "clamp")):
        GriddedCurrentConfig.model_validate({**config, "outside": outside}).check(site(south))
    with pytest.raises(
        ScenarioError, match=r"the world reaches from 44\.8.*, or say 'outside: clamp' or 'outside: fade'"
    ):
        GriddedCurrentConfig.model_validate(config).check(site(20_000.0))


def test_water_that_is_nowhere_at_the_surface_balances_no_vehicle(monkeypatch) -> None:
    config = OceanConfig.model_validate({"temperature_c": {"depth_m": [0, 9], "value": [20, 10]}})
    assert build_ocean(config).ballast is not None
    monkeypatch.setattr("pelagos.ocean.config.math.isfinite", lambda v: v != 20)
    with pytest.raises(ScenarioError, match="there is no temperature or salinity at the surface of the world's origin"):
        build_ocean(config)


def test_a_field_of_a_file_says_its_quantity() -> None:
    field = lambda **keys: GriddedFieldConfig.model_validate({"type": "gridded", "file": "a.nc", **keys}).quantities
    assert field(quantity="oxygen") == [("oxygen", None)]
    assert field(variable="dye") == [("dye", "dye")]
    assert field(quantity="oxygen", variable="dye") == [("oxygen", "dye")]
    with pytest.raises(ScenarioError, match="quantity: say which quantity to read from the file"):
        field()


def test_files_need_their_readers(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "netCDF4", None)
    with pytest.raises(ScenarioError, match=r"the extra 'bathymetry': pip install pelagos\[bathymetry\]"):
        build(Path("a.nc"))
