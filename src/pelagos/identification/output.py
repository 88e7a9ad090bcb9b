"""Results of a fit: the vehicle as YAML with its provenance, numbers as JSON, pictures and a page."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pelagos.files import write_whole
from pelagos.identification.coordinates import ANGLES, COORDINATES, RATES, UNITS, number
from pelagos.identification.fit import Estimate, Fit, Score
from pelagos.report import theme
from pelagos.report.page import Section, Tile, image, page, table

_SHOWN = 3  # shots in the picture


def write_fit(made: Fit, folder: Path, *, data: str, title: str) -> list[Path]:
    """Write `vehicle.yaml`, `fit.json`, `fit.png` and `fit.html` into a folder, which is made.

    Args:
        made: the fit; folder: where to; data: name of the record; title: of the page.

    Returns:
        the files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / name for name in ("vehicle.yaml", "fit.json", "fit.png", "fit.html")]
    write_whole(files[0], vehicle_yaml(made, data=data))
    write_whole(files[1], json.dumps(as_data(made), indent=1) + "\n")
    picture = draw(made)
    write_whole(files[2], picture)
    write_whole(files[3], _page(made, picture, data=data, title=title))
    return files


def vehicle_yaml(made: Fit, *, data: str) -> str:
    """The fitted vehicle as a scenario has it under `vehicle:`; its first lines say where its numbers come from."""
    quality = made.test or made.train
    lines = [
        f"Fitted by pelagos {version('pelagos')} on {datetime.now(UTC).date()} to {data}: {made.train.seconds:.0f} s.",
        f"Open loop over {made.plan.segment_s:g} s, "
        f"{'unseen' if made.test else 'fitted'} part ({quality.seconds:.0f} s):"
        + ",".join(f" {n} R2 {quality.r2[n]:.3f}" for n in quality.r2 if n not in COORDINATES[:6]),
        *(
            f"{e.parameter.name} = {e.value:.6g} [{e.low:.6g}, {e.high:.6g}], prior {e.parameter.prior:.6g}"
            + ("" if e.identified else f"  NOT IDENTIFIED: {_why(e)}")
            for e in made.estimates
        ),
        "Intervals: 95 %, the wider of Fisher's and that of resampled shots.",
        *(f"DOUBTFUL: {text}" for text in made.doubts),
    ]
    head = "".join(f"# {line}\n" for line in lines)
    kept = {k: v for k, v in made.vehicle.items() if v not in (None, {}, [], "")}
    body = yaml.safe_dump(
        {**kept, "variant": None} if "variants" in kept else kept, sort_keys=False, allow_unicode=True
    )
    return head + body


def _why(e: Estimate) -> str:
    """Reason for which a parameter is not identified."""
    if not e.felt:
        return "nothing that was recorded depends on it, this is the prior"
    return "it stands at its bound" if e.bounded else "the record says little, this is mostly the prior"


def as_data(made: Fit) -> dict[str, Any]:
    """All numbers of a fit, for JSON."""
    return {
        "parameters": {e.parameter.name: _estimate(e) for e in made.estimates},
        "alike": [list(pair) for pair in made.certainty.alike],
        "train": _score(made.train), "test": None if made.test is None else _score(made.test),
        "before": _score(made.before), "residual_memory_rows": made.certainty.memory, "settled": made.found.settled,
        "doubts": list(made.doubts),
        "step_s": made.record.step_s, "substeps": made.substeps, "seconds": made.seconds,
    }  # fmt: skip


def _estimate(e: Estimate) -> dict[str, Any]:
    return {
        "value": e.value, "interval_95": [e.low, e.high], "fisher_95": list(e.fisher),
        "bootstrap_95": list(e.resampled) if e.resampled else None,
        "prior": e.parameter.prior, "paths": list(e.parameter.paths), "identified": e.identified, "at_bound": e.bounded,
        "told": e.told, "step_shift": e.step_shift, "has_influence": e.felt,
    }  # fmt: skip


def _score(s: Score) -> dict[str, Any]:
    return {"r2": dict(s.r2), "rms": dict(s.rms), "shots": s.shots, "seconds": s.seconds}


def draw(made: Fit) -> bytes:
    """PNG: the last shots, recorded and simulated in open loop, and the parameters with their intervals."""
    with theme.style():
        figure = theme.figure(11.0, 7.2)
        left, right = figure.subfigures(1, 2, width_ratios=[1.7, 1.0])
        _draw_shots(made, left)
        _draw_parameters(made, right)
        return theme.as_png(figure)


