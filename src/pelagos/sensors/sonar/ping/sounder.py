"""Constants of a sonar: its water, the surfaces at its frequency, its random stream, its recorded ping."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.echo import Patches
from pelagos.jit import Array
from pelagos.raycast.caster import Caster
from pelagos.sensors.mount import Mounted, sensor_pose
from pelagos.sensors.noise import Key, opaque_key, stream_key
from pelagos.sensors.sonar.ping.fan import Fan, FanHits, Lanes, Trace, cast_fan, fan_struct
from pelagos.sensors.sonar.ping.medium import medium_of, profile_of
from pelagos.sensors.sonar.ping.patches import patches_of
from pelagos.sensors.sonar.ping.ping_spec import Refraction
from pelagos.sensors.sonar.ping.sea_surface import looks_up, sea_around
from pelagos.sensors.sonar.ping.surface_scattering import TEXTURE_DB, Surfaces, surfaces
from pelagos.sensors.sonar.ping.water_around import profiles_around
from pelagos.sensors.sonar.ping.water_survey import survey

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean
    from pelagos.sensors.sensor import Kinematics, SensorContext

FACE_M: Final = 0.05  # a sonar higher than this above the surface is out of the water; assumed half the face of one
_BENDS: Final = 0.004  # displacement of a level ray, in parts of the range, from which refraction matters
_NEAR: Final = 60.0  # [m], reach from which on the sea around a sonar is as coarse as it gets
_VARIES: Final = 5e-4  # change of the sound speed with the place, in parts of it, from which it counts along the way


@dataclass(frozen=True)
class Waters:
    """Water and surfaces that a sonar's rays meet.

    Attributes:
        frequency_hz: of the water's absorption and of the surfaces' scattering.
        ph: acidity of the water.
        wind_speed: roughens the sea surface [m/s].
        texture_db: rms variation of surfaces' cross sections from place to place [dB].
        refraction: whether rays bend by the profile of the sound speed; "auto": where a level ray would be displaced,
            or the sound speed changes from place to place within the reach, by more than `_BENDS` of it.
        reach: longest range of a ray [m], by which the sea around is as fine as it matters.
        sea_surface: whether rays that reach it meet the ocean's waves and tide, or a plane at rest.
    """

    frequency_hz: float
    ph: float
    wind_speed: float = 5.0
    texture_db: float = TEXTURE_DB
    refraction: Refraction = False
    reach: float = _NEAR
    sea_surface: Literal["waves", "flat"] = "waves"


@dataclass(frozen=True)
class Ping:
    """One ping on every lane, as a recorded kernel sees it.

    Attributes:
        caster: the world, see `Caster`.
        lanes: where the sonar is.
        fan: its rays.
        surfaces: what materials scatter.
        key: random stream of its noise.
        motion: of the body.
    """

    caster: Caster
    lanes: Lanes
    fan: Fan
    surfaces: Surfaces
    key: Key
    motion: Kinematics

    def cast(self, *, max_range: float, smooth: bool = True, assumed_speed: float | None = None) -> FanHits:
        """Cast the fan on every lane, see `fan.cast_fan`."""
        return cast_fan(
            self.caster, self.fan, self.lanes, self.surfaces, max_range=max_range, smooth=smooth,
            assumed_speed=assumed_speed,
        )  # fmt: skip

    def patches(self, view: FanHits, *, longest: float, trace: Trace = None) -> Patches:
        """The echo of every ray as a strip of surface, see `patches_of`."""
        return patches_of(view, self.fan, self.lanes, self.surfaces, longest=longest, trace=trace)


class Sounder:
    """The parts that a sonar keeps from ping to ping; none of them changes.

    Args:
        mounting: where it sits.
        context: see `SensorContext`.
        rays: the ray pattern, see `fan_struct`.
        waters: what its rays meet.

    Attributes:
        fan: rays on the device.
        surfaces: what materials scatter.
        key: random stream of the sonar's noise.
        bent: whether rays bend.
    """

    def __init__(
        self, mounting: Mounted, context: SensorContext, rays: dict[str, NDArray[Any]], waters: Waters
    ) -> None:
        self._mounting, self._waters = mounting, waters
        reach = waters.reach
        self._context = context
        self._reach = reach
        moves = context.ocean.waves is not None or context.ocean.tide is not None
        self._moves = moves
        self._surface = waters.sea_surface == "waves" and moves
        self._waves = looks_up(in_body(mounting, rays["direction"]))
        self._bottom = lowest_ground(context, reach)
        self._medium = medium_of(waters.frequency_hz, waters.ph, context.path, reach=reach, bottom=self._bottom)
        asked = waters.refraction
        self.bent, self._varied = bends(context, asked, reach, self._bottom)
        self._own = jit.UInt32(context.own_body)
        jit.align(self._own)
        self.fan: Fan = fan_struct(rays)
        jit.align(self.fan)
        self.surfaces: Surfaces = surfaces(
            context.world.palette, waters.frequency_hz, wind_speed=waters.wind_speed, texture_db=waters.texture_db
        )
        self.key = opaque_key(stream_key(context.seed, context.path, "noise"))

    def arguments(self, motion: Kinematics) -> tuple[Lanes, Fan, Surfaces, Any]:
        """Arguments of every ping: where the sonar is, its rays, its surfaces, its random stream."""
        return self._lanes(motion, self._context.ocean, self._own), self.fan, self.surfaces, self.key

    def compile(self, kernel: Callable[..., Any]) -> Callable[..., Any]:
        """Freeze all that a ping takes, from the body's motion on: a function (motion, *more) of arrays.

        `kernel` is called with (ping, *more). Lanes that are found outside of the
        frozen ping take longer than a ping of few rays: 0.3 to 0.6 ms.
        """

        def whole(
            caster: Caster,
            motion: Kinematics,
            ocean: Ocean,
            own: Array,
            fan: Fan,
            surfaces: Surfaces,
            key: Key,
            *more: Any,
        ) -> Any:
            lanes = self._lanes(motion, ocean, own)
            dr.eval(lanes)  # in one kernel: rays gather from each of its arrays
            return kernel(Ping(caster, lanes, fan, surfaces, key, motion), *more)

        frozen = self._context.scene.compile(whole)

        def ping(motion: Kinematics, *more: Any) -> Any:
            return frozen(motion, self._context.ocean, self._own, self.fan, self.surfaces, self.key, *more)

        return ping

    def _lanes(self, motion: Kinematics, ocean: Ocean, own: Array) -> Lanes:
        position, attitude = sensor_pose(motion, self._mounting)
        t = jit.Float64(motion.t_ns) * 1e-9
        water = self._medium(ocean, position, t)
        own_row = dr.gather(jit.UInt32, own, motion.copy)
        profile = profile_of(ocean, position, t, reach=self._reach, bottom=self._bottom) if self.bent else None
        around = profiles_around(ocean, position, t, reach=self._reach, bottom=self._bottom) if self._varied else None
        sea = (
            sea_around(ocean, position, t, motion.copy, reach=self._reach, waves=self._waves) if self._surface else None
        )
        wet = position.z <= (
            ocean.elevation(position.x, position.y, t, motion.copy) + FACE_M if self._moves else FACE_M
        )
        who = (motion.copy, own_row, motion.environment, motion.tick)
        return Lanes(position, attitude, *who, water, profile, sea, wet, around)

    def trace(self, kernel: Callable[..., Any], motion: Kinematics, *more: Any) -> list[tuple[str, NDArray[Any], str]]:
        """Run a ping that is not frozen, and keep its intermediate arrays: (name, values, unit).

        `kernel(ping, *more, trace=...)` is the sonar's.
        """
        found: list[tuple[str, NDArray[Any], str]] = []
        keep: Trace = lambda name, values, unit: found.append((name, np.array(values), unit))
        ping = Ping(self._context.scene.caster, *self.arguments(motion), motion)
        kernel(ping, *more, trace=keep)
        return found


def in_body(mounting: Mounted, directions: NDArray[Any]) -> NDArray[Any]:
    """Unit vectors `(r, 3)` of the sensor frame in the body frame."""
    w, *v = mounting.q_body_sensor
    return directions + 2.0 * np.cross(v, np.cross(v, directions) + w * directions)


def lowest_ground(context: SensorContext, reach: float) -> float:
    """Height of the world's deepest place [m]; without any ground, of how deep rays may reach."""
    return float(context.world.bounds[0, 2]) if context.world.geometries else -max(reach, 1.0)


def bends(context: SensorContext, asked: Refraction, reach: float, bottom: float) -> tuple[bool, bool]:
    """Refraction over `reach` [m] above `bottom`, anywhere in the world and on its first day: whether rays bend, and
    whether profiles along their ways count."""
    if asked is False:
        return False, False
    water = survey(context, reach, bottom)
    bent = asked is True or max(water.displacement, water.variation) > _BENDS
    return bent, bent and water.variation > _VARIES
