"""Shapes of hulls against their geometry: volumes, which way faces look, profiles, where fins and probes lie."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pelagos.vehicles.shape.floating_mesh import wet_part
from pelagos.vehicles.shape.hull import build_hull, hull_materials
from pelagos.vehicles.shape.mesh import Mesh, box, placed, revolved, slab
from pelagos.vehicles.shape.parts import PartsHull, ShapePart, _on_spine, _outlying
from pelagos.vehicles.shape.pontoon import PontoonConfig, displaced, fullness, pontoon_mesh
from pelagos.vehicles.shape.torpedo import FinShape, TorpedoHull, myring_radius

ROUND = 32 / (2 * math.pi) * math.sin(2 * math.pi / 32)  # area of a polygon of 32 corners over its circle's
SIZE = np.array([2.0, 0.7, 0.4])


def volume(mesh: Mesh) -> float:
    """Divergence theorem: positive where faces look outwards."""
    p, q, r = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.einsum("fi,fi->f", p, np.cross(q, r)).sum() / 6)


def looks(mesh: Mesh) -> np.ndarray:
    """Cosine between a face's own normal and the mean of those of its corners."""
    p, q, r = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    own, given = np.cross(q - p, r - p), mesh.normals[mesh.faces].mean(axis=1)
    return np.einsum("fi,fi->f", own, given) / np.linalg.norm(own, axis=1) / np.linalg.norm(given, axis=1)


def part(kind: str, size: np.ndarray = SIZE) -> Mesh:
    return ShapePart.model_validate({"type": kind, "size_m": tuple(size)}).meshes()[0]


def test_primitives_have_their_size_and_volume() -> None:
    """A cylinder whose edges are rounded by a tenth of its width; an ellipsoid of 16 rings."""
    corners = np.linspace(0, np.pi, 17)
    x, r = 0.5 * np.cos(corners), 0.5 * np.sin(corners)
    rings = ROUND * np.pi * abs(np.sum(np.diff(x) * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2) / 3))
    assert volume(part("box")) == pytest.approx(SIZE.prod(), rel=1e-12)
    assert volume(part("ellipsoid")) == pytest.approx(SIZE.prod() * rings, rel=1e-6)
    assert rings == pytest.approx(np.pi / 6, rel=0.02)
    edge = 0.1 * 0.7 / 2.0  # of the length, at either end, where the radius grows from 0.4 to 0.5
    assert volume(part("cylinder")) == pytest.approx(
        SIZE.prod() * ROUND * np.pi * (0.25 - 2 * edge * (0.25 - 0.475**2)), rel=0.01
    )
    for kind in ("box", "cylinder", "ellipsoid", "hull"):
        mesh = part(kind)
        assert np.ptp(mesh.vertices, axis=0) == pytest.approx(SIZE, rel=1e-6), kind
        assert mesh.vertices.max(axis=0) == pytest.approx(SIZE / 2, rel=1e-6), kind
        assert looks(mesh).min() > 0.3, kind
        assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0), kind
    assert looks(part("box")).min() == pytest.approx(1.0)
    bow = part("hull").vertices
    assert np.ptp(bow[bow[:, 0] > 0.49 * SIZE[0], 1]) < 0.05 * SIZE[1]  # to a point ahead
    assert np.ptp(bow[bow[:, 2] < -0.49 * SIZE[2], 1]) == pytest.approx(0.6 * SIZE[1], rel=1e-6)  # V bottom


def test_normals_of_a_stretched_body_are_those_of_its_surface() -> None:
    """Of an ellipsoid along (x/a^2, y/b^2, z/c^2); those of its profile are by differences."""
    mesh = part("ellipsoid")
    slope = mesh.vertices / SIZE**2
    expected = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    assert np.einsum("vi,vi->v", mesh.normals, expected).min() > 0.96
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = placed(mesh, turn, np.array([3.0, -1.0, 0.5]))
    assert moved.vertices[:, 1] == pytest.approx(mesh.vertices[:, 0] - 1.0)
    assert moved.vertices[:, 0] == pytest.approx(3.0 - mesh.vertices[:, 1])
    assert moved.normals[:, 1] == pytest.approx(mesh.normals[:, 0])


