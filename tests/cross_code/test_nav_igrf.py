"""The magnetic field against the IGRF-14 web service of the British Geological Survey (epoch 2025.0, whole
nanotesla).
"""

import numpy as np
import pytest

from pelagos.math.geomagnetism import earth_field

POINTS = [  # latitude, longitude [deg], height [km], north, east, down [nT]
    (0.0, 0.0, 0.0, 27457, -1926, -15997),
    (45.0, 10.0, 0.0, 22843, 1451, 41825),
    (51.5, 0.0, 400.0, 16632, 69, 37519),
    (-33.86, 151.21, 0.0, 24040, 5450, -51381),
]


@pytest.mark.parametrize(("latitude", "longitude", "height", "north", "east", "down"), POINTS)
def test_field(latitude, longitude, height, north, east, down) -> None:
    field = earth_field(latitude, longitude, height_m=1000 * height) * 1e9
    assert field == pytest.approx([north, -east, -down], abs=1.0)


@pytest.mark.parametrize(("latitude", "longitude"), [(0, 0), (45.65, 13.77), (-60, -120), (89, 10)])
def test_first_degree_is_a_dipole(latitude, longitude) -> None:
    """(a/r)^3 (3 (m . r) r - m) with m = (g11, h11, g10), in Earth-fixed axes, seen from the ellipsoid's own normal."""
    lat, lon = np.radians([latitude, longitude])
    e2 = 1 - (1 - 1 / 298.257223563) ** 2
    normal = 6378137.0 / np.sqrt(1 - e2 * np.sin(lat) ** 2)
    place = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), (1 - e2) * np.sin(lat)]) * normal
    r = np.linalg.norm(place)
    unit, moment = place / r, np.array([-1410.3, 4545.5, -29350.0])
    field = (6371200 / r) ** 3 * (3 * (moment @ unit) * unit - moment)
    north = [-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)]
    west = [np.sin(lon), -np.cos(lon), 0]
    up = [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)]
    found = earth_field(latitude, longitude, degree=1) * 1e9
    assert found == pytest.approx([field @ north, field @ west, field @ up], abs=1e-6)


def test_poles_are_finite() -> None:
    assert np.isfinite([earth_field(latitude, 0.0) for latitude in (-90, 90)]).all()
