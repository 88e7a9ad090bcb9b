"""Pictures, the viewer and reports, each against a formula of its own."""

from __future__ import annotations

import math
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from pelagos.drawing.sample import _colour, _flow
from pelagos.manoeuvres.picture import in_lengths
from pelagos.messages.sonar_image import eight_bits
from pelagos.report.movers import near_parts
from pelagos.report.sonar import _interest
from pelagos.report.soundings import _means
from pelagos.viewer.chase import _seen
from pelagos.viewer.drive import _integrate
from pelagos.viewer.ground import _stitch
from pelagos.viewer.hull import Model3d
from pelagos.viewer.marks import _passed
from pelagos.viewer.scene import fan_mesh


@pytest.mark.parametrize(
    ("scale", "levels"), [("db", [-75.0, -60.0, -25.0]), ("linear", [0.0, 1e-6, 1.0]), ("unit", [0.0, 0.25, 1.0])]
)
def test_levels_of_any_scale_go_over_the_dynamic_range(scale, levels):
    """From -70 dB on over 40 dB: -60 dB is a quarter of 255, rounded."""
    config = Stub(scale=scale, floor_db=-70.0, dynamic_range_db=40.0)
    assert eight_bits(config, np.array(levels)).tolist() == [0, 64, 255]


def test_flow_is_shown_as_hue_and_brightness():
    """HSV's wheel: to the right red, down chartreuse, to the left cyan, up violet."""
    flow = np.array([[(2.0, 0), (0, 2), (-2, 0), (0, -2), (1, 0), (np.nan, 0)]])
    wheel = [[255, 0, 0], [127, 255, 0], [0, 255, 255], [127, 0, 255], [127, 0, 0], [0, 0, 0]]
    assert _flow(flow)[0].tolist() == wheel


def test_pictures_of_16_bits_and_of_radiance_are_shown_in_eight():
    """The upper byte; and a display's gamma of 2.2: 255 x 0.5^(1/2.2) = 186.1, 255 x 0.2^(1/2.2) = 122.7."""
    assert _colour(np.array([[[0xABCD]]], np.uint16)).tolist() == [[[0xAB] * 3]]
    assert _colour(np.array([[0.5, 1.5, -1.0]])).tolist() == [[[186] * 3, [255] * 3, [0] * 3]]
    assert _colour(np.array([[(0.5, 0.2, 1.0)]])).tolist() == [[[186, 123, 255]]]
    assert _colour(np.array([[(5, 250, 7)]], np.uint8)).tolist() == [[[5, 250, 7]]]


def test_corners_are_passed_in_order_and_once():
    """Where a track is nearest while it is within a fifth of the leg, at least 5 m; what is not reached has no row."""
    corners = np.array([(0.0, 0), (100, 0), (100, 20), (0, 20)])
    track = np.array([(0, 0), (79, 0), (85, 0), (97, 1), (97, 3), (103, 14), (101, 19), (100, 20.5), (60, 20),
                      (19, 20), (8, 24), (3, 21), (-25, 21), (0, 20)])  # fmt: skip
    assert _passed(corners, track.astype(float)) == [3, 7, 11]
    assert _passed(corners, track[:6].astype(float)) == [3, None, None]
    assert _passed(corners[:2], np.array([(0, 0), (79.9, 0)])) == [None]
    assert _passed(corners[1:3], np.array([(100, 0), (100, 15.1)])) == [1]  # at least 5 m of a short leg


def test_every_second_node_of_an_edge_lies_on_the_line_of_its_neighbours():
    z = np.array([1.0, 9.0, 4.0, 9.0, -7.0, 9.0, 8.0])
    _stitch(np.array([0.0, 2.0, 3.0, 3.5, 5.0, 5.0, 5.0]), z)
    assert np.allclose(z, [1, 3, 4, 4 - 11 / 4, -7, -7, 8])  # the last piece has no length


def test_propellers_turn_on_slowly_and_fins_by_their_angle():
    """At 0.12 of their true rate, so that the eye can follow; an actuator that is not there is at rest."""
    parts = [Stub(actuator=1, spins=True), Stub(actuator=0, spins=False), Stub(actuator=5, spins=True)]
    angles = Model3d([], parts, 2.0).turned(np.array([0.3, -60.0]), np.array([1.0, 9.0, 2.0]), 0.25)
    assert np.allclose(angles, [1.0 - 0.12 * 60 * 0.25 + 2 * math.pi, 0.3, 2.0])


