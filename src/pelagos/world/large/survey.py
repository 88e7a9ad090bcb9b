"""A survey file as the source of a large ground."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.bathymetry.read import Reading, read_survey
from pelagos.world.bathymetry.regrid import block_means, extent, fill, height_field
from pelagos.world.bathymetry.survey import Grid
from pelagos.world.bathymetry.values import upwards
from pelagos.world.large.source import FieldSource, Source, SurveySource

if TYPE_CHECKING:
    from pelagos.world.large.large import SurveyGround

_MAX_SOUNDING_NODES = 4_000_000
_RIM_POINTS = 33  # of an edge of the world: an arc of 1/32 of it is within 1/1000 of the bend


def survey_source(
    config: SurveyGround, origin: GeoOrigin, *, x0: float, y0: float, cells: tuple[int, int], spacing: float
) -> Source:
    """Heights of a survey; a grid is kept as it is in the file, soundings are laid on a grid of the world's nodes.

    Raises:
        WorldError: the file cannot be used, or does not cover the world's middle.
    """
    x1, y1 = x0 + cells[0] * spacing, y0 + cells[1] * spacing
    # the edges bend on the map: the middle of a northern one lies farther north than both its ends
    rim = np.linspace(0.0, 1.0, _RIM_POINTS)
    across, along = y0 + (y1 - y0) * rim, x0 + (x1 - x0) * rim
    x = np.concatenate([np.full(_RIM_POINTS, x0), np.full(_RIM_POINTS, x1), along, along])
    y = np.concatenate([across, across, np.full(_RIM_POINTS, y0), np.full(_RIM_POINTS, y1)])
    lat, lon = origin.to_latlon(x, y)
    box = (float(lat.min()), float(lat.max()), float(lon.min()), float(lon.max()))
    survey = read_survey(str(config.path), Reading(config.variable, config.crs, config.columns, box, config.unit))
    covered = extent(survey)
    if not covered.holds(origin.latitude, origin.longitude):
        raise WorldError(
            f"large: {config.path} covers {covered}, not the world's origin at {origin.latitude:g}, "
            f"{origin.longitude:g}; set latitude_deg and longitude_deg"
        )
    survey, _ = upwards(survey, config.sign, config.datum_offset_m)
    if isinstance(survey, Grid):
        filled, _ = fill(survey.z)
        return SurveySource(replace(survey, z=filled), origin)
    nodes = (cells[0] + 1) * (cells[1] + 1)
    if nodes > _MAX_SOUNDING_NODES:
        raise WorldError(
            f"large: soundings would need a grid of {nodes} nodes in memory (at most {_MAX_SOUNDING_NODES}); "
            "grid them first, or use type: bathymetry with a crop"
        )
    survey = block_means(survey, origin, low=(x0, y0), high=(x1, y1), cell=spacing)
    field, _ = height_field(survey, origin, corner=(x0, y0), cells=cells, spacing=spacing)
    return FieldSource(field)
