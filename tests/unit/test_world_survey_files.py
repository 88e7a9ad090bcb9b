"""Words of survey files: which variables are coordinates, and in which system they are."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.errors import WorldError
from pelagos.world.bathymetry.read_netcdf import _about, _coordinates, _crs


def variable(*dimensions: str, **said: Any) -> Any:
    return SimpleNamespace(dimensions=dimensions, ndim=len(dimensions), **said)


@pytest.mark.parametrize(("variables", "asked", "found"), [
    ({"lat": variable("lat"), "lon": variable("lon")}, None, ("lat", "lon", True)),
    ({"y": variable("y", units="degrees_north"), "x": variable("x", units="Degrees_East")}, None, ("y", "x", True)),
    ({"q": variable("q", standard_name="Latitude"), "lon": variable("p")}, None, ("q", "lon", True)),
    ({"lat": variable("a"), "p": variable("p", standard_name="latitude"), "lon": variable("b")}, None,
     ("lat", "lon", True)),
    ({"y": variable("y", standard_name="projection_y_coordinate", units="degrees_north"),
      "x": variable("x", standard_name="projection_x_coordinate", units="degrees_east")}, None,
     ("y", "x", False)),
    ({"northing": variable("n"), "Easting": variable("e"), "z": variable("n", "e")}, None,
     ("northing", "Easting", False)),
    ({"p": variable("p"), "q": variable("q"), "z": variable("t", "q", "p")}, None, ("q", "p", False)),
    ({"p": variable("p"), "q": variable("q"), "z": variable("q", "p"), "w": variable("p", "q")}, "w",
     ("p", "q", False)),
])  # fmt: skip
def test_coordinates_are_found_by_name_by_what_they_say_or_as_rows_and_columns(variables, asked, found):
    how: Any = SimpleNamespace(variable=asked)
    assert _coordinates(Path("a.nc"), variables, how) == found


def test_what_has_no_coordinates_is_told():
    variables = {"p": variable("p"), "z": variable("p", "q")}  # of q there are no values
    with pytest.raises(WorldError, match="no coordinates named lat, lon or y, x; it has: p, z"):
        _coordinates(Path("a.nc"), variables, SimpleNamespace(variable=None))


@pytest.mark.parametrize(("variables", "mapping", "found"), [
    ({"m": variable(crs_wkt="WKT", epsg_code=4326)}, "m", "WKT"), ({"m": variable(epsg_code=32633)}, "m", "EPSG:32633"),
    ({"m": variable(spatial_ref="32632")}, "m: x y", "EPSG:32632"), ({"crs": variable(proj4text="+p")}, "no", "+p"),
    ({"crs": variable(spatial_ref="A"), "m": variable(spatial_ref="B")}, "m", "B"), ({"m": variable()}, "m", ""),
    ({}, "m", ""),
])  # fmt: skip
def test_the_system_is_that_of_the_variables_mapping(variables, mapping, found):
    assert _crs(variables, variable(grid_mapping=mapping)) == found


def test_what_a_variable_says_of_itself():
    assert _about(variable(positive="Down", units="feet", standard_name="a", long_name="Water depth")) == (
        True, "feet", "a Water depth",
    )  # fmt: skip
    assert _about(variable(positive="up"))[0] is False
    assert _about(variable(positive="east")) == (None, "", " ")
