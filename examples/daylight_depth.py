"""Downward irradiance against depth in ten kinds of water: the light field that cameras see, beside the tables' Kd.

python examples/daylight_depth.py [PICTURE]
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos.optics.radiative_transfer import Above, WaterChannel, gauss, media, solve
from pelagos.optics.water import (
    JERLOV_TYPES,
    REFRACTIVE_INDEX,
    channel_means,
    spectra,
    table_sun,
    water_optics,
)

COLOURS = {"red": "#c0392b", "green": "#1e8449", "blue": "#21618c"}
LEAST = 0.01  # share of light down to which it is drawn


def irradiance(medium: WaterChannel, depths: NDArray[np.float64], sun: float) -> NDArray[np.float64]:
    """On level ground from above, over that just below the surface, under parallel light whose cosine from the zenith
    is `sun` in the water."""
    u, weight = gauss(math.sqrt(1 - REFRACTIVE_INDEX**-2), 1, 16)
    field = solve(medium, Above(sun, 1.0, u, weight, np.zeros(16)), depths)
    scattered = 2 * math.pi * field.radiance[:, :, 0] @ (field.weight * np.maximum(field.u, 0))
    straight = sun * np.exp(-medium.attenuation * depths / sun)
    whole = scattered * np.exp(-medium.decay * depths) + straight
    return np.asarray(whole / whole[0])


def main() -> None:
    """Draw them, and print how far the table is from the solution."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", nargs="?", default="daylight_depth.png", type=Path)
    path = parser.parse_args().picture
    figure = Figure(figsize=(13, 6.4), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 5, sharex=True)
    print("     light at the tables' tenth, over it     farthest from exp(-Kd z) above it")
    print("     red, green, blue                        red, green, blue")
    for name, panel in zip(JERLOV_TYPES, panels.flat, strict=True):
        water, sun = water_optics(name), table_sun(name)
        table = channel_means(spectra(name).downwelling)
        ends, most = [], []
        for (colour, line), kd, medium in zip(COLOURS.items(), table, media(water), strict=True):
            depths = np.linspace(0, math.log(1 / LEAST) / kd, 120)
            light = irradiance(medium, depths, sun)
            panel.semilogx(light, depths, color=line, label=colour)
            panel.semilogx(np.exp(-kd * depths), depths, color=line, linestyle="--", linewidth=1)
            tenth = math.log(10) / kd
            panel.plot([0.1], [tenth], "o", color=line, markersize=4)
            over = light * np.exp(kd * depths) - 1
            ends.append(1 + float(np.interp(tenth, depths, over)))
            most.append(float(over[depths <= tenth].max()))
        there, half = (" ".join(f"{v:7.4f}" for v in values) for values in (ends, most))
        print(f"{name:4s} {there}                 {half}")
        panel.set_title(f"type {name}", fontsize=10)
        panel.set_xlim(LEAST, 1)
        panel.set_ylim(max(math.log(1 / LEAST) / kd for kd in table), 0)
        panel.grid(alpha=0.3)
    panels[0, 0].legend(fontsize=8, loc="lower right")
    figure.supxlabel(
        "downward irradiance over that just below the surface: solved (full), exp(-Kd z) (dashed)", fontsize=10
    )
    figure.supylabel("depth [m]", fontsize=10)
    figure.savefig(path, dpi=80)


if __name__ == "__main__":
    main()
