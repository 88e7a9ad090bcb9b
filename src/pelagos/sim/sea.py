"""The ocean of a simulation, and what can be set of it while a run stands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.config.loader import load_scenario
from pelagos.config.vary import TURBIDITY, WAVES
from pelagos.errors import CommandError, LookupFailed
from pelagos.ocean.config import build_ocean
from pelagos.ocean.tide import make_tide
from pelagos.sim.bodies import rows
from pelagos.sim.groups import one_agent
from pelagos.sim.model import with_changes
from pelagos.sim.set_points import vectors

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean
    from pelagos.sim.simulation import Simulation

_SCENARIO = object()
_KEYS: Final = ("sun", "weather", "water_type", "waves")


class Sea:
    """The ocean: `sim.ocean`. Its fields are those of `sim.ocean.fields`."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    @property
    def fields(self) -> Ocean:
        """Currents, waves, water masses, tracers and light as functions of place and time, on the device."""
        self._sim.stepper.in_own_water()  # simulations may share the ocean
        ocean, own = self._sim.model.ocean, self._sim.stepper.own_current
        return ocean if own is None or ocean.own is None else ocean.with_(own=own)

    def set(
        self,
        *,
        current: Any = _SCENARIO,
        turbidity: float | None = None,
        level_m: float | None = None,
        keys: Mapping[str, Any] | None = None,
        agent: str | None = None,
    ) -> None:
        """Set the current of each copy, or the turbidity, the level, the light and the waves of all.

        Args:
            current: velocity of the water NWU [m/s], `(3,)` or `(n, 3)`, everywhere in a copy and until it is set
                again, in place of the scenario's currents; None: the scenario's again, or what its `vary` draws.
                Vehicles, DVLs, ADCPs and current meters feel it; the scenario's plumes drift with the scenario's
                currents. The first time, all sensors are built anew; after that it takes no time.
            turbidity: factor on the particles of the water type, the same in all copies; sensors are built anew.
            level_m: mean height of the sea surface over z = 0 [m], about which tides go on; the first time, sensors are
                built anew.
            keys: of the scenario's `sun`, `weather`, `water_type` and `waves`, by dotted key ("weather.cloud"); sensors
                are built anew. Waves are the whole list of systems, `{"waves": [{"type": "sea_state", "state": 4}]}`: a
                system that stays in its place keeps its phases, so that crests stand where they stood.
            agent: whose current it is, where it is not that of all: vehicles in one sea may be told currents of their
                own. Where the scenario has currents, that of all is set before: the scenario's end for everybody.

        Raises:
            CommandError: a wrong shape, a value that is not finite or not allowed, or within a step or a run.
        """
        sim = self._sim
        sim.gate.refuse("ocean.set")
        if current is _SCENARIO and turbidity is None and level_m is None and not keys:
            raise CommandError("what is to be set of the ocean? Give current, turbidity, level_m or keys")
        self._refuse_drawn(turbidity, keys or {})
        if agent is not None:
            if turbidity is not None or level_m is not None or keys:
                raise CommandError("with an agent, give its current alone: the rest of the ocean is that of all")
            self._set_agent(agent, current)
            return
        ocean, scenario = sim.model.ocean, sim.scenario
        if turbidity is not None:
            if np.ndim(turbidity) or not (np.isfinite(turbidity) and 0 <= turbidity <= 1000):
                raise CommandError(f"turbidity is one number from 0 to 1000 for all copies, not {turbidity!r}")
            checked = load_scenario(scenario, overrides={"ocean.turbidity": float(turbidity)})
            scenario = scenario.model_copy(update={"ocean": checked.ocean})
            ocean = ocean.with_(turbidity=float(turbidity))
        if keys:
            scenario, ocean = self._relit(scenario, ocean, keys)
        if level_m is not None:
            ocean = self._levelled(ocean, level_m)
        own = sim.stepper.own_current
        if current is None:
            own = None
        elif current is not _SCENARIO:
            own = vectors(rows(current, sim.n, 3, "current"))
        if (own is None) != (ocean.own is None) and not sim.stepper.variety.has_current:
            ocean = ocean.with_(own=own)
        if ocean is not sim.model.ocean:
            sim.exchange(with_changes(sim.model, scenario, sim.encounters, seed=sim.seed, ocean=ocean))
        sim.stepper.own_current = own
        sim.stepper.agent_currents.clear()

    def _refuse_drawn(self, turbidity: float | None, keys: Mapping[str, Any]) -> None:
        asked = {TURBIDITY} if turbidity is not None else set()
        asked |= {"ocean.waves."} if any(key.split(".")[0] == WAVES for key in keys) else set()
        for key in self._sim.scenario.vary:
            if key.startswith(tuple(asked)):
                raise CommandError(f"the scenario draws {key} for every copy and episode; it cannot be set besides")

    def _set_agent(self, agent: str, current: Any) -> None:
        """A current of one vehicle."""
        sim = self._sim
        one_agent(sim.model, agent)
        if current is _SCENARIO or current is None:
            raise CommandError("with an agent, give its current")
        kept = dict(sim.stepper.agent_currents)
        if sim.stepper.own_current is None:
            if sim.scenario.ocean.currents:
                raise CommandError("set the current of all before that of an agent: it ends the scenario's currents")
            self.set(current=(0.0, 0.0, 0.0))
        sim.stepper.agent_currents = {**kept, agent: rows(current, sim.n, 3, "current")}

    def _relit(self, scenario: Any, ocean: Ocean, keys: Mapping[str, Any]) -> tuple[Any, Ocean]:
        """Scenario and ocean with other light, weather and waves."""
        for key in keys:
            if key.split(".")[0] not in _KEYS:
                raise CommandError(str(LookupFailed("key of the ocean that can be set", key, _KEYS)))
        checked = load_scenario(scenario, overrides={f"ocean.{key}": value for key, value in keys.items()})
        config = checked.ocean
        elevation, azimuth = config.sun.angles(self._sim.world.origin)
        weather = config.weather.weather()
        changed = ocean.with_(
            sun_elevation=dr.opaque(jit.Float, elevation), sun_azimuth=dr.opaque(jit.Float, azimuth),
            water_type=config.water_type, cloud=weather.cloud, visibility=weather.visibility, rain=weather.rain,
        )  # fmt: skip
        if any(key.split(".")[0] == "waves" for key in keys):
            sim = self._sim
            made = build_ocean(config, sim.world, seed=sim.seed, duration_s=scenario.duration_s)
            changed = changed.with_(waves=made.waves, tracers=made.tracers)  # plumes drift in the waves
        return scenario.model_copy(update={"ocean": config}), changed

    def _levelled(self, ocean: Ocean, level_m: float) -> Ocean:
        """The ocean with its surface at another mean level; the same object where it has such a level already."""
        if not np.isfinite(level_m):
            raise CommandError(f"level_m is a finite number, not {level_m!r}")
        tide = make_tide(self._sim.scenario.ocean.tide, float(level_m))
        assert tide is not None
        if ocean.tide is not None and dr.width(ocean.tide.amplitude) == dr.width(tide.amplitude):
            ocean.tide = tide
            return ocean
        return ocean.with_(tide=tide)
