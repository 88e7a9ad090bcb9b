"""Fields whose model depends on the value's own `type:` key, looked up in the registry."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError, ValidationInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

from pelagos.config import registry
from pelagos.errors import InputError, LookupFailed, did_you_mean


@dataclass(frozen=True)
class Component:
    """Marks a field as a component of one table: `Annotated[Any, Component("sensor")]`.

    Attributes:
        kind: the registry's table.
        default: the type that a mapping without `type:` gets; None where the key must be written.
        shorthand: whether a name alone stands for a mapping of nothing but its type.
    """

    kind: registry.Kind
    default: str | None = None
    shorthand: bool = False

    def model(self, value: Any) -> type[BaseModel] | None:
        """The model that this value would be checked with; None where the value does not say, or says it wrongly."""
        if self.shorthand and isinstance(value, str):
            value = {"type": value}
        name = value.get("type", self.default) if isinstance(value, Mapping) else None
        known = registry.entries(self.kind)
        return known[name].config if isinstance(name, str) and name in known else None

    def build(self, value: Any, info: ValidationInfo) -> BaseModel:
        """Validate a mapping with the model that its `type` names; a model that is already built passes."""
        known = registry.entries(self.kind)
        if isinstance(value, BaseModel):
            if any(type(value) is entry.config for entry in known.values()):
                return value
            value = value.model_dump()
        if self.shorthand and isinstance(value, str):
            value = {"type": value}
        if not isinstance(value, Mapping):
            raise PydanticCustomError(
                "component_mapping", "{text}", {"text": _not_a_mapping(self.kind, value, list(known))}
            )
        name = value.get("type", self.default)
        if name is None:
            text = f"required key 'type' is missing; it names the {self.kind}: {', '.join(known)}"
            raise PydanticCustomError("component_missing", "{text}", {"text": text})
        try:
            if not isinstance(name, str) or name not in known:
                raise LookupFailed(self.kind, str(name), known)
            config = known[name].config
        except LookupFailed as error:
            wrong = PydanticCustomError("component_unknown", "{text}", {"text": str(error)})
            line = InitErrorDetails(type=wrong, loc=() if self.shorthand else ("type",), input=name)
            raise ValidationError.from_exception_data(self.kind, [line]) from None
        except InputError as error:
            raise PydanticCustomError("component_broken", "{text}", {"text": str(error)}) from error
        given = dict(value)
        if "type" not in config.model_fields:
            given.pop("type", None)
        if self.kind != "vehicle" or not isinstance(info.context, dict):
            return config.model_validate(given, context=info.context)
        alike: dict[bytes, BaseModel] = info.context.setdefault("vehicles", {})  # a fleet's are one configuration
        try:
            key = pickle.dumps(value)
        except (pickle.PicklingError, TypeError, AttributeError):
            return config.model_validate(given, context=info.context)
        if key not in alike:
            alike[key] = config.model_validate(given, context=info.context)
        return alike[key]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(
            self.build,
            serialization=core_schema.plain_serializer_function_ser_schema(_dump, info_arg=True),
        )

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        known = registry.entries(self.kind, plugins=False)
        models = dict.fromkeys(entry.config for entry in known.values())
        choices = [model.__get_pydantic_json_schema__(model.__pydantic_core_schema__, handler) for model in models]
        if self.shorthand:
            choices.append({"enum": list(known), "type": "string"})
        return {"anyOf": choices}


def _dump(value: BaseModel, info: Any) -> dict[str, Any]:
    return value.model_dump(mode=info.mode)


def _not_a_mapping(kind: str, value: Any, known: list[str]) -> str:
    hint = did_you_mean(value, known) if isinstance(value, str) else ""
    if isinstance(value, str) and value in known:
        hint = f"; write {{type: {value}}}"
    return f"a {kind} is a mapping with a key 'type', not {value!r}{hint}"
