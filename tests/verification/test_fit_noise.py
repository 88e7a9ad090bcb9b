"""Noise that is known, found again in records of it; and records that do not tell."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from typer.testing import CliRunner

import pelagos as pl
from pelagos.cli.main import app
from pelagos.errors import InputError, PelagosWarning
from pelagos.identification.noise import allan_deviation, even_rate, fit_beams, fit_noise, keys_of


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
    """A term alone lies nowhere above the measured curve: N/sqrt(tau), sqrt(2 ln 2/pi) B and K sqrt(tau/3) (IEEE Std
    952-1997, Annex C); two digits are printed, half of the last is at most 5 %."""
    noise = 0.3 * np.random.default_rng(6).normal(size=4000)
    x = noise if kind == "white" else np.cumsum(noise)
    file = tmp_path / "imu.csv"
    file.write_text("t,gx\n" + "\n".join(f"{k / 50:.2f},{v:.9f}" for k, v in enumerate(x)), encoding="utf-8")
    told = CliRunner().invoke(app, ["fit-noise", str(file), "--columns", "gx"], terminal_width=200).output
    found = fit_noise(np.array([float(f"{v:.9f}") for v in x]), 50.0)
    bounds = {
        "white": (found.allan * np.sqrt(found.tau)).min(),
        "bias": found.allan.min() / np.sqrt(2 * np.log(2) / np.pi),
        "walk": (found.allan * np.sqrt(3 / found.tau)).min(),
    }
    bounds.pop(kind)
    printed = [float(v) for v in re.findall(r"not seen, < (\S+)", told)]
    assert printed == pytest.approx(list(bounds.values()), rel=0.051)


def flicker(n: int, rate: float, bias: float, random: np.random.Generator) -> np.ndarray:
    """Noise with the density B^2/(2 pi f) on either side of 0 (IEEE Std 952-1997, Annex C.1.4)."""
    f = np.fft.rfftfreq(n, 1 / rate)
    density = np.zeros_like(f)
    density[1:] = bias**2 / (2 * np.pi * f[1:])
    waves = (random.normal(size=len(f)) + 1j * random.normal(size=len(f))) / np.sqrt(2)
    return np.fft.irfft(waves * np.sqrt(density * n * rate), n)


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
        (lambda x, t: 0.01 * x + t, "at rest, and warm"),
    ],
)
def test_records_of_a_sensor_that_moved_are_warned_of(change, said):
    t = np.arange(4000) / 100
    x = np.random.default_rng(5).normal(size=4000)
    fit_noise(x, 100.0)
    with pytest.warns(PelagosWarning, match=said):
        fit_noise(change(x, t), 100.0, label="gx: ")


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
        (["--columns", "gx", "--prefix", "gyro scope"], "letters, digits and _ alone"),
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
