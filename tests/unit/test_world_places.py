"""Where a world lies on Earth is said in one place; what it is made of says how it scatters; meshes come back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import yaml
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos.config.loader import load_scenario, to_yaml
from pelagos.errors import InputError
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.world.build import build_world, world_config
from pelagos.world.export import load, save, save_glb
from pelagos.world.material import MATERIALS

ORIGIN = {"latitude_deg": 44.5, "longitude_deg": 9.25}


def test_an_origin_given_twice_is_refused():
    with pytest.raises(InputError, match="in one of the two places"):
        load_scenario({"origin": ORIGIN, "world": {"type": "flat", **ORIGIN}})


@pytest.mark.parametrize("keys", [{"latitude_deg": 44.0}, {"longitude_deg": 9.0}])
def test_half_an_origin_is_refused(keys):
    with pytest.raises(ValidationError, match="go together"):
        world_config({"type": "flat", **keys})


def test_either_place_gives_the_same_world():
    """Fields of a large world by latitude and longitude need the origin while they are built."""
    world = {
        "type": "large", "size_m": [4000, 4000], "memory_mb": 600,
        "things": [{"at_deg": [44.501, 9.25], "at_m": [0, 0, 0], "on_ground": True, "name": "cube"}],
    }  # fmt: skip
    a = pl.Simulation.load({"origin": ORIGIN, "world": world}).world
    b = pl.Simulation.load({"world": {**world, **ORIGIN}}).world
    assert a.origin == b.origin
    cubes = [next(g.vertices for g in w.geometries if g.name == "cube") for w in (a, b)]
    assert cubes[0].tobytes() == cubes[1].tobytes()
    assert cubes[0][:, 0].mean() == pytest.approx(111.1, abs=0.3)  # a thousandth of a degree of latitude


def test_a_scenario_with_an_origin_survives_yaml():
    scenario = load_scenario({"origin": ORIGIN, "world": {"type": "flat"}})
    assert load_scenario(yaml.safe_load(to_yaml(scenario))).located_world == scenario.located_world


def test_a_saved_world_may_be_put_elsewhere(tmp_path):
    world = build_world(world_config({"type": "flat", **ORIGIN}))
    saved = {"type": "saved", "path": str(save(world, tmp_path / "w.npz"))}
    assert build_world(world_config(saved)).origin == world.origin
    assert build_world(world_config({**saved, "latitude_deg": 1.0, "longitude_deg": 2.0})).origin.latitude == 1.0


def test_sediments_scatter_as_the_seabed_model_says():
    assert {n for n, m in MATERIALS.items() if m.sediment} == {n for n, m in MATERIALS.items() if "9407" in m.source}
    assert MATERIALS["sand"].sediment
    assert not MATERIALS["steel"].sediment


def test_gltf_comes_back_upright(tmp_path):
    """Exported, and read again as a mesh: the same triangles at the same places, single precision."""
    thing = {"shape": "cone", "at_m": [3, -4, -6], "size_m": [2, 1, 5], "orientation_deg": [10, 20, 30]}
    world = build_world(world_config({"type": "built", "depth_m": None, "things": [thing]}))
    save_glb(world, tmp_path / "w.glb")
    again = {
        "type": "built",
        "depth_m": None,
        "things": [{"shape": "file", "path": str(tmp_path / "w.glb"), "up": "y"}],
    }
    back = build_world(world_config(again))
    a, b = (np.sort(w.geometries[0].vertices[w.geometries[0].faces].reshape(-1, 9), axis=0) for w in (world, back))
    np.testing.assert_allclose(a, b, atol=1e-5)


def test_a_saved_world_has_each_copy_of_a_model_where_and_as_it_was(tmp_path):
    """Copies of two models by turns, with a mesh of its own between them."""
    rng = np.random.default_rng(4)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.uint32)
    models = [Geometry(rng.normal(size=(4, 3)), faces, 0, 0, 0) for _ in range(2)]
    things = [
        PlacedGeometry(models[k % 2], turn=Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), scale=0.5 + 0.3 * k,
                       offset=rng.normal(scale=9, size=3), material=0, label=2, instance=50 + k, name=f"thing {k}")
        for k in range(5)
    ]  # fmt: skip
    things.insert(2, Geometry(rng.normal(size=(4, 3)), faces, 0, 3, 49, name="own"))
    world = replace(build_world(world_config({"type": "flat"})), geometries=tuple(things))
    for one, other in zip(world.geometries, load(save(world, tmp_path / "w.npz")).geometries, strict=True):
        assert (one.name, one.instance, one.label) == (other.name, other.instance, other.label)
        np.testing.assert_allclose(other.vertices, one.vertices, atol=1e-5)


@pytest.mark.parametrize(("number", "free"), [(127, False), (128, True), (254, True), (255, False), (-1, False)])
def test_labels_of_a_scenario_have_numbers_that_nothing_else_has(number, free):
    keys = {"type": "flat", "labels": {"reef": 200, "cage": number}}
    if free:
        assert build_world(world_config(keys)).label_number("cage") == number
    else:
        with pytest.raises(ValidationError, match=rf"numbers 128 \.\. 254, not cage: {number}"):
            world_config(keys)
