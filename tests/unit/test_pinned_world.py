"""Rare branches of small functions of world, ocean, optics and contact: second corners, far ends, other signs."""

from __future__ import annotations

import math
from itertools import permutations
from types import SimpleNamespace

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.contact import probe
from pelagos.hydro import flooding, lift, liquid, thruster, wetted_hull
from pelagos.ocean import gridded, netcdf_variable
from pelagos.optics import caustics, clear_sky, directions, exposure, image_quality, lamp, laser_beam, lens, port
from pelagos.optics import radiative_transfer as transfer
from pelagos.vehicles.actuators import curve
from pelagos.vehicles.shape import stations
from pelagos.vehicles.terms import air
from pelagos.world import border, clearance, terrain
from pelagos.world.bathymetry import projection, triangles, values
from pelagos.world.generate import pipeline, relief, scatter, sediments
from pelagos.world.large import ground

F = jit.Float64


def test_highest_of_the_rows_around():
    heights = np.random.default_rng(1).normal(size=(7, 3))
    for step, centre in ((1, True), (2, False), (4, True)):
        offsets = [-step, step, *([0] if centre else [])]
        found = clearance._highest(heights, step, centre=centre)
        assert found.shape == (7 + 2 * step, 3)
        for i in range(-step, 7 + step):
            rows = [heights[i + o] for o in offsets if 0 <= i + o < 7]
            expected = np.max(rows, axis=0) if rows else np.full(3, -np.inf)
            assert found[i + step].tolist() == expected.tolist()


def test_maps_end_at_their_edges():
    heights = np.arange(6.0).reshape(2, 3) + 1
    i, j = np.array([0.0, 1, -1, 2, 0, 1, 1]), np.array([2.0, 0, 1, 1, -1, 3, 2])
    assert clearance._at(heights, i, j).tolist() == [3, 4, -np.inf, -np.inf, -np.inf, -np.inf, 6]


def test_fields_of_sediment_between_their_nodes():
    nodes = np.random.default_rng(2).normal(size=(5, 4)).astype(np.float32)
    found = sediments._denser(nodes, (11, 8), 3)
    for i in range(11):
        for j in range(8):
            a, b, p, q = i // 3, j // 3, i % 3 / 3, j % 3 / 3
            low = nodes[a, b] * (1 - p) + nodes[a + 1, b] * p
            high = nodes[a, b + 1] * (1 - p) + nodes[a + 1, b + 1] * p
            assert found[i, j] == pytest.approx(low * (1 - q) + high * q, abs=4e-6)
    assert np.array_equal(sediments._denser(nodes, (4, 2), 1), nodes[:4, :2])


def test_steps_and_dents():
    assert relief.smoothstep([1.0, 2.0, 2.5, 4.0, 5.0], 2.0, 4.0) == pytest.approx([0, 0, 0.15625, 1, 1])
    x, y = np.arange(0.0, 9.0), np.arange(-4.0, 3.0)
    z = np.ones((9, 7))
    relief.dent(x, y, z, (5.0, -1.0), 0.8, -0.7)
    away = np.hypot(x[:, None] - 5, y[None] + 1)
    square = (np.abs(x[:, None] - 5) <= 2.4) & (np.abs(y[None] + 1) <= 2.4)
    assert z == pytest.approx(np.where(square, 1 + 0.7 * np.exp(-(away**2) / 1.28), 1.0))


def test_indices_that_miss_a_node_by_rounding():
    index = np.array([-1e-10, 3 + 2e-9, 3 + 2e-7, 5 - 1e-9, 6 + 1e-10, 2.5])
    assert terrain.snapped(index, 5).tolist() == [0.0, 3.0, 3 + 2e-7, 5.0, 6 + 1e-10, 2.5]
    assert ground._snap(np.array([-7 - 5e-9, 7 + 5e-9, 7 + 2e-8])).tolist() == [-7.0, 7.0, 7 + 2e-8]


def test_where_fields_of_two_materials_cross():
    fields = np.array([[3.0, 1.0], [2.0, 5.0], [9.0, 9.0]], dtype=np.float32)  # differ by 1 at node 0, by 4 at node 1
    found = border._crossing(np.array([0]), np.array([1]), np.array([0, 1], dtype=np.uint8), fields)
    assert found == pytest.approx([0.2])


