"""Corner reflectors: their target strength in every sonar that images, and its lobe."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError
from sonar_scenes import DT_NS, LAMBERT_DB, PLAIN, at, box, context

import pelagos as pl
from pelagos.acoustics.target_strength import corner, corner_area, corner_lobe
from pelagos.errors import CommandError
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.sidescan import Sidescan, SidescanConfig
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.world.body import Prop
from pelagos.world.by_hand import ThingConfig
from pelagos.world.material import MATERIALS
from pelagos.world.mesh import rotation
from pelagos.world.reflector import CORNERS, EDGES, corner_reflector

DEEP = -200.0
PALETTE = (PLAIN, *(MATERIALS | CORNERS).values())
WORLD = SimpleNamespace(material_row=[m.name for m in PALETTE].index, label_number=lambda label: 5)


def reflector(place, edge, *, yaw=180.0, pitch=0.0, roll=0.0):
    """A corner at a place; without turning it looks back along x."""
    made = Prop("corner_reflector", size=edge).geometry(instance=7, world=WORLD)
    turn = rotation(math.radians(roll), math.radians(pitch), math.radians(yaw))
    return replace(
        made, vertices=made.vertices @ turn.T + place, vertex_normals=(made.vertex_normals @ turn.T).astype("f4")
    )


class TestLobe:
    def test_effective_area(self):
        """Along the axis a^2/sqrt 3; 0 where a plate is seen edge-on; else by the smallest two cosines."""
        assert corner_area(np.full(3, 1 / math.sqrt(3))) == pytest.approx(1 / math.sqrt(3))
        assert corner_area(np.array([0.0, 0.6, 0.8])) == 0.0
        low, middle, high = 0.2, 0.4, math.sqrt(0.8)
        assert corner_area(np.array([middle, high, low])) == pytest.approx(4 * low * middle / (low + middle + high))

    def test_both_formulas_meet(self):
        a = np.array([0.3, 0.4, 0.7])
        a /= np.linalg.norm(a)
        assert corner_area(a * [1, 1, 1 + 1e-9]) == pytest.approx(corner_area(a * [1, 1, 1 - 1e-9]), rel=1e-6)

    def test_the_mean_lobe_is_within_half_a_decibel_of_all_azimuths(self):
        for deg, most in ((5, 0.1), (15, 0.2), (20, 0.3), (25, 0.6)):
            tilt, turn = math.radians(deg), np.linspace(0, 2 * math.pi, 200)
            legs = [
                (math.cos(tilt) + math.sqrt(2) * math.sin(tilt) * np.cos(turn - 2 * math.pi * k / 3)) / math.sqrt(3)
                for k in range(3)
            ]
            exact = 3 * corner_area(np.stack(legs, axis=-1)) ** 2
            assert np.abs(10 * np.log10(corner_lobe(np.array(tilt)) / exact)).max() < most
        assert corner_lobe(np.array([0.0, 1.4])) == pytest.approx([1.0, 0.0], abs=1e-12)

    def test_it_is_wide(self):
        """The 3 dB width of a triangular trihedral is about 40 deg (Robertson 1947)."""
        angle = np.radians(np.linspace(0, 40, 400))
        half = np.degrees(angle[np.argmax(corner_lobe(angle) < 0.5)])
        assert 2 * half == pytest.approx(40.0, abs=3.0)


class TestImages:
    def strength(self, geometries, **options):
        """Of all that 128 beams of 0.09 deg with 1500 rays each see 20 m away [dB re 1 m^2]."""
        config = ImagingSonarConfig(
            beams=128, bins=600, range_min_m=18.0, range_max_m=22.0, horizontal_aperture_deg=12.0, rays_per_beam=1500,
            vertical_beamwidth_deg=40.0, beamwidth_deg=0.25, side_lobe_beams=0, scale="linear", **options,
        )  # fmt: skip
        s = ImagingSonar(config, context(geometries, materials=PALETTE))
        truth = s.sense(at(0, 0, DEEP)).truth[0]
        cell = math.radians(12.0) / 128 * config.bin_width_m
        return 10 * math.log10(max((truth * s.tables["range"] * cell).sum(), 1e-30))

    @pytest.mark.parametrize("edge", [0.25, 0.3, 0.6, 1.0])
    @pytest.mark.parametrize("frequency", [300e3, 750e3])
    def test_a_corner_has_its_target_strength(self, edge, frequency):
        """a^4/(3 lambda^2). It stands 0.4 edges before the tip: 0.02 edge of 40 log r of 20 m for 30 log r kept here,
        0.1 dB; rays and tubes are 4 cm and 1.5 cm apart: 500 of them see the smallest, +-0.1 dB."""
        found = self.strength([reflector((20.0, 0, DEEP), edge)], frequency_hz=frequency)
        assert found == pytest.approx(float(corner(edge, 1500.0 / frequency)), abs=0.2)

    @pytest.mark.parametrize(("yaw", "pitch"), [(10, 0), (0, 15), (-20, 0), (12, -12), (25, 0)])
    def test_it_answers_over_a_wide_angle(self, yaw, pitch):
        """The pattern's azimuthal mean, and how much exact patterns depart from it: at most 0.5 dB."""
        turned = self.strength([reflector((20.0, 0, DEEP), 0.5, yaw=180.0 + yaw, pitch=pitch)])
        back = rotation(0.0, math.radians(pitch), math.radians(180.0 + yaw)).T @ [-1.0, 0, 0]
        turns = np.array([math.pi / 2 + 2 * math.pi * k / 3 for k in range(3)])
        legs = np.stack([np.ones(3), math.sqrt(2) * np.cos(turns), math.sqrt(2) * np.sin(turns)], axis=-1) / math.sqrt(
            3
        )
        exact = 10 * math.log10((corner_area(legs @ back) ** 2) / (1500.0 / 750e3) ** 2 * 0.5**4)
        assert turned == pytest.approx(exact, abs=0.7)

    def test_from_behind_it_is_a_plate(self):
        ahead = self.strength([reflector((20.0, 0, DEEP), 0.5)])
        assert self.strength([reflector((20.0, 0, DEEP), 0.5, yaw=0.0)]) < ahead - 40.0

    def test_what_stands_before_it_hides_it(self):
        """A box before all of it leaves the box; one before its left half leaves half of its rays."""
        corner_ = reflector((20.0, 0, DEEP), 0.5)
        free = self.strength([corner_])
        hidden = self.strength([corner_, box((19.0, 0, DEEP), (0.1, 1.5, 1.5))])
        assert hidden < free - 30.0
        half = self.strength([corner_, box((19.0, 0.75, DEEP), (0.1, 1.5, 1.5))])
        assert half == pytest.approx(free - 3.0, abs=0.3)


