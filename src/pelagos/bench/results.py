"""`bench/RESULTS.md`: what was measured, where and when."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from pelagos.bench.case import Result

_PACKAGES = ("pelagos", "mitsuba", "drjit", "numpy")


def hardware() -> str:
    """Name of the processor, and how many cores this process may use."""
    name = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [
            line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")
        ]
        name = names[0] if names else name
    return f"{name}, {cores()} cores"


def cores() -> int:
    """Number of cores that this process may use."""
    import os

    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def as_markdown(results: Sequence[Result], *, today: datetime.date | None = None) -> str:
    """The page."""
    day = today or datetime.datetime.now(tz=datetime.UTC).date()
    versions = ", ".join(f"{name} {version(name)}" for name in _PACKAGES)
    lines = [
        "# Benchmark results",
        "",
        "Written by `make bench`. What each case is and how it is measured: `docs/benchmarks.md`.",
        "",
        f"* Hardware: {hardware()}",
        f"* System: {platform.system()} {platform.release()}, Python {platform.python_version()}",
        f"* Versions: {versions}",
        f"* Date: {day.isoformat()}",
        "",
        "| case | value | unit | goal | met | ratio | compared with | checked |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for r in results:
        sign = ">=" if r.case.better == "higher" else "<="
        value = "-" if r.value is None else f"{r.value:.4g}"
        ratio = "-" if r.ratio is None else f"{r.ratio:.3g}"
        reference = r.reference.text + (f" ({r.reference.value:.4g})" if r.reference.value is not None else "")
        lines.append(
            f"| `{r.case.name}` | {value} | {r.case.unit} | {sign} {r.case.goal:g} | {'yes' if r.met else 'no'} "
            f"| {ratio} | {reference} | {r.detail} |"
        )
    lines += ["", *(f"`{r.case.name}`: {r.case.title}  " for r in results), ""]
    return "\n".join(lines)
