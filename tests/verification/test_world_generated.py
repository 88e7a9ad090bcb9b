"""Generated worlds: numbers by Poisson, sizes by Kolmogorov and Smirnov, spectra, clearances, one seed one world."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections import Counter
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial.distance import pdist
from scipy.stats import chi2, kstest, lognorm, loguniform, norm, poisson, uniform

from pelagos.errors import WorldError
from pelagos.world import shapes
from pelagos.world.generate.draw import Distribution
from pelagos.world.generate.generated import GeneratedConfig
from pelagos.world.generate.harbour import _lie
from pelagos.world.generate.landform import LANDFORMS
from pelagos.world.generate.objects import KINDS
from pelagos.world.generate.relief import fractal
from pelagos.world.generate.scatter import Places
from pelagos.world.generate.thing import Part, Thing, stand
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField


def build(**keys):
    return GeneratedConfig(**keys).build()


def digest(world):
    h = hashlib.sha256()
    for g in world.geometries:
        h.update(np.ascontiguousarray(g.vertices).tobytes() + g.faces.tobytes() + g.face_materials.tobytes())
        h.update(f"{g.name} {g.label} {g.instance}".encode())
    return h.hexdigest()


MANY = {
    "size_m": (120, 120), "depth_m": 25, "terrain": {"kind": "mixed", "relief_m": 3},
    "objects": (
        {"kind": "wreck_boat", "count": 1}, {"kind": "pipeline", "count": 1}, {"kind": "cable", "count": 1},
        {"kind": "boulder", "density_per_ha": 40, "cluster": 0.5}, {"kind": "tyre", "density_per_ha": 10},
        {"kind": "barrel", "density_per_ha": 10, "min_distance_m": 1.0},
    ),
}  # fmt: skip


@cache
def many(seed):
    """The world of MANY, which no test changes."""
    return build(seed=seed, **MANY)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_closed_faces_outwards_and_has_its_size(kind):
    rng = np.random.default_rng(0)
    for size in KINDS[kind].size:
        thing = KINDS[kind].build(size, rng, 20.0)
        for part in thing.parts:
            assert part.mesh.closed, kind
            assert part.mesh.volume > 0, kind
        assert thing.radius > 0
        points = np.concatenate([p.vertices for p in thing.parts])
        assert np.hypot(points[:, 0], points[:, 1]).max() <= thing.radius + 1e-9


def test_structures_stand_in_the_ground_and_reach_where_they_should():
    """Depth 20 m: a dam 25 m high, battered by 12 %, 3 m in the ground; a quay's ladder from 6 m below the water to
    3.3 m above; a manifold's frame as wide as it is said to be, but for its bars' own thickness."""
    rng = np.random.default_rng(3)
    body = KINDS["dam"].build(60.0, rng, 20.0).parts[0].vertices
    foot = body[np.abs(body[:, 2] + 3.0) < 1e-6]
    assert foot[:, 1].max() == pytest.approx(0.35 * 25.0 + 3.0)
    assert np.abs(foot[:, 1] + 0.12 * 25.0).min() == pytest.approx(0.0, abs=1e-6)  # buttresses stand before it
    assert body[:, 2].min() == pytest.approx(-3.0)
    assert body[:, 2].max() == pytest.approx(25.0)
    rungs = KINDS["quay_wall"].build(30.0, rng, 20.0).parts[2].vertices
    assert [rungs[:, 2].min(), rungs[:, 2].max()] == pytest.approx([14.0, 23.3])
    assert rungs[:, 0].mean() == pytest.approx(14.0, abs=0.05)
    frame = KINDS["manifold"].build(10.0, rng, 20.0).parts[0].vertices
    assert np.abs(frame).max(axis=0)[:2] == pytest.approx([5.0, 3.0], abs=0.018 * 10.0 + 0.05)


@pytest.mark.parametrize("kind", LANDFORMS)
def test_landforms_have_about_the_relief_asked_for(kind):
    world = build(size_m=(300, 300), grid_m=2.0, depth_m=60, terrain={"kind": kind, "relief_m": 10, "roughness_m": 0})
    span = float(np.percentile(world.terrain.z, 99) - np.percentile(world.terrain.z, 1))
    assert (1.5 if kind == "slope" else 0.25) * 10 < span < (5 if kind == "slope" else 1.6) * 10


@pytest.mark.parametrize("slope", [2.0, 3.0, 4.0])
def test_the_spectrum_falls_as_asked(slope):
    """Least squares of the radial spectrum over the middle octaves; leakage moves it by less than 0.25."""
    z = fractal((512, 512), 1.0, np.random.default_rng(1), slope=slope, longest=200, shortest=2)
    assert _fitted_slope(z) == pytest.approx(-slope, abs=0.25)


def _fitted_slope(z):
    """Of the radial power spectrum of 512 x 512 nodes that are 1 m apart."""
    window = np.hanning(512)[:, None] * np.hanning(512)
    power = np.abs(np.fft.fft2(z * window)) ** 2
    k = np.hypot(np.fft.fftfreq(512)[:, None], np.fft.fftfreq(512))
    edges = np.geomspace(0.02, 0.3, 16)
    middle = np.sqrt(edges[1:] * edges[:-1])
    mean = [power[(k >= a) & (k < b)].mean() for a, b in pairwise(edges)]
    return np.polyfit(np.log(middle), np.log(mean), 1)[0]


def test_numbers_follow_poisson():
    """40 a hectare on 1.44 ha: each world's count within 1e-6 bounds, the mean of 20 within 5 standard errors, and
    their dispersion, chi-squared with 19 degrees of freedom, within 1e-4 bounds: counts that never vary fail."""
    expected = 40 * 1.44
    counts = []
    for seed in range(20):
        world = build(seed=seed, size_m=(120, 120), grid_m=4.0, objects=({"kind": "tyre", "density_per_ha": 40},))
        counts.append(Counter(g.name for g in world.geometries)["tyre"])
    low, high = poisson.ppf([1e-6, 1 - 1e-6], expected)
    assert all(low <= c <= high for c in counts)
    assert abs(np.mean(counts) - expected) < 5 * np.sqrt(expected / 20)
    dispersion = float(((counts - np.mean(counts)) ** 2).sum() / np.mean(counts))
    assert chi2.ppf(1e-4, 19) < dispersion < chi2.ppf(1 - 1e-4, 19)


def test_sizes_follow_the_distribution_asked_for():
    """Drums keep their proportions: their greatest extent is the size times a constant."""
    world = build(
        size_m=(300, 300), grid_m=5.0, objects=({"kind": "manta_mine", "count": 400, "size_m": (0.5, 2.5)},),
    )  # fmt: skip
    size = [np.ptp(g.vertices[:, :2], axis=0).max() for g in world.geometries if g.name == "truncated cone mine"]
    assert len(size) == 400
    assert kstest(size, "uniform", args=(0.5, 2.0)).pvalue > 1e-3


@pytest.mark.parametrize(
    ("given", "low", "high"),
    [({"uniform": (1, 2)}, 1, 2), ({"loguniform": (0.1, 10)}, 0.1, 10), ({"choice": (3, 3.5)}, 3, 3.5),
     ({"normal": (5, 0.1)}, 4, 6), ({"lognormal": (2, 0.1)}, 1, 4)],
)  # fmt: skip
def test_distributions(given, low, high):
    rng = np.random.default_rng(0)
    values = [Distribution(**given).draw(rng) for _ in range(200)]
    assert low <= min(values) <= max(values) <= high
    with pytest.raises(ValidationError, match="exactly one"):
        Distribution(**given, **({"choice": (1,)} if "choice" not in given else {"normal": (1, 1)}))


@pytest.mark.parametrize(
    ("given", "law"),
    [({"uniform": (1, 2)}, uniform(1, 1)), ({"loguniform": (0.1, 10)}, loguniform(0.1, 10)),
     ({"normal": (5, 0.3)}, norm(5, 0.3)), ({"lognormal": (2, 0.4)}, lognorm(0.4, scale=2))],
)  # fmt: skip
def test_draws_have_the_law_they_name(given, law):
    rng = np.random.default_rng(3)
    assert kstest([Distribution(**given).draw(rng) for _ in range(1000)], law.cdf).pvalue > 1e-3


@pytest.mark.parametrize("slope", [2.4, 3.6])
def test_the_ground_of_a_world_has_the_spectrum_asked_for(slope):
    terrain = {"kind": "flat", "relief_m": 4, "wavelength_m": 200, "spectrum_slope": slope, "roughness_m": 0}
    z = build(size_m=(511, 511), grid_m=1.0, depth_m=60, terrain=terrain).terrain.z
    assert _fitted_slope(z) == pytest.approx(-slope, abs=0.25)


@pytest.mark.parametrize("seed", range(10))
def test_nothing_interpenetrates(seed):
    """No two things' outlines on the ground meet, and nothing stands on a pipe or a cable."""
    assert overlaps(many(seed)) == []


