"""What the view draws: nested grids of the ground, waves, hulls that turn, samples."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.config import registry
from pelagos.drawing.sample import Sample, sample_of, waterfall_line
from pelagos.math.geodesy import GeoOrigin
from pelagos.math.rotation import product
from pelagos.viewer.frame import ShownPose, between
from pelagos.viewer.ground import CELLS, NestedGrids
from pelagos.viewer.hull import model_3d
from pelagos.viewer.panels import Panel
from pelagos.viewer.sea_surface import SeaSurface


def sloped(x: np.ndarray[Any, Any], y: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return -10.0 + 0.02 * x - 0.03 * y


@pytest.mark.parametrize("at", [(0.0, 0.0), (413.7, -288.1), (-951.0, 940.0)])
def test_nested_grids_cover_two_kilometres_once_and_without_steps(at: tuple[float, float]) -> None:
    """Seen from above, patches add up to the world's area, however near the edge the place is."""
    grids = NestedGrids(sloped, np.array([[-1000.0, -1000.0], [1000.0, 1000.0]]), 1.0)
    patches = list(grids.patches(*at))
    area, faces = 0.0, 0
    for patch in patches:
        v = patch.vertices[patch.faces].astype(np.float64)
        p, q = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
        area += 0.5 * float(np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum())
        faces += len(patch.faces)
        inside = v.reshape(-1, 3)
        assert inside[:, 2] == pytest.approx(sloped(inside[:, 0], inside[:, 1]), abs=1e-3)
    assert area == pytest.approx(4.0e6, rel=1e-6)
    assert faces <= grids.levels * 2 * CELLS**2
    assert faces < 60_000  # of 8 million at 1 m
    finest = patches[0].vertices
    assert np.abs(finest[:, :2] - np.clip(at, -1000, 1000)).min(axis=0).max() < 1.0


def test_only_what_changed_is_sent_again() -> None:
    grids = NestedGrids(sloped, np.array([[-1000.0, -1000.0], [1000.0, 1000.0]]), 1.0)
    known: dict[int, tuple[object, ...]] = {}
    assert len(list(grids.patches(3.0, 5.0, known))) == grids.levels
    assert not list(grids.patches(3.5, 5.5, known))
    again = [p.level for p in grids.patches(14.0, 5.0, known)]
    assert again[0] == 0
    assert len(again) < grids.levels


def test_waves_of_the_view_are_those_of_the_ocean() -> None:
    """All of a regular sea; NumPy's cosine and the ocean's polynomial agree to 1e-4 of the height."""
    from pelagos import jit
    from pelagos.ocean.config import OceanConfig, build_ocean
    from pelagos.world.material import MATERIALS
    from pelagos.world.world import World

    waves = {"type": "regular", "height_m": 1.2, "period_s": 5.5, "towards_deg": 35}
    ocean = build_ocean(OceanConfig.model_validate({"waves": waves}), World((), tuple(MATERIALS.values())), seed=4)
    surface = SeaSurface.of(ocean)
    x, y, t = np.array([3.0, -41.0, 17.5]), np.array([-8.0, 12.0, 60.0]), 7.3
    true = np.array(ocean.elevation(jit.Float64(x), jit.Float64(y), jit.Float64(t)))
    assert np.abs(true).max() > 0.1
    assert surface.elevation(x, y, t) == pytest.approx(true, abs=2e-4)


def test_hull_is_whole_and_its_fins_follow_the_actuators() -> None:
    vehicle = pl.Vehicle.from_catalogue("remus100")
    model = model_3d(vehicle)
    faces = sum(len(p.faces) for p in model.still) + sum(len(p.faces) for p in model.turning)
    assert faces == len(vehicle.hull.faces)
    names = list(vehicle.actuator_names)
    moved = {names[p.actuator] for p in model.turning}
    assert moved == set(names)
    states = np.array([0.2, -0.1, 900.0])
    angles = model.turned(states, np.zeros(len(model.turning)), 0.1)
    for part, angle in zip(model.turning, angles, strict=True):
        if not part.spins:
            assert angle == states[part.actuator]
    assert model.length == pytest.approx(1.6, abs=0.05)
    rov = model_3d(pl.Vehicle.from_catalogue("bluerov2_heavy"))
    assert len(rov.turning) == len(pl.Vehicle.from_catalogue("bluerov2_heavy").actuator_names)