def test_the_sector_of_a_sonar_has_its_area_and_its_ends():
    """(R^2 - r^2)/2 of 1.1 rad, less what 63 chords leave of the arcs; all faces look the same way."""
    config = Stub(azimuths=np.array([0.6, 0.1, -0.5]), range_min_m=2.0, range_max_m=20.0)
    vertices, faces = fan_mesh(config)
    ends = [(2 * math.cos(0.6), 2 * math.sin(0.6), 0), (20 * math.cos(0.5), -20 * math.sin(0.5), 0)]
    assert np.allclose(vertices[[0, -1]], ends, atol=1e-5)
    a, b, c = np.swapaxes(vertices[faces].astype(float), 0, 1)
    area = 0.5 * np.cross(b - a, c - a)[:, 2]
    assert (area < 0).all() or (area > 0).all()
    assert abs(area.sum()) == pytest.approx(0.5 * (20**2 - 2**2) * 1.1, rel=(1.1 / 63) ** 2)


def test_places_on_a_sheet_from_behind():
    """A pinhole whose sheet of 600 pixels is 1.5 times as wide as far away; what lies behind keeps its distance."""
    basis = np.array([(0.6, 0.8, 0.0), (0.0, 0.0, 1.0), (0.8, -0.6, 0.0)])  # right, up, along the sight
    eye = np.array([1.0, 2.0, 3.0])
    points = eye + np.array([(1.5, -0.5, 8.0), (-1.5, 0.5, -2.0)]) @ basis
    found = _seen(Stub(width=600, height=400), points, eye, basis)
    assert np.allclose(found[0], [300 + 400 * 1.5 / 8, 200 + 400 * 0.5 / 8, 8.0])
    assert found[1, 2] == pytest.approx(-2.0)


def driven(held, mode, names, axes):
    """What half a second of a stick orders of a vehicle of 3 m/s at most; of what was ordered before where `held`."""
    sent, modes = [], []
    vehicle = Stub(command_names=lambda mode: names, config=Stub(envelope=Stub(top_mps=3.0)))
    state = Stub(velocity=np.array([[1.2, 0.7, -0.4]]), euler=np.array([[0.3, -0.2, -3.1]]), depth=np.array([-6.1]))
    sim = Stub(
        model=Stub(agents={"a": Stub(vehicle=vehicle)}), state={"a": state}, command=sent.append,
        stepper=Stub(mode=lambda agent: mode if held else "other"), set_mode=lambda *given: modes.append(given),
        held_command=lambda agent: np.array([held]),
    )  # fmt: skip
    _integrate(sim, "a", mode, Stub(sway=0.4, **axes), 0.5)
    assert modes == ([] if held else [("a", mode)])
    return sent[0]["a"]


def test_a_stick_turns_deepens_and_hastens_what_was_ordered():
    """25 degrees/s, 0.4 m/s and 0.4 m/s^2 at full; compass headings go down to port, past -pi to the other side."""
    names = ["depth", "heading", "speed"]
    turn = math.radians(25) * 0.8 * 0.5
    found = driven([4.0, -3.0, 1.1], "d", names, {"yaw": 0.8, "heave": 0.5, "surge": -0.9})
    assert np.allclose(found, [4.0 - 0.1, -3.0 - turn + 2 * math.pi, 1.1 - 0.18])
    found = driven([4.0, 0.2, 1.1], "d", names, {"yaw": -0.8, "heave": -0.75, "surge": 0.9})
    assert np.allclose(found, [4.0 + 0.15, 0.2 + turn, 1.1 + 0.18])
    found = driven([0.1, 0.2, 2.95], "d", names, {"yaw": 0.0, "heave": 1.0, "surge": 0.9})
    assert np.allclose(found, [0.0, 0.2, 3.0])  # to the surface, and to its largest speed
    assert driven([0.1, 0.2, 0.1], "d", names, {"yaw": 0.0, "heave": 0.0, "surge": -0.9})[2] == 0.0


