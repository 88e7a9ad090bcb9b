"""Coefficients of floating hulls by Capytaine: `python scripts/bem.py wamv otter`, in an environment that has it.

Writes `src/pelagos/vehicles/catalogue/<vehicle>.bem.json`, FRD, about the origin at the waterline, zero speed, deep
water, per kg/m^3 of the water's density: added mass and damping `(frequencies, 6, 6)`, and the mean drift force in
surge and sway and the moment in yaw `(frequencies, headings, 3)` of a regular wave of amplitude 1 m that travels
towards each heading. Reads the hulls under the vehicle's `afloat`, its mass and its linear damping. What
`scripts/drift.py` wrote there (`own`) stays.
"""

from __future__ import annotations

import json
import logging
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import capytaine
import numpy as np
from capytaine.post_pro.kochin import compute_kochin

from pelagos.vehicles.shape.pontoon import displaced, pontoon_mesh
from pelagos.vehicles.vehicle import Vehicle

CATALOGUE = Path(__file__).parent.parent / "src/pelagos/vehicles/catalogue"
MOTIONS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
FLIP = np.array([1, -1, -1, 1, -1, -1])  # FRD and FLU
HEADINGS = np.arange(0.0, 181.0, 15.0)
GRAVITY = 9.81
WITHOUT_DRIFT = ("surface_vessel", "mariner")  # far field and energy disagree by too much: see docs/ocean.md


