"""Messages of acoustic beacons and optical modems, and who has which number."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from pelagos.compat.holoocean.exceptions import named
from pelagos.compat.holoocean.messages import Media

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment

_SKIN: Final = 1e-3  # [m]


class Messaging:
    """See the module."""

    def _begin_messaging(self) -> None:
        self._stations: dict[str, dict[int, Any]] = {}
        self.media = Media(cast("HoloOceanEnvironment", self))

    def stations(self, registry: str) -> dict[int, Any]:
        """Those of one medium, "beacons" or "modems", by number."""
        return self._stations.setdefault(registry, {})

    @property
    def beacons(self) -> dict[int, Any]:
        """Acoustic beacons by number."""
        return self.stations("beacons")

    @property
    def beacons_id(self) -> list[int]:
        """Their numbers."""
        return list(self.beacons)

    @property
    def beacons_status(self) -> list[str]:
        """ "Idle" or "Transmitting", in the order of `beacons_id`."""
        return [beacon.status for beacon in self.beacons.values()]

    @property
    def modems(self) -> dict[int, Any]:
        """Optical modems by number."""
        return self.stations("modems")

    @property
    def modems_id(self) -> list[int]:
        """Their numbers."""
        return list(self.modems)

    def send_acoustic_message(self, id_from: int, id_to: Any, msg_type: str, msg_data: Any) -> None:
        """Send from a beacon to one, a list, or all others (-1 or "all")."""
        self.media.send(id_from, id_to, msg_type, msg_data)

    def send_optical_message(self, id_from: int, id_to: Any, msg_data: Any) -> None:
        """Send from an optical modem; it arrives at the next tick, or not at all."""
        self.media.shine(id_from, id_to, msg_data)

    @staticmethod
    def initialize_bst_graphs(**keys: Any) -> Any:
        """A visualiser of biomass, salinity and temperature."""
        from pelagos.compat.holoocean.bst_graph import BST_Visualizer

        return BST_Visualizer(**keys)

    def set_biomass_function(self, agent_name: str, function: Any) -> None:
        """Another field of biomass for the agent's sensor `BSTSensor`: a function of `location`."""
        self._set_field(agent_name, "biomass", function)

    def set_salinity_function(self, agent_name: str, function: Any) -> None:
        """The same for salinity."""
        self._set_field(agent_name, "salinity", function)

    def set_temperature_function(self, agent_name: str, function: Any) -> None:
        """The same for temperature."""
        self._set_field(agent_name, "temperature", function)

    def _set_field(self, agent_name: str, name: str, function: Any) -> None:
        env = cast("HoloOceanEnvironment", self)
        sensors = named("agent", agent_name, env.agents).sensors
        named(f"sensor of {agent_name}", "BSTSensor", sensors).fields[name] = function  # type: ignore[attr-defined]

    def sees(self, agent: str, start: Any, other: str, end: Any) -> bool:
        """Whether the way between two points on two agents is free: the first thing met is the other agent, or the
        point itself."""
        sim = cast("HoloOceanEnvironment", self).pelagos
        line = np.asarray(end, dtype=np.float64) - start
        distance = float(np.linalg.norm(line))
        if distance < _SKIN:
            return True
        hulls = sim.bodies.hulls
        own = hulls.get(cast("HoloOceanEnvironment", self).native_name(agent))
        target = hulls.get(cast("HoloOceanEnvironment", self).native_name(other))
        at, left = np.asarray(start, dtype=np.float64), distance - _SKIN
        for _ in range(8):  # out through the sender's own hull
            hit = sim.world.cast(at[None], (line / distance)[None], left)
            if not hit.valid[0] or (target is not None and hit.instance[0] == target.instance):
                return True
            if own is None or hit.instance[0] != own.instance:
                return False
            step = float(hit.t[0]) + _SKIN
            at, left = at + line / distance * step, left - step
            if left <= 0:
                return True
        return False
