"""A subscriber in a process of its own, for benchmarks: counts what it receives, and how old it was."""

from __future__ import annotations

import json
import struct
import sys
import time

import numpy as np


def main() -> None:
    """`ros2_peer.py DOMAIN topic=type ...`; says "ready", and its account when its input ends."""
    from pelagos.bridges.dds import DdsTransport
    from pelagos.bridges.transport import Qos

    transport = DdsTransport(domain=int(sys.argv[1]), node="peer")
    ages: list[float] = []
    received: list[int] = []

    def receive(raw: bytes) -> None:
        now = time.monotonic_ns()
        seconds, nanoseconds = struct.unpack_from("<iI", raw, 4) if len(raw) >= 12 else (0, 0)
        received.append(now)
        ages.append(now - (seconds * 1_000_000_000 + nanoseconds))

    for argument in sys.argv[2:]:
        topic, _, type_name = argument.partition("=")
        transport.subscribe(topic, type_name, receive, qos=Qos(depth=200))
    print("ready", flush=True)
    sys.stdin.read()
    transport.close()
    p50, p99 = np.percentile(np.array(ages), [50, 99]) * 1e-6 if ages else (0.0, 0.0)
    span_s = (received[-1] - received[0]) * 1e-9 if received else 0.0
    account = {"count": len(ages), "p50_ms": float(p50), "p99_ms": float(p99), "span_s": span_s}
    print(json.dumps(account), flush=True)


if __name__ == "__main__":
    main()
