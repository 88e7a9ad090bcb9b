"""Strangers' files: scenarios, meshes and surveys that would run code, call home, leave their folder or eat memory."""

from __future__ import annotations

import contextlib
import gzip
import http.server
import resource
import struct
import subprocess
import sys
import threading
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest

import pelagos as pl
from pelagos.cli.console import visible
from pelagos.config.loader import load_scenario
from pelagos.errors import PelagosError, ScenarioError, WorldError
from pelagos.world.build import build_world, world_config
from pelagos.world.files import read_mesh
from pelagos.world.robots.read import read_description

AGENT = "agents: {a: {vehicle: remus100, start: {depth_m: 3}}}\n"
FLAT = "world: {type: flat, depth_m: 10}\n"


def scenario(folder: Path, text: str) -> Path:
    path = folder / "scenario.yaml"
    path.write_text(text)
    return path


# YAML


def merge_bomb(levels: int = 30) -> str:
    lines = ["a0: &a0 {x: 1, y: 2}"]
    lines += [f"a{k}: &a{k}\n  <<: [*a{k - 1}, *a{k - 1}, *a{k - 1}]\n  k{k}: 1" for k in range(1, levels)]
    return "\n".join(lines)


BOMBS = {
    "merge keys": (merge_bomb(), "too large for a scenario"),
    "merge into itself": ("a: &a {<<: *a}", "merges a mapping into itself"),
    "recursive list": ("a: &a [*a]", "nested too deeply"),
    "recursive mapping": ("a: &a {b: *a}", "nested too deeply"),
    "aliases": ("a: &a [1,1,1,1,1,1,1,1,1,1]\n" + "\n".join(
        f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 10)}]" for k in range(9)), "too large"),
    "deep flow": ("a: " + "[" * 100_000, "nested too deeply"),
    "deep mappings": ("a: " + "{b: " * 5_000 + "1" + "}" * 5_000, "nested too deeply"),
    "deep blocks": ("- " * 20_000 + "1", "nested too deeply"),
    "huge integer": ("seed: " + "9" * 5_000, "a number of 5000 characters"),
    "huge hexadecimal": ("seed: 0x" + "f" * 5_000, "a number of 5002 characters"),
    "tag": ("a: !!python/object/apply:os.system [echo]", "the tag"),
}  # fmt: skip


@pytest.mark.parametrize("name", list(BOMBS))
def test_yaml_bombs_are_one_error(name: str, tmp_path: Path) -> None:
    """Unpacked, they would never end."""
    text, message = BOMBS[name]
    with pytest.raises(ScenarioError, match=message):
        load_scenario(scenario(tmp_path, text))


def test_the_work_of_reading_grows_with_the_number_of_agents(tmp_path: Path) -> None:
    """Twice as many agents take less than 2.2 times as many calls."""
    agent = "  a{}: {{vehicle: remus100, start: {{position_m: [{}, 0], depth_m: 3}}, sensors: {{imu: {{type: imu}}}}}}"

    def calls(agents: int) -> int:
        path = scenario(tmp_path, FLAT + "agents:\n" + "\n".join(agent.format(k, k) for k in range(agents)))
        counted = 0

        def count(*_: object) -> None:
            nonlocal counted
            counted += 1

        before = sys.getprofile()
        sys.setprofile(count)
        try:
            read = load_scenario(path)
        finally:
            sys.setprofile(before)
        assert len(read.agents) == agents
        return counted

    calls(1)  # what is made once
    assert calls(200) < 2.2 * calls(100)


def test_a_pipe_is_no_scenario(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="a device or a pipe"):
        load_scenario("/dev/zero")


def test_control_characters_are_shown_as_text() -> None:
    assert visible("a\x1b[2Jb\u202ec\nd\te\x07\x9b") == "a\\x1b[2Jb\\u202ec\nd\te\\x07\\x9b"


def test_names_do_not_reach_the_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from pelagos.cli.main import main

    text = 'name: "evil\\e]0;owned\\a"\n' + FLAT + AGENT
    with pytest.raises(SystemExit):
        main(["check", str(scenario(tmp_path, text)), "--set", "na\x1b[31mme2=1"])
    main_output = capsys.readouterr()
    assert "\x1b" not in main_output.out + main_output.err
    with contextlib.suppress(SystemExit):
        main(["check", str(scenario(tmp_path, text))])
    assert "evil\\x1b]0;owned\\x07" in capsys.readouterr().out


# Code


