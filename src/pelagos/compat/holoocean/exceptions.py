"""HoloOcean's exceptions, by its names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from pelagos.errors import did_you_mean

Value = TypeVar("Value")


class HoloOceanException(Exception):
    """Anything that HoloOcean refuses."""


class HoloOceanConfigurationException(HoloOceanException):
    """A configuration that cannot be."""


class TimeoutException(HoloOceanException):
    """Kept for scripts that catch it; Pelagos runs in the same process and waits for nothing."""


class NotFoundException(HoloOceanException):
    """A package or a file that is not there."""


class UnknownName(HoloOceanException, KeyError):
    """Nothing has this name: a KeyError, as HoloOcean raises it, with words."""

    __str__ = Exception.__str__


def named(what: str, name: object, known: Mapping[str, Value]) -> Value:
    """The value under a name.

    Raises:
        UnknownName: nothing has; the message says what there is.
    """
    if not isinstance(name, str) or name not in known:
        there = ", ".join(known) or "none"
        raise UnknownName(f"there is no {what} {name!r}{did_you_mean(str(name), known)}; there is {there}")
    return known[name]


def three(what: str, values: Any) -> list[float]:
    """Three finite numbers.

    Raises:
        HoloOceanConfigurationException: anything else; `what` says of which agent and key.
    """
    try:
        given = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.size != 3 or not np.isfinite(given).all():
        raise HoloOceanConfigurationException(f"{what} is three finite numbers, not {values!r}")
    return [float(v) for v in given.reshape(-1)]
