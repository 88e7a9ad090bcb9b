"""Packages that only some doors need, each behind an extra of its own."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from pelagos.bridges.transport import BridgeError


def require(module: str, *, extra: str, purpose: str) -> Any:
    """Import an optional package.

    Raises:
        BridgeError: it is not installed; says the command that installs it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise BridgeError(f'{purpose} needs the extra {extra!r}: pip install "pelagos[{extra}]" ({error})') from None