def test_cells_that_a_disc_may_reach():
    size = scatter._CELL
    found = set(scatter._cells_of(0.4 * size, -1.2 * size, 0.5 * size))
    assert found == {(i, j) for i in (-1, 0) for j in (-2, -1)}


def test_marks_stand_alone_and_longitudes_wrap():
    mark = values._MARKS[0]
    z = np.array([[mark, -12.0], [3.0, np.nan]])
    assert values._marks(z).tolist() == [[True, False], [False, False]]
    z[1, 0] = mark + 0.5 * values._ALONE
    assert not values._marks(z).any()
    assert projection._wrap(np.array([-190.0, -180, 180, 190, 12])).tolist() == [170, -180, 180, -170, 12]


def test_nodes_in_the_boxes_of_triangles_come_once_in_any_portions(monkeypatch):
    first, last = np.array([[2, 5], [0, 0], [4, 1]]), np.array([[9, 8], [3, 0], [6, 12]])
    expected = {
        (t, i, j) for t in range(3) for i in range(first[t, 0], last[t, 0]) for j in range(first[t, 1], last[t, 1])
    }
    for portion in (4, 7, 1000):
        monkeypatch.setattr(triangles, "_AT_ONCE", portion)
        rows = np.concatenate([np.stack(part, axis=1) for part in triangles._nodes(first, last)])
        assert len(rows) == len(expected)
        assert {tuple(r) for r in rows.tolist()} == expected


def test_moments_of_a_head_over_a_triangle():
    places, head = (0.7, -1.3, 2.1), (3.0, 0.4, 1.9)
    mean, moment = wetted_hull._moments(places, head)
    middles = [0.25 * (places[i] + places[j]) * (head[i] + head[j]) for i, j in ((0, 1), (1, 2), (2, 0))]
    assert mean == pytest.approx(5.3 / 3)
    assert moment == pytest.approx(sum(middles) / 3)  # quadratic: the middles of the sides are exact


