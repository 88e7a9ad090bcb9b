"""Things that a sonar may miss: which are looked for, as what, where they are, and their mirror's echo."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.acoustics.specular import flat_side, round_side
from pelagos.acoustics.sphere_scattering import Filling, sphere_form
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.sonar.ping.mirror_echo import mirror_echo
from pelagos.sensors.sonar.ping.target_echoes import excluded_share
from pelagos.sensors.sonar.ping.target_place import Place, target_places
from pelagos.sensors.sonar.ping.targets import BOX, CYLINDER, OTHER, SPHERE, Band, is_smooth, targets
from pelagos.world.material import MATERIALS
from pelagos.world.shapes import box, sphere

NAMES = ("sand", "steel", "copper", "rusted_steel", "rock")
PALETTE = tuple(MATERIALS[name] for name in NAMES)
BAND = Band(50e3, 10e3, 400.0, 80.0)
WAVE = 1500.0 / 50e3


def thing(
    shape: Any, material: str, instance: int, at: tuple[float, ...] = (0.0, 0.0, 0.0), turn: Any = None
) -> Geometry:
    vertices = np.asarray(shape.vertices, float)
    vertices = (vertices if turn is None else turn.apply(vertices)) + np.array(at)
    return Geometry(vertices, shape.faces, NAMES.index(material), 1, instance)


def lump(radius: float, material: str, instance: int) -> Geometry:
    """Of no simple shape."""
    rough = np.random.default_rng(instance).normal(size=(9, 3))
    rough *= radius / np.linalg.norm(rough, axis=1, keepdims=True) * np.linspace(0.3, 1.0, 9)[:, None]
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.uint32)
    return Geometry(rough, faces, NAMES.index(material), 1, instance)


def scene(standing: list[Geometry], bodies: list[tuple[Geometry, int]] = [], copies: int = 1) -> Any:  # noqa: B006
    return SimpleNamespace(standing=standing, bodies=bodies, copies=copies)


def test_things_are_looked_for_by_size_reach_and_smoothness() -> None:
    """The smallest first. A lump of 0.8 m is met by fewer than 24 of 400 rays a steradian from 80 m; a rusty box
    of 30 m is met by more and is not smooth (1 mm in 30 mm is below 0.12 of it, 1 mm in 7 mm is not); a steel is."""
    lumps = [lump(0.8, "rock", 4), lump(3.0, "rock", 5)]
    boxes = [thing(box((30.0, 30.0, 9.0)), "steel", 7), thing(box((32.0, 30.0, 9.0)), "rusted_steel", 8)]
    ball = thing(sphere(0.2, sides=24, rings=12), "copper", 2, (3.0, -1.0, 2.0))
    sea = scene([*boxes, *lumps, ball])
    found = targets(sea, PALETTE, BAND)
    assert found is not None
    assert np.array(found.instance).tolist() == [2, 4, 7, 8]
    assert np.array(found.kind).tolist() == [SPHERE, OTHER, BOX, BOX]
    assert is_smooth(found)
    higher = targets(sea, PALETTE, replace(BAND, frequency_hz=200e3, bandwidth_hz=40e3))
    assert higher is not None
    assert np.array(higher.instance).tolist() == [2, 4, 7]
    near = targets(scene([lumps[0]]), PALETTE, replace(BAND, reach=5.0))
    assert near is None
    alone = targets(scene([lumps[0]]), PALETTE, replace(BAND, rays_per_sr=4000.0))
    assert alone is not None
    assert not is_smooth(alone)
    assert np.array(found.of_instance).tolist() == [4, 4, 0, 4, 1, 4, 4, 2, 3, 4]
    assert np.array(found.centre).T[0] == pytest.approx([3.0, -1.0, 2.0], abs=1e-6)
    assert np.array(found.radius)[0] == pytest.approx(0.2, rel=1e-3)
    assert sorted(np.array(found.half).T[2]) == pytest.approx([4.5, 15.0, 15.0], rel=1e-5)
    assert np.array(found.body).tolist() == [NO_BODY] * 4


def test_things_are_as_strong_as_what_they_are_made_of() -> None:
    """(Z - 1)/(Z + 1) of the impedance; roughness in wavelengths; Lambert's mu; a copper sphere is an elastic one over
    the band, a rusty one rigid times what its surface reflects, a large one half its radius."""
    balls = [thing(sphere(r, sides=24, rings=12), m, k + 1) for k, (r, m) in enumerate(
        ((0.02, "copper"), (0.1, "rusted_steel"), (0.3, "sand"), (5.0, "steel"))
    )]  # fmt: skip
    found = targets(scene(balls), PALETTE, BAND)
    assert found is not None
    made = [MATERIALS[m] for m in ("copper", "rusted_steel", "sand", "steel")]
    assert np.array(found.instance).tolist() == [1, 2, 3, 4]
    impedance = np.array([m.density_ratio * m.sound_speed_ratio for m in made])
    mirror = np.abs(impedance - 1) / (impedance + 1)
    assert np.array(found.mirror) == pytest.approx(mirror, rel=1e-5)
    assert np.array(found.smooth) == pytest.approx(np.array([1e-5, 1e-3, 1.0, 2e-5]) / WAVE, rel=1e-5)
    assert np.array(found.lambert) == pytest.approx([10 ** (m.lambert_db / 10) for m in made], rel=1e-5)
    lines = np.linspace(45e3, 55e3, 33)
    copper = Filling(made[0].density_ratio, made[0].sound_speed_ratio, 2288.5 / 1500.0)
    form = np.array(found.form)
    for k, filling, factor in ((0, copper, 1.0), (1, None, mirror[1]), (2, None, mirror[2])):
        radius = float(np.array(found.radius)[k])
        exact = np.sqrt((np.abs(sphere_form(radius, lines, filling, sound_speed=1500.0)) ** 2).mean()) * factor
        assert form[k] == pytest.approx(exact, rel=1e-4)
    assert form[3] == pytest.approx(2.5 * mirror[3], rel=1e-3)


def test_what_moves_is_a_row_of_each_copy() -> None:
    """Two vehicles with one mesh each in three copies, and a prop that only one copy has: rows of the moving table."""
    hull, fin = thing(box((0.5, 0.3, 0.2)), "steel", 3), thing(box((0.1, 0.2, 0.1)), "steel", 9)
    bodies = [(hull, 0), (hull, 1), (hull, 2), (fin, 0), (fin, 1), (fin, 2), (lump(0.2, "rock", 5), 1)]
    found = targets(scene([], bodies, copies=3), PALETTE, BAND)
    assert found is not None
    assert np.array(found.instance).tolist() == [9, 3]
    assert np.array(found.body).tolist() == [3, 4, 5, 0, 1, 2]


def test_a_thing_is_seen_where_its_body_carries_it_in_the_sonars_copy() -> None:
    """Two things, one of them carried, in two copies; lanes of two vehicles, vehicle by vehicle."""
    turns = Rotation.random(4, random_state=2)
    q = np.roll(turns.as_quat(), 1, axis=1)
    centre = np.array([[3.0, -2.0, -9.0], [0.4, 0.3, -0.2]])
    at, moves = np.array([[10.0, 4.0, -5.0], [-8.0, 7.0, -6.0]]), np.array([[1.0, 0.2, 0.0], [0.0, -0.7, 0.3]])
    rows = lambda v, kind: kind(np.ascontiguousarray(np.asarray(v).T))
    one = jit.Float([0.5, 0.7])
    things: Any = SimpleNamespace(
        body=jit.UInt32([NO_BODY, NO_BODY, 0, 1]), centre=rows(centre, jit.Array3f64), axes=rows(q[:2], jit.Array4f),
        kind=jit.UInt32([1, 2]), half=rows([[1, 2, 3], [4, 5, 6]], jit.Array3f), radius=one, form=one * 2,
        mirror=one * 3, smooth=one * 4, lambert=one * 5, instance=jit.UInt32([7, 8]),
    )  # fmt: skip
    tables = SimpleNamespace(
        body_attitude=rows(q[2:], jit.Array4f),
        body_position=rows(at, jit.Array3f64),
        body_velocity=rows(moves, jit.Array3f),
    )
    here = np.random.default_rng(3).uniform(-20, 20, (4, 3))
    lanes: Any = SimpleNamespace(copy=jit.UInt32([0, 1, 2, 3]), position=rows(here, jit.Array3f64))
    caster: Any = SimpleNamespace(tables=tables)
    found = target_places(caster, things, lanes, jit.UInt32(np.arange(8)), 2)
    dr.eval(found)
    for lane in range(4):
        for k in range(2):
            row, copy = lane * 2 + k, lane % 2
            place = centre[0] if k == 0 else at[copy] + turns[2 + copy].apply(centre[1])
            own = turns[0] if k == 0 else turns[2 + copy] * turns[1]
            way = place - here[lane]
            distance = np.linalg.norm(way)
            assert np.array(found.distance)[row] == pytest.approx(distance, rel=1e-5)
            assert np.array(found.direction).T[row] == pytest.approx(way / distance, abs=1e-5)
            assert np.array(found.local).T[row] == pytest.approx(own.inv().apply(-way), abs=1e-4)
            seen = Rotation.from_quat(np.roll(np.array(found.attitude).T[row], -1)).as_matrix()
            assert seen == pytest.approx(own.as_matrix(), abs=1e-5)
            assert np.array(found.velocity).T[row] == pytest.approx(moves[copy] if k else [0, 0, 0], abs=1e-6)
            assert np.array(found.body)[row] == (copy if k else NO_BODY)
            assert np.array(found.half).T[row].tolist() == [[1, 2, 3], [4, 5, 6]][k]
            names = ("radius", "form", "mirror", "smooth", "lambert")
            known = [np.array(getattr(found, n))[row] for n in names]
            assert known == pytest.approx(np.array([1, 2, 3, 4, 5]) * [0.5, 0.7][k], rel=1e-5)
            assert (np.array(found.kind)[row], np.array(found.instance)[row]) == ([1, 2][k], [7, 8][k])


TURN, COUNT = Rotation.from_rotvec([0.4, -1.1, 0.7]), 60
SOLIDS = {BOX: (1.2, 0.5, 0.8), CYLINDER: (0.6, 0.6, 1.1), SPHERE: (0.5, 0.5, 0.5), OTHER: (0.5, 0.4, 0.3)}
"""Half lengths by kind."""


def around(kind: int) -> np.ndarray:
    """The sonar's places about a thing, in its own frame."""
    local = np.random.default_rng(kind).normal(size=(COUNT, 3))
    return np.asarray(local * 4.0 / np.linalg.norm(local, axis=1, keepdims=True))


