"""The channel between two places of a world: geometry, Doppler, waveforms, noise; and its command."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import pelagos as pl
from pelagos.acoustics.channel import ambient_noise, impulse_response, received, spectral_level
from pelagos.cli.main import app
from pelagos.sensors.comms.link.water_paths import WaterPaths, shift_arrivals


def scenario(**changes: Any) -> dict[str, Any]:
    base: dict[str, Any] = {
        "seed": 5,
        "tick_rate_hz": 50,
        "world": {"type": "flat", "depth_m": 30.0},
        "agents": {
            "a": {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 10, "speed_mps": 2.0}},
            "b": {"vehicle": "remus100", "start": {"position_m": [200, -80], "depth_m": 18, "heading_deg": 90}},
        },
    }
    return base | changes


@pytest.fixture(scope="module")
def sim() -> pl.Simulation:
    return pl.Simulation.load(scenario())


@pytest.fixture(scope="module")
def pair() -> pl.Simulation:
    return pl.Simulation.load(scenario(), n=2)


def test_direct_path_runs_straight_between_the_ends(sim: pl.Simulation) -> None:
    tx, rx = np.array([10.0, 5.0, -8.0]), np.array([90.0, -40.0, -21.0])
    a = pl.channel(sim, tuple(tx), tuple(rx)).arrivals()
    way = rx - tx
    length = np.linalg.norm(way)
    c = float(np.array(sim.model.ocean.masses.sound_speeds)[28])  # at 14 m
    assert a.delay[0] == pytest.approx(length / c, rel=1e-4)
    np.testing.assert_allclose(a.departure[0], way / length, atol=2e-3)  # bent by pressure alone
    np.testing.assert_allclose(a.arrival[0], way / length, atol=2e-3)
    assert (a.surface[0], a.bottom[0]) == (0, 0)
    assert a.loss_db[0] == pytest.approx(20 * np.log10(length) + 4.2e-3 * length, abs=0.5)
    surface = np.flatnonzero((a.surface == 1) & (a.bottom == 0))[0]
    mirrored = np.linalg.norm(way * [1, 1, 0] + [0, 0, 8.0 + 21.0])
    assert a.delay[surface] == pytest.approx(mirrored / c, rel=1e-4)
    bottom = np.flatnonzero((a.surface == 0) & (a.bottom == 1))[0]
    assert a.delay[bottom] == pytest.approx(np.linalg.norm(way * [1, 1, 0] + [0, 0, 22.0 + 9.0]) / c, rel=1e-4)


def test_doppler_of_moving_vehicles(sim: pl.Simulation) -> None:
    """(1 - v_r.t/c)/(1 - v_s.t/c) with the ends' own velocities, to 1e-6."""
    made = pl.channel(sim, "a", "b")
    a, c = made.arrivals(), float(made.section.speed_at(14.0))
    v = sim.state["a"].velocity[0, 0] * np.array([1.0, 0.0, 0.0])  # heads north
    expected = 1.0 / (1.0 - a.departure @ v / c)
    np.testing.assert_allclose(a.doppler, expected, atol=1e-6)
    assert a.doppler[0] > 1.001


@pytest.mark.parametrize("aside", [0.0, 2e-3, 0.3])
def test_straight_below_every_echo_of_level_ground_is_heard(sim: pl.Simulation, aside: float) -> None:
    """2 n + 1 paths of up to n bounces: that casts scatter by micrometres is no slope of the ground."""
    for source, depth in ((1.04, 27.003), (3.3, 14.7), (20.01, 8.6)):
        a = pl.channel(sim.world, (12.3, -7.7, -source), (12.3 - aside, -7.7, -depth), bounces=3).arrivals()
        assert len(a) == 7
        c = float(np.array(sim.model.ocean.masses.sound_speeds)[28])
        images = [abs(depth - source), depth + source, 60.0 - depth - source]
        np.testing.assert_allclose(np.sort(a.delay)[:3], np.sort(np.hypot(images, aside)) / c, rtol=2e-4)


