"""Long runs, to see that memory and time per tick stay flat.

usage: python scripts/soak.py [SOAK ...] [--share 1.0] [--write docs/soak]

A share of 1 is a week of simulated time with navigation sensors, a day with a sonar and a camera, 100 000 resets and
10 000 loads: some hours. Each soak is a process of its own; Ctrl-C keeps what was sampled.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

SAMPLES = 200
WARM = 0.25
"""Share of a soak in which caches may still fill: kernels, Python's arenas, file buffers."""
GROWTH_MB, GROWTH_SHARE = 8.0, 0.02
"""More memory than this after `WARM` is a leak."""

NAVIGATION = {
    "tick_rate_hz": 50,
    "world": {"type": "flat", "depth_m": 40.0},
    "agents": {
        "auv": {
            "vehicle": "remus100",
            "start": {"position_m": [0.0, 0.0], "depth_m": 5.0},
            "control": "depth_heading",
            "command": [6.0, 0.7, 900.0],
            "sensors": {
                "imu": {"type": "imu", "rate_hz": 50}, "dvl": {"type": "dvl", "rate_hz": 5},
                "depth": {"type": "depth", "rate_hz": 10}, "magnetometer": {"type": "magnetometer", "rate_hz": 10},
                "gps": {"type": "gps", "rate_hz": 1},
            },
        }
    },
}  # fmt: skip
SEEING: dict[str, Any] = {
    "tick_rate_hz": 20,
    "world": {"type": "harbour", "seed": 3},
    "agents": {
        "rov": {
            "vehicle": "bluerov2_heavy",
            "start": {"position_m": [0.0, 0.0], "depth_m": 4.0},
            "sensors": {
                "sonar": {"type": "imaging_sonar", "rate_hz": 1, "beams": 64, "bins": 128},
                "camera": {"type": "camera", "rate_hz": 1, "width_px": 96, "height_px": 64},
            },
        }
    },
}


@dataclass(frozen=True)
class Soak:
    """One kind of long run."""

    title: str
    unit: str
    """What is counted: ticks, resets, loads."""
    whole: int
    """How many at a share of 1."""
    work: Callable[[int], Iterator[int]]
    """Does that many, and says from time to time how many are done."""


