"""Recorded vehicles, devices and seas beside simulated ones: figures of `docs/proof.md` that follow from small tables.

Each bar is the page's own; where the page says that it is missed, the figure that stands there is held, with a tenth of
it in hand, so that a change which moves it is noticed.
"""

from __future__ import annotations

import importlib
import math
import re
import sys
from pathlib import Path

import pytest

import pelagos as pl

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "scripts/proof"


@pytest.fixture(scope="module")
def chapter():
    """Chapters by name, made once from the small tables."""
    made = {}
    sys.path.insert(0, str(SCRIPT))

    def make(name):
        if name not in made:
            made[name] = importlib.import_module(name).chapter(None)
        return made[name]

    yield make
    sys.path.remove(str(SCRIPT))


def row(chapter, words):
    found = [r for r in chapter.rows if words in r.quantity]
    assert len(found) == 1, (words, [r.quantity for r in chapter.rows])
    return found[0]


def test_slocum_rises_and_sinks_as_fast_as_recorded(chapter):
    gliders = chapter("gliders")
    for words in ("Slocum, vertical speed by measured pitch", "by commands alone", "Slocum, pitch"):
        assert row(gliders, words).kept, words


def test_seaglider_dives_as_well_as_its_operators_model(chapter):
    gliders = chapter("gliders")
    speed = row(gliders, "Seaglider, vertical speed")
    own = float(re.match(r"([\d.]+) cm/s", speed.others).group(1))
    assert speed.deviation < 1.15 * own
    assert row(gliders, "glide angle").kept


def test_a_buoy_in_the_simulated_sea_records_what_the_real_one_did(chapter):
    sea = chapter("sea")
    assert [r.kept for r in sea.rows if r.bar is not None] == [True] * 4


@pytest.mark.slow  # 12 s
def test_a_deep_sounder_s_depths_follow_from_time_and_profile(chapter):
    """Rays through the recorded profile that come out as far aside as recorded: 4 100 m within 0.1 %."""
    sys.path.insert(0, str(SCRIPT))
    sonar = importlib.import_module("sonar")
    sys.path.remove(str(SCRIPT))
    assert [r.kept for r in sonar._ray_rows()] == [True, True]


@pytest.mark.slow  # 15 s
def test_images_and_soundings_of_sonars(chapter):
    """Speckle of an Oculus, a swath's level; what misses its bar misses by what the page says."""
    sonar = chapter("sonar")
    assert row(sonar, "Oculus, one ping: speckle contrast").kept
    assert row(sonar, "Oculus, one ping: quantiles").kept
    assert row(sonar, "next row of 2.84 mm").deviation == pytest.approx(0.17, abs=0.03)
    assert row(sonar, "next beam").deviation == pytest.approx(-0.15, abs=0.03)
    assert row(sonar, "level at 55 to 62 deg").kept


@pytest.mark.slow  # 120 s
def test_tankers_zig_zags(chapter):
    """First overshoots within 2.5 deg but for one with the published set; with drift tests of the hull all of them."""
    tanker = chapter("kvlcc2")
    assert row(tanker, "thrust of the screw").deviation == pytest.approx(-2.2, abs=0.5)
    off = [r.deviation for r in tanker.rows if r.quantity.endswith(": first overshoot")]
    assert off == pytest.approx([-1.88, -2.06, -2.48, -1.45, -2.89], abs=0.1)
    drifting = [r for r in tanker.rows if "first overshoot, sideways" in r.quantity]
    assert [r.deviation for r in drifting] == pytest.approx([0.85, -1.75, -2.13, 0.91, -1.45], abs=0.1)
    second = [r.deviation for r in tanker.rows if "second overshoot, sideways" in r.quantity]
    assert second == pytest.approx([-0.36, -0.45, -1.21, 1.60], abs=0.15)
    circles = [r for r in tanker.rows if r.quantity.startswith("circle")]
    assert [r.kept for r in circles] == [True] * 4


def test_drift_tests_of_the_tanker_less_its_rudder(chapter):
    """Y'v and N'v of HMRI's model: a hull less stable on its course than the published -0.315 and -0.137."""
    sys.path.insert(0, str(SCRIPT))
    found = importlib.import_module("kvlcc2").drift_coefficients()
    sys.path.remove(str(SCRIPT))
    assert found == pytest.approx({"Yv": -0.274, "Yvvv": -1.487, "Nv": -0.1453, "Nvvv": 0.294}, rel=0.01)
    hull = pl.Vehicle.from_dict({"type": "kvlcc2", "variant": "drift_tests"}).config.actuators["rudder"].hull
    assert {name: hull[name] for name in found} == pytest.approx(found, rel=1e-4)


