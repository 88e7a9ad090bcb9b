"""What a record's columns may do from row to row, at both sides of each limit; and velocities from slopes of a pose."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.spatial.transform import Rotation

from pelagos.errors import InputError
from pelagos.identification.noise import BeamNoise
from pelagos.identification.noise_keys import keys_of_beams
from pelagos.identification.plausibility import between_jumps, dropped, jumps, plausible, steady
from pelagos.identification.record import _slopes
from pelagos.identification.recording import read_topic

T = 0.1 * np.arange(100)
TURN = 2 * np.pi


def stepped(size: float, slow: float = 1e-3) -> np.ndarray:
    """A column that goes on by `slow` from row to row, and once, after row 40, by `size` more."""
    return slow * np.arange(100.0) + size * (np.arange(100) > 40)


@pytest.mark.parametrize(
    ("name", "size", "found"),
    [
        ("u", 0.9, []), ("u", 1.1, [40]), ("u", -1.1, [40]), ("r", 1.1, [40]),  # 10 m/s^2 in a tenth of a second
        ("north", 0.09, []), ("north", -0.11, [40]), ("depth", 0.11, [40]),
        ("heading", TURN + 0.05, []), ("heading", -TURN - 0.05, []), ("heading", TURN + 0.12, [40]),
        ("heading", 0.2, [40]),
        ("north", TURN + 0.05, [40]),
    ],
)  # fmt: skip
def test_a_jump_is_harder_than_a_vehicle_is_moved(name: str, size: float, found: list[int]) -> None:
    assert jumps(name, stepped(size), T).tolist() == found


@pytest.mark.parametrize(("slow", "found"), [(0.06, []), (0.04, [40])])
def test_a_jump_is_twenty_times_the_usual_change(slow: float, found: list[int]) -> None:
    assert jumps("u", stepped(1.05, slow), T).tolist() == found
    near = np.where(np.abs(np.arange(100) - 41) < 8, 0.06 * (-1.0) ** np.arange(100), 0.0)
    assert jumps("u", np.cumsum(near) + stepped(1.05, 0.0), T).tolist() == []  # about there
    assert jumps("u", 0 * T, T).tolist() == []
    assert jumps("heading", stepped(TURN + 0.5), 5 * T).tolist() == [40]  # too much beside a turn to be one


def test_rows_between_two_near_jumps_are_a_fault() -> None:
    assert np.flatnonzero(between_jumps(np.array([3, 8, 20, 22]), 30)).tolist() == [4, 5, 6, 7, 8, 21, 22]
    assert not between_jumps(np.array([3, 9]), 30).any()


@pytest.mark.parametrize(
    ("value", "rows", "found"),
    [(0.0, [41], [41]), (0.0, [41, 42], [41, 42]), (7.0, [41], None), (7.0, [41, 60], [41, 60])],
)
def test_a_number_that_is_jumped_to_is_a_drop_out(value: float, rows: list[int], found: list[int] | None) -> None:
    """0, or any other that is so exactly more than once; not one that is come to otherwise."""
    values = 3.0 + stepped(0.0)
    values[rows] = value
    told = dropped(values, jumps("u", values, T))
    assert (None if told is None else (told[0], told[1].tolist())) == (None if found is None else (value, found))
    slow = np.concatenate([np.linspace(3.0, 0.0, 98), [5.0, 5.01]])
    assert dropped(slow, np.array([96])) is None


@pytest.mark.parametrize(
    ("name", "values", "unit", "said"),
    [
        ("roll", stepped(0.0) + 3.05, "", ""), ("roll", stepped(0.0) - 3.3, "", "largest roll there is: degrees"),
        ("pitch", stepped(0.0) + 1.5, "", ""), ("pitch", stepped(0.0) - 1.8, "deg", "largest pitch there is"),
        ("heading", 0.3 * np.arange(100), "", ""),  # counts on
        ("heading", stepped(359.0), "", "jumps by 359: degrees"), ("heading", stepped(6.7), "", "6.701: degrees"),
        ("heading", stepped(6.3), "", ""),
        ("heading", np.radians(stepped(-6.2)), "deg", "no number is beyond 2 pi, and they jump by 6.199: radians"),
        ("heading", np.radians(stepped(-5.9)), "deg", ""), ("heading", np.radians(stepped(-6.2) + 30), "deg", ""),
        ("heading", np.radians(stepped(360.0)), "deg", ""),
        ("u", stepped(59.0), "", ""), ("u", stepped(-61.0), "", "has (60); wrong unit? Give unit: cm/s"),
        ("u", stepped(61.0), "mm/s", "a mark of lost rows"), ("depth", stepped(12001.0), "km", "Give unit: m, cm, mm"),
        ("q", stepped(20.5), "", "Give unit: deg/s, deg/min, rpm"),
    ],
)  # fmt: skip
def test_values_that_no_vehicle_has_are_refused(name: str, values: np.ndarray, unit: str, said: str) -> None:
    if not said:
        plausible(name, values, "col", unit, "data")
        return
    with pytest.raises(InputError) as caught:
        plausible(name, values, "col", unit, "data")
    assert str(caught.value).startswith(f"data: column 'col' as {name}: ")
    assert said in str(caught.value)


@pytest.mark.parametrize(("count", "refused"), [(1, False), (3, True)])
def test_a_pose_may_be_too_fast_in_few_rows(count: int, refused: bool) -> None:
    """61 m/s in up to 2 of 100 rows; whole turns of a heading are no speed, and velocities have none."""
    values = np.zeros(100)
    values[np.arange(count) * 20 + 5] = 6.1 * (-1.0) ** np.arange(count)
    values = np.cumsum(values)
    if refused:
        with pytest.raises(InputError, match="as north"):
            steady("north", values, T, "x", "data")
        with pytest.raises(InputError, match=r"as heading: 3 % of its rows .* than 20 rad/s|jumps in 3 %"):
            steady("heading", values * 0.4, T, "x", "data")
    else:
        steady("north", values, T, "x", "data")
    steady("u", values, T, "x", "data")
    steady("north", 0.95 * values, T, "x", "data")
    steady("heading", np.where(np.arange(100) % 20 > 10, TURN, 0.05), T, "x", "data")


def test_slopes_of_a_pose_are_the_velocities_of_the_body() -> None:
    """A motion on six axes, turned by SciPy; parabolas over 0.1 s miss a sine's slope by (w T/2)^2/10, 1e-4 of it."""
    h, t = 0.02, 0.02 * np.arange(500)
    euler = np.stack([0.25 * t + 0.3 * np.sin(0.6 * t), 0.1 + 0.3 * np.cos(0.4 * t), 0.4 * np.sin(0.5 * t)], -1)
    nu = np.stack([1.0 + 0.3 * np.sin(0.7 * t), 0.4 * np.cos(0.5 * t), -0.3 * np.sin(0.3 * t + 1)], -1)
    turn = Rotation.from_euler("ZYX", euler)
    place = cumulative_trapezoid(turn.apply(nu), t, axis=0, initial=0)
    pose = dict(zip(("north", "east", "depth", "heading", "pitch", "roll"), [*place.T, *euler.T], strict=True))
    found = _slopes(pose, ((0, 200), (260, 500)), h, 0.1)
    rates = (turn[:-2].inv() * turn[2:]).as_rotvec() / (2 * h)
    inside = np.r_[10:190, 270:490]
    for k, name in enumerate(("u", "v", "w")):
        assert found[name][inside] == pytest.approx(nu[inside, k], abs=1e-3), name
    for k, name in enumerate(("p", "q", "r")):
        assert found[name][inside] == pytest.approx(rates[inside - 1, k], abs=1e-3), name
        assert np.isnan(found[name][200:260]).all()
    assert set(_slopes({"depth": pose["depth"], "roll": pose["roll"]}, ((0, 500),), h, 0.1)) == {"w", "p"}
    alone = _slopes({"depth": pose["depth"]}, ((0, 500),), h, 0.1)["w"]
    assert alone[inside] == pytest.approx(np.gradient(pose["depth"], h)[inside], abs=1e-3)