@pytest.fixture(scope="module")
def echo() -> Any:
    """Mirrors' echoes of all solids from all around: size, reach and way by kind."""
    local, half = np.concatenate([around(k) for k in SOLIDS]), np.repeat(list(SOLIDS.values()), COUNT, axis=0)
    rows = lambda v: jit.Array3f(np.ascontiguousarray(v.T))
    wide = lambda v: jit.Float(np.full(len(local), v))
    q = np.tile(np.roll(TURN.as_quat(), 1), (len(local), 1))
    place = Place(
        kind=jit.UInt32(np.repeat(list(SOLIDS), COUNT)), distance=wide(4.0), direction=rows(0 * local),
        local=rows(local), attitude=jit.Array4f(np.ascontiguousarray(q.T)), half=rows(half),
        radius=jit.Float(np.linalg.norm(half, axis=1)),
        form=wide(0.4), mirror=wide(0.8), smooth=wide(0.0), lambert=wide(0.0), instance=jit.UInt32(0),
        body=jit.UInt32(0), velocity=rows(0 * local), small=jit.Bool(True),
    )  # fmt: skip
    hearing: Any = SimpleNamespace(wavelength=WAVE)
    made = mirror_echo(place, hearing)
    dr.eval(made)
    size, reach, way = np.array(made.size), np.array(made.reach), np.array(made.way).T
    return {
        k: (size[j : j + COUNT], reach[j : j + COUNT], way[j : j + COUNT])
        for k, j in zip(SOLIDS, range(0, 240, COUNT), strict=True)
    }


