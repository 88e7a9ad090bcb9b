"""Sonars that hear one another: arrivals at the time of flight, at the one-way level, through beams and bands."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from sonar_scenes import DT_NS, at, box, context, plane

import pelagos as pl
from pelagos import jit
from pelagos.acoustics.absorption import absorption
from pelagos.acoustics.beam_pattern import HALF_POWER_LINE, weighted_line_np
from pelagos.acoustics.interference import Sent, band_overlap, through_filter
from pelagos.errors import InputError
from pelagos.math.so3 import from_euler
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.keys.sector_keys import layout
from pelagos.sensors.sonar.mechanical_scanning_sonar import MechanicalScanningSonar, MechanicalScanningSonarConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.ping.emitter import Apertures
from pelagos.sensors.sonar.ping.interference import Neighbours
from pelagos.sensors.sonar.singlebeam import cone_rays

DEEP = -200.0
QUIET = {"self_noise_db": -200.0, "source_level_db": 220.0, "wind_speed_mps": 0.0, "scale": "linear"}
SMALL = {"beams": 65, "horizontal_aperture_deg": 65.0, "beamwidth_deg": 1.0, "bins": 600, "range_max_m": 60.0,
         "rays_per_beam": 8, "side_lobe_beams": 0}  # fmt: skip


def test_band_overlap():
    assert band_overlap(750e3, 30e3, 750e3, 30e3) == 1.0
    assert band_overlap(750e3, 30e3, 765e3, 30e3) == pytest.approx(0.5)
    assert band_overlap(750e3, 30e3, 400e3, 80e3) == 0.0
    assert band_overlap(750e3, 100e3, 750e3, 30e3) == 1.0  # all of a narrow pulse in a wide band


def matched(own: Sent, other: Sent, rate: float = 4e6) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and amplitude of a chirp behind another's Hann-shaded matched filter, by the sum itself."""

    def wave(sent, t, offset):
        return np.exp(1j * np.pi * sent.bandwidth_hz / sent.pulse_s * t**2 + 2j * np.pi * offset * t)

    grid = lambda sent: np.arange(-sent.pulse_s / 2, sent.pulse_s / 2, 1 / rate)
    t0, t1 = grid(own), grid(other)
    place = own.bandwidth_hz / own.pulse_s * t0 / own.bandwidth_hz  # a chirp's frequency, in bandwidths
    replica = wave(own, t0, 0.0) * (1 + np.cos(2 * np.pi * place))
    received = wave(other, t1, other.frequency_hz - own.frequency_hz)
    found = np.correlate(received, replica, mode="full") / np.vdot(replica, wave(own, t0, 0.0)).real
    return (np.arange(len(found)) - (len(t0) - 1)) / rate + t1[0] - t0[0], np.abs(found)


class TestFilter:
    OWN = Sent(750e3, 30e3, 2e-3)

    @pytest.mark.parametrize(
        "other", [Sent(750e3, 30e3, 2e-3), Sent(750e3, 30e3, 4e-3), Sent(760e3, 50e3, 1e-3), Sent(745e3, 10e3, 3e-3)]
    )
    def test_a_pulse_comes_out_as_its_correlation(self, other):
        """Shading by frequency is shading along the chirp but for Fresnel's ripples: 8 % of the peak at B T = 60."""
        found = through_filter(self.OWN, other)
        time = found.lead_s + found.step_s * np.arange(len(found.signal))
        t, expected = matched(self.OWN, other)
        assert np.abs(found.signal) == pytest.approx(np.interp(time, t, expected), abs=0.08 * expected.max())

    def test_its_own_pulse_is_compressed_to_one(self):
        found = through_filter(self.OWN, self.OWN)
        time = found.lead_s + found.step_s * np.arange(len(found.signal))
        x = 30e3 * time
        expected = np.sinc(x) + 0.5 * (np.sinc(x - 1.0) + np.sinc(x + 1.0))
        assert found.signal.real == pytest.approx(expected, abs=0.03)
        assert np.abs(found.signal.imag).max() < 0.03


def test_apertures_of_a_cone():
    beam = Apertures.of_fan(cone_rays(math.radians(10), 64), 1, math.radians(10), math.radians(10))
    tilt = lambda degrees: np.array([math.sin(math.radians(degrees)), 0.0, -math.cos(math.radians(degrees))])
    assert beam.power(tilt(0.0))[0] == pytest.approx(1.0, abs=1e-3)
    assert min(beam.power(tilt(5.0))[0], beam.power(tilt(-5.0))[0]) == pytest.approx(0.5, rel=0.03)
    assert beam.power(-tilt(0.0))[0] <= 1e-3


