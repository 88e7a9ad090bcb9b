"""Nothing is accepted that is then ignored: each key of a sensor changes what it reads, or is refused or warned of.

Each sensor that is named below reads a small sea with a wall, a mover, waves, wind, a current, layers and a neighbour,
before and after one of its keys has moved away from what it is. A key counts as heard if it makes a difference in any
of the sensor's settings (see `sensor_settings`).
"""

from __future__ import annotations

import hashlib
import re
import warnings
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from other_values import others
from pydantic import ValidationError
from sensor_settings import DEAF, SETTINGS, UNTAKEN, UNTRIED
from test_every_sensor import SMALL

import pelagos as pl
from known import SINGLE, check
from pelagos.config import registry
from pelagos.errors import PelagosError
from pelagos.sim.observe import of_a_run

QUICK = (
    "depth", "gps", "incidence_sonar", "instance_camera", "normal_camera", "optical_flow_camera", "pose",
    "semantic_camera", "semantic_lidar", "thermal_camera", "velocity",
)  # fmt: skip
SLOW = (
    "adcp", "ais", "altimeter", "camera", "collision", "ctd", "current_meter", "depth_camera", "dvl", "event_camera",
    "fluorometer", "hydrophone", "imaging_sonar", "imu", "lbl", "lidar", "magnetometer", "mechanical_scanning_sonar",
    "modem", "multibeam", "optical_modem", "oxygen", "profiling_sonar", "radio", "range_bearing", "range_finder",
    "sidescan", "singlebeam", "sound_velocity", "synthetic_aperture_sonar", "tracer", "turbidity", "usbl",
)  # fmt: skip
"""Sensors that are held to it."""
LOOSE = ("singlebeam", "synthetic_aperture_sonar")
"""Phases of echoes that overlap follow what little single precision finds otherwise on another processor."""
TICKS = 9
LOUD: Mapping[str, Any] = {"radiated_noise": {"type": "thrusters", "level_db": 170.0}}
SIDEWAYS = ("sidescan", "synthetic_aperture_sonar")
SONARS = (*SIDEWAYS, "imaging_sonar", "mechanical_scanning_sonar", "profiling_sonar", "singlebeam", "multibeam")
"""Sensors that hear the noise of vehicles."""
WAVY = (*SIDEWAYS, "imaging_sonar", "mechanical_scanning_sonar", "profiling_sonar")
"""Sensors that are tried under waves."""
WAVES: Mapping[str, Any] = {
    "waves": {"type": "regular", "height_m": 0.4, "period_s": 3.1, "towards_deg": 115.0, "phase_deg": 40.0}
}
LINKED = {"ais": "ais", "modem": "modem", "optical_modem": "optical_modem", "radio": "radio", "usbl": "modem"}
"""Sensors that tell what others sent, and who sends."""
CARRIED: Mapping[str, dict[str, Any]] = {
    "optical_modem": {"orientation_deg": [3.0, -4.0, 44.0]},  # towards the other
    "usbl": {"interrogate": ["auv1.its"], "interrogate_s": 1.5, "bit_rate_bps": 4000.0},  # answers come in time
}
PARTNER: Mapping[str, dict[str, Any]] = {
    "optical_modem": {"orientation_deg": [0.0, 2.0, -96.0]},
    "usbl": {"device": "x150", "bit_rate_bps": 4000.0},
    "singlebeam": {"orientation_deg": [0.0, 75.0, 0.0], "beamwidth_deg": 50.0},  # towards the other
    "imaging_sonar": {"orientation_deg": [0.0, 2.0, -96.0], "rays_per_beam": 24},
    "profiling_sonar": {
        "orientation_deg": [0.0, 2.0, -96.0],
        "vertical_beamwidth_deg": 20.0,
        "beams": 16,
        "bins": 32,
        "rays_per_beam": 8,
    },
    "mechanical_scanning_sonar": {"orientation_deg": [0.0, 2.0, -96.0], "sector_deg": 4.0, "bins": 32, "rays": 64},
    "sidescan": {"orientation_deg": [0.0, 2.0, -6.0], "beamwidth_deg": 20.0, "bins": 32, "rays_per_side": 64},
    "synthetic_aperture_sonar": {"orientation_deg": [0.0, 2.0, 174.0], "bins": 128, "rays": 256, "range_max_m": 8.2},
    "incidence_sonar": {"beams": 4, "bins": 8},
}
LINKED_TICKS = 120
AIS_TICKS = 300  # the first report comes within 10 s


