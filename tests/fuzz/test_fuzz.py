"""Fuzzing: scenarios mutated or drawn from the schema, and damaged recordings end well or in one error of ours.

`make fuzz` goes on by time.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from from_schema import FromSchema
from harness import COUNTS, SECONDS, end_well, run_cases
from hypothesis import strategies as st

from pelagos.config.loader import load_scenario, to_yaml
from pelagos.sim.record import Recorder
from pelagos.sim.replay import Recording
from pelagos.sim.simulation import Simulation

ROOT = Path(__file__).parents[2]
CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.yaml"))
EXAMPLES = [yaml.safe_load(path.read_text()) for path in sorted((ROOT / "examples").glob("*.yaml"))]
SCHEMA = json.loads((ROOT / "schema/scenario.schema.json").read_text())

NUMBERS = st.one_of(
    st.integers(-10, 10),
    st.integers(),
    st.floats(allow_subnormal=False),
    st.sampled_from([1e300, -1e300, 1e-300, 2**63, -(2**31), 0.0]),
)
TEXTS = st.one_of(st.text(max_size=20), st.sampled_from(["", "null", "imu", "remus100", "../../x", "module:function"]))
SCALARS = st.one_of(st.none(), st.booleans(), NUMBERS, TEXTS)
VALUES = st.recursive(
    SCALARS, lambda v: st.lists(v, max_size=4) | st.dictionaries(st.text(max_size=8), v, max_size=4), max_leaves=8
)


def places(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place of a tree of plain values."""
    found = [path] if path else []
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        found += places(value, (*path, key))
    return found


def changed(data: Any, path: tuple[Any, ...], change: Callable[[Any, Any], None]) -> Any:
    """A copy of a tree with one place changed."""
    copy = {**data} if isinstance(data, dict) else [*data]
    if len(path) == 1:
        change(copy, path[0])
    else:
        copy[path[0]] = changed(copy[path[0]], path[1:], change)
    return copy


@st.composite
def mutants(draw: st.DrawFn) -> Any:
    """An example's scenario with one to three places replaced, removed, or with a key too many."""
    data = draw(st.sampled_from(EXAMPLES))
    for _ in range(draw(st.integers(1, 3))):
        found = places(data)
        if not found:
            break
        path, value, kind = (
            draw(st.sampled_from(found)),
            draw(VALUES),
            draw(st.sampled_from(["set", "set", "del", "add"])),
        )

        def change(holder: Any, key: Any, value: Any = value, kind: str = kind) -> None:
            if kind == "del":
                del holder[key]
            elif kind == "add" and isinstance(holder, dict):
                holder[f"{key}x"] = value
            else:
                holder[key] = value

        data = changed(data, path, change)
    return data


@st.composite
def allowed(draw: st.DrawFn) -> Any:
    """What the schema allows: a world, an ocean, and one agent with up to three sensors; half of each left out."""
    value = FromSchema(SCHEMA, draw).value
    top, agent = SCHEMA["properties"], SCHEMA["$defs"]["Agent"]["properties"]
    auv = {"vehicle": "remus100", "start": {"depth_m": 3.0}}
    keys = draw(st.lists(st.sampled_from(sorted(agent)), max_size=2, unique=True))
    auv |= {key: value(agent[key], 1) for key in keys}
    sensors = agent["sensors"]["additionalProperties"]
    auv["sensors"] = {
        name: value(sensors, 1) for name in draw(st.sampled_from([(), ("a",), ("a", "b"), ("a", "b", "c")]))
    }
    data = {"world": {"type": "flat", "depth_m": 20.0}, "agents": {"auv": auv}}
    more = draw(st.lists(st.sampled_from(sorted(set(top) - {"agents", "name"})), max_size=2, unique=True))
    return data | {key: value(top[key], 1) for key in more}


def repeated(data: Any) -> None:
    scenario = load_scenario(data)
    assert load_scenario(yaml.safe_load(to_yaml(scenario))) == scenario


def test_mutated_examples() -> None:
    run_cases(mutants(), repeated, "scenarios")


def test_what_the_schema_allows() -> None:
    run_cases(allowed(), repeated, "schema")


@pytest.mark.skipif(not SECONDS, reason="builds simulations; `make fuzz` runs it by time")
def test_short_runs() -> None:
    """What passes the check runs five ticks, or ends in one error of ours; memory of two gigabytes at most."""

    def run(data: Any) -> None:
        sim = Simulation.load(load_scenario(data), memory_limit=2e9)
        for _ in range(5):
            sim.step()

    run_cases(mutants() | allowed(), run, "runs", cases=4, longest_s=120.0)


def test_texts(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"

    def read(text: str) -> None:
        path.write_text(text, encoding="utf-8")
        load_scenario(path)

    letters = st.sampled_from("abc: -[]{}&*<>|\n\t#!'0123456789.eE\x00\u2028")
    run_cases(st.text(alphabet=letters, max_size=200), read, "texts")


@pytest.mark.parametrize("path", CORPUS, ids=lambda p: p.stem)
def test_past_failures(path: Path) -> None:
    end_well(lambda: load_scenario(path))


def test_damaged_recordings(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with Recorder(path, "name: a\n", 1, {}, None, (0.0, 0.0), 1_000_000) as recorder:
        recorder.flush()
    whole = path.read_bytes()
    flips = st.lists(st.tuples(st.integers(0, len(whole) - 1), st.integers(0, 255)), max_size=6)

    def read(damage: tuple[int, list[tuple[int, int]]]) -> None:
        raw = bytearray(whole)
        for at, value in damage[1]:
            raw[at] = value
        path.write_bytes(raw[: damage[0]])
        Recording(path)

    run_cases(st.tuples(st.integers(0, len(whole)), flips), read, "recordings")


def test_figures() -> None:
    """How many cases there were (`make fuzz` shows it)."""
    print(COUNTS)
