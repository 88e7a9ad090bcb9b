"""Doubts about a fit whose steps are not those of the run that was recorded."""

from __future__ import annotations

from pelagos.identification.certainty import NORMAL_95, Certainty
from pelagos.identification.problem import Problem
from pelagos.identification.record import Record
from pelagos.identification.search import Found
from pelagos.identification.shots import shooter_of
from pelagos.identification.steps import DOUBTED, shift_from
from pelagos.identification.water import Water


def doubts_of_run(problem: Problem, found: Found, sure: Certainty, record: Record, water: Water) -> tuple[str, ...]:
    """Parameters that would come out otherwise in the run's own steps, in words; one play of the shots tells.

    How far is told for `loss: squares` alone: other losses weigh what the steps add otherwise than what was there.
    """
    run, family, shooter = record.run, problem.family, problem.shooter
    integrator, step_s = family.data["integrator"], shooter.grid_s / shooter.substeps
    if run is None or run.are(integrator, step_s):
        return ()
    in_its_steps = shooter_of(family, record, water, integrator=run.integrator)
    ticks = max(1, round(record.step_s / run.tick_s))
    in_its_steps.divide(ticks)
    shift = shift_from(problem, found, in_its_steps)
    shifted = [
        f"{p.name} by {float(x) * p.slope(at):+.2g}" if problem.plan.loss == "squares" else p.name
        for p, x, at, fisher in zip(family.parameters, shift, found.at, sure.fisher, strict=True)
        if abs(x) > DOUBTED * NORMAL_95 * fisher
    ]
    if not shifted:
        return ()
    said = problem.plan.vehicle.get("integrator", run.integrator) != run.integrator
    cure = f"give integrator: {run.integrator}, step_s: {ticks * run.tick_s:.6g} and substeps: {ticks}"
    return (
        f"the run was made in steps of {1000 * run.tick_s:.3g} ms ({run.integrator}), the fit in steps of "
        f"{1000 * step_s:.3g} ms ({integrator}), which shifts {', '.join(shifted)}: {cure}"
        f"{', and leave integrator out under vehicle' if said else ''}",
    )
