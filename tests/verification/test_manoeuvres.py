"""Numbers of manoeuvres from tracks that are known in closed form, and from the mariner's own runs."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve

from pelagos.errors import InputError, LookupFailed
from pelagos.hydro.squat import squat
from pelagos.manoeuvres import picture, run_manoeuvre, turning_measures, zigzag_measures
from pelagos.manoeuvres.approach import approach
from pelagos.manoeuvres.calm_run import CalmRun
from pelagos.manoeuvres.measures import (
    decay_measures,
    first_overshoot_limit,
    half_cycles,
    second_overshoot_limit,
    stop_measures,
)
from pelagos.manoeuvres.orders import Orders
from pelagos.manoeuvres.picture import draw
from pelagos.vehicles.vehicle import Vehicle


def by_name(measures):
    return {m.name: m for m in measures}


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("course", [0.0, 2.1])
def test_a_circle_has_the_numbers_of_a_circle(side, course):
    """10 s ahead at 5 m/s, then a circle of 120 m: advance and transfer one radius, tactical diameter two."""
    t = np.arange(0, 400, 0.1)
    turned = np.maximum(t - 10, 0) * 5 / 120
    along = np.where(t < 10, 5 * (t - 10), 120 * np.sin(turned))
    across = side * 120 * (1 - np.cos(turned))
    north = 7 + along * np.cos(course) - across * np.sin(course)
    east = -3 + along * np.sin(course) + across * np.cos(course)
    heading = np.degrees(course + side * turned)
    found = by_name(turning_measures(t, north, east, heading, ordered_s=10.0, length_m=40.0))
    expected = {"advance": 3, "transfer": 3, "tactical diameter": 6, "steady diameter": 6,
                "speed in the turn / before": 1, "time to 90 deg": 12 * np.pi,
                "time to 180 deg": 24 * np.pi}  # fmt: skip
    for name, value in expected.items():
        assert found[name].value == pytest.approx(value, rel=2e-4), name  # linear between points of 0.1 s
    assert found["advance"].kept is True
    assert found["tactical diameter"].kept is False


@pytest.mark.parametrize("side", [1, -1])
def test_advance_is_ahead_and_transfer_to_the_side(side):
    """A track that begins ahead: 150 m sin, 120 m (1 - cos) of the heading turned, course 2.1 rad, not at the origin.

    At 90 deg it is 150 m ahead, 120 m aside; at 180 deg 240 m aside. With 15 deg of helm there is no limit to keep.
    """
    t, course = np.arange(0, 200, 0.1), 2.1
    turned = np.maximum(t - 10, 0) / 40
    along, across = np.where(t < 10, 3.75 * (t - 10), 150 * np.sin(turned)), side * 120 * (1 - np.cos(turned))
    north = 700 + along * np.cos(course) - across * np.sin(course)
    east = -300 + along * np.sin(course) + across * np.cos(course)
    heading = np.degrees(course + side * turned)
    for helm in (35.0, 15.0):
        found = by_name(turning_measures(t, north, east, heading, ordered_s=10.0, length_m=40.0, limited=helm == 35.0))
        values = [found[name].value for name in ("advance", "transfer", "tactical diameter")]
        assert values == pytest.approx([3.75, 3.0, 6.0], rel=1e-4)
        limits = [found[name].limit for name in ("advance", "tactical diameter")]
        assert limits == ([4.5, 5.0] if helm == 35 else [None, None])


@pytest.mark.parametrize("side", [1, -1])
def test_overshoots_and_period_of_a_sinusoid(side):
    """Heading 1 + 14 sin(2 pi t/60) to the side of the first helm, reversed at 10 deg: 5 and 3 deg over, 60 s apart."""
    w = 2 * np.pi / 60
    t = np.arange(0, 200, 0.01)
    heading = side * (1 + 14 * np.sin(w * t))
    first, second = np.arcsin(9 / 14) / w, (np.pi + np.arcsin(11 / 14)) / w
    switched = np.array([first, second, first + 60, second + 60, first + 120])
    found = by_name(zigzag_measures(t, heading, switched, rudder_deg=10, angle_deg=10, length_m=160, speed_m_s=8,
                                    run_lengths=1.2))  # fmt: skip
    words = ("first", "second", "third", "fourth")
    assert [found[f"{k} overshoot"].value for k in words] == pytest.approx([5, 3, 5, 3], abs=1e-5)
    assert found["period"].value == pytest.approx(60, abs=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_a_stop_along_a_quarter_of_a_circle(side):
    """80 m of radius from course 2.1 rad: the track is 40 pi m long and ends 80 m ahead, 80 m to the side."""
    a, course = np.linspace(0, np.pi / 2, 2000), 2.1
    along, across = 80 * np.sin(a), side * 80 * (1 - np.cos(a))
    north = 9 + along * np.cos(course) - across * np.sin(course)
    east = -4 + along * np.sin(course) + across * np.cos(course)
    found = by_name(stop_measures(north, east, heading_deg=np.degrees(course), length_m=20.0))
    assert found["stopping track"].value == pytest.approx(2 * np.pi, rel=1e-6)
    assert found["head reach"].value == pytest.approx(4.0)
    assert found["side reach, to starboard"].value == pytest.approx(4.0 * side)
    assert found["stopping track"].limit == 15.0


def test_orders_that_a_manoeuvre_would_ignore_are_refused():
    for name, orders, words in (
        ("bollard", Orders(rudder_deg=20), "--rudder 20: bollard takes no option"),
        ("decay", Orders(speed_m_s=2), "--speed 2: decay takes --angle, --depth, --seconds"),
        ("turning", Orders(rudder_deg=0), "--rudder 0: give a number other than 0"),
        ("decay", Orders(angle_deg=-200), "--angle -200: give at most 90 deg"),
        ("zigzag", Orders(angle_deg=-10), "--angle -10: give a number above 0"),
        ("stop", Orders(seconds=-5), "--seconds -5: give a number above 0"),
        ("turning", Orders(rudder_deg=-50), "--rudder -50: the rudder of mariner goes from -40 to 40 deg"),
    ):
        with pytest.raises(InputError, match=words):
            run_manoeuvre({"type": "mariner"}, name, orders)


def test_a_turn_that_was_cut_off_is_refused():
    t = np.arange(0, 100, 0.5)
    with pytest.raises(InputError, match=r"the heading reaches 99\.5 deg of the 180 deg"):
        turning_measures(t, t, t, t, ordered_s=0.0, length_m=10.0)


def test_overshoots_of_a_made_up_zigzag():
    """Triangles of heading with peaks at 13, -16.5 and 14 deg, reversed at 10 deg."""
    corners_t = np.array([0, 26, 85, 146.0])
    corners = np.array([0, 13, -16.5, 14.0])
    t = np.arange(0, 146.01, 0.1)
    heading = np.interp(t, corners_t, corners)
    switched = np.array([20.0, 79.0, 138.0])
    switched[1] = np.interp(10, -corners[1:3], corners_t[1:3])
    found = by_name(zigzag_measures(t, heading, switched, rudder_deg=10, angle_deg=10, length_m=160, speed_m_s=8,
                                    run_lengths=1.2))  # fmt: skip
    assert found["first overshoot"].value == pytest.approx(3.0, abs=1e-9)
    assert found["second overshoot"].value == pytest.approx(6.5, abs=1e-9)
    assert found["first overshoot"].limit == 15.0  # 5 + 20 s / 2
    assert found["second overshoot"].limit == 32.5  # 17.5 + 0.75 x 20 s


def test_limits_of_overshoots():
    """MSC.137(76), 5.3.3: 10 deg below 10 s of L/V, 20 deg from 30 s on; 25 and 40 deg for the second."""
    assert [first_overshoot_limit(s) for s in (4, 10, 21, 30, 60)] == [10, 10, 15.5, 20, 20]
    assert [second_overshoot_limit(s) for s in (4, 10, 20, 30, 60)] == [25, 25, 32.5, 40, 40]


def test_a_decay_gives_its_damping_back():
    """A damped swing, zeta 0.05 and 6 s: the logarithmic decrement of half a cycle is pi zeta / sqrt(1 - zeta^2)."""
    t = np.arange(0, 60, 0.01)
    zeta, w = 0.05, 2 * np.pi / 6
    roll = -0.2 * np.exp(-zeta * w * t) * np.cos(w * np.sqrt(1 - zeta**2) * t)
    found = by_name(decay_measures(t, roll))
    assert found["period"].value == pytest.approx(6 / np.sqrt(1 - zeta**2), rel=2e-3)
    assert found["damping ratio, mean"].value == pytest.approx(zeta / np.sqrt(1 - zeta**2), rel=0.02)
    with pytest.raises(InputError, match="too few for its damping"):
        decay_measures(t, 0.2 * np.exp(-t))


@pytest.mark.parametrize("rest", [0.0, 0.03])
def test_extremes_lie_between_samples(rest):
    """A swing of 0.93 s sampled at 10 Hz: cos(w h/2) says that samples are up to 5.7 % below the extremes.

    Parabolas are within (w h)^4/128 = 1.6e-3 of the amplitude for a cosine; damping and the angle of rest: 6e-3.
    """
    zeta, w, t = 0.02, 2 * np.pi / 0.93, np.arange(0, 12, 0.1)
    found = half_cycles(t, rest + 0.2 * np.exp(-zeta * w * t) * np.cos(w * t + 0.3))
    true = (np.arange(1, len(found.time) + 1) * np.pi - 0.3 - np.arctan(zeta)) / w
    assert found.time == pytest.approx(true, abs=2e-3)
    size = 0.2 * np.exp(-zeta * w * true) * np.cos(np.arctan(zeta))
    assert np.abs(found.angle - rest) == pytest.approx(size, rel=6e-3)
    assert found.ratio == pytest.approx(zeta, rel=0.1)
    assert found.ratio.mean() == pytest.approx(zeta, rel=0.01)


def test_what_cannot_be_told_from_scatter_is_not_carried_on_to_small_angles():
    """zeta' = 0.01 + 0.05 a over 40 half cycles, with scatter of 1 %, and 0.02 with it and no growth."""
    rng = np.random.default_rng(5)
    for growth, told in ((0.05, True), (0.0, False)):
        size = [0.3]
        for _ in range(40):
            ratio = (0.01 + growth * size[-1] if told else 0.02) * (1 + 0.01 * rng.standard_normal())
            size.append(size[-1] * np.exp(-np.pi * ratio))
        corners = np.array(size) * (-1.0) ** np.arange(41)
        x = np.arange(0, 40.001, 0.01)
        k = np.minimum(x.astype(int), 39)
        swing = (corners[k] + corners[k + 1]) / 2 + (corners[k] - corners[k + 1]) / 2 * np.cos(np.pi * (x - k))
        found = by_name(decay_measures(5 * x, swing))
        assert ("damping ratio at small angles" in found) == ("its growth with the angle" in found) == told
        if told:
            assert found["damping ratio at small angles"].value == pytest.approx(0.01, rel=0.1)
            assert found["its growth with the angle"].value == pytest.approx(0.05, rel=0.1)
        else:
            assert found["damping ratio, mean"].value == pytest.approx(0.02, rel=0.02)