def test_the_loudest_beam_of_an_array_is_found_without_asking_all():
    config = ImagingSonarConfig(beams=64, beamwidth_deg=1.5)
    beams = Apertures.of_array(layout(config).aperture)
    rng = np.random.Generator(np.random.PCG64(4))
    directions = rng.normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    ahead = directions[:, 0] > 0.45  # in the sector; behind and beside it side lobes compete
    assert beams.loudest(directions)[ahead] == pytest.approx(beams.power(directions).max(axis=-1)[ahead], rel=1e-9)


def test_others_are_those_of_other_vehicles():
    paths = ("auv0.bow", "auv0.stern", "auv1.bow", "auv10.stern", "auv.bow")
    neighbours = Neighbours(paths)
    assert neighbours.chosen("others", "auv0.stern") == ["auv1.bow", "auv10.stern", "auv.bow"]
    assert neighbours.chosen("others", "auv1.bow") == ["auv0.bow", "auv0.stern", "auv10.stern", "auv.bow"]
    assert neighbours.chosen("none", "auv0.stern") == []
    assert neighbours.chosen(["auv0.bow"], "auv0.stern") == ["auv0.bow"]


def pair(*geometries, other=None, distance=30.0, bearing=0.0, **options):
    """A sonar that looks along x, and another one `distance` away that looks back at it."""
    neighbours = Neighbours(("auv0.sonar", "auv1.sonar"))
    direction = np.array([math.cos(bearing), math.sin(bearing), 0.0])
    place = tuple(np.array([0.0, 0.0, DEEP]) + distance * direction)
    turn = [float(a) for a in from_euler(0.0, 0.0, math.pi + bearing)]
    scene = [plane(DEEP - 100.0), *geometries]
    make = lambda path, o: ImagingSonar(
        ImagingSonarConfig(**(SMALL | QUIET | o)), replace_path(context(scene), path, neighbours)
    )
    receiver = make("auv0.sonar", {"hears": "others", **options})
    make("auv1.sonar", {**options, **(other or {})})
    tick = {"now": 0}

    def sense(k=0):
        tick["now"] = k
        return receiver.sense(at(0, 0, DEEP, tick=k))

    neighbours.motion_of = lambda agent: at(*place, tick=tick["now"], attitude=turn)
    return receiver, sense


def replace_path(made, path, neighbours):
    return replace(made, path=path, neighbours=neighbours)


def test_the_pulse_arrives_after_its_time_of_flight():
    """Both ping at t = 0: 30 m one way look like 15 m; pings at other times hear it earlier or not at all."""
    receiver, sense = pair()
    r = receiver.tables["range"]
    level = sense().data[0, 32] - sense().truth[0, 32]
    assert r[np.argmax(level)] == pytest.approx(15.0, abs=0.11)
    later = sense(k=6).data[0, 32]  # 30 ms later; the other's next ping is at 200 ms: out of this ping's 80 ms
    assert later.max() < 1e-3 * level.max()
    earlier = sense(k=34).data[0, 32]  # at 170 ms: pinged 170 ms ago, pings again in 30 ms, heard after 50 ms
    assert r[np.argmax(earlier)] == pytest.approx(0.05 * 1500 / 2, abs=0.11)


def test_level_is_the_one_way_sonar_equation():
    """SL' - 20 log d - a d, re this sonar's SL: in the reading's unit times 10^(3 log r + 2 a r/10) over what a
    sample hears of an even bottom: the integral of the beam's power pattern, 1.056/L of the array's length L with its
    light shading, times 1.5 c/2B of the shaded chirp.

    The same pulse is compressed, and a bin keeps its strongest sample: one ping is enough, and all are the same.
    """
    receiver, sense = pair(other={"source_level_db": 226.0})
    heard = np.array([sense(k=40 * j).data[0, 32].max() for j in range(5)])
    a = float(absorption(jit.Float64(750e3), 10.0, 35.0, 200.0)[0])
    length = HALF_POWER_LINE * 1.1294 / (2 * math.sin(math.radians(0.5)))
    cell = (1 + 0.5 / 9) / length * 1.5 * 1500 / 60e3
    r = receiver.tables["range"][146]  # 15.03 m
    gain = r**3 * 10 ** (2 * a * r / 10) / cell
    expected = 10**0.6 / 30.0**2 * 10 ** (-a * 30.0 / 10) * gain
    assert heard == pytest.approx(np.full(5, expected), rel=0.03)  # 0.1 dB


