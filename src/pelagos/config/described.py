"""Models whose fields are explained by the docstrings under them, read from the source when somebody asks for them.

Pydantic's own `use_attribute_docstrings` reads the source of each class as it is made: with our 350 models that is a
good part of the time that a command takes to start, and a run has no use for it.
"""

from __future__ import annotations

import ast
import inspect
import linecache
import sys
from collections.abc import Iterator, Mapping
from functools import cache

from pydantic import BaseModel, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema


class Described(BaseModel):
    """A model whose JSON schema has the docstring under each field as its description."""

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        made = handler(schema)
        properties = handler.resolve_ref_schema(made).get("properties", {})
        for name, text in descriptions(cls).items():
            if name in properties:
                properties[name].setdefault("description", text)
        return made


@cache
def descriptions(model: type[BaseModel]) -> Mapping[str, str]:
    """Explanations of a model's fields by name: what the field itself says, else the docstring under it.

    A field that a class writes anew has the docstring of that class. Fields without any are left out, and so are all
    docstrings of a class whose source is not on disk.
    """
    found: dict[str, str] = {}
    for ancestor in reversed(model.__mro__):
        own = _docstrings(ancestor)
        for name in vars(ancestor).get("__annotations__", {}):
            found.pop(name, None)
            if name in own:
                found[name] = own[name]
    said = {name: field.description for name, field in model.model_fields.items() if field.description}
    return {name: text for name, text in (found | said).items() if name in model.model_fields}


def _docstrings(cls: type) -> Mapping[str, str]:
    """Docstrings under the annotations of a class, by name."""
    module = sys.modules.get(cls.__module__)
    file = getattr(module, "__file__", None)
    return {} if file is None else _of_file(file).get(cls.__qualname__, {})


@cache
def _of_file(file: str) -> Mapping[str, Mapping[str, str]]:
    """Docstrings under annotations in a file, by the qualified name of the class."""
    return dict(_of_body(ast.parse("".join(linecache.getlines(file))).body, ""))


def _of_body(body: list[ast.stmt], prefix: str) -> Iterator[tuple[str, Mapping[str, str]]]:
    for node in body:
        if isinstance(node, ast.ClassDef):
            yield f"{prefix}{node.name}", _of_class(node)
            yield from _of_body(node.body, f"{prefix}{node.name}.")
        elif isinstance(node, ast.FunctionDef):
            yield from _of_body(node.body, f"{prefix}{node.name}.<locals>.")
        elif isinstance(node, ast.If | ast.With | ast.Try):
            yield from _of_body(node.body, prefix)


def _of_class(node: ast.ClassDef) -> Mapping[str, str]:
    texts = {}
    for field, text in zip(node.body, node.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(text, ast.Expr):
            value = text.value
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                texts[field.target.id] = inspect.cleandoc(value.value)
    return texts