def test_a_boat_rolls_as_its_linear_equations_do():
    """Eigenvalue of the accelerations' slopes about rest that rolls most; a first-order step of 1/60 of its period is
    1 % off, and an otter rolls once a second."""
    otter = Vehicle.from_catalogue("otter")
    small = np.concatenate([1e-5 * np.eye(12), -1e-5 * np.eye(12)])
    rest = np.zeros((1, 2))
    pulls = otter.accelerations(small[:, :6], small[:, 6:], rest, rest, np.zeros((1, 3)))[0]
    slopes = (pulls[:12] - pulls[12:]).T / 2e-5  # (6, 12)
    values, ways = np.linalg.eig(np.concatenate([np.eye(6, 12, 6), slopes]))
    rolls = np.where(values.imag > 0, np.abs(ways[3]) / np.linalg.norm(ways[:6], axis=0), 0.0)
    root = values[np.argmax(rolls)]
    found = by_name(run_manoeuvre({"type": "otter"}, "decay", Orders(angle_deg=-2.0, seconds=8)).measures)
    assert found["period"].value == pytest.approx(2 * np.pi / root.imag, rel=0.02)
    assert found["damping ratio, mean"].value == pytest.approx(-root.real / abs(root), rel=0.06)


def test_a_roll_that_grows_is_drawn_below_nought(monkeypatch):
    """An axis upwards, nought at its top, and every half cycle on it."""
    made = []
    monkeypatch.setattr(picture.theme, "as_png", lambda figure: made.append(figure) or b"")
    trial = run_manoeuvre({"type": "otter"}, "decay", Orders(seconds=8))
    t = trial.track.time
    grown = 0.01 * np.exp(0.02 * t) * np.sin(6 * t)
    attitude = np.stack([grown, 0 * t, 0 * t], axis=1)
    track = replace(trial.track, attitude=attitude)
    draw(replace(trial, track=track, measures=decay_measures(t, grown)))
    low, high = made[0].axes[1].get_ylim()
    ratio = half_cycles(t, grown).ratio
    assert low < ratio.min() < ratio.max() < 0 <= high
    assert low == pytest.approx(1.25 * ratio.min(), rel=0.3)


