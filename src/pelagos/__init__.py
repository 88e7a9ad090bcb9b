"""Pelagos: a marine-robotics simulator.

    import pelagos as pl

    sim = pl.Simulation.load("scenario.yaml")
    result = sim.run(seconds=60, record="mission.mcap")

Names are imported at first use, so that `import pelagos` costs next to nothing and needs no device.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pelagos import envs as envs
    from pelagos.config.loader import load_scenario as load_scenario
    from pelagos.config.scenario import Scenario as Scenario
    from pelagos.errors import CommandError as CommandError
    from pelagos.errors import DeviceError as DeviceError
    from pelagos.errors import InputError as InputError
    from pelagos.errors import LookupFailed as LookupFailed
    from pelagos.errors import PelagosError as PelagosError
    from pelagos.errors import PelagosWarning as PelagosWarning
    from pelagos.errors import RecordingError as RecordingError
    from pelagos.errors import ScenarioError as ScenarioError
    from pelagos.errors import SimulationError as SimulationError
    from pelagos.errors import ValidityWarning as ValidityWarning
    from pelagos.errors import WorldError as WorldError
    from pelagos.sensors.sensor import Reading as Reading
    from pelagos.sim.channel import Channel as Channel
    from pelagos.sim.channel import channel as channel
    from pelagos.sim.checkpoint import Checkpoint as Checkpoint
    from pelagos.sim.replay import Recording as Recording
    from pelagos.sim.run import RunResult as RunResult
    from pelagos.sim.simulation import Simulation as Simulation
    from pelagos.vehicles.vehicle import Vehicle as Vehicle
    from pelagos.world.body import Prop as Prop
    from pelagos.world.world import World as World

    __version__: str

_HOMES = {
    "load_scenario": "pelagos.config.loader",
    "Scenario": "pelagos.config.scenario",
    "Reading": "pelagos.sensors.sensor",
    "Checkpoint": "pelagos.sim.checkpoint",
    "Channel": "pelagos.sim.channel",
    "channel": "pelagos.sim.channel",
    "Recording": "pelagos.sim.replay",
    "RunResult": "pelagos.sim.run",
    "Simulation": "pelagos.sim.simulation",
    "Vehicle": "pelagos.vehicles.vehicle",
    "Prop": "pelagos.world.body",
    "World": "pelagos.world.world",
} | dict.fromkeys(
    [
        "PelagosError", "InputError", "ScenarioError", "WorldError", "CommandError", "LookupFailed",
        "DeviceError", "SimulationError", "RecordingError", "PelagosWarning", "ValidityWarning",
    ],
    "pelagos.errors",
)  # fmt: skip

__all__ = ["__version__", "envs", *sorted(_HOMES)]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("pelagos")
    if name == "envs":
        return import_module("pelagos.envs")
    if name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