def ticks(scenario: dict[str, Any]) -> Callable[[int], Iterator[int]]:
    """Ticks of one simulation, in blocks."""

    def work(count: int) -> Iterator[int]:
        import pelagos as pl

        sim = pl.Simulation.load(scenario)
        sim.reset()
        block = max(count // SAMPLES, 1)
        for done in range(0, count, block):
            sim.run(block / scenario["tick_rate_hz"])
            yield done + block

    return work


def resets(count: int) -> Iterator[int]:
    """Resets of one simulation, each with a few ticks behind it."""
    import pelagos as pl

    sim = pl.Simulation.load(NAVIGATION)
    for done in range(count):
        sim.reset(seed=done)
        sim.step(ticks=3)
        if (done + 1) % max(count // SAMPLES, 1) == 0:
            yield done + 1


def loads(count: int) -> Iterator[int]:
    """Simulations loaded from data, each with a few ticks behind it."""
    import pelagos as pl

    for done in range(count):
        sim = pl.Simulation.load(NAVIGATION | {"seed": done % 7})
        sim.reset()
        sim.step(ticks=3)
        if (done + 1) % max(count // SAMPLES, 1) == 0:
            yield done + 1


SOAKS = {
    "navigation": Soak("A week with navigation sensors", "ticks", 7 * 86_400 * 50, ticks(NAVIGATION)),
    "seeing": Soak("A day with a sonar and a camera in a harbour", "ticks", 86_400 * 20, ticks(SEEING)),
    "resets": Soak("100 000 resets", "resets", 100_000, resets),
    "loads": Soak("10 000 loads", "loads", 10_000, loads),
}


def resident_mb() -> float:
    """Memory that this process holds now [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def child(name: str, count: int) -> None:
    """Run one soak; a line of JSON for each sample: units done, MB, CPU ms a unit since the last sample."""
    before, began = 0, time.process_time()  # of the processor: what else runs on the machine is no matter
    for done in SOAKS[name].work(count):
        now = time.process_time()
        gc.collect()  # Python's collector counts objects, not the megabytes behind them: without this, a saw-tooth
        print(json.dumps([done, resident_mb(), 1e3 * (now - began) / (done - before)]), flush=True)
        before, began = done, time.process_time()


def grown_mb(samples: list[list[float]]) -> float:
    """Memory of the last tenth over that right after the warm-up [MB]."""
    after = [mb for _, mb, _ in samples[int(WARM * len(samples)) :]]
    tenth = max(len(after) // 10, 1)
    return sum(after[-tenth:]) / tenth - sum(after[:tenth]) / tenth


def is_flat(samples: list[list[float]]) -> bool:
    """Whether memory grew by no more than `GROWTH_MB` and `GROWTH_SHARE` of itself."""
    return grown_mb(samples) <= max(GROWTH_MB, GROWTH_SHARE * samples[-1][1])


def run(name: str, share: float) -> list[list[float]]:
    """The samples of one soak, from a process of its own."""
    soak = SOAKS[name]
    count = max(round(share * soak.whole), SAMPLES)
    samples: list[list[float]] = []
    command = [sys.executable, __file__, "--child", name, str(count)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            samples.append(json.loads(line))
            done, mb, ms = samples[-1]
            print(f"\r{name}: {done:.0f} of {count} {soak.unit}, {mb:.0f} MB, {ms:.3g} ms each  ", end="", flush=True)
    print()
    if process.returncode:
        sys.exit(f"{name}: the process ended with {process.returncode}")
    return samples


def draw(found: dict[str, list[list[float]]], path: Path) -> None:
    """Memory and time against work done, one row a soak."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot, ticker

    figure, rows = pyplot.subplots(len(found), 2, figsize=(9, 2.2 * len(found)), squeeze=False, layout="constrained")
    for (name, samples), (memory, pace) in zip(found.items(), rows, strict=True):
        soak, (done, mb, ms) = SOAKS[name], zip(*samples, strict=True)
        memory.plot(done, mb, color="#0072b2")
        pace.plot(done, ms, color="#d55e00")
        share = f"{done[-1] / soak.whole:.0%} of {soak.title[0].lower()}{soak.title[1:]}"
        memory.set(title=share, ylabel="memory [MB]", ylim=(0, 1.2 * max(mb)))
        pace.set(ylabel=f"CPU time [ms a {soak.unit[:-1]}]", ylim=(0, 2.0 * sorted(ms)[len(ms) // 2]))
        for axes in (memory, pace):
            axes.xaxis.set_major_formatter(ticker.EngFormatter(sep=""))
            axes.set_xlabel(soak.unit)
    figure.savefig(path)


def main() -> int:
    """Run the soaks; 1 if one of them grew."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("soaks", nargs="*", metavar="SOAK", help=f"of {', '.join(SOAKS)}; all by default")
    parser.add_argument("--share", type=float, default=1.0, help="of the full length, 1 by default")
    parser.add_argument("--write", type=Path, help="write FILE.json and FILE.svg")
    parser.add_argument("--child", nargs=2, metavar=("SOAK", "COUNT"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        child(options.child[0], int(options.child[1]))
        return 0
    if unknown := set(options.soaks) - set(SOAKS):
        parser.error(f"no soak {', '.join(sorted(unknown))}; known: {', '.join(SOAKS)}")
    if not options.share > 0:
        parser.error(f"--share is more than 0, not {options.share:g}")
    found = {name: run(name, options.share) for name in options.soaks or SOAKS}
    for name, samples in found.items():
        grown, flat = grown_mb(samples), is_flat(samples)
        print(f"{name:12s} {samples[-1][1]:6.0f} MB, {grown:+.1f} MB after the warm-up: {'flat' if flat else 'GREW'}")
    if options.write:
        options.write.with_suffix(".json").write_text(json.dumps(found) + "\n")
        draw(found, options.write.with_suffix(".svg"))
    return 0 if all(map(is_flat, found.values())) else 1


if __name__ == "__main__":
    sys.exit(main())