def water(value: float) -> list[dict[str, Any]]:
    """A field that changes with all coordinates and time."""
    return [
        {"type": "profile", "depth_m": [0.0, 3.1, 9.0], "value": [value, 1.3 * value, 0.7 * value]},
        {"type": "gradient", "per_m": 0.011 * value, "towards_deg": 25.0},
    ]


def own(name: str, config: Mapping[str, Any]) -> dict[str, Any]:
    """The sensor under test, as its vehicle carries it: off every axis."""
    here = {"position_m": [0.3, 0.1, 1.4 if name in ("ais", "radio") else 0.4], "orientation_deg": [3.0, -4.0, 5.0]}
    return {"type": name, "rate_hz": 10, **here, **SMALL.get(name, {}), **CARRIED.get(name, {}), **config}


def sea(name: str, config: Mapping[str, Any]) -> dict[str, Any]:
    """One vehicle with the sensor, one with what answers it."""
    surfaced = name in ("gps", "ais", "radio", "thermal_camera")
    depth = 0.0 if surfaced else 3.0
    middle = -2.0 if surfaced else -6.0  # of the wall, which stands out of the water for who looks over it
    place = [4.4, -3.6] if name == "collision" else [0.0, 0.0]  # bow before the wall
    partner = {**own(LINKED.get(name, name), {}), "position_m": [0.2, 0.0, 1.2 if surfaced else 0.4]}
    partner |= PARTNER.get(name, {})
    if name == "modem" and "chirp_order" in config:  # which only those hear who send by it
        partner["modulation"] = "chirp"
    return {
        "seed": 11,
        "tick_rate_hz": 20,
        "world": {
            "type": "flat",
            "depth_m": 8.0,
            "things": [{"shape": "box", "at_m": [6.0, -5.0, middle], "size_m": [2.0, 1.0, 9.0]}],
            "movers": [{"name": "drum", "body": "cylinder", "size_m": 1.0, "path": {
                "kind": "waypoints", "points_m": [[5.0, -1.0, -3.0], [4.0, -2.0, -3.5]], "speed_mps": 0.5}}],
        },
        "ocean": {
            "temperature_c": water(12.0),
            "salinity": water(30.0),
            "tracers": {"chlorophyll": water(2.0), "oxygen": water(240.0), "turbidity": water(1.5)},
            "currents": [{"type": "uniform", "speed_mps": 0.2, "towards_deg": 70.0}],
            "wind": {"speed_mps": 6.0, "from_deg": 200.0},
        },
        "agents": {
            "auv0": {
                "vehicle": "remus100",
                "start": {"position_m": place, "depth_m": depth, "heading_deg": 40.0},
                "control": "depth_heading",
                "command": [depth + 1.0, 0.9, 700.0],
                "sensors": {"it": own(name, config)},
                **(LOUD if name in SONARS else {}),
            },
            "auv1": {
                "vehicle": "remus100",
                "start": {"position_m": [14.0, 1.0], "depth_m": depth + 0.5, "heading_deg": 80.0},
                "control": "depth_heading",
                "command": [depth + 1.0, 0.9, 700.0],
                "sensors": {"its": partner},
                **(LOUD if name in SONARS else {}),
            },
        },
    }  # fmt: skip


def tried_in(name: str, config: Mapping[str, Any]) -> dict[str, Any]:
    """The sea in which keys are tried."""
    scenario = sea(name, config)
    scenario["ocean"] |= WAVES if name in WAVY else {}
    return scenario


