"""The ocean of a simulation, and what can be set of it while a run stands."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pelagos.config.loader import load_scenario
from pelagos.errors import CommandError
from pelagos.sim.bodies import rows
from pelagos.sim.model import with_changes
from pelagos.sim.set_points import vectors

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean
    from pelagos.sim.simulation import Simulation

_SCENARIO = object()


class Sea:
    """The ocean: `sim.ocean`. Its fields are those of `sim.ocean.fields`."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    @property
    def fields(self) -> Ocean:
        """Currents, waves, water masses, tracers and light as functions of place and time, on the device."""
        return self._sim.model.ocean

    def set(self, *, current: Any = _SCENARIO, turbidity: float | None = None) -> None:
        """Set the current of each copy, or the turbidity of all.

        Args:
            current: velocity of the water NWU [m/s], `(3,)` or `(n, 3)`, everywhere in a copy and until it is set
                again, in place of the scenario's currents; None: the scenario's again. Vehicles, DVLs, ADCPs and
                current meters feel it; the scenario's plumes drift with the scenario's currents. The first time, all
                sensors are built anew; after that it takes no time.
            turbidity: factor on the particles of the water type, the same in all copies; sensors are built anew.

        Raises:
            CommandError: a wrong shape, a value that is not finite or not allowed, or within a step or a run.
        """
        sim = self._sim
        sim.gate.refuse("ocean.set")
        if current is _SCENARIO and turbidity is None:
            raise CommandError("what is to be set of the ocean? Give current or turbidity")
        ocean, scenario = sim.model.ocean, sim.scenario
        if turbidity is not None:
            if np.ndim(turbidity) or not (np.isfinite(turbidity) and 0 <= turbidity <= 1000):
                raise CommandError(f"turbidity is one number from 0 to 1000 for all copies, not {turbidity!r}")
            checked = load_scenario(scenario, overrides={"ocean.turbidity": float(turbidity)})
            scenario = scenario.model_copy(update={"ocean": checked.ocean})
            ocean = ocean.with_(turbidity=float(turbidity))
        own = sim.stepper.own_current
        if current is None:
            own = None
        elif current is not _SCENARIO:
            own = vectors(rows(current, sim.n, 3, "current"))
        if (own is None) != (ocean.own is None):
            ocean = ocean.with_(own=own)
        if ocean is not sim.model.ocean:
            sim.exchange(with_changes(sim.model, scenario, sim.encounters, seed=sim.seed, ocean=ocean))
        sim.stepper.own_current = own
