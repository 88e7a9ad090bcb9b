"""Descriptions of fields, from the docstrings under them."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel, Field

from pelagos.config.described import Described, descriptions


class Base(Described):
    """Two fields."""

    depth_m: float = 1.0
    """Below the surface,
    positive down."""
    rate_hz: float = 2.0
    """Of the base."""
    silent: int = 3


class Derived(Base):
    """One of them written anew with a docstring, one without, one with words of its own."""

    rate_hz: float = 4.0
    """Of the derived."""
    depth_m: float = 5.0
    own: Base = Field(default_factory=Base, description="by the field")
    """By the docstring."""

    class Inner(Described):
        """Within a class."""

        rate_hz: float = 6.0
        """Of the inner."""

        class Innermost(Described):
            """Within that."""

            rate_hz: float = 8.0
            """Of the innermost."""


def test_field_says_what_its_class_wrote_under_it():
    assert descriptions(Base) == {"depth_m": "Below the surface,\npositive down.", "rate_hz": "Of the base."}
    assert descriptions(Derived) == {"rate_hz": "Of the derived.", "own": "by the field"}
    assert descriptions(Derived.Inner) == {"rate_hz": "Of the inner."}
    assert descriptions(Derived.Inner.Innermost) == {"rate_hz": "Of the innermost."}


def test_json_schema_has_the_descriptions_also_of_what_it_refers_to():
    schema = Derived.model_json_schema()
    assert {k: v.get("description") for k, v in schema["properties"].items()} == {
        "depth_m": None, "rate_hz": "Of the derived.", "silent": None, "own": "by the field",
    }  # fmt: skip
    assert schema["$defs"]["Base"]["properties"]["depth_m"]["description"] == "Below the surface,\npositive down."


def test_models_are_made_without_reading_their_source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What pydantic does with `use_attribute_docstrings` costs a second of every command's start."""
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "described_plug_in.py").write_text(
        "from pelagos.config.described import Described\n\n\n"
        'class Config(Described):\n    gain: float = 1.0\n    """Over all."""\n',
        encoding="utf-8",
    )
    with monkeypatch.context() as without:
        without.setattr("ast.parse", lambda *_, **__: pytest.fail("a source was read"))
        made: Any = import_module("described_plug_in")
    assert descriptions(made.Config) == {"gain": "Over all."}
    monkeypatch.delitem(sys.modules, "described_plug_in")


def test_class_without_a_file_has_none():
    scope: dict[str, Any] = {"Described": Described, "__name__": "nowhere"}
    exec('class Made(Described):\n    gain: float = 1.0\n    "Over all."', scope)
    assert descriptions(scope["Made"]) == {}
    assert issubclass(scope["Made"], BaseModel)
