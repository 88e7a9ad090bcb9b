"""Numbers of a scenario that are drawn anew for every copy of a fleet and every episode."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from pydantic_core import PydanticCustomError

from pelagos.errors import did_you_mean

if TYPE_CHECKING:
    from pelagos.config.agent import Agent

ANGLES: Final = ("roll_deg", "pitch_deg", "heading_deg")
AXES: Final = 3
STARTS: Final = (*(f"position_m.{i}" for i in range(AXES)), *ANGLES, "speed_mps")
MOUNT: Final = tuple(f"{key}.{i}" for key in ("position_m", "orientation_deg") for i in range(AXES))
ERROR: Final = "error"
LAMPS: Final = "lamps"
_OF_SENSORS: Final = (*MOUNT, ERROR, LAMPS)
PROPS: Final = "props"
CURRENTS: Final = tuple(f"ocean.current_mps.{i}" for i in range(AXES))
_FORMS: Final = (
    "'agents.NAME.start.heading_deg', 'agents.NAME.factors.mass', 'agents.NAME.sensors.SENSOR.position_m.0', "
    "'agents.NAME.sensors.SENSOR.error', 'agents.NAME.sensors.CAMERA.lamps', 'props.NAME.position_m.0' or "
    "'ocean.current_mps.0'"
)


@dataclass(frozen=True)
class Varied:
    """Number that a key of `vary` names: agent, `start`, `factors` or `sensors`, and the number in it; of the ocean and
    of props, no agent; of a sensor or a prop, its name.
    """

    agent: str
    group: str
    number: str
    name: str = ""


def parse(key: str) -> Varied:
    """A key of `vary`.

    Raises:
        PydanticCustomError: no such key.
    """
    if key in CURRENTS:
        return Varied("", "current", key.rpartition(".")[2])
    first, _, rest = key.partition(".")
    agent, _, rest = rest.partition(".")
    if first == PROPS and agent and rest:
        if rest not in MOUNT:
            raise _unknown(key, f"props.{agent}.", MOUNT)
        return Varied("", PROPS, rest, agent)
    group, _, number = rest.partition(".")
    if first != "agents" or not agent or group not in ("start", "factors", "sensors") or not number:
        text = (
            "'{key}' cannot differ from copy to copy; {forms} can. Whole runs differ by `pelagos sweep` and `dataset`"
        )
        raise PydanticCustomError("vary", text, {"key": key, "forms": _FORMS})
    if group == "start" and number not in STARTS:
        raise _unknown(key, f"agents.{agent}.start.", STARTS)
    if group == "sensors":
        sensor, _, number = number.partition(".")
        if number not in _OF_SENSORS:
            raise _unknown(key, f"agents.{agent}.sensors.{sensor}.", _OF_SENSORS)
        return Varied(agent, group, number, sensor)
    return Varied(agent, group, number)


def check(keys: Collection[str], agents: Mapping[str, Agent], props: Collection[str]) -> None:
    """Check that the agents and props of a scenario have what is to vary.

    Raises:
        PydanticCustomError: they have not.
    """
    for key in keys:
        varied = parse(key)
        if varied.group == PROPS and varied.name not in props:
            text = "there is no 'props.{prop}'{meant}"
            meant = did_you_mean(varied.name, props)
            raise PydanticCustomError("vary", text, {"prop": varied.name, "meant": meant})
        if not varied.agent:
            continue
        if varied.agent not in agents:
            text = "there is no 'agents.{agent}'; known: {known}"
            raise PydanticCustomError("vary", text, {"agent": varied.agent, "known": ", ".join(agents)})
        if agents[varied.agent].count is not None:
            text = "{agent} is a group of agents, whose members differ by 'distributions'"
            raise PydanticCustomError("vary", text, {"agent": varied.agent})
        if varied.group == "sensors" and varied.name not in agents[varied.agent].sensors:
            known = [f"agents.{varied.agent}.sensors.{name}." for name in agents[varied.agent].sensors]
            meant = did_you_mean(f"agents.{varied.agent}.sensors.{varied.name}.", known)
            text = "'{agent}' has no sensor '{sensor}'{meant}"
            raise PydanticCustomError("vary", text, {"agent": varied.agent, "sensor": varied.name, "meant": meant})


def _unknown(key: str, before: str, known: Collection[str]) -> PydanticCustomError:
    meant = did_you_mean(key, [before + name for name in known])
    return PydanticCustomError("vary", "there is no '{key}'{meant}", {"key": key, "meant": meant})
