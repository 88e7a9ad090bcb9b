"""What configurations refuse, and the other side of each limit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import pytest
from pydantic import BaseModel, Field, TypeAdapter, ValidationError
from pydantic_core import PydanticCustomError

from pelagos.config import document, registry, swarm
from pelagos.config.component import Component
from pelagos.config.document import MAX_DEPTH, parse_document, read_document
from pelagos.config.loader import load_scenario
from pelagos.config.mission.follow import Follow
from pelagos.config.mission.vertical import Profile
from pelagos.config.problem import coerced
from pelagos.config.walk import annotation_at, fixed_length
from pelagos.errors import InputError, ScenarioError

# legs


@pytest.mark.parametrize(
    "given", [{"agent": "a"}, {"wall": "s"}, {"agent": "a", "offset_m": (1, 2, 3)}, {"wall": "s", "distance_m": 2}]
)
def test_what_never_ends_is_no_leg(given: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match="give 'seconds' or 'until': nothing else ends this leg"):
        Follow(**given)
    assert Follow(**given, seconds=1e-3).seconds == 1e-3
    assert Follow(**given, until={"sensor": "s", "above": 3}).until is not None


def test_a_pipeline_ends_the_leg_by_itself() -> None:
    assert Follow(pipeline="p").seconds is None


def test_a_profile_goes_along_a_heading_or_to_a_point() -> None:
    for heading in (0, 90.0):
        with pytest.raises(ValidationError, match="give either 'heading_deg' or 'point', not both"):
            Profile(lower_depth_m=20, heading_deg=heading, point=(1, 2), cycles=2)
    assert Profile(lower_depth_m=20, heading_deg=0, cycles=2).point is None
    assert Profile(lower_depth_m=20, point=(1, 2)).heading_deg is None
    for upper in (20, 20.1):
        with pytest.raises(ValidationError, match=r"upper_depth_m .* must be above lower_depth_m 20"):
            Profile(lower_depth_m=20, upper_depth_m=upper, cycles=2)


# files


def test_a_file_is_as_large_as_it_may_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "it.yaml"
    path.write_text("a: 1\n" + "#" * ((1 << 20) - 5))
    monkeypatch.setattr(document, "MAX_BYTES", 1 << 20)
    assert read_document(path).data == {"a": 1}
    with path.open("a") as file:
        file.write("#")
    with pytest.raises(ScenarioError, match=r"it\.yaml: too large for a scenario: more than 1 MiB"):
        read_document(path)


def test_a_file_that_may_not_be_read_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "it.yaml"
    path.write_text("a: 1\n")

    def refuse(*_: Any, **__: Any) -> str:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_text", refuse)
    with pytest.raises(ScenarioError, match=r"it\.yaml: cannot be read: Permission denied"):
        read_document(path)


def test_merges_may_be_nested_so_deep() -> None:
    def chain(count: int) -> str:
        """Each mapping merges the one that stands in its own merge."""
        inner = "&m0 {x: 0}"
        for k in range(1, count + 1):
            inner = f"{{<<: {inner}, k{k}: {k}}}"
        return f"it: {inner}\n"

    assert len(parse_document(chain(MAX_DEPTH), "it", Path()).data["it"]) == MAX_DEPTH + 1
    with pytest.raises(ScenarioError, match=r"it:1: '<<' is nested too deeply"):
        parse_document(chain(MAX_DEPTH + 1), "it", Path())


# values


def test_numbers_are_finite_and_flags_are_flags() -> None:
    built = {"range_m": math.inf, "least": 2.0, "on": True}
    found = dict(coerced({"range_m": 1e999, "least": 2.0, "on": True}, built))
    assert found == {("range_m",): "expected a finite number [m], not inf"}
    assert dict(coerced([math.nan], [math.nan])) == {(0,): "expected a finite number, not nan"}


@pytest.mark.parametrize("given", ["maybe", 2, [1], {"a": 1}])
def test_a_flag_is_true_or_false(given: Any) -> None:
    data = {
        "world": {"type": "flat"},
        "agents": {"a": {"vehicle": "remus100", "sensors": {"s": {"type": "lidar", "through_water": given}}}},
    }
    with pytest.raises(ScenarioError, match=r"agents\.a\.sensors\.s\.through_water: expected true or false, not "):
        load_scenario(data)


# components


def test_a_component_is_a_name_a_mapping_or_another_model() -> None:
    mark = Component("vehicle", shorthand=True)
    by_name, by_type = mark.model("remus100"), mark.model({"type": "remus100"})
    assert by_name is by_type is registry.entries("vehicle")["remus100"].config
    assert mark.model("remus") is None
    assert Component("vehicle").model("remus100") is None

    class Other(BaseModel):
        type: str = "depth"
        rate_hz: float = 7.0

    info: Any = SimpleNamespace(context=None)
    built = Component("sensor").build(Other(), info)
    assert isinstance(built, registry.entries("sensor")["depth"].config)
    assert built.rate_hz == 7.0  # type: ignore[attr-defined]
    assert Component("sensor").build(built, info) is built


def test_a_vehicle_that_cannot_be_told_from_others_is_its_own() -> None:
    """What cannot be pickled is validated anew."""
    context: dict[str, Any] = {}
    info: Any = SimpleNamespace(context=context)

    class Written(dict):  # type: ignore[type-arg]
        def __reduce__(self) -> Any:
            raise TypeError("no pickle")

    one, other = (Component("vehicle").build(Written(type="remus100"), info) for _ in range(2))
    assert one == other
    assert one is not other
    assert not context["vehicles"]
    shared = [Component("vehicle").build({"type": "remus100"}, info) for _ in range(2)]
    assert shared[0] is shared[1] == one


def test_our_own_broken_component_is_no_users_mistake() -> None:
    for target in ("pelagos.nowhere:It", "pelagos.errors:Nothing"):
        with pytest.raises((ImportError, AttributeError)) as caught:
            registry.Entry("sensor", "it", target).load()
        assert not isinstance(caught.value, InputError)
        with pytest.raises(InputError, match="sensor 'it' of the package theirs cannot be loaded: "):
            registry.Entry("sensor", "it", target, "theirs").load()


@pytest.mark.parametrize(
    "dotted", ["a.b.c", "name.x", "name.x.y", "places.x.y", "name", "places.2", "places.-1", "places", "places.0.x"]
)
def test_a_distribution_names_a_number(dotted: str) -> None:
    data: dict[str, Any] = {"a": {"b": "word"}, "name": "x", "places": [1.0, 2.0]}
    with pytest.raises(PydanticCustomError, match=f"'{dotted}' names no number of an agent"):
        swarm._put(data, dotted, 3.0)
    swarm._put(data, "a.c.d", 4.0)
    swarm._put(data, "places.1", 5.0)
    assert (data["a"]["c"], data["places"]) == ({"d": 4.0}, [1.0, 5.0])


# annotations


def test_lengths_of_lists_that_are_fixed() -> None:
    for annotation, length in (
        (tuple[int, int, int], 3),
        (Annotated[tuple[int, int], Field()], 2),
        (tuple[int, ...], None),
        (Annotated[list[int], Field()], None),
        (None | tuple[int, int], 2),
        (str | tuple[int, ...], None),
        (float, None),
    ):
        assert fixed_length(annotation) == length


def test_annotations_are_found_where_the_data_leads() -> None:
    class Leaf(BaseModel):
        size: Annotated[float, Field(gt=0)] = 1.0
        pair: tuple[int, str] = (1, "a")

    class Root(BaseModel):
        many: dict[str, list[Leaf]] | None = None
        either: int | Mapping[str, str] = 0
        rows: Sequence[tuple[float, ...]] = ()
        plain: float = 0.0

    data = {"many": {"x": [{"size": 2.0}]}, "either": {"a": "b"}, "rows": [[1.0, 2.0]], "plain": 3.0}
    for path, annotation in (
        (("many", "x", 0), Leaf),
        (("many", "x", 0, "pair", 1), str),
        (("many", "x", 0, "pair", 0), int),
        (("either", "a"), str),
        (("rows", 0, 1), float),
        (("nothing",), None),
        (("many", "x", 0, "nothing"), None),
        (("plain", "deeper"), None),
        (("plain", "deeper", 0), None),
    ):
        assert annotation_at(Root, data, path) is annotation
    size = annotation_at(Root, data, ("many", "x", 0, "size"))
    with pytest.raises(ValidationError, match="greater than 0"):
        TypeAdapter(size).validate_python(0)