@pytest.mark.parametrize("x", [100.0, 180.0])
def test_the_ground_goes_on_behind_the_edge_of_the_world(x: float) -> None:
    """A receiver at the edge or behind it hears what it would in a larger world; casts are in single precision."""

    def arrivals(size: float) -> Any:
        world = {"type": "flat", "depth_m": 60.0, "size_m": [size, size]}
        vehicle = {"vehicle": "remus100", "start": {"position_m": [-30.0, 5.0], "depth_m": 10.0}}
        sim = pl.Simulation.load({"world": world, "agents": {"a": vehicle}})
        return pl.channel(sim, "a", (x, 7.0, -25.0), frequency_hz=20_000.0).arrivals()

    small, large = arrivals(200.0), arrivals(2000.0)
    assert len(small) > 10
    np.testing.assert_allclose(small.delay, large.delay, atol=1e-7)
    np.testing.assert_array_equal(small.bottom, large.bottom)
    np.testing.assert_allclose(small.loss_db, large.loss_db, atol=0.01)


def test_a_hull_between_two_places_blocks_them() -> None:
    """A wall 13 m deep takes the direct and the surface's path, not those by the bottom; it goes, and they are back."""
    sim = pl.Simulation.load(scenario())
    ends = (0.0, 40.0, -6.0), (120.0, 40.0, -7.0)
    before = pl.channel(sim, *ends)
    assert not before.arrivals().blocked.any()
    wall = sim.spawn(pl.Prop("box", position=(60.0, 40.0, -6.0), size=(2.0, 20.0, 14.0), material="steel"))
    between = pl.channel(sim, *ends)
    assert between.arrivals().blocked[0]
    a = between.arrivals()
    assert a.blocked[(a.bottom == 0)].all()
    assert not a.blocked[(a.surface == 0) & (a.bottom == 1)].any()
    assert between.transmission_loss() > before.transmission_loss() + 2.0
    wall.move(position=(60.0, 400.0, -6.0))
    assert not pl.channel(sim, *ends).arrivals().blocked.any()


def test_hulls_of_the_ends_are_neither_ground_nor_in_the_way(sim: pl.Simulation) -> None:
    """Between two vehicles: nothing is blocked, the bottom is flat, and both ways have the same paths.

    Level of the direct path: spherical spreading and 4.2 dB/km; image method for times, in almost uniform water.
    """
    there, back = pl.channel(sim, "a", "b"), pl.channel(sim, "b", "a")
    np.testing.assert_allclose(there.section.bottom_depth, 30.0, atol=1e-3)
    a, b = there.arrivals(), back.arrivals()
    assert not a.blocked.any()
    first = slice(0, 8)
    np.testing.assert_allclose(a.delay[first], b.delay[first], rtol=1e-9)
    np.testing.assert_allclose(a.loss_db[first], b.loss_db[first], atol=1e-6)
    way = there.receiver - there.source
    length = float(np.linalg.norm(way))
    assert a.loss_db[0] == pytest.approx(20 * np.log10(length) + 4.2e-3 * length, abs=0.2)
    images = [np.hypot(np.linalg.norm(way[:2]), z) for z in (8.0, 28.0, 32.0, 52.0, 68.0, 88.0, 92.0, 112.0)]
    np.testing.assert_allclose(a.length[first], images, rtol=1e-3)


def test_tone_is_shifted_by_doppler() -> None:
    """10 m/s closing at 50 kHz in 1538.92 m/s: 50 324.90 Hz (validation of arlpy)."""
    c, f, v, rate = 1538.92, 50_000.0, 10.0, 20_000.0
    count = 40_000
    tone = np.ones(count, complex)
    ratio = np.array([1.0 + v / c])
    got = received(
        tone, np.array([0.01]), np.ones(1, complex), ratio, carrier=f, sample_rate=rate, start=0.1, count=30_000
    )
    turn = np.unwrap(np.angle(got))
    measured = f + (turn[-1] - turn[0]) / (2 * np.pi) * rate / (len(turn) - 1)
    assert measured == pytest.approx(50_324.90, abs=0.01)


