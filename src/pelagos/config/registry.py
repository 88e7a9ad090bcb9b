"""Registry of components: the class for each `type:` in a scenario.

A table names each class as a string, "module:Class", imported at first use: the registry stands at the bottom of the
layers and knows the others by name only. Other packages add to a table through entry points of the groups
`pelagos.sensors`, `pelagos.worlds` and so on; a name of theirs may not replace one of ours.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Final, Literal, TypeAlias

from pydantic import BaseModel

from pelagos.errors import InputError, LookupFailed

Kind: TypeAlias = Literal["sensor", "vehicle", "world", "ocean", "bridge"]

BUILT_IN: Final[Mapping[Kind, Mapping[str, str]]] = {
    "sensor": {
        "adcp": "pelagos.sensors.sonar.adcp:Adcp",
        "altimeter": "pelagos.sensors.sonar.altimeter:Altimeter",
        "camera": "pelagos.sensors.camera.camera:Camera",
        "collision": "pelagos.sensors.navigation.collision:Collision",
        "ctd": "pelagos.sensors.water.ctd:Ctd",
        "current_meter": "pelagos.sensors.water.current_meter:CurrentMeter",
        "depth": "pelagos.sensors.navigation.depth:Depth",
        "depth_camera": "pelagos.sensors.camera.depth_camera:DepthCamera",
        "dvl": "pelagos.sensors.sonar.dvl:Dvl",
        "event_camera": "pelagos.sensors.camera.event_camera:EventCamera",
        "fluorometer": "pelagos.sensors.water.fluorometer:Fluorometer",
        "gps": "pelagos.sensors.navigation.gps:Gps",
        "imaging_sonar": "pelagos.sensors.sonar.imaging_sonar:ImagingSonar",
        "imu": "pelagos.sensors.navigation.imu:Imu",
        "incidence_sonar": "pelagos.sensors.sonar.incidence_sonar:IncidenceSonar",
        "instance_camera": "pelagos.sensors.camera.instance_camera:InstanceCamera",
        "lidar": "pelagos.sensors.lidar.lidar:Lidar",
        "magnetometer": "pelagos.sensors.navigation.magnetometer:Magnetometer",
        "mechanical_scanning_sonar": "pelagos.sensors.sonar.mechanical_scanning_sonar:MechanicalScanningSonar",
        "hydrophone": "pelagos.sensors.comms.hydrophone:Hydrophone",
        "lbl": "pelagos.sensors.comms.lbl:Lbl",
        "usbl": "pelagos.sensors.comms.usbl:Usbl",
        "ais": "pelagos.sensors.comms.ais:Ais",
        "optical_modem": "pelagos.sensors.comms.optical_modem:OpticalModem",
        "radio": "pelagos.sensors.comms.radio:RadioLink",
        "range_bearing": "pelagos.sensors.comms.range_bearing:RangeBearing",
        "range_finder": "pelagos.sensors.lidar.range_finder:RangeFinder",
        "modem": "pelagos.sensors.comms.modem:Modem",
        "multibeam": "pelagos.sensors.sonar.multibeam:Multibeam",
        "normal_camera": "pelagos.sensors.camera.normal_camera:NormalCamera",
        "optical_flow_camera": "pelagos.sensors.camera.optical_flow_camera:OpticalFlowCamera",
        "oxygen": "pelagos.sensors.water.oxygen:Oxygen",
        "pose": "pelagos.sensors.navigation.pose:Pose",
        "profiling_sonar": "pelagos.sensors.sonar.profiling_sonar:ProfilingSonar",
        "semantic_camera": "pelagos.sensors.camera.semantic_camera:SemanticCamera",
        "semantic_lidar": "pelagos.sensors.lidar.semantic_lidar:SemanticLidar",
        "sidescan": "pelagos.sensors.sonar.sidescan:Sidescan",
        "singlebeam": "pelagos.sensors.sonar.singlebeam:Singlebeam",
        "sound_velocity": "pelagos.sensors.water.sound_velocity:SoundVelocity",
        "synthetic_aperture_sonar": "pelagos.sensors.sonar.synthetic_aperture_sonar:SyntheticApertureSonar",
        "thermal_camera": "pelagos.sensors.camera.thermal_camera:ThermalCamera",
        "tracer": "pelagos.sensors.water.tracer:Tracer",
        "turbidity": "pelagos.sensors.water.turbidity:Turbidity",
        "velocity": "pelagos.sensors.navigation.velocity:Velocity",
    },
    "world": {
        "bathymetry": "pelagos.world.bathymetry.bathymetry:BathymetryConfig",
        "built": "pelagos.world.built:BuiltConfig",
        "classic": "pelagos.world.classic:ClassicConfig",
        "flat": "pelagos.world.generate.flat:FlatConfig",
        "generated": "pelagos.world.generate.generated:GeneratedConfig",
        "harbour": "pelagos.world.generate.harbour:HarbourConfig",
        "large": "pelagos.world.large.large:LargeConfig",
        "saved": "pelagos.world.export:SavedConfig",
    },
    "ocean": {"standard": "pelagos.ocean.config:OceanConfig"},
    "bridge": {
        "ardupilot": "pelagos.bridges.ardupilot:ArdupilotConfig",
        "foxglove": "pelagos.bridges.foxglove_transport:FoxgloveConfig",
        "instrument": "pelagos.bridges.instrument:InstrumentConfig",
        "lcm": "pelagos.bridges.lcm_transport:LcmConfig",
        "mavlink": "pelagos.bridges.mavlink:MavlinkConfig",
        "moos": "pelagos.bridges.moos:MoosConfig",
        "px4": "pelagos.bridges.px4:Px4Config",
        "ros2": "pelagos.bridges.ros2:Ros2Config",
        "rosbridge": "pelagos.bridges.rosbridge:RosbridgeConfig",
    },
    "vehicle": {"custom": "pelagos.vehicles.config:VehicleConfig"},
}

# Tables that also have one entry for each file of a catalogue: (module with its names and data, target).
CATALOGUES: Final[Mapping[Kind, tuple[str, str]]] = {
    "vehicle": ("pelagos.vehicles.load", "pelagos.vehicles.config:VehicleConfig"),
}

_CUSTOM: Final = "A vehicle of your own: start from nothing and write every key"


@dataclass(frozen=True)
class Entry:
    """One name of a table.

    Attributes:
        kind: the table.
        name: what a scenario calls it.
        target: "module:attribute".
        package: distribution that brought it; empty for our own.
    """

    kind: Kind
    name: str
    target: str
    package: str = ""

    def load(self) -> Any:
        """Import the component.

        Raises:
            InputError: a plug-in's module cannot be imported.
        """
        module, _, attribute = self.target.partition(":")
        try:
            return getattr(import_module(module), attribute)
        except (ImportError, AttributeError) as error:
            if not self.package:
                raise
            raise InputError(
                f"{self.kind} {self.name!r} of the package {self.package} cannot be loaded: {error}"
            ) from error

    @property
    def config(self) -> type[BaseModel]:
        """The component's configuration: the class itself where it is one, else its attribute `Config`."""
        component = self.load()
        if isinstance(component, type) and issubclass(component, BaseModel):
            return component
        config: type[BaseModel] = component.Config
        return config

    @property
    def title(self) -> str:
        """One line about the component: its `TITLE`, or the first line of its docstring."""
        catalogue = _catalogue(self.kind)
        if catalogue is not None and self.name in catalogue.catalogue_names():
            return str(catalogue.catalogue_data(self.name).get("title", ""))
        if (self.kind, self.name) == ("vehicle", "custom"):
            return _CUSTOM
        component = self.load()
        title = str(getattr(component, "TITLE", None) or (component.__doc__ or "").strip().split("\n")[0])
        return title[:1].upper() + title[1:]


