"""Writes a synthetic circulation as CMEMS would: an eddy with a warm core, over the place of `adriatic_currents.yaml`.

    python examples/write_circulation.py [FILE]

Currents turn around the centre, fastest (0.35 m/s) 1.2 km from it, weaker with depth, and grow by a fifth in six
hours; the core is 2 degC warmer than the water around. The file is results/circulation.nc unless you say otherwise.
"""

import sys
from pathlib import Path

import numpy as np
import xarray

CENTRE = (44.76, 13.96)  # latitude, longitude [deg]
RADIUS_M = 1200.0
SPEED_MPS = 0.35


def circulation() -> xarray.Dataset:
    """13 x 10 x 61 x 61 values over 12 km x 12 km and twelve hours."""
    north = np.linspace(-6000, 6000, 61)
    lat = CENTRE[0] + north / 111_120
    lon = CENTRE[1] + north / (111_320 * np.cos(np.radians(CENTRE[0])))
    depth = np.array([0.5, 2, 5, 10, 15, 20, 30, 40, 60, 80])
    hours = np.arange(13.0)
    t, z, y, x = np.meshgrid(hours, depth, north, north, indexing="ij")  # y north, x east [m]
    r2 = (x**2 + y**2) / RADIUS_M**2
    turn = SPEED_MPS / RADIUS_M * np.exp(0.5 * (1 - r2)) * np.exp(-z / 50) * (1 + t / 30)
    background = 22 - 9 / (1 + np.exp(-(z - 18) / 3))
    axes = ("time", "depth", "latitude", "longitude")
    fields = {
        "uo": (axes, -turn * y, {"standard_name": "eastward_sea_water_velocity", "units": "m s-1"}),
        "vo": (axes, turn * x, {"standard_name": "northward_sea_water_velocity", "units": "m s-1"}),
        "thetao": (
            axes,
            background + 2 * np.exp(-r2),
            {"standard_name": "sea_water_temperature", "units": "degrees_C"},
        ),
    }
    return xarray.Dataset(
        {name: (a, v.astype(np.float32), u) for name, (a, v, u) in fields.items()},
        coords={
            "time": ("time", hours, {"units": "hours since 2024-07-01 00:00:00", "calendar": "standard"}),
            "depth": ("depth", depth, {"units": "m", "positive": "down"}),
            "latitude": ("latitude", lat, {"units": "degrees_north"}),
            "longitude": ("longitude", lon, {"units": "degrees_east"}),
        },
        attrs={"Conventions": "CF-1.8", "title": "Synthetic eddy for Pelagos' examples"},
    )


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "results" / "circulation.nc"
    target.parent.mkdir(parents=True, exist_ok=True)
    circulation().to_netcdf(target)
    print(target)
