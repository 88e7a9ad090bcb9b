"""The view: what it costs a mission, how long a picture of four panels takes, how soon the page is there."""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from dataclasses import dataclass
from typing import Any, Final

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.cases.missions import harbour
from pelagos.bench.check import must

_SECONDS: Final = 10.0
_PAIRS: Final = 6
_CLIENT: Final = """
import asyncio, json, sys, websockets
async def main():
    async with websockets.connect(sys.argv[1], max_size=None) as connection:
        wanted = sys.argv[2:]
        while wanted:
            message, at = await connection.recv(), 0
            while at < len(message):
                size, blob = (int.from_bytes(message[i:i + 4], "little") for i in (at, at + 4))
                header = json.loads(message[at + 8:at + 8 + size])
                at += 8 + size + blob + -blob % 4
                if wanted and header["type"] == wanted[0] and header.get("pictured", True):
                    wanted = []
        print("ready", flush=True)
        count = size = 0
        try:
            async for message in connection:
                count, size = count + 1, size + len(message)
        except websockets.exceptions.ConnectionClosed:
            pass
        print(count, size, flush=True)
asyncio.run(main())
"""


def _client(url: str, *until: str) -> Any:
    """A client in another process; it is ready when it has a message of that type, if one is named."""
    address = url.replace("http://", "ws://").replace("/?", "/live?")
    made = subprocess.Popen([sys.executable, "-c", _CLIENT, address, *until], stdout=subprocess.PIPE, text=True)
    assert made.stdout is not None
    must(made.stdout.readline().strip() == "ready", "the client did not connect")
    return made


@dataclass(frozen=True)
class _Lap:
    """Cost of one run [s]: wall-clock time, CPU time of the thread that steps, and of the whole process."""

    wall: float
    stepper: float
    process: float


def _lap(sim: Any) -> _Lap:
    before = time.perf_counter(), time.thread_time(), time.process_time()
    sim.run(_SECONDS)
    after = time.perf_counter(), time.thread_time(), time.process_time()
    return _Lap(*(b - a for a, b in zip(before, after, strict=True)))


def view_slowdown_ratio() -> Measured:
    """The demo mission with the view and a client that takes everything, over the same alone: median of pairs.

    The two of a pair follow one another, the first of them in turns, so that a machine that grows slower or faster, or
    has other work for a while, does not count for one side.
    """
    from pelagos.sim.simulation import Simulation
    from pelagos.viewer.session import Watch

    sim = Simulation.load(harbour())
    sim.run(5.0)
    messages = size = pictures = 0

    def alone() -> _Lap:
        sim.reset()
        return _lap(sim)

    def seen() -> _Lap:
        nonlocal messages, size, pictures
        sim.reset()
        with Watch(sim, port=0) as watch:
            client = _client(watch.url, "hello")  # the scene is sent once, before the run
            try:
                found = _lap(sim)
                pictures += watch.view.pictures
            finally:
                watch.close()
                account = client.communicate(timeout=30)[0].split()
        messages, size = messages + int(account[0]), size + int(account[1])
        return found

    pairs: list[tuple[_Lap, _Lap]] = []
    for turn in range(_PAIRS):
        if turn % 2:
            with_view = seen()
            pairs.append((alone(), with_view))
        else:
            pairs.append((alone(), seen()))
    must(messages >= pictures > 0, f"the client got {messages} messages of {pictures} pictures")
    ratio = {k: statistics.median(getattr(b, k) / getattr(a, k) for a, b in pairs) for k in _Lap.__annotations__}
    walls = [b.wall / a.wall for a, b in pairs]
    took = sum(b.wall for _, b in pairs)
    return Measured(
        ratio["wall"],
        reference=Reference("the run alone", 1.0),
        detail=f"median of {_PAIRS} pairs from {min(walls):.2f} to {max(walls):.2f}; CPU time of the stepping thread "
        f"{ratio['stepper']:.2f}, of the process {ratio['process']:.2f} times that alone; "
        f"{pictures / took:.1f} pictures a second, {size * 1e-6 / took:.2f} MB/s to another process",
    )


def view_panel_ms() -> Measured:
    """Four panels of the demo's sensors, from readings to JPEG, in one thread."""
    from pelagos.drawing.sample import sample_of
    from pelagos.sim.simulation import Simulation
    from pelagos.viewer.panels import Panels

    sim = Simulation.load(harbour())
    found = sim.observe("auv0", (-60.0, 40.0, -6.0))
    configs = {f"auv0.{n}": m.config for n, m in sim.model.agents["auv0"].sensors.items()}
    names = [n for n in ("imaging", "multibeam", "camera", "dvl") if n in found]
    panels = Panels({f"auv0.{n}": configs[f"auv0.{n}"] for n in names})
    pictures = [0]

    def once() -> None:
        for name in names:
            panels.take(sample_of(configs[f"auv0.{name}"], found[name]))
            pictures[0] += panels.panels[f"auv0.{name}"].jpeg() is not None

    once()
    start, count = time.perf_counter(), 50
    for _ in range(count):
        once()
    took = 1e3 * (time.perf_counter() - start) / count
    must(pictures[0] >= 3 * count, "panels have no pictures")
    return Measured(took, detail=f"{', '.join(names)}: {pictures[0] // (count + 1)} pictures")


def view_open_s() -> Measured:
    """From the command to the first picture at a client, in processes of their own; the faster of two.

    The first leaves the bytecode of all modules behind, as an installation does, even where Python is told not to.
    """
    import os
    import tempfile
    from pathlib import Path

    import yaml

    times = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "harbour.yaml"
        path.write_text(yaml.safe_dump(harbour()), encoding="utf-8")
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        environment["PYTHONPYCACHEPREFIX"] = str(Path(folder) / "bytecode")
        for _ in range(2):
            start = time.perf_counter()
            command = [sys.executable, "-m", "pelagos", "view", str(path), "--no-browser", "--port", "0"]
            view = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=folder, env=environment)
            try:
                assert view.stdout is not None
                line = view.stdout.readline()
                must(line.startswith("the view: "), f"the command said {line!r}")
                client = _client(line.split()[-1], "panel")
                times.append(time.perf_counter() - start)
                client.kill()
                client.wait()
            finally:
                view.terminate()
                view.communicate(timeout=60)
    return Measured(min(times), detail="command to the first picture of a sensor at a client, kernels cached")


CASES: Final = (
    Case(
        name="view_slowdown_ratio",
        title="Demo mission looked at, four panels, a client that takes everything",
        measure=view_slowdown_ratio,
        unit="of the time alone",
        goal=1.1,
        better="lower",
        reference=Reference("the run alone", 1.0),
    ),
    Case(
        name="view_panel_ms",
        title="Four panels from readings to pictures",
        measure=view_panel_ms,
        unit="ms",
        goal=20.0,
        better="lower",
        reference=Reference("a tenth of a second between pictures", 100.0),
    ),
    Case(
        name="view_open_s",
        title="From the command to the first picture",
        measure=view_open_s,
        unit="s",
        goal=6.0,
        better="lower",
        reference=Reference("what people wait for", 6.0),
    ),
)
