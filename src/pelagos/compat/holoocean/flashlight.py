"""HoloOcean's flashlights: native lamps on the cameras of a vehicle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Final

from pelagos.compat.holoocean.exceptions import HoloOceanException, named
from pelagos.errors import did_you_mean

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment

NAMES: Final = ("flashlight1", "flashlight2", "flashlight3", "flashlight4")
_LUMEN: Final = 1.0  # of a unit of intensity: HoloOcean's usual 5000 are 5000 lm


@dataclass(frozen=True)
class Lamp:
    """A flashlight.

    Attributes:
        intensity: 0 to 100 000 [lm].
        beam_width: half angle of the cone, 1 to 80 [deg].
        location_x_offset, location_y_offset, location_z_offset: from its mount [m].
        angle_pitch, angle_yaw: -70 to 70 [deg], up and to the left.
        color_R, color_G, color_B: 0 to 1.
    """

    intensity: float = 5000
    beam_width: float = 45
    location_x_offset: float = 0
    location_y_offset: float = 0
    location_z_offset: float = 0
    angle_pitch: float = -30
    angle_yaw: float = 0
    color_R: float = 1
    color_G: float = 1
    color_B: float = 1

    def clamped(self) -> Lamp:
        """Within HoloOcean's limits."""
        limits = {"intensity": (0, 1e5), "beam_width": (1, 80), "angle_pitch": (-70, 70), "angle_yaw": (-70, 70)}
        limits |= dict.fromkeys(("color_R", "color_G", "color_B"), (0, 1))
        return replace(self, **{k: min(max(float(getattr(self, k)), low), high) for k, (low, high) in limits.items()})


KEYS: Final = tuple(f.name for f in fields(Lamp))


class Flashlights:
    """Those of an environment: by name for all agents, or for one."""

    def __init__(self, env: HoloOceanEnvironment) -> None:
        self._env = env
        self._on: dict[tuple[str, str | None], Lamp] = {}
        for given in env._scenario.get("flashlight") or ():
            keys = {k: v for k, v in given.items() if k in KEYS}
            env.advice.unknown("flashlight", given, [*KEYS, "flashlight_name", "agent_tag"])
            tag, known = given.get("agent_tag"), [a["agent_name"] for a in env._scenario["agents"]]
            if tag is not None and tag not in known:
                env.advice.name("flashlight: agent_tag", str(tag), known, "it lights nothing")
            self._on[_checked(given.get("flashlight_name", NAMES[0])), tag] = Lamp(**keys).clamped()

    def turn_on(self, name: str, values: Sequence[Any], keys: Mapping[str, Any], agent: str | None) -> None:
        """Light one: what is given counts, then what the scenario says, then HoloOcean's defaults.

        Raises:
            HoloOceanException, KeyError: no flashlight, or no agent, of this name.
            TypeError: an unknown key, or more numbers than a flashlight has.
        """
        if name in self._env.agents and values:  # HoloOcean 2.4 has the agent first
            agent, name, values = name, str(values[0]), values[1:]
        given = _given(values, keys)
        if agent is not None:
            named("agent", agent, self._env.agents)
        base = self._on.get((_checked(name), agent), Lamp())
        self._on[name, agent] = replace(base, **given).clamped()
        self._env._lit |= {agent} if agent else set(self._env.agents)

    def turn_off(self, name: str, agent: str | None) -> None:
        """Put one out.

        Raises:
            HoloOceanException, KeyError: no flashlight, or no agent, of this name.
        """
        _checked(name)
        if agent is not None:
            named("agent", agent, self._env.agents)
        for key in [k for k in self._on if k[0] == name and (agent is None or k[1] in (agent, None))]:
            del self._on[key]
        self._env._lit |= {agent} if agent else set(self._env.agents)

    def native(self, agent: str) -> list[dict[str, Any]]:
        """Native lamps of an agent."""
        mounts = self._env.agents[agent].kind.lamps if agent in self._env.agents else ()
        found = []
        for (name, whose), lamp in self._on.items():
            if whose not in (None, agent) or lamp.intensity <= 0:
                continue
            number = NAMES.index(name)
            place = mounts[min(number, len(mounts) - 1)] if mounts else (0.3, 0.0, 0.0)
            offset = (lamp.location_x_offset, lamp.location_y_offset, lamp.location_z_offset)
            found.append(
                {
                    "position_m": [float(p + o) for p, o in zip(place, offset, strict=True)],
                    "orientation_deg": [0.0, -lamp.angle_pitch, lamp.angle_yaw],
                    "flux_lm": lamp.intensity * _LUMEN,
                    "beam_angle_deg": min(2 * lamp.beam_width, 170.0),
                    "color": [lamp.color_R, lamp.color_G, lamp.color_B],
                }
            )
        return found


def _checked(name: str) -> str:
    if name not in NAMES:
        raise HoloOceanException(f"a flashlight is one of {', '.join(NAMES)}, not {name!r}{did_you_mean(name, NAMES)}")
    return name


def _given(values: Sequence[Any], keys: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers of a lamp by name, from those in order and those by name."""
    wrong = next((k for k in keys if k not in KEYS), None)
    if wrong is not None:
        raise TypeError(f"a flashlight has no {wrong!r}{did_you_mean(wrong, KEYS)}")
    if len(values) > len(KEYS):
        raise TypeError(f"a flashlight has {len(KEYS)} numbers, {', '.join(KEYS)}; {len(values)} given")
    return {**dict(zip(KEYS, values, strict=False)), **keys}


class FlashlightController:
    """One flashlight with a setter for each of its numbers; `set_flashlight` lights it so."""

    def __init__(self, client: Any, flashlight_name: str = NAMES[0], *values: Any, **keys: Any) -> None:
        self._env, self.flashlight_name = client, _checked(flashlight_name)
        self._keys = _given(values, keys)

    def __getattr__(self, name: str) -> Any:
        key = name.removeprefix("set_")
        if name.startswith("set_") and key in KEYS:
            return lambda value: self._keys.update({key: value})
        raise AttributeError(f"{type(self).__name__} has no {name!r}{did_you_mean(name, [f'set_{k}' for k in KEYS])}")

    def set_flashlight(self) -> None:
        """Light it."""
        self._env.turn_on_flashlight(self.flashlight_name, **self._keys)