def _draw_shots(made: Fit, where: Any) -> None:
    seen, shots = made.simulated
    h = made.record.step_s
    fitted = made.plan.fitted
    wanted = {*fitted, *(RATES[n] for n in fitted if n in RATES)}
    there = [n for n in COORDINATES[6:] if made.record.values(n) is not None]
    names = sorted(there, key=lambda n: n not in wanted)[:4]  # what was fitted comes first
    axes = np.atleast_1d(where.subplots(len(names), 1, sharex=True))
    shown = min(_SHOWN, made.test.shots) if made.test else _SHOWN
    last = range(max(0, len(shots) - shown), len(shots))
    for ax, name in zip(axes, names, strict=True):
        values = made.record.values(name)
        assert values is not None
        scale, unit = (180 / np.pi, "deg/s") if "rad" in UNITS[number(name)] else (1.0, "m/s")
        for k in last:
            rows = shots.starts[k] + np.arange(shots.steps + 1)
            t = made.record.start_s + rows * h
            ax.plot(t, scale * values[rows], color=theme.TRUTH, lw=3.0, label="recorded" if k == last[0] else None)
            ax.plot(
                t, scale * seen[:, number(name), k], color=theme.SENSOR, label="open loop" if k == last[0] else None
            )
            ax.axvline(t[0], color=theme.GRID, zorder=0)
        ax.set_ylabel(f"{name} [{unit}]")
    axes[0].legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    axes[0].set_title("Unseen part of the record" if made.test else "End of the record")
    axes[-1].set_xlabel("time [s]")


def _draw_parameters(made: Fit, where: Any) -> None:
    ax = where.subplots()
    for k, e in enumerate(made.estimates):
        size = e.parameter.prior or abs(e.value) or 1.0
        colour = theme.SENSOR if e.identified else theme.MUTED
        ax.plot([e.low / size, e.high / size], [k, k], color=colour, lw=3, alpha=0.5, solid_capstyle="butt")
        ax.plot(e.value / size, k, "o", color=colour, ms=5)
        ax.plot(e.parameter.prior / size, k, "|", color=theme.TRUTH, ms=9)
    ax.set_yticks(range(len(made.estimates)), [e.parameter.name for e in made.estimates])
    ax.invert_yaxis()
    ax.set_xlabel("value / prior (tick); bar: 95 %")
    ax.set_title("Parameters")


def _page(made: Fit, picture: bytes, *, data: str, title: str) -> str:
    quality = made.test or made.train
    best = [n for n in ("u", "v", "r", "w", "p", "q") if n in quality.r2][:3]
    tiles = [Tile(f"{quality.r2[n]:.2f}", "", f"R2 of {n}, open loop {made.plan.segment_s:g} s") for n in best]
    known = sum(e.identified for e in made.estimates)
    tiles += [
        Tile(f"{known}/{len(made.estimates)}", "", "parameters identified"),
        Tile(f"{made.train.seconds:.0f}", "s", "fitted"), Tile(f"{made.seconds:.0f}", "s", "on the clock"),
    ]  # fmt: skip
    rows = [
        (
            e.parameter.name, f"{e.parameter.prior:.5g}", f"{e.value:.5g}", f"{e.low:.5g} to {e.high:.5g}",
            f"{e.fisher[0]:.5g} to {e.fisher[1]:.5g}",
            f"{e.resampled[0]:.5g} to {e.resampled[1]:.5g}" if e.resampled else "",
            e.said,
            ", ".join(e.parameter.paths),
        )
        for e in made.estimates
    ]  # fmt: skip
    alike = "; ".join(f"{a} and {b} ({c:+.3f})" for a, b, c in made.certainty.alike)
    note = (
        f"Not to be told apart by this record (correlation): {alike}." if alike else "No two parameters are confused."
    )
    note = " ".join(
        [note, "95 %: the wider of the two intervals beside it.", *(f"Doubtful: {d}." for d in made.doubts)]
    )
    heads = ("parameter", "prior", "found", "95 %", "Fisher", "resampled", "identified", "key")
    scores = [("fitted part", made.train), ("unseen part", made.test), ("with the priors", made.before)]
    quality_rows = [
        (label, name, f"{s.r2[name]:.3f}" if name in s.r2 else "none: it does not change", _rms(name, s))
        for label, s in scores
        if s is not None
        for name in s.rms
    ]
    return page(
        title=title, kind="Identification", tiles=tiles, foot=f"pelagos {version('pelagos')}",
        text=f"{len(made.estimates)} parameters from {data}",
        sections=[
            Section("Record and simulation", "Shots begin at measured states and obey the recorded commands.",
                    image(theme.data_uri(picture), "recorded and simulated velocities; parameters")),
            Section("Parameters", note, table(heads, rows, numbers=(1, 2, 3, 4, 5), code=(7,))),
            Section("Open loop", f"Shots of {made.plan.segment_s:g} s. R2 = 1 - sum of squared differences over that "
                    "about the mean.", table(("part", "coordinate", "R2", "rms"), quality_rows, numbers=(2, 3))),
        ],
    )  # fmt: skip


def _rms(name: str, s: Score) -> str:
    if name in ANGLES or "rad" in UNITS[number(name)]:
        return f"{np.degrees(s.rms[name]):.3g} deg" + ("/s" if "/s" in UNITS[number(name)] else "")
    return f"{s.rms[name]:.3g} {UNITS[number(name)]}"
