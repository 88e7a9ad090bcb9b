"""Ground out of survey files of every format, askew, in feet, with holes; and large grounds made of them.

Soundings lie at random, so that no four of them are on a circle; where a hole is filled the ground is a plane, so that
it does not matter which triangles fill it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_known_contents import by_label

from known import DOUBLE, check
from pelagos.world.bathymetry.bathymetry import BathymetryConfig
from pelagos.world.bathymetry.survey import rising
from pelagos.world.build import build_world
from pelagos.world.large.large import LargeConfig
from pelagos.world.large.picture import pictured
from pelagos.world.large.stream import Stream

netcdf = pytest.importorskip("netCDF4")
rasterio = pytest.importorskip("rasterio")
laspy = pytest.importorskip("laspy")
pyproj = pytest.importorskip("pyproj")

ROWS, COLUMNS = np.arange(31)[:, None], np.arange(43)[None, :]
GROUND = -31 + 4 * np.sin(ROWS / 4) * np.exp(-COLUMNS / 30) + 0.11 * COLUMNS + 2 * np.cos(COLUMNS / 3.3 + ROWS / 9)
GROUND += np.random.default_rng(9).normal(0.0, 0.25, GROUND.shape)  # a spectrum that goes on
PLANE = -31 + 0.2 * ROWS - 0.13 * COLUMNS + 0.0
LAT, LON = 44.0 + 0.001 * np.arange(31), 13.0 + 0.0013 * np.arange(43)
UTM = "EPSG:32633"
FOOT = 0.3048


def to_netcdf(path: Path, variables: dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]) -> Path:
    with netcdf.Dataset(path, "w") as data:
        for name, (dims, values, attributes) in variables.items():
            for dim, count in zip(dims, np.shape(values), strict=True):
                if dim not in data.dimensions:
                    data.createDimension(dim, count)
            variable = data.createVariable(name, "f8", dims)
            variable.setncatts(attributes)
            variable[:] = values
    return path


def netcdf_from_the_north(t: Path) -> Any:
    z = np.stack([GROUND, GROUND - 7])[:, ::-1] / -FOOT
    axes = {"latitude": (("latitude",), LAT[::-1], {}), "longitude": (("longitude",), LON, {})}
    depth = (("time", "longitude", "latitude"), z.swapaxes(1, 2), {"units": "feet", "positive": "down"})
    other = (("latitude", "longitude"), 0 * GROUND, {})
    file = to_netcdf(t / "a.nc", {**axes, "other": other, "floor": depth})
    return {"path": file, "variable": "floor", "latitude_range_deg": (44.007, 44.021),
            "longitude_range_deg": (13.006, 13.041), "datum_offset_m": 0.7}  # fmt: skip


def netcdf_in_metres(t: Path) -> Any:
    mapping = ((), 0.0, {"crs_wkt": pyproj.CRS.from_epsg(32633).to_wkt()})
    axes = {"x": (("x",), 401e3 + 23.0 * np.arange(43), {}), "y": (("y",), 4.9e6 + 31.0 * np.arange(31), {})}
    z = (("y", "x"), GROUND, {"grid_mapping": "mapping"})
    return {"path": to_netcdf(t / "a.nc", {**axes, "mapping": mapping, "z": z}), "nodes": "survey"}


def netcdf_curved(t: Path) -> Any:
    rng = np.random.default_rng(7)
    lat = LAT[:, None] + 2e-4 * np.sin(COLUMNS / 5) + rng.uniform(0, 1e-4, GROUND.shape)
    lon = LON + 3e-4 * np.cos(ROWS / 4) + rng.uniform(0, 1e-4, GROUND.shape)
    z = (("b", "eta", "xi"), np.stack([-GROUND, GROUND]), {"long_name": "water depth"})
    both = {"lat_rho": (("eta", "xi"), lat, {}), "lon_rho": (("eta", "xi"), lon, {})}
    return {"path": to_netcdf(t / "a.nc", {**both, "m": z}), "resolution_m": 63.0}


def raster_of_two_bands(t: Path) -> Any:
    transform = rasterio.Affine(21.0, 0.0, 403e3, 0.0, -17.0, 4902e3)
    size = {"driver": "GTiff", "height": 31, "width": 43, "count": 2, "dtype": "int32", "crs": UTM}
    with rasterio.open(t / "a.tif", "w", **size, transform=transform) as raster:
        raster.write((GROUND * 0).astype(np.int32), 1)
        raster.write(((GROUND[::-1] + 50) * 100).astype(np.int32), 2)
        raster.set_band_description(2, "height")
        raster.scales, raster.offsets = (1.0, 0.01), (0.0, -50.0)
    middle = pyproj.Transformer.from_crs(UTM, "EPSG:4326").transform(403480.0, 4901730.0)
    return {"path": t / "a.tif", "variable": "height", "centre_deg": middle, "size_m": (310.0, 420.0),
            "resolution_m": 7.0, "detail": {"seed": 3, "strength": 1.3}}  # fmt: skip


def raster_in_text(t: Path) -> Any:
    head = "ncols 43\nnrows 31\nxllcorner 401000\nyllcorner 4900500\ncellsize 19\nNODATA_value -9999\n"
    holed = PLANE.copy()
    holed[11:14, 20:25] = holed[0:2, 0:3] = -9999
    (t / "a.asc").write_text(head + "\n".join(" ".join(f"{v:.5f}" for v in row) for row in holed[::-1]))
    return {"path": t / "a.asc", "crs": UTM, "resolution_m": 27.0}


def surfer(t: Path) -> Any:
    head = f"DSAA\n43 31\n400000 400840\n4900000 4900450\n{GROUND.min()} {GROUND.max()}\n"
    (t / "a.grd").write_text(head + "\n".join(" ".join(f"{v:.5f}" for v in row) for row in GROUND))
    return {"path": t / "a.grd", "crs": UTM, "nodes": "survey"}


def archive(t: Path) -> Any:
    np.savez(t / "a.npz", lat=LAT[::-1], lon=LON + 360.0, depth=-GROUND[::-1] / 1.8288, other=GROUND)
    return {"path": t / "a.npz", "variable": "depth", "unit": "fathom", "sign": "down", "centre_deg": (44.014, 13.022),
            "size_m": (900.0, 1700.0), "nodes": "survey"}  # fmt: skip


PLACES = np.random.default_rng(1).uniform(0, 1, (700, 2)) * [410.0, 290.0]
HEIGHT = -30 + 5 * np.sin(PLACES[:, 0] / 60) + PLACES[:, 1] / 40 + 2 * np.cos(PLACES.sum(axis=1) / 45)


def cloud(t: Path) -> Any:
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = [0.001] * 3, [6.2e6, 1.85e6, 0]
    header.add_crs(pyproj.CRS.from_user_input("EPSG:2230"))
    points = laspy.LasData(header)
    foot = 1200 / 3937
    points.x, points.y, points.z = 6.2e6 + PLACES[:, 0] / foot, 1.85e6 + PLACES[:, 1] / foot, HEIGHT / foot
    classes = np.zeros(700, dtype=np.uint8)
    classes[::9], classes[4::7] = 7, 9
    points.classification, points.withheld = classes, np.arange(700) % 13 == 5
    points.z = np.where(np.isin(classes, (7, 9)), 9.0, points.z)
    points.write(t / "a.las")
    return {"path": t / "a.las", "resolution_m": 11.0}


def bed(t: Path) -> Any:
    """Points of the bed and the ground alone, where any is of the bed."""
    keys = cloud(t)
    points = laspy.read(keys["path"])
    points.classification = np.where(np.arange(700) % 3 == 0, 40, np.where(np.arange(700) % 3 == 1, 2, 1)).astype("u1")
    points.write(keys["path"])
    return keys | {"datum_offset_m": -1.5}


def text_in_degrees(t: Path) -> Any:
    lines = [f"{k};{13 + p[1] / 8e4:.7f};{-h / FOOT:.4f};{44 + p[0] / 1.1e5:.7f}".replace(".", ",")
             for k, (p, h) in enumerate(zip(PLACES, HEIGHT, strict=True))]  # fmt: skip
    (t / "a.csv").write_text("no;longitude;depth ft;latitude\n" + "\n".join(lines) + "\n700;13,001;;44,001\n")
    return {
        "path": t / "a.csv",
        "resolution_m": 2.6,
        "detail": {"seed": 8},
        "latitude_range_deg": (44.0005, 44.0031),
        "longitude_range_deg": (13.0006, 13.0031),
    }


def text_of_columns(t: Path) -> Any:
    """More soundings than triangles are made of, two of them at one place."""
    rows = [*zip(4.9e6 + PLACES[:, 0], HEIGHT, 4.1e5 + PLACES[:, 1], strict=True)]
    rows.append((rows[3][0], -21.0, rows[3][2]))
    (t / "a.xyz").write_text("# made by hand\n" + "\n".join("  ".join(f"{v:.3f}" for v in row) for row in rows))
    return {"path": t / "a.xyz", "columns": "yzx", "crs": UTM, "resolution_m": 40.0}


def around_the_earth(t: Path) -> Any:
    lat, lon = np.arange(-20.0, -13.9, 0.5), np.arange(-180.0, 180.0, 0.5)
    z = -3000 + 10 * lat[:, None] ** 2 + 100 * np.cos(np.radians(lon) + 0.3) + 30 * np.sin(np.radians(37 * lon))
    axes = {"lat": (("lat",), lat, {}), "lon": (("lon",), lon, {})}
    file = to_netcdf(t / "a.nc", {**axes, "elevation": (("lat", "lon"), z, {})})
    return {"path": file, "centre_deg": (-17.0, 179.9), "size_m": (200e3, 300e3), "resolution_m": 10e3}


FILES: dict[str, Callable[[Path], Any]] = {
    f.__name__.replace("_", " "): f
    for f in (netcdf_from_the_north, netcdf_in_metres, netcdf_curved, raster_of_two_bands, raster_in_text, surfer,
              archive, cloud, bed, text_in_degrees, text_of_columns, around_the_earth)
}  # fmt: skip


def numbers_in(words: Any) -> list[float]:
    return [float(v) for line in words for v in re.findall(r"-?\d+\.?\d*(?:e[-+]?\d+)?", re.sub(r"a\.\w+", "", line))]


@pytest.mark.parametrize("case", FILES)
def test_survey_files(case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    keys = FILES[case](tmp_path)
    monkeypatch.setattr("pelagos.world.bathymetry.regrid._MANY", 300 if case == "text of columns" else 200_000)
    if case == "surfer":
        monkeypatch.setattr("pelagos.world.bathymetry.axes._MOST", 400)
    world = BathymetryConfig.model_validate({**keys, "path": str(keys["path"]), "material": "mud"}).build()
    ground: Any = world.terrain
    low, high = ground.bounds[:, :2]
    x, y = low[:, None] + (high - low)[:, None] * np.random.default_rng(3).uniform(0.02, 0.98, (2, 60))
    found = {
        "heights": ground.z, "shape": ground.z.shape, "bounds": ground.bounds, "between": world.height(x, y),
        "bends": [*np.diff(ground.z, 2, axis=0).ravel(), *np.diff(ground.z, 2, axis=1).ravel()],
        "normals": ground.normals(), "origin": [world.origin.latitude, world.origin.longitude],
        "notes": [len(world.notes), *numbers_in(world.notes)],
    }  # fmt: skip
    check("surveys", case, found, DOUBLE)


def test_axes_that_fall() -> None:
    u, v, z = np.array([1.0, 2.0, 4.0]), np.array([-3.0, 5.0, 7.0, 8.0]), np.arange(12.0).reshape(3, 4) ** 2
    found = {f"{a}{b}": np.concatenate([np.ravel(w) for w in rising(u[::a], v[::b], z[::a, ::b])]) for a in (1, -1)
             for b in (1, -1)}  # fmt: skip
    check("surveys", "axes that fall", found, DOUBLE)


PATCHES = {
    "insets": [{"centre_m": [310.0, -220.0], "size_m": [120.0, 80.0], "resolution_m": 2.4, "relief_m": 0.8,
                "spectral_slope": 2.6, "blend_m": 17.0, "material": "mud"},
               {"centre_m": [-500.0, 90.0], "size_m": [90.0, 60.0], "resolution_m": 5.0, "path": "inset.npy"}],
    "fields": [{"centre_m": [-200.0, 140.0], "size_m": [90.0, 60.0], "seed": 4,
                "exclude": [{"at_m": [12.0, -7.0], "radius_m": 15.0}, {"at_m": [-20.0, 9.0], "size_m": [14.0, 6.0]}],
                "objects": [{"kind": "boulder", "count": 16, "size_m": [1, 2]},
                            {"kind": "barrel", "at_m": [[10.0, -20.0], [-14.0, 5.0]]}]},
               {"centre_deg": [44.0021, 9.0031], "size_m": [80.0, 50.0], "objects": [{"kind": "barrel",
                "at_m": [[3.0, -4.0]]}]}],
    "things": [{"shape": "box", "at_m": [35, -57, 1.5], "on_ground": True, "size_m": [3, 5, 2], "label": "concrete"}],
}  # fmt: skip
LARGE: dict[str, dict[str, Any]] = {
    "fractal": {"ground": {"kind": "fractal", "seed": 4, "mean_depth_m": 60.0, "relief_m": 5.0, "longest_m": 700.0,
                           "spectral_slope": 3.1, "gradient": [0.013, -0.021]}, **PATCHES},
    "survey": {"ground": {"kind": "survey", "path": "a.npz", "variable": "depth", "unit": "fathom", "sign": "down",
                          "datum_offset_m": 0.6}},
    "soundings": {"ground": {"kind": "survey", "path": "a.xyz", "columns": "yzx", "crs": UTM}},
    "file": {"ground": {"kind": "file", "path": "ground.npy"}, "reach_m": 130.0},
}  # fmt: skip


@pytest.mark.parametrize("kind", LARGE)
def test_large_grounds(kind: str, tmp_path: Path) -> None:
    """Heights on and between the nodes of every level, normals of tiles, and what stands in pictures of them."""
    keys: dict[str, Any] = {"type": "large", "size_m": [1500.0, 1080.0], "resolution_m": 10.0, "memory_mb": 700.0,
                            "latitude_deg": 44.0, "longitude_deg": 9.0, **LARGE[kind]}  # fmt: skip
    np.save(tmp_path / "ground.npy", np.random.default_rng(2).normal(-40.0, 2.0, (151, 109)).cumsum(axis=0) / 40 - 30)
    np.save(tmp_path / "inset.npy", -50 + np.add.outer(np.arange(31.0) ** 1.5 / 20, np.arange(21.0) / 9))
    if kind == "survey":
        archive(tmp_path)
        keys |= {"latitude_deg": 44.0143, "longitude_deg": 13.0251}
    if kind == "soundings":
        text_of_columns(tmp_path)
        lat, lon = pyproj.Transformer.from_crs(UTM, "EPSG:4326").transform(410140.0, 4900190.0)
        keys |= {"latitude_deg": lat, "longitude_deg": lon, "size_m": [300.0, 200.0]}
    world = build_world(LargeConfig.model_validate(keys, context={"folder": tmp_path}))
    ground: Any = world.ground
    rng = np.random.default_rng(5)
    x, y = (rng.uniform(-0.55, 0.55, 90) * s for s in keys["size_m"])
    stream = Stream(ground)
    stream.follow(np.array([[0.2, -0.13], [-0.31, 0.22]]) * keys["size_m"])
    patch = stream.patch
    found: dict[str, Any] = {
        "heights": world.height(x, y), "surface": ground.surface(x, y), "levels": ground.level_at(x, y),
        "vertices": patch.vertices + patch.origin, "normals": patch.normals, "tiles": [len(patch.faces),
        stream.capacity],
        "materials": patch.face_materials, "notes": [len(world.notes), *numbers_in(world.notes)],
        "bounds": world.bounds,
    }  # fmt: skip
    for level in range(ground.finest, 2):
        i, j = (
            np.arange(0, 40) * step % (count * 2.0**-level) for step, count in zip((7, 11), ground.cells, strict=True)
        )
        found[f"nodes {level}"] = ground.nodes(level, i.astype(np.int64), j.astype(np.int64))
    if kind == "fractal":
        x, y = np.random.default_rng(6).uniform(-1, 1, (2, 60)) * [[55.0], [35.0]] + [[310.0], [-220.0]]
        found |= {"in the inset": world.height(x, y), "on the inset": ground.surface(x, y)}
        found |= by_label(list(pictured(world).geometries))
    check("surveys", f"large {kind}", found)