@dataclass
class Afloat:
    """What moves freely, FLU, over the water's density: mass, stiffness, and further damping of motion relative to the
    water, `(6, 6)`.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    dissipation: np.ndarray


@dataclass
class Solved:
    """One frequency: added mass and damping `(6, 6)`; drift `(headings, 3)`, and its error by the energy theorem: the
    energy that leaves against the energy that is missing from the wave, relative to the larger.
    """

    added: np.ndarray
    damping: np.ndarray
    drift: np.ndarray
    misfit: float


def floating_body(vertices: np.ndarray, faces: np.ndarray, *, lid: bool) -> Any:
    """A hull that is open at the waterline, from FRD [m]."""
    four = faces if faces.shape[1] == 4 else np.concatenate([faces, faces[:, :1]], axis=1)
    mesh = capytaine.Mesh(vertices * [1, -1, -1], four)
    dofs = capytaine.rigid_body_dofs(rotation_center=(0, 0, 0))
    return capytaine.FloatingBody(mesh=mesh, lid_mesh=mesh.generate_lid() if lid else None, dofs=dofs)


def solve(body: Any, omega: float, free: Afloat | None, headings: np.ndarray, depth: float = np.inf) -> Solved:
    """All six motions and all headings [deg] at one frequency [rad/s]; `free`: None for a body that is held."""
    solver = capytaine.BEMSolver()
    sea = {"body": body, "omega": omega, "rho": 1.0, "g": GRAVITY, "water_depth": depth}
    added, damping = np.zeros((2, 6, 6))
    angles = np.arange(720) * (np.pi / 360)
    waves = np.zeros((6, len(angles)), complex)
    for j, moving in enumerate(MOTIONS if free is not None or not np.isfinite(omega) else ()):
        found = solver.solve(capytaine.RadiationProblem(radiating_dof=moving, **sea), method="indirect")
        added[:, j] = [found.added_masses[k] for k in MOTIONS]
        damping[:, j] = [found.radiation_dampings[k] for k in MOTIONS] if np.isfinite(omega) else 0.0
        waves[j] = compute_kochin(found, angles) if np.isfinite(omega) else 0.0
    drift, misfit = np.zeros((len(headings), 3)), 0.0
    for i, heading in enumerate(headings if np.isfinite(omega) else ()):
        travels = -np.radians(heading)
        problem = capytaine.DiffractionProblem(wave_direction=travels, **sea)
        found = solver.solve(problem, method="indirect")
        kochin, power = compute_kochin(found, angles), 0.0
        if free is not None:
            push = np.array(
                [found.forces[k] + capytaine.bem.airy_waves.froude_krylov_force(problem)[k] for k in MOTIONS]
            )
            resists = -omega * (omega * (free.mass + added) + 1j * (free.dissipation + damping)) + free.stiffness
            water = sheet(body, travels, float(found.wavenumber))
            motion = np.linalg.solve(resists, push - 1j * omega * free.dissipation @ water)
            kochin = kochin + motion @ waves
            power = 0.5 * omega**2 * float(np.real(np.conj(motion) @ free.dissipation @ (motion - water)))
        drift[i], error = far_field(kochin, travels, omega, float(found.wavenumber), depth, power)
        misfit = max(misfit, error)
    return Solved(added, damping, drift * [1, -1, -1], misfit)


def sheet(body: Any, travels: float, k: float) -> np.ndarray:
    """Motion (6) of the water as a rigid sheet under the hull, FLU, in a wave of amplitude 1 m, deep water: what the
    vehicle's own damping acts against.
    """
    centers, areas = body.mesh.faces_centers, body.mesh.faces_areas
    x, y = np.cos(travels), np.sin(travels)
    mean = np.exp(1j * k * (centers[:, :2] @ [x, y])) @ areas / areas.sum()
    return mean * np.array([1j * x, 1j * y, 1.0, 1j * k * y, -1j * k * x, 0.0])


def far_field(
    kochin: np.ndarray, travels: float, omega: float, k: float, depth: float, power: float
) -> tuple[np.ndarray, float]:
    """Mean force (x, y) and moment about z over the density, FLU, from the far field on a regular grid of angles.

    H. Maruo, J. Ship Research 4:1 (1960); J. N. Newman, J. Ship Research 11:51 (1967). What is missing from the wave
    must be what is scattered and what the body's own damping takes, `power`. The force is that of the scattered wave
    alone; the balance is returned as the error.
    """
    wave = 1j * kochin
    count = len(wave)
    angles = np.arange(count) * (2 * np.pi / count)
    orders = np.fft.fftfreq(count, 1 / count)
    series = np.fft.fft(wave) / count
    ahead = series @ np.exp(1j * orders * travels)
    bend = (1j * orders * series) @ np.exp(1j * orders * travels)
    shallow = 1.0
    if np.isfinite(depth):
        kh = k * depth
        shallow = 1 / (np.tanh(kh) * (1 + 2 * kh / np.sinh(2 * kh)))
    out = 2 * np.pi * k**2 * shallow * np.abs(wave) ** 2 * (2 * np.pi / count)
    speed = omega / k
    taken = -2 * np.pi * GRAVITY * k / omega * float(np.imag(ahead))  # momentum missing from the wave
    scattered = float(out.sum())
    given = scattered + power / speed  # momentum that left, and that the damping stands for
    x = scattered * np.cos(travels) - float(out @ np.cos(angles))
    y = scattered * np.sin(travels) - float(out @ np.sin(angles))
    turned = float(np.sum(orders * np.abs(series) ** 2)) * 2 * np.pi
    z = 2 * np.pi * GRAVITY / omega * float(np.real(bend)) - 2 * np.pi * k * shallow * turned
    return np.array([x, y, z]), abs(taken - given) / max(abs(taken), scattered)


def coefficients(body: Any, omega: np.ndarray, free: Afloat) -> dict[str, Any]:
    """Everything that the file holds but its source."""
    found = [solve(body, w, free, HEADINGS) for w in [*omega, np.inf]]
    for w, one in zip(omega, found, strict=False):
        print(f"{w:.2f} rad/s: energy is balanced to {100 * one.misfit:.2g} %", flush=True)
    sign = FLIP[:, None] * FLIP[None, :]
    a, b = (np.stack([getattr(s, key) for s in found]) for key in ("added", "damping"))
    a, b = ((m + m.swapaxes(1, 2)) / 2 * sign for m in (a, b))
    own = np.sqrt(
        np.abs(np.diagonal(a, axis1=1, axis2=2))
    )  # metres and radians differ: each entry by its own two modes
    a[np.abs(a) < 1e-3 * own[:, :, None] * own[:, None, :]] = 0.0  # couplings that symmetry forbids
    b = np.where(np.eye(6) > 0, np.maximum(b, 0.0), b)
    b[:, ~(a != 0).any(axis=0)] = 0.0
    drift = np.stack([s.drift for s in found[:-1]])
    drift[:, [0, -1], 1:] = 0.0  # from ahead and astern, by symmetry
    return {
        "omega_radps": omega, "added_mass_infinite": a[-1], "added_mass": a[:-1], "damping": b[:-1],
        "drift": {"omega_radps": omega, "heading_deg": HEADINGS, "force": drift},
    }  # fmt: skip


def free_floating(body: Any, vehicle: Vehicle, volume: float) -> Afloat:
    """Mass, stiffness and linear damping of a vehicle that displaces `volume` [m^3]."""
    config = vehicle.config
    sign = FLIP[:, None] * FLIP[None, :]
    own = config.body
    body.center_of_mass = own.center_of_gravity * [1, -1, -1]
    stiffness = body.compute_hydrostatic_stiffness(rho=1.0, g=GRAVITY).values
    linear = getattr(config.terms.get("linear_damping"), "diagonal", np.zeros(6))
    mass = own.rigid * sign * (volume / own.rigid[0, 0])
    return Afloat(mass, stiffness, np.diag(np.asarray(linear, float)) / own.density)


def main(name: str) -> None:
    """One vehicle of the catalogue."""
    vehicle = Vehicle.from_catalogue(name)
    config = vehicle.config
    hulls = config.afloat.hulls
    volume = config.body.weight / config.body.gravity / config.body.density
    draught = volume / sum(h.volume_per_draught for h in hulls)
    lots = [pontoon_mesh(h, draught, along=36, down=4, deck=False) for h in hulls]
    closed = sum(displaced(*m) for m in lots)
    vertices = np.concatenate([v for v, _ in lots]) * [1, 1, volume / closed]
    starts = np.cumsum([0, *(len(v) for v, _ in lots[:-1])])
    faces = np.concatenate([f + s for (_, f), s in zip(lots, starts, strict=True)])
    p, q, r = (vertices[faces[:, k]] for k in range(3))
    panel = max(np.linalg.norm(q - p, axis=1).max(), np.linalg.norm(r - q, axis=1).max())
    finest = np.sqrt(2 * np.pi * 9.81 / (6 * panel))  # a wave has six panels or more
    step = 0.25 if config.length_m < 10 else 0.06  # [rad/s]
    omega = np.arange(step, finest, step)
    body = floating_body(vertices, faces, lid=True)
    found = coefficients(body, omega, free_floating(body, vehicle, volume))
    if name in WITHOUT_DRIFT:
        del found["drift"]
    file = CATALOGUE / f"{name}.bem.json"
    kept = json.loads(file.read_text()).get("drift", {}) if file.exists() else {}
    carry_own(kept, found.get("drift", {}))
    text = f"scripts/bem.py with Capytaine {capytaine.__version__}, {len(faces)} panels, draught {draught:.4f} m"
    file.write_text(json.dumps({"source": text, **rounded(found)}) + "\n")


def carry_own(before: dict[str, Any], drift: dict[str, Any]) -> None:
    """Keep what `scripts/drift.py` measured, at this table's frequencies: without it waves would push a hull twice."""
    if not drift or not before.get("own"):
        return
    if list(before["heading_deg"]) != list(HEADINGS):
        raise SystemExit("the drift's `own` has other headings than HEADINGS: run scripts/drift.py again")
    own = np.array(before["own"])
    shape = (len(drift["omega_radps"]), *own.shape[1:])
    table = own.reshape(len(own), -1).T
    drift["own"] = np.stack([np.interp(drift["omega_radps"], before["omega_radps"], c) for c in table]).T.reshape(shape)
    print("`own` is that of the table before: run scripts/drift.py again where hull, mass or damping changed")


def rounded(found: Any) -> Any:
    """Lists of numbers of five digits."""
    if isinstance(found, dict):
        return {key: rounded(value) for key, value in found.items()}
    return np.char.mod("%.5g", found).astype(float).tolist()


if __name__ == "__main__":
    logging.getLogger("capytaine").setLevel(logging.ERROR)
    for given in sys.argv[1:]:
        main(given)
