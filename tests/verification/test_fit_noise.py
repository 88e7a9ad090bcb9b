"""Noise that is known, found again in records of it; and records that do not tell."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from scipy.stats import chi2
from typer.testing import CliRunner

import pelagos as pl
from pelagos.cli.main import app
from pelagos.errors import InputError, LookupFailed, PelagosWarning
from pelagos.identification.noise import SensorNoise, Term, allan_deviation, even_rate, fit_beams, fit_noise, keys_of
from pelagos.identification.noise_keys import keys_at_rest, reading_of


def test_the_measure_itself_on_the_nbs_set():
    """W. J. Riley, NIST Special Publication 1065 (2008), page 108."""
    x, values = 1234567890, []
    for _ in range(1000):
        values.append(x / 2147483647)
        x = 16807 * x % 2147483647
    assert allan_deviation(np.array(values), 10) == pytest.approx(9.159953e-2, rel=1e-6)


def test_white_noise_and_random_walk_are_told_apart():
    """N = 0.02 and K = 0.004 at 20 Hz cross at tau = sqrt(3) N/K = 8.7 s; 4 000 s leave K some 10 %, N 1 %."""
    random = np.random.default_rng(4)
    n, white, walk, rate = 80_000, 0.02, 0.004, 20.0
    values = 5 + white * np.sqrt(rate) * random.normal(size=n) + walk / np.sqrt(rate) * np.cumsum(random.normal(size=n))
    found = fit_noise(values, rate)
    assert found.white.visible
    assert found.white.value == pytest.approx(white, rel=0.04)
    assert found.random_walk.visible
    assert found.random_walk.value == pytest.approx(walk, rel=0.3)


def test_a_short_record_shows_no_walk():
    found = fit_noise(np.random.default_rng(2).normal(size=2000), 50.0)
    assert found.white.value == pytest.approx(1 / np.sqrt(50), rel=0.08)
    assert not found.random_walk.visible
    assert keys_of({"x": found}, "gyroscope_")["gyroscope_random_walk"] == 0.0


def test_a_simulated_imu_is_found_again():
    """White noise of a gyroscope at rest, 50 Hz, three axes of 40 s: N to 2 %, the step of the output exactly."""
    imu = {
        "type": "imu", "rate_hz": 50, "gyroscope_noise_density": 0.003, "gyroscope_resolution": 0.0,
        "gyroscope_bias_instability": 0.0, "accelerometer_noise_density": 0.05, "accelerometer_resolution": 0.05,
    }  # fmt: skip
    agent = {"vehicle": "bluerov2", "control": "acceleration", "start": {"position_m": [0, 0], "depth_m": 5}}
    sim = pl.Simulation.load(
        {"tick_rate_hz": 50, "world": {"type": "flat"}, "agents": {"it": {**agent, "sensors": {"imu": imu}}}}
    )
    readings = np.array([sim.step({"it": np.zeros(6)})["it"]["imu"].data[0] for _ in range(2000)])
    gyroscope = {k: fit_noise(readings[:, k], 50.0) for k in range(6) if readings[:, k].std() < 0.1}
    keys = keys_of({str(k): n for k, n in gyroscope.items()}, "gyroscope_")
    assert len(gyroscope) == 3
    assert keys["gyroscope_noise_density"] == pytest.approx(0.003, rel=0.06)


def test_beams_of_a_log_that_moves():
    """Four beams at 30 deg, azimuths 45 to -45: noise 4 mm/s and 1 % of the speed, from 5 000 pings to 5 %."""
    random = np.random.default_rng(8)
    azimuth = np.radians([45, 135, -135, -45])
    axes = np.stack([np.sin(0.52) * np.cos(azimuth), np.sin(0.52) * np.sin(azimuth), -np.cos(0.52) * np.ones(4)], -1)
    velocity = np.cumsum(random.normal(size=(5000, 3)) * [0.05, 0.03, 0.01], axis=0) % 3.0
    velocity[::2] *= 0.02  # nearly at rest
    beams = velocity @ axes.T
    beams += np.sqrt(0.004**2 + (0.01 * beams) ** 2) * random.normal(size=beams.shape)
    beams[random.random(5000) < 0.1, 2] = np.nan
    found = fit_beams(list(beams.T))
    assert found.noise_mps == pytest.approx(0.004, rel=0.08)
    assert found.noise_relative == pytest.approx(0.01, rel=0.08)
    assert found.lost == pytest.approx((0, 0, 0.1, 0), abs=0.015)
    with pytest.raises(InputError, match="not in order around"):
        fit_beams([beams[:, k] for k in (0, 2, 1, 3)])


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda t: t[::-1], "not in order: row 2"),
        (lambda t: np.where(np.arange(len(t)) == 7, t[6], t), "occur twice: row 8"),
        (lambda t: np.delete(t, slice(40, 60)), r"steps are 0.1 s, but 2.1 s at 3.9 s \(1 such\)"),
        (lambda t: np.where(np.arange(len(t)) == 7, np.nan, t), "are not numbers: row 8"),
    ],
)
def test_times_that_cannot_be_used_are_named(change, match):
    with pytest.raises(InputError, match=match):
        even_rate(change(0.1 * np.arange(300)))


@pytest.mark.parametrize(
    ("values", "match"),
    [
        (np.ones(500), "all samples are the same"),
        (np.arange(50.0), "50 samples are too few"),
        (np.where(np.arange(500) == 3, np.inf, np.arange(500.0)), r"no numbers: 4 \(1 such\)"),
    ],
)
def test_samples_that_do_not_tell(values, match):
    with pytest.raises(InputError, match=match):
        fit_noise(values, 10.0)


def test_the_command_prints_keys_that_the_imu_knows(tmp_path):
    random = np.random.default_rng(1)
    rows = np.column_stack([0.02 * np.arange(3000), random.normal(size=(3000, 2)) * [0.01, 0.03]])
    file = tmp_path / "imu.csv"
    file.write_text("t,gx,gy\n" + "\n".join(",".join(f"{x:.6f}" for x in row) for row in rows), encoding="utf-8")
    done = CliRunner().invoke(app, ["fit-noise", str(file), "--columns", "gx,gy", "--prefix", "gyroscope_", "--json"])
    assert done.exit_code == 0, done.output
    keys = json.loads(done.output)["keys"]
    assert keys["gyroscope_noise_density"] == pytest.approx(np.sqrt((0.01**2 + 0.03**2) / 2 / 50), rel=0.05)
    from pelagos.sensors.navigation.imu import ImuConfig

    ImuConfig(**keys)
    assert CliRunner().invoke(app, ["fit-noise", str(file)]).exit_code != 0
    wrong = CliRunner().invoke(app, ["fit-noise", str(file), "--columns", "gz"])
    assert wrong.exit_code != 0


@pytest.mark.parametrize("kind", ["white", "walk"])
def test_what_is_not_seen_is_bounded_by_the_curve(kind, tmp_path):
    """A term alone lies nowhere above the measured curve, as far as that is known: N/sqrt(tau), sqrt(2 ln 2/pi) B and
    K sqrt((tau + step^2/(2 tau))/3) (IEEE Std 952-1997, Annex C), where the variance of nu + 1 clusters times
    nu/chi^2(nu) is passed by one in a hundred; two digits are printed, half of the last is at most 5 %."""
    noise = 0.3 * np.random.default_rng(6).normal(size=4000)
    x = noise if kind == "white" else np.cumsum(noise)
    file = tmp_path / "imu.csv"
    file.write_text("t,gx\n" + "\n".join(f"{k / 50:.2f},{v:.9f}" for k, v in enumerate(x)), encoding="utf-8")
    told = CliRunner().invoke(app, ["fit-noise", str(file), "--columns", "gx"], terminal_width=200).output
    found = fit_noise(np.array([float(f"{v:.9f}") for v in x]), 50.0)
    nu = 4000 / (found.tau * 50) - 1
    curve = found.allan * np.sqrt(nu / chi2.ppf(0.01, nu))
    bounds = {
        "white": (curve * np.sqrt(found.tau)).min(),
        "bias": curve.min() / np.sqrt(2 * np.log(2) / np.pi),
        "walk": (curve * np.sqrt(3 / (found.tau + 0.5 / 50**2 / found.tau))).min(),
    }
    bounds.pop(kind)
    printed = [float(v) for v in re.findall(r"not seen, < (\S+)", told)]
    assert printed == pytest.approx(list(bounds.values()), rel=0.051)
    data = json.loads(CliRunner().invoke(app, ["fit-noise", str(file), "--columns", "gx", "--json"]).output)
    assert list(data["most"]["gx"].values()) == pytest.approx(list(bounds.values()), rel=1e-9)
    assert [v is None for v in data["axes"]["gx"].values()] == [kind != "white", True, kind != "walk"]


def flicker(n: int, rate: float, bias: float, random: np.random.Generator) -> np.ndarray:
    """Noise with the density B^2/(2 pi f) on either side of 0 (IEEE Std 952-1997, Annex C.1.4)."""
    f = np.fft.rfftfreq(n, 1 / rate)
    density = np.zeros_like(f)
    density[1:] = bias**2 / (2 * np.pi * f[1:])
    waves = (random.normal(size=len(f)) + 1j * random.normal(size=len(f))) / np.sqrt(2)
    return np.fft.irfft(waves * np.sqrt(density * n * rate), n)


@pytest.mark.parametrize(("bias", "walk"), [(2e-3, 0.0), (0.0, 3e-4)])
def test_bounds_hold_what_is_there_and_hides(bias, walk):
    """100 records of 2 000 s in which white noise hides a term in some: a bound of 99 % fails in 4 of them or fewer
    with the probability 0.997."""
    n, rate, low = 20_000, 10.0, 0
    for seed in range(100):
        random = np.random.default_rng(seed)
        x = 0.01 * np.sqrt(rate) * random.normal(size=n) + walk / np.sqrt(rate) * np.cumsum(random.normal(size=n))
        x += flicker(2 * n, rate, bias, random)[:n] if bias else 0.0
        found = fit_noise(x, rate)
        term = found.bias_instability if bias else found.random_walk
        low += term.most < bias + walk
        assert term.value < term.most
    assert low <= 4


@pytest.mark.parametrize(
    ("white", "bias", "walk"), [(0.01, 0.0, 0.0), (0.0, 0.02, 0.0), (0.0, 0.0, 0.003), (0.01, 0.02, 0.0)]
)
def test_terms_that_are_there_are_seen_and_no_others(white, bias, walk):
    """100 000 samples at 100 Hz, three records: N to 1 %, B to 5 % and K to 10 %."""
    n, rate = 100_000, 100.0
    for seed in range(3):
        random = np.random.default_rng(seed)
        values = white * np.sqrt(rate) * random.normal(size=n) + flicker(n, rate, bias, random)
        values += walk / np.sqrt(rate) * np.cumsum(random.normal(size=n))
        found = fit_noise(values, rate)
        for term, true, part in (
            (found.white, white, 0.01), (found.bias_instability, bias, 0.05), (found.random_walk, walk, 0.1)
        ):  # fmt: skip
            assert term.visible == (true > 0)
            assert true == 0 or term.value == pytest.approx(true, rel=part)


@pytest.mark.parametrize(("bias", "walk", "part"), [(5e-4, 0.0, 0.03), (0.0, 3e-4, 0.04)])
def test_slow_terms_are_right_in_the_mean(bias, walk, part):
    """40 records of 1 000 s at 25 Hz, in which B and K scatter by 6.5 and 8.5 %: three standard deviations of their
    means are 3 and 4 %."""
    n, rate, sizes = 25_000, 25.0, []
    for seed in range(40):
        random = np.random.default_rng(seed)
        values = 1e-3 * np.sqrt(rate) * random.normal(size=n) + walk / np.sqrt(rate) * np.cumsum(random.normal(size=n))
        values += flicker(2 * n, rate, bias, random)[:n] if bias else 0.0
        found = fit_noise(values, rate)
        shown, other = (found.bias_instability, found.random_walk)[:: 1 if bias else -1]
        assert (shown.visible, other.value) == (True, 0.0)
        sizes.append(shown.value / (bias + walk))
    assert np.mean(sizes) == pytest.approx(1.0, abs=part)


def test_white_noise_alone_shows_nothing_else():
    """60 records of 20 000 samples, in 11 of which another term makes a quarter of the variance somewhere."""
    for seed in range(60):
        found = fit_noise(np.random.default_rng(seed).normal(size=20_000), 100.0)
        assert found.white.visible
        assert not found.bias_instability.visible
        assert not found.random_walk.visible


def test_the_deviation_is_that_of_its_definition():
    """Half the mean square of the difference of neighbouring means of m samples."""
    values = np.cumsum(np.random.default_rng(3).normal(size=700)) + 4.0
    for m in (1, 7, 60):
        means = np.convolve(values, np.ones(m) / m, "valid")
        expected = np.sqrt(0.5 * np.mean((means[m:] - means[:-m]) ** 2))
        assert allan_deviation(values, m) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda x, t: x + np.where(t == 9.0, 1e3, 0.0), "gx: 2 changes .* after sample 900 .8.99 s."),
        (lambda x, t: 0.01 * x + np.sin(t), "at rest, and warm"),
        (lambda x, t: 0.01 * x + t, "drifts by 1 a second"),
    ],
)
def test_records_of_a_sensor_that_moved_are_warned_of(change, said):
    t = np.arange(4000) / 100
    x = np.random.default_rng(5).normal(size=4000)
    fit_noise(x, 100.0)
    with pytest.warns(PelagosWarning, match=said):
        fit_noise(change(x, t), 100.0, label="gx: ")


@pytest.mark.parametrize("drift", [-1e-4, 6e-5])
def test_a_straight_drift_is_told_from_a_random_walk(drift):
    """Random walk of 2e-5 and N = 3e-4 in 300 s at 20 Hz; a drift of 6e-5 a second is 0.018, the walk 3.5e-4."""
    random, rate = np.random.default_rng(8), 20.0
    white, walk = 3e-4 * np.sqrt(rate) * random.normal(size=6000), 2e-5 / np.sqrt(rate) * random.normal(size=6000)
    noise = white + np.cumsum(walk)
    assert fit_noise(noise, rate).white.value == pytest.approx(3e-4, rel=0.05)
    with pytest.warns(PelagosWarning, match=r"^gyro_z: the mean drifts by .* a second, straight as no noise") as told:
        fit_noise(noise + drift * np.arange(6000) / rate, rate, label="gyro_z: ")
    assert float(str(told[0].message).split()[5]) == pytest.approx(drift, rel=0.05)


def test_beams_that_are_lost_or_in_another_unit_are_told():
    random = np.random.default_rng(8)
    azimuth = np.radians([45, 135, -135, -45])
    axes = np.stack([0.5 * np.cos(azimuth), 0.5 * np.sin(azimuth), -0.87 * np.ones(4)], -1)
    beams = np.cumsum(random.normal(size=(2000, 3)) * 0.02, axis=0) @ axes.T + 0.004 * random.normal(size=(2000, 4))
    beams = beams[np.abs(beams[:, 1]) > 0.1]
    assert fit_beams(list(beams.T)).noise_mps == pytest.approx(0.004, rel=0.1)
    beams[::90, 2] = 0.0
    beams[::90, 3] = beams[::90, 0] - beams[::90, 1]  # a beam may well be still
    assert fit_beams(list(beams.T)).noise_mps > 0
    zeros = beams.copy()
    zeros[::50, 1] = 0.0
    with pytest.raises(InputError, match=r"beam 2 reads exactly 0 in .* the first in row 1 "):
        fit_beams(list(zeros.T))
    with pytest.raises(InputError, match="more than any vehicle has; in mm/s"):
        fit_beams(list(1e3 * beams.T))
    with pytest.raises(InputError, match="never changes: there is no noise"):
        fit_beams([np.ones(300)] * 4)
    with pytest.warns(PelagosWarning, match=r"samples are 1e.07 s apart: if the time is in ms, us or ns"):
        assert even_rate(1e7 * np.arange(300)) == pytest.approx(1e-7)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--columns", ","], "names no column"),
        (["--columns", "t"], "t is the time"),
        (["--columns", "gx", "--prefix", "gyro scope"], "unknown prefix 'gyro scope' (did you mean 'gyroscope_'?)"),
        (["--beams", "a,b,c,d", "--prefix", "x_"], "belong to --columns"),
        (["--beams", "a,b,c,d", "--time", "t"], "belong to --columns"),
    ],
)
def test_options_that_cannot_be_are_told(options, said, tmp_path):
    file = tmp_path / "imu.csv"
    noise = np.random.default_rng(2).normal(size=300)
    file.write_text("t,gx\n" + "\n".join(f"{10 * k},{x:.4f}" for k, x in enumerate(noise)), encoding="utf-8")
    done = CliRunner().invoke(app, ["fit-noise", str(file), *options])
    assert isinstance(done.exception, InputError)
    assert said in str(done.exception)
    good = CliRunner().invoke(app, ["fit-noise", str(file), "--columns", "gx", "--time-unit", "ms"])
    assert "300 samples, 100 a second: 3 s" in good.output


AXES = np.stack([0.5 * np.cos(np.radians([45, 135, 225, 315])), 0.5 * np.sin(np.radians([45, 135, 225, 315])),
                 -0.87 * np.ones(4)], -1)  # fmt: skip


def pings(n: int, noise: float, relative: float, speed: float, seed: int) -> np.ndarray:
    """Beams of a log that goes to and fro on all axes."""
    random, t = np.random.default_rng(seed), np.arange(n)
    velocity = speed * np.stack([np.sin(t / 37), 0.6 * np.cos(t / 23), 0.05 * np.sin(t / 11)], -1)
    beams = velocity @ AXES.T
    return beams + np.sqrt(noise**2 + (relative * beams) ** 2) * random.normal(size=beams.shape)


@pytest.mark.parametrize("speed", [0.0, 0.004, 0.02, 0.2])
def test_a_log_at_rest_or_slow_shows_its_noise_at_rest_and_no_other(speed):
    """4 mm/s from 2 000 pings, whose variance is known to sqrt(2/2000) = 3 %, and 1 % of a speed, which it hides."""
    found = fit_beams(list(pings(2000, 0.004, 0.01, speed, 3).T))
    assert found.noise_mps == pytest.approx(0.004, rel=0.05)
    assert found.noise_relative == 0.0
    assert found.most_relative > 0.01
    assert found.most_mps > 0.004
    assert found.speed_mps == pytest.approx(np.sqrt(0.004**2 + speed**2 * 1.36 / 16), rel=0.1)


@pytest.mark.parametrize(("noise", "relative"), [(0.003, 0.0), (0.0, 0.012), (0.003, 0.012)])
def test_a_log_under_way_shows_what_is_there(noise, relative):
    """5 000 pings at up to 2 m/s; bounds at 3 standard deviations."""
    found = fit_beams(list(pings(5000, noise, relative, 2.0, 11).T))
    assert found.noise_mps == pytest.approx(noise, rel=0.1)
    assert found.noise_relative == pytest.approx(relative, rel=0.1)
    assert noise <= found.most_mps < noise + 0.002
    assert relative <= found.most_relative < relative + 0.006


def test_a_steady_speed_does_not_part_the_noises():
    """All noise of one speed is taken for that at rest: sqrt(0.003^2 + (0.02 x 0.5)^2) along every beam."""
    random = np.random.default_rng(5)
    beams = 0.5 * np.array([1, 1, 1, 1.0]) + np.hypot(0.003, 0.02 * 0.5) * random.normal(size=(3000, 4))
    found = fit_beams(list(beams.T))
    assert (found.noise_mps, found.noise_relative) == (pytest.approx(np.hypot(0.003, 0.01), rel=0.05), 0.0)
    assert found.most_relative > 0.02


@pytest.mark.parametrize("flag", [-32.768, 32.767, 9.999, -99.99, 12.5])
@pytest.mark.parametrize("speed", [0.0, 1.5])
def test_numbers_that_say_that_a_beam_is_lost_are_named_and_left_out(flag, speed):
    beams = pings(3000, 0.004, 0.01, speed, 2)
    without = fit_beams(list(beams.T))
    lost = np.random.default_rng(1).random(beams.shape) < [0.1, 0.0, 0.03, 0.0]
    lost[40:60] = True
    flagged = np.where(lost, flag, beams)
    said = f"{flag:g} is taken for the mark of a lost beam: beam 1 in {lost[:, 0].sum()} pings, beam 2 in 20 pings, "
    with pytest.warns(PelagosWarning, match="^" + re.escape(said)):
        found = fit_beams(list(flagged.T))
    assert found.lost == pytest.approx(lost.mean(axis=0))
    assert found.noise_mps == pytest.approx(without.noise_mps, rel=0.05)
    empty = fit_beams(list(np.where(lost, np.nan, beams).T))
    assert (found.noise_mps, found.noise_relative) == (empty.noise_mps, empty.noise_relative)


def test_two_flags_are_both_left_out_and_fast_beams_are_none():
    beams = np.round(pings(3000, 0.004, 0.01, 1.5, 2), 3)  # written to 1 mm/s, so that the largest may occur twice
    beams[7, 1] = 9.999  # known, once is enough
    beams[[9, 80, 81], 2] = -50.0
    with pytest.warns(PelagosWarning) as told:
        found = fit_beams(list(beams.T))
    assert [str(w.message).split(" is")[0] for w in told] == ["-50", "9.999"]
    assert found.pings == 2996
    beams = beams[100:]
    beams[1000:1002, 0] = 1.1 * beams.max()  # twice the same, and no mark
    with pytest.warns(PelagosWarning, match=r"2 pings stand out, the first in row 1001: left out"):
        found = fit_beams(list(beams.T))
    assert (found.pings, max(found.lost)) == (2898, 0.0)


def test_pings_that_stand_out_are_left_out():
    """3 of 4 000 pings with 3 m/s more in a beam, and one in a hundred by 2 m/s: what is found is that without them."""
    beams = pings(4000, 0.003, 0.004, 2.0, 5)
    without = fit_beams(list(beams.T))
    few = beams.copy()
    few[1000:1003, 1] += 3.0
    many = beams.copy()
    many[::100, 2] += np.random.default_rng(3).choice([-2.0, 2.0], 40)
    for faulty, said in ((few, "3 pings stand out, the first in row 1001"), (many, "40 pings stand out")):
        with pytest.warns(PelagosWarning, match=said):
            found = fit_beams(list(faulty.T))
        assert found.noise_mps == pytest.approx(without.noise_mps, rel=0.02)
        assert found.noise_relative == pytest.approx(without.noise_relative, rel=0.05)


def test_noise_that_grows_with_the_speed_does_not_stand_out():
    """A burst at 8 m/s in one of 50 pings has 26 times the noise of the others, which rest."""
    random = np.random.default_rng(4)
    velocity = np.where(np.arange(5000) % 50 == 0, 8.0, 0.0)[:, None] * [1.0, 0.2, 0.0]
    beams = velocity @ AXES.T
    beams += np.hypot(0.001, 0.01 * beams) * random.normal(size=beams.shape)
    found = fit_beams(list(beams.T))
    assert (found.pings, found.noise_relative) == (5000, pytest.approx(0.01, rel=0.15))


@pytest.mark.parametrize("speed", [0.0, 1.5])
@pytest.mark.parametrize("reading", [0.0, 0.31])
def test_a_beam_that_never_changes_is_refused(speed, reading):
    beams = pings(3000, 0.004, 0.01, speed, 2)
    beams[:, 2] = reading
    beams[5, 2] = np.nan
    with pytest.raises(InputError, match=f"beam 3 reads {reading:g} in every ping"):
        fit_beams(list(beams.T))


@pytest.mark.parametrize("factor", [-1.0, 0.1, 1.5])
@pytest.mark.parametrize("beam", [0, 3])
def test_a_beam_of_another_sign_or_scale_is_refused(beam, factor):
    beams = pings(3000, 0.004, 0.01, 1.5, 2)
    beams[:, beam] *= factor
    with pytest.raises(InputError, match=rf"beam {beam + 1} reads \S+ times what the other three say") as told:
        fit_beams(list(beams.T))
    assert float(str(told.value).split()[3]) == pytest.approx(factor, rel=0.03)


def test_a_beam_that_is_a_little_off_is_warned_of():
    """5 % of a beam of 0.4 m/s rms is 20 mm/s, beside noise of 6 mm/s in the sum."""
    beams = pings(3000, 0.003, 0.0, 1.5, 2)
    fit_beams(list(beams.T))
    beams[:, 1] *= 0.95
    with pytest.warns(PelagosWarning, match=r"beam 2 reads 0\.9[45]\d? times .*: angles or scales"):
        fit_beams(list(beams.T))


def test_a_log_that_goes_straight_does_not_say_which_beam_it_is():
    beams = np.full((2000, 4), 0.4) + 0.004 * np.random.default_rng(2).normal(size=(2000, 4))
    beams[:, 1] *= -1
    with pytest.raises(InputError, match=r"goes with the velocity, with .* another sign, unit or order"):
        fit_beams(list(beams.T))


def test_zeros_of_lost_beams_at_rest_are_refused_and_those_of_rounding_are_not():
    """Noise of 3 mm/s: one reading in 8 is exactly 0 where it is written to 1 mm/s, and 9 in 10 where to 1 cm/s."""
    beams = pings(4000, 0.003, 0.0, 0.0, 9)
    for step in (0.001, 0.01):
        fit_beams(list((np.round(beams / step) * step).T))
    beams[np.random.default_rng(1).random(4000) < 0.05, 1] = 0.0
    with pytest.raises(InputError, match=r"beam 2 reads exactly 0 in \d+ pings, and every other number in 1 at most"):
        fit_beams(list(beams.T))


def test_an_offset_that_comes_and_goes_and_noise_in_another_unit_are_told():
    beams = pings(4000, 0.003, 0.0, 0.0, 9)
    with pytest.warns(PelagosWarning, match=r"noise of 3\.\d+ m/s a ping is more than any log has; in mm/s"):
        fit_beams(list(1e3 * beams.T))
    beams[2000:, 0] += 0.05
    with pytest.warns(PelagosWarning, match=r"only 0\.0\d+ of the variance of b1 - b2 \+ b3 - b4 is new in every ping"):
        fit_beams(list(beams.T))


def test_noise_of_a_log_at_rest_that_changes_is_no_part_of_its_speed():
    """Ten times the noise in a tenth of the pings: squares of the three other sums go with it, and are no speed."""
    random = np.random.default_rng(6)
    beams = 0.002 * np.where(random.random(4000) < 0.1, 5.0, 1.0)[:, None] * random.normal(size=(4000, 4))
    assert fit_beams(list(beams.T)).noise_relative == 0.0


@pytest.mark.parametrize("step", [0.02, 0.04])
def test_rounding_is_not_counted_as_white_noise(step):
    """A simulated sensor adds it by itself: noise of 0.02, one step or half of one, in 200 000 samples."""
    x = 0.02 * np.random.default_rng(3).normal(size=200_000) + 0.0123
    found = fit_noise(np.round(x / step) * step, 50.0)
    assert found.resolution == pytest.approx(step)
    assert found.white.value == pytest.approx(0.02 / np.sqrt(50), rel=0.02)
    assert found.white.visible


def test_noise_below_half_a_step_is_called_a_guess():
    x = np.round(0.3 * np.random.default_rng(3).normal(size=20_000) + 0.31)
    with pytest.warns(
        PelagosWarning, match=r"gx: white noise of 0\.\d+ a sample is less than half of the output's step 1,"
    ):
        fit_noise(x, 50.0, label="gx: ")


SCENARIO = """
world: {type: flat, depth_m: 30}
agents:
  auv0:
    vehicle: bluerov2
    start: {position_m: [0, 0], depth_m: 5}
    sensors:
      it:
        type: TYPE
