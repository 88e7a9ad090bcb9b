"""Parts of sensors by themselves, against second ways: beams of a log, points in fine cells, pulse pairs, beacons."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sonar_scenes import DT_NS, context, plane

from pelagos import jit
from pelagos.sensors.comms.link.budget import same_waveform_db, success, sum_arrivals
from pelagos.sensors.comms.link.traffic import Traffic
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.dvl import Dvl, DvlConfig, beam_echo
from pelagos.sensors.sonar.ping.pinger import boost


@pytest.mark.parametrize("beam", [0, 2, 3])
def test_a_beam_of_a_log_is_the_mean_of_its_rays_that_meet_something(beam: int) -> None:
    """Three lanes of four beams of five rays, of which all, some, two or none meet something; else infinity."""
    rng = np.random.default_rng(7)
    valid = rng.random((3, 4, 5)) < 0.7
    valid[0, beam], valid[1, beam] = [True, True, False, True, False], [True, False, False, False, True]
    distance = np.where(valid, rng.uniform(2.0, 30.0, (3, 4, 5)), np.inf)
    section, ground = rng.uniform(0.01, 0.2, (3, 4, 5)), rng.normal(size=(3, 4, 5, 3))
    axis = np.array([0.3, -0.4, -0.8])
    seen, mean, level, speed = (
        np.array(a)
        for a in beam_echo(
            3, beam, jit.Bool(valid.ravel()), jit.Float(distance.ravel()), jit.Float(section.ravel()),
            jit.Array3f(*ground.reshape(-1, 3).T), axis,
        )
    )  # fmt: skip
    for lane in range(3):
        met = valid[lane, beam]
        assert seen[lane] == (met.sum() >= 3)
        if met.any():
            assert mean[lane] == pytest.approx(distance[lane, beam][met].mean(), rel=1e-5)
            assert level[lane] == pytest.approx(section[lane, beam][met].mean(), rel=1e-5)
            assert speed[lane] == pytest.approx((ground[lane, beam][met] @ axis).mean(), rel=1e-4, abs=1e-6)


def test_a_point_in_fine_cells_is_heard_as_a_whole() -> None:
    """By hand: the amplitudes 0.6 in range and 0.5 or 0.4 in angle are squared, the cell is 1.5 bins, of the sector
    the beams hear 0.8 and 1.25: 1/(0.36 0.25 1.5 0.8) and 1/(0.36 0.16 1.5 1.25)."""
    pulse = np.array([0.1, 0.6, 0.2], np.float32)
    spec: Any = SimpleNamespace(equivalent_m=0.3, bin_width_m=0.2)
    steering = np.array([[0.1, 0.5, 0.3], [0.2, 0.4, 0.1]], np.float32)
    layout: Any = SimpleNamespace(beams=2, steering=steering, heard_parts=np.array([0.8, 1.25], np.float32))
    assert boost(spec, layout, pulse) == pytest.approx([1 / 0.108, 1 / 0.108], rel=1e-5)
    layout.steering = None
    assert boost(spec, layout, pulse) == pytest.approx([1 / 0.432, 1 / 0.675], rel=1e-5)


def test_pulse_pairs_turn_in_each_cell_by_the_speed_of_what_is_there() -> None:
    """A level bottom at the height h below: what is heard at the range r lies at acos(h/r) from straight down. Half of
    a wide beam turns more and half less than its axis; 3 % for the beam's extent to the sides, and the scatter."""
    height, velocity, lag, pings = 12.0, np.array([5.0, -2.0, 0.4]), 1e-4, 100
    config = DvlConfig(iq=True, noise_mps=0.0, noise_relative=0.0, range_max_m=30.0, beamwidth_deg=8.0)
    dvl = Dvl(config, context([plane(-200.0 - height)]))
    places = np.array([0, 0, -200.0]) + np.arange(pings)[:, None] * np.array([0.1, 0.03, 0])
    iq = dvl.sense(lanes(range(pings), dt_ns=DT_NS, position=places, velocity=tuple(velocity))).extras["iq"]
    ranges = dvl.tables["water_column_range"].astype(float)
    axis_range = height / math.cos(math.radians(config.beam_tilt_deg))
    for factor in (0.975, 1.03):
        here = np.abs(ranges - factor * axis_range) < 0.006 * axis_range
        down = height / ranges[here].mean()
        cells = np.moveaxis(iq[..., here], -1, 0).reshape(-1, 4, 2)  # pings and cells alike
        pair = np.stack([cells[..., 0], cells[..., 1]], axis=2)
        cross = (np.conj(pair[..., 0]) * pair[..., 1]).sum(axis=0)
        found = np.angle(cross) * 1500.0 / (4 * math.pi * config.frequency_hz * lag)
        for b, azimuth in enumerate(np.radians(config.beam_azimuth_deg)):
            level = math.sqrt(1 - down**2) * (velocity[0] * math.cos(azimuth) + velocity[1] * math.sin(azimuth))
            assert found[b] == pytest.approx(level - down * velocity[2], abs=0.03)