class TestOtherSonars:
    """Against plates square on, of Lambert's mu, in the same places: mu times their area."""

    EDGE, SIDE = 0.5, 0.6

    def compared(self, sonar, places, motion, turn, plate):
        """Decibels by which corners are stronger than plates, in all that a sonar hears."""
        levels = []
        for targets in ([reflector(p, self.EDGE, **turn) for p in places], [box(p, plate) for p in places]):
            levels.append(sonar(context(targets, materials=PALETTE)).sense(motion))
        return levels

    def expected(self, frequency):
        return float(corner(self.EDGE, 1500.0 / frequency)) - (LAMBERT_DB + 20 * math.log10(self.SIDE))

    def test_singlebeam(self):
        """Straight ahead: of 20 000 rays as far as the first null, some 2 000 meet either: 0.2 dB. Edges lie 2 deg off
        the axis, where the two-way pattern is 0.5 dB down, and the corner stands 0.2 m nearer: 0.1 dB."""
        config = SinglebeamConfig(
            bins=200, range_min_m=8.0, range_max_m=12.0, rays=20_000, scale="linear", texture_db=0.0
        )
        a, b = self.compared(
            lambda c: Singlebeam(config, c), [(0, 0, DEEP - 10.0)], at(0, 0, DEEP), {"yaw": 0.0, "pitch": -90.0},
            (self.SIDE, self.SIDE, 0.01),
        )  # fmt: skip
        found = 10 * math.log10(a.truth.sum() / b.truth.sum())
        assert found == pytest.approx(self.expected(config.frequency_hz), abs=0.5)

    def test_sidescan(self):
        """40 pings pass it, 5 cm apart. The plate stands upright: it is seen at an angle, whose sine counts twice."""
        config = SidescanConfig(scale="linear", range_max_m=30.0, texture_db=0.0)
        a, b = self.compared(
            lambda c: Sidescan(config, c), [(0, 15.0, DEEP - 6.0)], passing(0.0, 40),
            {"yaw": -90.0, "pitch": -math.degrees(math.atan2(6, 15))}, (self.SIDE, 0.01, self.SIDE),
        )  # fmt: skip
        found = 10 * math.log10(a.truth[:, 0].sum() / b.truth[:, 0].sum())
        sine = 15.0 / math.hypot(15.0, 6.0)
        assert found == pytest.approx(self.expected(config.frequency_hz) - 20 * math.log10(sine), abs=0.5)

    def test_multibeam(self):
        """24 of each in a row. The plates' texture is 1.5 dB rms: their mean 0.26 dB above, and +-0.3 dB of 24."""
        config = MultibeamConfig(water_column_bins=600, range_max_m=20.0, beams=32, swath_deg=20.0)
        places = [(3.0 * k, 0.0, DEEP - 12.0) for k in range(24)]
        a, b = self.compared(
            lambda c: Multibeam(config, c), places, passing(places[-1][0], 250), {"yaw": 0.0, "pitch": -90.0},
            (self.SIDE, self.SIDE, 0.01),
        )  # fmt: skip
        totals = [(10 ** (r.extras["water_column_truth"] / 10)).sum(dtype=np.float64) for r in (a, b)]
        found = 10 * math.log10(totals[0] / totals[1])
        assert found == pytest.approx(self.expected(config.frequency_hz) - 0.26, abs=3 * 0.3)


