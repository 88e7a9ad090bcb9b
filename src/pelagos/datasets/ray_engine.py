"""Work by index on a Ray cluster: an actor a worker, restarted where it is killed, its work tried again.

https://docs.ray.io/en/latest/ray-core/fault_tolerance/actors.html
"""

from __future__ import annotations

import os
import pickle
import socket
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Final

from pelagos.datasets.engine import THREADS, Job, Record
from pelagos.errors import InputError, PelagosError, SimulationError

CONNECT_S: Final = 5.0
STORE_BYTES: Final = 100 << 20  # records are small; data goes into files


def run_by_ray(job: Job, todo: list[int], *, address: str, workers: int) -> Iterator[Record]:
    """Results of the pieces `todo`, in the order in which they come.

    Raises:
        InputError: Ray is not installed, or nothing answers at the address.
        PelagosError: of the first piece of work that fails.
    """
    ray = _ray()
    ours = not ray.is_initialized()
    if ours:
        _connect(ray, address, workers)
    try:
        yield from _by_actors(ray, job, todo, min(workers, len(todo)))
    finally:
        if ours:
            ray.shutdown()


def check_address(address: str) -> None:
    """Refuse an address at which there is no cluster, before anything is written.

    Raises:
        InputError: Ray is not installed, or nothing answers.
    """
    _ray()
    if address not in ("local", "auto"):
        _answers(address)


def _ray() -> Any:
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # no telemetry
    try:
        import ray
    except ImportError:
        raise InputError("--ray needs Ray: pip install 'pelagos[ray]'") from None
    return ray


def _connect(ray: Any, address: str, workers: int) -> None:
    quiet: dict[str, Any] = {"include_dashboard": False} if address == "local" else {}
    if address == "local":
        quiet |= {"num_cpus": workers, "object_store_memory": STORE_BYTES}
    elif address != "auto":
        _answers(address)
    try:
        ray.init(address=address, log_to_driver=False, configure_logging=False, **quiet)
    except (ConnectionError, ValueError, RuntimeError, OSError) as error:
        told = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"--ray {address}: no Ray cluster could be joined: {told}") from None


def _answers(address: str) -> None:
    """Refuse an address at which nobody listens; Ray itself waits for it for minutes."""
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if not colon or not port.isdecimal() or not host:
        raise InputError(f"--ray {address!r}: give local, auto, HOST:PORT or ray://HOST:PORT")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=CONNECT_S).close()
    except (OSError, OverflowError) as error:
        raise InputError(f"--ray {address}: nothing answers there ({error}); is the cluster up?") from None


class Piece:
    """The actor: opens the job once, then does pieces of it."""

    def __init__(self, data: bytes, threads: str) -> None:
        os.environ[THREADS] = threads
        self._work: Callable[[int], Record] = pickle.loads(data).open()

    def make(self, index: int) -> Record | PelagosError:
        """A piece, or what is wrong with it: errors of the input are not tried again."""
        try:
            return self._work(index)
        except PelagosError as error:
            return error


def _by_actors(ray: Any, job: Job, todo: list[int], workers: int) -> Iterator[Record]:
    from ray.exceptions import RayError

    waiting, data, threads = deque(todo), pickle.dumps(job), os.environ.get(THREADS, "1")
    kind = ray.remote(num_cpus=int(threads), max_restarts=-1, max_task_retries=-1)(Piece)
    actors = [kind.remote(data, threads) for _ in range(workers)]
    running = {actor.make.remote(waiting.popleft()): actor for actor in actors if waiting}
    try:
        while running:
            done, _ = ray.wait(list(running), num_returns=1)
            actor = running.pop(done[0])
            try:
                answer = ray.get(done[0])
            except RayError as error:
                raise SimulationError(f"a worker of Ray failed: {str(error).strip().splitlines()[-1]}") from None
            if isinstance(answer, PelagosError):
                raise answer
            yield answer
            if waiting:
                running[actor.make.remote(waiting.popleft())] = actor
    finally:
        for actor in actors:
            ray.kill(actor)