def test_plates_and_profiles_look_outwards() -> None:
    outline = np.array([[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 1.0, 1.0], [0.0, 1.0, 1.0]])
    plate = slab(outline, 0.3, np.array([0.0, 0.0, 1.0]))
    assert volume(plate) == pytest.approx(0.6, rel=1e-12)
    assert (plate.vertices[:, 2].min(), plate.vertices[:, 2].max()) == pytest.approx((0.85, 1.15))
    cone = revolved(np.array([1.0, 0.0, -2.0]), np.array([0.0, 0.5, 0.0]))
    assert volume(cone) == pytest.approx(ROUND * np.pi * 0.25, rel=1e-9)  # two cones, 3 m long
    assert volume(box(np.array([1.0, 2.0, 3.0]))) == pytest.approx(6.0)


def torpedo(**keys: object) -> TorpedoHull:
    given = {
        "type": "torpedo",
        "length_m": 2.0,
        "diameter_m": 0.3,
        "nose_m": 0.4,
        "tail_m": 0.6,
        "tail_angle_deg": 20.0,
    }
    return TorpedoHull.model_validate({**given, **keys})


def test_a_profile_is_myrings() -> None:
    """Nose d/2 (1 - ((x - a)/a)^2)^(1/n); the tail begins level and ends in a point, with its half angle."""
    hull = torpedo(nose_exponent=3.0)
    at = lambda *x: myring_radius(hull, np.array(x))
    assert at(0.0, 0.1, 0.4, 0.9, 1.4, 2.0) == pytest.approx(
        [0.0, 0.15 * (1 - 0.75**2) ** (1 / 3), 0.15, 0.15, 0.15, 0.0], abs=1e-12
    )
    small = 1e-6
    assert (at(2.0) - at(2.0 - small)) / small == pytest.approx(-math.tan(math.radians(20.0)), rel=1e-4)
    assert (at(1.4 + small) - at(1.4)) / small == pytest.approx(0.0, abs=1e-4)
    assert torpedo().tip == 1.0
    assert torpedo(nose_x_m=1.3).tip == 1.3
    body = torpedo(nose_x_m=1.3).meshes()[0].vertices
    assert (body[:, 0].max(), body[:, 0].min()) == pytest.approx((1.3, -0.7))


@pytest.mark.parametrize(
    ("angle", "out"), [(0.0, (0, -1, 0)), (90.0, (0, 0, -1)), (180.0, (0, 1, 0)), (270.0, (0, 0, 1))]
)
def test_a_fin_stands_out_where_its_angle_says(angle: float, out: tuple[int, int, int]) -> None:
    """0 to starboard, 90 down, of an axis system whose y is to port and z up; its probe goes to the tip."""
    fin = FinShape(angle_deg=angle, x_m=-0.8, span_m=0.35, chord_m=0.2)
    hull = torpedo(fins=(fin,), propeller_m=0.25, fin_material="steel")
    mesh = hull.meshes()[1]
    along = mesh.vertices @ np.array(out, dtype=float)
    assert along.max() == pytest.approx(0.35)
    assert along.min() == pytest.approx(0.3 * 0.35)
    assert (mesh.vertices[:, 0].min(), mesh.vertices[:, 0].max()) == pytest.approx((-0.9, -0.7))
    thick = mesh.vertices @ np.cross([1.0, 0.0, 0.0], out)
    assert np.ptp(thick) == pytest.approx(0.02)
    assert volume(mesh) == pytest.approx(0.02 * 0.7 * 0.35 * (0.2 + 0.12) / 2, rel=1e-9)  # a trapezium
    starts, vectors = hull.probes()
    assert (starts[-1] + vectors[-1]) == pytest.approx(np.array([-0.8, 0, 0]) + 0.35 * np.array(out))
    blades = np.concatenate([m.vertices for m in hull.meshes()[2:]])
    assert len(hull.meshes()) == 5
    assert np.hypot(*blades[:, 1:].T).max() == pytest.approx(0.125, abs=0.01)
    assert blades[:, 0].mean() == pytest.approx(-1.005, abs=0.02)
    assert [m.material for m in hull.meshes()] == [None] + 4 * ["steel"]
    geometry = build_hull(hull, "it", hull_materials(hull, ("paint", "rust")))
    assert hull_materials(hull, ("paint", "rust")) == ("paint", "rust", "steel")
    assert np.unique(geometry.material[: len(hull.meshes()[0].faces)]).tolist() == [0]
    assert np.unique(geometry.material[len(hull.meshes()[0].faces) :]).tolist() == [2]


