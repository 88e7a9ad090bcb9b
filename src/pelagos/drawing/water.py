"""Fields of the water for pictures: sampled at places and times, and the colours that each is drawn in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.drawing.colours import cmocean

Values = NDArray[np.float64]

SPEEDS: Final = cmocean("speed")
WARMTH: Final = cmocean("thermal")
SALT: Final = cmocean("haline")
MATTER: Final = cmocean("matter")


def sampled(field: Callable[[Any, Any], Any], position: Values, t: Values) -> Values:
    """A field of the ocean at positions `(k, 3)` NWU [m] and times `(k,)` [s]: `(k, 1)` or `(k, 3)`."""
    value = field(jit.Array3f64(np.ascontiguousarray(position.T)), jit.Float64(np.ascontiguousarray(t)))
    found = np.atleast_2d(np.array(value)).T
    return np.array(np.broadcast_to(found, (len(position), found.shape[1])))
