"""The public names, what importing them costs, and the tables that name components."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest

import pelagos
from pelagos.config import registry
from pelagos.config.described import descriptions

SOURCE = Path(pelagos.__file__).parent

NAMES = {
    "Channel", "Checkpoint", "CommandError", "DeviceError", "InputError", "LookupFailed", "PelagosError",
    "PelagosWarning", "Prop", "Reading", "Recording", "RecordingError", "RunResult", "Scenario", "ScenarioError",
    "Simulation", "SimulationError", "ValidityWarning", "Vehicle", "World", "WorldError", "__version__", "channel",
    "envs", "load_scenario",
}  # fmt: skip


def test_public_names_are_these() -> None:
    assert set(pelagos.__all__) == NAMES
    assert len(NAMES) <= 30
    assert set(dir(pelagos)) == NAMES


@pytest.mark.parametrize("name", sorted(NAMES))
def test_public_name_exists_and_is_documented(name: str) -> None:
    assert getattr(pelagos, name).__doc__


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Simulator'"):
        pelagos.Simulator  # noqa: B018


def test_import_is_light() -> None:
    code = "import pelagos, sys; assert not {'drjit', 'mitsuba', 'numpy', 'pydantic', 'yaml'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_scenario_needs_no_device() -> None:
    code = (
        "import pelagos as pl, sys; pl.load_scenario({'world': {'type': 'flat'}}); assert 'mitsuba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("kind", get_args(registry.Kind))
def test_every_entry_of_every_table_loads_and_says_what_it_is(kind: registry.Kind) -> None:
    for name, entry in registry.entries(kind).items():
        assert entry.config.model_config.get("extra") == "forbid", name
        assert entry.config.model_config.get("frozen"), name
        assert entry.title, name
        for field in entry.config.model_fields:
            assert descriptions(entry.config).get(field) or field == "type", f"{kind} {name}: {field} has no docstring"


def test_at_the_door_of_a_family_of_sensors_stand_its_instruments_and_nothing_else() -> None:
    doors = {p.stem: p for p in (SOURCE / "sensors").glob("*/*.py") if p.stem != "__init__"}
    assert set(doors) == set(registry.BUILT_IN["sensor"])
    for name, path in doors.items():
        assert registry.BUILT_IN["sensor"][name].startswith(f"pelagos.sensors.{path.parent.name}.{name}:")


def test_back_rooms_and_the_contract_hold_no_instrument() -> None:
    behind = [*(SOURCE / "sensors").glob("*.py"), *(SOURCE / "sensors").glob("*/*/*.py")]
    assert len(behind) > 20
    assert not [p for p in behind if '    TITLE: ClassVar[str] = "' in p.read_text().replace('= ""', "")]


def test_plugins_join_the_tables_and_broken_ones_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    plugin = registry.Entry("sensor", "sniffer", "no_such_package:Sniffer", "sniffers")
    monkeypatch.setattr(registry, "_plugins", lambda kind: {"sniffer": plugin} if kind == "sensor" else {})
    assert "sniffer" in registry.entries("sensor")
    assert "sniffer" not in registry.entries("sensor", plugins=False)
    with pytest.raises(pelagos.ScenarioError, match="sensor 'sniffer' of the package sniffers cannot be loaded"):
        pelagos.load_scenario(
            {"world": {"type": "flat"}, "agents": {"a": {"vehicle": "remus100", "sensors": {"s": {"type": "sniffer"}}}}}
        )