def test_revolutions_are_those_of_the_speed():
    """Hull, propeller and air go with U^2, so that revolutions go with U; the catalogue's hold 7.97 and 8.0 m/s."""
    slow, slower = (approach({"type": "kvlcc2"}, Orders(speed_m_s=u)).vehicle for u in (5.0, 4.0))
    turns = [v["actuators"]["rudder"]["revolutions_hz"] for v in (slow, slower)]
    assert turns == pytest.approx([1.777 * 5 / 7.97, 1.777 * 4 / 7.97], rel=2e-3)
    naval = approach({"type": "navalvessel"}, Orders(speed_m_s=4.0))
    assert naval.revolutions == pytest.approx({1: 6.444 / 2}, rel=2e-3)
    assert approach({"type": "navalvessel"}, Orders()).revolutions == {1: 6.444}
    assert approach({"type": "kvlcc2"}, Orders(speed_m_s=7.97)).vehicle == {"type": "kvlcc2"}


def test_a_ship_holds_the_speed_that_was_ordered():
    """A zig-zag of 1 deg from 4 m/s: the first 10 s are straight ahead."""
    trial = run_manoeuvre({"type": "navalvessel"}, "zigzag", Orders(speed_m_s=4.0, angle_deg=1.0))
    before = trial.track.time <= 10.0
    assert trial.track.velocity[before, 0] == pytest.approx(4.0, rel=1e-3)
    assert "4 m/s" in trial.title


