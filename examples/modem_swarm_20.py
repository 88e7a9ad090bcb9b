"""Twenty AUVs share the water by TDMA: how many of the others each one heard in a frame."""

from __future__ import annotations

from collections import Counter

import pelagos as pl
from pelagos.bench.cases.communication import swarm


def main(vehicles: int = 20, seconds: float = 24.0) -> Counter[str]:
    """Packets received, by receiver."""
    sim = pl.Simulation.load(swarm(vehicles))
    heard: Counter[str] = Counter()
    for name in sim.model.agents:
        sim.subscribe(f"{name}.modem", lambda reading, name=name: heard.update([name] * len(reading.packets)))
    sim.run(seconds)
    for name, count in sorted(heard.items(), key=lambda pair: int(pair[0].removeprefix("auv"))):
        print(f"{name}: {count} packets of the {vehicles - 1} others")
    return heard


if __name__ == "__main__":
    main()
