"""Froude-Krylov forces on a box barge against Capytaine 3.0.0 (`froude_krylov_force`, 10 x 4 m, draught 1 m, deep
water).

Capytaine: 40 x 16 x 8 panels of constant pressure, rho 1000, g 9.81, moments about the origin in the water plane, per
metre of amplitude, F = Re(f e^{-i omega t}), waves towards beta from x to y. Its panels and our triangles leave 1 %.
"""

import drjit as dr
import numpy as np
import pytest
import trimesh

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.hull_load import hull_load, make_hull

AMPLITUDE = 0.001
CASES = [  # omega [rad/s], beta [deg]; surge, sway, heave [N/m], roll, pitch, yaw [N], with their phase factor
    (0.8, 0, (-24345.36j, 0, 361136.42, 0, -185572.18j, 0)),
    (1.5, 0, (-63911.39j, 0, 247986.39, 0, -490422.82j, 0)),
    (1.5, 45, (-49947.94j, -49947.94j, 274064.26, 35372.39j, -363413.42j, 59785.15)),
    (2.2, 90, (0, -129114.33j, 202683.29, 82752.81j, 0, 0)),
]


@pytest.mark.parametrize(("omega", "beta", "expected"), CASES)
def test_box_barge(omega, beta, expected) -> None:
    box = trimesh.creation.box((10, 4, 2))
    for _ in range(4):
        box = box.subdivide()
    hull = make_hull(np.asarray(box.vertices), np.asarray(box.faces))
    period = 2 * np.pi / omega
    wave = {"type": "regular", "height_m": 2 * AMPLITUDE, "period_s": period, "towards_deg": -beta}
    sea = build_ocean(OceanConfig.model_validate({"temperature_c": 4.0, "salinity": 0, "waves": wave}))
    place, level = jit.Array3f64(0.0, 0.0, 0.0), jit.Array4f64(1.0, 0.0, 0.0, 0.0)
    rho = float(np.array(sea.density(place, jit.Float64(0.0)))[0])
    frozen = jit.freeze(hull_load)
    loads = []
    for quarter in range(4):
        force, moment = frozen(sea, hull, place, level, dr.opaque(jit.Float64, quarter * period / 4))
        loads.append(np.concatenate([np.array(force).ravel(), np.array(moment).ravel()]) * 1000 / rho)
    found = (loads[0] - loads[2] + 1j * (loads[1] - loads[3])) / (2 * AMPLITUDE)
    size = np.abs(expected)
    scale = np.array([size[:3].max()] * 3 + [size[3:].max()] * 3)
    assert np.abs(found - np.array(expected)) / scale == pytest.approx(0, abs=0.01)
