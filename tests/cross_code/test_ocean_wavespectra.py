"""Spectra against wavespectra 4.9.0 (`wavespectra.construct.frequency`): Hs 2 m, fp 0.1 Hz, 0.01 to 1.5 Hz every 0.5
mHz.

Its TMA takes an approximate wave number (0.1 %); its energy is scaled on the grid, ours to infinity (1e-5).
"""

import numpy as np
import pytest

from pelagos.ocean.spectrum import jonswap, tma

F = np.array([0.06, 0.08, 0.1, 0.11, 0.13, 0.2, 0.35])
JONSWAP = {
    3.3: (0.00682498, 1.20669, 7.74998, 4.12663, 1.43176, 0.236906, 0.0154774),
    1.5: (0.00922684, 1.60978, 4.76244, 3.64621, 1.92973, 0.320278, 0.0209242),
    1.0: (0.0104077, 1.80343, 3.58131, 3.30492, 2.1733, 0.361269, 0.0236022),
}
TMA = {
    10.0: (0.0016973, 0.532508, 5.32726, 3.42489, 1.64857, 0.584908, 0.0530825),
    30.0: (0.00219202, 0.680374, 6.58293, 4.10047, 1.78092, 0.351704, 0.0230114),
}


@pytest.mark.parametrize("gamma", JONSWAP)
def test_jonswap(gamma: float) -> None:
    assert jonswap(F, 2.0, 10.0, gamma) == pytest.approx(JONSWAP[gamma], rel=3e-5)


@pytest.mark.parametrize("depth", TMA)
def test_tma(depth: float) -> None:
    assert tma(F, 2.0, 10.0, 3.3, depth) == pytest.approx(TMA[depth], rel=2e-3)
