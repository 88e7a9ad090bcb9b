"""Requests of browsers, checked, on their way to the thread that steps."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from pelagos.errors import CommandError, LookupFailed
from pelagos.math.constants import GRAVITY
from pelagos.raycast.rays import NO_BODY
from pelagos.sim.simulation import Simulation
from pelagos.viewer.drive import Axes, drive
from pelagos.viewer.pilot import Pilot
from pelagos.viewer.soundings import Soundings
from pelagos.world.body import Prop

SHAPES: Final = ("box", "sphere", "cylinder", "cone")
_CLEAR_M: Final = 2.0  # over the ground, of a way-point that was clicked
_FASTEST: Final = 100.0
_SIGHT_M: Final = 4000.0
_HIGHEST_M: Final = 15.0
_LONGEST_S: Final = 25.0
_STEEPEST: Final = 1 / 15  # significant height over the peak's wavelength (DNV-RP-C205, 3.5.5: up to 8 s)


class Orders:
    """Obeys the browsers' messages.

    Attributes:
        soundings: told when something of the water has been set; None: nobody looks.

    Args:
        pilot: what they are for.
        results: the folder that recordings go to.
    """

    def __init__(self, pilot: Pilot, results: Path) -> None:
        self._pilot, self._results = pilot, results
        self.soundings: Soundings | None = None
        self._driven: dict[str, float] = {}
        self._do: Mapping[str, Callable[[Mapping[str, Any]], object]] = {
            "pause": self._pause, "tick": lambda m: pilot.single(), "speed": self._speed, "reset": self._reset,
            "mode": self._mode, "drive": self._drive, "command": self._command, "goal": self._goal,
            "clear_goals": self._clear_goals, "goal_seen": self._goal_seen, "current": self._current,
            "waves": self._waves, "sun": self._sun, "turbidity": self._turbidity, "section": self._section,
            "spawn": self._spawn, "spawn_seen": self._spawn_seen, "move": self._move, "move_seen": self._move_seen,
            "remove": self._remove, "record": self._record,
        }  # fmt: skip

    @property
    def known(self) -> tuple[str, ...]:
        """Orders that can be given."""
        return tuple(self._do)

    def obey(self, message: Mapping[str, Any]) -> bool:
        """Have it done at the next boundary; False where it is nothing for the simulation."""
        act = self._do.get(str(message.get("do")))
        if act is None:
            return False
        self._pilot.post(lambda: act(message))
        return True

    @property
    def _sim(self) -> Simulation:
        return self._pilot.sim

    def _pause(self, m: Mapping[str, Any]) -> None:
        self._pilot.paused = bool(m.get("paused", not self._pilot.paused))

    def _speed(self, m: Mapping[str, Any]) -> None:
        speed = _number(m, "speed")
        if not 0 <= speed <= _FASTEST:
            raise CommandError(
                f"the speed is 0.1 to {_FASTEST:g} times the clock, or 0: as fast as it goes; not {speed:g}"
            )
        self._pilot.speed = speed

    def _reset(self, m: Mapping[str, Any]) -> None:
        seed = m.get("seed")
        if seed is not None and (isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63):
            raise CommandError(f"a seed is a whole number from 0 on, not {seed!r}")
        self._pilot.reset(seed)

    def _mode(self, m: Mapping[str, Any]) -> None:
        self._sim.set_mode(self._agent(m), str(m.get("mode")))

    def _drive(self, m: Mapping[str, Any]) -> None:
        agent, now = self._agent(m), time.monotonic()
        dt_s = now - self._driven.get(agent, now - 0.1)
        self._driven[agent] = now
        self._pilot.goals.pop(agent, None)
        drive(self._sim, agent, Axes.of(m), dt_s)

    def _command(self, m: Mapping[str, Any]) -> None:
        values = m.get("values")
        if not isinstance(values, list):
            raise CommandError(f"the values of a command are a list of numbers, not {values!r}")
        self._sim.command({self._agent(m): values})

    def _goal(self, m: Mapping[str, Any]) -> None:
        """A way-point at x, y; at the vehicle's depth where none is given, and not into the ground."""
        agent, x, y = self._agent(m), _number(m, "x"), _number(m, "y")
        z = -_number(m, "depth") if m.get("depth") is not None else float(self._sim.state[agent].position[0, 2])
        ground = float(self._sim.world.height(x, y))
        if math.isfinite(ground) and z < ground + _CLEAR_M:
            z = min(ground + _CLEAR_M, 0.0) if z <= 0 else z
        self._pilot.go_to(agent, np.array([x, y, z]))

    def _goal_seen(self, m: Mapping[str, Any]) -> None:
        """A way-point over what a ray of the scene meets: `eye` NWU [m] and `way`."""
        x, y, _ = self._seen(m)
        self._goal({"agent": m.get("agent"), "x": x, "y": y})

    def _clear_goals(self, m: Mapping[str, Any]) -> None:
        self._pilot.goals.pop(self._agent(m), None)

    def _current(self, m: Mapping[str, Any]) -> None:
        """Speed [m/s] and where it sets to, of the compass [deg]."""
        speed, towards = _number(m, "speed"), math.radians(_number(m, "towards_deg"))
        if not 0 <= speed <= 10:
            raise CommandError(f"the speed of the current is 0 to 10 m/s, not {speed:g}")
        self._sim.ocean.set(current=(speed * math.cos(towards), -speed * math.sin(towards), 0.0))
        self._water_changed()

    def _waves(self, m: Mapping[str, Any]) -> None:
        """One wind sea in place of all waves: significant height and period [m], [s], compass direction; 0: flat."""
        height, period, towards = _number(m, "height"), _number(m, "period"), _number(m, "towards_deg")
        if not 0 <= height <= _HIGHEST_M:
            raise CommandError(f"the height of waves is 0 to {_HIGHEST_M:g} m, not {height:g}")
        if height > 0:
            least = math.sqrt(2 * math.pi * height / (_STEEPEST * GRAVITY))
            if not least <= period <= _LONGEST_S:
                raise CommandError(
                    f"waves of {height:g} m have a peak period of {least:.1f} to {_LONGEST_S:g} s, not {period:g} s: "
                    "shorter ones break"
                )
        sea = {"type": "jonswap", "significant_height_m": height, "peak_period_s": period, "towards_deg": towards}
        self._sim.ocean.set(keys={"waves": [sea] if height > 0 else []})
        self._water_changed()

    def _sun(self, m: Mapping[str, Any]) -> None:
        """Elevation over the horizon and compass direction [deg]."""
        sun = {f"{name}_deg": _number(m, f"{name}_deg") for name in ("elevation", "azimuth")}
        self._sim.ocean.set(keys={"sun": sun})
        self._water_changed()

    def _turbidity(self, m: Mapping[str, Any]) -> None:
        self._sim.ocean.set(turbidity=_number(m, "turbidity"))
        self._water_changed()

    def _water_changed(self) -> None:
        if self.soundings is not None:
            self.soundings.changed()

    def _section(self, m: Mapping[str, Any]) -> None:
        if self.soundings is not None:
            self.soundings.ask(m.get("what"), m.get("along", "north"))

    def _spawn(self, m: Mapping[str, Any]) -> None:
        shape = str(m.get("shape", "box"))
        if shape not in SHAPES:
            raise LookupFailed("shape", shape, SHAPES)
        size = _number(m, "size") if m.get("size") is not None else 1.0
        x, y = _number(m, "x"), _number(m, "y")
        self._sim.spawn(Prop(shape, position=(x, y, self._level(m, x, y, size)), size=(size,) * 3, label="debris"))

    def _spawn_seen(self, m: Mapping[str, Any]) -> None:
        """A prop on what a ray of the scene meets."""
        x, y, z = self._seen(m)
        size = _number(m, "size") if m.get("size") is not None else 1.0
        self._spawn({**m, "x": x, "y": y, "depth": -(z + size / 2)})

    def _move(self, m: Mapping[str, Any]) -> None:
        body = self._body(m)
        x, y = _number(m, "x"), _number(m, "y")
        z = float(body.position[0, 2])
        ground = float(self._sim.world.height(x, y))
        old = float(self._sim.world.height(*body.position[0, :2]))
        if math.isfinite(ground) and math.isfinite(old):
            z += ground - old  # what lies on the ground stays on it
        self._sim.gate.settle()
        body.move(position=(x, y, z))

    def _move_seen(self, m: Mapping[str, Any]) -> None:
        """A prop to what a ray of the scene meets behind it: upon itself it would climb as long as it is dragged."""
        body = self._body(m)
        x, y, z = self._seen(m, through=int(self._sim.bodies.rows_of(body)[0]))
        above = -float(body.geometry.extent[0, 2])
        self._sim.gate.settle()
        body.move(position=(x, y, z + above))

    def _remove(self, m: Mapping[str, Any]) -> None:
        body = self._body(m)
        self._sim.gate.settle()
        body.remove()

    def _record(self, m: Mapping[str, Any]) -> None:
        if bool(m.get("on")):
            self._results.mkdir(parents=True, exist_ok=True)
            number = 1
            while (self._results / f"view-{number}.mcap").exists():
                number += 1
            self._pilot.begin_recording(self._results / f"view-{number}.mcap")
        else:
            path = self._pilot.end_recording()
            if path is not None:
                self._pilot.say(f"recorded: {path}", "note")

    def _seen(self, m: Mapping[str, Any], *, through: int = NO_BODY) -> tuple[float, float, float]:
        """Point at which a ray of the scene meets the ground, a structure or a body: `eye` NWU [m] and `way`."""
        eye, way = _vector(m, "eye"), _vector(m, "way")
        long = float(np.linalg.norm(way))
        if long == 0:
            raise CommandError("the way of a ray has a length")
        hits = self._sim.world.cast(eye[None], way[None] / long, _SIGHT_M, own_body=through)
        if not hits.valid[0]:
            raise CommandError("there is nothing under the pointer; click on the ground or a structure")
        x, y, z = (float(v) for v in hits.position[0])
        return x, y, z

    def _level(self, m: Mapping[str, Any], x: float, y: float, size: float) -> float:
        if m.get("depth") is not None:
            return -_number(m, "depth")
        ground = float(self._sim.world.height(x, y))
        return ground + size / 2 if math.isfinite(ground) else -5.0

    def _agent(self, m: Mapping[str, Any]) -> str:
        name = m.get("agent")
        if name not in self._sim.model.agents:
            raise LookupFailed("agent", str(name), self._sim.model.agents)
        return str(name)

    def _body(self, m: Mapping[str, Any]) -> Any:
        found = {b.name: b for b in self._sim.bodies.bodies if b.fastest_mps is None}
        name = str(m.get("name"))
        if name not in found:
            raise LookupFailed("prop", name, found)
        return found[name]


def _number(m: Mapping[str, Any], key: str) -> float:
    value = m.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise CommandError(f"{key} is a number, not {value!r}")
    return float(value)


def _vector(m: Mapping[str, Any], key: str) -> np.ndarray[Any, Any]:
    value = m.get(key)
    if not isinstance(value, list) or len(value) != 3:
        raise CommandError(f"{key} is three numbers, not {value!r}")
    return np.array([_number({key: v}, key) for v in value])


def plain_name(name: str) -> str:
    """A scenario's name as a folder's."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_") or "view"