def check(found: Any, foot: np.ndarray, local: np.ndarray, expected: np.ndarray) -> None:
    """Where nothing is heard no place matters."""
    size, reach, way = found
    heard = expected > 1e-6
    assert heard.sum() > 30
    assert size == pytest.approx(expected, rel=1e-3, abs=1e-6)
    assert way[heard] == pytest.approx(TURN.apply(foot - local)[heard], abs=1e-3)
    assert reach[heard] == pytest.approx(np.linalg.norm(foot - local, axis=1)[heard], rel=1e-3)


def flat(half: tuple[Any, Any], offset: tuple[Any, Any], height: Any) -> np.ndarray:
    """A flat side's echo, nothing from behind it."""
    rows = [jit.Float(np.broadcast_to(v, np.shape(height)).copy()) for v in (*half, *offset, height)]
    loud, _, _ = flat_side((rows[0], rows[1]), (rows[2], rows[3]), rows[4], jit.Float(WAVE))
    return np.asarray(np.where(np.asarray(height) > 0.0, 0.8 * np.array(loud), 0.0))


def test_a_box_is_the_loudest_of_the_sides_that_face_the_sonar(echo: Any) -> None:
    """From the place on it that is nearest; each of six sides by itself."""
    half, local = np.array(SOLIDS[BOX]), around(BOX)
    best, foot = np.zeros(COUNT), np.zeros((COUNT, 3))
    for axis in range(3):
        u, v = (k for k in range(3) if k != axis)
        for sign in (1.0, -1.0):
            level = flat((half[u], half[v]), (local[:, u], local[:, v]), sign * local[:, axis] - half[axis])
            here = np.clip(local, -half, half)
            here[:, axis] = sign * half[axis]
            foot = np.where((level > best)[:, None], here, foot)
            best = np.maximum(best, level)
    check(echo[BOX], foot, local, best)


