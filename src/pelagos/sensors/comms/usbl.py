"""An ultra-short baseline: a modem with an array, which finds where packets come from and how far away."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.acoustics.bearing import array_rank, direction_of
from pelagos.sensors.comms.link.devices import Device
from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.packet import Packet
from pelagos.sensors.comms.modem import Modem, ModemConfig
from pelagos.sensors.idle_keys import Need
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig

Place = tuple[float, float, float]
Alignment = Annotated[float, Field(ge=0, le=30)]


class UsblConfig(ModemConfig):
    """A transceiver with an array; figures where not given are those of its `device`."""

    type: Literal["usbl"] = "usbl"  # type: ignore[assignment]
    """The sensor's kind."""
    device: str = "x150"
    """See `modem`."""
    elements_m: Annotated[tuple[Place, ...], Field(min_length=3)] = (
        (0.02, 0.0, 0.0),
        (-0.02, 0.0, 0.0),
        (0.0, 0.02, 0.0),
        (0.0, -0.02, 0.0),
        (0.0, 0.0, 0.025),
    )  # fmt: skip
    """Elements of the array in the sensor frame [m]: three or more, not on one line."""
    bearing_noise_deg: float = Field(default=1.0, ge=0, le=30)
    """Standard deviation of a bearing across the way to the sender, in each of both directions, besides noise and
    echoes [deg]: phases of the elements, beam former, motion sensor."""  # assumed: as of x150
    range_noise_m: float = Field(default=0.05, ge=0)
    """Standard deviation of the range of a response, besides noise and clock: detection of pulses [m]."""  # as above
    alignment_std_deg: tuple[Alignment, Alignment, Alignment] = (0.0, 0.0, 0.0)
    """Standard deviations of constant turns of the array about x, y and z of the sensor frame, drawn once a run [deg]:
    what calibration leaves of the mounting; sheets leave it out."""
    interrogate: tuple[str, ...] = ()
    """Modems that it asks for their range in turn: "agent.modem", or an agent with one modem."""
    interrogate_s: float = Field(default=2.0, gt=0)
    """Time between two such requests [s]."""

    @classmethod
    def _keys_of(cls, device: Device) -> Mapping[str, Any]:
        return {**device.keys, **device.array}

    @model_validator(mode="after")
    def _spread(self) -> UsblConfig:
        if array_rank(np.array(self.elements_m)) < 2:
            raise ValueError("elements_m lie on one line: their phases leave the bearing around it open; spread them")
        return self


class Usbl(Modem):
    """Ranges and bearings of modems that answer, and bearings of all packets.

    Reading: as of a modem; packets have `azimuth_rad` and `elevation_rad` in the sensor frame, responses `range_m`.
    Extras: `fix` `(n, 3)`, place of the last responder in the sensor frame [m], NaN without a response since the
    reading before; `fix_of` `(n,)` objects, its name.
    """

    Config: ClassVar[type[SensorConfig]] = UsblConfig
    TITLE: ClassVar[str] = "Ultra-short baseline: range and bearing of modems that answer"
    SOURCES: ClassVar[tuple[str, ...]] = (
        *Modem.SOURCES,
        "P. H. Milne, Underwater Acoustic Positioning Systems, 1983, Chapter 5 (ultra-short baselines)",
        "H. L. Van Trees, Optimum Array Processing, 2002, Section 8.4 (bound of a bearing)",
        "Kongsberg, HiPAP 501/451/351/101, Product description 317748/F, Sections 9 and 11 (errors that levels leave)",
    )

    NEEDS: ClassVar[tuple[Need, ...]] = (*Modem.NEEDS, Need(("interrogate_s",), "interrogate"))
    _config: UsblConfig

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the transceiver on every lane of `motion`."""
        found = super().sense(motion)
        fixes, names = np.full((len(found.data), 3), np.nan), np.full(len(found.data), "", dtype=object)
        for lane, packets in enumerate(found.extras["packets"]):
            for packet in packets:
                if packet.kind == "response" and math.isfinite(packet.range_m):
                    fixes[lane], names[lane] = place_of(packet), packet.sender
        return replace(found, extras={**found.extras, "fix": fixes, "fix_of": names})

    def _array(self) -> NDArray[np.float64] | None:
        return np.array(self._config.elements_m)

    def _port(self) -> ModemPort:
        return replace(super()._port(), interrogate=self._config.interrogate, interrogate_s=self._config.interrogate_s)


def place_of(packet: Packet) -> NDArray[np.float64]:
    """Place of a responder in the sensor frame [m], from range and bearing."""
    return packet.range_m * direction_of(packet.azimuth_rad, packet.elevation_rad)
