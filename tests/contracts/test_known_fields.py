"""Fields of the sea from files, as ocean models write them: grids askew, in many units and orders, with land in them.

No grid is regular, no field symmetric in place, depth or time; points of curved grids lie so that no four of them are
on a circle, and triangles are the same everywhere.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from known import DOUBLE, check
from pelagos import jit
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.biology import patches, plankton_column, step_column
from pelagos.ocean.config import OceanConfig, build_ocean, check_files
from pelagos.ocean.grid_data import Windows
from pelagos.ocean.hull_load import hull_load, make_hull
from pelagos.ocean.netcdf import read_grid
from pelagos.ocean.site import Site
from pelagos.ocean.sky import SunConfig
from pelagos.ocean.waves import patch

xarray = pytest.importorskip("xarray")
pytest.importorskip("netCDF4")

ORIGIN = GeoOrigin(45.0, 13.0)
HOURS, DEPTHS = np.array([0.0, 5.0, 12.0]), np.array([0.5, 6.0, 23.0, 61.0])
LAT = 44.93 + np.array([0.0, 0.013, 0.031, 0.049, 0.063, 0.081, 0.112, 0.128, 0.151])
LON = 12.86 + np.array([0.0, 0.021, 0.044, 0.057, 0.093, 0.118, 0.141, 0.169, 0.203, 0.231, 0.262])
WANTED = [("east", None), ("north", None), ("temperature", None), ("salinity", None)]
UNITS = {"u": "m s-1", "v": "m s-1", "w": "m s-1", "temp": "degC", "salt": "1"}


def flow(name: str, hour: Any, depth: Any, lat: Any, lon: Any) -> Any:
    """Unlike in every direction, and never linear."""
    k = list(UNITS).index(name)
    size, mean = ([0.4, 0.3, 0.02, 3.0, 1.5][k], [0.1, -0.2, 0.003, 14.0, 34.0][k])
    turn = 31 * (lat - 45) * (1 + 0.2 * k) + 17 * (lon - 13) + 0.02 * depth + 0.11 * hour + k
    return mean + size * np.sin(turn) * np.exp(-depth / (40.0 + 7 * k)) + 0.1 * size * (lon - 13) ** 2 * hour


def latlon(lat: Any = LAT, lon: Any = LON, hours: Any = HOURS, depths: Any = DEPTHS) -> Any:
    """Axes in degrees."""
    axes = np.meshgrid(hours, depths, lat, lon, indexing="ij")
    dims = ("time", "depth", "lat", "lon")
    return xarray.Dataset(
        {name: (dims, flow(name, *axes), {"units": unit}) for name, unit in UNITS.items()},
        coords={
            "time": ("time", hours, {"units": "hours since 2024-05-01", "calendar": "standard"}),
            "depth": ("depth", depths, {"units": "m", "positive": "down"}),
            "lat": ("lat", lat, {"units": "degrees_north"}), "lon": ("lon", lon, {"units": "degrees_east"}),
        },
    )  # fmt: skip


def backwards(data: Any) -> Any:
    """Rows from the north, depths from below and negative, dimensions in another order, units of others."""
    data = data.isel(lat=slice(None, None, -1), depth=slice(None, None, -1)).transpose("lon", "time", "lat", "depth")
    data = data.assign_coords(depth=("depth", -data.depth.values, {"units": "metres"}))
    changed = {"u": (100.0, 0.0, "cm/s"), "v": (1.0, 0.0, "m/s"), "temp": (1.0, 273.15, "K")}
    for name, (factor, offset, unit) in changed.items():
        data[name] = (data[name] * factor + offset).assign_attrs(units=unit)
    return data


def with_land(data: Any) -> Any:
    dry = (data.lat > 45.02) & (data.lon < 12.95)
    deep = (data.depth > 20.0) & (data.lon > 13.04)
    for name in UNITS:
        data[name] = data[name].where(~dry & ~deep).assign_attrs(data[name].attrs)
    return data


def around_the_world(data: Any) -> Any:
    """Longitudes from 0 to 360, every 10 degrees, that run past the far side of the place."""
    whole = latlon(lon=np.arange(0.0, 360.0, 10.0) + 0.5 * np.sin(np.arange(36)))
    return whole.assign_attrs(data.attrs)


def in_metres(data: Any) -> Any:
    x = 900.0 * np.array([-4.1, -2.7, -1.2, 0.1, 1.3, 2.2, 3.9, 5.0])
    y = 700.0 * np.array([-5.3, -3.1, -1.9, 0.4, 1.7, 3.6, 6.1])
    data = latlon(45 + y / 2e4, 13 + x / 2e4).rename(lat="y", lon="x")
    return data.assign_coords(y=("y", y, {"units": "m"}), x=("x", x, {"units": "m"}))


def of_the_surface(data: Any) -> Any:
    """One moment and one level, and no axis for either."""
    return data.isel(time=1, depth=2).drop_vars(("time", "depth"))


def potential(data: Any) -> Any:
    data["temp"] = data.temp.assign_attrs(standard_name="sea_water_potential_temperature")
    return data.assign_coords(depth=("depth", 30 * DEPTHS, {"units": "m"}))


REGULAR = {f.__name__.replace("_", " "): f for f in (backwards, with_land, around_the_world, in_metres, of_the_surface,
                                                     potential)}  # fmt: skip
NEAR = Windows(13.0, (44.965, 45.031, 12.93, 13.02), (-1900.0, 1400.0, -1100.0, 2100.0))


def arrays(data: Any) -> dict[str, Any]:
    parts = {f"values {k}": v for k, v in enumerate(data.values)}
    axes = {name: getattr(data, name) for name in ("time", "depth", "row", "column")}
    return parts | axes | {"rest": [data.metric, data.filled, *data.covers], "size": data.values.shape}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("case", REGULAR)
def test_grids_that_are_read(case: str, tmp_path: Path) -> None:
    path = tmp_path / "sea.nc"
    REGULAR[case](latlon()).to_netcdf(path)
    start = None if case == "of the surface" else "2024-05-01T03:00:00Z"
    up = [("up", "w")] if case != "potential" else []
    far = Windows(193.0, None, None) if case == "around the world" else Windows(13.0, None, None)
    found = {f"{where} {part}": values for where, windows, wanted in (("all", far, [*WANTED, *up]), ("near", NEAR,
             WANTED[:3])) for part, values in arrays(read_grid(path, wanted, start=start,
                 windows=windows)).items()}  # fmt: skip
    check("fields", case, found, DOUBLE)


S = (np.arange(7) + 0.3) / 7 - 1
FACES = np.linspace(-1.0, 0.0, 8)


def bent(j: Any, i: Any) -> tuple[Any, Any]:
    """Latitude and longitude of fractional rows and columns of a grid that is turned, sheared and curved."""
    j, i = np.asarray(j, dtype=float), np.asarray(i, dtype=float)
    y, x = (
        0.011 * (j - 5.2) + 0.0013 * np.sin(1.3 * i + 0.4 * j),
        0.013 * (i - 6.1) + 0.0021 * np.cos(0.9 * j - 0.3 * i),
    )
    return 45.0 + 0.4 * x + 0.9 * y, 13.0 + 1.3 * x - 0.5 * y + 0.8 * x * y


def stretched(levels: Any) -> Any:
    return (1 - np.cosh(3 * levels)) / (np.cosh(3.0) - 1)


def roms(kind: str) -> Any:
    """Velocities on their own points along a turned grid, on levels that follow ground and surface."""
    rows, columns = 11, 13
    level, values = {"faces": ("s_w", FACES), "sigma": ("sigma", S), "first": ("sc_r", S)}.get(kind, ("s_rho", S))
    form = 1 if kind == "first" else 2
    variables: dict[str, Any] = {}
    for grid, (dj, di, nj, ni) in {
        "rho": (0.0, 0.0, rows, columns), "u": (0.0, 0.5, rows, columns - 1), "v": (0.5, 0.0, rows - 1, columns),
    }.items():  # fmt: skip
        lat, lon = bent(*np.meshgrid(np.arange(nj) + dj, np.arange(ni) + di, indexing="ij"))
        plane = (f"eta_{grid}", f"xi_{grid}")
        variables[f"lat_{grid}"] = (plane, lat, {"units": "degree_north", "standard_name": "latitude"})
        variables[f"lon_{grid}"] = (plane, lon, {"units": "degree_east", "standard_name": "longitude"})
        h = 40.0 + 200 * (lat - 45) + 90 * (lon - 13)
        axes = np.meshgrid(HOURS, -values * 40.0, np.arange(nj), np.arange(ni), indexing="ij")
        for name in {"rho": ("temp", "salt"), "u": ("u",), "v": ("v",)}[grid]:
            field = flow(name, axes[0], axes[1], np.broadcast_to(lat, axes[0].shape), lon)
            field = np.where(lon > 13.09, np.nan, field)
            variables[name] = (("ocean_time", level, *plane), field, {"units": UNITS[name]})
        if grid == "rho":
            surface = 0.3 * np.sin(9 * lat + HOURS[:, None, None]) + 2 * (lon - 13)
            turn = 20.0 + 90 * (lat - 45)
            units = {"units": "degrees"} if kind == "first" else {}
            variables["angle"] = (plane, turn if kind == "first" else np.radians(turn), units)
            variables |= {"h": (plane, h), "zeta": (("ocean_time", *plane), surface)}
    stretching = "Cs_w" if level == "s_w" else "Cs_r"
    variables |= {stretching: (level, stretched(values)), "hc": ((), 7.0)}
    said = {"standard_name": f"ocean_s_coordinate_g{form}"} if level != "sigma" else {}
    times = ("ocean_time", HOURS * 3600, {"units": "seconds since 2024-05-01 00:00:00"})
    return xarray.Dataset(variables, coords={"ocean_time": times, level: (level, values, said)})


def nemo() -> Any:
    """True east and north on ordinary levels of a curved grid."""
    lat, lon = bent(*np.meshgrid(np.arange(11), np.arange(13), indexing="ij"))
    axes = np.meshgrid(HOURS, DEPTHS, np.arange(11), np.arange(13), indexing="ij")
    dims = ("time_counter", "deptht", "y", "x")
    names = {"u": "uo", "v": "vo", "temp": "thetao", "salt": "so"}
    fields = {
        o: (dims, flow(k, axes[0], axes[1], np.broadcast_to(lat, axes[0].shape), lon), {"units": UNITS[k]})
        for k, o in names.items()
    }
    return xarray.Dataset(
        fields | {"nav_lat": (("y", "x"), lat), "nav_lon": (("y", "x"), lon)},
        coords={"time_counter": ("time_counter", HOURS, {"units": "hours since 2024-05-01"}),
                "deptht": ("deptht", -DEPTHS, {"units": "m", "positive": "up"})},
    )  # fmt: skip


@pytest.mark.parametrize("case", ["first", "second", "faces", "sigma", "nemo"])
def test_curved_grids_that_are_read(case: str, tmp_path: Path) -> None:
    path = tmp_path / "sea.nc"
    (nemo() if case == "nemo" else roms(case)).to_netcdf(path)
    windows = {"near": Windows(13.0, (44.99, 45.02, 12.96, 13.04), None)}
    if case in ("first", "nemo"):
        windows["all"] = Windows(13.0, None, None)
    found = {f"{where} {part}": values for where, windows in windows.items()
             for part, values in arrays(read_grid(path, WANTED, start="2024-05-01T04:00",
                 windows=windows)).items()}  # fmt: skip
    check("fields", f"curved {case}", found, DOUBLE)


def test_fields_in_an_ocean(tmp_path: Path) -> None:
    """A flow of three components and a temperature at places within and beyond, and times of both."""
    path = tmp_path / "sea.nc"
    latlon().to_netcdf(path)
    low, high = (-7200.0, -8700.0, -60.0), (7300.0, 9900.0, 0.0)
    world: Any = SimpleNamespace(origin=ORIGIN, bounds=np.array([low, high]))
    rng = np.random.default_rng(6)
    place = jit.Array3f64(*(jit.Float64(v) for v in rng.uniform(-1, 1, (3, 60)) * [[21e3], [17e3], [40.0]]))
    t = jit.Float64(rng.uniform(0, 50e3, 60))
    found: dict[str, Any] = {}
    for outside in ("clamp", "fade", "error"):
        gridded = {"type": "gridded", "file": str(path), "outside": outside, "start": "2024-05-01T02:30"}
        sea = {"currents": {**gridded, "up_variable": "w"}, "temperature_c": [{**gridded, "quantity": "temperature"}],
               "salinity": [{**gridded, "quantity": "salinity"}], "tracers": {"dye": [{**gridded,
               "quantity": "w"}]}}  # fmt: skip
        config = OceanConfig.model_validate(sea)
        check_files(config, Site(ORIGIN, (low, high)))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            ocean = build_ocean(config, world)
        found |= {
            f"{outside} flow": ocean.current(place, t), f"{outside} temperature": ocean.temperature(place, t),
            f"{outside} density": ocean.density(place, t), f"{outside} dye": ocean.tracer("dye", place, t),
        }  # fmt: skip
        if outside == "error":
            found["beyond"] = np.array(ocean.grids[0][1].beyond(place, t))
            far = jit.Array3f64(19e3, 0.0, -3.0)
            found["uncovered"] = [len(ocean.uncovered(far, jit.Float64(0.0))), len(ocean.grids)]
    check("fields", "in an ocean", {name: np.array(v) for name, v in found.items()}, DOUBLE)


def test_life_in_columns() -> None:
    depth = np.linspace(-3.0, 290.0, 41)
    own = {"surface": 0.7, "peak": 2.1, "peak_m": 37.0, "width_m": 19.0, "photic_m": 140.0, "sharpness_m": 13.0,
           "deep": 0.05}  # fmt: skip
    clusters = [
        {"position": [13.0, -8.0, -7.0], "strength": 1.7, "falloff": 6.0},
        {"position": [-3.0, 5.0, -2.0], "strength": -0.4}, {"position": [0, 1, 0], "strength": 3.0, "falloff": 0.0},
    ]  # fmt: skip
    at = np.random.default_rng(2).uniform(-20, 20, (5, 8, 3))
    found = {
        "usual": plankton_column(depth), "own": plankton_column(depth, **own), "patches": patches(at, clusters),
        "step": step_column(depth, surface=36.1, deep=34.2, middle_m=41.0, thickness_m=-7.0),
    }  # fmt: skip
    check("fields", "life", found, DOUBLE)


@pytest.mark.parametrize("sea", ["waves", "still"])
def test_the_load_of_a_sea_on_a_hull(sea: str) -> None:
    waves = {"type": "regular", "height_m": 0.9, "period_s": 4.3, "towards_deg": 115.0, "phase_deg": 40.0}
    more: dict[str, Any] = {"waves": [waves]} if sea == "waves" else {}
    tide = {"period_h": 5.0, "amplitude_m": 0.8, "phase_deg": 40.0}
    ocean = build_ocean(OceanConfig.model_validate({"tide": [tide], "salinity": 31.0, **more}))
    corners = np.array([[3.1, 0.9, 0.4], [-2.7, 1.3, 0.7], [-2.2, -0.8, 0.6], [2.6, -1.1, 0.5], [0.4, 0.1, -0.9]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]])
    hull = make_hull(corners, faces)
    loads = []
    for place in ([13.0, -8.0, -0.1], [4.0, 9.0, 0.4], [4.0, 9.0, -3.0]):
        position, attitude = (
            dr.opaque(t, v) for t, v in ((jit.Array3f64, place), (jit.Array4f64, [0.31, -0.22, 0.4, 0.84]))
        )
        loads.append([np.ravel(v) for v in hull_load(ocean, hull, position, attitude, dr.opaque(jit.Float64, 2.7))])
    check("fields", f"a hull, {sea}", {str(k): np.concatenate(v) for k, v in enumerate(loads)}, DOUBLE)


@pytest.mark.parametrize("depth", [None, 17.0])
def test_sharp_crests_drift_and_foam(depth: float | None) -> None:
    """A sea and a swell, deep and shallow, asked for everything at places of both signs."""
    systems = [
        {"type": "jonswap", "significant_height_m": 1.1, "peak_period_s": 5.1, "towards_deg": 40.0, "spreading": 7.0,
         "components_count": 21, "gamma": 2.2},
        {"type": "regular", "height_m": 0.5, "period_s": 8.0, "towards_deg": -110.0, "phase_deg": 65.0},
    ]  # fmt: skip
    tide = {"period_h": 5.0, "amplitude_m": 0.8, "phase_deg": 40.0}
    config = OceanConfig.model_validate(
        {"waves": systems, "waves_depth_m": depth, "tide": [tide], "wind": {"speed_mps": 11.0}}
    )
    ocean = build_ocean(config, seed=4)
    waves: Any = ocean.waves
    rng = np.random.default_rng(7)
    x, y, t = (jit.Float64(v) for v in rng.uniform(-60, 60, (3, 40)))
    z = jit.Float64(rng.uniform(-9, 1.5, 40))
    place = jit.Array3f64(x, y, z)
    sharp, still = waves.surface_point(x, y, t, choppiness=0.7), ocean.wave_motion(place, t, stretch=False)
    motion: Any = ocean.wave_motion(place, t)
    slender: Any = ocean.waves_along((x, y, z), tuple(jit.Float64(v) for v in (0.64, -0.48, 0.6)), 3.3, t)
    found = {
        "sharp": [np.array(v) for v in vars(sharp).values() if np.shape(np.array(v)) == (3, 40)],
        "drift": waves.drift(z),
        "pressure": ocean.pressure(place, t), "slope": np.array(waves.slope(x, y, t)), "foam": ocean.foam(x, y, t),
        "height": ocean.elevation(x, y, t), "flow": motion.velocity, "gain": motion.acceleration,
        "unstretched": None if still is None else still.velocity, "table": waves.table,
        "patch": patch(np.reshape(waves.table, (-1, 8)), np.linspace(-9, 14, 7), np.linspace(-20, 3, 5), 2.7),
        "along": [np.array(v) for v in vars(slender).values() if np.shape(np.array(v)) == (3, 40)],
    }  # fmt: skip
    check("fields", f"waves {depth or 'deep'}", {name: np.array(v) for name, v in found.items()}, DOUBLE)


def test_where_the_sun_stands() -> None:
    found = []
    for time in ("2026-06-21T09:00:00Z", "2026-12-03T17:30:00+02:00", "2025-03-20T23:10:00-05:00"):
        for place in (GeoOrigin(44.3, 9.2), GeoOrigin(-33.0, 151.0), GeoOrigin(68.0, -21.0)):
            found.append(SunConfig.model_validate({"time": time}).angles(place))
    check("fields", "the sun", {"angles": found}, DOUBLE)