CODE = (
    """
agents: {a: {vehicle: {type: remus100, terms: {mine: {type: function, target: "intruder:run"}}}, start: {depth_m: 3}}}
"""
    + FLAT
)
OCEAN = FLAT + AGENT + 'ocean: {currents: [{type: python, function: "intruder:run"}]}\n'


@pytest.mark.parametrize("text", [CODE, OCEAN], ids=["vehicle", "ocean"])
def test_a_scenario_runs_no_code_unless_told(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "intruder.py").write_text("import pathlib; pathlib.Path('ran').touch()\ndef run(*a): return a[0]\n")
    monkeypatch.chdir(tmp_path)
    path = scenario(tmp_path, text)
    with pytest.raises(ScenarioError, match=r"is code that the scenario wants to run.*--trust"):
        pl.Simulation.load(path)
    if text == OCEAN:
        done = subprocess.run([sys.executable, "-m", "pelagos", "check", str(path)], capture_output=True, text=True)
        assert done.returncode == 2
        assert "is code that the scenario wants to run" in done.stderr
    assert not Path("ran").exists()
    assert load_scenario(path, trust=True)


def test_modules_beside_a_scenario_are_not_imported(tmp_path: Path) -> None:
    (tmp_path / "yaml.py").write_text("import pathlib; pathlib.Path('ran').touch()\n")
    path = scenario(tmp_path, FLAT + AGENT)
    done = subprocess.run(
        [sys.executable, "-m", "pelagos", "check", str(path)], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "ran").exists()


# Meshes and descriptions


BOX = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n"


def test_meshes_stay_in_the_scenarios_folder(tmp_path: Path) -> None:
    (tmp_path / "project").mkdir()
    (tmp_path / "secret.obj").write_text(BOX)
    thing = "world: {{type: flat, depth_m: 10, things: [{{shape: file, path: {}}}]}}\n"
    for name in ("../secret.obj", str(tmp_path / "secret.obj")):
        path = scenario(tmp_path / "project", thing.format(name) + AGENT)
        with pytest.raises(ScenarioError, match=r"lies outside of the scenario's folder"):
            load_scenario(path)
        assert load_scenario(path, trust=True)
    (tmp_path / "project" / "link.obj").symlink_to(tmp_path / "secret.obj")
    with pytest.raises(ScenarioError, match=r"lies outside of the scenario's folder"):
        load_scenario(scenario(tmp_path / "project", thing.format("link.obj") + AGENT))


@pytest.mark.parametrize("name", ["/etc/passwd.obj", "../../../secret.obj", "file:///etc/secret.obj"])
def test_descriptions_name_no_meshes_outside_of_their_package(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b" / "c"
    folder.mkdir(parents=True)
    (tmp_path / "secret.obj").write_text(BOX)
    text = (
        f'<robot name="r"><link name="l"><visual><geometry><mesh filename="{name}"/></geometry></visual></link></robot>'
    )
    (folder / "r.urdf").write_text(text)
    with pytest.raises(WorldError, match=r"outside of the package|was not found"):
        read_description(folder / "r.urdf")


def stl(count: int, *, said: int | None = None, value: float = 1.0) -> bytes:
    triangle = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, value, 0, 0, 0, value, 0, 0)
    return b"\0" * 80 + struct.pack("<I", count if said is None else said) + triangle * count


def ply(said: int) -> bytes:
    return (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {said}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {said}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode() + b"\0" * 200


MESHES = {
    "nan.stl": (stl(2, value=float("nan")), "not finite|no triangle with an area"),
    "flat.stl": (stl(2, value=0.0), "no triangle with an area"),
    "lying.stl": (stl(2, said=2**32 - 1), "mesh file"),
    "lying.ply": (ply(4_000_000_000), "cannot be read"),
    "noise.stl": (np.random.default_rng(1).bytes(5000), "mesh file"),
    "noise.glb": (b"glTF" + np.random.default_rng(2).bytes(5000), "cannot be read"),
    "lying.glb": (b"glTF" + struct.pack("<IIII", 2, 2**31, 2**31 - 1, 0x4E4F534A) + b"{}", "mesh file"),
    "outside.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999\n", "mesh file"),
    "empty.obj": (b"", "mesh file"),
    "huge.obj": (b"v 1e308 0 0\nv 0 1e308 0\nv 0 0 1e308\nf 1 2 3\n", ""),
}


@pytest.mark.parametrize("name", list(MESHES))
@pytest.mark.filterwarnings("ignore")
def test_hostile_meshes_are_one_error(name: str, tmp_path: Path) -> None:
    data, message = MESHES[name]
    (tmp_path / name).write_bytes(data)
    guarded(lambda: read_mesh(tmp_path / name), message)


