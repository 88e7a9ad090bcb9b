"""Panels of the page: what is sent of them, to whom, and when."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.drawing.sample import Sample
from pelagos.viewer.panels import LINES, Panel, Panels, _rounded


class Ear:
    def __init__(self, count: int = 1) -> None:
        self.count = count
        self.told: list[Any] = []

    def publish(self, key: str, header: Any, blob: bytes = b"", *, keep: bool = True) -> None:
        self.told.append((key, dict(header), blob))


def panels() -> Panels:
    kinds = {"a.cam": "camera", "b.cam": "camera", "a.imu": "imu"}
    config = lambda kind: SimpleNamespace(
        type=kind, rate_hz=5.0, model_dump=lambda mode: {"type": kind, "gain": 2, "x": None}
    )
    return Panels({name: config(kind) for name, kind in kinds.items()})  # type: ignore[misc]


def picture(shade: int) -> Any:
    return np.full((8, 9, 3), shade, dtype=np.uint8)


def test_pictures_go_to_those_who_look_at_them_and_numbers_to_all() -> None:
    made: Any = panels()
    made.take(Sample("a.cam", "camera", 2_500_000_000, picture=picture(10)))
    made.take(Sample("b.cam", "camera", 2_500_000_000, picture=b"\xff\xd8 as it was"))
    made.take(Sample("a.imu", "imu", 2_600_000_000, numbers={"rate": 1 / 3, "lost": np.nan}, truth={"rate": 0.25}))
    made.take(Sample("c.imu", "imu", 1, numbers={"rate": 1.0}))  # of nobody that is shown
    ear: Any = Ear()
    made.publish(ear, {"b.cam"})
    heads = {key: header for key, header, _ in ear.told}
    blobs = {key: blob for key, _, blob in ear.told}
    assert list(heads) == ["panel/a.cam", "panel/b.cam", "panel/a.imu"]
    assert [h["pictured"] for h in heads.values()] == [False, True, False]
    assert blobs == {"panel/a.cam": b"", "panel/b.cam": b"\xff\xd8 as it was", "panel/a.imu": b""}
    assert heads["panel/a.imu"] == {
        "type": "panel", "name": "a.imu", "t": 2.6, "numbers": {"rate": 0.333333, "lost": None}, "pictured": False,
        "truth": {"rate": 0.25},
    }  # fmt: skip
    assert "truth" not in heads["panel/a.cam"]
    ear.told.clear()
    made.publish(ear, None)
    assert ear.told == []  # nothing new
    made.take(Sample("a.cam", "camera", 3_000_000_000, picture=picture(200)))
    nobody: Any = Ear(0)
    made.publish(nobody, None)
    assert [h["pictured"] for _, h, _ in nobody.told] == [False]
    made.panels["a.cam"].fresh = True
    made.publish(ear, None)
    assert ear.told[0][2].startswith(b"\xff\xd8")
    made.clear()
    made.publish(ear, None)
    assert len(ear.told) == 1


def test_a_list_of_sensors_has_their_settings_that_are_set() -> None:
    listed = panels().listing()
    assert [(s["name"], s["kind"], s["pictured"]) for s in listed] == [
        ("a.cam", "camera", True), ("b.cam", "camera", True), ("a.imu", "imu", False)
    ]  # fmt: skip
    assert listed[0]["config"] == {"gain": 2}
    assert listed[0]["rate_hz"] == 5


def test_the_newest_line_of_a_waterfall_is_on_top_and_another_width_begins_anew() -> None:
    panel = Panel(SimpleNamespace(type="sidescan"))  # type: ignore[arg-type]
    assert panel.picture() is None
    for k in range(1, LINES + 3):
        panel.take(Sample("a.s", "sidescan", k, line=np.full((4, 3), k % 251, dtype=np.uint8)))
    found = panel.picture()
    assert isinstance(found, np.ndarray)
    assert found[:, 0, 0].tolist() == [(LINES + 2 - k) % 251 for k in range(LINES)]
    panel.take(Sample("a.s", "sidescan", 999, line=np.full((5, 3), 7, dtype=np.uint8)))
    found = panel.picture()
    assert isinstance(found, np.ndarray)
    assert found.shape == (LINES, 5, 3)
    assert found[0].min() == 7
    assert found[1:].max() == 0


@pytest.mark.parametrize(("angle", "row", "column"), [(0.0, 20, 160), (np.pi / 2, 160, 20), (-np.pi / 2, 160, 299),
                                                      (np.pi, 299, 160)])  # fmt: skip
def test_a_scanning_sonars_picture_has_ahead_up_and_port_at_the_left(angle: float, row: int, column: int) -> None:
    panel = Panel(SimpleNamespace(type="mechanical_scanning_sonar", step_deg=4.0))  # type: ignore[arg-type]
    colours = np.zeros((16, 3), dtype=np.uint8)
    colours[14] = 200  # from 14/16 to 15/16 of the range
    panel.take(Sample("a.s", "mechanical_scanning_sonar", 1, sector=(colours, angle)))
    found = panel.picture()
    assert isinstance(found, np.ndarray)
    rows, columns = np.nonzero(found[..., 0])
    assert abs(rows.mean() - row) < 8
    assert abs(columns.mean() - column) < 8
    away = np.hypot(rows + 0.5 - 160, columns + 0.5 - 160) / 160
    assert 0.86 < away.min() < away.max() < 0.95


def test_numbers_are_told_to_six_digits() -> None:
    assert [_rounded(v) for v in (1234.56789, -0.000123456789, np.inf)] == [1234.57, -0.000123457, None]


def test_swaths_that_met_nothing_have_no_picture() -> None:
    panel = Panel(SimpleNamespace(type="multibeam"))  # type: ignore[arg-type]
    panel.take(Sample("a.m", "multibeam", 1, swath=np.full(9, np.nan, dtype=np.float32)))
    assert panel.scale is None
    assert panel.picture() is None
