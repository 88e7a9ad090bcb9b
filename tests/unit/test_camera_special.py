"""Event and thermal cameras, and annotations."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from oceans import lit_ocean
from pelagos import jit
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.event_camera import EventCamera, EventCameraConfig, event_count, events
from pelagos.sensors.camera.picture.annotations import boxes, coco, run_lengths
from pelagos.sensors.camera.picture.boxes_3d import boxes_3d
from pelagos.sensors.camera.thermal_camera import ThermalCamera, ThermalCameraConfig
from pelagos.sensors.sensor import Kinematics, Measurement, SensorContext
from pelagos.world.material import MATERIALS, material_tables

SIZE: dict[str, Any] = {"width_px": 96, "height_px": 64}


def half(material: int, low: float, high: float, bottom: float, top: float, x: float = 2.0) -> Geometry:
    corners = np.array([[x, high, bottom], [x, low, bottom], [x, low, top], [x, high, top]], dtype=float)
    return Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), material, 7, material + 1)


def context(geometries: list[Geometry], *, sun: float = 1.2) -> SensorContext:
    materials = [MATERIALS["white"], MATERIALS["black"]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    ocean = lit_ocean("I", sun, math.pi, temperature_c=8.0)
    return SensorContext(
        "auv0.view", 1, 5_000_000, Scene(geometries, copies=1), world, ocean, np.full(1, NO_BODY, np.uint32)
    )


def ahead(*, velocity: Any = (0.0, 0.0, 0.0), height: float = -10.0) -> Kinematics:
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)

    def vector(v: Any) -> Any:
        return jit.Array3f64(*(zero + float(c) for c in v))

    none = vector((0, 0, 0))
    attitude = jit.Array4f64(zero + 1, zero, zero, zero)
    motion = Kinematics(
        vector((0, 0, height)),
        attitude,
        vector(velocity),
        none,
        none,
        none,
        jit.UInt64(u) + 10**9,
        u + 200,
        u + 0,
        u + 0,
    )
    dr.make_opaque(motion)  # one kernel serves all poses
    return motion


def plates() -> list[Geometry]:
    return [half(0, 0.0, 40.0, -30, -1), half(1, -40.0, 0.0, -30, -1)]


def test_nothing_moves_nothing_happens():
    config = EventCameraConfig(ripple=0.0, background_hz=0.0, **SIZE)
    got = EventCamera(config, context(plates())).sense(ahead())
    assert not got.data.any()


@pytest.mark.parametrize("speed", [3.0, -2.2])
def test_a_moving_edge_makes_events_of_one_sign_where_it_passes(speed):
    """White comes where black was, or the other way; each row has a column for every middle that the edge passes."""
    config = EventCameraConfig(ripple=0.0, background_hz=0.0, threshold_mismatch=0.0, rate_hz=10.0, **SIZE)
    got = EventCamera(config, context(plates())).sense(ahead(velocity=(0, speed, 0)))
    rows, columns = np.nonzero(got.data[0])
    shift = abs(speed) * 0.1 / 2.0 * 48 / math.tan(math.radians(35))  # pixels that the edge moved
    assert len(rows) == pytest.approx(64 * shift, abs=64)  # a column at most, more or less
    assert (np.sign(got.data[0][rows, columns]) == np.sign(speed)).all()
    listed = events(got, 0, config)
    assert len(listed) == np.abs(got.data[0]).sum()
    assert (np.diff(listed[:, 2]) >= 0).all()
    assert listed[:, 2].min() >= -0.1
    assert listed[:, 2].max() <= 0


def test_events_come_when_a_steady_change_crosses_each_threshold():
    """Event k of a pixel that began a part p of a threshold c ahead: (k + 1 - p) c/|change| of a sample has passed."""
    config = EventCameraConfig(threshold=0.2, rate_hz=10.0, threshold_mismatch=0.0)
    count, change, phase = (np.zeros((1, 2, 3)) for _ in range(3))
    count[0, 0, 1], change[0, 0, 1], phase[0, 0, 1] = 3, 0.5, 0.7
    count[0, 1, 2], change[0, 1, 2], phase[0, 1, 2] = -2, -0.44, 0.1
    made = Measurement(count, None, None, {"log_change": change, "phase": phase}, {})
    up = [(1, 0, (k + 0.3) * 0.2 / 0.5, 1) for k in range(3)]
    down = [(2, 1, (k + 0.9) * 0.2 / 0.44, -1) for k in range(2)]
    expected = sorted(
        ((c, r, (min(share, 1.0) - 1.0) / 10.0, p) for c, r, share, p in (*up, *down)), key=lambda e: e[2]
    )
    assert events(made, 0, config) == pytest.approx(np.array(expected), abs=1e-12)


def test_a_body_that_moves_makes_events_at_its_edges():
    """A white plate before a black wall: brighter where it comes, darker where it was, as many as its way is long."""
    made = context([half(1, -40.0, 40.0, -30, -1, 2.5)])
    made.scene.set_moving([(half(0, -0.4, 0.4, -0.5, 0.5), 0)])
    still = np.zeros((1, 3))
    made.scene.move(np.array([[0.0, 0, -10]]), np.array([[1.0, 0, 0, 0]]), np.array([[0.0, 3.0, 0]]), still)
    config = EventCameraConfig(ripple=0.0, background_hz=0.0, threshold_mismatch=0.0, rate_hz=10.0, **SIZE)
    got = EventCamera(config, made).sense(ahead()).data[0]
    focal = 48 / math.tan(math.radians(35))
    high, way = 1.0 / 2.0 * focal, 3.0 * 0.1 / 2.0 * focal  # [px], each a pixel more or less
    for count in ((got > 0).sum(), (got < 0).sum()):
        assert (high - 1) * (way - 1) < count < (high + 1) * (way + 1)
    assert np.nonzero(got > 0)[1].mean() < 48 < np.nonzero(got < 0)[1].mean()  # it goes to the left


def test_count_is_the_change_over_the_threshold():
    """Mean over a uniform phase is exactly |change| / threshold."""
    phase = jit.Float((np.arange(10_000) + 0.5) / 10_000)
    config = EventCameraConfig(threshold=0.2, refractory_s=0.0)
    for change in (0.05, 0.2, 0.73, -0.5):
        count = np.array(event_count(jit.Float(change), phase, 0.2, config), dtype=float)
        assert count.mean() == pytest.approx(change / 0.2, abs=2e-4)


def test_background_events_have_their_rate():
    config = EventCameraConfig(ripple=0.0, background_hz=3.0, rate_hz=10.0, width_px=320, height_px=320)
    got = EventCamera(config, context(plates())).sense(ahead())
    n = got.data.size
    assert (got.data - got.truth).sum() / n == pytest.approx(0.3, abs=5 * math.sqrt(0.3 * 0.7 / n))


def test_water_hides_everything_from_heat():
    config = ThermalCameraConfig(noise_k=0.0, **SIZE)
    got = ThermalCamera(config, context(plates())).sense(ahead())
    assert got.truth == pytest.approx(8.0, abs=1e-3)


def sea_and_sky(down: float, right: float) -> float:
    """Apparent temperature [degC] of a sea at 8 degC that mirrors a sky of -25 overhead and 15 at the horizon.

    The sea's heat by what Fresnel's equations leave of it, index 1.22; `down`, `right` of the middle [px].
    """
    focal = 48 / math.tan(math.radians(35))
    rise = down / math.sqrt(down**2 + right**2 + focal**2)
    within = math.sqrt(1 - (1 - rise**2) / 1.22**2)  # cosine of the refracted ray, of what falls in at `rise`
    across, along = (rise - 1.22 * within) / (rise + 1.22 * within), (within - 1.22 * rise) / (within + 1.22 * rise)
    mirror = (across**2 + along**2) / 2
    sky = 248.15**4 + (288.15**4 - 248.15**4) * math.exp(-rise / 0.35)
    return float(((1 - mirror) * 281.15**4 + mirror * sky) ** 0.25 - 273.15)


def test_sky_is_cold_sea_is_itself_and_walls_take_the_sun():
    walls = [half(0, 0.0, 4.0, 0.5, 4.0, 6.0), half(1, -4.0, 0.0, 0.5, 4.0, 6.0)]
    config = ThermalCameraConfig(noise_k=0.0, attenuation_per_km=0.0, width_px=96, height_px=96)
    picture = ThermalCamera(config, context(walls, sun=0.6)).sense(ahead(height=2.0)).truth[0]
    assert picture[0].max() < 12  # sky
    assert picture[95, 48] == pytest.approx(sea_and_sky(95.5 - 48, 48.5 - 48), abs=0.02)  # single precision of T^4
    assert picture[80, 20] == pytest.approx(sea_and_sky(80.5 - 48, 20.5 - 48), abs=0.02)
    white, black = picture[45, 20], picture[45, 75]
    assert black > white + 5  # a black wall in the sun
    shade = ThermalCamera(config, context(walls, sun=-0.2)).sense(ahead(height=2.0)).truth[0]
    assert shade[45, 20] == pytest.approx(shade[45, 75])
    assert shade[45, 20] == pytest.approx(15.0, abs=2.0)


def test_thermal_noise_is_as_asked():
    config = ThermalCameraConfig(noise_k=0.05, width_px=200, height_px=200)
    got = ThermalCamera(config, context(plates())).sense(ahead())
    error = (got.data - got.truth).ravel()
    assert error.std() == pytest.approx(0.05, rel=0.02)


def test_boxes_hold_exactly_what_is_seen():
    instances = np.zeros((20, 30), dtype=np.uint32)
    labels = np.zeros((20, 30), dtype=np.uint8)
    instances[4:9, 10:18] = 5
    labels[4:9, 10:18] = 22
    instances[8, 17] = 9
    labels[8, 17] = 23
    found = boxes(instances, labels)
    assert [(b.instance, b.label, b.column, b.row, b.width, b.height, b.area) for b in found] == [
        (5, 22, 10, 4, 8, 5, 39),
        (9, 23, 17, 8, 1, 1, 1),
    ]
    assert [b.instance for b in boxes(instances, labels, least_area=2)] == [5]


def test_coco_masks_decode_to_the_pixels():
    rng = np.random.default_rng(1)
    instances = rng.integers(0, 4, (12, 17)).astype(np.uint32)
    labels = np.where(instances > 0, 20 + instances, 0).astype(np.uint8)
    made = coco([("frame_1.png", instances, labels)])
    assert made["images"][0] == {"id": 1, "file_name": "frame_1.png", "width": 17, "height": 12}
    assert [c["name"] for c in made["categories"]] == ["sub", "pier", "buoy"]
    for a in made["annotations"]:
        runs = a["segmentation"]["counts"]
        flat = np.repeat(np.arange(len(runs)) % 2, runs)
        assert np.array_equal(flat.reshape(17, 12).T == 1, instances == a["instance_id"])
        assert a["area"] == (instances == a["instance_id"]).sum()


def test_run_lengths_begin_with_zeros():
    assert run_lengths(np.array([[True, False], [True, True]])) == [0, 2, 1, 1]
    assert run_lengths(np.zeros((2, 2), dtype=bool)) == [4]


def test_boxes_in_space_join_the_parts_of_an_object():
    a, b = half(0, 0.0, 2.0, -3, -1), half(0, -1.0, 0.0, -2, 4)
    made = boxes_3d([a, b])
    assert made[1].corners.min(axis=0).tolist() == [2.0, -1.0, -3.0]
    assert made[1].corners.max(axis=0).tolist() == [2.0, 2.0, 4.0]
    assert made[1].label == a.label
