"""The outbox of a simulation: packets that a user gives to a modem."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pelagos.errors import CommandError, LookupFailed, ScenarioError
from pelagos.math.so3 import rotate_np
from pelagos.sensors.comms.link.packet import BROADCAST, Kind
from pelagos.sensors.comms.link.reading import check_payload

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation


_KINDS: Final = ("data", "request")  # the others are the protocol's own


def send(
    sim: Simulation, agent: str, modem: str, payload: bytes | str, to: str, kind: Kind, tag: str,
    acknowledge: bool | None, where: Sequence[int] | None,
) -> int:  # fmt: skip
    """See `Simulation.send`."""
    if agent not in sim.model.agents:
        raise LookupFailed("agent", agent, sim.model.agents)
    medium, path = sim.medium, f"{agent}.{modem}"
    if path not in medium.modems:
        own = [p.split(".")[1] for p in medium.modems if p.split(".")[0] == agent]
        raise LookupFailed(f"modem of {agent}", modem, own)
    if kind not in _KINDS:
        raise LookupFailed("kind of packet to send", str(kind), _KINDS)
    port = medium.modems[path]
    receiver = to if to == BROADCAST else medium.find(str(to))
    if receiver == path:
        raise CommandError(f"{path}: a modem does not send to itself")
    if receiver != BROADCAST and not medium.modems[receiver].understands(port):
        raise CommandError(f"{receiver} does not understand {path}: another band, bit rate or modulation")
    try:
        content = check_payload(port, payload)
    except ScenarioError as error:
        raise CommandError(error.message) from None
    if not port.holds(len(content), kind):
        took = port.duration_s(len(content), kind)
        raise CommandError(
            f"{path}: {len(content)} bytes take {took:.3g} s; slot_s {port.slot_s:g} less guard_s {port.guard_s:g} "
            "does not hold them"
        )
    copies = range(sim.n) if where is None else [int(c) for c in where]
    if any(not 0 <= c < sim.n for c in copies):
        raise CommandError(f"copies of this fleet are 0 to {sim.n - 1}; given {list(copies)}")
    state = sim.state[agent]
    arm = np.tile(np.array(port.mount.position_m), (sim.n, 1))
    height = state.position[:, 2] + rotate_np(state.attitude, arm)[:, 2] - medium.level(sim.time_ns * 1e-9)
    if port.kind == "radio" and all(height[c] < 0.0 for c in copies):
        raise CommandError(f"{path} is {-height[copies[0]]:.2g} m under water; radio sends above it")
    if port.kind != "radio" and all(height[c] > 0.0 for c in copies):
        raise CommandError(f"{path} is {height[copies[0]]:.2g} m above the water; a modem sends under it")
    if all(-height[c] > port.depth_max_m for c in copies):
        raise CommandError(f"{path} is {-height[copies[0]]:.4g} m deep; its housing stands {port.depth_max_m:g} m")
    asked = port.acknowledge if acknowledge is None else acknowledge
    return sim.stepper.traffic.send(
        path, receiver, content, kind=kind, tag=tag, now_ns=sim.time_ns,
        acknowledge=bool(asked) and receiver != BROADCAST, where=copies,
    )  # fmt: skip