def test_pose_between_two_others() -> None:
    half = math.radians(20)
    a = ShownPose(np.array([1.0, -2.0, -5.0]), np.array([1.0, 0.0, 0.0, 0.0]))
    b = ShownPose(
        np.array([3.0, 2.0, -6.0]), -np.array([math.cos(half), 0.0, 0.0, math.sin(half)])
    )  # the same, other sign
    middle = between((100, a), (300, b), 200)
    assert middle.position == pytest.approx([2.0, 0.0, -5.5])
    assert abs(middle.euler[2] - (360 - 20)) < 0.01
    turned = product(b.attitude, b.attitude)
    assert ShownPose(a.position, turned).euler[2] == pytest.approx(360 - 80, abs=1e-9)


def test_waterfall_has_port_on_the_left_and_keeps_echoes() -> None:
    levels = np.zeros((2, 1000), dtype=np.uint8)
    levels[0, 900], levels[1, 100] = 255, 255
    line = waterfall_line(levels)
    bright = np.flatnonzero(line.sum(axis=1))
    assert len(bright) == 2
    assert bright[0] == pytest.approx(99 / 2000 * len(line), abs=1)
    assert bright[1] == pytest.approx(1100 / 2000 * len(line), abs=1)


def test_samples_of_readings() -> None:
    """Pictures have the sensors' shapes; points lie where the soundings are; numbers carry names and units."""
    sim = pl.Simulation.load({
        "seed": 2, "world": {"type": "flat", "depth_m": 9.0},
        "agents": {"a": {"vehicle": "remus100", "start": {"position_m": [1, -2], "depth_m": 3.0}, "sensors": {
            "depth": {"type": "depth", "rate_hz": 10}, "dvl": {"type": "dvl", "rate_hz": 5},
            "mbes": {"type": "multibeam", "rate_hz": 5, "beams": 32},
        }}},
    })  # fmt: skip
    found = sim.observe("a", (1.0, -2.0, -3.0))
    configs = {name: m.config for name, m in sim.model.agents["a"].sensors.items()}
    samples = {name: sample_of(configs[name], reading) for name, reading in found.items()}
    assert samples["depth"].numbers["depth [m]"] == pytest.approx(3.0, abs=0.2)
    assert samples["dvl"].beams is not None
    assert samples["dvl"].beams[:, 2] == pytest.approx([-6.0] * 4, abs=0.2)
    points = samples["mbes"].points
    assert points is not None
    assert points[:, 2].mean() == pytest.approx(-6.0, abs=0.2)
    swath = samples["mbes"].swath
    assert swath is not None
    assert swath.shape == (32,)
    assert swath == pytest.approx(6.0, abs=0.3)  # below the sonar, not along the beam


def test_ground_of_a_harbour_is_drawn_once() -> None:
    """Its mesh is finer than the height field in places; drawn as a structure too, the two would flicker."""
    from pelagos.config.loader import load_scenario
    from pelagos.viewer.structures import ground_of, parts_of
    from pelagos.world.build import build_world

    harbour = {"type": "harbour", "seed": 4, "grid_m": 1.0, "boulders": 3, "debris": 3}
    world = build_world(load_scenario({"world": harbour, "agents": {"a": {"vehicle": "bluerov2_heavy"}}}).located_world)
    assert world.terrain is not None
    ground = ground_of(world)
    assert ground is not None
    assert ground.name == "seabed"
    assert len(ground.vertices) > world.terrain.z.size  # else this tests nothing
    faces = sum(len(part.faces) for part in parts_of(world)[0])
    assert faces == sum(len(g.faces) for g in world.still) - len(ground.faces)