def test_overlaps_would_be_found(monkeypatch):
    """Where places that are taken are given again, things do interpenetrate."""
    monkeypatch.setattr(Places, "free", lambda *_: True)
    pairs = overlaps(build(seed=0, **MANY))
    assert any(isinstance(a, str) for a, _ in pairs)
    assert any(isinstance(a, int) for a, _ in pairs)


@pytest.mark.slow
def test_nothing_interpenetrates_over_a_hundred_seeds():
    assert [(seed, pair) for seed in range(100) for pair in overlaps(build(seed=seed, **MANY))] == []


def overlaps(world):
    """Pairs of instances whose convex outlines in plan meet: those are at least as large as the things."""
    things: dict[int, list[np.ndarray]] = {}
    for g in world.geometries:
        if g.name not in ("seabed", "pipeline", "cable", "pipe supports"):
            things.setdefault(g.instance, []).append(g.vertices[:, :2])
    hulls = {k: np.concatenate(v) for k, v in things.items()}
    middles = {k: (v.max(axis=0) + v.min(axis=0)) / 2 for k, v in hulls.items()}
    radii = {k: np.linalg.norm(v - middles[k], axis=1).max() for k, v in hulls.items()}
    keys = list(hulls)
    near = [
        (a, b)
        for i, a in enumerate(keys)
        for b in keys[i + 1 :]
        if np.linalg.norm(middles[a] - middles[b]) < radii[a] + radii[b]
    ]
    crossed = [
        (line.name, k)
        for line in world.geometries
        if line.name in ("pipeline", "cable")
        for k, points in hulls.items()
        if _inside(points, line.vertices[:, :2])
    ]
    return [(a, b) for a, b in near if _overlap(hulls[a], hulls[b])] + crossed


