"""`pelagos world`: statistics, pictures and files of a scenario's world."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pelagos.cli.main import main
from pelagos.world.build import build_world, world_config
from pelagos.world.export import load
from pelagos.world.viewpoint import viewpoints

SCENARIO = """\
name: small reef
world:
  type: generated
  seed: 3
  size_m: [40, 40]
  objects: [{kind: boulder, count: 6}, {kind: barrel, count: 2}]
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "reef.yaml"
    path.write_text(SCENARIO)
    return path


def outcome(*arguments: object) -> int:
    with pytest.raises(SystemExit) as caught:
        main([str(a) for a in arguments])
    return int(caught.value.code or 0)


def test_statistics_are_printed_without_any_output(scenario: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("world", scenario) == 0
    captured = capsys.readouterr()
    for word in ("0.16 ha", "6 boulder", "triangles", "MB", "generated in"):
        assert word in captured.out
    assert "building the world" in captured.err


@pytest.mark.usefixtures("small_pictures")
def test_every_kind_of_output(scenario: Path, tmp_path: Path) -> None:
    names = ("p.png", "r.html", "w.glb", "w.npz", "s.json", "folder")
    outs = [part for name in names for part in ("--out", tmp_path / name)]
    assert outcome("world", scenario, "--samples", 1, *outs) == 0
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    page = (tmp_path / "r.html").read_text()
    assert page.count("data:image/png;base64,") >= 2
    assert "boulder" in page
    assert (tmp_path / "w.glb").read_bytes().startswith(b"glTF")
    saved = load(tmp_path / "w.npz")
    numbers = json.loads((tmp_path / "s.json").read_text())
    assert numbers["triangles"] == saved.triangles
    assert numbers["objects"]["boulder"] == 6
    assert {f.name for f in (tmp_path / "folder").iterdir()} == {"world.npz", "world.glb", "labels.json", "height.npz"}
    rebuilt = build_world(world_config({"type": "saved", "path": str(tmp_path / "w.npz")}))
    for a, b in zip(saved.geometries, rebuilt.geometries, strict=True):
        assert a.vertices.tobytes() == b.vertices.tobytes()


@pytest.mark.parametrize(("at", "x"), [((), -4.0), (("--at", "0"), -4.0), (("--at", "6"), -1.0), (("--at", "40"), 8.0)])
def test_movers_stand_in_files_where_they_are_at_the_time_that_is_asked_for(
    tmp_path: Path, at: tuple[str, ...], x: float
) -> None:
    """0.5 m/s from x = -4 to x = 8; in glTF y is up, and world y (west) is -z."""
    import trimesh

    path = tmp_path / "moving.yaml"
    path.write_text("""\
world:
  type: flat
  depth_m: 30
  size_m: [60, 60]
  movers:
    - {name: plate, body: box, size_m: 2.0,
       path: {kind: waypoints, points_m: [[-4, 7, -12], [8, 7, -12]], speed_mps: 0.5}}
""")
    assert outcome("world", path, *at, "--out", tmp_path / "folder", "--out", tmp_path / "w.glb") == 0
    for file in (tmp_path / "folder" / "world.glb", tmp_path / "w.glb"):
        scene = trimesh.load(file)
        transform, name = scene.graph[next(n for n in scene.graph.nodes_geometry if "plate" in n)]
        corners = trimesh.transform_points(scene.geometry[name].vertices, transform)
        assert corners.mean(axis=0) == pytest.approx([x, -12, -7], abs=1e-4)
    kept = load(tmp_path / "folder" / "world.npz").movers  # with its whole way
    assert [m.name for m in kept] == ["plate"]
    assert not load(tmp_path / "folder" / "world.npz").at_time(0.0).movers


@pytest.mark.parametrize(
    ("name", "says"), [("w.docx", ".glb"), ("nowhere/w.glb", "does not exist"), ("full", "empty folder")]
)
def test_refused_outputs(
    scenario: Path, tmp_path: Path, name: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    assert outcome("world", scenario, "--out", tmp_path / name) == 2
    assert says in " ".join(capsys.readouterr().err.split())


def test_views_see_what_they_look_at() -> None:
    """From every eye the way to its target is free for at least half of it, also where the world has a roof."""
    worlds = ({"type": "classic", "name": "rooms"}, {"type": "classic", "name": "tank"}, {"type": "flat"})
    for values in worlds:
        world = build_world(world_config(dict(values)))
        for view in viewpoints(world):
            way = view.target - view.eye
            length = float(np.linalg.norm(way))
            hits = world.cast(view.eye, way, length)
            assert not hits.valid[0] or hits.t[0] > 0.5 * length, (values, view)
