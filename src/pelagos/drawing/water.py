"""Fields of the water for pictures: sampled at places and times, and the colours that each is drawn in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import LinearSegmentedColormap
from numpy.typing import NDArray

from pelagos import jit

Values = NDArray[np.float64]

SPEEDS: Final = LinearSegmentedColormap.from_list("speeds", ["#f4f8f7", "#bfe0d6", "#5fb3b3", "#2a6f97", "#1b2a5c"])
WARMTH: Final = colormaps["plasma"]
SALT: Final = LinearSegmentedColormap.from_list("salt", ["#f7f3d3", "#b6d7a0", "#5aae8a", "#22788a", "#243b6b"])
MATTER: Final = LinearSegmentedColormap.from_list("matter", ["#f6f7f3", "#cfe0a8", "#8fb85a", "#4a8a3f", "#1d4a2c"])


def sampled(field: Callable[[Any, Any], Any], position: Values, t: Values) -> Values:
    """A field of the ocean at positions `(k, 3)` NWU [m] and times `(k,)` [s]: `(k, 1)` or `(k, 3)`."""
    value = field(jit.Array3f64(np.ascontiguousarray(position.T)), jit.Float64(np.ascontiguousarray(t)))
    found = np.atleast_2d(np.array(value)).T
    return np.array(np.broadcast_to(found, (len(position), found.shape[1])))