@pytest.mark.parametrize("alone", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_tip_of_a_triangle_that_the_surface_cuts(alone, sign):
    depth = {0: 0.6, 1: -0.2, 2: -1.4}  # of the tip, and of the two others
    place, head = {0: 0.7, 1: -1.3, 2: 2.1}, {0: 3.0, 1: 0.4, 2: 1.9}
    order = [(k - alone) % 3 for k in range(3)]
    corners, wet, heads = ([F(table[k]) for k in order] for table in (place, depth, head))
    share, level, moment = (x[0] for x in wetted_hull._tip(corners, [sign * d for d in wet], heads))
    p, q = 0.6 / 0.8, 0.6 / 2.0
    ends = place[0], place[0] + p * (place[1] - place[0]), place[0] + q * (place[2] - place[0])
    tops = head[0], head[0] + p * (head[1] - head[0]), head[0] + q * (head[2] - head[0])
    middles = [0.25 * (ends[i] + ends[j]) * (tops[i] + tops[j]) for i, j in ((0, 1), (1, 2), (2, 0))]
    assert share == pytest.approx(p * q)
    assert level == pytest.approx(p * q * sum(tops) / 3)
    assert moment == pytest.approx(p * q * sum(middles) / 3)


@pytest.mark.parametrize("w", [0.7, 1.9])
def test_means_of_a_ramp(w):
    u = (np.arange(20000) + 0.5) / 10000 - 1
    for a in (-2.5, -0.4, 0.3, 2.4):
        part = np.maximum(a + w * u, 0)
        assert liquid._ramp(F(a), F(w))[0] == pytest.approx(part.mean(), abs=1e-7)
        assert liquid._square(F(a), F(w))[0] == pytest.approx((part**2).mean(), abs=1e-7)
        assert liquid._arm(F(a), F(w))[0] == pytest.approx((u * part).mean(), abs=1e-7)


def test_largest_side_first():
    for sides in permutations((0.3, 1.1, 2.2)):
        found = [int(F(k)[0]) for k in liquid._by_size([F(s) for s in sides])]
        assert found == sorted(range(3), key=lambda k: -sides[k])
    for sides in ((1.0, 1.0, 2.0), (2.0, 1.0, 1.0), (1.0, 2.0, 1.0), (1.0, 1.0, 1.0)):
        assert sorted(int(F(k)[0]) for k in liquid._by_size([F(s) for s in sides])) == [0, 1, 2]


def test_water_through_an_orifice_both_ways():
    area, slope, gravity = 0.02, 0.5, 9.8
    for head, h in ((1.3, 4.0), (-1.3, 4.0), (1.3, 400.0), (-0.7, 400.0)):
        rate = area * math.sqrt(2 * gravity)
        root = max(math.sqrt(abs(head)) - 0.5 * rate * slope * h, 0.0)  # of the head that is left
        expected = math.copysign((abs(head) - root * root) / slope, head)
        found = flooding.through_orifice(F(head), F(slope), F(area), F(h), gravity)[0]
        assert found == pytest.approx(expected, rel=1e-12)


def test_thrust_astern_has_its_own_factor():
    found = thruster.quadratic_thrust(F(2.0), F(3.0), F([1.5, -1.5])).numpy()
    assert found == pytest.approx([4.5, -6.75])


def test_lift_from_astern_is_that_from_ahead_seen_from_behind():
    polar = SimpleNamespace(slope=2.3, parasitic=0.04, induced=0.11, area=0.7)
    for u, w in ((1.7, 0.4), (1.7, -0.4), (-1.7, 0.4), (-1.7, -0.4)):
        alpha = math.atan2(w, abs(u))
        up, along = 2.3 * alpha, 0.04 + 0.11 * (2.3 * alpha) ** 2
        pressure = 0.5 * 1025.0 * 0.7 * (u * u + 0.09 + w * w)
        x = pressure * (up * math.sin(alpha) - along * math.cos(alpha))
        z = -pressure * (along * math.sin(alpha) + up * math.cos(alpha))
        found = lift.lift_and_drag(polar, F(1025.0), [F(u), F(0.3), F(w), F(0), F(0), F(0)], mirrored=True)
        assert [F(f)[0] for f in found] == pytest.approx([math.copysign(x, x * u), 0, z, 0, 0, 0], rel=1e-6)


def test_lines_through_points_are_level_beyond_them():
    at, heights = [-2.0, -0.5, 0.3, 4.0], [-7.0, -1.0, 0.2, 9.0]
    x = np.array([-3.0, -2.0, -1.0, 0.1, 0.3, 2.0, 4.0, 6.0])
    assert curve._along(F(x), at, heights).numpy() == pytest.approx(np.interp(x, at, heights))


def test_flow_separates_on_both_sides():
    found = air._separation(F([0.0, 0.3, -0.3, 0.35, -0.35, 1.0]), 0.3, 50.0).numpy()
    late = 1 / (1 + math.exp(-2.5))
    assert found == pytest.approx([6.1e-7, 0.5, 0.5, late, late, 1.0], abs=1e-6)


def test_parts_of_a_section_under_water_run_from_port_to_starboard():
    loop = np.array([[3.0, 1.0], [2.0, -3.0], [-1.0, -2.0], [-1.6, 1.0]])
    for points in (loop, loop[::-1], np.roll(loop, 2, axis=0)):
        (run,) = stations._under_water(points)
        assert run == pytest.approx(np.array([[-1.4, 0.0], [-1.0, -2.0], [2.0, -3.0], [2.75, 0.0]]))


def test_active_probes_stand_first_in_their_vehicles_block():
    active = jit.Bool([False, True, True, True, False, False, False, False, True])
    listed = probe._list_active(active, 3)
    assert listed.first.numpy().tolist() == [0, 3, 6]
    assert listed.count.numpy().tolist() == [2, 1, 1]
    lanes = listed.lane.numpy()
    assert [lanes[0], lanes[1], lanes[3], lanes[6]] == [1, 2, 3, 8]


def test_friction_of_a_contact_that_slides():
    # held where hold * after is less than the limit, else the limit over the slip that is left
    cases = probe._Sideways(F([5.0, 5.0, 5.0]), F([2.0, 2.0, 2.0]), F([0.04, 0.08, 0.08]), F([100.0, 100.0, 100.0]))
    left = 2.0 * (1 - 5.0 / 8.0)
    assert probe._first_slide(cases).numpy() == pytest.approx([100.0, 5 / left, 5 / left])
    assert probe._slide(cases).numpy() == pytest.approx([100.0, 62.5, 62.5])


def test_fields_fade_over_the_outermost_cells():
    nodes, place = F([1.0, 3.0, 8.0, 13.0]), F([-2.0, 0.5, 1.0, 13.0, 14.0, 20.0])
    field = SimpleNamespace(outside="fade")
    found = gridded.GridField._edge(field, nodes, place, 4, above=False).numpy()
    assert found == pytest.approx([0.0, 0.75, 1.0, 1.0, 0.8, 0.0])
    field.outside = "error"
    found = gridded.GridField._edge(field, nodes, place, 4, above=False).numpy()
    assert np.isnan(found).tolist() == [True, True, False, False, True, True]


def test_polynomial_in_two_variables():
    c = np.random.default_rng(3).normal(size=15)  # degree 4
    x, y = 0.7, -1.2
    powers = [x**i * y**j for i in range(5) for j in range(5 - i)]
    assert gridded._polynomial(F(c), F(x), F(y))[0] == pytest.approx(float(np.dot(powers, c)))


def test_valid_range_of_packed_values():
    attributes = {"valid_min": np.int16(-20), "valid_max": np.int16(30)}
    variable = SimpleNamespace(attrs=attributes, encoding={"scale_factor": -0.5, "add_offset": 2.0, "dtype": np.int16})
    found = netcdf_variable._valid(np.array([-13.1, -12.9, 11.9, 12.1, np.nan]), variable)
    assert found.tolist() == [False, True, True, False, True]
    variable.encoding = {}
    assert netcdf_variable._valid(np.array([-20.1, 30.0, 30.1]), variable).tolist() == [False, True, False]


def test_two_axes_across_a_direction():
    n = np.array([[0.36, -0.48, 0.8], [0.36, -0.48, -0.8], [0.0, 0.0, -1.0]]).T
    one, two = (a.numpy() for a in directions._across(jit.Array3f(n)))
    frame = np.stack([one, two, n])
    assert np.einsum("aik,bik->kab", frame, frame) == pytest.approx(np.tile(np.eye(3), (3, 1, 1)), abs=1e-6)


def test_bits_cone_and_fan():
    assert exposure.to_bits(jit.Float([-1.0, 0.5, 0.996, 2.0]), 8).numpy().tolist() == [0, 128, 254, 255]
    beam = SimpleNamespace(axis=jit.Array3f(0, 0, -1), inner=0.9, outer=0.5)
    found = lamp._cone(beam, jit.Array3f([0, 0, 0], [0, 0, 0], [0.4, 0.6, 0.95])).numpy()
    assert found == pytest.approx([0.0, 0.15625, 1.0], abs=1e-6)
    fan, edge = 0.8, laser_beam._EDGE
    laser = SimpleNamespace(across=jit.Array3f(0, 0, 1), axis=jit.Array3f(1, 0, 0))
    angle = np.array([0.0, -0.3, 0.4, -0.4, 0.4 + 0.25 * edge, 0.5])
    offset = jit.Array3f(2 * np.cos(angle), 2 * np.sin(angle), 0.3 + 0 * angle)
    found = laser_beam._in_fan(laser, jit.Float(fan), offset).numpy()
    assert found == pytest.approx(np.array([1, 1, 0.5, 0.5, 0.25, 0]) / fan, abs=1e-3)


def test_refraction_and_the_far_side_of_a_dome():
    angle = np.radians(35.0)
    found = port.refract_np(np.array([math.sin(angle), 0, -math.cos(angle)]), np.array([0.0, 0, 1]), 1 / 1.34)
    sine = math.sin(angle) / 1.34
    assert found == pytest.approx([sine, 0, -math.sqrt(1 - sine * sine)])
    steep = np.array([[0.8, 0, -0.6]])
    assert np.isnan(port.refract_np(steep, np.array([0.0, 0, 1]), 1.34)).all()
    start, centre = np.array([0.2, -0.1, 0.3]), np.array([0.1, 0.2, 0.1])
    along = np.array([[0.6, 0.0, 0.8], [0.0, -0.6, -0.8]])
    at = port._sphere(start, along, centre, 1.5)
    assert np.linalg.norm(at - centre, axis=1) == pytest.approx([1.5, 1.5])
    assert (((at - start) * along).sum(axis=1) > 0).all()


def test_radii_of_bent_lenses():
    bend = (-0.2, 0.03, 0.0, 0.0, -0.002)
    r = np.array([0.05, 0.4, 0.9])
    bent = r * (1 + bend[0] * r**2 + bend[1] * r**4 + bend[4] * r**6)
    assert lens._undistorted_radius(bent, bend) == pytest.approx(r, rel=1e-3)
    fish = (0.03, -0.02, 0.004, -0.0015)
    theta = np.array([0.1, 0.7, 1.2])
    goal = theta * (1 + sum(k * theta ** (2 * n) for n, k in enumerate(fish, start=1)))
    assert lens._invert_radius(goal, fish) == pytest.approx(theta)
    t = np.linspace(0, math.pi, 200001)
    slope = 1 + sum((2 * n + 1) * k * t ** (2 * n) for n, k in enumerate(fish, start=1))
    assert lens.fisheye_reach(fish) == pytest.approx(t[np.argmax(slope < 0)], abs=2e-5)


def test_geometry_of_the_air():
    height, up, way = np.array([500.0, 2000.0]), np.array([0.6, -0.3]), np.array([9000.0, 4000.0])
    r = clear_sky._EARTH + height
    x, z = way * np.sqrt(1 - up * up), r + way * up
    found = clear_sky._along(height, up, way)
    assert found[0] == pytest.approx(np.hypot(x, z) - clear_sky._EARTH, abs=1e-6)
    assert found[1] == pytest.approx((up * z + np.sqrt(1 - up * up) * x) / np.hypot(x, z))
    cosine = np.polynomial.legendre.leggauss(60)
    total = 2 * math.pi * (cosine[1] * clear_sky._by_aerosol(cosine[0])).sum()
    forward = 2 * math.pi * (cosine[1] * cosine[0] * clear_sky._by_aerosol(cosine[0])).sum()
    assert (total, forward) == pytest.approx((1.0, clear_sky._AEROSOL_G), rel=1e-6)
    nodes = np.linspace(0, 1, 7) ** 2
    weights = clear_sky._weights(nodes, np.linspace(0, math.pi, 5))
    assert weights.sum() == pytest.approx(math.pi)  # of a level sky
    assert weights[:, 0] * 2 == pytest.approx(weights[:, 1])


def test_tables_of_the_air_between_their_nodes():
    rows, columns = np.arange(clear_sky._HEIGHTS)[:, None], np.arange(clear_sky._SUNS)[None]
    table = np.stack([2.0 * rows + 0 * columns, -3.0 * columns + 0 * rows, rows * columns * 1.0], axis=-1)
    a, b = np.array([4.3, 0.0, 17.0]), np.array([7.8, 39.0, 20.25])
    height = clear_sky._TOP * (a / (clear_sky._HEIGHTS - 1)) ** 2
    level = 2 * b / (clear_sky._SUNS - 1) - 1
    sun = np.sign(level) * np.abs(level) ** 2.2
    found = clear_sky._looked_up(table, height, sun)
    assert found == pytest.approx(np.stack([2 * a, -3 * b, a * b], axis=-1), abs=1e-9)


def test_maps_of_focused_light_go_round():
    cells = caustics.CELLS
    table = np.random.default_rng(4).normal(size=(2, cells, cells)).astype(np.float32)
    u, v = np.array([cells - 0.25, 3.5, -0.75]), np.array([2.625, cells - 0.375, -1.5])
    got = caustics._bilinear(jit.Float(table.ravel()), jit.Float(u), jit.Float(v), jit.UInt32([1, 0, 1])).numpy()
    for k, row in enumerate((1, 0, 1)):
        i, j = math.floor(u[k]), math.floor(v[k])
        p, q = u[k] - i, v[k] - j
        corner = [table[row, (i + a) % cells, (j + b) % cells] for a in (0, 1) for b in (0, 1)]
        low, high = corner[0] * (1 - q) + corner[1] * q, corner[2] * (1 - q) + corner[3] * q
        assert got[k] == pytest.approx(low * (1 - p) + high * p, abs=3e-6)
    counts = dr.zeros(jit.UInt32, cells * cells)
    caustics._splat(counts, jit.UInt32(0), jit.Float(cells - 0.25), jit.Float(3.625))
    shares = counts.numpy().reshape(cells, cells) / caustics._UNIT
    at = {(cells - 1, 3): 0.09375, (cells - 1, 4): 0.15625, (0, 3): 0.28125, (0, 4): 0.46875}
    assert {tuple(p) for p in np.argwhere(shares).tolist()} == set(at)
    assert [shares[p] for p in at] == pytest.approx(list(at.values()), abs=1 / caustics._HALF_UNIT)
    one = np.zeros((cells, cells), dtype=np.uint32)
    one[0, 5] = 16
    spread = caustics._blurred(jit.UInt32(one.ravel())).numpy().reshape(cells, cells)
    assert spread[[-1, 0, 1]][:, 4:7] == pytest.approx(np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]]))
    assert spread.sum() == pytest.approx(16)


