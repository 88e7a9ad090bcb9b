"""`pelagos fit`: a vehicle's parameters from a record of its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from pelagos.cli.console import err, out
from pelagos.config.loader import load_scenario
from pelagos.errors import InputError, LookupFailed


def fit_vehicle(
    path: Path, data: Path, changes: Sequence[str], *, plan: Path, agent: str, folder: Path | None, trust: bool
) -> None:
    """Fit, print a table, write vehicle, numbers, picture and page.

    Raises:
        InputError: scenario, plan or data are wrong, or the data say nothing.
    """
    from pelagos.identification import fit, load_plan, read_record
    from pelagos.identification.output import write_fit
    from pelagos.vehicles.vehicle import Vehicle

    scenario = load_scenario(path, changes=changes, trust=trust)
    name = _agent(scenario.members, agent, path)
    vehicle = scenario.members[name].vehicle
    made_plan = load_plan(plan, recording=data if data.suffix == ".mcap" else None, agent=name)
    names = Vehicle(vehicle).actuator_names
    record = read_record(data, made_plan, names)
    with err.status("fitting") as status:
        made = fit(vehicle, record, made_plan, scenario=scenario, tell=lambda text: status.update(f"fitting: {text}"))
    table = Table(box=None)
    for head in ("parameter", "prior", "found", "95 %", "identified"):
        table.add_column(head, justify="left" if head in ("parameter", "identified") else "right")
    for e in made.estimates:
        table.add_row(
            e.parameter.name, f"{e.parameter.prior:.5g}", f"{e.value:.5g}", f"{e.low:.5g} .. {e.high:.5g}", e.said
        )
    out.print(table)
    for a, b, c in made.certainty.alike:
        out.print(f"cannot be told apart by this record: {a} and {b} (correlation {c:+.3f})", markup=False)
    for label, s in (("fitted", made.train), ("unseen", made.test)):
        if s is not None:
            text = ", ".join(f"{n} {s.r2[n]:.3f}" for n in s.r2)
            out.print(f"open loop {made_plan.segment_s:g} s, {label} part, R2: {text}", markup=False)
    where = folder or Path("results") / f"fit-{data.name.split('.')[0]}"
    files = write_fit(made, where, data=data.name, title=f"{vehicle.type}: {data.name}")
    out.print(f"wrote {', '.join(f.name for f in files)} in {where}", markup=False)


def _agent(members: Mapping[str, Any], agent: str, path: Path) -> str:
    """Name of the agent whose vehicle is fitted."""
    if agent and agent not in members:
        raise LookupFailed("agent", agent, members, where=str(path))
    if not members:
        raise InputError(f"{path} has no agents, and so no vehicle to fit")
    if not agent and len(members) != 1:
        raise InputError(f"{path} has {len(members)} agents ({', '.join(members)}): say which with --agent")
    return agent or next(iter(members))
