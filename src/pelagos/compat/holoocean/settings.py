"""Choices of the command line for every environment of a program (`pelagos holoocean --legacy-dynamics ...`)."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Final

from pelagos.errors import InputError

LEGACY: Final = "PELAGOS_HOLOOCEAN_LEGACY"
SEED: Final = "PELAGOS_HOLOOCEAN_SEED"
STRICT: Final = "PELAGOS_HOLOOCEAN_STRICT"


@dataclass(frozen=True)
class Settings:
    """Defaults of `make`.

    Attributes:
        legacy_dynamics: HoloOcean's own force model.
        seed: of every random stream; None: drawn by each `make`, and random poses from Python's own
            generator.
        strict: unknown keys are errors.
    """

    legacy_dynamics: bool = False
    seed: int | None = None
    strict: bool = False


def settings() -> Settings:
    """From the process's environment variables.

    Raises:
        InputError: the seed is no whole number.
    """
    seed = os.environ.get(SEED, "")
    if seed and not seed.isdigit():
        raise InputError(f"{SEED} is a whole number from 0 on, not {seed!r}")
    flags = {name: os.environ.get(name, "") not in ("", "0") for name in (LEGACY, STRICT)}
    return Settings(flags[LEGACY], int(seed) if seed else None, flags[STRICT])
