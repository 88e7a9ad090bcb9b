"""Radiation coefficients of floating hulls by Capytaine: `python scripts/bem.py wamv`, in an environment that has it.

Writes `src/pelagos/vehicles/catalogue/<vehicle>.bem.json`: added mass and damping `(frequencies, 6, 6)` at zero speed
about the origin at the waterline, FRD, deep water, per kg/m^3 of the water's density. Reads the hulls under the
vehicle's `afloat`.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import capytaine
import numpy as np
import yaml

from pelagos.vehicles.shape.pontoon import PontoonConfig, displaced, pontoon_mesh

CATALOGUE = Path(__file__).parent.parent / "src/pelagos/vehicles/catalogue"
MOTIONS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
FLIP = np.array([1, -1, -1, 1, -1, -1])  # FRD and FLU


def radiation(vertices: np.ndarray, faces: np.ndarray, omega: np.ndarray, *, lid: bool) -> dict[str, Any]:
    """Coefficients of a hull that is open at the waterline, FRD [m]; the last frequency is infinity."""
    four = np.concatenate([faces, faces[:, :1]], axis=1)
    mesh = capytaine.Mesh(vertices * [1, -1, -1], four)
    body = capytaine.FloatingBody(
        mesh=mesh,
        lid_mesh=mesh.generate_lid() if lid else None,
        dofs=capytaine.rigid_body_dofs(rotation_center=(0, 0, 0)),
    )
    solver = capytaine.BEMSolver()
    added, damping = np.zeros((2, len(omega) + 1, 6, 6))
    for i, w in enumerate([*omega, np.inf]):
        for j, moving in enumerate(MOTIONS):
            problem = capytaine.RadiationProblem(body=body, omega=w, radiating_dof=moving, rho=1.0, g=9.81)
            found = solver.solve(problem, keep_details=False)
            added[i, :, j] = [found.added_masses[k] for k in MOTIONS]
            damping[i, :, j] = [found.radiation_dampings[k] for k in MOTIONS] if np.isfinite(w) else 0.0
    sign = FLIP[:, None] * FLIP[None, :]
    a, b = ((m + m.swapaxes(1, 2)) / 2 * sign for m in (added, damping))
    scale = np.abs(a).max(axis=(1, 2), keepdims=True)
    a[np.abs(a) < 1e-3 * scale] = 0.0  # couplings that symmetry forbids
    b = np.where(np.eye(6) > 0, np.maximum(b, 0.0), b)
    b[:, ~(a != 0).any(axis=0)] = 0.0
    return {"omega_radps": omega, "added_mass_infinite": a[-1], "added_mass": a[:-1], "damping": b[:-1]}


def main(name: str) -> None:
    """One vehicle of the catalogue."""
    data = yaml.safe_load((CATALOGUE / f"{name}.yaml").read_text())
    hulls = [PontoonConfig.model_validate(h) for h in data["afloat"]["hulls"]]
    volume = data["mass"]["mass_kg"] / data["density_kg_m3"]
    draught = volume / sum(h.volume_per_draught for h in hulls)
    lots = [pontoon_mesh(h, draught, along=36, down=4, deck=False) for h in hulls]
    closed = sum(displaced(*m) for m in lots)
    vertices = np.concatenate([v for v, _ in lots]) * [1, 1, volume / closed]
    starts = np.cumsum([0, *(len(v) for v, _ in lots[:-1])])
    faces = np.concatenate([f + s for (_, f), s in zip(lots, starts, strict=True)])
    p, q, r = (vertices[faces[:, k]] for k in range(3))
    panel = max(np.linalg.norm(q - p, axis=1).max(), np.linalg.norm(r - q, axis=1).max())
    finest = np.sqrt(2 * np.pi * 9.81 / (6 * panel))  # a wave has six panels or more
    omega = np.arange(0.25, finest, 0.25)
    found = radiation(vertices, faces, omega, lid=True)
    text = f"scripts/bem.py with Capytaine {capytaine.__version__}, {len(faces)} panels, draught {draught:.4f} m"
    rows = {key: np.char.mod("%.5g", value).astype(float).tolist() for key, value in found.items()}
    (CATALOGUE / f"{name}.bem.json").write_text(json.dumps({"source": text, **rows}) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
