"""Derivatives of a ship in the bis system: each once, and no others."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

import pelagos as pl
from pelagos.vehicles.actuators.bis import BisShipConfig


@pytest.mark.parametrize("key", ["hull", "propeller"])
@pytest.mark.parametrize("wrong", ["missing", "unknown"])
def test_derivatives_are_all_there_and_no_others(key: str, wrong: str) -> None:
    parts = pl.Vehicle.from_catalogue("tanker").config.actuators.values()
    given: dict[str, Any] = next(p for p in parts if isinstance(p, BisShipConfig)).model_dump()
    name = next(iter(given[key]))
    if wrong == "missing":
        del given[key][name]
    else:
        name = "Zvv"
        given[key][name] = 1.0
    with pytest.raises(ValidationError, match=f"{key}: give each of .* once, and nothing else; not so: {name}"):
        BisShipConfig.model_validate(given)
