"""Warnings about what HoloOcean would ignore or do otherwise: each once in a process."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from typing import Any

from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException
from pelagos.errors import PelagosWarning, did_you_mean


class HoloOceanWarning(PelagosWarning):
    """Something that HoloOcean would silently ignore, or that has no counterpart here."""


class Advice:
    """Warnings and errors of one environment; with `strict`, unknown keys are errors."""

    def __init__(self, *, strict: bool = False) -> None:
        self.strict = strict
        self._said: set[str] = set()

    def once(self, text: str) -> None:
        """Warn, unless that was said already."""
        if text not in self._said:
            self._said.add(text)
            warnings.warn(text, HoloOceanWarning, stacklevel=3)

    def name(self, where: str, given: str, known: Iterable[str], otherwise: str) -> None:
        """Say that something refers to a name that there is not, and how it goes on.

        Raises:
            HoloOceanConfigurationException: if `strict`.
        """
        allowed = list(known)
        text = f"{where}: there is no {given!r}{did_you_mean(given, allowed)}; there is {', '.join(allowed)}"
        if self.strict:
            raise HoloOceanConfigurationException(text)
        self.once(f"{text}; {otherwise}, as in HoloOcean")

    def unknown(self, where: str, given: Mapping[str, Any], known: Iterable[str]) -> None:
        """Say which keys are not known, with the nearest that are.

        Raises:
            HoloOceanConfigurationException: if `strict`.
        """
        allowed = list(known)
        for key in given:
            if key in allowed:
                continue
            text = f"{where}: {key!r} is no key that HoloOcean reads{did_you_mean(str(key), allowed)}"
            if self.strict:
                raise HoloOceanConfigurationException(text)
            self.once(f"{text}; it is ignored, as HoloOcean does")
