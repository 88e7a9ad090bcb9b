"""A beamformer of one's own over the raw elements of an imaging sonar: delay and sum, and one that adapts.

    python examples/beamform_elements.py [--out FILE]

A remotely operated vehicle looks at the harbour's sunken boat. The device's own picture, delay and sum with Hamming's
weights at three times as many beams, and Capon's beamformer over parts of the array, whose beams are as narrow as the
signal allows: each from the same ping. Writes beamform_elements.png, and prints how far delay and sum with the device's
weights is from the device's own beams.

Source: H. L. Van Trees, Optimum Array Processing (2002), Sections 2.4, 6.2 and 6.12.4, doi 10.1002/0471221104.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import pelagos as pl
from pelagos.sensors.sonar.ping.fan_picture import fan_image

SONAR = {
    "type": "imaging_sonar", "rate_hz": 5, "elements": True, "iq": True, "beams": 128, "horizontal_aperture_deg": 90,
    "bins": 400, "range_max_m": 20.0, "position_m": [0.5, 0.0, 0.0], "orientation_deg": [0, 12, 0],
    "beamwidth_deg": 1.6, "labels": True,
}  # fmt: skip
FINER = 3


def ping() -> tuple[Any, dict[str, Any]]:
    """One reading of the sonar, and its keys as resolved."""
    sim = pl.Simulation.load({
        "seed": 3,
        "tick_rate_hz": 20,
        "world": {"type": "harbour"},
        "agents": {"rov": {
            "vehicle": "bluerov2_heavy",
            "start": {"position_m": [11.0, -10.5], "depth_m": 10.5, "heading_deg": 10.0},
            "sensors": {"sonar": SONAR},
        }},
    })  # fmt: skip
    for _ in range(40):
        seen = sim.step()["rov"]
        if "sonar" in seen:
            return seen["sonar"], sim.model.agents["rov"].sensors["sonar"].sensor.config
    raise RuntimeError("no ping within 2 s")


def steering(y: Any, azimuth: Any, wavelength: float) -> Any:
    """Phases of a plane wave from each azimuth at each element `(len(azimuth), len(y))`."""
    return np.exp(2j * np.pi / wavelength * np.outer(np.sin(azimuth), y))


def delay_and_sum(signals: Any, waves: Any, weights: Any) -> Any:
    """Beams `(beams, bins)` of signals `(elements, bins)`: each element's phase taken off, the sum by weights."""
    return (waves.conj() * weights) @ signals


def capon(signals: Any, waves: Any, part: int) -> Any:
    """Least power that leaves a plane wave as it is, `(beams, bins)`, over parts of the array [elements].

    Parts of the array that lie side by side, and neighbouring bins, stand for the looks that a single ping lacks.
    """
    count, bins = signals.shape
    parts = np.stack([signals[k : k + part] for k in range(count - part + 1)])  # (looks, part, bins)
    every = np.einsum("kib,kjb->bij", parts, parts.conj()) / len(parts)
    every = (every + np.roll(every, 1, axis=0) + np.roll(every, -1, axis=0)) / 3.0
    load = 0.004 * np.trace(every, axis1=1, axis2=2).real / part
    inverse = np.linalg.inv(every + load[:, None, None] * np.eye(part))
    look = waves[:, :part] / waves[:, :1]
    power = 1.0 / np.einsum("ai,bij,aj->ab", look.conj(), inverse, look, optimize=True).real
    return np.sqrt(np.maximum(power, 1e-30)).reshape(len(waves), bins)


def decibels(amplitude: Any, ranges: Any) -> Any:
    """Level after 30 log r."""
    return 20.0 * np.log10(np.maximum(np.abs(amplitude), 1e-12)) + 30.0 * np.log10(ranges)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("beamform_elements.png"))
    out = parser.parse_args().out
    reading, config = ping()
    signals, azimuth, ranges = reading.extras["elements"][0], *(reading.extras[k] for k in ("azimuth", "range"))
    y, own_weights = reading.extras["element_position"][:, 1], reading.extras["element_weights"]
    wavelength = float(reading.extras["steering_speed"][0]) / config.frequency_hz

    again = delay_and_sum(signals, steering(y, azimuth, wavelength), own_weights)
    own = reading.extras["iq"][0]
    off = np.sum(np.abs(again - own) ** 2) / np.sum(np.abs(own) ** 2)
    print(f"{len(y)} elements; delay and sum with the device's weights is {10 * np.log10(off):.0f} dB off its beams")

    step = (azimuth[1] - azimuth[0]) / FINER
    fine = azimuth[0] + step * (np.arange(FINER * len(azimuth)) - (FINER - 1) / 2)
    waves = steering(y, fine, wavelength)
    hamming = np.hamming(len(y) + 2)[1:-1]
    pictures = {
        "the device's own beams": (azimuth, own),
        "delay and sum, Hamming": (fine, delay_and_sum(signals, waves, hamming / hamming.sum())),
        "Capon": (fine, capon(signals, waves, len(y) // 2)),
    }
    figure, axes = plt.subplots(1, 3, figsize=(15, 5.2), layout="constrained", facecolor="black")
    top = np.percentile(decibels(own, ranges), 99.8)
    for panel, (title, (angles, beams)) in zip(axes, pictures.items(), strict=True):
        fan = fan_image(decibels(beams, ranges), angles, ranges, height=600)
        half = ranges[-1] * fan.shape[1] / fan.shape[0] / 2
        panel.imshow(fan, cmap="copper", vmin=top - 50, vmax=top, extent=(-half, half, 0, ranges[-1]))
        panel.set_title(title, color="white")
        panel.set_xlabel("[m]", color="white")
        panel.tick_params(colors="white")
        panel.set_facecolor("black")
    figure.savefig(out, dpi=110, facecolor="black")
    print(f"wrote {out}")


if __name__ == "__main__":
    main()