@pytest.mark.parametrize("bearing", [-27.3, 4.6])
def test_its_bearing_is_right_in_every_ping(bearing):
    """All beams hear one wave: the level falls from the beam that looks there by the array's pattern."""
    receiver, sense = pair(bearing=math.radians(bearing))
    azimuth = receiver.tables["azimuth"].astype(float)
    length = HALF_POWER_LINE * 1.1294 / (2 * math.sin(math.radians(0.5)))
    pattern = weighted_line_np(np.sin(math.radians(bearing)) - np.sin(azimuth), length, "light") ** 2
    main = pattern > 0.05
    for k in range(4):
        heard = sense(k=40 * k).data[0].max(axis=1)
        assert heard[main] / heard.max() == pytest.approx(pattern[main] / pattern.max(), rel=0.01)
        assert abs(math.degrees(azimuth[heard.argmax()]) - bearing) <= 0.5


def test_only_beams_that_look_there_hear_it():
    receiver, sense = pair(bearing=math.radians(10.0))
    heard = np.array([sense(k=40 * j).data[0].max(axis=1) for j in range(30)]).mean(axis=0)
    azimuth = np.degrees(receiver.tables["azimuth"])
    assert azimuth[np.argmax(heard)] == pytest.approx(10.0, abs=1.0)
    assert heard[np.abs(azimuth - 10) > 5].max() < 0.03 * heard.max()  # side lobes: -13 dB and less


@pytest.mark.parametrize("other", [{"frequency_hz": 1.2e6}, {"frequency_hz": 400e3}])
def test_other_bands_are_not_heard(other):
    _, sense = pair(other=other)
    _, deaf = pair(hears="none")
    np.testing.assert_array_equal(sense().data, deaf().data)


def test_another_kind_of_pulse_is_longer_and_weaker():
    """A chirp of half the slope: each frequency comes at another time, over the difference of both durations."""
    receiver, sense = pair(other={"pulse_s": 4e-3}, pulse_s=2e-3, bins=600, range_min_m=13.0, range_max_m=17.0)
    r = receiver.tables["range"].astype(float)
    found = np.sqrt(sense().data[0, 32] / r**3)
    t, expected = matched(Sent(750e3, 30e3, 2e-3), Sent(750e3, 30e3, 4e-3))
    expected = np.interp(2 * (r - 15.0) / 1500.0, t, expected)
    assert found / found.max() == pytest.approx(expected / expected.max(), abs=0.12)  # Fresnel's ripples
    assert found[np.abs(r - 15.0) < 0.2].mean() > 10 * found[np.abs(r - 15.0) > 1.0].mean()


def test_far_and_faint_sonars_cost_nothing():
    """At 2 km and 750 kHz the pulse has lost 500 dB: nobody is asked what arrives of it."""
    receiver, sense = pair(distance=2000.0)
    sense()
    own = receiver._pinger._own
    assert receiver._pinger._neighbours.heard(own, ["auv1.sonar"], at(0, 0, DEEP)) is None


def test_a_wall_silences_it():
    wall = box((15.0, 0.0, DEEP), (0.5, 20.0, 20.0))
    _, sense = pair(wall)
    _, deaf = pair(wall, hears="none")
    np.testing.assert_array_equal(sense().data, deaf().data)


def test_a_scanning_head_is_loudest_where_it_looks():
    neighbours = Neighbours(("auv0.sonar", "auv1.sonar"))
    build = lambda path, o: MechanicalScanningSonar(
        MechanicalScanningSonarConfig(step_deg=10.0, rays=64, bins=100, **(QUIET | o)),
        replace_path(context([plane(DEEP - 100.0)]), path, neighbours),
    )
    scanner = build("auv0.sonar", {"hears": ("auv1.sonar",)})
    build("auv1.sonar", {})
    found = []
    for k in range(36):
        neighbours.motion_of = lambda agent, k=k: at(0, 20.0, DEEP, tick=20 * k)
        reading = scanner.sense(at(0, 0, DEEP, tick=20 * k))
        found.append((reading.extras["angle"][0], reading.data[0].max()))
    angle, level = np.array(found).T
    loud = angle[level > 1e-2 * level.max()]
    assert set(np.round(np.degrees(loud)).astype(int)) & {90}


