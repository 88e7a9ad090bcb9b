"""A vehicle's page, written from its catalogue file: `python -m pelagos.vehicles.page docs/vehicles`."""

from __future__ import annotations

import sys
from importlib.resources import files
from pathlib import Path

import numpy as np

from pelagos.vehicles.family import mission_mode
from pelagos.vehicles.load import catalogue_names
from pelagos.vehicles.vehicle import Vehicle


def page(name: str) -> str:
    """Markdown about one vehicle of the catalogue."""
    vehicle = Vehicle.from_catalogue(name)
    parts = [f"# {name}\n\n{vehicle.config.title}.\n", _particulars(vehicle), _modes(vehicle), _missions(vehicle)]
    parts.append(_actuators(vehicle))
    parts += [_terms(vehicle), _mounts(vehicle), _deviations(vehicle), _variants(vehicle), _sources(vehicle)]
    text = (files("pelagos.vehicles.catalogue") / f"{name}.yaml").read_text(encoding="utf-8")
    use = f"In a scenario: `vehicle: {name}`, or with changes `vehicle: {{type: {name}, density_kg_m3: 1000}}`."
    parts.append(f"## Every parameter\n\n{use}\n\n```yaml\n{text}```\n")
    return "\n".join(p for p in parts if p)


def _particulars(vehicle: Vehicle) -> str:
    c, body = vehicle.config, vehicle.config.body
    rigid, added = np.diag(body.rigid), np.diag(body.added)
    rows = [
        ("length x beam x height", f"{c.length_m:g} x {c.beam:g} x {c.height:g} m"),
        ("mass", f"{rigid[0]:.4g} kg"),
        ("inertia about the origin", ", ".join(f"{x:.4g}" for x in rigid[3:]) + " kg m^2"),
        ("added mass", ", ".join(f"{x:.4g}" for x in added[:3]) + " kg"),
        ("added inertia", ", ".join(f"{x:.4g}" for x in added[3:]) + " kg m^2"),
        ("weight, buoyancy when wet", f"{body.weight:.5g} N, {body.buoyancy:.5g} N"),
        ("water (or air)", f"{c.density_kg_m3:g} kg/m^3"),
    ]
    lines = [f"| {name} | {value} |" for name, value in rows]
    return "## Particulars\n\n| | |\n|---|---|\n" + "\n".join(lines) + "\n"


def _modes(vehicle: Vehicle) -> str:
    lines = []
    for mode in vehicle.modes:
        default = " (default)" if mode == vehicle.default_mode else ""
        commands = ", ".join(vehicle.command_names(mode)) or "none"
        lines.append(f"| `{mode}`{default} | {commands} |")
    return "## Control modes\n\n| mode | set-points, in order |\n|---|---|\n" + "\n".join(lines) + "\n"


def _missions(vehicle: Vehicle) -> str:
    found = mission_mode({mode: vehicle.set_points(mode) for mode in vehicle.modes})
    if found is None:
        return ""
    mode, family = found
    e = vehicle.config.envelope
    rows = [
        ("steered by", f"mode `{mode}`"),
        ("legs", ", ".join(f"`{leg}`" for leg in family.legs)),
        ("at a place", "stays" if family.stops else "circles"),
        ("looks where it does not go", "yes" if family.turns else "no"),
        ("speed where a leg gives none", f"{e.cruise_mps:g} m/s"),
        ("largest speed", "not stated" if e.top_mps is None else f"{e.top_mps:g} m/s"),
        ("a place counts as reached within", f"{e.tolerance_m:g} m"),
    ]
    if e.turn_radius_m is not None:
        banked = "" if e.turn_speed_mps is None else f" at {e.turn_speed_mps:g} m/s, as the square of the speed"
        rows.append(("smallest circle", f"{e.turn_radius_m:g} m{banked}"))
    if e.slow_mps is not None:
        rows.append(("least speed that steers", f"{e.slow_mps:g} m/s"))
    if e.depth_m is not None:
        rows.append(("largest depth", f"{e.depth_m:g} m"))
    lines = [f"| {name} | {value} |" for name, value in rows]
    return "## Missions\n\nSee [missions](../missions.md).\n\n| | |\n|---|---|\n" + "\n".join(lines) + "\n"


def _actuators(vehicle: Vehicle) -> str:
    lines = []
    for name, part in vehicle.model.actuators.items():
        lag = part.lag
        most = getattr(lag, "rate_limit", None)
        rate = "" if most is None else f", at most {most:.4g} a second"
        lines.append(f"| `{name}` | {part.unit} | {lag.low:.4g} .. {lag.high:.4g} | {lag.time_constant:g} s{rate} |")
    return "## Actuators\n\n| name | unit | limits | lag |\n|---|---|---|---|\n" + "\n".join(lines) + "\n"


def _terms(vehicle: Vehicle) -> str:
    lines = []
    for name, term in vehicle.config.terms.items():
        if term is not None:
            what = (type(term).__doc__ or "").strip().split("\n")[0]
            lines.append(f"* `{name}` ({term.type}): {what}")
    return "## Terms of the equation of motion\n\n" + "\n".join(lines) + "\n"


def _mounts(vehicle: Vehicle) -> str:
    rows = [f"| `{name}` | {x:g}, {y:g}, {z:g} |" for name, (x, y, z) in vehicle.config.mounts.items()]
    said = (
        "A sensor that is given no `position_m` stands at the `antenna` (gps, ais, radio), `mast` (LiDAR) or `keel` "
        "(sonars, acoustic modems, instruments for the water), at the origin where the vehicle has no such place.\n"
    )
    return (
        f"## Places for sensors\n\n{said}\n| | forward, left, up of the origin [m] |\n|---|---|\n"
        + "\n".join(rows)
        + "\n"
    )


def _deviations(vehicle: Vehicle) -> str:
    if not vehicle.config.as_published:
        return ""
    return (
        "## Where it differs from the publication\n\nThe block `as_published` at the end of the file undoes every "
        "deviation; `Vehicle.accelerations` is the model as published, the simulator flies the other.\n"
    )


def _variants(vehicle: Vehicle) -> str:
    names = ", ".join(f"`{v}`" for v in vehicle.config.variants)
    return f"## Other parameter sets\n\n`variant:` {names}, each used as a whole.\n" if names else ""


def _sources(vehicle: Vehicle) -> str:
    lines = [f"* **{key}**: {text}" for key, text in vehicle.config.sources.items()]
    return "## Sources\n\n" + "\n".join(lines) + "\n"


def main(folder: str) -> None:
    """Write one page a vehicle."""
    for name in catalogue_names():
        (Path(folder) / f"{name}.md").write_text(page(name), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