def test_window_of_a_picture_without_its_border():
    radius, sigma = image_quality._RADIUS, image_quality._SIGMA
    picture = np.zeros((2 * radius + 4, 2 * radius + 3))
    picture[radius + 1, radius] = 5.0
    weight = np.exp(-0.5 * (np.arange(-radius, radius + 1) / sigma) ** 2)
    weight /= weight.sum()
    rows, columns = np.arange(4) - 1, np.arange(3)
    assert image_quality._blurred(picture) == pytest.approx(
        5 * np.outer(weight[radius - rows], weight[radius - columns])
    )


@pytest.mark.parametrize("sign", [1, -1])
def test_light_along_a_way_with_a_source_that_is_linear_between_depths(sign):
    depths, c, decay = np.array([0.0, 0.0008, 0.7, 2.5]), 0.9, 0.2
    u = sign * np.array([0.3, 0.8])
    values_at = np.array([2.0, 1.1, 3.0, 0.7])
    source = np.ones((1, 2, 1)) * values_at[:, None, None]
    found = transfer._along(depths, SimpleNamespace(attenuation=c, decay=decay), u, source, np.full((2, 1), 0.4))
    order = range(4) if sign > 0 else range(3, -1, -1)
    for k, s in enumerate(np.abs(u)):
        rate = c / s - sign * decay
        light = None
        for i, before in zip(order, [None, *order], strict=False):
            if before is None:
                light = 0.4 if sign > 0 else values_at[3] / s / rate
            else:
                h = abs(depths[i] - depths[before])
                way, weight = np.polynomial.legendre.leggauss(20)
                way = h * (way + 1) / 2
                shone = values_at[before] + (values_at[i] - values_at[before]) * way / h
                light = light * math.exp(-rate * h) + (weight * h / 2 * shone / s * np.exp(-rate * (h - way))).sum()
            assert found[i, k, 0] == pytest.approx(light, rel=1e-6)


@pytest.mark.parametrize("length", [36.0, 42.6, 42.7, 42.84, 42.951, 42.96, 43.0, 54.9])
def test_a_pipe_is_closed_wherever_its_last_collar_lies(length):
    """Collars are 12.2 m apart from 6.1 m on, half a metre long: one stands at 42.7 m; 36 m are whole metres."""
    path = np.stack([np.linspace(-0.6, 0.6, 40), np.linspace(-0.8, 0.8, 40)], -1) * length / 2
    pipe = pipeline.Pipeline(path, 0.4, np.zeros(40), (10.0, 20.0))
    bed = terrain.HeightField(-50.0, -60.0, 2.0, np.full((51, 61), -17.0))
    made = pipeline.pipe_mesh(pipe, bed)
    assert np.isfinite(made.vertices).all()
    assert made.closed
    assert np.ptp(made.vertices @ [0.6, 0.8, 0.0]) == pytest.approx(length, rel=1e-9)
    collars = 1 + int((length - 6.1) / 12.2)
    plain = 0.5 * 24 * math.sin(2 * math.pi / 24) * 0.4**2 * length  # of a prism of 24 sides
    assert plain < made.volume < plain * (1 + 0.3 * 0.52 * collars / length)  # collars are 1.14 times as thick
