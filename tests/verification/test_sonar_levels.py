"""The sonar equation in decibels, whatever the sampling: levels of surfaces, of noise, of the way between."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr
import numpy as np
import pytest
from scipy.integrate import trapezoid
from sonar_scenes import LAMBERT_DB, StillWater, at, context, plane, still_water

import pelagos as pl
from cases import slow
from pelagos import jit
from pelagos.acoustics.absorption import absorption
from pelagos.acoustics.beam_pattern import shaded_length, weighted_line_np
from pelagos.acoustics.noise import ambient_level, directivity_index, rain_level
from pelagos.errors import ValidityWarning
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.ping.cone_rays import cone_rays
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig

pytestmark = pytest.mark.filterwarnings("ignore:.*finer than the pulse resolves")

SMALL = {"beams": 128, "bins": 256, "rays_per_beam": 96, "range_max_m": 30.0, "orientation_deg": (0, 15, 0)}
LOUD = {"source_level_db": 260.0, "iq": True, "scale": "linear"}


@pytest.fixture(autouse=True)
def _plain_surfaces(monkeypatch):
    monkeypatch.setattr("pelagos.sensors.sonar.ping.patches.patch_factor", lambda *_: 1.0)


def raw_level(**options) -> float:
    """Mean raw level of a flat bottom 6 m below, 15 to 25 m away, without spreading and absorption [dB]."""
    found = []
    for k in range(6):
        s = ImagingSonar(ImagingSonarConfig(**(SMALL | LOUD | options)), context([plane(-6.0)], seed=k))
        reading = s.sense(at(0.3 * k, 0.1 * k, 0, tick=k))
        r, azimuth = s.tables["range"], s.tables["azimuth"]
        level = np.abs(reading.extras["iq"][0]) ** 2 * r**3 * 10 ** (0.2 * 0.17 * r)
        found.append(level[np.abs(azimuth) < 0.9][:, (r > 15) & (r < 25)].mean())
    return 10 * math.log10(np.mean(found))


@pytest.fixture(scope="module")
def usual_level() -> float:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pelagos.sensors.sonar.ping.patches.patch_factor", lambda *_: 1.0)
        return raw_level()


@pytest.mark.parametrize(
    "options",
    [slow({"beams": 256}), slow({"bins": 128}), slow({"bins": 512}), {"bins": 1024}, {"rays_per_beam": 192}],
    ids=str,
)
def test_raw_level_and_noise_do_not_depend_on_sampling(options, usual_level):
    """Beams of 1 deg in sectors of 1 and 0.5 deg, a pulse of 25 mm in bins of 29 to 230 mm: within 0.3 dB."""
    assert raw_level(**options) == pytest.approx(usual_level, abs=0.3)
    sonar = ImagingSonar(ImagingSonarConfig(**(SMALL | LOUD | options)), context([plane(-1000.0)]))
    noise = np.abs(sonar.sense(at(0, 0, 0)).extras["iq"]) ** 2
    assert 10 * math.log10(noise.mean()) == pytest.approx(NOISE_DB, abs=0.1)


def _noise_db() -> float:
    """N0 over the pulse's energy, the array's directivity and what its filter's shading loses, re a source of 260 dB:
    NL - 10 log10(T) + 10 log10(1.5) - DI - SL."""
    own = ImagingSonarConfig()
    density = 10 * math.log10(10 ** (ambient_level(750e3, 5.0) / 10) + 10 ** (own.self_noise_db / 10))
    index = directivity_index(math.radians(1.0), math.radians(20.0))
    return density - 10 * math.log10(own.pulse_s) + 10 * math.log10(1.5) - index - 260.0


NOISE_DB = _noise_db()


def test_bottom_has_the_level_of_the_sonar_equation():
    """RL - SL = -40 log r - 2 a r + S + 10 log A: straight below a sounder, A what pattern and pulse leave of an even
    bottom. The trace's energy is that of the whole patch: sum of r^4 I over the bins = sigma * psi h^2 * 1.5 c/2B/bin.
    """
    config = SinglebeamConfig(beamwidth_deg=10.0, bins=2000, range_max_m=25.0, bandwidth_hz=60e3, **LOUD)
    power, h = 0.0, 20.0
    for k in range(40):
        s = Singlebeam(config, context([plane(-h)], seed=k))
        iq = s.sense(at(0.7 * k, 0.3 * k, 0, tick=k)).extras["iq"][0]
        r = s.tables["range"].astype(float)
        power += (np.abs(iq) ** 2 * r**4)[(r > h - 0.3) & (r < h + 1.5)].sum() / 40
    rays = cone_rays(math.radians(10.0), 4096)
    cosine = -rays["direction"][:, 2]
    psi = float((rays["weight"] * cosine**-3 * cosine**2).sum())  # area over h^2, and Lambert's sin^2
    loss = float(absorption(jit.Float64(200e3), 10.0, 35.0, 0.0)[0])
    expected = 10 * math.log10(psi * h * h * 1.5 * 1500 / 120e3 / config.bin_width_m) + LAMBERT_DB - 2 * loss * h
    assert 10 * math.log10(power) == pytest.approx(
        expected, abs=0.45
    )  # 40 pings of some 15 independent samples: 3 deviations


@dataclass
class WarmOnTop(StillWater):
    """8 deg at -300 m and 20 deg at the surface, fresher on top; a Dr.Jit struct."""

    def temperature(self, position, t):
        return 20.0 + position[2] / 25.0

    def salinity(self, position, t):
        return 34.0 - position[2] / 300.0


def loss_at(frequency: float, depth, *, warm: bool) -> np.ndarray:
    """Absorption at depths [dB/m] in `WarmOnTop` or in `StillWater`."""
    z = jit.Float64(np.atleast_1d(depth))
    water = (20.0 - z / 25.0, 34.0 + z / 300.0) if warm else (10.0 + 0.0 * z, 35.0 + 0.0 * z)
    return np.array(absorption(jit.Float64(frequency), *water, z))


def integrated(frequency: float, top: float, bottom: float, *, warm: bool) -> float:
    """Absorption along the vertical [dB], by the trapezoidal rule."""
    depth = np.linspace(top, bottom, 2001)
    return float(trapezoid(loss_at(frequency, depth, warm=warm), depth))


@pytest.mark.parametrize(("frequency", "depth", "height"), [(200e3, 10.0, 250.0), (300e3, 200.0, 80.0)])
@pytest.mark.parametrize("warm", [False, True])
def test_absorption_is_integrated_along_the_way(frequency, depth, height, warm):
    """The trace's gain has the absorption at the sonar; what the way takes less shows: 2 (a0 h - int a dz)."""
    ocean = WarmOnTop(dr.opaque(jit.Float64, 1500.0)) if warm else still_water()
    options = {"range_max_m": 300.0, "rate_hz": 2.0, "bins": 600, "beamwidth_deg": 2.0, "refraction": False}
    config = SinglebeamConfig(frequency_hz=frequency, scale="db", **options)
    peak = [
        Singlebeam(config, context([plane(-d - height)], ocean=ocean)).sense(at(0, 0, -d)).truth.max()
        for d in (depth, 5.0)
    ]
    there, near = (
        2 * (float(loss_at(frequency, d, warm=warm)[0]) * height - integrated(frequency, d, d + height, warm=warm))
        for d in (depth, 5.0)
    )
    assert abs(near) > 0.04
    assert peak[0] - peak[1] == pytest.approx(there - near, abs=0.05)


