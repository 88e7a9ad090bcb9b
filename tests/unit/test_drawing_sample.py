"""What a panel shows of a reading: that of the copy asked for, and every camera's numbers as colours."""

from __future__ import annotations

import colorsys
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

import made_up
from pelagos.drawing import sample as drawn
from pelagos.drawing.colours import DIFFERENCE, display, painted, shades
from pelagos.drawing.sample import cloud, numbers_of, photograph, sample_of, swath_of, waterfall_line
from pelagos.messages.fan import copper
from pelagos.sensors.sensor import Reading
from pelagos.world.label import label_color


def joined(a: Reading, b: Reading) -> Reading:
    """Two readings as the copies of one."""
    extras = {k: np.concatenate([v, b.extras[k]]) if len(v) == len(a.data) else v for k, v in a.extras.items()}
    return replace(
        a, data=np.concatenate([a.data, b.data]), truth=np.concatenate([a.truth, b.truth]), extras=extras,
        valid=np.ones(2, bool),
    )  # fmt: skip


@pytest.mark.parametrize("kind", made_up.KEYS)
def test_a_sample_is_of_the_copy_asked_for(kind: str) -> None:
    config = made_up.configs((kind,))[kind]
    first, second, _ = made_up.readings(kind, config)
    found = sample_of(config, joined(first, second), copy=1, truth=True)
    alone, other = sample_of(config, second, truth=True), sample_of(config, first, truth=True)
    for f in fields(found):
        if f.name != "t_ns":
            np.testing.assert_equal(getattr(found, f.name), getattr(alone, f.name), f.name)
    shown = [repr([getattr(s, f.name) for f in fields(s) if f.name != "t_ns"]) for s in (alone, other)]
    assert shown[0] != shown[1] or kind == "collision"  # of neither anything is hit


def test_values_are_painted_from_low_to_high_and_what_is_none_black() -> None:
    """256 colours, evenly; beyond either end the end's."""
    table = np.round(255 * DIFFERENCE(np.arange(256))[:, :3])
    values = np.array([[-4.0, -2.0, 1.0], [np.nan, 3.9, 8.0], [np.inf, 0.25, 4.0]])
    found = painted(values, -2.0, 4.0, DIFFERENCE)
    for v, colour in zip(values.ravel(), found.reshape(-1, 3), strict=True):
        level = round(min(max((v + 2) / 6, 0), 1) * 255) if np.isfinite(v) else None
        assert colour.tolist() == ([0, 0, 0] if level is None else table[level].tolist())
    assert values[0, 0] == -4.0  # what is painted stays
    level = painted([3.0, 3.5], 3.0, 3.0, DIFFERENCE)
    assert level.tolist() == [table[0].tolist(), table[128].tolist()]
    assert shades(DIFFERENCE)[0] == "#" + "".join(f"{int(c):02x}" for c in table[0])
    assert len(shades(DIFFERENCE)) == 9


def test_reflectances_are_shown_by_the_curve_of_srgb() -> None:
    """IEC 61966-2-1: 0.001 is 0.01292, a hundredth 0.09985 and a half 0.7354."""
    assert display([[-1.0, 0.001, 0.5], [0.0031308, 1.0, 7.0], [0.01, 0.02, 0.03]]) == pytest.approx(
        np.array([[0.0, 0.01292, 0.735357], [0.04045, 1.0, 1.0], [0.099853, 0.151701, 0.189744]]), abs=1e-5
    )


def test_pictures_of_any_depth_are_shown_in_eight_bits() -> None:
    colour = np.array([[[0, 255, 256], [513, 40_000, 65_535]]], dtype=np.uint16)
    assert photograph("camera", colour).tolist() == [[[0, 0, 1], [2, 156, 255]]]
    linear = np.array([[[0.0, 0.5, 1.0], [-2.0, 0.1, 3.0]]], dtype=np.float32)
    expected = np.floor(255 * np.clip(linear, 0, 1) ** (1 / 2.2) + 0.5)
    assert photograph("camera", linear).tolist() == expected.tolist()
    grey = np.arange(12, dtype=np.uint8).reshape(3, 4)
    for one in (grey, grey[..., None]):
        assert photograph("camera", one).tolist() == np.repeat(grey[..., None], 3, axis=2).tolist()
    wide = np.arange(2 * 1300 * 3).reshape(2, 1300, 3).astype(np.uint8)
    assert photograph("camera", wide).tolist() == wide[::3, ::3].tolist()