class Bag:
    """Two topics of unequal times [ns]."""

    def __init__(self, path: Any) -> None:
        self.times = {"/a": [5_000_000_000, 5_250_000_000, 5_750_000_000], "/b": [5_000_000_001, 5_250_000_000]}

    def topics(self) -> list[str]:
        return list(self.times)

    def messages(self, topic: str) -> Any:
        for ns in self.times[topic]:
            yield SimpleNamespace(t_ns=ns, message={"x": ns * 1e-9, "y": -2.0, "roll": 3.0 if ns % 3 else -3.0})


def test_a_topic_is_read_message_by_message(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pelagos.identification.recording.Recording", Bag)
    found = read_topic(Path("it"), ["t", "/a.x", "/a.y"])
    assert found["t"] == pytest.approx([0.0, 0.25, 0.75])
    assert found["/a.x"] == pytest.approx([5.0, 5.25, 5.75])
    assert set(found) == {"t", "/a.x", "/a.y"}
    with pytest.raises(
        InputError, match=r"^it: /a\.x and /b\.y are of topics with other times: name fields of one topic$"
    ):
        read_topic(Path("it"), ["/a.x", "/b.y"])


def test_keys_of_a_log_are_what_its_record_shows() -> None:
    found = BeamNoise(0.003, 0.0, 0.004, 0.0021, 0.87, (0, 0, 0, 0), 900)
    rest, relative = keys_of_beams(found)
    assert (rest.line, relative.value) == ("noise_mps: 0.003  # [m/s]", None)
    assert relative.line == "# noise_relative: not seen at 0.87 m/s along the beams, below 0.0021 [1]"