def test_a_deep_multibeam_hears_as_much_as_the_way_lets_through():
    """300 kHz over 250 m, 20 to 9 deg: its signal-to-noise ratio follows the integral, not the loss at the sonar."""
    config = MultibeamConfig(
        frequency_hz=300e3, range_max_m=300.0, rate_hz=2.0, beams=3, swath_deg=4.0, refraction=False,
        source_level_db=260.0,
    )  # fmt: skip
    snr = []
    for water in (WarmOnTop(dr.opaque(jit.Float64, 1500.0)), still_water()):
        s = Multibeam(config, context([plane(-260.0)], ocean=water))
        snr.append(np.mean([s.sense(at(3.0 * k, 0, -10.0, tick=k)).extras["snr"] for k in range(30)]))
    warm, even = (2 * integrated(300e3, 10.0, 260.0, warm=w) for w in (True, False))
    at_sonar = 2 * 250.0 * float(loss_at(300e3, 10.0, warm=True)[0])
    assert at_sonar - warm > 5.0
    assert snr[0] - snr[1] == pytest.approx(even - warm, abs=0.1)  # both waters show the same facets


def weather(ocean: dict[str, object], **sonar: object) -> pl.Simulation:
    sensor = {"type": "singlebeam", "rate_hz": 5, "iq": True, "frequency_hz": 30e3, "bandwidth_hz": 2e3, **sonar}
    sensor |= {"self_noise_db": 10.0, "range_max_m": 30.0, "position_m": [0.3, 0, 0.3]}
    auv = {"vehicle": "remus100", "start": {"depth_m": 20.0, "position_m": [0, 0]}, "sensors": {"echo": sensor}}
    return pl.Simulation.load({"world": {"type": "flat", "depth_m": 900.0}, "ocean": ocean, "agents": {"auv0": auv}})


def noise_of(sim: pl.Simulation) -> float:
    sim.reset()
    found = []
    for _ in range(200):
        obs = sim.step()["auv0"]
        found += [np.abs(obs["echo"].extras["iq"]) ** 2] if "echo" in obs else []
    return 10 * math.log10(np.mean(found))


