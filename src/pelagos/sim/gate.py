"""The gate between a step loop and everything else: actions enter at the boundaries of steps, and a run can be held."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from pelagos.errors import CommandError

_LOOK_S: Final = 0.1  # how often a held run looks up, so that Ctrl-C ends it


class Gate:
    """One thread steps; any thread may post actions, hold the run, let it go on, or end it.

    Attributes:
        paused: the run is to be held at the next boundary.
        stopped: the run is to end at the next boundary.
        settle: reads the sensors that wait in a run; called before anything that they see changes.
    """

    def __init__(self) -> None:
        self.paused = False
        self.stopped = False
        self.settle: Callable[[], None] = _nothing
        self._posted: deque[Callable[[], object]] = deque()
        self._changed = threading.Condition()
        self._thread: int | None = None

    @property
    def elsewhere(self) -> bool:
        """Another thread than this one is stepping."""
        return self._thread is not None and self._thread != threading.get_ident()

    def enter(self, what: str) -> None:
        """Begin to step.

        Raises:
            CommandError: somebody steps already: another thread, or this one further up, which called back.
        """
        self.refuse(what)
        self._thread = threading.get_ident()

    def refuse(self, what: str) -> None:
        """Raises CommandError where somebody steps, and `what` cannot be done meanwhile."""
        if self._thread is not None:
            raise CommandError(
                f"sim.{what} was called while the simulation steps: from a callback, a policy or another thread. "
                "There, set commands, post actions (sim.post) or end the run (sim.stop)"
            )

    def leave(self) -> None:
        """End stepping."""
        self._thread = None
        self.settle = _nothing

    def post(self, action: Callable[[], object]) -> None:
        """Have an action done at the next boundary."""
        with self._changed:
            self._posted.append(action)
            self._changed.notify_all()

    def set(self, *, paused: bool | None = None, stopped: bool | None = None) -> None:
        """Hold or end a run, or let it go on."""
        with self._changed:
            self.paused = self.paused if paused is None else paused
            self.stopped = self.stopped if stopped is None else stopped
            self._changed.notify_all()

    @contextmanager
    def between_steps(self) -> Iterator[None]:
        """At a boundary of steps, in the thread that steps: what else must wait for the end of a run may be done."""
        self.settle()
        thread, settle = self._thread, self.settle
        self._thread = None
        try:
            yield
        finally:
            self._thread, self.settle = thread, settle

    def act(self) -> None:
        """Do what was posted, in order."""
        while self._posted:
            self._posted.popleft()()

    def hold(self) -> bool:
        """Do what was posted, and wait while the run is paused; whether it was."""
        self.act()
        held = False
        while self.paused and not self.stopped:
            held = True
            with self._changed:
                if not self._posted and self.paused and not self.stopped:
                    self._changed.wait(_LOOK_S)
            self.act()
        return held


def _nothing() -> None:
    """No sensor waits."""
