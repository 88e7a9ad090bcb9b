"""Check of what a scenario lets differ among its copies' sensors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pelagos.config.vary import ERROR, LAMPS, MOUNT, TURBIDITY, parse
from pelagos.errors import ScenarioError
from pelagos.sensors.camera.picture.surroundings import LitViewConfig
from pelagos.sensors.comms.optical_modem import OpticalModemConfig
from pelagos.sim.observe import of_a_run

if TYPE_CHECKING:
    from pelagos.config.scenario import Scenario
    from pelagos.sim.batch import SensorModel


def check_sensors(scenario: Scenario, agent: str, sensors: Mapping[str, SensorModel]) -> None:
    """Check of what is to vary of an agent's sensors.

    Raises:
        ScenarioError: it cannot vary.
    """
    if TURBIDITY in scenario.vary:
        for name, model in sensors.items():
            if isinstance(model.config, OpticalModemConfig):
                text = f"{TURBIDITY} cannot differ from copy to copy: {agent}.{name} sends through one water"
                raise ScenarioError(text, where=scenario.where("vary"))
    for key, draw in scenario.vary.items():
        varied = parse(key)
        if (varied.agent, varied.group) != (agent, "sensors"):
            continue
        model = sensors[varied.name]
        if varied.number == ERROR and not getattr(model.sensor, "ERRS", False):
            why = "readings are not a truth and an error that adds to it"
        elif varied.number in MOUNT and of_a_run(model.sensor):
            why = "others know its place too"
        elif varied.number == LAMPS and not _shines(model.config):
            why = "no lamps or lasers are written, which a factor would be on"
        elif varied.number == LAMPS and draw.below_zero:
            why = "there is no less than no light"
        elif varied.number == ERROR and draw.below_zero:
            why = "an error is drawn with either sign already: its factor is 0 or more"
        else:
            continue
        raise ScenarioError(
            f"{key} cannot differ from copy to copy: of the type {model.config.type}, {why}",
            where=scenario.where("vary"),
        )


def _shines(config: object) -> bool:
    """True of a camera with lamps or lasers."""
    return isinstance(config, LitViewConfig) and bool(config.lamps or config.lasers)
