"""Common parts of all cameras: a lens, its rays, and their hits.

A lens is two tables, one entry a pixel: where its ray starts and where it points, both in the sensor frame (x
    forward, y left, z up).
Pixels that the lens does not serve (outside a fisheye's circle) look nowhere.
"""

from __future__ import annotations

import math
import warnings
import weakref
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Final, Generic, Literal, Self, TypeAlias, TypeVar

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.config.strict import Strict, refusal
from pelagos.errors import ValidityWarning
from pelagos.jit import Array
from pelagos.math.so3 import rotate
from pelagos.optics.lens import (
    Intrinsics,
    fisheye_directions,
    fisheye_intrinsics,
    fisheye_reach,
    intrinsics,
    natural_vignette,
    pinhole_directions,
    project,
    project_fisheye,
)
from pelagos.optics.port import through_dome_port, through_flat_port
from pelagos.optics.water import REFRACTIVE_INDEX
from pelagos.raycast.rays import Rays
from pelagos.sensors.camera.picture.pixel_order import Pixels, Tiling
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.sensor import Kinematics, SensorConfig, SensorContext


class FlatPortConfig(Strict):
    """A flat window: magnifies by the index of water, and bends more towards the corners."""

    type: Literal["flat"]
    """The kind of port."""
    distance_m: float = Field(default=0.02, gt=0, le=1)
    """From the lens's entrance pupil to the window's dry face [m]."""
    thickness_m: float = Field(default=0.01, ge=0, le=0.2)
    """Thickness of the window, acrylic [m]."""


class DomePortConfig(Strict):
    """A spherical window: keeps the field of view when the lens sits at its centre."""

    type: Literal["dome"]
    """The kind of port."""
    radius_m: float = Field(default=0.05, gt=0, le=1)
    """Radius of the dry face [m]."""
    thickness_m: float = Field(default=0.006, ge=0, le=0.2)
    """Thickness of the dome, acrylic [m]."""
    offset_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where the dome's centre is, from the entrance pupil, forward-left-up [m]."""

    @model_validator(mode="after")
    def _pupil_is_inside(self) -> Self:
        if (off := math.hypot(*self.offset_m)) >= self.radius_m:
            raise refusal(f"'offset_m' puts the pupil {off:.4g} m from the centre of a dome of {self.radius_m:g} m")
        return self


Trace: TypeAlias = Callable[[str, Array, str], None]
PortConfig: TypeAlias = Annotated[FlatPortConfig | DomePortConfig, Field(discriminator="type")]


class ViewConfig(SensorConfig):
    """Size of the picture, and the lens."""

    rate_hz: Rate = 2.0
    """Frames per second [Hz]; must divide the tick rate."""
    width_px: int = Field(default=640, ge=16, le=8192)
    """Width of the picture [px]."""
    height_px: int = Field(default=480, ge=16, le=8192)
    """Height of the picture [px]."""
    horizontal_fov_deg: float = Field(default=70.0, gt=1, le=360)
    """Field of view across the width [deg]: in the medium around the camera, or in air behind a `port`."""
    lens: Literal["pinhole", "fisheye"] = "pinhole"
    """Projection: `pinhole` with Brown-Conrady distortion, or `fisheye` of Kannala and Brandt."""
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    """Coefficients in the order of OpenCV: k1, k2, p1, p2, k3 of a pinhole; k1, k2, k3, k4, 0 of a fisheye."""
    port: PortConfig | None = None
    """Window between lens and water; None for a lens calibrated in water."""
    max_range_m: float = Field(default=60.0, gt=0)
    """How far to look for surfaces [m]."""

    @model_validator(mode="after")
    def _lens_can_be(self) -> Self:
        fov, half = self.horizontal_fov_deg, math.radians(self.horizontal_fov_deg) / 2
        if self.lens == "pinhole":
            if fov >= 180:
                raise refusal(f"'horizontal_fov_deg' of a pinhole is below 180, not {fov:g}; for more, 'lens: fisheye'")
            return self
        if self.distortion[4] != 0:
            raise refusal(f"'distortion' of a fisheye has k1 to k4; the fifth value is 0, not {self.distortion[4]:g}")
        if (reach := fisheye_reach(self.distortion)) < half:
            most = math.degrees(2 * reach)
            raise refusal(f"'distortion' folds this fisheye back on itself: 'horizontal_fov_deg' is at most {most:.4g}")
        return self


@jit.struct
class Lens:
    """The lens's tables, a Dr.Jit struct, lanes in the order of `Tiling`.

    Attributes:
        start: `Array3f`, where rays start in the sensor frame [m]; None where all start at the origin.
        direction: `Array3f`, unit.
        dry: `Array3f`, the same where the port is out of the water; None without a port.
        serves: `Bool`, pixels that look somewhere.
    """

    start: Array | None
    direction: Array
    dry: Array | None
    serves: Array


