"""HoloOcean's sonars, octree, ray-cast and GPU forms alike: the native ray-cast sonars in HoloOcean's shapes.

Rows are ranges from the nearest, columns azimuths from right to left. `"physics": "holoocean"` asks for the simple
model of intensity by incidence and impedance; without it echoes interfere, spread and are absorbed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException
from pelagos.compat.holoocean.sensor import HoloOceanSensor
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.motion import AgentMotion

_COMMON: Final = frozenset(
    {
        "RangeMin", "RangeMax", "RangeBins", "RangeRes", "AddSigma", "AddCov", "MultSigma", "MultCov", "WaterDensity",
        "WaterSpeedSound", "WaterSoundSpeed", "ViewRegion", "ViewRays", "ViewPoints", "IgnorePlants", "ShowWarning",
        "physics",
    }
)  # fmt: skip
_OCTREE: Final = frozenset(
    {"InitOctreeRange", "ShadowEpsilon", "UseApprox", "ViewOctree", "ElevationBins", "ElevationRes"}
)
_RAYS: Final = frozenset(
    {
        "AzimuthRayCount", "AzimuthRayRes", "ElevationRayCount", "ElevationRayRes", "AzimuthRays", "ElevationRays",
        "ResolutionX", "OpeningAngleRays", "OpeningAngleRes", "OpeningAngleRayRes", "CentralAngleRays",
        "CentralAngleRes", "CentralAngleEuclidian", "OpeningAngleBins", "CentralAngleBins",
    }
)  # fmt: skip
_SECTOR: Final = frozenset(
    {
        "Azimuth", "Elevation", "AzimuthBins", "AzimuthRes", "RangeSigma", "MultiPath", "ClusterSize", "ScaleNoise",
        "AzimuthStreaks",
    }
)  # fmt: skip
_LOOKS_DOWN: Final = (0.0, -90.0, 0.0)
"""HoloOcean's boresight x is the native -z: its x, y, z are the native -z, y, x."""
_SLOWEST_SOUND: Final = 1400.0  # [m/s], for echoes that must be back before the next ping
_LOUD_DB: Final = 280.0  # so loud that the sea and the receiver are not heard: noise is what the keys ask for
_STREAKS: Final = {-1: "dark", 0: "none", 1: "bright"}


class _Sonar(HoloOceanSensor):
    """Ranges and noise of every sonar."""

    nearest: ClassVar[float] = 0.5
    farthest: ClassVar[float] = 10.0
    default_bins: ClassVar[int] = 200
    azimuth: ClassVar[float] = 120.0

    def setup(self) -> None:
        c = self.config
        self.low, self.high = float(c.get("RangeMin", self.nearest)), float(c.get("RangeMax", self.farthest))
        self.fastest_hz = _SLOWEST_SOUND / (2 * self.high)
        rate = self.env._ticks_per_sec / self.tick_every
        if rate > self.fastest_hz:
            self.env.advice.once(
                f"{self.agent_name}.{self.name}: at {rate:g} pings a second the sound of one ping is still under way "
                f"when the next goes out; from {self.high:g} m on, {self.fastest_hz:.3g} Hz are possible"
            )
        self.bins = _count(c, "Range", self.high - self.low, self.default_bins, self)
        known = [k for k in c if k in _OCTREE or (k in _RAYS)]
        if known:
            self.env.advice.once(
                f"{self.agent_name}.{self.name}: {', '.join(sorted(known))}: no octree is needed and rays are counted "
                "here by themselves; these keys change nothing"
            )
        if "WaterSoundSpeed" in c:
            self.env.advice.once(
                "WaterSoundSpeed, as one of HoloOcean's examples writes it, is taken as WaterSpeedSound"
            )
        physics = c.get("physics", "pelagos")
        if physics not in ("pelagos", "holoocean"):
            raise HoloOceanConfigurationException(f"physics is 'pelagos' or 'holoocean', not {physics!r}")
        self.simple = physics == "holoocean"
        if self.simple:
            self.extra = (0.0, 0.0, 0.0)  # type: ignore[misc]
            idle = [k for k in ("AzimuthStreaks", "ClusterSize", "MultiPath") if c.get(k)]
            if idle:
                self.env.advice.once(
                    f"{self.agent_name}.{self.name}: {', '.join(idle)}: the simple intensity of physics 'holoocean' "
                    "has no reflections and no streaks; these keys change nothing (without 'physics' they do)"
                )
        elif c.get("ClusterSize"):
            self.env.advice.once(
                f"{self.agent_name}.{self.name}: ClusterSize changes nothing: reflections are traced ray by ray"
            )
        for one, other in (("AddSigma", "AddCov"), ("MultSigma", "MultCov")):
            if one in c and other in c:
                raise ValueError(f"give either {one} or {other}, not both")

    @property
    def speed(self) -> float | None:
        """Of sound, as the sonar believes [m/s]."""
        given = self.config.get("WaterSpeedSound", self.config.get("WaterSoundSpeed"))
        return None if given is None else float(given)

    def _sigma(self, name: str) -> float:
        c = self.config
        return float(c[f"{name}Sigma"]) if f"{name}Sigma" in c else math.sqrt(float(c.get(f"{name}Cov", 0.0)))

    def pinged(self, kind: str, **keys: Any) -> dict[str, Any]:
        """Keys of the native sonar."""
        c = self.config
        noise: dict[str, Any] = {"additive": self._sigma("Add"), "multiplicative": self._sigma("Mult")}
        noise["range_m"] = float(c.get("RangeSigma", 0.0))
        noise["azimuth_streaks"] = _STREAKS[int(c.get("AzimuthStreaks", 0))]
        made: dict[str, Any] = {"type": kind, "bins": self.bins, "range_min_m": self.low, "range_max_m": self.high}
        made["source_level_db"] = _LOUD_DB
        made |= keys
        if any(v not in (0.0, "none") for v in noise.values()):
            made["painted_noise"] = noise | {"onto": "level"}
        if c.get("MultiPath"):
            made["multipath"] = "surface_and_bottom"
        if self.speed is not None:
            made["sound_speed_mps"] = self.speed
        return made

    def simply(
        self, azimuth: float, elevation: float, columns: int, *, cone: bool = False, gain: float = 1.0
    ) -> dict[str, Any]:
        """Keys of the native sonar with HoloOcean's simple intensity."""
        c = self.config
        return {
            "type": "incidence_sonar", "bins": self.bins, "range_min_m": self.low, "range_max_m": self.high,
            "horizontal_aperture_deg": azimuth, **({} if cone else {"vertical_aperture_deg": elevation}),
            "beams": columns, "cone": cone,
            "density_kg_m3": float(c.get("WaterDensity", 997)), "sound_speed_mps": self.speed or 1480.0,
            "additive": self._sigma("Add"), "multiplicative": self._sigma("Mult"),
            "range_error_m": float(c.get("RangeSigma", 0.0)), "gain": gain,
            "scale_noise": bool(c.get("ScaleNoise", False)),
        }  # fmt: skip


