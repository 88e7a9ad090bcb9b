"""A vehicle that floats on a mesh of its own: wet part, draught, and riding the waves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import pelagos as pl
from pelagos.errors import PelagosError
from pelagos.vehicles.shape.floating_mesh import float_mesh, wet_part

BOX = (3.0, 1.2, 0.8)


def barge(path: Path, **changes: Any) -> dict[str, Any]:
    """A box barge of 0.3 m draught, as data; in sea water of 1025 kg/m^3."""
    length, beam, _ = BOX
    mass = 1025 * length * beam * 0.3
    stiffness = 1025 * 9.81 * length * beam
    return {
        "type": "custom", "density_kg_m3": 1025, "length_m": length, "beam_m": beam, "height_m": 0.8,
        "mass": {"type": "explicit", "mass_kg": mass, "inertia_kg_m2": [0.1 * mass, 0.8 * mass, 0.9 * mass]},
        "added_mass": {"type": "diagonal", "diagonal": [mass * f for f in (0.05, 0.3, 1.0, 0.03, 0.8, 0.3)]},
        "terms": {
            "hydrostatics": {"type": "hydrostatic", "heave_n_m": stiffness, "roll_n_m": 3000, "pitch_n_m": 25000},
            "damping": {"type": "linear_damping", "diagonal": [300, 600, 6000, 300, 6000, 600]},
        },
        "modes": {"actuators": {"type": "actuators"}, "wrench": {"type": "wrench"}}, "default_mode": "wrench",
        "afloat": {"mesh": str(path)}, **changes,
    }  # fmt: skip


@pytest.fixture
def box(tmp_path: Path) -> Path:
    mesh = trimesh.creation.box(extents=BOX)
    mesh.apply_translation([0, 0, 5.0])  # wherever its maker put it: it is moved to where it floats
    mesh.export(tmp_path / "box.stl")
    return tmp_path / "box.stl"


def test_wet_part_of_a_ball_is_a_cap() -> None:
    """V = pi h^2 (3 r - h) / 3; a ball of 80 x 160 flats holds 0.1 % less."""
    ball = trimesh.creation.uv_sphere(radius=1.0, count=[160, 320])
    for level in (-0.6, 0.0, 0.35):
        h = level + 1
        volume, center = wet_part(np.asarray(ball.vertices), np.asarray(ball.faces), level)
        assert volume == pytest.approx(np.pi * h * h * (3 - h) / 3, rel=2e-3)
        assert center[:2] == pytest.approx([0, 0], abs=1e-9)
        assert center[2] == pytest.approx(-3 * (2 - h) ** 2 / (4 * (3 - h)), abs=2e-3)


def test_a_box_floats_at_its_draught(box: Path) -> None:
    found = float_mesh(box, 3.0 * 1.2 * 0.3)
    assert found.vertices[:, 2].max() == pytest.approx(0.3, abs=1e-6)  # STL is single precision
    assert found.center == pytest.approx([0, 0, 0.15], abs=1e-6)


def test_triangles_that_were_turned_the_wrong_way_are_turned(tmp_path: Path) -> None:
    """A wedge of half the box's volume, off its middle: the same with a third of its triangles inside out, or all."""
    places = np.array([[0, 0, 0], [3, 0, 0], [0, 1.2, 0], [0, 0, 0.8], [3, 0, 0.8], [0, 1.2, 0.8]])
    faces = np.array([[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]])
    found = []
    for turned in ([], [1, 4, 6], range(8)):
        way = faces.copy()
        way[list(turned)] = way[list(turned)][:, ::-1]
        trimesh.Trimesh(places, way, process=False).export(tmp_path / "wedge.stl")
        found.append(float_mesh(tmp_path / "wedge.stl", 0.5 * 3 * 1.2 * 0.3))
    for made in found:
        assert made.vertices[:, 2].max() == pytest.approx(0.3, abs=1e-6)  # the draught, down
        assert made.center == pytest.approx([1.0, -0.4, 0.15], abs=1e-6)


def test_it_rides_long_waves(box: Path) -> None:
    """Waves of 39 m: the surface under a 3 m barge moves by its own height, and so does the barge."""
    start = {"position_m": [0.0, 0.0], "depth_m": 0.0}
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 100,
            "world": {"type": "flat", "depth_m": 60.0},
            "ocean": {"waves": {"type": "regular", "height_m": 0.6, "period_s": 5.0}},
            "agents": {"it": {"vehicle": barge(box), "start": start}},
        }
    )
    sim.run(15.0)
    z = []
    for _ in range(50):
        sim.run(0.2)
        z.append(float(sim.state["it"].position[0, 2]))
    assert 0.5 * (max(z) - min(z)) == pytest.approx(0.3, rel=0.06)
    assert abs(np.mean(z)) < 0.03


@pytest.mark.parametrize(
    ("what", "message"), [("open", "is not closed"), ("small", "sinks: it holds"), ("none", "does not exist"),
                          ("both", "either hulls or mesh")],
)  # fmt: skip
def test_bad_meshes(tmp_path: Path, box: Path, what: str, message: str) -> None:
    data = barge(box)
    if what == "open":
        mesh = trimesh.load_mesh(box)
        trimesh.Trimesh(mesh.vertices, mesh.faces[:-1]).export(box)
    elif what == "small":
        trimesh.creation.box(extents=(1, 1, 0.2)).export(box)
    elif what == "none":
        data["afloat"] = {"mesh": str(tmp_path / "nothing.stl")}
    else:
        data["afloat"] = {"mesh": str(box), "hulls": [{"length_m": 3, "beam_m": 1.2, "freeboard_m": 0.4}]}
    with pytest.raises(PelagosError, match=message):
        pl.Vehicle.from_dict(data)
