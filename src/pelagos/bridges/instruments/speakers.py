"""From readings of sensors to an instrument's own language, and from requests to answers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from pelagos.bridges.autopilot import motion_of
from pelagos.bridges.instruments import mip, nmea, nortek, teledyne, vectornav
from pelagos.bridges.instruments.a50 import WaterLinkedJson, WaterLinkedSerial
from pelagos.bridges.instruments.doppler_log import DopplerLog
from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.bridges.instruments.ping_devices import Ping1d, Ping360
from pelagos.bridges.instruments.speaker import SOUND_MPS, WATER_KG_M3, Place, Silent, Speaker
from pelagos.math.constants import ATMOSPHERE_PA, GRAVITY


class NmeaGps(Silent):
    """GGA, RMC, VTG and HDT of a satellite compass: its heading, course and speed are the true ones."""

    tells_loss = True

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`; without a fix GGA and RMC say so, and are all there is."""
        at = nmea.clock(reading.t_ns, self.place.epoch)
        if not reading.valid[0]:
            return nmea.no_fix(at)
        motion = motion_of(self.place.sim, self.place.agent)
        latitude, longitude, height = (float(v) for v in reading.data[0])
        north, east, _ = motion.velocity
        speed, course = math.hypot(north, east), math.degrees(math.atan2(east, north))
        return (
            nmea.gga(at, latitude, longitude, height)
            + nmea.rmc(at, latitude, longitude, speed, course)
            + nmea.vtg(speed, course)
            + nmea.hdt(math.degrees(motion.euler[2]))
        )


class NmeaSounder(Silent):
    """DBT of an altimeter; its fields are empty without an echo."""

    tells_loss = True

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        return nmea.dbt(float(np.asarray(reading.data).ravel()[0]) if reading.valid[0] else None)


class NmeaPressure(Silent):
    """XDR of a depth gauge: absolute pressure."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        depth = float(np.asarray(reading.data).ravel()[0])
        return nmea.xdr_pressure(ATMOSPHERE_PA + WATER_KG_M3 * GRAVITY * depth)


class Pd0(DopplerLog):
    """See `teledyne.pd0`."""

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `DopplerLog`."""
        return teledyne.pd0(dvl, self.place.epoch, self.attitude(), SOUND_MPS, self.number, self.down())


class Pd6(DopplerLog):
    """See `teledyne.pd6`; it adds up the distance made good over ground."""

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._made_good = teledyne.MadeGood()

    def begin(self) -> None:
        """See `Speaker`: nothing has been made good yet."""
        super().begin()
        self._made_good = teledyne.MadeGood()

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `DopplerLog`."""
        attitude = self.attitude()
        self._made_good = self._made_good.after(dvl, attitude)
        return teledyne.pd6(dvl, self.place.epoch, attitude, SOUND_MPS, self._made_good)


class Nortek(DopplerLog):
    """See `nortek.bottom_track`."""

    def say(self, dvl: DvlVelocity) -> bytes:
        """See `DopplerLog`."""
        return nortek.bottom_track(dvl, self.place.epoch, self.down())


class Mip(Silent):
    """See `mip.inertial`."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        return mip.inertial(reading.t_ns, *_force_and_rate(reading))


class VectorNavText(Silent):
    """See `vectornav.text`."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        return vectornav.text(*_force_and_rate(reading))


class VectorNavBinary(Silent):
    """See `vectornav.binary`."""

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        return vectornav.binary(reading.t_ns, *_force_and_rate(reading))


def _force_and_rate(reading: Any) -> tuple[list[float], list[float]]:
    """Forward, right, down."""
    x, y, z, p, q, r = (float(v) for v in reading.data[0])
    return [x, -y, -z], [p, -q, -r]


SPEAKERS: Final[Mapping[str, Mapping[str, Callable[[Place], Speaker]]]] = {
    "nmea": {"gps": NmeaGps, "altimeter": NmeaSounder, "depth": NmeaPressure},
    "waterlinked": {"dvl": WaterLinkedJson},
    "waterlinked_serial": {"dvl": WaterLinkedSerial},
    "nortek": {"dvl": Nortek},
    "pd0": {"dvl": Pd0},
    "pd6": {"dvl": Pd6},
    "mip": {"imu": Mip},
    "vectornav": {"imu": VectorNavText},
    "vectornav_binary": {"imu": VectorNavBinary},
    "ping1d": {"altimeter": Ping1d, "singlebeam": Ping1d},
    "ping360": {"mechanical_scanning_sonar": Ping360},
}
"""By protocol, and by the type of the sensor that speaks it."""