def _inside(outline, points):
    """Whether any of the points lies in the convex outline of a point set."""
    from scipy.spatial import ConvexHull

    sides = ConvexHull(outline).equations
    return bool((points @ sides[:, :2].T + sides[:, 2] < 0).all(axis=1).any())


def _overlap(a, b):
    """Whether the convex outlines of two point sets meet: no axis among their edges' normals separates them."""
    from scipy.spatial import ConvexHull

    for points in (a, b):
        normals = ConvexHull(points).equations[:, :2]
        for n in normals:
            pa, pb = a @ n, b @ n
            if pa.max() < pb.min() or pb.max() < pa.min():
                return False
    return True


def test_discs_never_touch_over_a_dozen_seeds():
    for seed in range(12):
        rng = np.random.default_rng(seed)
        places = Places((-40, 40), (-40, 40))
        for _ in range(150):
            places.find(rng, rng.uniform(0.2, 4), around=(np.zeros(2), 15.0) if rng.uniform() < 0.5 else None, tries=20)
        x, y, r = np.array(places.taken).T
        gap = np.hypot(x[:, None] - x, y[:, None] - y) - r[:, None] - r
        assert gap[~np.eye(len(r), dtype=bool)].min() > 0


def test_same_seed_same_bytes_other_seed_other_bytes():
    assert digest(build(seed=5, **MANY)) == digest(many(5))
    assert digest(many(5)) != digest(many(6))


