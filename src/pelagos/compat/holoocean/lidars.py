"""HoloOcean's lidars."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from pelagos.compat.holoocean.sensor import HoloOceanSensor
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.motion import AgentMotion

_LIDAR: Final = frozenset(
    {
        "Channels", "Range", "PointsPerSecond", "RotationFrequency", "UpperFovLimit", "LowerFovLimit", "HorizontalFov",
        "RandomSeed", "ShowDebugPoints", "SaveWaterPoints",
    }
)  # fmt: skip


class _Lidar(HoloOceanSensor):
    """Points in the sensor's frame; an empty list at ticks at which it is not due."""

    keys = _LIDAR
    always = True
    columns: ClassVar[int] = 5

    @property
    def data_shape(self) -> Sequence[int]:
        return [0, self.columns]

    def idle(self) -> Any:
        return np.zeros((0, self.columns), dtype=np.float32)

    def scanner(self, kind: str) -> dict[str, Any]:
        """Keys of the native scanner."""
        c, rate = self.config, self.env._ticks_per_sec / self.tick_every
        channels = int(c.get("Channels", 32))
        if c.get("ShowDebugPoints"):
            self.env.advice.once("ShowDebugPoints draws nothing here")
        return {
            "type": kind,
            "channels": channels,
            "range_m": float(c.get("Range", 500)),
            "points_per_second": max(int(c.get("PointsPerSecond", 56000)), int(np.ceil(channels * rate))),
            "rotation_hz": float(c.get("RotationFrequency", 10)),
            "upper_fov_deg": float(c.get("UpperFovLimit", 10)),
            "lower_fov_deg": float(c.get("LowerFovLimit", -30)),
            "horizontal_fov_deg": float(c.get("HorizontalFov", 360)),
            "water_points": bool(c.get("SaveWaterPoints", False)),
        }


class RaycastLidar(_Lidar):
    """Points x, y, z [m], intensity, ring."""

    sensor_type = "RaycastLidar"
    keys = _LIDAR | {
        "AtmospAttenRate", "DropOffGenRate", "DropOffIntensityLimit", "DropOffAtZeroIntensity", "NoiseStdDev",
    }  # fmt: skip

    def native(self) -> dict[str, Any] | None:
        c = self.config
        rate = float(c.get("AtmospAttenRate", 0.4))
        limit = float(c.get("DropOffIntensityLimit", 0.8))
        return self.scanner("lidar") | {
            "atmosphere_attenuation_rate": rate,
            "water_attenuation_rate": rate,
            "dropoff_general_rate": float(c.get("DropOffGenRate", 0.45)),
            "dropoff_intensity_limit": max(limit, 1e-9),
            "dropoff_zero_intensity": 1.0 - float(c.get("DropOffAtZeroIntensity", 0.4)),
            "noise_stddev_m": float(c.get("NoiseStdDev", 0)),
        }

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        from pelagos.sensors.lidar.lidar import points

        assert reading is not None
        return points(reading.data[0]).astype(np.float32)


class RaycastSemanticLidar(_Lidar):
    """Points x, y, z [m], cosine of incidence, ring, object and label."""

    sensor_type = "RaycastSemanticLidar"
    columns = 7

    def native(self) -> dict[str, Any] | None:
        return self.scanner("semantic_lidar")

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        from pelagos.sensors.lidar.semantic_lidar import points

        assert reading is not None
        cloud = points(reading.data[0], reading.extras["instance"][0], reading.extras["label"][0])
        columns = ("x", "y", "z", "CosAngle", "ring", "ObjIdx", "ObjTag")
        return np.stack([cloud[name].astype(np.float32) for name in columns], axis=-1)
