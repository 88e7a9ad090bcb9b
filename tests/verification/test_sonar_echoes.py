"""Raw echoes of altimeter, DVL and ADCP, and what comes after the next ping."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError
from sonar_scenes import DT_NS, at, box, context, plane

from pelagos.errors import ValidityWarning
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.adcp import Adcp, AdcpConfig
from pelagos.sensors.sonar.altimeter import Altimeter, AltimeterConfig
from pelagos.sensors.sonar.dvl import Dvl, DvlConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.ping.beam_echoes import beam_cones
from pelagos.sensors.sonar.singlebeam import cone_rays

DEEP = -200.0
LOUD = {"source_level_db": 260.0}


def below(height: float):
    return plane(DEEP - height)


def test_cones_are_about_their_axes():
    axes = DvlConfig().beams
    rays = beam_cones(axes, math.radians(3.0), 64)
    cone = cone_rays(math.radians(3.0), 64)
    for b, axis in enumerate(axes):
        mine = rays["beam"] == b
        assert rays["direction"][mine] @ axis == pytest.approx(-cone["direction"][:, 2])
        assert np.abs((rays["direction"][mine] * rays["along"][mine]).sum(axis=1)).max() < 1e-12
        outwards = rays["along"][mine] @ axis  # away from the axis, as the cone's
        assert outwards == pytest.approx(-cone["along"][:, 2])


def test_an_altimeters_echo_is_where_it_reads():
    s = Altimeter(AltimeterConfig(iq=True, water_column_bins=500, range_max_m=50.0, **LOUD), context([below(12.5)]))
    reading = s.sense(lanes(range(0, 800, 4), dt_ns=DT_NS, position=(0, 0, DEEP)))
    r = s.tables["water_column_range"]
    assert r[reading.extras["water_column_truth"][0].argmax()] == pytest.approx(reading.truth[0], abs=0.15)
    gain = 30 * np.log10(r) - 10 * np.log10(math.radians(8.0) * 0.1)  # less absorption, 3 dB a hundred metres
    level = 20 * np.log10(np.abs(reading.extras["iq"]).mean(axis=0) + 1e-20) + gain
    assert r[level.argmax()] == pytest.approx(12.5, abs=0.15)


class TestDvl:
    def test_level_labels_and_snr(self):
        shelf = box((0, -50.0, DEEP - 10.0), (200.0, 100.0, 4.0))  # to the right, label 2
        s = Dvl(DvlConfig(labels=True, range_max_m=40.0), context([below(20.0), shelf]))
        extras = s.sense(at(0, 0, DEEP)).extras
        right = s.tables["direction"][:, 1] < 0
        assert (extras["label"][0] == np.where(right, 2, 1)).all()
        assert (extras["instance"][0] == np.where(right, 2, 1)).all()
        assert extras["snr"][0, right].min() > extras["snr"][0, ~right].max() + 5
        r = s.tables["water_column_range"]
        for b in range(4):
            loudest = extras["water_column_truth"][0, b].argmax()
            assert r[loudest] == pytest.approx((8.0 if right[b] else 20.0) / math.cos(math.radians(30)), rel=0.05)
            assert extras["water_column_label"][0, b, loudest] == (2 if right[b] else 1)


def test_an_adcp_hears_the_waters_echo_and_the_bottom():
    """Sv as it is given: in the echo above noise; the bottom far above the water."""
    config = AdcpConfig(water_column_bins=300, volume_scattering_db=-60.0, cells=25, **LOUD)
    s = Adcp(config, context([below(20.0)]))
    extras = s.sense(at(0, 0, DEEP)).extras
    level, r = extras["water_column_truth"][0, 0], s.tables["water_column_range"]
    slant = 20.0 / math.cos(math.radians(20.0))
    assert r[level.argmax()] == pytest.approx(slant, abs=0.5)
    water = level[(r > 5) & (r < 15)]
    # 30 log r instead of 20 log r: the level of a cell grows by 10 log r
    assert np.diff(water).mean() > 0
    assert level.max() - water.max() > 15.0
    assert level[r > slant + 2].max() < -100.0  # nothing behind the bottom
    assert (extras["label"] == 1).all()


@pytest.mark.parametrize(
    ("kind", "config", "altitude", "found"),
    [
        (Altimeter, AltimeterConfig(rate_hz=20.0), 36.0, True),
        (Altimeter, AltimeterConfig(rate_hz=20.0), 39.0, False),
        (Dvl, DvlConfig(rate_hz=20.0), 31.0, True),  # 36 m along the beams
        (Dvl, DvlConfig(rate_hz=20.0), 34.0, False),  # 39 m
        (Multibeam, MultibeamConfig(rate_hz=20.0, beams=9, swath_deg=4.0), 36.0, True),
        (Multibeam, MultibeamConfig(rate_hz=20.0, beams=9, swath_deg=4.0), 39.0, False),
    ],
)
def test_echoes_after_the_next_ping_are_lost(kind, config, altitude, found):
    """c/(2 rate) = 37.5 m at 20 pings a second."""
    reading = kind(config, context([below(altitude)])).sense(at(0, 0, DEEP))
    assert np.isfinite(reading.data).all() == found
    assert np.isnan(reading.data).all() != found


@pytest.mark.parametrize("kind", [Altimeter, Dvl, Multibeam])
def test_ranges_beyond_the_next_ping_are_warned_of(kind):
    with pytest.warns(ValidityWarning, match=r"auv0\.sonar.*after the next ping.*35 m are heard"):
        kind(kind.Config(rate_hz=20.0, range_max_m=80.0), context([below(10.0)]))


def test_cells_beyond_the_next_ping_are_refused():
    with pytest.raises(ValidationError, match="ambiguous"):
        AdcpConfig(cells=200, cell_m=4.0)


def test_a_multibeams_water_column_has_labels_and_signal():
    config = MultibeamConfig(beams=32, water_column_bins=200, range_max_m=40.0, iq=True, labels=True)
    s = Multibeam(config, context([below(15.0), box((0, 0, DEEP - 8.0), (2.0, 2.0, 1.0))]))
    extras = s.sense(at(0, 0, DEEP)).extras
    r, label = s.tables["water_column_range"], extras["water_column_label"][0]
    assert label[16][extras["water_column_truth"][0, 16].argmax()] == 2
    assert 2 not in label[16][r > 9.0]
    assert label[0].max() == 1
    assert (label[0][r < 14.0] == 0).all()
    assert extras["water_column_iq"].shape == extras["water_column"].shape
    assert np.abs(extras["water_column_iq"][0, 0, np.abs(r - 30.0).argmin()]) > 0