@pytest.mark.parametrize("threads", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_same_bytes_in_another_process(threads):
    """Whatever the order of sets there, and the number of threads."""
    code = (
        "import sys; sys.path.insert(0, 'tests/verification'); import test_world_generated as t;"
        "print(t.digest(t.build(seed=5, **t.MANY)))"
    )
    root = Path(__file__).parents[2]
    few = {"OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads), "PYTHONHASHSEED": str(threads)}
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=root, env={**os.environ, **few}, capture_output=True, text=True
    )
    assert ran.stdout.strip() == digest(many(5)), ran.stderr


def test_one_more_kind_moves_nothing_placed_before():
    fewer = build(seed=5, **(MANY | {"objects": MANY["objects"][:4]}))
    more = many(5)
    stones = [[g.vertices.tobytes() for g in w.geometries if g.name == "boulder"] for w in (fewer, more)]
    assert stones[0] == stones[1]
    assert len(stones[0]) > 10


def test_things_stand_on_the_ground_and_respect_slope_and_depth():
    config = GeneratedConfig(
        size_m=(200, 200), grid_m=2.0, depth_m=30, terrain={"kind": "ridges", "relief_m": 15, "wavelength_m": 60},
        objects=({"kind": "boulder", "count": 120, "size_m": 1.0, "max_slope_deg": 12, "depth_m": (20, 33)},),
        exclude=({"at_m": (0, 0), "radius_m": 30},),
    )  # fmt: skip
    world = config.build()
    for g in world.geometries:
        if g.name == "boulder":
            low, high = g.vertices.min(axis=0), g.vertices.max(axis=0)
            x, y, _ = (low + high) / 2
            ground = float(world.height(x, y))
            assert low[2] < ground + 0.5
            assert high[2] > ground - 0.2
            assert np.hypot(x, y) > 29
            assert -34 < ground < -19


@pytest.mark.parametrize("slope", [(0.9, 0.7), (-0.6, 1.1), (0.8, -0.5), (-1.3, -0.4), (0.0, 0.9), (0.9, 0.0)])
@pytest.mark.parametrize("follow", [1.0, 0.4])
def test_a_thing_lies_flat_on_ground_that_slopes_both_ways(slope, follow):
    """Corners of a plate on z = 3 + f (gx x + gy y), whatever its heading, and as far apart as ever."""
    site = Site()
    plate = shapes.box((2.0, 1.2, 0.4)).moved((0, 0, 0.2))
    stand(site, Thing("plate", "rock", (Part(plate, "rock"),), follow=follow), np.array([5.0, -7.0]), 3.0, slope, 0.7)
    corners = np.asarray(site.geometries[0].vertices, dtype=np.float64) - [5.0, -7.0, 3.0]
    along, across = follow * slope[0], follow * slope[1]
    height = (corners @ [-along, -across, 1.0]) / np.sqrt(along**2 + across**2 + 1.0)  # above the plane
    assert np.allclose(np.sort(np.unique(height.round(6))), [0.0, 0.4], atol=1e-5)
    apart = (np.sort(pdist(np.unique(v.round(5), axis=0))) for v in (corners, plate.vertices))
    assert np.allclose(*apart, atol=1e-4)


def test_what_lies_in_the_harbour_lies_on_its_slope():
    """Without chance its z axis is the normal of the ground, z = 0.5 x - 0.8 y."""
    axis = np.arange(-5.0, 6.0)
    ground = HeightField(-5.0, -5.0, 1.0, 0.5 * axis[:, None] - 0.8 * axis)
    chance = SimpleNamespace(normal=lambda: 0.0, uniform=lambda low, high: 0.7)
    up = _lie(ground, np.array([0.3, -0.4]), chance)[:, 2]
    np.testing.assert_allclose(up, np.array([-0.5, 0.8, 1.0]) / np.sqrt(0.5**2 + 0.8**2 + 1.0), atol=1e-9)


def test_what_finds_no_room_is_said():
    world = build(size_m=(40, 40), objects=({"kind": "wreck_boat", "count": 30},))
    note = next(n for n in world.notes if "wreck_boat" in n)
    placed = int(note.split(": ")[1].split()[0])
    assert 1 <= placed < 30
    assert len({g.instance for g in world.geometries if g.name == "sunken boat"}) == placed


@pytest.mark.parametrize(
    ("keys", "error", "message"),
    [
        ({"objects": ({"kind": "bolder", "count": 1},)}, ValidationError, "did you mean 'boulder'"),
        ({"terrain": {"kind": "hills"}}, ValidationError, "ridges"),
        ({"size_m": (1e5, 1e5)}, WorldError, "larger grid_m"),
        ({"size_m": (0, 10)}, ValidationError, "greater than 0"),
        ({"terrain": {"wavelength_m": 0}}, ValidationError, "greater than 0, not 0"),
        ({"terrain": {"roughness_m": [-1, 1]}}, ValidationError, "at least 0, but this gives -1"),
        ({"terrain": {"spectrum_slope": 40}}, ValidationError, "at most 8, not 40"),
        ({"objects": ({"kind": "tyre", "size_m": [3, 1]},)}, ValidationError, "from the least to the greatest"),
        ({"objects": ({"kind": "tyre", "size_m": {"normal": [1, -2]}},)}, ValidationError, "standard deviation"),
        ({"objects": ({"kind": "tyre", "size_m": {"choice": []}},)}, ValidationError, "at least one value"),
        ({"objects": ({"kind": "tyre", "density_per_ha": -3},)}, ValidationError, "at least 0, not -3"),
    ],
)
def test_bad_input(keys, error, message):
    with pytest.raises(error, match=message):
        build(**keys)


def test_hopeless_densities_end_soon_and_are_counted():
    """4000 boulders of 2 to 3 m on 30 m x 30 m: some are placed, the rest is given up and said."""
    world = build(size_m=(30, 30), objects=({"kind": "boulder", "count": 4000, "size_m": (2, 3)},))
    placed = len({g.instance for g in world.geometries if g.name == "boulder"})
    assert 20 < placed < 200
    assert f"boulder: {placed} of 4000 were placed; no room was found for the rest" in world.notes


def test_a_density_may_be_drawn_too():
    """Between 10 and 200 in a hectare: over 12 seeds, counts differ by far more than Poisson's law lets one density."""
    object_ = {"kind": "tyre", "density_per_ha": [10, 200]}
    counts = [len(build(seed=s, size_m=(100, 100), grid_m=5.0, objects=(object_,)).geometries) - 1 for s in range(12)]
    assert 10 <= np.mean(counts) <= 200
    assert np.var(counts) > 5 * np.mean(counts)


def test_land_is_said():
    assert any("100.0 % of the area is land" in n for n in build(size_m=(40, 40), depth_m=-5).notes)


def test_rectangles_stay_free():
    """Nothing of 200 mines stands in a strip of 60 m x 10 m, and some stand within 3 m of it."""
    zone = {"at_m": [5, -3], "size_m": [60, 10]}
    world = build(size_m=(70, 40), exclude=(zone,), objects=({"kind": "manta_mine", "count": 200, "size_m": 1.0},))
    points = np.concatenate([g.vertices[:, :2] for g in world.geometries if g.name == "truncated cone mine"])
    beyond = np.abs(points - zone["at_m"]) - np.array(zone["size_m"]) / 2
    assert (beyond.max(axis=1) > 0).all()
    assert (beyond.max(axis=1) < 3).any()
    with pytest.raises(ValidationError, match="radius_m of a disc, or size_m of a rectangle"):
        build(exclude=({"at_m": [0, 0]},))