def test_a_stick_begins_from_the_motion_where_nothing_was_ordered():
    """Of an aeroplane 6.1 m up at 1.2 m/s, whose yaw of -3.1 rad (to port) is a heading of 3.1."""
    turn = math.radians(25) * 0.8 * 0.5
    found = driven(None, "h", ["height", "heading", "airspeed"], {"yaw": -0.8, "heave": -0.75, "surge": 0.9})
    assert np.allclose(found, [6.1 - 0.15, 3.1 + turn - 2 * math.pi, 1.2 + 0.18])


def test_soundings_are_averaged_by_cells():
    """Cells of 1 m about their middles; one without soundings has no height, and outside nothing counts."""
    points = np.array([
        (0.9, 4.1, -3.0), (0.6, 4.9, -4.5), (1.6, 4.2, -5.0), (1.1, 5.9, -2.0), (2.9, 7.9, -9.0), (3.1, 5.0, -1.0),
        (0.4, 5.0, -1.0), (3.6, 5.0, -1.0), (2.0, 3.9, -1.0), (2.0, 8.1, -1.0),
    ])  # fmt: skip
    mean, count = _means(points, np.array([1.0, 2.0, 3.0]), np.array([4.5, 5.5, 6.5, 7.5]), 1.0)
    expected = np.full((3, 4), np.nan)
    expected[0, 0], expected[1, 0], expected[0, 1], expected[2, 3], expected[2, 1] = -3.75, -5.0, -2.0, -9.0, -1.0
    np.testing.assert_allclose(mean, expected)
    assert count.tolist() == [[2, 1, 0, 0], [1, 0, 0, 0], [0, 1, 0, 1]]


def test_a_picture_is_conspicuous_by_contrast_along_its_rows():
    """The deviation of means of 8 x 8 pixels, free of speckle, from those of their rows; only whole cells count."""
    cells = np.array([[10.0, 20.0, 60.0], [5.0, 5.0, 5.0]])
    picture = np.full((19, 29), 200, np.uint8)
    speckle = np.kron([[3.0, 7.0, 1.0], [2.0, 5.0, 0.0]], np.kron(np.ones((4, 4)), [[1, -1], [-1, 1]]))
    picture[:16, :24] = np.kron(cells, np.ones((8, 8))) + speckle
    assert _interest(picture) == pytest.approx(math.sqrt((20**2 + 10**2 + 30**2) / 6))


def test_a_map_shows_movers_as_far_away_as_the_way_is_long():
    """And within 40 m of a vehicle that stands."""
    own = np.array([(0.0, -10.0), (100.0, 10.0), (50.0, 0.0)])
    track = np.array([
        (-99.0, 0.0, 5.0), (-101.0, 0, 5), (199.0, 109.0, 5), (199.0, 111.0, 5), (201.0, 0, 5), (0.0, -109.0, 5),
        (0.0, -111.0, 5),
    ])  # fmt: skip
    near, none = near_parts([Stub(position=track), Stub(position=track[[1, 3]])], own)
    assert near.tolist() == track[[0, 2, 5], :2].tolist()
    assert none.shape == (0, 2)
    still = near_parts([Stub(position=track)], np.array([(-62.0, 0.0), (-60.5, 0.0)]))[0]
    assert still.tolist() == track[:2, :2].tolist()
    assert not len(near_parts([Stub(position=track)], np.array([(-58.0, 0.0)]))[0])


def test_a_manoeuvre_is_drawn_in_lengths_from_the_order_and_along_the_course_there():
    """North + i east, turned back by the course: ahead + i to starboard. At the order, halfway, place and course are
    halfway too.
    """
    track = Stub(
        time=np.array([0.0, 2.0, 4.0]), position=np.array([(10.0, -3, 7), (14, -1, 8), (16, 7, -9)]),
        attitude=np.array([(0.1, -0.2, 0.2), (0.3, 0.1, 0.6), (-0.1, 0.2, 2.0)]),
    )  # fmt: skip
    found = in_lengths(Stub(track=track, switched_s=np.array([1.0, 3.0]), length_m=5.0))
    way = np.array([-2.0 - 1.0j, 2.0 + 1.0j, 4.0 + 9.0j]) / 5 * np.exp(-0.4j)
    assert np.allclose(found, np.stack([way.real, way.imag], -1))