@pytest.mark.parametrize("turns", ["receiver", "source"])
def test_heads_turn_to_the_left(turns):
    """A head hears, and is heard, where it looks at the other, which looks back: at 50 deg, not at -50 deg."""
    neighbours = Neighbours(("auv0.sonar", "auv1.sonar"))
    bearing = math.radians(50.0)
    there, back = 20.0 * np.array([math.cos(bearing), math.sin(bearing), 0.0]), math.pi + bearing
    scanning = MechanicalScanningSonarConfig(step_deg=10.0, rays=64, bins=100, frequency_hz=750e3, **QUIET)
    fixed = ImagingSonarConfig(frequency_hz=750e3, **(SMALL | QUIET))
    for path, part in (("auv0.sonar", "receiver"), ("auv1.sonar", "source")):
        kind, config = (MechanicalScanningSonar, scanning) if part == turns else (ImagingSonar, fixed)
        kind(config, replace_path(context([plane(DEEP - 100.0)]), path, neighbours))
    # whoever turns lies along x, whoever stands still looks at it
    ticks = range(0, 36 * 20, 20)
    turning = lanes(ticks, dt_ns=DT_NS, position=(0, 0, DEEP))
    still = lanes(
        ticks, dt_ns=DT_NS, position=(there[0], there[1], DEEP), attitude=[float(a) for a in from_euler(0.0, 0.0, back)]
    )
    here, other = (turning, still) if turns == "receiver" else (still, turning)
    neighbours.motion_of = lambda agent: other
    heard = neighbours.heard(neighbours.emitters["auv0.sonar"], ["auv1.sonar"], here)
    level = np.array(heard.level).reshape(36, -1).max(axis=1)
    angles = np.degrees(scanning.angles(np.arange(36)))
    assert (angles[np.argmax(level)] + 180.0) % 360.0 - 180.0 == pytest.approx(50.0, abs=1e-6)


def test_what_stands_between_two_sonars_silences_them_in_its_own_copy():
    """A plate half way, in one copy or the other: what is heard is what both hear with all plates aside, or between."""
    sim = pl.Simulation.load(scenario("others"), n=2)
    plate = sim.spawn(pl.Prop("box", position=(10.0, 30.0, -10.0), size=(0.4, 6.0, 6.0)))
    there, heard = {"aside": (10.0, 30.0, -10.0), "between": (10.0, 0.0, -10.0)}, {}
    for places in (("aside", "aside"), ("between", "between"), ("aside", "between"), ("between", "aside")):
        plate.move(position=[there[place] for place in places])
        for copy, place in enumerate(places):
            seen = sim.observe("auv0", sim.state["auv0"].position[copy], sensors=["imaging"], copy=copy)["imaging"]
            heard.setdefault(place, []).append(seen.data.tobytes())
            assert (float((seen.data - seen.truth).max()) > 0.08) == (place == "aside")
    assert [len(set(found)) for found in heard.values()] == [1, 1]


def test_a_multibeam_can_be_heard():
    neighbours = Neighbours(("auv0.sonar", "ship.multibeam"))
    Multibeam(
        MultibeamConfig(beams=16, frequency_hz=750e3),
        replace_path(context([plane(-300.0)]), "ship.multibeam", neighbours),
    )
    sonar = ImagingSonar(
        ImagingSonarConfig(**(SMALL | QUIET), hears=("ship.multibeam",), orientation_deg=(0, -60, 0)),
        replace_path(context([plane(-300.0)]), "auv0.sonar", neighbours),
    )
    neighbours.motion_of = lambda agent: at(12.0, 0, DEEP + 20.0)
    assert sonar.sense(at(0, 0, DEEP)).data[0].max() > 1e-6


def scenario(hears):
    sonar = {"type": "imaging_sonar", "rate_hz": 5, "beams": 16, "bins": 64, "rays_per_beam": 8, "range_max_m": 40.0}
    agent = lambda x, heading, **more: {
        "vehicle": "remus100",
        "start": {"position_m": [x, 0.0], "depth_m": 10.0, "heading_deg": heading},
        "sensors": {"imaging": {**sonar, **more}},
    }
    return {
        "seed": 3,
        "world": {"type": "flat", "depth_m": 60.0},
        "agents": {"auv0": agent(0.0, 0.0, hears=hears), "auv1": agent(20.0, 180.0)},
    }


