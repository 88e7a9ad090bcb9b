"""Fields on turned grids and on levels that follow the ground, as in ROMS, against the fields they were made of."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.errors import ScenarioError
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.config import OceanConfig, build_ocean

xarray = pytest.importorskip("xarray")
pytest.importorskip("netCDF4")

ORIGIN = GeoOrigin(45.0, 13.0)
TURN = np.radians(25.0)
HC, LEVELS = 8.0, 24
S = (np.arange(LEVELS) + 0.5) / LEVELS - 1
CS = (1 - np.cosh(4 * S)) / (np.cosh(4.0) - 1)
HOURS = np.array([0.0, 6.0])


def lat_lon(j: Any, i: Any) -> tuple[Any, Any]:
    """Of fractional rows and columns: turned by 25 degrees, some 1.1 km apart."""
    y, x = 0.010 * (np.asarray(j) - 8.0), 0.010 * (np.asarray(i) - 9.0)
    return 45.0 + np.sin(TURN) * x + np.cos(TURN) * y, 13.0 + (np.cos(TURN) * x - np.sin(TURN) * y) / np.cos(np.pi / 4)


def east(lat: Any, lon: Any, z: Any, hour: Any) -> Any:
    return 0.2 + 1.5 * (lat - 45) + 0.003 * z + 0.01 * hour + 0 * lon


def north(lat: Any, lon: Any, z: Any, hour: Any) -> Any:
    return -0.1 + 2.0 * (lon - 13) - 0.002 * z + 0 * lat + 0 * hour


def heights(h: Any, zeta: Any, form: int) -> Any:
    """`(levels, ...)`, written from the definitions."""
    s, c = (v.reshape(-1, *([1] * np.ndim(h))) for v in (S, CS))
    if form == 1:
        z0 = HC * (s - c) + h * c
        return z0 + zeta * (1 + z0 / h)
    return zeta + (zeta + h) * (HC * s + h * c) / (HC + h)


def roms(form: int = 2, *, zeta: float = 0.3) -> Any:
    """u and v on their own points along the turned grid, temperature on the middles; the ground slopes."""
    rows, columns = 17, 19
    grids = {"rho": (0.0, 0.0, rows, columns), "u": (0.0, 0.5, rows, columns - 1), "v": (0.5, 0.0, rows - 1, columns)}
    variables: dict[str, Any] = {}
    for kind, (dj, di, nj, ni) in grids.items():
        lat, lon = lat_lon(*np.meshgrid(np.arange(nj) + dj, np.arange(ni) + di, indexing="ij"))
        h = 40.0 + 300 * (lat - 45)
        z = heights(h, zeta, form)
        t = HOURS[:, None, None, None]
        e, n = east(lat, lon, z, t), north(lat, lon, z, t)
        plane = (f"eta_{kind}", f"xi_{kind}")
        variables[f"lat_{kind}"] = (plane, lat, {"units": "degree_north", "standard_name": "latitude"})
        variables[f"lon_{kind}"] = (plane, lon, {"units": "degree_east", "standard_name": "longitude"})
        full = ("ocean_time", "s_rho", *plane)
        if kind == "rho":
            variables["temp"] = (full, np.broadcast_to(20 + 0.2 * z + 0 * t, e.shape), {"units": "Celsius"})
            variables["h"] = (plane, h, {"units": "meter"})
            variables["zeta"] = (("ocean_time", *plane), np.full((2, nj, ni), zeta), {"units": "meter"})
            variables["angle"] = (plane, np.full((nj, ni), TURN), {"units": "radians"})
        elif kind == "u":
            variables["u"] = (full, np.cos(TURN) * e + np.sin(TURN) * n, {"units": "meter second-1"})
        else:
            variables["v"] = (full, -np.sin(TURN) * e + np.cos(TURN) * n, {"units": "meter second-1"})
    variables |= {"Cs_r": ("s_rho", CS), "hc": ((), HC), "Vtransform": ((), form)}
    coordinates = {
        "ocean_time": ("ocean_time", HOURS * 3600, {"units": "seconds since 2024-05-01 00:00:00"}),
        "s_rho": ("s_rho", S, {"standard_name": f"ocean_s_coordinate_g{form}"}),
    }
    return xarray.Dataset(variables, coords=coordinates)


def build(data: Any, path: Path, **more: Any) -> Any:
    data.to_netcdf(path)
    gridded = {"type": "gridded", "file": str(path), **more}
    config = {"currents": gridded, "temperature_c": [{**gridded, "quantity": "temperature"}]}
    low, high = (-2500.0, -2500.0, -60.0), (2500.0, 2500.0, 0.0)
    world = SimpleNamespace(origin=ORIGIN, bounds=np.array([low, high]))
    return build_ocean(OceanConfig.model_validate(config), world)


def to_true(flow: Any, lat: Any, lon: Any) -> tuple[Any, Any]:
    """To east and north, from the world's x and y: meridians converge by atan(tan(dlon) sin(lat)) (Snyder, 8-9)."""
    angle = np.arctan(np.tan(np.radians(lon - ORIGIN.longitude)) * np.sin(np.radians(lat)))
    c, s = np.cos(angle), np.sin(angle)
    return s * flow[0] - c * flow[1], c * flow[0] + s * flow[1]