def entries(kind: Kind, *, plugins: bool = True) -> dict[str, Entry]:
    """Every entry of a table by name, sorted; with those of installed plug-ins unless told otherwise."""
    own = _own(kind, tuple(BUILT_IN[kind].items()))
    brought = _plugins(kind) if plugins else {}
    return dict(sorted({**brought, **own}.items())) if brought else dict(own)


def find(kind: Kind, name: str) -> Entry:
    """One entry of a table.

    Raises:
        LookupFailed: no component has this name; the message names the nearest.
    """
    known = entries(kind)
    if name not in known:
        raise LookupFailed(kind, name, known)
    return known[name]


@cache
def _own(kind: Kind, built_in: tuple[tuple[str, str], ...]) -> Mapping[str, Entry]:
    """Entries that are not of plug-ins, sorted."""
    found = {name: Entry(kind, name, target) for name, target in built_in}
    catalogue = _catalogue(kind)
    if catalogue is not None:
        found |= {name: Entry(kind, name, CATALOGUES[kind][1]) for name in catalogue.catalogue_names()}
    return dict(sorted(found.items()))


def _catalogue(kind: Kind) -> Any:
    return import_module(CATALOGUES[kind][0]) if kind in CATALOGUES else None


@cache
def _plugins(kind: Kind) -> Mapping[str, Entry]:
    group = f"pelagos.{kind}s"
    return {
        point.name: Entry(kind, point.name, point.value, point.dist.name if point.dist else point.value)
        for point in entry_points(group=group)
    }
