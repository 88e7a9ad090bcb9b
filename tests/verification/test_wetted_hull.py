"""Wetted hulls against closed forms: volumes, moments, stiffness, and pressures of waves."""

import numpy as np
import pytest
import trimesh

from pelagos import jit
from pelagos.hydro.wave_load import across, morison, moving_water, newman_drift, strip_wrench, wind_wrench
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.hull_load import Hull, hull_load, make_hull

G = 9.81
STILL = build_ocean(OceanConfig(temperature_c=0.0, salinity=0.0))
LOAD = jit.freeze(hull_load)


def quaternion(axis, angle: float):
    axis = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])


def load(hull: Hull, z: float, q=(1, 0, 0, 0), ocean=STILL, t: float = 0.0, at=(0.0, 0.0)):
    position = jit.Array3f64(float(at[0]), float(at[1]), float(z))
    f, m = LOAD(ocean, hull, position, jit.Array4f64(*(float(v) for v in q)), jit.Float64(float(t)))
    rho = float(np.array(ocean.density(jit.Array3f64(0.0, 0.0, min(float(z), 0.0)), jit.Float64(0.0)))[0])
    return np.array(f).ravel() / (rho * G), np.array(m).ravel() / (rho * G)


def mesh(shape) -> Hull:
    return make_hull(np.asarray(shape.vertices), np.asarray(shape.faces))


def cut_volume(shape, q, z):
    """Volume and centroid (about the origin of the body, world axes) below the surface, by another library's mesh
    cutter.
    """
    matrix = trimesh.transformations.quaternion_matrix(q)
    matrix[2, 3] = z
    wet = shape.copy().apply_transform(matrix)
    wet = trimesh.intersections.slice_mesh_plane(wet, (0, 0, -1), (0, 0, 0), cap=True, engine="manifold")
    return wet.volume, wet.center_mass - np.array([0, 0, z])


@pytest.mark.parametrize("z", [-3.0, -0.5, -0.2, 0.0, 0.49, 0.6])
def test_box_at_any_draft(z: float) -> None:
    hull = mesh(trimesh.creation.box((4, 2, 1)))
    wet = np.clip(0.5 - z, 0, 1)
    force, moment = load(hull, z, at=(7.0, -12.0))
    assert force == pytest.approx([0, 0, 8 * wet], abs=1e-12)
    assert moment == pytest.approx([0, 0, 0], abs=1e-12)


@pytest.mark.parametrize("angle", [0.05, 0.3, np.pi / 4, 1.2, 2.5])
def test_box_at_any_roll(angle: float) -> None:
    """Origin in the surface: half of a centrally symmetric body is wet. While the deck is dry, the righting moment is
    V (BM + BG): of a wall-sided body, sin(angle) (BM (1 + tan^2 / 2) + KB - KG), with KB - KG = -1/4, BM = 4 2^3/12/4
    = 2/3.
    """
    hull = mesh(trimesh.creation.box((4, 2, 1)))
    force, moment = load(hull, 0.0, quaternion((1, 0, 0), angle), at=(-3.0, 21.0))
    assert force == pytest.approx([0, 0, 4.0], abs=1e-12)
    if np.tan(angle) <= 0.5 and angle < np.pi / 2:
        arm = np.sin(angle) * (2 / 3 * (1 + np.tan(angle) ** 2 / 2) - 0.25)
        assert moment == pytest.approx([-4 * arm, 0, 0], abs=1e-12)


