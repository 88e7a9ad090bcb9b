"""Engines: work by index done in this process, by processes of this machine, or by Ray; the results are the same.

Importing this module is light: a worker sets the number of its threads before anything else is loaded.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any, Final, Protocol

from pelagos.errors import InputError, PelagosError, SimulationError

ATTEMPTS: Final = 3  # of one piece of work, whose worker was killed
THREADS: Final = "PELAGOS_THREADS"
JOIN_S: Final = 5.0

Record = dict[str, Any]


class Job(Protocol):
    """Work that can be pickled; `open` makes what does a piece of it by index and keeps what is expensive."""

    def open(self) -> Callable[[int], Record]:
        """Worker in the process that calls this."""
        ...


@dataclass(frozen=True)
class Engine:
    """Processes or machines that do the work.

    Attributes:
        workers: processes, 1 for this one; with Ray its actors.
        ray: address of a Ray cluster: "local" starts one on this machine, "auto" finds one; None: without Ray.
    """

    workers: int = 1
    ray: str | None = None

    def run(self, job: Job, indices: Iterable[int]) -> Iterator[Record]:
        """Results in the order in which they come.

        Raises:
            PelagosError: of the first piece of work that fails; the others are stopped.
        """
        todo = list(indices)
        if not todo:
            return
        if self.ray is not None:
            from pelagos.datasets.ray_engine import run_by_ray

            yield from run_by_ray(job, todo, address=self.ray, workers=self.workers)
        elif self.workers == 1:
            work = job.open()
            for index in todo:
                yield work(index)
        else:
            yield from _by_processes(job, todo, min(self.workers, len(todo)))


def checked(workers: int, ray: str | None) -> Engine:
    """An engine.

    Raises:
        InputError: a number of workers that cannot be, or no Ray at the address.
    """
    if workers < 1:
        raise InputError(f"--workers is a number from 1 on, not {workers}")
    if ray is not None:
        from pelagos.datasets.ray_engine import check_address

        check_address(ray)
    return Engine(workers, ray)


@dataclass
class _Worker:
    process: Any
    pipe: Connection
    index: int


def _by_processes(job: Job, todo: list[int], workers: int) -> Iterator[Record]:
    waiting, lost = deque(todo), Counter[int]()
    context, data = multiprocessing.get_context("spawn"), pickle.dumps(job)
    running: list[_Worker] = []
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                running.append(_started(context, data, waiting.popleft(), workers))
            ready = wait([w.pipe for w in running])
            for worker in [w for w in running if w.pipe in ready]:
                try:
                    answer = worker.pipe.recv()
                except (EOFError, ConnectionResetError):
                    running.remove(worker)
                    lost[worker.index] += 1
                    _refuse_lost(worker, lost[worker.index])
                    waiting.appendleft(worker.index)
                    continue
                if isinstance(answer, BaseException):
                    raise answer
                yield answer
                if waiting:
                    worker.index = waiting.popleft()
                    worker.pipe.send(worker.index)
                else:
                    running.remove(worker)
                    worker.pipe.close()
                    worker.process.join()
    finally:
        for worker in running:
            worker.process.terminate()
            worker.process.join(JOIN_S)


def _started(context: Any, data: bytes, index: int, workers: int) -> _Worker:
    ours, theirs = context.Pipe()
    threads = os.environ.get(THREADS) or str(max(1, (os.cpu_count() or 1) // workers))
    process = context.Process(target=serve, args=(data, theirs, threads), daemon=True)
    process.start()
    theirs.close()
    ours.send(index)
    return _Worker(process, ours, index)


def _refuse_lost(worker: _Worker, times: int) -> None:
    worker.process.join(JOIN_S)
    if times >= ATTEMPTS:
        raise SimulationError(
            f"piece {worker.index}: {times} workers were killed while they made it (exit code "
            f"{worker.process.exitcode}; -9 is often too little memory: give fewer workers or a smaller batch)"
        )


def serve(data: bytes, pipe: Connection, threads: str) -> None:
    """The life of a worker: an index comes, a record or an exception goes; it ends with the pipe."""
    os.environ[THREADS] = threads
    with quiet_ending():
        try:
            work = pickle.loads(data).open()
            while True:
                pipe.send(work(pipe.recv()))
        except (EOFError, BrokenPipeError, ConnectionResetError):
            return
        except PelagosError as error:
            pipe.send(error)
        except Exception as error:
            pipe.send(SimulationError(f"a worker failed: {type(error).__name__}: {error}"))


@contextmanager
def quiet_ending() -> Iterator[None]:
    """Ctrl-C, which every process of a terminal gets, is the driver's to answer."""
    try:
        yield
    except KeyboardInterrupt:
        return