def places() -> tuple[Any, ...]:
    rng = np.random.default_rng(4)
    x, y, depth = rng.uniform(-2400, 2400, 60), rng.uniform(-2400, 2400, 60), rng.uniform(1.0, 30.0, 60)
    lat, lon = ORIGIN.to_latlon(x, y)
    position = jit.Array3f64(*(jit.Float64(v) for v in (x, y, -depth)))
    return position, lat, lon, -depth


@pytest.mark.parametrize("form", [1, 2])
def test_linear_fields_come_back(tmp_path: Path, form: int) -> None:
    """Linear in place, depth and time: interpolation leaves nothing but rounding of the depths to a millimetre (3e-6
    m/s) and the ground's own curvature on the levels (none: it slopes evenly).
    """
    sea = build(roms(form), tmp_path / "roms.nc")
    position, lat, lon, z = places()
    for hour in (0.0, 3.0, 6.0):
        flow = np.array(sea.current(position, dr.opaque(jit.Float64, 3600 * hour)))  # one kernel for all hours
        to_east, to_north = to_true(flow, lat, lon)
        assert to_east == pytest.approx(east(lat, lon, z, hour), abs=2e-5)
        assert to_north == pytest.approx(north(lat, lon, z, hour), abs=2e-5)
    assert np.array(sea.temperature(position, jit.Float64(0.0))) == pytest.approx(20 + 0.2 * z, abs=1e-3)


def test_the_two_transforms_differ(tmp_path: Path) -> None:
    """Levels that are read with the wrong transform lie elsewhere, by more than the tolerance above: a check of the
    check.
    """
    data = roms(2)
    data["Vtransform"] = ((), 1)
    sea = build(data, tmp_path / "roms.nc")
    position, _, _, z = places()
    off = np.abs(np.array(sea.temperature(position, jit.Float64(0.0))) - (20 + 0.2 * z))
    assert off.max() > 0.05


def test_land_is_still(tmp_path: Path) -> None:
    data = roms()
    land = data.lon_u.values > 13.01
    data["u"] = data.u.where(~land[None, None])
    data["v"] = data.v.where(data.lon_v.values[None, None] <= 13.01)
    data.u.attrs = data.v.attrs = {"units": "meter second-1"}
    sea = build(data, tmp_path / "roms.nc")
    x, y = ORIGIN.to_xy(np.array([45.0]), np.array([13.025]))
    assert np.array(
        sea.current(jit.Array3f64(jit.Float64(x), jit.Float64(y), -5.0), jit.Float64(0.0))
    ) == pytest.approx(0.0, abs=1e-12)


def nemo() -> Any:
    """As NEMO writes it: nav_lat and nav_lon, depths in metres, velocities already to east and north."""
    lat, lon = lat_lon(*np.meshgrid(np.arange(17.0), np.arange(19.0), indexing="ij"))
    depth = np.array([0.5, 5.0, 15.0, 40.0])
    z = -depth[None, :, None, None]
    t = HOURS[:, None, None, None]
    full = ("time_counter", "deptht", "y", "x")
    return xarray.Dataset(
        {
            "uo": (full, np.broadcast_to(east(lat, lon, z, t), (2, 4, 17, 19)), {"units": "m/s"}),
            "vo": (full, np.broadcast_to(north(lat, lon, z, t), (2, 4, 17, 19)), {"units": "m/s"}),
            "temp": (full, np.broadcast_to(20 + 0.2 * z + 0 * t + 0 * lat, (2, 4, 17, 19)), {"units": "degC"}),
            "nav_lat": (("y", "x"), lat, {"units": "degrees_north"}),
            "nav_lon": (("y", "x"), lon, {"units": "degrees_east"}),
        },
        coords={
            "time_counter": ("time_counter", HOURS, {"units": "hours since 2024-05-01"}),
            "deptht": ("deptht", depth, {"units": "m", "positive": "down"}),
        },
    )