TILTS = [((1, 2, 3), 0.7, 0.1), ((0, 1, 0), 1.1, -0.3), ((3, -1, 1), 2.6, 0.25)]
SHAPES = {
    "box": trimesh.creation.box((4, 2, 1)),
    "sphere": trimesh.creation.icosphere(subdivisions=3, radius=1.2),
    "cylinder": trimesh.creation.cylinder(radius=0.6, height=3.0, sections=48),
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize(
    ("axis", "angle", "z"), [((1, 2, 3), 0.7, 0.1), ((0, 1, 0), 1.1, -0.3), ((3, -1, 1), 2.6, 0.25)]
)
def test_any_mesh_at_any_attitude(name, axis, angle, z) -> None:
    """The force is the volume of the clipped polyhedron through its centroid, to rounding (the other cutter's is
    1e-7).
    """
    q = quaternion(axis, angle)
    force, moment = load(mesh(SHAPES[name]), z, q)
    volume, centroid = cut_volume(SHAPES[name], q, z)
    assert force[:2] == pytest.approx([0, 0], abs=1e-12)
    assert force[2] == pytest.approx(volume, rel=1e-6)
    assert moment == pytest.approx(np.cross(centroid, [0, 0, volume]), abs=1e-5)
    assert moment[2] == pytest.approx(0, abs=1e-12)


def test_sphere_and_cylinder_tend_to_their_formulas() -> None:
    """A sphere of radius 1 with its centre 0.3 m below: 2 pi / 3 + pi (0.3 - 0.009). The mesh's error falls as h^2."""
    exact = np.pi * (2 / 3 + 0.3 - 0.3**3 / 3)
    found = [load(mesh(trimesh.creation.icosphere(subdivisions=n)), -0.3)[0][2] for n in (2, 3, 4)]
    errors = np.abs(np.array(found) - exact)
    assert errors[:-1] / errors[1:] == pytest.approx([4, 4], rel=0.15)
    lying = load(
        mesh(trimesh.creation.cylinder(radius=1, height=5, sections=720)), 0.0, quaternion((1, 0, 0), np.pi / 2)
    )
    assert lying[0][2] == pytest.approx(5 * np.pi / 2, rel=2e-5)


def test_heave_and_roll_stiffness_give_the_periods_of_a_box() -> None:
    """rho g A and rho g V GM by differences; with them the undamped periods 2 pi sqrt(m / c) of the hull without
    added mass.
    """
    hull = mesh(trimesh.creation.box((4, 2, 1)))
    d = 1e-4
    heave = (load(hull, -d)[0][2] - load(hull, d)[0][2]) / (2 * d)
    assert heave == pytest.approx(8.0, rel=1e-9)
    roll = -(load(hull, 0, quaternion((1, 0, 0), d))[1][0] - load(hull, 0, quaternion((1, 0, 0), -d))[1][0]) / (2 * d)
    assert roll == pytest.approx(4 * (2 / 3 - 0.25), rel=1e-6)
    assert 2 * np.pi * np.sqrt(4.0 / (heave * G)) == pytest.approx(2 * np.pi * np.sqrt(0.5 / G))


def wavy(height: float, period: float):
    return build_ocean(
        OceanConfig.model_validate(
            {
                "temperature_c": 0.0,
                "salinity": 0.0,
                "waves": {"type": "regular", "height_m": height, "period_s": period},
            }
        )
    )


def test_submerged_body_feels_froude_and_krylov() -> None:
    """Horizontal cylinder along the crests, radius 0.5 m, axis 4 m deep, k R = 0.18: analytic integral of e^{kz}
    cos(kx).

    Over a circle the mean of a harmonic function is its value in the centre, so that the force is rho V times the
    acceleration on the axis, exactly. The mesh of 64 sides has 0.2 % less volume and the pressure is linear on each
    side: 1 %.
    """
    sea = wavy(0.2, 3.4)
    k = (2 * np.pi / 3.4) ** 2 / G
    shape = trimesh.creation.cylinder(radius=0.5, height=2.0, sections=64)
    shape = shape.subdivide().subdivide()
    hull, q = mesh(shape), quaternion((1, 0, 0), np.pi / 2)  # its axis along y
    for t in (0.0, 0.85, 1.3):
        force = load(hull, -4.0, q, sea, t)[0] - np.array([0, 0, shape.volume])
        phase, a = -2 * np.pi / 3.4 * t, 0.1 * k * np.exp(-4 * k)
        expected = shape.volume * a * np.array([np.sin(phase), 0, -np.cos(phase)])
        assert force == pytest.approx(expected, abs=0.01 * shape.volume * a)


def test_small_float_rides_the_wave() -> None:
    """A box much smaller than the wave displaces at the crest what it displaces in still water at the same draft."""
    sea = wavy(1.0, 10.0)
    hull = mesh(trimesh.creation.box((0.2, 0.2, 0.2)))
    assert load(hull, 0.5, ocean=sea)[0][2] == pytest.approx(0.004, rel=0.03)
    assert load(hull, 0.0, ocean=sea)[0][2] == pytest.approx(0.008, rel=0.05)  # under the crest: all wet
    assert load(hull, 0.7, ocean=sea)[0][2] == 0
    assert load(hull, -0.39, ocean=sea, t=5.0)[0][2] == pytest.approx(0.0, abs=1e-9)  # in the trough: all dry


def test_deep_body_feels_no_wave() -> None:
    """At half a wave length e^{-pi}; at periscope depth, a tenth, e^{-0.63}."""
    sea = wavy(1.0, 6.0)
    length = G * 36 / (2 * np.pi)
    hull = mesh(trimesh.creation.icosphere(subdivisions=3, radius=0.3))
    volume = load(hull, -5.0)[0][2]
    push = [abs(load(hull, -d * length, ocean=sea)[0][2] - volume) for d in (0.5, 0.1)]
    k = 2 * np.pi / length
    assert push == pytest.approx([volume * 0.5 * k * np.exp(-k * d * length) for d in (0.5, 0.1)], rel=0.02)


def test_moving_water_pushes_with_displaced_and_added_mass() -> None:
    added = np.diag([10.0, 200, 200, 1, 30, 30])
    added[1, 5] = added[5, 1] = 7.0
    wrench = moving_water(100.0, [0.0, 0.0, -0.1], added.tolist(), [1.0, 2.0, 3.0])
    expected = [110, 2 * 300, 3 * 300, 0.1 * 200, -0.1 * 100, 14]
    assert [float(w) for w in wrench] == pytest.approx(expected)


def test_morison_acts_across_the_cylinder() -> None:
    """rho 1000, d 0.5, C_M 2, C_D 1.2: 392.7 N/m for 1 m/s^2 and 300 N/m for 1 m/s, none along the axis."""
    v = [jit.Float64(x) for x in (5.0, 1.0, 0.0)]
    a = [jit.Float64(x) for x in (3.0, 0.0, -1.0)]
    f = [float(np.array(x)[0]) for x in morison(1000.0, 0.5, 2.0, 1.2, v, a, [1.0, 0.0, 0.0])]
    assert f == pytest.approx([0, 300, -1000 * 2 * np.pi / 16], rel=1e-12)
    assert across([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]) == pytest.approx([1, 2, 0])
    wrench = strip_wrench([[0.0, 1.0, 0.0]] * 4, [[x, 0.0, 0.0] for x in (-3.0, -1.0, 1.0, 5.0)], 0.5)
    assert wrench == pytest.approx([0, 2, 0, 0, 0, 1])


def test_newman_drift_has_the_right_mean_and_only_slow_parts() -> None:
    rng = np.random.default_rng(3)
    f, a, p = np.linspace(0.09, 0.13, 12), rng.uniform(0.1, 0.4, 12), rng.uniform(0, 6, 12)
    d, t = rng.uniform(100, 900, 12), np.arange(0, 60_000, 1.0)
    phase = 2 * np.pi * f[:, None] * t + p[:, None]
    c, s = a[:, None] * np.cos(phase), a[:, None] * np.sin(phase)
    force = newman_drift((c.sum(axis=0), s.sum(axis=0)), (d @ c, d @ s))
    pairs = 0.5 * (d[:, None] + d) * a[:, None] * a
    at = [float(np.sum(pairs * np.cos(phase[:, k, None] - phase[:, k]))) for k in (0, 777)]
    assert force[[0, 777]] == pytest.approx(at, rel=1e-12)
    assert force.mean() == pytest.approx(np.sum(a**2 * d), rel=0.01)
    spectrum = np.abs(np.fft.rfft(force - force.mean())) ** 2
    fast = np.fft.rfftfreq(len(t), 1.0) > 0.045
    assert spectrum[fast].sum() < 1e-3 * spectrum.sum()


@pytest.mark.parametrize(("velocity", "signs"), [((-10, 0), (-1, 0, 0)), ((0, 10), (0, 1, 0)), ((-10, 10), (-1, 1, 1))])
def test_wind_pushes_down_wind(velocity, signs) -> None:
    """From ahead it pushes aft, from port to starboard; from ahead to port it also turns the bow to starboard (FRD)."""
    v = [jit.Float64(float(x)) for x in velocity]
    w = wind_wrench(1.2, v, 4.0, 10.0, 8.0, (0.6, 0.8, 0.1), 2.0)
    x, y, n = (float(np.array(jit.Float64(w[i]))[0]) for i in (0, 1, 5))
    assert np.sign([x, y, n]) == pytest.approx(signs)
    if velocity == (-10, 0):
        assert x == pytest.approx(-0.5 * 1.2 * 100 * 0.6 * 4)
        assert float(np.array(jit.Float64(w[4]))[0]) == pytest.approx(-2.0 * x)
