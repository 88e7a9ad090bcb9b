"""Sediments of APL-UW TR 9407 (1994), Section IV, Table 2: what a seabed is to sound.

Applied Physics Laboratory, University of Washington, "APL-UW High-Frequency Ocean Environmental Acoustic Models
Handbook", APL-UW TR 9407, 1994. All ratios are to the water above the sediment; valid from 10 to 100 kHz.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

SPECTRAL_EXPONENT: Final = 3.25
"""gamma of the roughness spectrum W(K) = w2 (h0 K)^-gamma, h0 = 1 cm, for every sediment of the table."""


@dataclass(frozen=True)
class Sediment:
    """One row of the table.

    Attributes:
        grain_size_phi: mean grain size Mz [phi]; None for rock and cobble.
        density_ratio: rho, sediment to water.
        sound_speed_ratio: nu, sediment to water.
        loss: delta, imaginary over real wave number in the sediment.
        volume_scatter: sigma2, ratio of volume scattering cross-section to attenuation.
        spectral_strength: w2 of the relief spectrum [cm^4].
    """

    grain_size_phi: float | None
    density_ratio: float
    sound_speed_ratio: float
    loss: float
    volume_scatter: float
    spectral_strength: float


SEDIMENTS: Final[dict[str, Sediment]] = {
    "rough_rock": Sediment(None, 2.5, 2.5, 0.01374, 0.002, 0.20693),
    "rock": Sediment(None, 2.5, 2.5, 0.01374, 0.002, 0.01862),
    # w2: the copies of the report disagree; this value reproduces its own Table 3 of backscattering strength.
    "cobble": Sediment(None, 2.5, 1.8, 0.01374, 0.002, 0.0156),
    "sandy_gravel": Sediment(-1.0, 2.492, 1.3370, 0.01705, 0.002, 0.012937),
    "very_coarse_sand": Sediment(-0.5, 2.401, 1.3067, 0.01667, 0.002, 0.010573),
    "muddy_sandy_gravel": Sediment(0.0, 2.314, 1.2778, 0.01630, 0.002, 0.008602),
    "coarse_sand": Sediment(0.5, 2.231, 1.2503, 0.01638, 0.002, 0.006957),
    "gravelly_muddy_sand": Sediment(1.0, 2.151, 1.2241, 0.01645, 0.002, 0.005587),
    "medium_sand": Sediment(1.5, 1.845, 1.1782, 0.01624, 0.002, 0.004446),
    "muddy_gravel": Sediment(2.0, 1.615, 1.1396, 0.01610, 0.002, 0.003498),
    "fine_sand": Sediment(2.5, 1.451, 1.1073, 0.01602, 0.002, 0.002715),
    "muddy_sand": Sediment(3.0, 1.339, 1.0800, 0.01728, 0.002, 0.002070),
    "very_fine_sand": Sediment(3.5, 1.268, 1.0568, 0.01875, 0.002, 0.001544),
    "clayey_sand": Sediment(4.0, 1.224, 1.0364, 0.02019, 0.002, 0.001119),
    "coarse_silt": Sediment(4.5, 1.195, 1.0179, 0.02158, 0.002, 0.000781),
    "sandy_silt": Sediment(5.0, 1.169, 0.9999, 0.01261, 0.002, 0.000518),
    "medium_silt": Sediment(5.5, 1.149, 0.9885, 0.00676, 0.001, 0.000518),
    "sandy_mud": Sediment(6.0, 1.149, 0.9873, 0.00386, 0.001, 0.000518),
    "fine_silt": Sediment(6.5, 1.148, 0.9861, 0.00306, 0.001, 0.000518),
    "sandy_clay": Sediment(7.0, 1.147, 0.9849, 0.00242, 0.001, 0.000518),
    "very_fine_silt": Sediment(7.5, 1.147, 0.9837, 0.00194, 0.001, 0.000518),
    "silty_clay": Sediment(8.0, 1.146, 0.9824, 0.00163, 0.001, 0.000518),
    "clay": Sediment(9.0, 1.145, 0.9800, 0.00148, 0.001, 0.000518),
}