def test_a_cylinder_is_its_side_or_a_square_as_large_as_its_cap(echo: Any) -> None:
    (a, _, h), local = SOLIDS[CYLINDER], around(CYLINDER)
    across = np.hypot(local[:, 0], local[:, 1])
    side, _, _ = round_side(jit.Float(a), jit.Float(h), jit.Float(local[:, 2]), jit.Float(across), jit.Float(WAVE))
    edge = 0.5 * math.sqrt(math.pi) * a
    cap = flat((edge, edge), (local[:, 0], local[:, 1]), np.abs(local[:, 2]) - h)
    loud = [np.where(across > a, 0.8 * np.array(side), 0.0), cap]
    rim = [local[:, 0] * a / across, local[:, 1] * a / across, np.clip(local[:, 2], -h, h)]
    top = [np.clip(local[:, 0], -edge, edge), np.clip(local[:, 1], -edge, edge), np.sign(local[:, 2]) * h]
    foot = np.where((loud[1] > loud[0])[:, None], np.stack(top, axis=-1), np.stack(rim, axis=-1))
    check(echo[CYLINDER], foot, local, np.maximum(*loud))


def test_a_sphere_echoes_from_its_near_side(echo: Any) -> None:
    """|f|/(r (r + a)) at r from there; things of no shape have no mirror's echo."""
    local, radius = around(SPHERE), math.sqrt(0.75)
    check(echo[SPHERE], local * radius / 4.0, local, np.full(COUNT, 0.4 / ((4.0 - radius) * 4.0)))
    assert (echo[OTHER][0] == 0.0).all()


def test_rays_that_meet_a_thing_with_rays_of_its_own_do_not_count() -> None:
    """Instances 2 and 4 are things 0 and 1; the first is small in the second lane alone; others are whole."""
    things: Any = SimpleNamespace(kind=jit.UInt32([1, 2]), of_instance=jit.UInt32([2, 2, 0, 2, 1, 2]))
    sighting: Any = SimpleNamespace(small=jit.Bool([False, True, True, False]), dulled=jit.Float([0.2, 0.3, 0.4, 0.5]))
    instance = jit.UInt32([2, 4, 1, 0xFFFF, 2, 4, 3, 5])
    lane = jit.UInt32([0, 0, 0, 0, 1, 1, 1, 1])
    small, left = excluded_share(things, sighting, instance, lane)
    assert np.array(small).tolist() == [False, True, False, False, True, False, False, False]
    assert np.array(left) == pytest.approx([0.2, 0.3, 1.0, 1.0, 0.4, 0.5, 1.0, 1.0])
