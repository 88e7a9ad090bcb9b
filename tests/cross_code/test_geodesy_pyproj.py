"""Latitude and longitude against PROJ: transverse Mercator about the origin, and geodesic distances."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.math.geodesy import GeoOrigin

pyproj = pytest.importorskip("pyproj")

ORIGINS = [(45.335, 12.33), (-60.0, 170.0), (0.0, 0.0), (80.0, 20.0), (48.8, -123.0)]


@pytest.mark.parametrize(("latitude", "longitude"), ORIGINS)
def test_metres_agree_with_proj_to_a_micrometre(latitude, longitude):
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-1e5, 1e5, (2, 500))
    origin = GeoOrigin(latitude, longitude)
    lat, lon = origin.to_latlon(x, y)
    proj = f"+proj=tmerc +lat_0={latitude} +lon_0={longitude} +k=1 +x_0=0 +y_0=0 +ellps=WGS84"
    east, north = pyproj.Transformer.from_crs("EPSG:4326", proj, always_xy=True).transform(lon, lat)
    assert np.abs(north - x).max() < 1e-6
    assert np.abs(-east - y).max() < 1e-6


@pytest.mark.parametrize(("latitude", "longitude"), ORIGINS)
def test_round_trip_to_a_millimetre(latitude, longitude):
    rng = np.random.default_rng(1)
    place = np.column_stack([rng.uniform(-1e5, 1e5, (300, 2)), rng.uniform(-5000, 100, 300)])
    origin = GeoOrigin(latitude, longitude)
    assert np.abs(origin.to_nwu(origin.to_geodetic(place)) - place).max() < 1e-3


def test_distances_are_the_ellipsoids_within_the_stated_scale():
    """Scale error (d/R)^2/2 east or west: 3e-7 at 5 km; 1 cm over 10 km leaves room for three times that."""
    origin = GeoOrigin(45.0, 12.0)
    geod = pyproj.Geod(ellps="WGS84")
    for x, y in [(5000.0, 0.0), (0.0, 5000.0), (-3000.0, 4000.0)]:
        lat, lon = origin.to_latlon([0.0, x], [0.0, y])
        distance = geod.inv(lon[0], lat[0], lon[1], lat[1])[2]
        assert distance == pytest.approx(np.hypot(x, y), abs=2e-3)


def test_x_is_north_and_y_is_west():
    lat, lon = GeoOrigin(45.0, 12.0).to_latlon([1000.0, 0.0], [0.0, 1000.0])
    assert lat[0] > 45.0
    assert lon[0] == pytest.approx(12.0)
    assert lon[1] < 12.0


def test_longitudes_wrap_at_the_date_line():
    origin = GeoOrigin(10.0, 179.999)
    lat, lon = origin.to_latlon(0.0, -5000.0)
    assert -180 < float(lon) < -179.9
    assert float(origin.to_xy(lat, lon)[1]) == pytest.approx(-5000.0, abs=1e-6)