def test_colours_of_a_multibeam_mean_the_same_depth_in_all_lines() -> None:
    """The bar holds all lines; two lines at one depth are of one colour; noise on a plain is not relief."""
    config = registry.find("sensor", "multibeam").config.model_validate({"type": "multibeam", "beams": 16})
    panel = Panel(config)
    flat = np.full(16, 7.3, dtype=np.float32) + np.linspace(-0.02, 0.02, 16, dtype=np.float32)
    panel.take(Sample("a.m", "multibeam", 0, swath=flat))
    assert panel.scale == pytest.approx((6.3, 8.3), abs=0.01)
    deep = np.linspace(5.0, 31.0, 16, dtype=np.float32)
    panel.take(Sample("a.m", "multibeam", 1, swath=deep))
    panel.take(Sample("a.m", "multibeam", 2, swath=flat))
    assert panel.scale == pytest.approx(tuple(np.percentile(deep, [3, 97])), abs=1e-4)
    picture = panel.picture()
    assert isinstance(picture, np.ndarray)
    np.testing.assert_array_equal(picture[0], picture[2])
    assert picture[1, 0].sum() > picture[1, -1].sum() + 200  # deep is dark
    assert not picture[3:].any()  # no pings yet
    panel.clear()
    assert panel.scale is None
    assert panel.picture() is None