XML = {
    "deep.urdf": "<robot>" + "<link>" * 100_000 + "</link>" * 100_000 + "</robot>",
    "deep.sdf": "<sdf><world>" + "<model>" * 5_000 + "</model>" * 5_000 + "</world></sdf>",
    "laughs.urdf": '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">'
    + "".join(f'<!ENTITY {chr(98 + k)} "{("&" + chr(97 + k) + ";") * 10}">' for k in range(10))
    + "]><robot>&k;</robot>",
    "noise.urdf": "<robot><link><visual><geometry><box size='1 nan x'/></geometry></visual></link></robot>",
    "itself.sdf": "<sdf><include><uri>itself.sdf</uri></include></sdf>",
}


@pytest.mark.parametrize("name", list(XML))
def test_hostile_descriptions_are_one_error(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(XML[name])
    guarded(lambda: read_description(tmp_path / name), "description file|model")


# Surveys


def survey(path: Path) -> object:
    values = {
        "type": "bathymetry",
        "path": str(path),
        "crs": "EPSG:4326",
        "centre_deg": [45.0, 12.0],
        "size_m": [100, 100],
    }
    return build_world(world_config(values))


def guarded(read: object, message: str) -> None:
    """One clear error, and less than 1 GB more memory."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    if message:
        with pytest.raises(WorldError, match=message):
            read()  # type: ignore[operator]
    else:
        with contextlib.suppress(PelagosError):
            read()  # type: ignore[operator]
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 1_000_000


def las(points: int) -> bytes:
    import io

    import laspy

    cloud = laspy.create(point_format=1)
    cloud.x = cloud.y = cloud.z = np.arange(10.0)
    file = io.BytesIO()
    cloud.write(file)
    raw = bytearray(file.getvalue())
    struct.pack_into("<I", raw, 107, points)
    return bytes(raw)


@pytest.mark.filterwarnings("ignore")
def test_hostile_surveys_are_one_error(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    pytest.importorskip("laspy")
    draw = np.random.default_rng(3)
    files = {
        "lying.las": las(2**32 - 1), "noise.las": b"LASF" + draw.bytes(4000), "noise.tif": b"II*\0" + draw.bytes(4000),
        "noise.nc": b"CDF\x01" + draw.bytes(4000), "noise.nc4": b"\x89HDF\r\n\x1a\n" + draw.bytes(4000),
        "noise.npz": b"PK\3\4" + draw.bytes(4000), "lying.asc": b"ncols 2000000000\nnrows 2000000000\nxllcorner 0\n"
        b"yllcorner 0\ncellsize 1\n1 2 3\n", "nothing.xyz": b"\0" * 1000,
    }  # fmt: skip
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
        guarded(lambda name=name: survey(tmp_path / name), "bathymetry file")  # type: ignore[misc]


def test_archives_that_are_bombs_are_refused_before_they_are_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pelagos.world.size.MAX_BYTES", 8_000_000)
    np.savez_compressed(tmp_path / "bomb.npz", z=np.zeros((2000, 1000)))
    guarded(lambda: survey(tmp_path / "bomb.npz"), "GB unpacked; at most")
    with ZipFile(tmp_path / "lying.npz", "w") as archive, archive.open("z.npy", "w") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (60000, 60000)})
        file.write(bytes(800))
    guarded(lambda: survey(tmp_path / "lying.npz"), "array 'z' says that it has 28.8 GB")
    with gzip.open(tmp_path / "bomb.xyz.gz", "wb") as file:
        file.write(bytes(20_000_000))
    guarded(lambda: survey(tmp_path / "bomb.xyz.gz"), "GB of text when it is unpacked")


def test_rasters_call_nobody(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    asked: list[str] = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            self.send_error(404)

        do_HEAD = do_GET  # noqa: N815

        def log_message(self, format: str, *arguments: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        source = f"/vsicurl/http://127.0.0.1:{server.server_port}/secret.tif"
        text = (
            '<VRTDataset rasterXSize="9" rasterYSize="9"><GeoTransform>0,1,0,0,0,-1</GeoTransform>'
            '<VRTRasterBand dataType="Float32" band="1"><SimpleSource>'
            f'<SourceFilename relativeToVRT="0">{source}</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>'
        )
        for name in ("a.vrt", "a.tif", "a.asc"):
            (tmp_path / name).write_text(text)
            with pytest.raises(WorldError, match="bathymetry file"):
                survey(tmp_path / name)
        server.shutdown()
    assert asked == []
