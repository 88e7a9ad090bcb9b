"""Open-water coefficients of propellers of the Wageningen B-series.

Source: M. W. C. Oosterveld, P. van Oossanen, "Further computer-analyzed data of the Wageningen B-screw series",
International Shipbuilding Progress 22:251, 1975, doi 10.3233/ISP-1975-2225102, Table 5; printed again by M. M.
Bernitsas, D. Ray, P. Kinley, "KT, KQ and efficiency curves for the Wageningen B-series propellers", University of
Michigan report 237, 1981. At a Reynolds number of 2e6, for 2 to 7 blades, blade-area ratios of 0.30 to 1.05, pitch
ratios of 0.5 to 1.4, and advance numbers from 0 to that of zero thrust. Flow from behind and a shaft that turns astern
are not in it.
"""

from __future__ import annotations

from typing import Final

import numpy as np

PITCH: Final = (0.5, 1.4)
AREA: Final = (0.30, 1.05)
BLADES: Final = (2, 7)

_Term = tuple[float, int, int, int, int]
# coefficient, powers of J, P/D, AE/A0, Z
_KT: Final[tuple[_Term, ...]] = (
    (0.00880496, 0, 0, 0, 0), (-0.204554, 1, 0, 0, 0), (0.166351, 0, 1, 0, 0), (0.158114, 0, 2, 0, 0),
    (-0.147581, 2, 0, 1, 0), (-0.481497, 1, 1, 1, 0), (0.415437, 0, 2, 1, 0), (0.0144043, 0, 0, 0, 1),
    (-0.0530054, 2, 0, 0, 1), (0.0143481, 0, 1, 0, 1), (0.0606826, 1, 1, 0, 1), (-0.0125894, 0, 0, 1, 1),
    (0.0109689, 1, 0, 1, 1), (-0.133698, 0, 3, 0, 0), (0.00638407, 0, 6, 0, 0), (-0.00132718, 2, 6, 0, 0),
    (0.168496, 3, 0, 1, 0), (-0.0507214, 0, 0, 2, 0), (0.0854559, 2, 0, 2, 0), (-0.0504475, 3, 0, 2, 0),
    (0.010465, 1, 6, 2, 0), (-0.00648272, 2, 6, 2, 0), (-0.00841728, 0, 3, 0, 1), (0.0168424, 1, 3, 0, 1),
    (-0.00102296, 3, 3, 0, 1), (-0.0317791, 0, 3, 1, 1), (0.018604, 1, 0, 2, 1), (-0.00410798, 0, 2, 2, 1),
    (-0.000606848, 0, 0, 0, 2), (-0.0049819, 1, 0, 0, 2), (0.0025983, 2, 0, 0, 2), (-0.000560528, 3, 0, 0, 2),
    (-0.00163652, 1, 2, 0, 2), (-0.000328787, 1, 6, 0, 2), (0.000116502, 2, 6, 0, 2), (0.000690904, 0, 0, 1, 2),
    (0.00421749, 0, 3, 1, 2), (0.0000565229, 3, 6, 1, 2), (-0.00146564, 0, 3, 2, 2),
)  # fmt: skip
_KQ: Final[tuple[_Term, ...]] = (
    (0.00379368, 0, 0, 0, 0), (0.00886523, 2, 0, 0, 0), (-0.032241, 1, 1, 0, 0), (0.00344778, 0, 2, 0, 0),
    (-0.0408811, 0, 1, 1, 0), (-0.108009, 1, 1, 1, 0), (-0.0885381, 2, 1, 1, 0), (0.188561, 0, 2, 1, 0),
    (-0.00370871, 1, 0, 0, 1), (0.00513696, 0, 1, 0, 1), (0.0209449, 1, 1, 0, 1), (0.00474319, 2, 1, 0, 1),
    (-0.00723408, 2, 0, 1, 1), (0.00438388, 1, 1, 1, 1), (-0.0269403, 0, 2, 1, 1), (0.0558082, 3, 0, 1, 0),
    (0.0161886, 0, 3, 1, 0), (0.00318086, 1, 3, 1, 0), (0.015896, 0, 0, 2, 0), (0.0471729, 1, 0, 2, 0),
    (0.0196283, 3, 0, 2, 0), (-0.0502782, 0, 1, 2, 0), (-0.030055, 3, 1, 2, 0), (0.0417122, 2, 2, 2, 0),
    (-0.0397722, 0, 3, 2, 0), (-0.00350024, 0, 6, 2, 0), (-0.0106854, 3, 0, 0, 1), (0.00110903, 3, 3, 0, 1),
    (-0.000313912, 0, 6, 0, 1), (0.0035985, 3, 0, 1, 1), (-0.00142121, 0, 6, 1, 1), (-0.00383637, 1, 0, 2, 1),
    (0.0126803, 0, 2, 2, 1), (-0.00318278, 2, 3, 2, 1), (0.00334268, 0, 6, 2, 1), (-0.00183491, 1, 1, 0, 2),
    (0.000112451, 3, 2, 0, 2), (-0.0000297228, 3, 6, 0, 2), (0.000269551, 1, 0, 1, 2), (0.00083265, 2, 0, 1, 2),
    (0.00155334, 0, 2, 1, 2), (0.000302683, 0, 6, 1, 2), (-0.0001843, 0, 0, 2, 2), (-0.000425399, 0, 3, 2, 2),
    (0.0000869243, 3, 3, 2, 2), (-0.0004659, 0, 6, 2, 2), (0.0000554194, 1, 6, 2, 2),
)  # fmt: skip


def _polynomial(terms: tuple[_Term, ...], pitch: float, area: float, blades: int) -> tuple[float, ...]:
    found = [0.0] * (1 + max(term[1] for term in terms))
    for c, s, t, u, v in terms:
        found[s] += c * pitch**t * area**u * blades**v
    return tuple(found)


def thrust_polynomial(pitch: float, area: float, blades: int) -> tuple[float, ...]:
    """Coefficients of KT(J) from J^0 on [-]: pitch ratio P/D, blade-area ratio AE/A0, number of blades."""
    return _polynomial(_KT, pitch, area, blades)


def torque_polynomial(pitch: float, area: float, blades: int) -> tuple[float, ...]:
    """Coefficients of KQ(J) from J^0 on [-]."""
    return _polynomial(_KQ, pitch, area, blades)


def advance_at(thrust: tuple[float, ...], coefficient: float) -> float:
    """Least J >= 0 at which KT(J), which falls from J = 0 on, has come down to a coefficient [-]."""
    roots = np.polynomial.Polynomial([thrust[0] - coefficient, *thrust[1:]]).roots()
    real = roots[np.abs(roots.imag) < 1e-9].real
    return max(float(min((x for x in real if x > -1e-9), default=np.inf)), 0.0)
