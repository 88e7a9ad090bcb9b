"""Readings of everything that sends packets, and payloads that it takes."""

from __future__ import annotations

import numpy as np

from pelagos.errors import ScenarioError
from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.traffic import Output
from pelagos.sensors.noise import BatchPath
from pelagos.sensors.sensor import Measurement, SensorContext


def read_port(context: SensorContext, lanes: int) -> Measurement:
    """Reading of this context's modem at the ticks that are asked for; without a simulation it is silent."""
    rows, medium = len(context.own_body), context.medium
    if medium is None or medium.traffic is None:
        return _measured([_silent(rows) for _ in range(lanes // rows)])
    paths = context.path.members if isinstance(context.path, BatchPath) else (context.path,)
    return _measured([medium.traffic.read(path, tick) for tick in medium.ticks for path in paths])


def check_payload(port: ModemPort, payload: object) -> bytes:
    """A payload as bytes.

    Raises:
        ScenarioError: it is neither bytes nor text, or longer than the device sends.
    """
    if isinstance(payload, str):
        payload = payload.encode()
    if not isinstance(payload, bytes | bytearray):
        raise ScenarioError(f"{port.path}: a payload is bytes or text, not {type(payload).__name__}")
    if len(payload) > port.packet_max_bytes:
        raise ScenarioError(f"{port.path}: a packet holds {port.packet_max_bytes} bytes; given {len(payload)}")
    return bytes(payload)


def _silent(copies: int) -> Output:
    return Output(np.zeros((copies, 5)), [[] for _ in range(copies)], [[] for _ in range(copies)])


def _measured(outputs: list[Output]) -> Measurement:
    status = np.concatenate([o.status for o in outputs])
    packets, fates = (np.empty(len(status), dtype=object) for _ in range(2))
    packets[:] = [tuple(p) for o in outputs for p in o.packets]
    fates[:] = [tuple(f) for o in outputs for f in o.fates]
    return Measurement(status, status, extras={"packets": packets, "fates": fates})
