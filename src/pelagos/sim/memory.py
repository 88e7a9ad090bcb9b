"""Peak memory of this process."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final

_LINUX: Final = Path("/proc/self/status")


def peak_memory_mb() -> float | None:
    """Peak resident size of this process [MB of 2^20 bytes]; None where the system does not tell.

    Linux's `getrusage` will not do: what it says of a process begins with the peak of the one that started it.
    """
    if _LINUX.exists():
        line = next(text for text in _LINUX.read_text().splitlines() if text.startswith("VmHWM:"))
        return int(line.split()[1]) / 1024
    try:
        import resource
    except ImportError:  # Windows
        return None
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 1024)
