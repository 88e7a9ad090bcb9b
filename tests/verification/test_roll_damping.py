"""Roll damping after Ikeda: published program's figures, energy of harmonic roll, limits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid

from pelagos.errors import InputError, PelagosError
from pelagos.hydro.roll_damping import RollForm, roll_components, roll_damping, roll_lift
from pelagos.vehicles.terms.roll_damping import _check
from pelagos.vehicles.vehicle import Vehicle

BEAM, DRAUGHT = 50.0, 12.5
SHIP = RollForm(300.0, BEAM, DRAUGHT, 0.65, 0.98, -0.2 * DRAUGHT, 0.2 * 300.0, 0.025 * BEAM)
FREQUENCY = 0.6 / np.sqrt(BEAM / 2 / 9.81)


def test_a_cargo_ship_of_the_authors_program():
    """B44 without dimension is 0.010156148773 for L/B 6, B/d 4, Cb 0.65, Cm 0.98, OG/d -0.2, at 10 deg and 0.6.

    The figure is held by the tests of rolldecay-estimators (MIT), a translation of the authors' program.
    """
    found = roll_components(SHIP, np.radians(10.0), FREQUENCY)
    assert found.total == pytest.approx(0.010156148773, rel=1e-9)
    assert min(found.friction, found.waves, found.eddies, found.keels) > 0


def test_friction_and_waves_are_linear_and_eddies_quadratic():
    """Ikeda 1978: the eddies' equivalent damping grows with the amplitude, that of the other two does not."""
    small, large = (roll_components(SHIP, np.radians(a), FREQUENCY) for a in (4.0, 12.0))
    assert large.eddies == pytest.approx(3 * small.eddies, rel=1e-12)
    assert (large.friction, large.waves) == pytest.approx((small.friction, small.waves), rel=1e-12)


@pytest.mark.parametrize("degrees", [3.0, 17.0])
def test_the_term_dissipates_what_the_components_do(degrees):
    """Energy of one period of harmonic roll, by quadrature, is pi B44 w a^2; without bilge keels exactly."""
    naked = RollForm(300.0, BEAM, DRAUGHT, 0.65, 0.98, -0.2 * DRAUGHT)
    linear, quadratic = roll_damping(naked, FREQUENCY, 1025.0)
    amplitude = np.radians(degrees)
    phase = np.linspace(0, 2 * np.pi, 20001)
    rate = amplitude * FREQUENCY * np.cos(phase)
    lost = trapezoid((linear + quadratic * np.abs(rate)) * rate**2, phase) / FREQUENCY
    scale = 1025.0 * naked.volume * BEAM**2 / np.sqrt(BEAM / 2 / 9.81)
    expected = np.pi * scale * roll_components(naked, amplitude, FREQUENCY).total * FREQUENCY * amplitude**2
    assert lost == pytest.approx(expected, rel=1e-6)


def test_lift_at_forward_speed():
    """Ikeda, Himeno, Tanaka 1978: rho/2 L d k_N l_0 l_R (1 - 1.4 OG/l_R + 0.7 OG^2/(l_0 l_R)), k_N with kappa 0.3."""
    slope = 2 * np.pi * 12.5 / 300 + 0.3 * (4.1 * 50 / 300 - 0.045)
    arm = 3.75 * 6.25 * (1 - 1.4 * -2.5 / 6.25 + 0.7 * 2.5**2 / (3.75 * 6.25))
    assert roll_lift(SHIP, 1025.0) == pytest.approx(512.5 * 300 * 12.5 * slope * arm, rel=1e-12)


@pytest.mark.parametrize("rate", [0.02, -0.05])
def test_a_tanker_slows_its_roll_by_it(rate):
    """M44 dp/dt falls by (b1 + c |u| + b2 |p|) p against the same ship without the term."""
    without = Vehicle.from_dict({"type": "kvlcc2", "terms": {"roll": None}})
    tanker = Vehicle.from_dict({"type": "kvlcc2"})
    nu = np.array([[3.0, 0.0, 0.0, rate, 0.0, 0.0]])
    at, none = np.zeros((1, 6)), np.zeros((1, len(tanker.actuator_names)))
    difference = (tanker.accelerations(at, nu, none, none)[0] - without.accelerations(at, nu, none, none)[0])[0]
    inertia = tanker.model.inertia
    moment = ((np.array(inertia.rigid, float) + np.array(inertia.added, float)) @ difference)[3]
    frequency = np.sqrt(1.8011e10 / (np.array(inertia.rigid, float) + np.array(inertia.added, float))[3, 3])
    form = RollForm(320.0, 58.0, 20.8, 0.81, 0.99, 2.2)
    linear, quadratic = roll_damping(form, float(frequency), 1025.0)
    assert moment == pytest.approx(-(linear + 3.0 * roll_lift(form, 1025.0) + quadratic * abs(rate)) * rate, rel=1e-3)


@pytest.mark.parametrize(
    ("vehicle", "words"),
    [
        ({"type": "kvlcc2", "terms": {"roll": {"draught_m": 30.0}}}, "beam over draught_m is 1.93"),
        ({"type": "kvlcc2", "terms": {"roll": {"keel_length_m": 60.0}}}, "keel_breadth_m over beam is 0;"),
        ({"type": "kvlcc2", "terms": {"roll": {"block": 0.9}}}, "at most 0.85"),
        ({"type": "kvlcc2", "gravity_m_s2": 0, "afloat": None}, "gravity_m_s2 of this one is 0"),
    ],
)
def test_forms_beyond_the_formula_are_refused(vehicle, words):
    with pytest.raises(PelagosError, match=words):
        Vehicle.from_dict(vehicle)


def test_a_number_at_its_limit_is_within() -> None:
    """0.58 / 58 is 0.01 but for a digit, below or above, and so are -1.5 and 0.06."""
    deep = (("deep", -1.5, -1.5, 0.2), ("deeper", np.nextafter(-1.5, -2), -1.5, 0.2))
    _check((*deep, ("narrow", 0.58 / 58, 0.01, 0.06), ("broad", np.nextafter(0.06, 1), 0.01, 0.06)), "made", "else")
    for value in (-1.5001, 0.2001):
        with pytest.raises(InputError, match=f"is {value:.3g}; made for -1.5 to 0.2: else"):
            _check((("deep", value, -1.5, 0.2),), "made", "else")