def curved(x: np.ndarray[Any, Any], y: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return np.where(x > 310.3, np.nan, -20.0 + 5 * np.sin(x / 7) * np.cos(y / 5))


@pytest.mark.parametrize("at", [(0.0, 0.0), (133.7, -88.1), (-241.0, 310.0)])
def test_grids_of_a_curved_ground_meet_without_a_gap(at: tuple[float, float]) -> None:
    """Along each side of a grid that lies in the world its edge is that of the coarser one around, and no face has a
    corner where there is no ground."""
    grids = NestedGrids(curved, np.array([[-300.0, -280.0], [340.0, 350.0]]), 1.0)
    patches = list(grids.patches(*at))
    for patch in patches:
        assert np.unique(patch.faces).tolist() == list(range(len(patch.vertices)))
        assert patch.vertices[:, 0].max(initial=-1e9) <= 310.3
        assert (patch.vertices[:, :2] >= [-300, -280]).all()
        assert patch.vertices[:, 1].max(initial=-1e9) <= 350
    met = 0
    for fine, coarse in itertools.pairwise(patches):
        step = 2.0**fine.level
        low = step * np.array(fine.corner)
        for axis in (0, 1):
            for line in (low[axis], low[axis] + CELLS * step):
                ends = []
                for patch in (fine, coarse):
                    on = patch.vertices[np.abs(patch.vertices[:, axis] - line) < 1e-3].astype(float)
                    inside = (on[:, 1 - axis] >= low[1 - axis]) & (on[:, 1 - axis] <= low[1 - axis] + CELLS * step)
                    ends.append(on[inside][np.argsort(on[inside, 1 - axis])][:, [1 - axis, 2]])
                if min(map(len, ends)) < 3:  # at the rim of the world
                    continue
                both = ends[0][(ends[0][:, 0] >= ends[1][0, 0]) & (ends[0][:, 0] <= ends[1][-1, 0])]
                assert both[:, 1] == pytest.approx(np.interp(both[:, 0], *ends[1].T), abs=2e-5)
                assert len(both) >= len(ends[1])
                met += 1
    assert met > 8


def test_a_curtain_hangs_in_the_water_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """From south to north: a bed at 20 m, an island of 3 m, and no ground at all, where it ends at the world's foot."""
    from pelagos.viewer import section

    world: Any = SimpleNamespace(
        bounds=np.array([[-40.0, -70.0, -31.0], [60.0, 10.0, 4.0]]),
        height=lambda x, y: np.where(x < -10, -20.0, np.where(x < 10, 3.0, np.nan)),
    )
    asked: list[Any] = []

    def sampled(field: Any, points: np.ndarray[Any, Any], t: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        asked.append((field, t))
        warm = np.where(np.abs(points[:, 0]) < 10, 99.0, 10 + points[:, 2] / 10)  # on land there is no water
        return warm[:, None] if field == "warm" else np.stack([0.6 * warm, 0 * warm, -0.8 * warm], axis=1)

    monkeypatch.setattr(section, "sampled", sampled)
    ocean: Any = SimpleNamespace(temperature="warm", tracers=("dye",), tracer=lambda name, *_: name)
    found = section.curtain(ocean, world, section.Asked("temperature"), np.array([7.0, -13.0, -4.0]), 31.5)
    assert asked[0][0] == "warm"
    assert (asked[0][1] == 31.5).all()
    x = np.linspace(-40, 60, 81)
    bed = np.where(x < -10, -20.0, np.where(x < 10, 0.0, -31.0))
    places = found.vertices.reshape(81, 33, 3)
    assert places[..., 0] == pytest.approx(np.broadcast_to(x[:, None], (81, 33)))
    assert places[..., 1] == pytest.approx(-13.0)
    assert places[..., 2] == pytest.approx(bed[:, None] * np.linspace(0, 1, 33), abs=1e-5)
    columns = np.unique(found.faces // 33)
    assert columns.tolist() == np.flatnonzero(bed < 0).tolist()
    pairs = int(((bed < 0)[1:] & (bed < 0)[:-1]).sum())
    assert len(found.faces) == pairs * 32 * 2
    assert (found.low, found.high) == pytest.approx((10 - 3.1, 10.0))
    assert (found.title, found.unit) == ("temperature", "°C")
    flow = section.curtain(ocean, world, section.Asked("current", "east"), np.array([30.0, -13.0, -4.0]), 0.0)
    assert (flow.low, flow.high) == pytest.approx((6.9, 10.0))  # the length of the vector
    assert np.ptp(flow.vertices[:, 0]) == 0
    assert [flow.vertices[:, 1].min(), flow.vertices[:, 1].max()] == [-70, 10]
    assert section.curtain(ocean, world, section.Asked("tracer:dye"), np.zeros(3), 0.0).title == "dye"
    assert section.sections(ocean)["tracer:dye"] == "dye"
    dry: Any = SimpleNamespace(bounds=world.bounds, height=lambda x, y: 0 * x + 2.0)
    assert len(section.curtain(ocean, dry, section.Asked("temperature"), np.zeros(3), 0.0).faces) == 0


def test_the_largest_things_are_drawn_and_the_rest_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 12 faces each, but for one of 80, where 40 fit; things of one material are one part, in the world's frame."""
    from pelagos.viewer import structures
    from pelagos.world import shapes
    from pelagos.world.site import Site

    site = Site()
    for k, (size, what) in enumerate(((1.0, "steel"), (5.0, "wood"), (3.0, "steel"), (2.0, "gold"), (4.0, "wood"))):
        box = shapes.box((0.5, size, 0.3)).moved((3.0 * k, -2.0 * k, -k))
        site.add(box, what, label="cube", name=str(k))
    site.add(shapes.sphere(4.0, sides=10, rings=5), "red", label="sphere", name="ball")
    world = site.world(name="t", description="", origin=GeoOrigin(0.0, 0.0))
    assert structures.ground_of(world) is None
    monkeypatch.setattr(structures, "MOST_FACES", 40)
    made, left = structures.parts_of(world)
    assert left == 3
    assert {p.name: len(p.faces) for p in made} == {"wood": 24, "steel": 12}
    wood = next(p for p in made if p.name == "wood")
    expected = np.concatenate([g.vertices for g in world.geometries if g.name in ("1", "4")])
    assert sorted(wood.vertices.tolist()) == sorted(expected.astype(np.float32).tolist())
    area = lambda v, f: np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1).sum() / 2
    boxes = sum(2 * (0.5 * s + 0.3 * s + 0.15) for s in (5.0, 4.0))
    assert area(wood.vertices.astype(float), wood.faces) == pytest.approx(boxes, rel=1e-5)
    monkeypatch.setattr(structures, "MOST_FACES", 400_000)
    made, left = structures.parts_of(world)
    assert (left, sum(len(p.faces) for p in made)) == (0, world.triangles)


def test_the_ground_is_what_is_as_wide_as_the_height_field_and_nowhere_off_it() -> None:
    """Neither a plate that lies on it nor a lid as wide, nor a thing without faces, which come before it."""
    from pelagos.raycast.geometry import Geometry
    from pelagos.viewer import structures
    from pelagos.world import shapes
    from pelagos.world.site import Site
    from pelagos.world.terrain import HeightField

    site = Site()
    site.geometries.append(Geometry(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.uint32), 0, 1, 90))
    site.add(shapes.plane((30, 22)).moved((1, 2, -9.9)), "steel", label="cube", name="plate")
    site.add(shapes.plane((80, 60)).moved((0, 0, -3)), "steel", label="cube", name="lid")
    site.ground(HeightField(-40.0, -30.0, 2.0, np.full((41, 31), -10.0)), "sand")
    world = site.world(name="t", description="", origin=GeoOrigin(0.0, 0.0))
    found = structures.ground_of(world)
    assert found is not None
    assert found.name == "seabed"