def test_speeds_that_nothing_holds_are_refused():
    for name, speed, words in (
        ("navalvessel", 12.0, r"--speed 12: navalvessel makes at most 8\.02 m/s"),
        ("mariner", 5.0, r"--speed 5: mariner would gain speed at once: .*leave --speed out \(7\.72 m/s\)"),
        ("otter", 9.0, r"--speed 9: otter makes at most 1\.5 m/s"),
    ):
        with pytest.raises(InputError, match=words):
            run_manoeuvre({"type": name}, "stop" if name == "otter" else "turning", Orders(speed_m_s=speed))


def test_a_stop_begins_at_the_ordered_speed():
    found = by_name(run_manoeuvre({"type": "otter"}, "stop", Orders(speed_m_s=1.2)).measures)
    assert found["speed before"].value == pytest.approx(1.2, abs=1e-12)


SHALLOW = {"type": "kvlcc2", "variant": "shallow"}


@pytest.fixture(scope="module")
def in_shallow_water():
    return run_manoeuvre(SHALLOW, "zigzag", Orders(rudder_deg=20, angle_deg=1, depth_m=31.2))


def test_ships_that_feel_the_depth_are_asked_for_it(in_shallow_water):
    with pytest.raises(InputError, match=r"kvlcc2 feels the depth of its water here: give it \(--depth\)"):
        run_manoeuvre(SHALLOW, "turning")
    with pytest.raises(InputError, match=r"--depth 30: nothing of kvlcc2 depends on the depth of its water"):
        run_manoeuvre({"type": "kvlcc2"}, "turning", Orders(depth_m=30))
    with pytest.raises(InputError, match=r"--depth 15: .*its hull would touch seabed"):
        run_manoeuvre(SHALLOW, "turning", Orders(depth_m=15))
    trial = in_shallow_water
    assert trial.title == "kvlcc2, variant shallow: zigzag, 20/1 at 7.003 m/s in 31.2 m of water"
    speed = float(np.hypot(*trial.track.velocity[-1, :2]))
    sinkage, trim = squat((1.46, 1.0), 312600.0, 320.0, speed, 31.2, 9.81)
    assert trial.track.position[-1, 2] == pytest.approx(sinkage + 3.3e8 * speed * trim / 1.68e8, rel=0.05)