@pytest.mark.parametrize(
    ("order", "of_places", "backwards"),
    [
        (("time_counter", "deptht", "y", "x"), ("y", "x"), ()),
        (("deptht", "time_counter", "y", "x"), ("x", "y"), ("deptht",)),
        (("x", "deptht", "time_counter", "y"), ("y", "x"), ("time_counter",)),
        (("y", "time_counter", "x", "deptht"), ("y", "x"), ("y", "deptht", "time_counter")),
    ],
)
def test_turned_grid_on_depth_levels(
    tmp_path: Path, order: tuple[str, ...], of_places: tuple[str, ...], backwards: tuple[str, ...]
) -> None:
    """Dimensions in any order, and those that fall."""
    data = nemo().isel({name: slice(None, None, -1) for name in backwards})
    for name, dimensions in (
        *((v, order) for v in ("uo", "vo", "temp")),
        ("nav_lat", of_places),
        ("nav_lon", of_places),
    ):
        data[name] = data[name].transpose(*dimensions)
    sea = build(data, tmp_path / "nemo.nc")
    position, lat, lon, z = places()
    flow = np.array(sea.current(position, jit.Float64(3 * 3600.0)))
    to_east, to_north = to_true(flow, lat, lon)
    assert to_east == pytest.approx(east(lat, lon, z, 3.0), abs=2e-6)  # meridians turn by 2e-4 in a cell
    assert to_north == pytest.approx(north(lat, lon, z, 3.0), abs=2e-6)


def test_soundings_and_levels_in_any_order(tmp_path: Path) -> None:
    """ROMS with levels before times, and with everything that has places turned over."""
    data = roms()
    for name in ("u", "v", "temp"):
        data[name] = data[name].transpose("s_rho", "ocean_time", ...)
    data["h"], data["zeta"] = data.h.T, data.zeta.transpose("xi_rho", "ocean_time", "eta_rho")
    data["angle"] = data.angle.T
    sea = build(data, tmp_path / "roms.nc")
    position, lat, lon, z = places()
    to_east, to_north = to_true(np.array(sea.current(position, jit.Float64(3 * 3600.0))), lat, lon)
    assert to_east == pytest.approx(east(lat, lon, z, 3.0), abs=2e-5)
    assert to_north == pytest.approx(north(lat, lon, z, 3.0), abs=2e-5)


def test_velocities_along_a_turned_grid_need_its_angle(tmp_path: Path) -> None:
    with pytest.raises(
        ScenarioError, match=r"'u' and 'v' are along the axes .* turned by up to 25.* lacks its 'angle'"
    ):
        build(roms().drop_vars("angle"), tmp_path / "roms.nc")


@pytest.mark.parametrize("change", ["no time", "surface", "upwards", "angle"])
def test_turned_grids_told_otherwise(tmp_path: Path, change: str) -> None:
    """The same water; an `angle` turns no velocity that goes to east and north already."""
    data, hour, levels = nemo(), 3.0, True
    if change == "no time":
        data, hour = data.isel(time_counter=1, drop=True), 6.0
    elif change == "surface":
        data, levels = data.isel(deptht=1, drop=True), False
    elif change == "upwards":
        data = data.assign_coords(deptht=("deptht", -data.deptht.values, {"units": "m"}))
    else:
        data["angle"] = (("y", "x"), np.full((17, 19), TURN), {"units": "radians"})
        data.uo.attrs["standard_name"] = "eastward_sea_water_velocity"
        data.vo.attrs["standard_name"] = "northward_sea_water_velocity"
    sea = build(data, tmp_path / "nemo.nc")
    position, lat, lon, z = places()
    to_east, to_north = to_true(np.array(sea.current(position, jit.Float64(hour * 3600))), lat, lon)
    z = z if levels else np.full(len(lat), -5.0)
    assert to_east == pytest.approx(east(lat, lon, z, hour), abs=2e-6)
    assert to_north == pytest.approx(north(lat, lon, z, hour), abs=2e-6)


