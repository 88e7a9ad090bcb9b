"""The base of the scenario's own models: frozen, no unknown keys, one docstring under each field."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict
from pydantic_core import PydanticCustomError


class Strict(BaseModel):
    """A frozen model that refuses keys it does not know, and numbers that are not finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True, allow_inf_nan=False)


def refusal(message: str) -> PydanticCustomError:
    """Error for a validator to raise where keys do not fit together; the loader says where."""
    return PydanticCustomError("refused", "{message}", {"message": message})
