"""Lewis forms: sections of ships by beam, draught and area alone.

F. M. Lewis, The inertia of the water surrounding a vibrating ship, Trans. SNAME 37:1 (1929), as C. von Kerczek and
E. O. Tuck have it, The representation of ship hulls by conformal mapping functions, J. Ship Research 13:284 (1969). A
point at the angle psi from the keel (0) to the waterline (90 deg) is M ((1 + a1) sin psi - a3 sin 3 psi) out and
M ((1 - a1) cos psi + a3 cos 3 psi) down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError

Values = NDArray[np.float64]


@dataclass(frozen=True)
class LewisForm:
    """scale: M [m]; first, third: a1 and a3 [-]."""

    scale: float
    first: float
    third: float

    def out(self, angle: Values | float) -> Values:
        """Distance from the middle plane [m] at an angle from the keel [rad]."""
        return np.asarray(self.scale * ((1 + self.first) * np.sin(angle) - self.third * np.sin(3 * angle)))

    def down(self, angle: Values | float) -> Values:
        """Depth [m] at an angle from the keel [rad]."""
        return np.asarray(self.scale * ((1 - self.first) * np.cos(angle) + self.third * np.cos(3 * angle)))

    def points(self, panels: int) -> Values:
        """`(panels + 1, 2)` y and z [m] from the waterline at port under the keel to that at starboard, z upwards."""
        angle = np.linspace(-np.pi / 2, np.pi / 2, panels + 1)
        found = np.stack([self.out(angle), -self.down(angle)], axis=-1)
        found[[0, -1], 1] = 0.0
        return found


def lewis_form(beam: float, draught: float, area: float) -> LewisForm:
    """The form of a section's beam [m], draught [m] and area [m^2] under water.

    Raises:
        InputError: narrower or fuller than any such form.
    """
    ratio, fullness = beam / 2 / draught, area / (beam * draught)
    low, high = fullness_range(ratio)
    if not low <= fullness <= high:
        text = f"an area coefficient of {fullness:.4g} where half the beam over the draught is {ratio:.4g}"
        raise InputError(f"{text} is none of a Lewis form, which has {low:.4g} to {high:.4g}")
    square = ((ratio - 1) / (ratio + 1)) ** 2
    filled = 4 * fullness / np.pi
    c = 3 + filled + (1 - filled) * square
    third = (3 - c + np.sqrt(max(9 - 2 * c, 0.0))) / c
    first = (1 + third) * (ratio - 1) / (ratio + 1)
    return LewisForm(beam / 2 / float(1 + first + third), float(first), float(third))


def fullness_range(ratio: float) -> tuple[float, float]:
    """Least and largest area coefficient of a form whose half beam over the draught is `ratio`."""
    slender = min(ratio, 1 / ratio)
    return 3 * np.pi / 32 * (2 - slender), np.pi / 32 * (10 + slender + 1 / slender)