def read(sim, seconds=0.6):
    found = [sim.reset()["auv0"]["imaging"].data]
    for _ in range(round(seconds * 1e9 / sim.dt_ns)):
        now = sim.step()["auv0"]
        found += [now["imaging"].data] if "imaging" in now else []
    return np.array(found)


def test_vehicles_of_a_scenario_hear_one_another_and_the_same_in_every_copy():
    deaf, hearing = (read(pl.Simulation.load(scenario(h))) for h in ("none", "others"))
    assert np.abs(hearing - deaf).max() > 0.1
    assert (hearing == deaf).mean() > 0.8  # one pulse a ping
    fleet = read(pl.Simulation.load(scenario(["auv1.imaging"]), n=2))
    np.testing.assert_array_equal(fleet[:, 0], hearing[:, 0])


def test_a_sonar_that_is_not_there_is_named():
    with pytest.raises(InputError, match=r"auv0.*hears.*auv1\.imaging"):
        pl.Simulation.load(scenario(["auv1.imagine"]))


def test_sonars_that_are_moved_together_are_heard_each():
    """Two vehicles alike share their sonar; a third one hears both."""
    sonar = {"type": "singlebeam", "frequency_hz": 125_500.0, "rate_hz": 10}
    place = {"a": (0, 0, 20), "b": (30, 0, 30), "c": (15, 10, 25)}
    agents = {
        name: {
            "vehicle": "remus100",
            "start": {"position_m": [x, y], "depth_m": depth},
            "sensors": {"sonar": {**sonar, **({"hears": "others"} if name == "c" else {})}},
        }
        for name, (x, y, depth) in place.items()
    }
    sim = pl.Simulation.load(
        {"seed": 5, "tick_rate_hz": 20, "world": {"type": "flat", "depth_m": 60.0}, "agents": agents}
    )
    assert len(sim.model.batches) == 2
    assert {"a.sonar", "b.sonar", "c.sonar"} == set(sim.encounters.neighbours.emitters)
    sim.step(ticks=2)
    assert np.isfinite(sim.observe("c", (15, 10, -25))["sonar"].data).all()


@pytest.mark.parametrize(
    "hears", [pytest.param("others", marks=pytest.mark.slow), ["auv[1].imaging", "lone.head", "auv[0].head"]]
)
def test_sonars_of_a_group_that_hear_others_read_in_one_call_what_each_reads_alone(hears, monkeypatch):
    """To the byte, in every copy: vehicles out of one another's sight, at different distances; heads that turn."""
    imaging = {"type": "imaging_sonar", "rate_hz": 5, "beams": 24, "bins": 150, "range_max_m": 25.0, "hears": hears}
    head = {"type": "mechanical_scanning_sonar", "rate_hz": 10, "bins": 80, "range_max_m": 20.0, "hears": hears}
    sensors = {"imaging": imaging, "head": head | {"position_m": [0.1, -0.2, 0.15]}}
    alike = {"vehicle": "remus100", "sensors": sensors}
    group = alike | {
        "count": 4,
        "start": {"position_m": [0.0, -20.0], "depth_m": 5.0, "speed_mps": 1.5, "spacing_m": [34.0, 45.0]},
        "distributions": {"start.heading_deg": {"uniform": [-180.0, 180.0]}, "start.depth_m": {"uniform": [4.0, 8.0]}},
    }
    lone = alike | {"vehicle": "bluerov2", "start": {"position_m": [-60.0, 500.0], "depth_m": 7.0, "heading_deg": -80}}
    written = {"seed": 8, "tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 12.0, "size_m": [2000, 2000]}}

    def pings() -> list[bytes]:
        sim = pl.Simulation.load(written | {"agents": {"auv": group, "lone": lone}}, n=2)
        found = []
        for _ in range(3):
            obs = sim.step(ticks=10)
            found += [obs[name][sensor].data.tobytes() for name in obs for sensor in sensors]
        batches.append(len(sim.model.batches))
        return found

    batches: list[int] = []
    together = pings()
    monkeypatch.setattr("pelagos.sim.batch._shareable", lambda agent: False)
    alone = pings()
    assert batches == [2, 5]
    assert together == alone
    for sensor in sensors.values():
        sensor["hears"] = "none"
    assert sum(one != other for one, other in zip(pings(), alone, strict=True)) > 12