def test_impulse_response_is_the_transfer_function() -> None:
    """Fourier transform of the taps against the sum over paths, within the band."""
    rng = np.random.default_rng(2)
    delay, amplitude = np.sort(rng.uniform(0.1, 0.11, 5)), rng.normal(size=5) + 1j * rng.normal(size=5)
    rate, carrier = 20_000.0, 25_000.0
    start, taps = impulse_response(delay, amplitude, carrier=carrier, sample_rate=rate)
    for offset in (-7000.0, 0.0, 3123.0, 8000.0):
        t = start + np.arange(len(taps)) / rate
        seen = np.sum(taps * np.exp(-2j * np.pi * offset * t))
        exact = np.sum(amplitude * np.exp(-2j * np.pi * (carrier + offset) * delay))
        assert abs(seen - exact) < 2e-3 * np.abs(amplitude).sum()


def test_waveform_through_the_channel_equals_its_convolution(sim: pl.Simulation) -> None:
    """Without motion: sent samples times taps."""
    made = pl.channel(sim, (10.0, 5.0, -8.0), (90.0, -40.0, -21.0), frequency_hz=20_000.0, bounces=3)
    rng = np.random.default_rng(4)
    smooth = np.convolve(rng.normal(size=400) + 1j * rng.normal(size=400), np.hanning(9), "same")
    start, got = made.transmit(smooth, 16_000.0)
    first, taps = made.impulse_response(16_000.0)
    whole = np.convolve(smooth, taps)
    t_got, t_whole = start + np.arange(len(got)) / 16_000.0, first + np.arange(len(whole)) / 16_000.0
    from pelagos.acoustics.channel import interpolated

    again = interpolated(whole, (t_got - t_whole[0]) * 16_000.0)
    assert np.abs(again - got).max() < 5e-3 * np.abs(got).max()


@pytest.mark.parametrize(
    ("khz", "wind", "level"),
    [(0.1, 0, 67.22), (0.1, 5, 67.79), (1, 5, 60.95), (1, 10, 67.88), (10, 5, 46.09), (30, 10, 43.95), (100, 0, 25.13)],
)
def test_wenz_levels(khz: float, wind: float, level: float) -> None:
    assert spectral_level(khz * 1e3, wind_speed=wind, shipping=0.5)[0] == pytest.approx(level, abs=0.01)


def test_ambient_noise_has_its_spectrum() -> None:
    """Mean periodogram of 200 rows in three bands against Wenz: 0.3 dB, four standard errors of 1e4 values."""
    rng = np.random.Generator(np.random.PCG64(1))
    rate, count = 96_000.0, 4096
    x = ambient_noise(count, rate, wind_speed=6.0, shipping=0.5, rng=rng, elements=200)
    density = (np.abs(np.fft.rfft(x, axis=1)) ** 2).mean(axis=0) * 2 / (rate * count)
    f = np.fft.rfftfreq(count, 1 / rate)
    for low, high in ((2e3, 4e3), (10e3, 14e3), (30e3, 40e3)):
        band = (f >= low) & (f < high)
        expected = 10 ** (spectral_level(f[band], wind_speed=6.0, shipping=0.5) / 10)
        assert 10 * np.log10(density[band].mean() / expected.mean()) == pytest.approx(0.0, abs=0.3)


def test_wrong_ends_are_refused(sim: pl.Simulation) -> None:
    with pytest.raises(pl.LookupFailed, match="known: a, b"):
        pl.channel(sim, "c", "b")
    with pytest.raises(pl.CommandError, match="above the water"):
        pl.channel(sim, (0, 0, 3.0), "b")
    with pytest.raises(pl.CommandError, match=r"\(20, 0, -31.5\) is 1.5 m below the ground"):
        pl.channel(sim, "a", (20, 0, -31.5))
    with pytest.raises(pl.CommandError, match="two places"):
        pl.channel(sim, "a", "a")
    with pytest.raises(pl.CommandError, match="positive number"):
        pl.channel(sim, "a", "b", frequency_hz=float("nan"))
    with pytest.raises(pl.CommandError, match="three finite numbers"):
        pl.channel(sim, (0.0, 1.0), "b")
    with pytest.raises(pl.CommandError, match="a world has none"):
        pl.channel(sim.world, "a", "b")


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"copy": 2}, "copy is a whole number from 0 to 1, not 2"),
        ({"copy": -1}, "copy is a whole number from 0 to 1, not -1"),
        ({"copy": 0.5}, r"copy is a whole number from 0 to 1, not 0\.5"),
        ({"copy": True}, "copy is a whole number from 0 to 1, not True"),
        ({"shipping": 1.2}, r"shipping is a number from 0 \(none\) to 1 \(heavy\), not 1\.2"),
        ({"shipping": -0.1}, r"shipping .* not -0\.1"),
        ({"shipping": float("nan")}, "shipping .* not nan"),
        ({"shipping": "heavy"}, "shipping .* not 'heavy'"),
        ({"bounces": -1}, "bounces is a whole number, 0 or more, not -1"),
        ({"bounces": 2.5}, r"bounces is a whole number, 0 or more, not 2\.5"),
        ({"frequency_hz": "25 kHz"}, "frequency_hz is a positive number, not '25 kHz'"),
    ],
)
def test_keys_of_a_channel_have_their_range(pair: pl.Simulation, keys: dict[str, Any], message: str) -> None:
    with pytest.raises(pl.CommandError, match=message):
        pl.channel(pair, "a", "b", **keys)