def test_a_surface_that_does_not_change_in_time(tmp_path: Path) -> None:
    data = roms(zeta=0.8)
    data["zeta"] = data.zeta.isel(ocean_time=0)
    position, _, _, z = places()
    warmth = np.array(build(data, tmp_path / "roms.nc").temperature(position, jit.Float64(7200.0)))
    assert warmth == pytest.approx(20 + 0.2 * z, abs=1e-3)


@pytest.mark.parametrize(("change", "message"), [
    ("gap", r"'nav_lat' or 'nav_lon' has gaps"),
    ("gap in longitude", r"'nav_lat' or 'nav_lon' has gaps"),
    ("one place", "the points of 'uo' coincide"),
    ("empty", "'vo' has no value in the world's window"),
    ("two levels", r"cannot tell what the dimensions \['deptht', 'member'\] of 'uo' are"),
    ("no depths", "the dimension 'deptht' has no coordinate values; depths in metres are needed"),
    ("times again", "time does not increase"),
    ("depths again", "the depths of 'deptht' neither increase nor decrease from entry to entry"),
    ("pressure", r"depths of 'deptht' must be in metres \(units: m\), not in 'dbar'"),
    ("no unit", r"depths of 'deptht' must be in metres \(units: m\), not without units"),
])  # fmt: skip
def test_turned_grids_that_cannot_be_read_are_refused(tmp_path: Path, change: str, message: str) -> None:
    data = nemo()
    if change == "gap":
        data.nav_lat.values[3, 4] = np.nan
    elif change == "gap in longitude":
        data.nav_lon.values[3, 4] = np.nan
    elif change == "one place":
        data.nav_lat.values[:], data.nav_lon.values[:] = 45.0, 13.0
    elif change == "empty":
        data["vo"] = (data.vo * np.nan).assign_attrs(units="m/s")
    elif change == "two levels":
        data["uo"] = data.uo.expand_dims(member=2, axis=2).assign_attrs(units="m/s")
    elif change == "no depths":
        data = data.drop_vars("deptht")
    elif change == "times again":
        data = data.isel(time_counter=[1, 1])
    elif change == "depths again":
        data = data.assign_coords(deptht=("deptht", np.array([0.5, 5.0, 5.0, 40.0]), {"units": "m"}))
    else:
        units = {"units": "dbar"} if change == "pressure" else {}
        data = data.assign_coords(deptht=("deptht", data.deptht.values, units))
    with pytest.raises(ScenarioError, match=rf"nemo\.nc: .*{message}"):
        build(data, tmp_path / "nemo.nc")


@pytest.mark.parametrize(
    ("gone", "message"),
    [
        (["h"], "'h', which the file lacks"),
        (["Cs_r", "hc"], "need Cs_r, hc, which the file lacks"),
        (["lat_u"], r"'u' has no latitude and longitude over \(eta_u, xi_u\)"),
        (["Vtransform"], "Vtransform"),
    ],
)
def test_what_is_missing_is_named(tmp_path: Path, gone: list[str], message: str) -> None:
    data = roms().drop_vars(gone)
    data.s_rho.attrs = {}
    with pytest.raises(ScenarioError, match=message):
        build(data, tmp_path / "roms.nc")


def test_a_world_beside_the_grid(tmp_path: Path) -> None:
    """A rectangle that the turned grid does not fill is not covered, even where latitude and longitude are."""
    data = roms()
    data.to_netcdf(tmp_path / "roms.nc")
    config = OceanConfig.model_validate({"currents": {"type": "gridded", "file": str(tmp_path / "roms.nc")}})
    far = SimpleNamespace(origin=ORIGIN, bounds=np.array([[-9000.0, -9000, -60], [9000.0, 9000, 0]]))
    with pytest.raises(ScenarioError, match="covers"):
        build_ocean(config, far)
    away = SimpleNamespace(origin=GeoOrigin(50.0, 13.0), bounds=np.array([[-100.0, -100, -60], [100.0, 100, 0]]))
    with pytest.raises(ScenarioError, match="the world is not there"):
        build_ocean(config, away)