def passing(far, count):
    """Pings from 1 m before x = 0 to 1 m behind `far`."""
    track = np.array([0, 0, DEEP]) + np.linspace(-1.0, far + 1.0, count)[:, None] * [1.0, 0, 0]
    return lanes(range(count), dt_ns=DT_NS, position=track)


class TestPlacing:
    @pytest.mark.parametrize("edge", [0.05, 0.1, 0.3, 0.5, 3.0])
    def test_its_shape(self, edge):
        """Plates of its edge; a closed, thin solid; of the next material as much as has its cross section."""
        made = corner_reflector(edge)
        mesh = made.mesh
        corners = mesh.vertices[mesh.faces]
        area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        inside = np.array([m != "steel" for m in made.materials])
        size = min(e for e in EDGES if e >= edge)
        assert {m for m in made.materials if m != "steel"} == {f"corner_{size:g}"}
        assert area[inside].sum() * size**2 == pytest.approx(1.5 * edge**4)
        assert np.linalg.norm(mesh.vertices, axis=1).max() == pytest.approx(edge)
        assert mesh.volume == pytest.approx(0.05 * edge**3 * math.sqrt(0.75) / 3)  # base by the tip's distance
        assert made.normals[np.repeat(inside, 3)] == pytest.approx(np.tile([1.0, 0, 0], (3 * inside.sum(), 1)))

    @pytest.mark.parametrize("size", [0.01, 5.0, (0.3, 0.3, 0.4)])
    def test_impossible_props_are_refused(self, size):
        with pytest.raises(CommandError, match="corner reflector"):
            Prop("corner_reflector", size=size).geometry(instance=1, world=WORLD)

    @pytest.mark.parametrize("size", [[0.3, 0.3, 0.4], [9.0, 9.0, 9.0]])
    def test_impossible_things_are_refused(self, size):
        with pytest.raises(ValidationError, match="corner reflector"):
            ThingConfig(shape="corner_reflector", size_m=size)

    def test_in_a_running_scenario(self):
        """Part of the world, hidden, free again, and another one spawned: each is in the next ping."""
        thing = {"shape": "corner_reflector", "at_m": [20, 0, -10], "size_m": [0.5] * 3, "orientation_deg": [0, 0, 180]}
        sonar = {"type": "imaging_sonar", "range_max_m": 30, "scale": "db", "rate_hz": 10, "bins": 256, "beams": 65}
        agent = {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 10}, "sensors": {"it": sonar}}
        world = {"type": "flat", "depth_m": 30, "things": [thing]}
        sim = pl.Simulation.load({"world": world, "agents": {"auv0": agent}})
        sim.reset()
        top = loudest(sim)
        assert top > 20.0  # the ground is below -10 dB
        aslant = (math.cos(0.25), 0.0, 0.0, math.sin(0.25))  # squarely it would be a mirror
        box_ = sim.spawn(pl.Prop("box", position=(15, 0, -10), size=(0.2, 3, 3), attitude=aslant))
        assert loudest(sim) < top - 20.0
        box_.remove()
        assert loudest(sim) == pytest.approx(top, abs=0.1)
        other = sim.spawn(pl.Prop("corner_reflector", position=(12, 2, -10), size=1.0, attitude=(0, 0, 0, 1)))
        assert loudest(sim) > top + 3.0
        other.remove()
        assert loudest(sim) == pytest.approx(top, abs=0.1)


def loudest(sim):
    """The highest level [dB] of the truth of the next ping, of a vehicle held where it is."""
    for _ in range(100):
        sim.set_state("auv0", position=[[0, 0, -10]], attitude=[[1, 0, 0, 0]], velocity=[[0, 0, 0]])
        obs = sim.step()
        if "it" in obs["auv0"]:
            return float(obs["auv0"]["it"].truth.max())
    raise AssertionError("no reading")