class Bench:
    """A sensor in the midst of a run of its sea, where it is exchanged and asked again about the same motions."""

    def __init__(self, name: str, base: Mapping[str, Any]) -> None:
        config = registry.entries("sensor", plugins=False)[name].config.model_validate(own(name, base))
        self.numbers: Any = None  # of what was measured last
        self.base = {key: value for key, value in config.model_dump(mode="json").items() if key != "type"}
        self.sim = pl.Simulation.load(tried_in(name, base))
        self.motions: list[tuple[Any, Mapping[str, Any]]] = []  # own, and everybody's at that time
        self.neighbours = self.sim.stepper.sensing._encounters.neighbours
        sensor = self.sensor
        sense = sensor.sense
        sensor.sense = lambda motion: (self.motions.append((motion, self.around())), sense(motion))[1]
        self.sim.reset()
        for _ in range(TICKS):
            self.sim.step()
        sensor.sense = sense

    @property
    def sensor(self) -> Any:
        return self.sim.model.agents["auv0"].sensors["it"].sensor

    def around(self) -> dict[str, Any]:
        """Motions at the time of a reading: a run forgets them as it goes on."""
        return {agent: self.neighbours.motion_of(agent) for agent in self.sim.model.agents}

    def read(self) -> Iterator[Any]:
        """What the sensor measures at the motions."""
        for motion, around in self.motions:
            self.neighbours.motion_of, self.neighbours.motions_of = around.__getitem__, None
            yield self.sensor.sense(motion)

    def digest(self, keys: Mapping[str, Any]) -> str | None:
        """Of the readings with some keys changed; None if that is refused or warned of."""
        found = hashlib.blake2b(digest_size=8)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            try:
                self.sim.set("auv0.it", **(self.base | keys))
                if idle(told):
                    return None
                measured = list(self.read())
            except (PelagosError, ValidationError):
                return None
        self.numbers = np.concatenate([told_apart(m.data) for m in measured])
        for m in measured:
            for values in (m.data, m.truth, m.valid, *m.extras.values(), *m.tables.values()):
                if values is not None:
                    found.update(str(np.shape(values)).encode() + np.ascontiguousarray(values).tobytes())
        return None if idle(told) else found.hexdigest()


def told_apart(data: Any) -> Any:
    """Values end to end, components by weights of their own, so that those that changed places are seen."""
    parts = np.shape(data)[-1] if np.ndim(data) > 1 else 1
    return np.ravel(data * (1.0 + 0.25 * np.arange(parts)) if 1 < parts < 8 else data)


def idle(told: list[warnings.WarningMessage]) -> bool:
    """Whether somebody was warned that a key changes nothing."""
    return any("changes nothing" in str(w.message) for w in told)


def ticks_of(name: str) -> int:
    """Until something is told."""
    if name in LINKED:
        return AIS_TICKS if name == "ais" else LINKED_TICKS
    return 7 * TICKS if name == "collision" else TICKS


def said(sim: pl.Simulation, tick: int) -> bytes:
    """What one gives to send at a tick, in turn, and what came of it."""
    once, back = ("auv0", "it", b"of six", "*"), ("auv1", "its", b"!", "*")
    packets = {
        3: [once, once], 30: [("auv0", "it", b"", "auv1.its", "request")], 50: [back],
        80: [("auv0", "it", b"?", "auv1.its")], 100: [("auv1", "its", b"?", "3")],
    }  # fmt: skip
    try:
        return bytes(
            sim.send(agent, it, what, to=to, kind=(*kind, "data")[0])
            for agent, it, what, to, *kind in packets.get(tick, ())
        )
    except PelagosError as error:
        return str(error).encode()


def rounded(text: str) -> bytes:
    """A text with its numbers to nine digits: what is turned into a frame and back differs in the last ones."""
    return re.sub(r"\d+\.\d+(e[-+]\d+)?", lambda found: f"{float(found[0]):.9g}", text).encode()


