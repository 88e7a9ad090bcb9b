"""Orders from outside, on their way to the next boundary of steps; every one that was obeyed is written down."""

from __future__ import annotations

import json
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from pelagos.errors import InputError
from pelagos.sim.order import Order, apply
from pelagos.sim.simulation import Simulation

LIMIT: Final = 1000
"""Orders that may wait; what comes beyond is refused."""
ANSWER_S: Final = 10.0
MOST_REASONS: Final = 1000
"""Refusals that are told apart: their texts hold names that a peer chose."""
STREAM_S: Final = 1.0
"""Velocities that are farther apart are no stream [s]."""


@dataclass
class Ticket:
    """An order whose sender waits for the outcome.

    Attributes:
        order: what to do.
        done: set when it was obeyed or refused.
        refusal: why it was refused; empty where it was obeyed.
    """

    order: Order
    done: threading.Event = field(default_factory=threading.Event)
    refusal: str = ""
    _claimed: threading.Lock = field(default_factory=threading.Lock)

    def claim(self) -> bool:
        """Take it, to do or to withdraw it; False where somebody has."""
        return self._claimed.acquire(blocking=False)

    def wait(self, seconds: float = ANSWER_S) -> str:
        """The refusal, or an empty text; an order that is not reached in time is withdrawn."""
        if not self.done.wait(seconds) and self.claim():
            return f"the simulation did not reach a boundary of steps within {seconds:g} s; the order was withdrawn"
        self.done.wait()
        return self.refusal


class Inbox:
    """Takes orders from any thread, and has them done by the thread that steps.

    Of a stream of commands only the newest is kept, so that a fast peer fills nothing.

    Attributes:
        obeyed: orders by kind.
        refused: how often each refusal was given.
    """

    def __init__(
        self, sim: Simulation, note: Callable[[str, int], None] | None = None, say: Callable[[str], None] | None = None
    ) -> None:
        self._sim, self._note, self._say = sim, note, say
        self._unwritten: list[tuple[Order, int, int]] = []
        self._waiting: deque[Ticket] = deque()
        self._by_key: dict[tuple[str, ...], Ticket] = {}
        self._lock = threading.Lock()
        self._posted = False
        self._velocity_ns: dict[str, int] = {}
        self.obeyed: Counter[str] = Counter()
        self.refused: Counter[str] = Counter()

    def put(self, order: Order) -> Ticket:
        """Have an order done at the next boundary."""
        ticket = Ticket(order)
        with self._lock:
            older = None if order.key is None else self._by_key.get(order.key)
            if older is not None and older in self._waiting:
                self._waiting.remove(older)
                older.done.set()
            if len(self._waiting) >= LIMIT:
                self._refuse(ticket, f"more than {LIMIT} orders wait")
                return ticket
            self._waiting.append(ticket)
            if order.key is not None:
                self._by_key[order.key] = ticket
            post, self._posted = not self._posted, True
        if post:
            self._sim.post(self.drain)
        return ticket

    def obey(self, order: Order) -> None:
        """Do an order at once; for who is at a boundary already, in the thread that steps."""
        self._do(Ticket(order))

    def steer(self, agent: str, values: Sequence[float], source: str) -> None:
        """Obey an order to an agent's actuators at once, by a short way; for autopilots, thousands of times a second.

        The numbers are finite, one for each actuator. The order is written down when `write_down` is called next.
        """
        order = Order("command", agent, {"values": values, "mode": "actuators"}, source)
        stepper = self._sim.stepper
        if stepper.mode(agent) != "actuators":
            self.obey(order)
            return
        stepper.set_command(agent, np.array([values], dtype=np.float64))
        self.obeyed["command"] += 1
        self._unwritten.append((order, self._sim.time_ns, time.time_ns()))

    def write_down(self) -> None:
        """Write down what was steered."""
        for order, t_ns, wall_ns in self._unwritten:
            if self._note is not None:
                self._note(order_text(order, t_ns, self._sim.dt_ns, wall_ns), t_ns)
        self._unwritten.clear()

    def refuse(self, reason: str) -> None:
        """Count something that could not be understood; said once."""
        if reason not in self.refused and len(self.refused) >= MOST_REASONS:
            reason = "for further reasons"
        self.refused[reason] += 1
        if self.refused[reason] == 1 and self._say is not None:
            self._say(reason)

    def drain(self) -> None:
        """Do what waits; called at a boundary of steps."""
        with self._lock:
            waiting = list(self._waiting)
            self._waiting.clear()
            self._by_key.clear()
            self._posted = False
        for ticket in waiting:
            if ticket.claim():
                self._do(ticket)

    def _timed(self, order: Order) -> Order:
        """A velocity with the time since the last one, which moves a heading on; 0 where the stream had ended."""
        if order.kind != "velocity" or "since_s" in order.data:
            return order
        now = self._sim.time_ns
        since_s = (now - self._velocity_ns.get(order.target, now)) * 1e-9
        self._velocity_ns[order.target] = now
        return replace(order, data={**order.data, "since_s": since_s if 0 <= since_s <= STREAM_S else 0.0})

    def _do(self, ticket: Ticket) -> None:
        ticket.order = self._timed(ticket.order)
        try:
            apply(ticket.order, self._sim)
        except (InputError, TypeError, ValueError, KeyError) as error:
            self._refuse(ticket, f"{ticket.order.source}: {error}" if ticket.order.source else str(error))
            return
        self.obeyed[ticket.order.kind] += 1
        self._unwritten.append((ticket.order, self._sim.time_ns, time.time_ns()))
        self.write_down()
        ticket.done.set()

    def _refuse(self, ticket: Ticket, reason: str) -> None:
        self.refuse(reason)
        ticket.refusal = reason
        ticket.done.set()


def order_text(order: Order, t_ns: int, dt_ns: int, wall_ns: int) -> str:
    """An order as it is written down: JSON, which keeps every bit of a float."""
    written: dict[str, Any] = {
        "tick": t_ns // dt_ns, "t_ns": t_ns, "wall_ns": wall_ns, "kind": order.kind,
        "target": order.target, "data": dict(order.data), "source": order.source,
    }  # fmt: skip
    return json.dumps(written, default=_plain)


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)