def test_a_channel_takes_numpys_numbers_and_a_world_has_one_copy(pair: pl.Simulation) -> None:
    """Of Wenz's sources shipping alone changes: 40 + 20 (s - 0.5) + 26 log f - 60 log(f + 0.03) dB, f in kHz."""
    quiet, loud = (
        pl.channel(pair, "a", "b", copy=np.int64(1), shipping=s, bounces=np.int32(1))
        for s in (np.float32(0.0), np.float64(1.0))
    )
    none, heavy = (40 + 20 * (s - 0.5) + 26 * np.log10(0.05) - 60 * np.log10(0.08) for s in (0.0, 1.0))
    more = 10 ** (loud.noise_level_db(50.0) / 10) - 10 ** (quiet.noise_level_db(50.0) / 10)
    assert more == pytest.approx(10 ** (heavy / 10) - 10 ** (none / 10), rel=1e-3)
    assert max(loud.arrivals().surface + loud.arrivals().bottom) == 1
    with pytest.raises(pl.CommandError, match="copy is 0, as there is but one, not 1"):
        pl.channel(pair.world, (0, 0, -3), (9, 0, -3), copy=1)


def test_command_prints_and_draws(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(json.dumps(scenario()))
    picture = tmp_path / "channel.png"
    got = CliRunner().invoke(app, ["channel", str(file), "a", "60,20,-5", "--out", str(picture)])
    assert got.exit_code == 0, got.output
    assert "all together" in got.output
    assert {"[ms]", "[dB]", "[deg]"} <= set(got.output.replace("│", " ").replace("┃", " ").split())
    assert picture.read_bytes()[:4] == b"\x89PNG"
    got = CliRunner().invoke(app, ["channel", str(file), "a", "b", "--json"])
    assert got.exit_code == 0
    assert json.loads(got.output)["arrivals"][0]["surface"] == 0


def test_ends_that_move_a_little_change_delays_as_a_new_trace_does() -> None:
    """To first order by t/c at each end; what is left is of second order, some |d|^2/(L c) = 0.04 us for 7 cm on 90 m,
    and more where a layer bends the ray.

    In water of 1421 m/s at one end and 1483 m/s at the other, one's speed in the other's place is wrong by 2 us.
    """
    water = {"temperature_c": {"depth_m": [0, 8, 22, 30], "value": [4.0, 4.0, 20.0, 20.0]}}
    model = pl.Simulation.load(scenario(ocean=water)).model
    trace = WaterPaths(model.scene, model.world, model.ocean, frequency=25e3, rays=256, bounces=1)
    ends = np.array([[[10.0, 5.0, -7.0], [80.0, -45.0, -23.0]]])
    shift = 0.1 * np.array([[[0.4, -0.3, 0.5], [-0.6, -0.2, 0.3]]])
    before, after = (trace.trace(e[:, 0], e[:, 1], 0.0, np.zeros(1, np.int64)) for e in (ends, ends + shift))
    guessed = shift_arrivals(before, ends, ends + shift).delay
    assert len(guessed) == len(after.arrivals) > 2
    changes = after.arrivals.delay - before.arrivals.delay
    assert np.abs(changes).min() > 30e-6
    np.testing.assert_allclose(guessed - before.arrivals.delay, changes, atol=1e-7)