def test_probes_of_a_torpedo_end_on_its_skin() -> None:
    hull = torpedo(nose_x_m=1.3)
    starts, vectors = hull.probes()
    ends = starts + vectors
    assert starts[:, 1:] == pytest.approx(np.zeros((len(starts), 2)))
    level = np.abs(vectors[:, 0]) < 1e-12
    skin = np.maximum(myring_radius(hull, 1.3 - ends[level, 0]), 0.25 * 0.15)
    assert np.hypot(*ends[level, 1:].T) == pytest.approx(skin, rel=1e-9)
    assert (ends[:, 0].max(), ends[:, 0].min()) == pytest.approx((1.3, -0.7))
    caps = ~level & (np.hypot(*vectors[:, 1:].T) > 1e-9)
    assert np.linalg.norm(vectors[caps], axis=1) == pytest.approx(0.7 * 0.15 * math.sqrt(2))
    assert caps.sum() == 12


def test_probes_of_parts_begin_on_their_own_spine() -> None:
    """Those of a catamaran's hulls in their own middle; points far from one another, the foremost first."""
    boat = {"type": "hull", "size_m": (2.0, 0.4, 0.5), "position_m": (0.1, 0.8, -0.2), "mirror": True}
    deck = {"type": "box", "size_m": (1.0, 2.2, 0.1), "position_m": (0.0, 0.0, 0.4)}
    starts, vectors = PartsHull.model_validate({"type": "parts", "parts": [boat, deck]}).probes()
    ends = starts + vectors
    hulls = ends[:, 2] < 0.1
    assert starts[hulls, 1] == pytest.approx(0.8 * np.sign(ends[hulls, 1]))
    assert starts[~hulls, 1] == pytest.approx(np.zeros((~hulls).sum()))
    assert np.abs(starts[hulls, 0] - 0.1).max() == pytest.approx(0.8, abs=0.01)  # half a width from the ends
    points = np.array([[-2.0, 0.1, 0.2], [2.0, -0.3, 0.0], [0.1, 0.5, 0.0]])
    found = _on_spine(points, np.array([[3.0, 0, 0], [0.5, 0, 0], [-1.8, 0, 0]]))
    assert found == pytest.approx(np.array([[1.6, 0.1, 0.1], [0.5, 0.1, 0.1], [-1.6, 0.1, 0.1]]))
    row = np.array([[0.0, 0, 0], [3.0, 0, 0], [1.4, 0, 0], [3.0, 0, 0]])
    assert _outlying(row).tolist() == [1, 0, 2]


@pytest.mark.parametrize(("plane", "section"), [(1.0, 1.0), (0.8, 0.9), (1.0, 0.75)])
def test_a_pontoon_displaces_by_its_coefficients(plane: float, section: float) -> None:
    """Waterplane and section after powers of the distance; both sides of a catamaran, in their places."""
    keys = {"waterplane_coefficient": plane, "section_coefficient": section, "freeboard_m": 0.4, "mirror": True}
    hull = PontoonConfig.model_validate(
        {"length_m": 6.0, "beam_m": 1.2, "position_x_m": 0.3, "position_y_m": 1.5, **keys}
    )
    assert hull.sides == (1.5, -1.5)
    assert hull.volume_per_draught == pytest.approx(2 * 6.0 * 1.2 * plane * section)
    vertices, faces = pontoon_mesh(hull, 0.7, along=40, down=20)
    assert vertices.min(axis=0) == pytest.approx([-2.7, -2.1, -0.4])
    assert vertices.max(axis=0) == pytest.approx([3.3, 2.1, 0.7])
    whole = 2 * 6.0 * 1.2 * plane * (0.7 * section + 0.4)
    assert displaced(vertices, faces) == pytest.approx(whole, rel=0.01)
    wet, center = wet_part(vertices * [1, -1, -1], faces, 0.0)
    assert wet == pytest.approx(0.7 * hull.volume_per_draught, rel=0.01)
    assert center[:2] == pytest.approx([0.3, 0.0], abs=1e-6)
    x = np.linspace(0, 1, 4001)
    assert fullness(x, 0.8).mean() == pytest.approx(0.8, abs=1e-3)


def test_the_wet_part_of_a_box_is_what_lies_below_the_level() -> None:
    mesh = box(np.array([2.0, 3.0, 4.0]))
    vertices, faces = mesh.vertices + np.array([0.5, -1.0, 1.0]), mesh.faces.astype(np.int64)
    for level, deep in ((-2.0, 0.0), (-0.3, 0.7), (2.0, 3.0), (5.0, 4.0)):
        found, center = wet_part(vertices, faces, level)
        assert found == pytest.approx(6.0 * deep)
        if deep:
            assert center == pytest.approx([0.5, -1.0, -1.0 + deep / 2])
