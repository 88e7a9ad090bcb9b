"""Steering of vehicles that can stop, hovering ones and surface craft: lane by lane in plain numbers, many calls."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
import pytest

from pelagos.sim.guidance.aboard import Aboard, Fix, wrapped
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.steering import surface
from pelagos.sim.guidance.steering.hover import Hover
from pelagos.sim.guidance.steering.surface import Surface

PATHS: Final = [
    Path.LINE,
    Path.LINE,
    Path.CIRCLE,
    Path.CIRCLE,
    Path.POINT,
    Path.POINT,
    Path.DRIFT,
    Path.LINE,
    Path.OVER,
    Path.LINE,
]
N: Final = len(PATHS)


def scene(seed: int, dt: float, depth: float = 6.0) -> tuple[Goal, list[Aboard]]:
    """Goals of every shape, and vehicles that go about at random."""
    rng = np.random.default_rng(seed)
    nan = np.full(N, np.nan)
    goal = Goal(
        path=np.array(PATHS), start=rng.uniform(-9, 9, (N, 2)), end=rng.uniform(-9, 9, (N, 2)),
        radius=np.where(np.arange(N) == 4, np.nan, rng.uniform(2, 7, N)),
        turn=np.array([1.0, -1, 1, -1, 1, 1, 1, -1, 1, 1]),
        course=rng.uniform(-3, 3, N), face=nan.copy(), depth=rng.uniform(2, depth, N), upper=nan.copy(), glide=nan,
        speed=np.array([1.1, 0.6, 0.9, 0.4, 0.0, 0.12, 0.7, 0.9, 0.5, 0.8]), sink=nan.copy(),
        stops=np.array([True, False, False, False, True, True, True, False, True, True]),
    )  # fmt: skip
    goal.face[::3], goal.sink[1::3] = rng.uniform(-3, 3, 4), [0.1, 0.5, 0.05]
    place, heading = rng.uniform(-9, 9, (N, 3)) * [1, 1, 0.2] - [0, 0, 4.0], rng.uniform(-3, 3, N)
    place[[0, 7], :2] = goal.end[[0, 7]] + [0.4, -0.3]  # about to pass the end
    place[4, :2] = goal.end[4] + [0.1, -0.2]  # there already
    goal.end[9] = place[9, :2] + [25.0, 9.0]
    seen = []
    for k in range(40):
        velocity = rng.uniform(-0.6, 0.9, (N, 3))
        velocity[4] *= 0.02
        place, heading = place + dt * velocity, wrapped(heading + dt * rng.uniform(-1, 1, N))
        fix = Fix(place.copy(), heading.copy(), velocity)
        seen.append(Aboard(fix, k * dt, dt, np.full(N, np.inf), np.zeros(N, dtype=bool)))
    return goal, seen


class Point:
    """The point that one hovering vehicle follows."""

    def __init__(self, here: Any, heading: float, gain: float, lead: float) -> None:
        self.x, self.y, self.z = here
        self.speed, self.heading, self.gain, self.lead = 0.0, heading, gain, lead

    def goes(self, goal: Any, here: Any, entered: bool, dt: float) -> list[float]:
        if goal.path == Path.DRIFT or (entered and math.hypot(self.x - here[0], self.y - here[1]) > 2 * self.lead):
            self.x, self.y = here[:2]
        (ex, ey), (sx, sy) = goal.end, goal.start
        left = math.hypot(ex - self.x, ey - self.y)
        aim, room = (ex, ey), left
        if goal.path == Path.LINE:
            length = math.hypot(ex - sx, ey - sy)
            ux, uy = (ex - sx) / length, (ey - sy) / length
            run = min(max((self.x - sx) * ux + (self.y - sy) * uy + 0.5, 0.0), length)
            aim = (sx + run * ux, sy + run * uy)
            room = left if goal.stops else math.inf
        if goal.path == Path.CIRCLE:
            angle = math.atan2(self.y - ey, self.x - ex) - goal.turn * min(0.5, 0.2 * goal.radius) / goal.radius
            aim, room = (ex + goal.radius * math.cos(angle), ey + goal.radius * math.sin(angle)), math.inf
        far = math.hypot(aim[0] - self.x, aim[1] - self.y)
        to = ((aim[0] - self.x) / far, (aim[1] - self.y) / far) if far > 1e-9 else (0.0, 0.0)
        asked = 0.0 if goal.path == Path.DRIFT else goal.speed if goal.speed > 0 else 0.2
        asked *= min(max(2 - math.hypot(self.x - here[0], self.y - here[1]) / self.lead, 0.0), 1.0)
        asked = min(asked, math.sqrt(2 * self.gain * room))
        self.speed = min(max(asked, self.speed - 2 * self.gain * dt), self.speed + self.gain * dt)
        self.speed = min(self.speed, (left if goal.path == Path.LINE else room) / dt)
        vx, vy = self.speed * to[0], self.speed * to[1]
        self.x, self.y = self.x + dt * vx, self.y + dt * vy
        down = goal.depth - self.z
        rate = min(0.3 if math.isnan(goal.sink) else goal.sink, math.sqrt(self.gain * abs(down)), abs(down) / dt)
        rate = math.copysign(rate, down)
        rate *= min(max(2 - (self.z - here[2]) * math.copysign(1, rate) / self.lead, 0.0), 1.0)
        self.z += dt * rate
        wanted = goal.face
        if math.isnan(wanted):
            wanted = math.atan2(-vy, vx) if self.speed > 0.05 else self.heading
        turn = math.remainder(wanted - self.heading, 2 * math.pi)
        self.heading = math.remainder(self.heading + min(max(turn, -0.5 * dt), 0.5 * dt), 2 * math.pi)
        return [self.x, self.y, -self.z, -self.heading, vx, vy, -rate, float(goal.path != Path.DRIFT)]


def lane_of(goal: Goal, k: int) -> Any:
    return SimpleNamespace(**{name: values[k] for name, values in vars(goal).items()})


@pytest.mark.parametrize(("seed", "dt", "lead"), [(1, 0.4, 1.5), (2, 0.1, 0.6)])
def test_a_hovering_vehicle_follows_a_point_that_waits_brakes_and_turns(seed: int, dt: float, lead: float) -> None:
    goal, seen = scene(seed, dt)
    hover, points = Hover(gain_mps2=0.2, lead_m=lead), []
    for step, now in enumerate(seen):
        entered = np.arange(N) % 4 == step % 5
        if step == 25:
            kept = {name: values.copy() for name, values in hover.memory().items()}
            kept["speed"][2] = np.nan  # begins anew
            hover.recall(kept)
        found = hover.command(goal, now, entered)
        here = np.column_stack([now.xy, now.depth])
        if not step:
            points = [Point(here[k], now.own.heading[k], 0.2, lead) for k in range(N)]
        if step == 25:
            points[2] = Point(here[2], now.own.heading[2], 0.2, lead)
        names = ("x", "y", "z", "yaw", "x_speed", "y_speed", "z_speed", "drive")
        expected = [points[k].goes(lane_of(goal, k), here[k], bool(entered[k]), dt) for k in range(N)]
        apart = np.stack([found[name] for name in names], axis=1) - expected
        apart[:, 3] = wrapped(apart[:, 3])
        np.testing.assert_allclose(apart, 0.0, atol=1e-9)
        assert not found["roll"].any()
        assert not found["pitch"].any()


def test_a_craft_keeps_its_place_against_the_current_and_slows_down_where_it_stops(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where courses are given: 0.15 of the distance a second less the current, which is what its way over ground has
    beyond what it asked for; held while slow. On circles at most 0.1 rad/s, or twice the current.
    """
    goal, seen = scene(3, 0.5)
    goal.depth[:] = 0.0
    asked_of: list[Any] = []

    def course(goal: Goal, aboard: Aboard, lookahead: Any, *more: Any) -> Any:
        asked_of.append(np.array(lookahead))
        return goal.course

    monkeypatch.setattr(surface, "course_to", course)
    crab = SimpleNamespace(angle=np.zeros(N), see=lambda aboard, speed: np.full(N, 0.1))
    lead = SimpleNamespace(lag_s=np.zeros(N), turning=lambda wanted, *more: wanted)
    craft = Surface(8.0, 3.0, 1.5, crab, lead)  # type: ignore[arg-type]
    held, current, asked = seen[0].own.heading.copy(), np.zeros((N, 2)), np.zeros(N)
    for step, now in enumerate(seen):
        if step == 20:
            kept = {name: values.copy() for name, values in craft.memory().items()}
            kept["held"][5] = np.nan
            craft.recall(kept)
            held[5], current[5], asked[5] = now.own.heading[5], 0.0, 0.0
        found = craft.command(goal, now, np.zeros(N, dtype=bool))
        for k in range(N):
            it, bow = lane_of(goal, k), now.own.heading[k]
            forward = np.array([math.cos(bow), -math.sin(bow)])
            beyond = now.own.velocity[k, :2] - asked[k] * forward - current[k]
            current[k] += (1 - math.exp(-0.5 / 10.0)) * beyond
            to = it.end - now.xy[k]
            far = float(np.hypot(*to))
            speed, heading = it.speed, it.course - (0.1 if it.path in (Path.LINE, Path.CIRCLE) else 0.0)
            if it.path == Path.LINE and it.stops:
                speed = min(speed, max(0.15 * far, 0.2))
            if it.path == Path.DRIFT:
                speed = 0.0
            if it.path == Path.CIRCLE:
                speed = min(speed, max(0.1 * max(it.radius, far), 2 * float(np.hypot(*current[k]))))
            past = it.stops and it.path == Path.LINE and (it.end - it.start) @ to <= 0
            if past or it.path in (Path.POINT, Path.OVER):
                fastest = it.speed if it.speed > 0 else 1.5
                way = min(0.15, fastest / far) * to - current[k]
                fast, bearing = float(np.hypot(*way)), math.atan2(-way[1], way[0])
                held[k] = bearing if fast > 0.08 else held[k]
                along = fast * math.cos(bearing - bow)
                heading, speed = held[k], min(max(along, 0.0 if fast > 0.08 else -fastest), fastest)
            asked[k] = speed
            assert wrapped(found["heading"][k] - heading) == pytest.approx(0.0, abs=1e-9)
            assert found["speed"][k] == pytest.approx(speed, abs=1e-9)
    np.testing.assert_allclose(asked_of[0], 8.0 * np.clip(goal.speed / 1.5, 0.25, 1.0))
