"""The base of the scenario's own models: frozen, no unknown keys, one docstring under each field."""

from __future__ import annotations

from pydantic import ConfigDict
from pydantic_core import PydanticCustomError

from pelagos.config.described import Described


class Strict(Described):
    """A frozen model that refuses keys it does not know, and numbers that are not finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def refusal(message: str) -> PydanticCustomError:
    """Error for a validator to raise where keys do not fit together; the loader says where."""
    return PydanticCustomError("refused", "{message}", {"message": message})
