"""The scenario that samples are taken with: one agent that is put from pose to pose, and cameras for its labels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from pelagos.config import registry
from pelagos.config.loader import load_scenario
from pelagos.config.scenario import Scenario
from pelagos.datasets.config import DatasetConfig
from pelagos.errors import InputError, LookupFailed, ScenarioError
from pelagos.sensors.camera.picture.camera_rays import ViewConfig
from pelagos.sim.observe import of_a_run

AIR_M: Final = 50.0  # the agent waits so far above the sea, where nothing can be in its way
LABELLERS: Final = {"depth": "depth_camera", "semantic": "semantic_camera", "instance": "instance_camera"}


@dataclass(frozen=True)
class Rig:
    """Sensors that read.

    Attributes:
        scenario: plain data; the agent waits in the air without a mission, and has the cameras of the labels.
        agent: whose sensors.
        sensors: to read, those of the labels among them.
        camera: the one that labels belong to, None where there is none.
        labels: sensors of the labels by kind ("depth", "semantic", "instance").
    """

    scenario: Mapping[str, Any]
    agent: str
    sensors: tuple[str, ...]
    camera: str | None
    labels: Mapping[str, str]

    @property
    def aim(self) -> str:
        """The sensor in whose view faced objects are."""
        return self.camera or self.sensors[0]

    def follow(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Changes of the scenario, and the same of the labels' cameras where they concern the camera's view."""
        found = dict(values)
        prefix = f"agents.{self.agent}.sensors."
        for key, value in values.items():
            name, _, rest = key.removeprefix(prefix).partition(".")
            if key.startswith(prefix) and name == self.camera and rest.split(".")[0] in ViewConfig.model_fields:
                found |= {f"{prefix}{other}.{rest}": value for other in self.labels.values()}
        return found


def rig_of(config: DatasetConfig, scenario: Scenario) -> Rig:
    """The rig of a configuration.

    Raises:
        InputError: no such agent or sensor, or a camera that labels cannot belong to.
    """
    agent = _agent(config, scenario)
    built = scenario.agents[agent].sensors
    for name in config.sensors:
        if name not in built:
            raise LookupFailed("sensor", name, built, where=f"sensors of {agent}")
    of_run = [name for name, c in built.items() if of_a_run(registry.find("sensor", c.type).load())]
    chosen = config.sensors or tuple(name for name in built if name not in of_run)
    silent = [name for name in chosen if name in of_run]
    if silent or not chosen:
        raise InputError(f"agent {agent}: {', '.join(silent) or 'it has no sensor that'} has nothing to say at a pose")
    camera = _camera(config, agent, {name: built[name] for name in chosen})
    data: dict[str, Any] = scenario.model_dump(mode="json", exclude_unset=True)
    data["seed"] = config.seed
    data.pop("bridges", None)
    own = data["agents"][agent]
    x, y = own.get("start", {}).get("position_m", (0.0, 0.0))[:2]
    own["start"] = {"position_m": [x, y, AIR_M]}
    for key in ("mission", "navigation"):
        own.pop(key, None)
    labels: dict[str, str] = {}
    if camera is not None:
        view = {k: v for k, v in own["sensors"][camera].items() if k in ViewConfig.model_fields and k != "type"}
        for kind in config.labels:
            labels[kind] = f"{camera}_{kind}"
            if labels[kind] in built:
                raise InputError(f"{agent}.{labels[kind]}: this name is that of a picture of labels; rename the sensor")
            own["sensors"][labels[kind]] = {"type": LABELLERS[kind], **view}
    others = [name for name in own["sensors"] if name not in (*chosen, *labels.values())]
    for name in others:
        del own["sensors"][name]
    return Rig(load_scenario(data, trust=True).model_dump(mode="json", exclude_unset=True), agent,
               (*chosen, *labels.values()), camera, labels)  # fmt: skip


def _agent(config: DatasetConfig, scenario: Scenario) -> str:
    if config.agent:
        if config.agent not in scenario.agents:
            raise LookupFailed("agent", config.agent, scenario.agents)
        agent = config.agent
    elif len(scenario.agents) == 1:
        agent = next(iter(scenario.agents))
    else:
        raise ScenarioError(f"the scenario has {len(scenario.agents)} agents; name one in 'agent'", where="agent")
    if scenario.agents[agent].count is not None:
        raise InputError(f"agent {agent} is a group of vehicles; a data set is seen by one: leave 'count' out")
    return agent


def _camera(config: DatasetConfig, agent: str, sensors: Mapping[str, Any]) -> str | None:
    views = [name for name, c in sensors.items() if isinstance(c, ViewConfig)]
    if config.camera is not None:
        if config.camera not in views:
            raise LookupFailed("camera", config.camera, views, where=f"sensors of {agent}")
        return config.camera
    colour = [name for name in views if sensors[name].type == "camera"]
    if colour or not {"coco", "yolo", "kitti"} & set(config.formats):
        return colour[0] if colour else None
    raise InputError(f"agent {agent} has no camera, which {', '.join(config.formats)} need")