@pytest.mark.slow  # 60 s
def test_devices_of_an_rov(chapter):
    """What misses its bar of 20 % misses by what the page says; losses and outliers are kept."""
    rov = chapter("minerva")
    figures = {
        "`range_bearing`": 175.0, "`usbl`": 204.0, "ahead and aside": -39.3, "downwards": -75.7, "no plane bed": -58.7,
        "depth by pressure": 27.3,
    }  # fmt: skip
    for words, off in figures.items():
        assert row(rov, words).deviation == pytest.approx(off, abs=3.0), words
    assert row(rov, "without lock").kept
    assert row(rov, "without one of four ranges").kept
    assert row(rov, "beyond 5 deviations").kept


@pytest.mark.slow  # 10 s
def test_tankers_free_roll(chapter):
    """The period within 2 %; damping by the hull's form within what others publish of Ikeda's method, 30 %."""
    roll = chapter("roll")
    assert row(roll, "period").kept
    assert row(roll, "damping").deviation == pytest.approx(23.4, abs=3)


def test_section_held_in_waves(chapter):
    """The flume: forces in sway and heave over the wave, nothing fitted; the bar is 10 %, kept with 3 %."""
    sys.path.insert(0, str(SCRIPT))
    flume, page = importlib.import_module("flume"), importlib.import_module("page")
    sys.path.remove(str(SCRIPT))
    held = page.table("flume_held.csv")
    for i, number in enumerate(held["wave"].astype(int)):
        found = flume.section_waves(flume.section(), flume.OMEGA[number], depth=flume.DEPTH_M)
        force = abs(found.excitation) * flume.DENSITY * flume.LENGTH_M
        assert force[:2] == pytest.approx([held["sway"][i], held["heave"][i]], rel=0.03), number


@pytest.mark.slow  # 90 s
def test_section_free_in_waves(chapter):
    """Motions within 10 % (20 % at resonance) but where the page says so."""
    flume = chapter("flume")
    missed = [r.quantity for r in flume.rows if r.kept is False]
    assert missed == ["free, 1.16 s: amplitude of sway", "free, 0.90 s: amplitude of sway"]
    for period, off in (("1.21 s", (-17, 19, 8.9)), ("1.52 s", (2.3, 7, 2.2))):
        found = [row(flume, f"free, {period}: amplitude of {m}").deviation for m in ("sway", "heave", "roll")]
        assert found == pytest.approx(off, abs=2), period


def test_tide_and_cast(chapter):
    water = chapter("water")
    assert all(r.kept for r in water.rows if r.bar is not None)
    assert row(water, "mean level").deviation == pytest.approx(-6.8, abs=0.2)  # weather and season, which no tide has


def test_towed_and_held_model_ship(chapter):
    cybership = chapter("cybership")
    assert row(cybership, "towed ahead").kept
    assert row(cybership, "bollard pull").kept
    assert row(cybership, "towed sideways").deviation < 8.5


def test_unseen_run_of_the_model_ship(chapter):
    figures = {
        c: row(chapter("cybership"), f"{c} velocity, open loop 15 s, kept").deviation for c in ("surge", "sway", "yaw")
    }
    assert figures == pytest.approx({"surge": 0.944, "sway": 0.463, "yaw": 0.706}, abs=0.03)


def test_the_page_says_what_the_tables_say(chapter):
    page = (ROOT / "docs/proof.md").read_text(encoding="utf-8")
    for name in ("gliders", "sea", "water"):
        made = chapter(name)
        assert f"## {made.title}" in page
        for r in made.rows:
            line = next(x for x in page.splitlines() if x.startswith(f"| {r.quantity} |"))
            shown = float(re.match(r"[+-]?[\d.]+(e[+-]?\d+)?", line.split("|")[4].strip()).group(0))
            assert shown == pytest.approx(r.deviation, rel=0.06, abs=0.01), r.quantity


def test_a_score_a_deviation_and_an_unjudged_row():
    sys.path.insert(0, str(SCRIPT))
    page = importlib.import_module("page")
    sys.path.remove(str(SCRIPT))
    assert page.at_least("R2", 0.86, 0.85).kept is True
    assert page.at_least("R2", 0.84, 0.85).kept is False
    assert page.relative("x", "m", -2.0, -2.2, 9.0).deviation == pytest.approx(10.0)
    assert page.relative("x", "m", -2.0, -2.2, 9.0).kept is False
    assert page.absolute("x", "m", 2.0, 1.4, 0.7).kept is True
    assert page.absolute("x", "m", 2.0, 1.4, 0.5).kept is False
    text = page.section(page.Chapter("T", "about", "from", [page.at_most("y", 3.0, "m", 2.0)], "why"), Path())
    assert "| y |  |  | 3 m | <= 2 m | **missed** |" in text
    whole = page.joined([text, text.replace("## T", "## S").replace("**missed**", "kept")], ["z: absent"])
    assert "1 of 2 comparisons" in whole
    assert "* z: absent" in whole
    assert list(page.sections(whole)) == ["T", "S", "Not made"]
    assert page.sections(whole)["T"] == text


