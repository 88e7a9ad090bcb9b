"""The water around the scene, looked up by the thread that steps: arrows, a section, waves and light.

Fields are on the device, so only the stepping thread asks them: `look` is called by it with every frame, and does
nothing until something was asked for or has grown old.
"""

from __future__ import annotations

import time
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import LookupFailed
from pelagos.sim.simulation import Simulation
from pelagos.viewer.currents import arrows
from pelagos.viewer.section import WAYS, Asked, curtain, sections
from pelagos.viewer.view import View
from pelagos.viewer.water import Water

_OLD_S: Final = 3.0
"""Wall-clock time after which what varies in time and with the vehicle's place is looked up again."""
_SHALLOW_M: Final = 0.5
_NOWHERE: Final = np.array([0.0, 0.0, -2.0])


class Soundings:
    """Looks the water up for a view.

    Args:
        sim: whose.
        view: who shows it.
    """

    def __init__(self, sim: Simulation, view: View) -> None:
        self._sim, self._view = sim, view
        self._asked: Asked | None = None
        self._arrows = view.subject.currents
        self._at = time.monotonic()
        self._stale = False
        self._ocean = sim.model.ocean

    def ask(self, what: object, along: object = "north") -> None:
        """Show a section of a field from now on, or none ("off"); any thread may call this.

        Raises:
            LookupFailed: no such field, or no such direction.
        """
        if what == "off":
            self._asked = None
        else:
            known = sections(self._sim.ocean.fields)
            if what not in known:
                raise LookupFailed("section", str(what), ["off", *known])
            if along not in WAYS:
                raise LookupFailed("direction of a section", str(along), WAYS)
            self._asked = Asked(str(what), "north" if along == "north" else "east")
        self._stale = True

    def changed(self) -> None:
        """Somebody has set something of the ocean; called by the thread that steps."""
        self._ocean = self._sim.model.ocean
        self._view.show_water(water_of(self._sim))
        self._stale = True

    def look(self) -> None:
        """Renew what is shown, if it is time; in the thread that steps."""
        now = time.monotonic()
        if self._sim.model.ocean is not self._ocean:  # somebody set something of it
            self.changed()
        if not self._stale and (now - self._at < _OLD_S or not self._view.hub.count):
            return
        self._at, renew, self._stale = now, self._stale, False
        sim = self._sim
        fields, t_s, place = sim.ocean.fields, sim.time_ns * 1e-9, vehicle_place(sim)
        if renew or fields.currents or fields.own is not None:
            found = arrows(fields, sim.world, t_s, -float(place[2]))
            if not np.array_equal(found, self._arrows):
                self._arrows = found
                self._view.show_currents(found)
        asked = self._asked
        if asked is not None:
            self._view.show_section(curtain(fields, sim.world, asked, place, t_s))
        elif renew:
            self._view.show_section(None)


def vehicle_place(sim: Simulation) -> NDArray[np.float64]:
    """Place of the first vehicle `(3,)` NWU [m], under the surface; 2 m below the origin where there is none."""
    first = next(iter(sim.model.agents), None)
    if first is None:
        return _NOWHERE
    place = np.array(sim.state[first].position[0])
    place[2] = min(place[2], -_SHALLOW_M)
    return place


def water_of(sim: Simulation) -> Water:
    """The water as it is now."""
    return Water.of(sim.ocean.fields, vehicle_place(sim), sim.time_ns * 1e-9)
