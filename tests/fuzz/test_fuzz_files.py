"""Fuzzing of world files: meshes, robot descriptions and surveys, flipped, cut and spliced.

Each is read or refused in one `WorldError`; `make fuzz` goes on by time. HDF5 is left out: damaged, it may end the
process in its native library, as SECURITY.md says.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from harness import run_cases
from hypothesis import strategies as st

from pelagos.errors import WorldError
from pelagos.world.bathymetry.read import Reading, read_survey
from pelagos.world.files import read_mesh
from pelagos.world.robots.read import read_description

EASTING, NORTHING = 500_000.0 + 10.0 * np.arange(5), 4_000_000.0 + 10.0 * np.arange(4)
DEPTHS = -20.0 - np.add.outer(0.5 * np.arange(4), 0.25 * np.arange(5))
URDF = (
    '<robot name="r"><link name="a"><visual><origin xyz="1 -2 0.5" rpy="0.1 0 -0.3"/><geometry><box size="1 2 3"/>'
    '</geometry></visual></link><link name="b"><visual><geometry><sphere radius="0.4"/></geometry></visual></link>'
    '<joint name="j" type="fixed"><parent link="a"/><child link="b"/><origin xyz="0 1 2"/></joint></robot>'
)
SDF = (
    '<sdf version="1.9"><model name="m"><pose>1 2 3 0 0.1 0.2</pose><link name="l"><visual name="v"><geometry>'
    "<cylinder><radius>0.5</radius><length>2</length></cylinder></geometry></visual></link></model></sdf>"
)
MJCF = (
    '<mujoco><worldbody><body pos="1 2 3" euler="0 30 0"><geom type="capsule" fromto="0 0 0 0 0 1" size="0.2"/>'
    '<geom type="box" size="1 2 3" quat="1 0 0.1 0"/></body></worldbody></mujoco>'
)


def mesh_file(suffix: str) -> bytes:
    solid = trimesh.creation.icosphere(subdivisions=1, radius=1.5)
    raw = solid.export(file_type=suffix)
    return raw.encode() if isinstance(raw, str) else bytes(raw)


def geotiff() -> bytes:
    rasterio = pytest.importorskip("rasterio", reason="rasterio is not installed")
    from rasterio.transform import from_origin

    warnings.simplefilter("ignore", PendingDeprecationWarning)  # rasterio's own
    with rasterio.MemoryFile() as memory:
        with memory.open(
            driver="GTiff", width=5, height=4, count=1, dtype="float32", crs="EPSG:32633",
            transform=from_origin(EASTING[0], NORTHING[-1], 10.0, 10.0), nodata=-9999.0,
        ) as raster:  # fmt: skip
            raster.write(DEPTHS[::-1].astype(np.float32), 1)
        return bytes(memory.read())


def ascii_grid() -> bytes:
    head = "ncols 5\nnrows 4\nxllcorner 500000\nyllcorner 4000000\ncellsize 10\nNODATA_value -9999\n"
    return (head + "\n".join(" ".join(f"{z:.2f}" for z in row) for row in DEPTHS)).encode()


def las() -> bytes:
    laspy = pytest.importorskip("laspy", reason="laspy is not installed")
    cloud = laspy.create(point_format=6, file_version="1.4")
    cloud.x, cloud.y = np.tile(EASTING, 4), np.repeat(NORTHING, 5)
    cloud.z = DEPTHS.ravel()
    cloud.classification[:] = 40
    stream = io.BytesIO()
    cloud.write(stream)
    return stream.getvalue()


def npz() -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, x=EASTING, y=NORTHING, z=DEPTHS)
    return stream.getvalue()


def soundings() -> bytes:
    rows = zip(np.tile(EASTING, 4), np.repeat(NORTHING, 5), DEPTHS.ravel(), strict=True)
    return ("easting,northing,depth\n" + "\n".join(f"{x},{y},{z}" for x, y, z in rows)).encode()


def surfer() -> bytes:
    text = f"DSAA\n5 4\n{EASTING[0]} {EASTING[-1]}\n{NORTHING[0]} {NORTHING[-1]}\n{DEPTHS.min()} {DEPTHS.max()}\n"
    return (text + "\n".join(" ".join(map(str, row)) for row in DEPTHS)).encode()


def survey(path: Path) -> None:
    read_survey(str(path), Reading(None, "EPSG:32633", "xyz", None))


FILES: dict[str, tuple[Callable[[], bytes], Callable[[Path], object]]] = {
    **{f"a.{kind}": (lambda kind=kind: mesh_file(kind), read_mesh) for kind in ("stl", "obj", "ply", "glb", "off")},  # type: ignore[misc]
    "a.urdf": (URDF.encode, read_description), "a.sdf": (SDF.encode, read_description),
    "a.xml": (MJCF.encode, read_description),
    "a.tif": (geotiff, survey), "a.asc": (ascii_grid, survey), "a.las": (las, survey), "a.npz": (npz, survey),
    "a.xyz": (soundings, survey), "a.grd": (surfer, survey),
}  # fmt: skip
TOKENS = [b"0", b"-1", b"nan", b"inf", b"1e999", b"99999999999", b"\xff\xff\xff\x7f", b"\x00" * 8, b" ", b"<", b"\n"]


@st.composite
def damaged(draw: st.DrawFn, whole: bytes) -> bytes:
    """A file with up to four places overwritten by a byte or a hostile token, a piece repeated, or the end cut off."""
    raw = bytearray(whole)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(len(raw) - 1, 0)))
        kind = draw(st.sampled_from(["byte", "token", "insert", "repeat", "cut"]))
        if kind == "byte" and raw:
            raw[at] = draw(st.integers(0, 255))
        elif kind == "repeat":
            raw[at:at] = raw[at : at + draw(st.integers(1, 64))]
        elif kind == "cut":
            del raw[at:]
        else:
            token = draw(st.sampled_from(TOKENS))
            raw[at : at + (len(token) if kind == "token" else 0)] = token
    return bytes(raw)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # rasterio's log of bytes beyond ASCII
@pytest.mark.parametrize("name", list(FILES))
def test_damaged_files_are_read_or_refused(name: str, tmp_path: Path) -> None:
    write, read = FILES[name]
    path, whole = tmp_path / name, write()
    path.write_bytes(whole)
    read(path)  # whole, it is read

    def check(raw: bytes) -> None:
        path.write_bytes(raw)
        read(path)

    run_cases(damaged(whole), check, name)


def test_an_empty_file_is_refused(tmp_path: Path) -> None:
    for name, (_, read) in FILES.items():
        (tmp_path / name).write_bytes(b"")
        with pytest.raises(WorldError):
            read(tmp_path / name)