def test_rates_of_a_spiral_are_positive_to_starboard_whichever_way_the_helm_is_swept():
    trial = run_manoeuvre({"type": "navalvessel"}, "spiral", Orders(rudder_deg=20, seconds=30))
    found = by_name(trial.measures)
    for way in ("to port", "back"):
        assert found[f"yaw rate at +20 deg of helm, sweep {way}"].value > 1.0
        assert found[f"yaw rate at -10 deg of helm, sweep {way}"].value < -0.5
    assert trial.track.attitude[295, 2] > 0.5  # 30 s of helm to starboard


def steady_turn(vehicle, states, guess):
    """Speed, sway and yaw rate [m/s], [m/s], [deg/s] at which forces vanish, by actuators' states; level."""
    ship = Vehicle.from_dict(vehicle)

    def forces(x):
        nu = [[x[0], x[1], 0.0, 0.0, 0.0, math.radians(x[2])]]
        acceleration = ship.accelerations(np.zeros((1, 6)), nu, [states], [states])[0][0]
        return (ship.config.body.mass_matrix @ acceleration)[[0, 1, 5]] / [1e5, 1e5, 1e7]

    return fsolve(forces, guess)


def test_a_steady_turn_is_one_whose_speed_is_steady_too():
    """KVLCC2 from 20 to 10 to 5 deg of helm: its yaw rate passes a least one 4 % below the steady one, while it gains
    way; steady is where the forces of the model vanish."""
    run = CalmRun({"type": "kvlcc2"}, 7.97)
    rates = []
    for helm in (20.0, 10.0, 5.0):
        run.command[0] = math.radians(helm)
        rates.append(run.settled_rate(320 / 7.97))  # often enough to look while the rate is at its least
    guess = (4.0, -1.0, 0.4)
    for helm, rate in zip((20.0, 10.0, 5.0), rates, strict=True):
        guess = steady_turn({"type": "kvlcc2"}, [math.radians(helm)], guess)
        assert rate == pytest.approx(guess[2], rel=0.01), helm


@pytest.mark.slow  # 30 s
def test_a_spiral_finds_a_loop_beside_helm_amidships():
    """The tanker's propeller turns it to port: between 0.2 and 0.9 deg of helm, not at 0, it has two steady turns."""
    trial = run_manoeuvre({"type": "tanker"}, "spiral")
    loop = by_name(trial.measures)["height of the loop, at +0.5 deg"].value
    turns = [
        steady_turn({"type": "tanker"}, [math.radians(0.5), 80 / 60], guess)[2]
        for guess in ((7.0, -0.4, 0.15), (7.0, 0.4, -0.16))
    ]
    assert turns[1] < -0.1 < 0.1 < turns[0]
    assert loop == pytest.approx(turns[0] - turns[1], rel=0.02)
    assert draw(trial).startswith(b"\x89PNG")


