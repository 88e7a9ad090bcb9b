"""The traffic of one run: packets that wait, that are in the water, and what became of them, tick by tick.

Time goes on when the first modem that is due at a tick reads; all that are due act together, so that the order of
agents does not matter. Each copy of a fleet has its own packets and its own numbers, drawn from streams named by the
modem, the purpose, the environment and the packet.
"""

from __future__ import annotations

import copy as copies_of
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.modulation import arrival_time_error
from pelagos.math.so3 import rotate_back_np
from pelagos.sensors.comms.link.array_error import reported_bearing, reported_range
from pelagos.sensors.comms.link.budget import (
    NOTHING,
    HeardSignal,
    measured_direction,
    same_waveform_db,
    success,
    sum_db,
)
from pelagos.sensors.comms.link.chance import Chance, Episodes
from pelagos.sensors.comms.link.medium import ModemPose, SharedMedium
from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.packet import BROADCAST, Fate, Incoming, Kind, Outgoing, Packet, Reception, Transmission
from pelagos.sensors.comms.link.station import SECOND, Station, answer, next_to_send

_REPORTS_S: Final = 10.0  # within which those that report by themselves begin
_ASKED: Final = 64  # requests whose answers are still turned into ranges
_KEPT_NS: Final = 30 * SECOND  # for which packets are kept that may have disturbed others


@dataclass
class Output:
    """Output of a modem at a tick: `(n, 5)` queued, transmitting, received, sent, noise; packets and fates by copy."""

    status: NDArray[np.float64]
    packets: list[list[Packet]]
    fates: list[list[Reception]]


