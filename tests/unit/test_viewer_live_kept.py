"""What a live view keeps between two frames: of which sensors, how many, of which copy, and after a jump."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.sensors.sensor import Reading
from pelagos.viewer import live as module
from pelagos.viewer.live import Live


class Block(dict[str, list[Reading]]):
    def newest(self, name: str) -> Reading | None:
        return self[name][-1] if self[name] else None


class Sea:
    """A simulation of three copies of which only what a view looks at is there."""

    def __init__(self, count: int = 2) -> None:
        kinds = {"mbes": "multibeam", "imu": "imu", "msis": "mechanical_scanning_sonar"}
        sensors = {name: SimpleNamespace(config=SimpleNamespace(type=kind)) for name, kind in kinds.items()}
        names = [f"a{k}" for k in range(count)]
        self.model = SimpleNamespace(agents={n: SimpleNamespace(sensors=sensors if n == "a0" else {}) for n in names})
        self.bodies = SimpleNamespace(bodies=[])
        self.stepper = SimpleNamespace(missions=SimpleNamespace(solutions={}))
        self.time_ns = 0
        self.names = names

    @property
    def state(self) -> dict[str, Any]:
        t = self.time_ns * 1e-9
        rows = np.arange(3.0)[:, None]
        return {
            n: SimpleNamespace(position=rows * 100 + [10.0 * k, t, -1.0], attitude=np.tile([1.0, 0, 0, 0], (3, 1)),
                               velocity=rows + np.array([t, 0.0, 0.0]), actuators=rows * [1.0, 2.0])
            for k, n in enumerate(self.names)
        }  # fmt: skip


def reading(t_ns: int, *, valid: bool = True) -> Reading:
    data = t_ns * 1e-9 + np.array([[0.0], [100.0], [200.0]])
    return Reading(data, data, t_ns, "a0/x", np.array([not valid, valid, not valid]), {})


@pytest.fixture
def sea(monkeypatch: pytest.MonkeyPatch) -> Sea:
    monkeypatch.setattr(module, "sample_of", lambda config, reading, truth: (config.type, reading, truth))
    monkeypatch.setattr(module, "EVERY_S", 1e9)  # only `show` makes a frame, and a jump
    return Sea()


def watched(sea: Any, copy: int = 1) -> Live:
    live = Live(sea, copy=copy)
    live.heard(Block({}))  # type: ignore[arg-type]
    live.take(0.0)
    return live


def heard(sea: Any, live: Live, t_s: float, **found: list[Reading]) -> None:
    sea.time_ns = round(t_s * 1e9)
    live.heard(Block({f"a0.{name}": values for name, values in found.items()}))  # type: ignore[arg-type]


def seen(frame: Any) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for placed in frame.samples:
        found.setdefault(placed.sample[0], []).append(float(placed.sample[1].data[0, 0]))
    return found


def test_of_pictures_the_newest_and_of_waterfalls_all_are_shown_of_ones_own_copy(sea: Any) -> None:
    live = watched(sea)
    for k in (1, 2, 3):
        times = [k * 10**8 - 5 * 10**7, k * 10**8]
        heard(sea, live, 0.1 * k, mbes=[reading(t) for t in times], imu=[reading(t) for t in times],
              msis=[reading(times[0], valid=False), reading(times[1])])  # fmt: skip
        if k < 3:
            live.show()
    live.show()
    frame: Any = live.take(0.0)
    assert frame.t_ns == 300_000_000
    found = seen(frame)
    assert found["multibeam"] == pytest.approx([100.05, 100.1, 100.15, 100.2, 100.25, 100.3])
    assert found["imu"] == pytest.approx([100.3])
    assert found["mechanical_scanning_sonar"] == pytest.approx([100.1, 100.2, 100.3])
    assert all(p.sample[2] is True for p in frame.samples)
    at = {round(float(p.sample[1].data[0, 0]), 2): p.pose.position for p in frame.samples if p.sample[0] == "multibeam"}
    np.testing.assert_allclose(at[100.15], [100, 100.15, 99])  # y is the time, between two poses that were kept
    assert [frame.agents[n].position.tolist() for n in ("a0", "a1")] == [[100, 100.3, 99], [110, 100.3, 99]]
    np.testing.assert_allclose(frame.agents["a1"].velocity, [1.3, 1, 1])
    np.testing.assert_allclose(frame.agents["a1"].actuators, [1, 2])
    assert not frame.jump
    assert live.take(0.0) is None
    live.show()
    assert live.take(0.0).samples == []  # type: ignore[union-attr]


def test_no_more_wait_than_sixty_of_a_sensor(sea: Any) -> None:
    live = watched(sea)
    for k in range(1, 9):
        heard(sea, live, float(k), mbes=[reading(k * 10**9 + j * 10**7) for j in range(10)])
        live.show()
    found = seen(live.take(0.0))["multibeam"]
    assert len(found) == 60
    assert found[-1] == pytest.approx(108.09)
    assert found[0] == pytest.approx(103.0)


def test_time_that_goes_back_is_a_jump_however_late_the_frame_is_taken(sea: Any) -> None:
    live = watched(sea)
    heard(sea, live, 5.0, mbes=[reading(5 * 10**9)], imu=[reading(5 * 10**9)])
    live.show()
    heard(sea, live, 0.0, mbes=[reading(0)])
    heard(sea, live, 0.5, mbes=[reading(5 * 10**8)])
    live.show()
    frame: Any = live.take(0.0)
    assert frame.jump
    assert frame.t_ns == 500_000_000
    assert seen(frame) == {"multibeam": pytest.approx([100.0, 100.5])}
    heard(sea, live, 0.7)
    live.show()
    assert not live.take(0.0).jump  # type: ignore[union-attr]


def test_estimates_and_bodies_are_those_of_ones_own_copy(sea: Any) -> None:
    rows = np.arange(9.0).reshape(3, 3)
    q = np.arange(12.0).reshape(3, 4)
    old, new = (SimpleNamespace(position=rows + k, attitude=q + k) for k in (50, 0))
    sea.stepper.missions.solutions = {"a0": [old, new], "a1": []}
    sea.bodies.bodies = [SimpleNamespace(name="crate", position=rows + 7, attitude=q + 7)]
    live = Live(sea, copy=2)
    live.status = lambda: {"paused": True}
    live.show()
    frame: Any = live.take(0.0)
    assert {n: p.position.tolist() for n, p in frame.navigation.items()} == {"a0": [6, 7, 8]}
    assert frame.navigation["a0"].attitude.tolist() == [8, 9, 10, 11]
    assert frame.movers["crate"].position.tolist() == [13, 14, 15]
    assert frame.movers["crate"].attitude.tolist() == [15, 16, 17, 18]
    assert frame.status == {"paused": True}


@pytest.mark.parametrize(("count", "kept"), [(20, [0, 1, 2, 3]), (21, [3])])
def test_of_many_agents_poses_are_kept_with_frames_alone(count: int, kept: list[int], monkeypatch: Any) -> None:
    monkeypatch.setattr(module, "EVERY_S", 1e9)
    sea: Any = Sea(count)
    live = watched(sea)
    for t in (1, 2, 3):
        heard(sea, live, float(t))
    live.show()
    assert [t // 10**9 for t, _ in live._poses["a7"]] == kept
    heard(sea, live, 5.0)
    live.show()
    assert [t // 10**9 for t, _ in live._poses["a7"]] == [*kept, 5]