def _count(config: Any, name: str, span: float, default: int, sensor: HoloOceanSensor, res: float | None = None) -> int:
    """Bins, as such or by their width."""
    given, width = config.get(f"{name}Bins"), config.get(f"{name}Res")
    if given is not None and width is not None:
        raise ValueError(f"{sensor.agent_name}.{sensor.name}: give either {name}Bins or {name}Res, not both")
    if given is not None:
        return int(given)
    if width is None and res is not None:
        width = res
    return default if width is None else max(round(span / float(width) - 1e-9), 1)


class ImagingSonar(_Sonar):
    """`(ranges, azimuths)`."""

    sensor_type = "ImagingSonar"
    keys = _COMMON | _OCTREE | _RAYS | _SECTOR
    nearest, farthest, default_bins = 0.1, 10.0, 512
    default_columns: ClassVar[int] = 512
    elevation: ClassVar[float] = 20.0
    kind: ClassVar[str] = "imaging_sonar"

    def setup(self) -> None:
        super().setup()
        self.sector = float(self.config.get("Azimuth", self.azimuth))
        self.height = float(self.config.get("Elevation", self.elevation))
        self.columns = _count(self.config, "Azimuth", self.sector, self.default_columns, self)

    @property
    def data_shape(self) -> Sequence[int]:
        return [self.bins, self.columns]

    def native(self) -> dict[str, Any] | None:
        if self.simple:
            return self.simply(self.sector, self.height, self.columns, gain=0.5)
        width = max(self.sector / self.columns, 0.2)
        return self.pinged(
            self.kind, beams=self.columns, horizontal_aperture_deg=self.sector, vertical_beamwidth_deg=self.height,
            beamwidth_deg=min(width, 20.0),
        )  # fmt: skip

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        image = reading.data[0].T
        return np.ascontiguousarray(image[:, ::-1], dtype=np.float32)


class ProfilingSonar(ImagingSonar):
    """`(ranges, azimuths)` of a thin fan."""

    sensor_type = "ProfilingSonar"
    nearest, farthest, default_bins, default_columns, elevation = 0.5, 75.0, 750, 480, 1.0
    kind = "profiling_sonar"