class Water:
    """A medium of one modem, in two copies."""

    def __init__(self, **keys: Any) -> None:
        self.seed, self.copies, self.dt_ns = 3, 2, 50_000_000
        usual: dict[str, Any] = {
            "path": "a.m", "period": 1, "queue": 1000, "beacon_s": None, "report": None, "interrogate": (),
            "address": 0, "beacon_to": "all", "beacon_bytes": 3, "acknowledge": False, "carrier": None,
            "clock_offset_std_s": 0.0, "clock_drift_std_ppm": 0.0, "kind": "sound", "frequency_hz": 25e3,
            "bandwidth_hz": 5e3, "mac": "none", "duration_s": lambda payload, kind="data": 1e6, "interrogate_s": 1.0,
            "holds": lambda payload, kind="data": True,
        }  # fmt: skip
        self.modems: dict[str, Any] = {"a.m": SimpleNamespace(**(usual | keys))}

    def noise(self, port: Any) -> float:
        return 40.0

    def level(self, t: float) -> float:
        return 1.7

    def find(self, name: str) -> str:
        return name

    def pose(self, path: str) -> Any:
        return SimpleNamespace(position=np.zeros((2, 3)), attitude=np.tile([1.0, 0, 0, 0], (2, 1)))


@pytest.mark.parametrize(
    "keys",
    [
        {"beacon_s": 2.0},
        {"interrogate": ("b.m",), "interrogate_s": 2.0},
        {"report": lambda port, pose, c, count: (b"x", 2.0)},
    ],
    ids=["beacon", "interrogation", "report"],
)
def test_what_a_modem_sends_by_itself_begins_anew_with_its_copy(keys: dict[str, Any]) -> None:
    """One thing in 2 s, by a modem that is busy for ever with the first: after 60 s some 30 wait. The second copy
    begins anew then: in 14 s it has 7, not the 37 that were due since the start; the first goes on."""
    water: Any = Water(**keys)
    episodes: Any = SimpleNamespace(environment=np.array([0, 1]), number=np.array([0, 0]))
    traffic = Traffic(water, episodes)
    due = [traffic.read("a.m", tick).status[:, [0, 3]].sum(axis=1) for tick in range(1201)][-1]
    assert due == pytest.approx([30, 30], abs=6)
    traffic.forget(np.array([False, True]), 1200)
    for tick in range(1201, 1481):
        waits = traffic.read("a.m", tick).status[:, 0]
        assert waits[1] <= 8
    assert waits[0] == pytest.approx(36, abs=6)
    assert waits[1] == pytest.approx(6 if "report" not in keys else 4, abs=3)


def port(**keys: Any) -> Any:
    """Of a modem, what sums of arrivals ask for."""
    usual = {
        "array": None, "multipath_window_s": 2e-3, "bandwidth_hz": 4e3, "frequency_hz": 25e3, "bit_rate_bps": 500.0,
        "coding_gain_db": 3.0, "modulation": "fsk", "chirp_order": 2, "sound_speed_mps": 1500.0,
    }  # fmt: skip
    return SimpleNamespace(**(usual | keys))


def test_arrivals_are_summed_within_the_window_of_the_first_loud_one() -> None:
    """By hand: the first way is 40 dB weaker than the loudest and counts nowhere as the first; the second, the loudest,
    is blocked; the fourth, 2.75 cycles after the third, and the fifth are within 2 ms of it, the last is later."""
    delay = np.array([0.199, 0.1995, 0.2, 0.20011, 0.2015, 0.21])
    amplitude = np.array([1e-5, 1.0, -6e-4j, 2e-4, 1e-3, 4e-4 + 3e-4j])
    doppler, blocked = np.array([1.01, 1.5, 1.02, 1.03, 0.97, 0.98]), np.arange(6) == 1
    arrival = np.array([[0, 0, 1.0], [0, 1.0, 0], [0.6, 0.8, 0], [0.8, 0, 0.6], [0, 0.6, -0.8], [1.0, 0, 0]])
    heard = sum_arrivals(port(array=np.zeros((4, 3))), 180.0, delay, amplitude, doppler, arrival, blocked)
    assert heard.delay_s == pytest.approx(0.2)
    assert heard.level_db == pytest.approx(180.0 + 10 * math.log10(6e-4**2 + 2e-4**2 + 1e-3**2))
    assert heard.echoes_db == pytest.approx(180.0 + 10 * math.log10(5e-4**2 + 1e-5**2))
    assert (heard.doppler, heard.lost) == (0.97, "")
    assert heard.waves is not None  # within 1/(4 kHz) there are two, from where they come, the second turned by its way
    assert heard.waves[0] == pytest.approx(np.array([[-0.6, -0.8, 0], [-0.8, 0, -0.6]]))
    assert heard.waves[1] == pytest.approx(np.array([-6e-4j, 2e-4j]))
    everything = np.ones(6, bool)
    assert sum_arrivals(port(), 180.0, delay, amplitude, doppler, arrival, everything).lost == "blocked"


def test_a_packet_is_lost_by_the_sum_of_all_powers() -> None:
    """Non-coherent FSK, exp(-g/2)/2 a bit: signal over noise and others as powers, times B/R and the coding's gain."""
    noise = 10 ** (9.3) + 10 ** (9.0) + 10 ** (8.7)
    g = 10 ** (9.4) / noise * 4e3 / 500.0 * 10**0.3
    expected = (1.0 - 0.5 * math.exp(-g / 2)) ** 40
    assert success(port(), 40, 94.0, 93.0, 90.0, 87.0, -math.inf) == pytest.approx(expected, rel=1e-6)
    assert same_waveform_db(port()) == pytest.approx(10 * math.log10(8.0) + 3.0)
    assert same_waveform_db(port(bit_rate_bps=9e3)) == 0.0