def test_a_ship_in_shallow_water_begins_at_a_speed_that_it_holds(in_shallow_water):
    """At its service revolutions KVLCC2 makes 7.0 m/s in 1.5 draughts of water, at 5 m/s ordered it turns faster than
    in deep water; neither loses way in 10 s straight ahead. 7.97 m/s there are refused."""
    first = [approach(SHALLOW, Orders(depth_m=d)).speed for d in (31.2, 24.96)]
    assert first == pytest.approx([0.88 * 7.97, 0.81 * 7.97], rel=0.01)  # docs/vehicles.md: 12 and 19 % lost
    slow = approach(SHALLOW, Orders(depth_m=31.2, speed_m_s=5.0))
    run = CalmRun(slow.vehicle, slow.speed, revolutions=slow.revolutions, depth=31.2)
    run.go(10.0)
    for track, speed in ((in_shallow_water.track, first[0]), (run.track(), 5.0)):
        before = track.time <= 10.0
        assert np.count_nonzero(before) > 90
        assert track.velocity[before, 0] == pytest.approx(speed, rel=2e-3)
    with pytest.raises(InputError, match=r"--speed 7\.5: kvlcc2 makes at most 7 m/s in 31\.2 m of water"):
        run_manoeuvre(SHALLOW, "turning", Orders(depth_m=31.2, speed_m_s=7.5))


def test_a_trial_brings_its_own_control_mode():
    """Of a ship without the mode `actuators`, and of one whose mode of that name is another."""
    for changed in (None, {"type": "wrench"}):
        ship = {"type": "navalvessel", "modes": {"actuators": changed}}
        assert run_manoeuvre(ship, "zigzag", Orders(angle_deg=1.0)).measures


def test_vehicles_refuse_what_they_cannot():
    with pytest.raises(InputError, match=r"otter has no ship's rudder .*left_propeller.*; what it can do is .*stop"):
        run_manoeuvre({"type": "otter"}, "turning")
    with pytest.raises(
        InputError, match=r"mariner has no actuators for stop, .* that push along its hull; its own: .+"
    ):
        run_manoeuvre({"type": "mariner"}, "stop")
    with pytest.raises(
        InputError, match=r"remus100 has no actuators for bollard, .*; its own: .*propeller of the type p"
    ):
        run_manoeuvre({"type": "remus100"}, "bollard")
    with pytest.raises(LookupFailed, match=r"unknown manoeuvre 'zig-zag' .did you mean 'zigzag'"):
        run_manoeuvre({"type": "otter"}, "zig-zag")


def test_a_vehicle_under_water_stops_as_its_thrust_and_drag_say():
    """BlueROV2 from its largest speed: (m + m_a) du/dt = -T - (X_u + X_uu u) u, T by the bollard pulls astern of four
    thrusters at 45 deg, and up to 0.2 s for thrusters that turn round; a battery that sags takes 10 %."""
    config = Vehicle.from_catalogue("bluerov2").config
    found = by_name(run_manoeuvre({"type": "bluerov2"}, "stop").measures)
    pull = by_name(run_manoeuvre({"type": "bluerov2"}, "bollard").measures)
    linear, square = config.terms["linear_damping"].diagonal[0], config.terms["quadratic_damping"].diagonal[0]
    top = found["speed before"].value
    assert config.envelope.top_mps <= top < config.envelope.top_mps + 0.05  # a tick at 4 m/s^2
    astern = 4 * np.cos(np.pi / 4) * abs(pull["front_port, astern"].value)
    speeds = np.linspace(0, top, 1000)
    mass = config.mass.mass_kg + config.added_mass.diagonal[0]
    slowing = np.trapezoid(mass / (astern + (linear + square * speeds) * speeds), speeds)
    assert 0.9 * slowing < found["stopping time"].value < 1.1 * slowing + 0.2