class Traffic:
    """See the module's docstring.

    Attributes:
        tick: the last one that was worked through.
    """

    def __init__(self, medium: SharedMedium, episodes: Episodes) -> None:
        self._medium, self._chance = medium, Chance(lambda: medium.seed, episodes)
        self._ports: list[ModemPort] = list(medium.modems.values())
        self._index = {p.path: k for k, p in enumerate(self._ports)}
        self.clear()

    def clear(self) -> None:
        """Time begins anew."""
        n = self._medium.copies
        self.tick = -1
        self._numbers = [0] * n
        self._stations = [[Station() for _ in range(n)] for _ in self._ports]
        self._incoming: list[Incoming] = []
        self._done: list[Incoming] = []
        self._cache: dict[tuple[int, int, int], Any] = {}
        self._outputs: dict[int, Output] = {}
        self._noise: dict[int, float] = {}

    def forget(self, where: NDArray[np.bool_], tick: int) -> None:
        """Some copies begin anew at a tick."""
        for c in np.flatnonzero(where).tolist() if self._ports else ():
            self._numbers[c] = 0
            for stations in self._stations:
                stations[c] = Station(begin_ns=tick * self._medium.dt_ns)
            for out in self._outputs.values():
                out.status[c, :4], out.packets[c], out.fates[c] = 0.0, [], []
        self._incoming = [i for i in self._incoming if not where[i.transmission.copy]]
        self._done = [i for i in self._done if not where[i.transmission.copy]]
        self._cache = {pair: link for pair, link in self._cache.items() if not where[pair[2]]}

    def send(
        self, sender: str, to: str, payload: bytes, *, kind: Kind = "data", tag: str = "", now_ns: int,
        acknowledge: bool, where: Sequence[int],
    ) -> int:  # fmt: skip
        """Give a packet to a modem in some copies; how many of them had room in their queue."""
        k, taken = self._index[sender], 0
        for c in where:
            station = self._stations[k][c]
            if len(station.queue) < self._ports[k].queue:
                station.queue.append(
                    Outgoing(kind, to, payload.decode("latin-1"), tag, now_ns, acknowledge=acknowledge)
                )
                taken += 1
        return taken

    def read(self, path: str, tick: int) -> Output:
        """Output of a modem at a tick; the first one that asks takes all others along."""
        if tick > self.tick:
            self._work(tick)
        return self._outputs[self._index[path]]

    # one tick

    def _work(self, tick: int) -> None:
        now, n = tick * self._medium.dt_ns, self._medium.copies
        self.tick = tick
        due = [k for k, port in enumerate(self._ports) if tick % port.period == 0]
        for k in due:
            self._outputs[k] = Output(np.zeros((n, 5)), [[] for _ in range(n)], [[] for _ in range(n)])
        self._finish(now, tick)
        started: list[tuple[int, int, Outgoing, int]] = []
        for k in due if tick > 0 else ():  # tick 0 is not always read
            for c in range(n):
                self._beacon(k, c, now)
                chosen = self._next(k, c, now)
                if chosen is not None:
                    started.append((k, c, *chosen))
        if started:
            self._transmit(started, now)
        self._report(due, now)

    def _beacon(self, k: int, c: int, now: int) -> None:
        """Traffic of the scenario: a packet every so often, the first ones spread over the period by address."""
        port, station = self._ports[k], self._stations[k][c]
        if port.report is not None:
            if station.next_ns == 0:  # not all at once
                station.next_ns = 1 + round(_REPORTS_S * self._chance.uniform(port.path, "report", c) * SECOND)
            while station.begin_ns + station.next_ns <= now:
                said, pause = port.report(port, self._medium.pose(port.path), c, station.beacon)
                varied = 0.95 + 0.1 * self._chance.uniform(port.path, f"report {station.beacon}", c)
                station.beacon += 1
                station.next_ns += max(round(varied * pause * SECOND), 1)
                if len(station.queue) < port.queue:
                    station.queue.append(Outgoing("data", BROADCAST, said.decode("latin-1"), "", now))
        if port.interrogate:
            period = round(port.interrogate_s * SECOND)
            while station.begin_ns + station.round * period <= now:
                to = self._medium.find(port.interrogate[station.round % len(port.interrogate)])
                station.round += 1
                if len(station.queue) < port.queue:
                    station.queue.append(Outgoing("request", to, "", "", now))
        if port.beacon_s is None:
            return
        period = round(port.beacon_s * SECOND)
        first = period * (port.address % max(len(self._ports), 1)) // max(len(self._ports), 1)
        while station.begin_ns + first + station.beacon * period <= now:
            station.beacon += 1
            if len(station.queue) < port.queue:
                to = BROADCAST if port.beacon_to == BROADCAST else self._medium.find(port.beacon_to)
                content = bytes(port.beacon_bytes).decode("latin-1")
                station.queue.append(Outgoing("data", to, content, "", now, acknowledge=port.acknowledge))

    def _next(self, k: int, c: int, now: int) -> tuple[Outgoing, int] | None:
        station = self._stations[k][c]
        if not (station.queue or station.replies or station.pending):
            return None
        port = self._ports[k]
        purpose = f"wait {station.draws}"
        return next_to_send(
            station, port, now, channel_busy=lambda: self._hears(k, c, now),
            draw=lambda: self._chance.uniform(port.path, purpose, c),
        )  # fmt: skip

    def _hears(self, k: int, c: int, now: int) -> bool:
        port = self._ports[k]
        return any(
            i.receiver == k and i.transmission.copy == c and i.start_ns <= now < i.end_ns
            and i.level_db > i.noise_db + port.detection_db
            for i in self._incoming
        )  # fmt: skip

    # into the water

    def _transmit(self, started: list[tuple[int, int, Outgoing, int]], now: int) -> None:
        sent: list[Transmission] = []
        poses: dict[int, ModemPose] = {}
        level = self._medium.level(now * 1e-9)
        for k, c, outgoing, start in started:
            port, station = self._ports[k], self._stations[k][c]
            poses.setdefault(k, self._medium.pose(port.path))
            outgoing.number = self._numbers[c]
            self._numbers[c] += 1
            end = start + round(port.duration_s(len(outgoing.payload), outgoing.kind) * SECOND)
            station.sending = [s for s in station.sending if s[1] > now - _KEPT_NS] + [[start, end]]
            station.sent += 1
            clock = self.clock(k, c, start)
            if outgoing.kind == "request":
                station.asked = {**dict(list(station.asked.items())[1 - _ASKED :]), outgoing.number: clock}
            depth = level - float(poses[k].position[c, 2])
            sent.append(Transmission(outgoing.number, outgoing, k, c, start, end, clock, depth))
        for kind in sorted({self._ports[t.sender].kind for t in sent}):
            self._spread([t for t in sent if self._ports[t.sender].kind == kind], poses, now, level)

    def _spread(self, sent: Sequence[Transmission], poses: dict[int, ModemPose], now: int, level: float) -> None:
        """Transmissions of one kind on their way to all that may hear them."""
        pairs, which = [], []
        for t in sent:
            sender = self._ports[t.sender]
            for r, port in enumerate(self._ports):
                apart = abs(port.frequency_hz - sender.frequency_hz)
                near = apart < 0.5 * (port.bandwidth_hz + sender.bandwidth_hz)
                if r != t.sender and port.kind == sender.kind and near:
                    poses.setdefault(r, self._medium.pose(port.path))
                    pairs.append((t.sender, r, t.copy))
                    which.append(t)
        if not pairs:
            return
        self._medium.place()
        carrier = self._ports[sent[0].sender].carrier
        if carrier is None:
            lag = [(now - t.start_ns) * 1e-9 for t in which]
            heard = self._medium.hear(pairs, poses, now * 1e-9, self._cache, lag)
        else:
            level = math.inf
            ends = [(p, self._ports[p[0]].carrier, self._ports[p[1]].carrier) for p in pairs]
            heard = [sends.hear(p, poses, now * 1e-9, hears) for p, sends, hears in ends if sends is not None]
        for t, (_, r, c), h in zip(which, pairs, heard, strict=True):
            self._incoming.append(self._coming(t, r, c, h, poses, level))

    def _coming(
        self, t: Transmission, r: int, c: int, h: HeardSignal, poses: Mapping[int, ModemPose], level: float
    ) -> Incoming:
        port, sender = self._ports[r], self._ports[t.sender]
        if r not in self._noise:
            self._noise[r] = self._quiet(port)
        dry = poses[r].position[c, 2] > level or poses[t.sender].position[c, 2] > level
        crushed = any(level - poses[k].position[c, 2] > p.depth_max_m for k, p in ((r, port), (t.sender, sender)))
        lost = "in air" if dry else "too deep" if crushed else h.lost
        if not port.understands(sender):
            lost = lost or "foreign"
        azimuth = elevation = math.nan
        if port.array is not None and h.waves is not None and not lost:
            snr = h.level_db - self._noise[r]
            gain = port.bandwidth_hz * port.preamble_s
            normals = self._chance.normals(port.path, f"bearing {t.number}", c, 2 * len(port.array)).reshape(2, -1)
            waves = rotate_back_np(np.tile(poses[r].attitude[c], (len(h.waves[0]), 1)), h.waves[0]), h.waves[1]
            angles = measured_direction(port, waves, 10.0 ** (snr / 10.0) * gain, normals)
            azimuth, elevation = reported_bearing(port, self._chance, c, t.number, angles)
        shift = round(h.delay_s * SECOND)
        stretch = round((t.end_ns - t.start_ns) / h.doppler)
        absent = lost not in ("", "foreign")
        start = t.start_ns if absent else t.start_ns + shift
        sonar = NOTHING if port.carrier else self._medium.sonar_noise(port, poses[r], c)
        return Incoming(
            t, r, start, start if absent else start + stretch, h.delay_s, NOTHING if absent else h.level_db,
            h.echoes_db, self._noise[r], sonar, h.spread_s, h.doppler, lost,
            azimuth, elevation,
        )  # fmt: skip

    # out of the water

    def _finish(self, now: int, tick: int) -> None:
        """Decide on packets that have arrived; those of modems that are not due now wait for their own tick."""
        ready = [i for i in self._incoming if i.end_ns <= now and tick % self._ports[i.receiver].period == 0]
        if not ready:
            return
        rest = [i for i in self._incoming if not (i.end_ns <= now and tick % self._ports[i.receiver].period == 0)]
        around: dict[tuple[int, int], list[Incoming]] = {}
        for i in (*self._incoming, *self._done):
            around.setdefault((i.receiver, i.transmission.copy), []).append(i)
        for i in sorted(ready, key=lambda i: (i.end_ns, i.receiver, i.transmission.copy, i.transmission.number)):
            if i.lost != "foreign":
                self._decide(i, around[i.receiver, i.transmission.copy])
        self._incoming = rest
        self._done = [i for i in [*self._done, *ready] if i.end_ns > now - _KEPT_NS and math.isfinite(i.level_db)]

    def _decide(self, i: Incoming, around: Sequence[Incoming]) -> None:
        t, port = i.transmission, self._ports[i.receiver]
        c = t.copy
        others = [
            (o.level_db, self._ports[o.transmission.sender]) for o in around
            if o is not i and math.isfinite(o.level_db) and o.start_ns < i.end_ns and i.start_ns < o.end_ns
        ]  # fmt: skip
        fate = self._fate(i, [level + same_waveform_db(port) * port.understands(p) for level, p in others])
        disturbance = sum_db(i.noise_db, i.echoes_db, i.sonar_db, *(level for level, _ in others))
        snr = i.level_db - disturbance if math.isfinite(i.level_db) else NOTHING
        out = self._outputs[i.receiver]
        names = (self._ports[t.sender].path, t.outgoing.to, port.path)
        out.fates[c].append(
            Reception(
                t.number, t.outgoing.kind, *names, t.start_ns, i.end_ns, len(t.outgoing.payload), fate, i.level_db, snr
            )
        )
        if fate == "received":
            self._received(i, snr, out)

    def _fate(self, i: Incoming, others: list[float]) -> Fate:
        if i.lost:
            lost: Fate = i.lost  # type: ignore[assignment]
            return lost
        t, port = i.transmission, self._ports[i.receiver]
        if self._stations[i.receiver][t.copy].sends_within(i.start_ns, i.end_ns):
            return "half duplex"
        if i.level_db < i.noise_db + port.detection_db:
            return "out of range"
        bits = 8 * (4 + len(t.outgoing.payload))
        chance = self._chance.uniform(port.path, f"fate {t.number}", t.copy)
        noise: list[tuple[Fate, list[float]]] = [
            ("noise", []), ("multipath", [i.echoes_db]), ("sonar", [i.sonar_db]), ("collision", others)
        ]  # fmt: skip
        present: list[float] = []
        for fate, levels in noise:
            heard = [level for level in levels if math.isfinite(level)]
            present += heard
            if fate != "noise" and not heard:
                continue
            if chance >= success(port, bits, i.level_db, i.noise_db, *present):
                return fate
        return "received"

    def _received(self, i: Incoming, snr: float, out: Output) -> None:
        t, port = i.transmission, self._ports[i.receiver]
        c, station = t.copy, self._stations[i.receiver][t.copy]
        sender = self._ports[t.sender].path
        mine = t.outgoing.to in (port.path, BROADCAST)
        if not mine:
            if t.outgoing.kind in ("rts", "cts"):
                hush = 2 * round(port.duration_s(port.packet_max_bytes) * SECOND)
                station.silent_ns = max(station.silent_ns, i.end_ns + min(hush, round(port.timeout_s * SECOND)))
            return
        error = arrival_time_error(10.0 ** (snr / 10.0), port.bandwidth_hz, port.preamble_s)
        (drawn,) = self._chance.normals(port.path, f"time {t.number}", c, 1)
        here = self.clock(i.receiver, c, i.start_ns) + float(drawn) * error
        distance = math.nan
        if t.outgoing.kind == "response" and t.outgoing.reply_to in station.asked:
            turned = port.turnaround_s + port.duration_s(0, "request")
            distance = 0.5 * (here - station.asked[t.outgoing.reply_to] - turned) * port.sound_speed_mps
            distance = reported_range(port, self._chance, c, t.number, distance)
        answer(station, port, i, sender)
        if t.outgoing.kind in ("ack", "rts", "cts"):
            return
        station.received += 1
        out.packets[c].append(
            Packet(
                t.number, t.outgoing.kind, sender, t.outgoing.to, t.outgoing.payload.encode("latin-1"), t.start_ns,
                i.end_ns, here - t.clock_s, i.level_db, snr, i.spread_s, i.doppler, distance, i.azimuth_rad,
                i.elevation_rad, t.depth_m, t.outgoing.tag,
            )
        )  # fmt: skip

    def _report(self, due: Sequence[int], now: int) -> None:
        for k in due:
            if k not in self._noise:
                self._noise[k] = self._quiet(self._ports[k])
            status = self._outputs[k].status
            for c, station in enumerate(self._stations[k]):
                waits = len(station.queue) + (station.pending is not None)
                status[c] = waits, station.busy(now), station.received, station.sent, self._noise[k]
                station.received = station.sent = 0

    def _quiet(self, port: ModemPort) -> float:
        return self._medium.noise(port) if port.carrier is None else port.carrier.noise()

    # clocks and chance

    def clock(self, k: int, c: int, t_ns: int) -> float:
        """Time on a modem's clock [s]."""
        port = self._ports[k]
        if port.clock_offset_std_s == 0.0 and port.clock_drift_std_ppm == 0.0:
            return t_ns * 1e-9
        offset, drift = self._chance.normals(port.path, "clock", c, 2)
        t = (t_ns - self._stations[k][c].begin_ns) * 1e-9
        error = float(offset) * port.clock_offset_std_s + float(drift) * port.clock_drift_std_ppm * 1e-6 * t
        return t_ns * 1e-9 + error

    # checkpoints

    def memory(self) -> dict[str, Any]:
        """Everything that changes in a run: plain values and copies of arrays."""
        return copies_of.deepcopy(
            {"tick": self.tick, "numbers": self._numbers, "stations": self._stations, "incoming": self._incoming,
             "done": self._done, "cache": [[*pair, link] for pair, link in self._cache.items()]}
        )  # fmt: skip

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        kept = copies_of.deepcopy(dict(memory))
        self.tick, self._numbers, self._stations = kept["tick"], kept["numbers"], kept["stations"]
        self._incoming, self._done = kept["incoming"], kept["done"]
        self._cache = {(a, b, c): link for a, b, c, link in kept["cache"]}
