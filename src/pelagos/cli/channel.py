"""`pelagos channel`: the paths of sound between two places of a scenario, as a table and a picture."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.markup import escape
from rich.table import Table

from pelagos.cli.console import out as console
from pelagos.cli.console import shown
from pelagos.cli.trusted import load
from pelagos.errors import InputError
from pelagos.files import write_whole

_ROWS = 20


def show_channel(
    path: Path, changes: Sequence[str], ends: tuple[str, str], *, frequency_hz: float, at_s: float, out: Path | None,
    as_json: bool, trust: bool = False,
) -> None:  # fmt: skip
    """Print arrivals, and draw them where `out` names a file.

    Raises:
        InputError: an end is neither an agent nor a place, or the file cannot be written.
    """
    if out is not None and (out.suffix.lower() != ".png" or not out.parent.is_dir()):
        raise InputError(f"--out {out}: give a file that ends in .png, in a folder that exists")
    if not at_s >= 0:
        raise InputError(f"--at {at_s}: a time from 0 on [s]")
    scenario = load(path, changes, trust=trust)
    from pelagos.sim.channel import channel
    from pelagos.sim.simulation import Simulation

    sim = Simulation.load(scenario)
    if at_s > 0:
        sim.run(at_s)
    made = channel(sim, _end(ends[0]), _end(ends[1]), frequency_hz=frequency_hz)
    a = made.arrivals()
    if as_json:
        console.print_json(json.dumps(_as_dict(made)))
    else:
        _print(made, ends)
    if out is not None:
        from pelagos.report.channel import draw_channel

        write_whole(out, draw_channel(made, title=f"{scenario.name}: {ends[0]} to {ends[1]}"))
        if not as_json:
            console.print(f"written: {shown(out)}", markup=False)
    if len(a) == 0 and not as_json:
        console.print("no ray leads there: a shadow zone, or a bottom in between")


def _end(text: str) -> str | tuple[float, ...]:
    if "," not in text:
        return text
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{text!r}: a place is x,y,z, three numbers [m]; an agent's name has no comma") from None


def _as_dict(made: Any) -> dict[str, Any]:
    a = made.arrivals()
    return {
        "frequency_hz": made.frequency_hz,
        "transmission_loss_db": made.transmission_loss() if len(a) else None,
        "noise_db": made.noise_level_db(),
        "arrivals": [
            {"delay_s": float(a.delay[k]), "loss_db": float(a.loss_db[k]), "phase_rad": float(a.phase[k]),
             "departure_deg": float(np.degrees(a.departure_angle[k])),
             "arrival_deg": float(np.degrees(a.arrival_angle[k])), "surface": int(a.surface[k]),
             "bottom": int(a.bottom[k]), "doppler": float(a.doppler[k]), "blocked": bool(a.blocked[k])}
            for k in range(len(a))
        ],
    }  # fmt: skip


def _print(made: Any, ends: tuple[str, str]) -> None:
    a = made.arrivals()
    way = float(np.linalg.norm(made.receiver - made.source))
    console.print(
        f"{ends[0]} to {ends[1]}: {way:.1f} m, depths {made.depths[0]:.1f} and {made.depths[1]:.1f} m, "
        f"{made.frequency_hz / 1e3:g} kHz, noise {made.noise_level_db():.1f} dB re 1 uPa^2/Hz",
        markup=False,
    )
    if not len(a):
        return
    table = Table()
    angles = "phase\n[deg]", "leaves\n[deg]", "arrives\n[deg]"
    for head in ("delay\n[ms]", "loss\n[dB]", *angles, "surface", "bottom", "Doppler"):
        table.add_column(escape(head), no_wrap=True, justify="right")
    for k in np.argsort(a.delay, kind="stable")[:_ROWS]:
        table.add_row(
            f"{1e3 * a.delay[k]:.4f}", "blocked" if a.blocked[k] else f"{a.loss_db[k]:.1f}",
            f"{np.degrees(a.phase[k]):.0f}",
            f"{np.degrees(a.departure_angle[k]):.2f}", f"{np.degrees(a.arrival_angle[k]):.2f}", str(a.surface[k]),
            str(a.bottom[k]), f"{a.doppler[k]:.6f}",
        )  # fmt: skip
    console.print(table)
    if len(a) > _ROWS:
        console.print(f"... and {len(a) - _ROWS} later ones")
    console.print(f"all together: {made.transmission_loss():.1f} dB re 1 m (powers added)")