"""


@pytest.fixture(scope="module")
def columns(tmp_path_factory):
    """Records of an IMU in deg/s and g, of a depth in m, and of a velocity log."""
    random = np.random.default_rng(21)
    n = 6000
    gyro = random.normal(size=(n, 3)) * 0.02 + [0.001, -0.002, 0.003]
    force = np.round((random.normal(size=(n, 3)) * 0.004 + [0.1, -0.05, 0.99]) / 0.002) * 0.002
    depth = random.normal(size=(n, 1)) * 0.01 + 3
    rows = np.column_stack([np.arange(n) / 50, gyro, force, depth, pings(n, 0.004, 0.01, 1.5, 6)])
    path = tmp_path_factory.mktemp("noise") / "record.csv"
    np.savetxt(path, rows, "%.9g", ",", header="t,gx,gy,gz,ax,ay,az,d,b1,b2,b3,b4", comments="")
    return path


@pytest.mark.parametrize(
    ("sensor", "options", "expected"),
    [
        ("imu", ["--columns", "gx,gy,gz", "--prefix", "gyroscope_", "--unit", "deg/s"],
         {"gyroscope_noise_density": (np.radians(0.02) / np.sqrt(50), "rad/s/sqrt(Hz)")}),
        ("imu", ["--columns", "ax,ay,az", "--prefix", "accelerometer_", "--unit", "g"],
         {"accelerometer_noise_density": (0.004 * 9.80665 / np.sqrt(50), "m/s^2/sqrt(Hz)"),
          "accelerometer_resolution": (0.002 * 9.80665, "m/s^2")}),
        ("depth", ["--columns", "d", "--sensor", "depth"], {"noise_density": (0.01 / np.sqrt(50), "m/sqrt(Hz)")}),
        ("dvl", ["--beams", "b1,b2,b3,b4"], {"noise_mps": (0.004, "m/s"), "noise_relative": (0.01, "1")}),
    ],
)  # fmt: skip
def test_what_is_printed_goes_into_a_scenario(sensor, options, expected, columns, tmp_path):
    """Every line under a sensor of its type; 6 000 samples know a white noise to 1 %, beams to 2.7 %; three of it."""
    done = CliRunner().invoke(app, ["fit-noise", str(columns), *options])
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    yaml = lines[lines.index(f"# of a sensor with type: {sensor}") :]
    file = tmp_path / "scenario.yaml"
    file.write_text(SCENARIO.replace("TYPE", sensor) + "".join(f"        {line}\n" for line in yaml), encoding="utf-8")
    assert CliRunner().invoke(app, ["check", str(file)]).exit_code == 0
    config = pl.load_scenario(file).agents["auv0"].sensors["it"]
    for key, (value, unit) in expected.items():
        assert getattr(config, key) == pytest.approx(value, rel=0.08), key
        assert any(line.startswith(f"{key}: ") and f"  # [{unit}]" in line for line in yaml), key
    printed = json.loads(CliRunner().invoke(app, ["fit-noise", str(columns), *options, "--json"]).output)
    assert printed["sensor"] == sensor
    assert printed["keys"].keys() == printed["units"].keys() >= expected.keys()
    assert all(getattr(config, k) == pytest.approx(v, rel=1e-3) for k, v in printed["keys"].items())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--columns", "gx", "--prefix", "gyro_"], "unknown prefix 'gyro_' (did you mean 'gyroscope_'?)"),
        (["--columns", "gx", "--prefix", "gyroscope_", "--unit", "deg"], "unknown unit 'deg' (did you mean 'deg/s'?)"),
        (["--columns", "gx", "--unit", "deg/s"], "--unit deg/s: say of what"),
        (["--columns", "gx", "--sensor", "imu"], "several readings: say --prefix accelerometer_ or gyroscope_"),
        (["--columns", "gx", "--sensor", "dvl"], "no key for a noise density"),
        (["--columns", "gx", "--sensor", "dept"], "unknown sensor 'dept' (did you mean 'depth'?)"),
        (["--beams", "b1,b2,b3,b4", "--sensor", "dvl"], "belong to --columns: beams are in m/s"),
    ],
)
def test_keys_that_no_sensor_has_are_refused(options, said, columns):
    done = CliRunner().invoke(app, ["fit-noise", str(columns), *options])
    assert isinstance(done.exception, InputError)
    assert said in str(done.exception)


def test_gravity_in_another_unit_is_warned_of(columns):
    options = ["fit-noise", str(columns), "--columns", "ax,ay,az", "--prefix", "accelerometer_"]
    with pytest.warns(PelagosWarning, match=r"means of three accelerometers make 0\.9963 m/s\^2 .* say --unit g"):
        CliRunner().invoke(app, options)
    CliRunner().invoke(app, [*options, "--unit", "g"], catch_exceptions=False)


@pytest.mark.parametrize(
    ("begin", "said"), [(b"\x89MCAP0\r\n", "is a recording, whose name must end in .mcap"), (b"", "no text in UTF-8")]
)
def test_files_that_are_no_text_are_told(begin, said, tmp_path):
    file = tmp_path / "it.csv"
    file.write_bytes(begin + bytes(range(128, 256)))
    with pytest.raises(InputError, match=said):
        CliRunner().invoke(app, ["fit-noise", str(file), "--columns", "gx"], catch_exceptions=False)


def test_a_recording_is_read_by_topic_and_field(tmp_path):
    """A gyroscope's and a log's own noise, from 8 s of them: white noise of three axes to sqrt(1/600) = 4 %."""
    agent = {
        "vehicle": "bluerov2", "control": "acceleration", "start": {"position_m": [0, 0], "depth_m": 5},
        "sensors": {"imu": {"type": "imu", "rate_hz": 25, "gyroscope_noise_density": 0.003},
                    "dvl": {"type": "dvl", "rate_hz": 50, "noise_mps": 0.02}},
    }  # fmt: skip
    scenario = {"tick_rate_hz": 50, "duration_s": 8.5, "world": {"type": "flat", "depth_m": 14}, "agents": {"a": agent}}
    (tmp_path / "it.yaml").write_text(json.dumps(scenario), encoding="utf-8")
    assert CliRunner().invoke(app, ["run", str(tmp_path / "it.yaml"), "--out", str(tmp_path / "out")]).exit_code == 0
    file = str(tmp_path / "out" / "mission.mcap")
    gyroscope = ",".join(f"/a/imu/data_raw.angular_velocity.{k}" for k in "xyz")
    found = json.loads(
        CliRunner().invoke(app, ["fit-noise", file, "--columns", gyroscope, "--prefix", "gyroscope_", "--json"]).output
    )
    assert found["rate_hz"] == pytest.approx(25)
    assert found["keys"]["gyroscope_noise_density"] == pytest.approx(0.003, rel=0.12)
    beams = ",".join(f"/a/dvl/dvl.beam_velocity.{k}" for k in range(4))
    log = json.loads(CliRunner().invoke(app, ["fit-noise", file, "--beams", beams, "--json"]).output)
    assert log["keys"]["noise_mps"] == pytest.approx(0.02, rel=0.15)
    for wrong, said in (
        ("gx", "a column is a topic and its fields"),
        ("/a/imu/data_raw.angular_velocity.x,/a/truth.twist.twist.angular.x", "of topics with other times"),
    ):
        done = CliRunner().invoke(app, ["fit-noise", file, "--columns", wrong])
        assert said in str(done.exception)


def test_every_unit_of_a_sensor_is_its_definition():
    """A degree is pi/180, an hour 3600 s, g 9.80665 m/s^2, a gauss 1e-4 T, a knot 1852 m an hour."""
    expected = {
        ("gyroscope_", "imu"): {"rad/s": 1, "mrad/s": 1e-3, "deg/s": np.pi / 180, "deg/h": np.pi / 180 / 3600},
        ("accelerometer_", "imu"): {"m/s^2": 1, "m/s2": 1, "g": 9.80665, "mg": 9.80665e-3},
        ("", "magnetometer"): {"T": 1, "mT": 1e-3, "uT": 1e-6, "nT": 1e-9, "G": 1e-4, "mG": 1e-7},
        ("", "depth"): {"m": 1, "cm": 0.01, "mm": 0.001},
        ("", "sound_velocity"): {"m/s": 1, "cm/s": 0.01, "mm/s": 0.001, "kn": 1852 / 3600},
        ("pressure_", "ctd"): {"dbar": 1, "bar": 10, "mbar": 0.01, "kPa": 0.1, "Pa": 1e-4},
        ("conductivity_", ""): {"S/m": 1, "mS/cm": 0.1, "uS/cm": 1e-4},
        ("", "turbidity"): {"NTU": 1},
    }
    for (prefix, sensor), units in expected.items():
        reading = reading_of(prefix, sensor)
        for unit, factor in units.items():
            assert reading.factor(unit) == pytest.approx(factor, rel=1e-12), unit
        assert reading.factor("") == 1
        with pytest.raises(LookupFailed) as told:
            reading.factor("furlong")
        assert set(told.value.known) == units.keys()


def test_terms_have_the_units_and_keys_of_their_sensor():
    terms = [Term(0.2, True, 0.3), Term(0.03, True, 0.04), Term(0.004, True, 0.005)]
    noise = SensorNoise(*terms, 0.5, 0.0, 1.0, np.ones(1), np.ones(1), 10.0, 300)
    lines = [key.line for key in keys_at_rest({"x": noise}, reading_of("gyroscope_"))]
    assert lines == [
        "gyroscope_noise_density: 0.2  # [rad/s/sqrt(Hz)]", "gyroscope_bias_instability: 0.03  # [rad/s]",
        "gyroscope_random_walk: 0.004  # [rad/s/sqrt(s)]", "gyroscope_resolution: 0.5  # [rad/s]",
    ]  # fmt: skip
    assert [key.line for key in keys_at_rest({"x": noise}, reading_of("", "magnetometer"))] == [
        "noise_density: 0.2  # [T/sqrt(Hz)]", "# bias instability 0.03 [T]: magnetometer has no key for it",
        "# random walk 0.004 [T/sqrt(s)]: magnetometer has no key for it", "resolution_t: 0.5  # [T]",
    ]  # fmt: skip