@pytest.mark.slow  # 15 s
def test_a_thruster_follows_its_pulses(chapter):
    """The catalogue's lag and von Benzon's function within 15 % in lag and in response at 8 Hz; 0.1 s is slow."""
    thruster = chapter("thruster")
    for words in ("square 1600-1900 us", "sine 1600-1900 us"):
        for part in ("lag", "response"):
            kept = [r for r in thruster.rows if r.quantity.startswith(f"{words}, {part}") and "0.1 s" not in r.quantity]
            assert [r.kept for r in kept] == [True, True], (words, part)
    assert row(thruster, "square 1600-1900 us, lag: first order, 0.1 s").deviation > 200


@pytest.mark.slow  # 10 s
def test_an_auv_turns_and_sinks_by_its_pulses(chapter):
    """Steady motions by strong pulses within 15 %, nothing fitted; by weak ones at the surface it turns too much."""
    bolt = chapter("bolt")
    assert row(bolt, "step of yaw pulses, yaw rate").kept
    assert row(bolt, "heave pulses, speed of sinking").kept
    assert row(bolt, "one-way yaw pulses, yaw rate").deviation == pytest.approx(55.5, abs=5)


@pytest.mark.slow  # 15 s
def test_a_velocity_log_errs_as_recorded(chapter):
    """The default 600 kHz log, nothing fitted: error velocity within 20 % in spread and tail; ranges scatter less."""
    log = chapter("dvl")
    assert row(log, "error velocity, two pings, spread").kept
    assert row(log, "error velocity, 95th").kept
    assert row(log, "four beams").kept
    assert row(log, "range along a beam").deviation == pytest.approx(-65, abs=4)


@pytest.mark.slow  # 60 s
def test_a_boat_crosses_a_river(chapter):
    """Bottom track, a bed that moves, a profile: what misses its bar of 20 % misses by what the page says.

    The run is seeded; 3 % are for other machines' rounding where beams or cells are just lost or just not.
    """
    river = chapter("river")
    figures = {
        "error velocity of the bottom track": -53.0, "95th percentile": -26.9, "ranges of the beams": -52.7,
        "speed of the bed along": -5.5, "last 20 of the 103": -41.0, "error velocity over moving bed": -40.9,
        "way over moving bed": -5.7, "noise along a beam": -21.5, "vertical velocity in a cell": 0.1,
        "velocity along the river, spread": -15.8, "friction velocity": -3.2, "exponent of the power law": -3.3,
    }  # fmt: skip
    for words, off in figures.items():
        assert row(river, words).deviation == pytest.approx(off, abs=3.0), words
    for words in ("velocity over ground, still bed", "beams lost, still", "way over still bed", "bed aside"):
        assert row(river, words).kept, words
    assert row(river, "velocity over ground, moving bed").deviation == pytest.approx(29.5, abs=2)
    assert row(river, "beams lost, moving").deviation == pytest.approx(-6.6, abs=1)


def test_a_recorded_log_goes_astray_where_the_bed_moves(chapter):
    """Figures of the kept pings alone: GPS and log agree over still bed; then the bed goes with the river."""
    sys.path.insert(0, str(SCRIPT))
    river = importlib.import_module("river")
    sys.path.remove(str(SCRIPT))
    p = river.pings()
    assert math.degrees(river.alignment(p)) == pytest.approx(0.99, abs=0.02)
    log, gps = river.made_good(p, p, river.STILL_S)
    assert log == pytest.approx(gps, abs=0.6)  # GPS of 0.5 m
    log, gps = river.made_good(p, p, river.MOVING_S)
    assert log - gps == pytest.approx([18.5, -64.0], abs=0.2)
    along, aside = river.bed_speed(p, p, river.MOVING_S)
    assert along == pytest.approx(0.65, abs=0.005)
    assert abs(aside) < 0.05
    kept = river.table("river_profile.csv")
    friction, surface, power = river.log_law(kept["part_of_depth"], kept["along_mps"])
    assert (friction, surface, power) == pytest.approx((0.1254, 2.434, 0.1487), rel=0.01)
