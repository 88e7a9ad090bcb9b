"""The ocean: sums of waves at points, on a patch and on a hull, and a fleet in a gridded current."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import BenchError, must
from pelagos.bench.timing import seconds
from pelagos.jit import Array
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.hull_load import Hull, hull_load, make_hull
from pelagos.ocean.ocean import Ocean
from pelagos.ocean.waves import patch
from pelagos.sim.driver import Driver
from pelagos.sim.simulation import Simulation
from pelagos.vehicles.vehicle import Vehicle

COMPONENTS: Final = 200
POINTS: Final = 1000
FLEET: Final = 4096
TICKS: Final = 20
_ORIGIN: Final = GeoOrigin(45.0, 13.0)


@cache
def _sea() -> Ocean:
    """Sea state 4 of 200 components."""
    waves = {"type": "sea_state", "state": 4, "components_count": COMPONENTS}
    return build_ocean(OceanConfig.model_validate({"waves": waves}))


def _numpy_sum(table: np.ndarray, x: np.ndarray, y: np.ndarray, t: float) -> np.ndarray:
    """The same sum in NumPy: what one would write first."""
    turns = np.outer(x, table[:, 0]) + np.outer(y, table[:, 1]) + (table[:, 3] - table[:, 2] * t)
    total: np.ndarray = np.cos(2 * np.pi * turns) @ table[:, 4]
    return total


def waves_200x1000_ms() -> Measured:
    """Elevation of 200 components at 1000 points, to NumPy."""
    waves = _sea().waves
    if waves is None:
        raise BenchError("the sea has no waves")
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-500, 500, (2, POINTS))
    places = jit.Float64(x), jit.Float64(y)
    dr.make_opaque(*places)
    frozen = jit.freeze(lambda w, a, b, t: w.elevation(a, b, t))

    def ours(t: float = 7.0) -> np.ndarray:
        found: np.ndarray = frozen(waves, *places, dr.opaque(jit.Float64, t)).numpy()
        return found

    table = waves.table.numpy().reshape(-1, 8)
    error = float(np.abs(ours() - _numpy_sum(table, x, y, 7.0)).max())
    must(error < 1e-9, "the sum differs from NumPy's")
    must(float(np.abs(ours(8.0) - ours()).max()) > 0.01, "the sea stands still")
    limit = Reference("the same sum in NumPy, same run", 1e3 * seconds(lambda: _numpy_sum(table, x, y, 7.0)))
    return Measured(1e3 * seconds(ours), limit, f"at most {error:.1g} m from NumPy's sum")


def wave_patch_256_ms() -> Measured:
    """Elevation of 200 components on 256 x 256 points."""
    waves = _sea().waves
    if waves is None:
        raise BenchError("the sea has no waves")
    table, line = waves.table.numpy().reshape(-1, 8), np.linspace(-64, 64, 256)
    surface = patch(table, line, line, 7.0)
    direct = _numpy_sum(table, np.full(256, line[9]), line, 7.0)
    must(float(np.abs(surface[9] - direct).max()) < 1e-9, "the patch differs from the sum")
    return Measured(1e3 * seconds(lambda: patch(table, line, line, 7.0)), detail=f"Hs {4 * surface.std():.2f} m")


@cache
def _hull() -> Hull:
    """A boat-like ellipsoid of 1920 triangles."""
    import trimesh

    sphere = trimesh.creation.uv_sphere(count=[32, 16])
    return make_hull(np.asarray(sphere.vertices) * [2.5, 0.6, 0.4], np.asarray(sphere.faces))


def hull_2000_in_waves_ms() -> Measured:
    """Pressure of 200 components on a hull that is clipped at their surface, to NumPy."""

    def load(ocean: Ocean, hull: Hull, p: Array, q: Array, t: Array) -> Array:
        force, moment = hull_load(ocean, hull, p, q, t)
        return dr.ravel(jit.ArrayXf64([*force, *moment]))

    frozen = jit.freeze(load)
    attitude = dr.opaque(jit.Array4f64, [1.0, 0.0, 0.0, 0.0])

    def ours(z: float = -0.05, t: float = 7.0) -> np.ndarray:
        place = dr.opaque(jit.Array3f64, [0.0, 0.0, z])
        found: np.ndarray = frozen(_sea(), _hull(), place, attitude, dr.opaque(jit.Float64, t)).numpy()
        return found

    weight = ours(-30.0)[2] / (1026.7 * 9.81)
    must(abs(weight / (4 / 3 * np.pi * 2.5 * 0.6 * 0.4) - 1) < 0.03, "a deep hull does not displace its volume")
    must(abs(ours(t=8.0)[2] / ours()[2] - 1) > 1e-3, "the waves do not move the hull")
    return Measured(1e3 * seconds(ours), detail=f"{dr.width(_hull().a)} triangles, {COMPONENTS} components")


def _gyre(folder: Path) -> Path:
    """A synthetic circulation, 3 x 8 x 40 x 40 values, as CMEMS writes it."""
    import xarray

    lat, lon = np.linspace(44.9, 45.1, 40), np.linspace(12.85, 13.15, 40)
    depth, hours = np.geomspace(1, 60, 8), np.array([0.0, 6.0, 12.0])
    t, z, la, lo = np.meshgrid(hours, depth, (lat - 45) / 0.1, (lon - 13) / 0.15, indexing="ij")
    fade = 0.3 * np.exp(-z / 40) * (1 + 0.02 * t)
    east = fade * np.sin(np.pi * la) * np.cos(0.5 * np.pi * lo)
    north = -fade * np.sin(np.pi * lo) * np.cos(0.5 * np.pi * la)
    axes = ("time", "depth", "latitude", "longitude")
    data = xarray.Dataset(
        {"uo": (axes, east, {"units": "m s-1"}), "vo": (axes, north, {"units": "m s-1"})},
        coords={
            "time": ("time", hours, {"units": "hours since 2024-05-01"}),
            "depth": ("depth", depth, {"units": "m", "positive": "down"}),
            "latitude": ("latitude", lat, {"units": "degrees_north"}),
            "longitude": ("longitude", lon, {"units": "degrees_east"}),
        },
    )
    data.to_netcdf(folder / "gyre.nc")
    return folder / "gyre.nc"


def remus_4096_gridded_msteps() -> Measured:
    """Steps of 4096 REMUS 100 in a current from NetCDF."""
    world: Any = SimpleNamespace(origin=_ORIGIN)
    with tempfile.TemporaryDirectory() as folder:
        current = {"type": "gridded", "file": str(_gyre(Path(folder)))}
        ocean = build_ocean(OceanConfig.model_validate({"currents": current}), world)
    vehicle = Vehicle.from_catalogue("remus100")
    driver = Driver(vehicle, n=FLEET, dt_ns=20_000_000)
    rng = np.random.default_rng(2)
    place = rng.uniform((-5000, -5000, -40), (5000, 5000, -5), (FLEET, 3))
    level = np.tile([1.0, 0.0, 0.0, 0.0], (FLEET, 1))
    state = driver.pack(vehicle.initial_state(position=place, attitude=level))
    mode = vehicle.default_mode
    command = [dr.full(jit.Float64, 0.0, FLEET) for _ in vehicle.command_names(mode)]
    dr.make_opaque(command)
    before = driver.unpack(state).velocity.numpy()

    def block() -> None:
        nonlocal state
        state, _ = driver.advance(state, command, ocean, mode=mode, tick=0, ticks=TICKS)
        dr.eval(state)
        dr.sync_thread()

    took = seconds(block, at_least_s=2.0)
    after = driver.unpack(state).velocity.numpy()
    must(bool(np.isfinite(after).all()), "a vehicle's velocity is not finite")
    must(float(np.abs(after - before).max()) > 0.01, "the current moves no vehicle")
    return Measured(FLEET * TICKS / took * 1e-6, detail=f"{FLEET} vehicles, {TICKS} steps a call, {mode}")


def wamv_ss4_rtf() -> Measured:
    """A WAM-V in sea state 4, pressure on its wet hulls, 200 Hz."""
    model = {
        "tick_rate_hz": 200,
        "world": {"type": "flat", "depth_m": 200.0},
        "ocean": {"waves": {"type": "sea_state", "state": 4, "components_count": COMPONENTS}},
        "agents": {"usv": {"vehicle": "wamv", "control": "actuators", "start": {"position_m": [0, 0], "depth_m": 0}}},
    }
    sim = Simulation.load(model)
    sim.run(1.0)
    heights: list[float] = []

    def ten_seconds() -> None:
        sim.run(10.0)
        heights.append(float(sim.state["usv"].position[0, 2]))

    took = seconds(ten_seconds, at_least_s=2.0)
    must(max(abs(h) for h in heights) < 3.0, "the vessel does not float")
    must(float(np.ptp(heights)) > 0.05, "the vessel does not move with the sea")
    return Measured(10.0 / took, detail=f"{COMPONENTS} components, buoyancy and Froude-Krylov on 312 triangles")


CASES: Final = (
    Case(
        name="wamv_ss4_rtf",
        title="WAM-V in sea state 4 at 200 Hz: pressure on the wet hull, diffraction, radiation with memory",
        measure=wamv_ss4_rtf,
        unit="x real time",
        goal=30.0,
        better="higher",
        reference=Reference("none"),
    ),
    Case(
        name="waves_200x1000_ms",
        title="Elevation of 200 wave components at 1000 points, to NumPy",
        measure=waves_200x1000_ms,
        unit="ms",
        goal=0.2,
        better="lower",
        reference=Reference("the same sum in NumPy, same run"),
    ),
    Case(
        name="wave_patch_256_ms",
        title="Elevation of 200 wave components on 256 x 256 points",
        measure=wave_patch_256_ms,
        unit="ms",
        goal=10.0,
        better="lower",
        reference=Reference("none"),
    ),
    Case(
        name="hull_2000_in_waves_ms",
        title="Pressure of 200 wave components on a clipped hull of 2000 triangles, to NumPy",
        measure=hull_2000_in_waves_ms,
        unit="ms",
        goal=0.5,
        better="lower",
        reference=Reference("none"),
    ),
    Case(
        name="remus_4096_gridded_msteps",
        title="4096 REMUS 100 in a current from NetCDF, whole control and step",
        measure=remus_4096_gridded_msteps,
        unit="M vehicle-steps/s",
        goal=10.0,
        better="higher",
        reference=Reference("none"),
    ),
)
