"""`pelagos manoeuvre`: standard manoeuvres of a vehicle with their numbers, limits and picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rich.table import Table

from pelagos.cli.console import out as console
from pelagos.errors import InputError, LookupFailed
from pelagos.files import write_whole
from pelagos.manoeuvres.orders import Orders
from pelagos.manoeuvres.standard import run_manoeuvre


def show_manoeuvre(
    vehicle: str,
    name: str,
    orders: Orders,
    *,
    out: Path | None,
    as_json: bool,
    variant: str | None = None,
    trust: bool = False,
) -> None:
    """Run it, print its numbers, draw it where `out` names a file.

    Raises:
        InputError: no such vehicle, variant or manoeuvre, or the file cannot be written.
    """
    if out is not None and (out.suffix.lower() != ".png" or not out.parent.is_dir()):
        raise InputError(f"--out {out}: give a file that ends in .png, in a folder that exists")
    trial = run_manoeuvre(_vehicle(vehicle, variant, trust), name, orders)
    if as_json:
        rows = [
            {"name": m.name, "value": m.value, "unit": m.unit, "limit": m.limit, "kept": m.kept} for m in trial.measures
        ]
        told = {
            "vehicle": trial.vehicle,
            "variant": trial.variant,
            "manoeuvre": name,
            "ordered": trial.ordered,
            "measures": rows,
        }
        console.print_json(json.dumps(told))
    else:
        table = Table(title=trial.title, box=None, title_justify="left")
        for head in ("quantity", "value", "unit", "IMO limit", ""):
            table.add_column(head, justify="right" if head in ("value", "IMO limit") else "left")
        for m in trial.measures:
            kept = {True: "kept", False: "NOT KEPT", None: ""}[m.kept]
            table.add_row(m.name, f"{m.value:.4g}", m.unit, "" if m.limit is None else f"{m.limit:.4g}", kept)
        console.print(table)
    if out is not None:
        from pelagos.manoeuvres.picture import draw

        write_whole(out, draw(trial))


def _vehicle(given: str, variant: str | None, trust: bool) -> dict[str, Any]:
    if given.endswith((".yaml", ".yml")):
        if variant is not None:
            raise InputError(f"--variant {variant}: is for vehicles of the catalogue; write `variant:` into {given}")
        from pelagos.vehicles.vehicle import Vehicle

        return Vehicle.from_yaml(given, trust=trust).config.model_dump(mode="json")
    from pelagos.vehicles.load import catalogue_names

    if given not in catalogue_names():
        raise LookupFailed("vehicle", given, catalogue_names())
    return {"type": given} if variant is None else {"type": given, "variant": variant}