def run(name: str, config: Mapping[str, Any], numbers: list[Any] | None = None) -> str | None:
    """A digest of a run from its start; None if the configuration is refused or warned of. Data go into `numbers`."""
    digest = hashlib.blake2b(digest_size=8)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            sim = pl.Simulation.load(tried_in(name, config))
            if idle(told):
                return None
            obs = sim.reset()
            for tick in range(ticks_of(name)):
                for reading in (*obs["auv0"].values(), *obs["auv1"].values()):
                    digest.update(reading.t_ns.to_bytes(8, "little"))
                    if numbers is not None and reading.data.dtype != object:
                        numbers.append(np.ravel(reading.data))
                    for values in (reading.data, reading.truth, *reading.extras.values()):
                        whole = values.dtype != object
                        digest.update(np.ascontiguousarray(values).tobytes() if whole else rounded(repr(values)))
                if name in LINKED and name != "ais":
                    digest.update(said(sim, tick))
                obs = sim.step()
        except (PelagosError, ValidationError):
            return None
    return None if idle(told) else digest.hexdigest()


class Runs:
    """The same by whole runs, of sensors that only a run tells of."""

    def __init__(self, name: str, base: Mapping[str, Any]) -> None:
        self.about, self.numbers = (name, base), np.zeros(0)

    def digest(self, keys: Mapping[str, Any]) -> str | None:
        """Of a run with some keys changed; None if that is refused or warned of."""
        name, base = self.about
        found: list[Any] = []
        digest = run(name, {**base, **keys}, found)
        self.numbers = np.concatenate([np.zeros(1), *found])
        return digest


def deaf(name: str, numbers: dict[str, Any]) -> list[str]:
    """Keys of a sensor that change nothing, neither at given motions nor in a run; data of each go into `numbers`.

    Keys of which no other value is known are told too, as `sensor.key?`, and those that all settings refuse, as
    `sensor.key!`.
    """
    entry = registry.entries("sensor", plugins=False)[name]
    schema = entry.config.model_json_schema()
    by_runs = name in LINKED or of_a_run(entry.load())
    silent: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {}
    heard: set[str] = set()
    tried: set[str] = set()
    known = {"type", *UNTRIED.get(name, ())}
    for k, setting in enumerate(SETTINGS.get(name, ({},))):
        bench = (Runs if by_runs else Bench)(name, setting)
        full = entry.config.model_validate(own(name, setting)).model_dump(mode="json")
        plain = bench.digest({})
        assert plain is not None, f"{name}: {setting} is refused"
        numbers[f"{k}"] = bench.numbers
        for key, value in full.items():
            if key == "type":
                continue
            for path, moved in others(schema["properties"].get(key, {}), schema.get("$defs", {}), value):
                at = f"{key}{path}"
                if moved != value:
                    tried.add(at)
                    known.add(key)
                settled = at in heard or (at in silent and f"{name}.{at}" in DEAF)
                found = plain if settled or moved == value else bench.digest({key: moved})
                if found not in (plain, None):
                    numbers[f"{k} {at}"] = bench.numbers
                    heard.add(at)
                elif found == plain and moved != value:
                    silent.setdefault(at, (setting, {key: moved}))
    left = {at: about for at, about in silent.items() if at not in heard}
    if not by_runs:
        left = {at: (setting, key) for at, (setting, key) in left.items() if not differs(name, setting, key)}
    refused = (f"{at}!" for at in tried - heard - {*silent} if name not in UNTAKEN)
    unknown = (f"{key}?" for key in {*schema["properties"]} - known)
    return sorted(f"{name}.{at}" for at in (*left, *refused, *unknown))


def differs(name: str, setting: Mapping[str, Any], changed: Mapping[str, Any]) -> bool:
    """Whether a run with a key changed is another."""
    found = run(name, {**setting, **changed})
    return found is not None and found != run(name, setting)


def test_every_sensor_is_held_to_it() -> None:
    assert {*QUICK, *SLOW} == set(registry.entries("sensor", plugins=False)), "give it a place in SLOW"


@pytest.mark.filterwarnings("ignore:.*leaves out the noise:pelagos.errors.ValidityWarning")
@pytest.mark.parametrize("name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW)])
def test_every_key_of_a_sensor_changes_what_it_reads_as_known(name: str) -> None:
    numbers: dict[str, Any] = {}
    found = deaf(name, numbers)
    check("keys_of_sensors", name, numbers, 1e-2 if name in LOOSE else SINGLE)
    assert found == sorted(at for at in DEAF if at.startswith(f"{name}."))