def view_intrinsics(config: ViewConfig) -> Intrinsics:
    """Focal length and principal point [px]."""
    fov = math.radians(config.horizontal_fov_deg)
    if config.lens == "fisheye":
        return fisheye_intrinsics(config.width_px, config.height_px, fov, config.distortion)
    return intrinsics(config.width_px, config.height_px, fov)


def pixel_rays(
    config: ViewConfig, outside: float = REFRACTIVE_INDEX, *, shift: tuple[float, float] = (0.0, 0.0)
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The ray pattern: starts [m] and unit directions `(height, width, 3)` in the sensor frame; NaN for no ray.

    Behind a port, in a medium of index `outside`: water, or 1 above it. With a `shift`, of places that far right and
    down of the pixels [px].
    """
    camera = view_intrinsics(config)
    camera = replace(camera, cx=camera.cx - shift[0], cy=camera.cy - shift[1])
    if config.lens == "fisheye":
        directions = fisheye_directions(camera, config.distortion)
    else:
        directions = pinhole_directions(camera, config.distortion)
    match config.port:
        case FlatPortConfig(distance_m=distance, thickness_m=thickness):
            return through_flat_port(directions, distance=distance, thickness=thickness, outside=outside)
        case DomePortConfig(radius_m=radius, thickness_m=thickness, offset_m=offset):
            return through_dome_port(directions, radius=radius, thickness=thickness, offset=offset, outside=outside)
    return np.zeros_like(directions), directions


def project_points(points: NDArray[np.float64], config: ViewConfig) -> NDArray[np.float64]:
    """Points `(..., 3)` in the sensor frame -> pixels `(..., 2)`, for a lens without a port."""
    camera = view_intrinsics(config)
    if config.lens == "fisheye":
        return project_fisheye(points, camera, config.distortion)
    return project(points, camera, config.distortion)


def pixel_angle(config: ViewConfig) -> float:
    """Angle between neighbouring pixels in the middle of the picture [rad]."""
    return 1 / view_intrinsics(config).fx


class LensTables:
    """Tables on the device of a lens of so many pixels; cameras that look alike share them, see `lens_tables`.

    Attributes:
        tiling: order of the rays.
        lens: their directions.
        blind: share of the pixels that look nowhere.
    """

    def __init__(self, config: ViewConfig) -> None:
        self.tiling = Tiling(config.width_px, config.height_px)
        starts, directions = pixel_rays(config)
        serves = np.asarray(np.isfinite(starts + directions).all(axis=-1))
        self.blind = float(1 - serves.mean())
        dry = None
        if config.port is not None:
            in_air = pixel_rays(config, 1.0)[1]
            dry = self._table(np.where(np.isfinite(in_air), in_air, [1.0, 0.0, 0.0]))
        self.lens = Lens(
            start=self._table(np.where(serves[..., None], starts, 0)) if config.port is not None else None,
            direction=self._table(np.where(serves[..., None], directions, [1.0, 0.0, 0.0])),
            dry=dry,
            serves=jit.Bool(self.tiling.arrange(np.asarray(serves, dtype=np.float64)) > 0.5),
        )
        jit.align(self.lens)
        self._vignettes: dict[float, Array] = {}

    def vignette(self, config: ViewConfig, strength: float) -> Array:
        """`Float` share of light at each pixel, see `natural_vignette`."""
        if strength not in self._vignettes:
            _, directions = pixel_rays(config.model_copy(update={"port": None}))
            share = np.nan_to_num(natural_vignette(directions, strength, fisheye=config.lens == "fisheye"))
            self._vignettes[strength] = jit.from_numpy(jit.Float, self.tiling.arrange(share))
        return self._vignettes[strength]

    def _table(self, values: NDArray[np.float64]) -> Array:
        return jit.Array3f(np.ascontiguousarray(self.tiling.arrange(values).T))


_IN_USE: Final[weakref.WeakValueDictionary[Any, LensTables]] = weakref.WeakValueDictionary()


def lens_tables(config: ViewConfig) -> LensTables:
    """Tables of a camera's lens: those of another camera with the same one, as long as there is one."""
    key = (config.width_px, config.height_px, config.horizontal_fov_deg, config.lens, config.distortion, config.port)
    found = _IN_USE.get(key)
    if found is None:
        found = _IN_USE[key] = LensTables(config)
    return found


class Imager:
    """The parts that a camera keeps from frame to frame; none of them changes.

    Attributes:
        tiling: order of the rays.
        lens: their directions on the device.
        own: `UInt32` `(n,)`, rows of the own hull.
    """

    def __init__(self, config: ViewConfig, context: SensorContext) -> None:
        self._config, self._context = config, context
        self._tables = lens_tables(config)
        self.tiling, self.lens = self._tables.tiling, self._tables.lens
        if config.lens == "pinhole" and self._tables.blind > 0:
            _warn_of_blind_pixels(self._tables.blind, context.path)
        self.own = jit.UInt32(context.own_body)
        jit.align(self.own)

    def vignette(self, strength: float) -> Array:
        """`Float` share of light at each pixel, see `natural_vignette`."""
        return self._tables.vignette(self._config, strength)

    def arguments(self, motion: Kinematics) -> tuple[Lens, Kinematics, Array]:
        """Arguments of every frame: the lens, the motion, the own hull's rows."""
        return self.lens, motion, self.own

    def explain(self, kernel: Callable[..., Any], arguments: tuple[Any, ...]) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays (name, values, unit) of one unfrozen frame of `make(caster, trace)`."""
        found: list[tuple[str, NDArray[Any], str]] = []

        def trace(name: str, values: Array, unit: str) -> None:
            found.append((name, np.array(values), unit))

        kernel(self._context.scene.caster, *arguments, trace=trace)
        return found

    def images(self, values: Array, dtype: Any) -> NDArray[Any]:
        """`(images, height, width)` of a flat array."""
        return np.array(values).reshape(-1, self._config.height_px, self._config.width_px).astype(dtype, copy=False)


def _warn_of_blind_pixels(share: float, path: str) -> None:
    message = (
        f"{path}: {share:.1%} of the picture see nothing and stay dark: no direction leads there through the lens "
        "('distortion') and its port; a smaller 'horizontal_fov_deg' helps"
    )
    warnings.warn(message, ValidityWarning, stacklevel=2)


def view_rays(
    lens: Lens, where: Pixels, motion: Kinematics, own: Array, config: ViewConfig, level: Array | None = None
) -> Rays:
    """Rays of all pixels at the moments of `motion`, in the world.

    Args:
        lens: see `Lens`.
        where: the pixels.
        motion: of the vehicle.
        own: rows of the own hull.
        config: place of the camera.
        level: height of the sea over each camera, `Float` by image [m]: above it a port is in air. None for z = 0.
    """
    position, attitude = sensor_pose(motion, config)
    q = jit.Array4f(*(dr.gather(jit.Float, jit.Float(attitude[i]), where.image) for i in range(4)))
    origin = dr.gather(jit.Array3f64, position, where.image)
    if lens.start is not None:
        origin += jit.Array3f64(rotate(q, dr.gather(jit.Array3f, lens.start, where.ray)))
    local = local_directions(lens, where, origin, level)
    copy = dr.gather(jit.UInt32, motion.copy, where.image)
    looks = where.active & dr.gather(jit.Bool, lens.serves, where.ray)
    return Rays(
        origin=origin,
        direction=rotate(q, local),
        max_range=dr.select(looks, jit.Float(config.max_range_m), 0),
        copy=copy,
        own=dr.gather(jit.UInt32, own, copy),
    )


_Config = TypeVar("_Config", bound=ViewConfig, covariant=True)


@dataclass(frozen=True)
class Frame(Generic[_Config]):
    """One frame of a camera, for all images of a call.

    Attributes:
        lens: see `Lens`.
        motion: of the vehicle, at the moments of the images.
        own: `UInt32` `(n,)`, rows of the own hull.
        config: of the camera.
        tiling: order of the pixels.
    """

    lens: Lens
    motion: Kinematics
    own: Array
    config: _Config
    tiling: Tiling

    @property
    def images(self) -> int:
        """Their number."""
        return int(dr.width(self.motion.tick))

    def rays(self, where: Pixels, level: Array | None = None) -> Rays:
        """Rays of some pixels, see `view_rays`."""
        return view_rays(self.lens, where, self.motion, self.own, self.config, level)

    def counter(self, where: Pixels) -> tuple[Array, Array, Array]:
        """Counters of the pixels' random numbers: pixel, environment, tick."""
        index = where.row * self.tiling.width + where.column
        environment, tick = (dr.gather(jit.UInt32, v, where.image) for v in (self.motion.environment, self.motion.tick))
        return index, environment, tick


def local_directions(lens: Lens, where: Pixels, origin: Array, level: Array | None) -> Array:
    """Directions in the sensor frame, `Array3f`, of rays that start at `origin` in the world: in water or in air.

    `level`: see `view_rays`.
    """
    wet = dr.gather(jit.Array3f, lens.direction, where.ray)
    if lens.dry is None:
        return wet
    return dr.select(starts_wet(where, origin, level), wet, dr.gather(jit.Array3f, lens.dry, where.ray))


def starts_wet(where: Pixels, origin: Array, level: Array | None) -> Array:
    """`Bool`: rays start in the water; see `view_rays`."""
    height = jit.Float(origin.z)
    return height < (0 if level is None else dr.gather(jit.Float, level, where.image))