@pytest.mark.filterwarnings("ignore:.*frequency")
def test_the_scenarios_wind_and_rain_are_heard():
    """At 30 kHz and 3, 12 m/s, and 10 mm/h: the levels differ as Wenz's wind and the rain do; 4000 samples: 0.3 dB."""
    levels = {}
    cases = {"calm": {"wind": {"speed_mps": 3.0}}, "windy": {"wind": {"speed_mps": 12.0}}}
    cases["rain"] = {"wind": {"speed_mps": 3.0}, "weather": {"rain_mm_per_h": 10.0}}
    for name, ocean in cases.items():
        levels[name] = noise_of(weather(ocean))
    own = lambda level: 10 * math.log10(10 ** (level / 10) + 10.0)
    wind = own(ambient_level(30e3, 12.0)) - own(ambient_level(30e3, 3.0))
    rain = own(ambient_level(30e3, 3.0, rain_mm_per_h=10.0)) - own(ambient_level(30e3, 3.0))
    assert wind > 8.0
    assert rain > 5.0
    assert levels["windy"] - levels["calm"] == pytest.approx(wind, abs=0.4)
    assert levels["rain"] - levels["calm"] == pytest.approx(rain, abs=0.4)


@pytest.mark.filterwarnings("ignore:.*frequency")
def test_a_sonars_own_wind_overrides_the_scenarios_and_says_so():
    with pytest.warns(ValidityWarning, match=r"auv0\.echo: wind_speed_mps 12 overrides the scenario's wind of 3 m/s"):
        sim = weather({"wind": {"speed_mps": 3.0}}, wind_speed_mps=12.0)
    assert noise_of(sim) == pytest.approx(noise_of(weather({"wind": {"speed_mps": 12.0}})), abs=1e-6)


def test_rain_has_the_levels_of_its_source():
    """Ma, Nystuen and Lien (2005): 42.4 + 15.4 log10 R at 5 kHz: 57.8 dB at 10 mm/h, 68.6 at 50."""
    assert rain_level(5e3, 10.0) == pytest.approx(57.8, abs=0.01)
    assert rain_level(5e3, 50.0) == pytest.approx(68.56, abs=0.01)
    assert rain_level(5e3, 0.0) == -math.inf


@pytest.mark.parametrize("beams", [128, 192])
def test_the_water_column_has_the_nadirs_ring_of_side_lobes(beams):
    """At the range of the nadir's echo a beam at 40 deg hears it by the side lobes of its Hamming array: their mean
    power there, over the beam's at nadir; in the truth and, averaged over beams, in the data."""
    config = MultibeamConfig(
        beams=beams,
        swath_deg=120.0,
        water_column_bins=400,
        range_max_m=40.0,
        source_level_db=260.0,
        beamwidth_across_deg=1.0,
    )
    s = Multibeam(config, context([plane(-20.0)]))
    reading = s.sense(at(0, 0, 0))
    r, angle = s.tables["water_column_range"], np.degrees(s.tables["angle"])
    ring = np.abs(r - 20.0) < 0.35
    near, far = np.abs(angle) < 1.5, np.abs(np.abs(angle) - 40.0) < 6.0
    lobes = (
        weighted_line_np(np.sin(np.radians(angle[far])), shaded_length(math.radians(1.0), "hamming"), "hamming") ** 2
    )
    for name, slack in (("water_column_truth", 3.0), ("water_column", 6.0)):
        power = 10 ** (reading.extras[name][0] / 10)
        ratio = 10 * math.log10(power[far][:, ring].max(axis=1).mean() / power[near][:, ring].max())
        # the echo of some beams about the nadir adds up: 10 log of the widths it fills
        assert 10 * math.log10(lobes.mean()) - slack < ratio < 10 * math.log10(lobes.mean()) + slack + 6.0, name
        assert ratio < -35.0


@dataclass
class Front(StillWater):
    """Layered water beyond x = 500 m, and even water before; a Dr.Jit struct."""

    def sound_speed(self, position, t):
        return self.speed + dr.select(position[0] > 500.0, 0.8 * (position[2] + 20.0), 0.0)


@pytest.mark.parametrize(("far", "bent"), [(800.0, True), (300.0, False)])
def test_refraction_is_switched_on_by_water_anywhere_in_the_world(far, bent):
    """A front 500 m off the origin, in a world that reaches 800 m, or only 300 m."""
    scene = context([plane(-40.0)], ocean=Front(dr.opaque(jit.Float64, 1500.0)))
    scene.world.geometries = (plane(-40.0),)
    scene.world.bounds = np.array([[-far, -far, -40.0], [far, far, 0.0]])
    config = ImagingSonarConfig(**(SMALL | {"range_max_m": 120.0}))
    assert ImagingSonar(config, scene)._pinger._sounder.bent is bent
