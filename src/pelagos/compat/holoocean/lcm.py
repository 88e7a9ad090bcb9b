"""HoloOcean's LCM messages: package `lcm`, a structure for each sensor type, with the time in milliseconds."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.messages.lcm import HOLOOCEAN, definition, encode

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment

LANGUAGES: Final = {"c": "-c", "cpp": "-x", "java": "-j", "python": "-p", "lua": "-l", "csharp": "--csharp", "go": "-g"}
_SEEN: Final = {  # of a beacon's list, what stands behind type, sender and data
    "OWAYU": ("azimuth", "elevation"), "MSG_REQU": ("azimuth", "elevation"),
    "MSG_RESPU": ("azimuth", "elevation", "range"), "MSG_REQX": ("azimuth", "elevation", "z"),
    "MSG_RESPX": ("azimuth", "elevation", "range", "z"),
}  # fmt: skip


class SensorData:
    """The message of one sensor on its channel.

    Attributes:
        type: the sensor's.
        channel: of LCM.
        values: by field.
    """

    def __init__(self, sensor_type: str, channel: str) -> None:
        if sensor_type not in HOLOOCEAN:
            raise KeyError(f"{sensor_type} has no LCM message; there are {', '.join(HOLOOCEAN)}")
        self.type, self.channel = sensor_type, channel
        self.values: dict[str, Any] = {}
        self.timestamp = 0

    def set_value(self, timestamp: float, value: Any) -> None:
        """A sensor's value at a time [ms]."""
        self.timestamp, self.values = int(timestamp), _MAKERS.get(self.type, _plain(self.type))(value)

    def encode(self) -> bytes:
        """As LCM writes it."""
        return encode(self.type, {"timestamp": self.timestamp, **self.values})


def _plain(kind: str) -> Callable[[Any], dict[str, Any]]:
    """A structure of one field."""
    member = HOLOOCEAN[kind][1]
    return lambda value: {member.name: value if member.sizes else float(np.ravel(value)[0])}


def _dvl(value: Any) -> dict[str, Any]:
    return {"velocity": value[:3], "range": value[3:7] if len(value) == 7 else [np.nan] * 4}


def _imu(value: Any) -> dict[str, Any]:
    rows = [*value, *[[np.nan] * 3] * (4 - len(value))]
    return dict(zip((member.name for member in HOLOOCEAN["IMUSensor"][1:]), rows, strict=True))


def _beacon(value: Any) -> dict[str, Any]:
    found: dict[str, Any] = dict.fromkeys(("azimuth", "elevation", "range", "z"), float("nan"))
    found |= dict(zip(_SEEN.get(value[0], ()), value[3:], strict=False))
    return {"msg_type": value[0], "from_beacon": int(value[1]), **found}


def _ranges(value: Any) -> dict[str, Any]:
    return {"count": len(value), "distances": value, "angles": np.arange(len(value)) * 360.0 / len(value)}


_MAKERS: Final[dict[str, Callable[[Any], dict[str, Any]]]] = {
    "DVLSensor": _dvl, "IMUSensor": _imu, "AcousticBeaconSensor": _beacon, "RangeFinderSensor": _ranges,
    "RotationSensor": lambda v: dict(zip(("roll", "pitch", "yaw"), (float(a) for a in v), strict=True)),
    "ImagingSonar": lambda v: {"bins_azimuth": v.shape[1], "bins_range": v.shape[0], "image": v},
    "RGBCamera": lambda v: {"width": v.shape[1], "height": v.shape[0], "channels": v.shape[2], "image": v},
}  # fmt: skip


def gen(lang: str, path: str = ".", headers: str | None = None) -> None:
    """Write the structures as `lcm/*.lcm` below a folder, and have `lcm-gen` make a language's classes of them.

    Raises:
        HoloOceanException: an unknown language, or there is no `lcm-gen`.
    """
    import shutil
    import subprocess
    import sys

    if lang not in LANGUAGES:
        raise HoloOceanException(f"a language is one of {', '.join(LANGUAGES)}, not {lang!r}")
    beside = str(Path(sys.executable).parent)  # of an environment that is not activated
    program = shutil.which("lcm-gen") or shutil.which("lcm-gen", path=beside)
    if program is None:
        raise HoloOceanException("lcm-gen is not installed: apt install liblcm-bin, or pip install lcm")
    folder = Path(path)
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for kind in HOLOOCEAN:
        files.append(folder / f"{kind}.lcm")
        files[-1].write_text(definition(kind), encoding="utf-8")
    where = {"python": "--ppath", "cpp": "--cpp-hpath", "c": "--c-cpath", "java": "--jpath"}.get(lang)
    more = [where, str(folder)] if where else []
    subprocess.run([program, LANGUAGES[lang], *more, *map(str, files)], check=True)


def provider(url: str) -> Any:
    """A connection to LCM, "" for its usual one.

    Raises:
        HoloOceanException: the package `lcm` is not installed.
    """
    try:
        import lcm
    except ImportError as error:
        raise HoloOceanException("a sensor has an lcm_channel; install lcm: pip install 'pelagos[lcm]'") from error
    return lcm.LCM(url) if url else lcm.LCM()


def publish(connection: Any, env: HoloOceanEnvironment, state: dict[str, Any]) -> None:
    """Send the messages of the sensors that have a value in this state."""
    now = 1000.0 * env._num_ticks / env._ticks_per_sec
    for agent in env.agents.values():
        for sensor in _with_channel(agent.sensors.values()):
            if sensor.name in agent.agent_state_dict:
                sensor.lcm_msg.set_value(now, agent.agent_state_dict[sensor.name])
                connection.publish(sensor.lcm_msg.channel, sensor.lcm_msg.encode())


def _with_channel(sensors: Iterable[Any]) -> list[Any]:
    return [sensor for sensor in sensors if sensor.lcm_msg is not None]