class SidescanSonar(_Sonar):
    """`[ranges]` of both sides: the farthest left first, straight ahead of the boresight in the middle."""

    sensor_type = "SidescanSonar"
    keys = _COMMON | _OCTREE | _RAYS | frozenset({"Azimuth", "Elevation", "AzimuthBins", "AzimuthRes", "RangeSigma"})
    nearest, farthest, azimuth = 0.5, 35.0, 170.0
    extra = _LOOKS_DOWN
    sides: ClassVar[int] = 2

    def setup(self) -> None:
        super().setup()
        self.sector = float(self.config.get("Azimuth", self.azimuth))
        if "RangeBins" not in self.config:
            self.bins = _count(self.config, "Range", self.high - self.low, 0, self, res=0.05)

    @property
    def data_shape(self) -> Sequence[int]:
        return [self.bins]

    def native(self) -> dict[str, Any] | None:
        width = float(self.config.get("Elevation", 0.25))
        if self.simple:
            return self.simply(self.sector, width, self.sides) | {"bins": max(-(-self.bins // self.sides), 8)}
        side = self.sector / self.sides
        made = self.pinged(
            "sidescan", beamwidth_deg=width, vertical_beamwidth_deg=min(side, 90.0), depression_deg=90 - side / 2
        )
        return made | {"bins": max(-(-self.bins // self.sides), 8)}

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        left, right = reading.data[0]
        half = self.bins // 2
        return np.concatenate([left[: self.bins - half][::-1], right[:half]]).astype(np.float32)


class SinglebeamSonar(_Sonar):
    """`[ranges]` of a cone about the boresight."""

    sensor_type = "SinglebeamSonar"
    keys = _COMMON | _OCTREE | _RAYS | frozenset({"OpeningAngle", "RangeSigma"})
    extra = _LOOKS_DOWN

    @property
    def data_shape(self) -> Sequence[int]:
        return [self.bins]

    def native(self) -> dict[str, Any] | None:
        width = float(self.config.get("OpeningAngle", 30.0))
        return (
            self.simply(width, width, 1, cone=True) if self.simple else self.pinged("singlebeam", beamwidth_deg=width)
        )

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        return np.array(reading.data[0].reshape(-1), dtype=np.float32)


class RaycastImagingSonar(ImagingSonar):
    """As `ImagingSonar`."""

    sensor_type = "RaycastImagingSonar"


class GPUImagingSonar(ImagingSonar):
    """As `ImagingSonar`."""

    sensor_type = "GPUImagingSonar"


class RaycastProfilingSonar(ProfilingSonar):
    """As `ProfilingSonar`."""

    sensor_type = "RaycastProfilingSonar"


class GPUProfilingSonar(ProfilingSonar):
    """As `ProfilingSonar`."""

    sensor_type = "GPUProfilingSonar"


class RaycastSidescanSonar(SidescanSonar):
    """`[ranges]` of one side, the nearest first; the sector lies about the boresight."""

    sensor_type = "RaycastSidescanSonar"
    azimuth = 85.0
    sides = 1

    def setup(self) -> None:
        super().setup()
        if not self.simple:
            self.extra = (0.0, -90.0, -self.sector / 2)  # type: ignore[misc]

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        return np.array(reading.data[0][0][: self.bins], dtype=np.float32)


class GPUSidescanSonar(RaycastSidescanSonar):
    """As `RaycastSidescanSonar`."""

    sensor_type = "GPUSidescanSonar"


class RaycastSinglebeamSonar(SinglebeamSonar):
    """As `SinglebeamSonar`."""

    sensor_type = "RaycastSinglebeamSonar"


class GPUSinglebeamSonar(SinglebeamSonar):
    """As `SinglebeamSonar`."""

    sensor_type = "GPUSinglebeamSonar"


class SemanticRaycastSinglebeamSonar(SinglebeamSonar):
    """`(ranges, 5)`: intensity, then label and intensity of the strongest echo; the second pair stays 0.

    With `UseIds` `(ranges, 7)`: label, instance and intensity instead.
    """

    sensor_type = "SemanticRaycastSinglebeamSonar"
    keys = SinglebeamSonar.keys | frozenset({"UseTags", "UseIds"})

    @property
    def data_shape(self) -> Sequence[int]:
        return [self.bins, 7 if self.config.get("UseIds") else 5]

    def setup(self) -> None:
        super().setup()
        if self.config.get("UseTags") and self.config.get("UseIds"):
            raise HoloOceanConfigurationException("give either UseTags or UseIds, not both")
        if self.simple:
            self.env.advice.once(
                f"{self.agent_name}.{self.name}: physics 'holoocean' has no labels; it changes nothing"
            )
        self.simple, self.extra = False, _LOOKS_DOWN  # type: ignore[misc]

    def native(self) -> dict[str, Any] | None:
        return self.pinged("singlebeam", beamwidth_deg=float(self.config.get("OpeningAngle", 30.0)), labels=True)

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        levels, found = reading.data[0], np.zeros(self.data_shape, dtype=np.float32)
        found[:, 0], found[:, 1] = levels, reading.extras["label"][0]
        if self.config.get("UseIds"):
            found[:, 2], found[:, 3] = reading.extras["instance"][0], levels
        else:
            found[:, 2] = levels
        return found