@pytest.mark.parametrize(("name", "top"), [("supply", 3.0), ("bluerov2_heavy", None)])
def test_a_stop_begins_at_the_largest_speed_or_at_what_thrusters_make(name, top):
    """The supply vessel's drag is linear and would let it reach 20 m/s, for which it was not identified; eight T200
    take the heavy BlueROV2 to 0.83 m/s, where their thrust is its drag, and not to the 1.5 m/s of its maker."""
    found = by_name(run_manoeuvre({"type": name}, "stop").measures)
    if top is not None:
        assert top <= found["speed before"].value < top + 0.1 * 2 * 798720 / 6764400  # a tick of full thrust
        return
    config = Vehicle.from_catalogue(name).config
    assert found["speed before"].value < config.envelope.top_mps
    assert found["speed before"].value == pytest.approx(0.84, abs=0.03)  # docs/vehicles.md


def test_pulls_are_told_by_the_way_they_act():
    """A tunnel pushes to a side, and a thruster that is mounted the other way round ahead at its lower limit."""
    found = by_name(run_manoeuvre({"type": "supply"}, "bollard").measures)
    assert found["bow_tunnel_1, to starboard"].value == -found["bow_tunnel_1, to port"].value == 3.2 * 250**2
    assert found["port_propeller, ahead"].value == 31.2 * 160**2
    turned = {
        "type": "force_thruster", "position_m": [-34, 0, 0], "low_n": -25.0, "high_n": 30.0, "time_constant_s": 1.0,
    }  # fmt: skip
    parts = {
        "aft": {**turned, "direction": [-1, 0, 0]},
        "lift": {**turned, "direction": [0, 0, -1]},
        "side": {**turned, "direction": [0.3, -0.9, 0.2]},
    }
    found = by_name(run_manoeuvre({"type": "supply", "actuators": parts}, "bollard").measures)
    told = {
        "aft, ahead": 25.0, "aft, astern": -30.0, "lift, down": 25.0, "lift, up": -30.0, "side, to starboard": 25.0,
        "side, to port": -30.0,
    }  # fmt: skip
    assert {name: found[name].value for name in told} == pytest.approx(told)


def test_bollard_of_an_otter():
    """Table of the Otter's own data: 24.4 and 13.6 kgf of both propellers."""
    found = by_name(run_manoeuvre({"type": "otter"}, "bollard").measures)
    assert found["left_propeller, ahead"].value == pytest.approx(24.4 * 9.81 / 2, rel=1e-3)
    assert found["right_propeller, astern"].value == pytest.approx(-13.6 * 9.81 / 2, rel=1e-3)


@pytest.mark.slow
def test_mariner_keeps_the_limits():
    """35 deg to starboard (to port its own asymmetry makes it wider), 10/10 from 15 knots."""
    turn = run_manoeuvre({"type": "mariner"}, "turning")
    assert {m.name for m in turn.measures if m.kept} == {"advance", "tactical diameter"}
    assert draw(turn).startswith(b"\x89PNG")
    zigzag = run_manoeuvre({"type": "mariner"}, "zigzag", Orders())
    assert all(m.kept is not False for m in zigzag.measures)


def test_an_engine_of_fixed_revolutions_is_stopped_in_a_decay():
    """At rest the tanker rolls on one spot (with its engine it makes 2 m/s in two minutes), and less than six periods
    tell its damping as twelve do."""
    short, long = (run_manoeuvre({"type": "kvlcc2"}, "decay", Orders(seconds=s)) for s in (120.0, 240.0))
    assert np.abs(short.track.velocity[:, 0]).max() < 0.02
    few, many = by_name(short.measures), by_name(long.measures)
    assert few["period"].value == pytest.approx(many["period"].value, rel=0.01)
    assert 0 < many["its growth with the angle"].value == pytest.approx(few["its growth with the angle"].value, rel=0.3)
    at = np.radians(8.0)  # a heel that both runs pass
    share = [m["damping ratio at small angles"].value + at * m["its growth with the angle"].value for m in (few, many)]
    assert share[0] == pytest.approx(share[1], rel=0.1)