def test_flow_is_shown_by_its_direction_and_speed() -> None:
    """Hue from right by down, as a colour wheel has it; full at the fastest hundredth."""
    angle = np.linspace(-np.pi, np.pi, 40, endpoint=False) + 0.03
    speed = np.linspace(0.0, 5.0, 40)
    data = np.stack([speed * np.cos(angle), speed * np.sin(angle)], axis=-1)[None].astype(np.float32)
    data[0, 3] = np.nan
    found = photograph("optical_flow_camera", data)[0]
    full = np.percentile(np.where(np.arange(40) == 3, 0.0, speed), 99)
    for k in range(40):
        value = 0.0 if k == 3 else min(speed[k] / full, 1.0)
        expected = 255 * np.array(colorsys.hsv_to_rgb((angle[k] / (2 * np.pi)) % 1.0, 1.0, value))
        assert found[k].astype(float) == pytest.approx(expected, abs=1.5), k


def test_depth_heat_normals_events_labels_and_objects_have_colours() -> None:
    depth = np.array([[1.0, 2.0, 4.0, np.inf]])
    assert photograph("depth_camera", depth).tolist() == painted(-depth, -np.percentile(depth[0, :3], 99), 0).tolist()
    bright = photograph("depth_camera", depth)[0].sum(axis=1)
    assert bright[0] > bright[1] > bright[2] > bright[3] == 0  # near is bright, nothing black
    heat = np.linspace(4.0, 9.0, 101)[None]
    assert photograph("thermal_camera", heat).tolist() == painted(heat, 4.05, 8.95, drawn.HEAT).tolist()
    normals = np.array([[[-1.0, 0.0, 1.0], [0.5, np.nan, -0.5]]])
    assert photograph("normal_camera", normals).tolist() == [[[0, 127, 255], [191, 0, 63]]]
    events = photograph("event_camera", np.array([[3, -1, 0]]))[0]
    assert events.tolist() == [[240, 228, 66], [0, 158, 200], [24, 24, 24]]
    labels = np.array([[53, 9], [0, 53]], dtype=np.uint8)
    expected = [[list(label_color(int(v))) for v in row] for row in labels]
    assert photograph("semantic_camera", labels).tolist() == expected
    ids = np.arange(400, dtype=np.uint32).reshape(20, 20)
    shown = photograph("instance_camera", ids).reshape(-1, 3)
    assert shown[0].tolist() == [0, 0, 0]
    assert (shown[1:].min(), shown[1:].max()) == (48, 248)
    assert len({tuple(c) for c in shown.tolist()}) == 400  # no two alike


def test_points_have_the_colours_of_their_labels_or_their_intensity() -> None:
    data = np.random.default_rng(5).uniform(-3, 3, (2, 6, 4)).astype(np.float32)
    data[0, 2, 1] = np.nan
    there = [(0, k) for k in range(6) if k != 2] + [(1, k) for k in range(6)]
    labels = np.arange(40, 52).reshape(2, 6)
    found = cloud(data, labels)
    assert found["points"].tolist() == [data[p][:3].tolist() for p in there]
    assert found["colours"].tolist() == [list(label_color(int(labels[p]))) for p in there]
    level = np.array([data[p][3] for p in there])
    assert cloud(data, None)["colours"].tolist() == painted(level, 0.0, np.percentile(level, 98)).tolist()


def test_lines_are_as_wide_as_a_panel_and_keep_the_brightest() -> None:
    """1201 bins a side: five together, port outwards to the left; the two that are left over are dropped."""
    levels = np.random.default_rng(6).integers(0, 256, (2, 1201)).astype(np.uint8)
    whole = [*levels[0][::-1], *levels[1]]
    step = -(-2402 // 480)
    expected = [max(whole[k : k + step]) for k in range(0, 2402 // step * step, step)]
    assert waterfall_line(levels).tolist() == copper()[expected].tolist()
    assert waterfall_line(levels[:1, :300]).tolist() == copper()[levels[0, :300]].tolist()


def test_a_swath_is_how_deep_beams_met_the_bottom() -> None:
    class Config:
        angles = np.linspace(-1.2, 1.1, 1000)

    ranges = np.random.default_rng(7).uniform(5, 9, 1000)
    expected = (ranges * np.cos(Config.angles))[::3]
    assert swath_of(Config, ranges) == pytest.approx(expected, rel=1e-6)


def test_numbers_have_names_and_units_where_these_are_known() -> None:
    field: Any = np.array([21e-6, -3e-6, 44e-6])
    assert list(numbers_of("magnetometer", field, {}).values()) == pytest.approx([21.0, -3.0, 44.0])
    found = numbers_of("dvl", np.array([1.0, -0.5, 0.25]), {"altitude": np.array([3.0, 7.0])}, 1)
    assert found == {"velocity x [m/s]": 1.0, "velocity y [m/s]": -0.5, "velocity z [m/s]": 0.25, "altitude [m]": 7.0}
    assert numbers_of("its_own", np.array([2.0]), {}) == {"its_own": 2.0}
    assert numbers_of("its_own", np.array([2.0, 5.0]), {}) == {"its_own 0": 2.0, "its_own 1": 5.0}
    assert len(numbers_of("its_own", np.zeros(16), {})) == 16
    assert numbers_of("its_own", np.zeros(17), {}) == {}
