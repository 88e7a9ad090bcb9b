"""Waves: `env.fftwaves` is the environment itself, which has the three calls."""

from pelagos.compat.holoocean.appearance import Appearance as FFTWaves

FFTWaveController = FFTWaves

__all__ = ["FFTWaveController", "FFTWaves"]
