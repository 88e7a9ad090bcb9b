"""Coefficients of floating hulls by strip theory: `python scripts/strips.py mariner --top-mps 7.72`.

Writes `src/pelagos/vehicles/catalogue/<vehicle>_strips.bem.json` (or `--out`), FRD, about the origin at the waterline,
deep water, per kg/m^3 of the water's density: added mass and damping, and the force of the scattered wave at speeds
ahead from zero to the top one. No panel method is needed: any floating hull of the catalogue, or of a YAML file with
the keys of a vehicle, gets coefficients, by `hulls` or `mesh` of its `afloat`. See `pelagos.hydro.strips` for what
strips can say; surge keeps the vehicle's own added mass.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from pelagos.hydro.strips import Strips, strips_of
from pelagos.vehicles.hull_at_rest import to_waterline
from pelagos.vehicles.shape.floating_mesh import float_mesh
from pelagos.vehicles.shape.pontoon import displaced
from pelagos.vehicles.shape.stations import mesh_stations, pontoon_stations
from pelagos.vehicles.vehicle import Vehicle

CATALOGUE = Path(__file__).parent.parent / "src/pelagos/vehicles/catalogue"
HEADINGS = np.arange(0.0, 181.0, 15.0)
PER_LENGTH = np.sqrt(2 * np.pi * 9.81)  # rad/s of a wave of 1 m
SWELLS, LONGEST, SHORTEST = 60.0, 12.0, 0.28  # hull lengths: waves of the table, few up to LONGEST, then evenly
SPEEDS = 4


def strips(vehicle: Vehicle, top: float) -> Strips:
    """Waves about the vehicle's sections, from long waves up to the shortest met at the top speed [m/s]."""
    config = vehicle.config
    afloat, body = config.afloat, config.body
    if afloat is None:
        raise SystemExit(f"{vehicle.name} does not float: it has no `afloat`")
    volume = body.weight / body.gravity / body.density
    if afloat.mesh is not None:
        hull = float_mesh(afloat.mesh, volume)
        stations = mesh_stations(hull.vertices, hull.faces)
    else:
        draught = volume / sum(h.volume_per_draught for h in afloat.hulls)
        draught *= volume / sum(displaced(*to_waterline(h, draught)) for h in afloat.hulls)
        stations = pontoon_stations(afloat.hulls, draught)
    shortest = PER_LENGTH / np.sqrt(SHORTEST * config.length_m)
    fastest = shortest + shortest**2 / 9.81 * top
    omega = np.geomspace(PER_LENGTH / np.sqrt(SWELLS * config.length_m), fastest, 32)
    return strips_of(stations, omega)


def coefficients(found: Strips, vehicle: Vehicle, top: float) -> dict[str, Any]:
    """Everything that the file holds but its source."""
    body, length = vehicle.config.body, vehicle.config.length_m
    added, damping = found.coefficients()
    infinite = found.added_mass_infinite()
    for matrix in (infinite, *added):
        matrix[0, 0] = body.added[0, 0] / body.density
    long = PER_LENGTH / np.sqrt(LONGEST * length)
    swells = np.geomspace(PER_LENGTH / np.sqrt(SWELLS * length), long, 6)[:-1]
    omega = np.concatenate([swells, np.linspace(long, PER_LENGTH / np.sqrt(SHORTEST * length), 24)])
    speeds = np.linspace(0.0, top, SPEEDS)
    scattered = np.array(
        [[[found.excitation(w, h, u)[1] for h in np.radians(HEADINGS)] for w in omega] for u in speeds]
    )
    scattered[:, :, [0, -1]] *= [1, 0, 1, 0, 1, 0]  # from ahead and astern, by symmetry
    return {
        "omega_radps": found.omega, "added_mass_infinite": clean(infinite[None])[0], "added_mass": clean(added),
        "damping": clean(damping),
        "diffraction": {"omega_radps": omega, "heading_deg": HEADINGS, "speed_mps": speeds,
                        "real": scattered.real, "imaginary": scattered.imag},
    }  # fmt: skip


def clean(matrices: np.ndarray) -> np.ndarray:
    """Symmetric, and without couplings that rounding leaves, each entry by its own two modes."""
    matrices = (matrices + matrices.swapaxes(1, 2)) / 2
    own = np.sqrt(np.abs(np.diagonal(matrices, axis1=1, axis2=2)).max(axis=0))
    small = np.abs(matrices).max(axis=0) < 1e-6 * own[:, None] * own
    return np.where(small, 0.0, matrices)


def rounded(found: Any) -> Any:
    """Lists of numbers of five digits."""
    if isinstance(found, dict):
        return {key: rounded(value) for key, value in found.items()}
    return np.char.mod("%.5g", found).astype(float).tolist()


def main() -> None:
    """One vehicle."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("vehicle", help="a name of the catalogue, or a YAML file")
    parser.add_argument("--top-mps", type=float, required=True, help="highest speed of the table [m/s]")
    parser.add_argument("--out", type=Path, help="file to write")
    given = parser.parse_args()
    of_file = given.vehicle.endswith((".yaml", ".yml"))
    if of_file and given.out is None:
        raise SystemExit("a vehicle from a file needs --out")
    vehicle = Vehicle.from_yaml(given.vehicle) if of_file else Vehicle.from_catalogue(given.vehicle)
    froude = given.top_mps / np.sqrt(9.81 * vehicle.config.length_m)
    if not 0 < froude <= 0.4:
        raise SystemExit(
            f"--top-mps {given.top_mps:g} is a Froude number of {froude:.2f}: strip theory holds up to 0.4"
        )
    found = strips(vehicle, given.top_mps)
    text = f"scripts/strips.py, {len(found.stations)} stations by pelagos.hydro.strips"
    file = given.out or CATALOGUE / f"{given.vehicle}_strips.bem.json"
    table = coefficients(found, vehicle, given.top_mps)
    file.write_text(json.dumps({"source": text, **rounded(table)}) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
