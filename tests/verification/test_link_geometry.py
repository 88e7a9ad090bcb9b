"""Signals between ends that move, first paths of transponders, and bottoms behind edges: made-up straight rays."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from modem_ports import modem_port
from numpy.typing import NDArray

import pelagos as pl
from pelagos.acoustics.eigenrays import Arrivals
from pelagos.sensors.comms.link.medium import ModemPose, SharedMedium, _holds, _Link
from pelagos.sensors.comms.link.transponders import TransponderConfig, Transponders
from pelagos.sensors.comms.link.water_paths import Paths, _continued, _straight

C = 1500.0


def straight_paths(source: NDArray[Any], receiver: NDArray[Any], *, blocked: Any = False) -> Paths:
    """One direct ray a pair, and one 3 % longer and 6 dB weaker, in water of one speed."""
    way = receiver - source
    distance = np.linalg.norm(way, axis=1)
    unit, m = way / distance[:, None], len(way)
    path = np.repeat(np.arange(m), 2)
    longer = np.tile([1.0, 1.03], m)
    none = np.zeros(2 * m, np.int64)
    arrivals = Arrivals(
        path, distance[path] * longer / C, np.tile([1.0, 0.5], m) / distance[path] + 0j, 0.0 * longer, 0.0 * longer,
        none, none, none, distance[path], 0.0 * longer,
    )  # fmt: skip
    return Paths(arrivals, unit[path], unit[path], np.broadcast_to(blocked, (2 * m,)), np.full((m, 2), C))


class Tracer:
    """Straight rays; what was asked for."""

    def __init__(self) -> None:
        self.asked: list[tuple[Any, ...]] = []

    def trace(self, source: Any, receiver: Any, t: float, copy: Any, own: Any) -> Paths:
        """See `WaterPaths`."""
        self.asked.append((len(source), t, copy.tolist(), own.tolist()))
        return straight_paths(source, receiver)


def water(**frequencies: float) -> Any:
    """A medium of modems in two copies, whose own hulls are rows 10, 11 of the first, 20, 21 of the second."""
    ports = {f"{name}.m": modem_port(f"{name}.m", frequency_hz=f) for name, f in frequencies.items()}
    made = SharedMedium(modems=ports, _context=SimpleNamespace(scene=SimpleNamespace(moving=None)))
    made._own_rows = {f"{n}.m": np.array([10, 11], np.uint32) * (k + 1) for k, n in enumerate(frequencies)}
    made._tracers = {f: Tracer() for f in frequencies.values()}  # type: ignore[misc]
    return made


def poses(*ends: tuple[Any, Any]) -> dict[int, ModemPose]:
    turned = np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))
    return {k: ModemPose(np.array(p, float), turned, np.array(v, float)) for k, (p, v) in enumerate(ends)}


FAST = poses(
    ([[0, 0, -20], [40, -30, -25]], [[3.0, -1.0, 0.5], [-2.0, 2.5, -0.4]]),
    ([[300, 120, -40], [-250, 90, -30]], [[-4.0, 2.0, 0.3], [1.5, 3.5, -0.2]]),
)


@pytest.mark.parametrize("copy", [0, 1])
@pytest.mark.parametrize("lag", [0.0, 0.4])
def test_sound_meets_a_receiver_where_it_has_gone_to(copy: int, lag: float) -> None:
    """Sent where the sender was `lag` ago; heard after tau, when |p_b(tau) - p_a| = c tau; to second order of v/c:
    (5/1500)^2 of 0.2 s are 2 us. Frequency by both speeds along the way: 1 - dtau/dt, to second order too."""
    medium = water(a=25e3, b=25e3)
    (signal,) = medium.hear([(0, 1, copy)], FAST, 7.0, {}, [lag])
    (pa, va), (pb, vb) = ((FAST[k].position[copy], FAST[k].velocity[copy]) for k in (0, 1))

    def delay(sent: float) -> float:
        tau = 0.0
        for _ in range(60):
            tau = float(np.linalg.norm(pb + vb * (sent + tau) - pa - va * sent)) / C
        return tau

    assert signal.delay_s == pytest.approx(delay(-lag), abs=3e-6)
    stretch = 1.0 + (delay(-lag + 1e-3) - delay(-lag)) / 1e-3
    assert signal.doppler == pytest.approx(1.0 / stretch, abs=3e-5)
    assert abs(1.0 / stretch - 1.0) > 3e-4
    assert signal.level_db == pytest.approx(180.0 + 20 * math.log10(1.25**0.5 / np.linalg.norm(pb - pa)), abs=0.3)


def test_links_are_traced_by_frequency_with_the_senders_hull_and_again_when_they_are_old() -> None:
    """Two senders of different frequencies and copies; the same again is not traced, nor after a small motion; it is
    after a long one, after a minute, and in other water."""
    medium = water(a=25e3, b=9e3, c=25e3)
    still = [(p.position, 0 * p.velocity) for p in FAST.values()]
    ends = poses(*still, ([[50, 60, -5], [70, -80, -9]], np.zeros((2, 3))))
    cache: dict[Any, Any] = {}
    pairs = [(0, 2, 1), (1, 0, 0), (2, 1, 1)]
    high, low = medium._tracers[25e3], medium._tracers[9e3]
    found = medium.hear(pairs, ends, 5.0, cache, [0.0] * 3)
    ways = [np.linalg.norm(ends[b].position[c] - ends[a].position[c]) for a, b, c in pairs]
    assert [s.delay_s for s in found] == pytest.approx(np.array(ways) / C)
    assert high.asked == [(2, 5.0, [1, 1], [11, 33])]
    assert low.asked == [(1, 5.0, [0], [20])]
    before = [cache[p].ends[0].copy() for p in pairs]
    for pair, (source, receiver) in zip(pairs, before, strict=True):
        assert source == pytest.approx(ends[pair[0]].position[pair[2]])
        assert receiver == pytest.approx(ends[pair[1]].position[pair[2]])
    medium.hear(pairs, ends, 64.9, cache, [0.0] * 3)
    assert (len(high.asked), len(low.asked)) == (1, 1)
    medium.hear(pairs[1:2], ends, 65.1, cache, [0.0])
    assert (len(high.asked), len(low.asked)) == (1, 2)
    medium.waters += 1
    medium.hear(pairs[:1], ends, 30.0, cache, [0.0])
    assert (len(high.asked), len(low.asked)) == (2, 2)


@pytest.mark.parametrize(
    ("t", "shift", "way", "crowded", "holds"),
    [(9.9, 0.0, 100.0, False, False), (10.0, 0.0, 100.0, False, True), (70.0, 0.0, 100.0, False, True),
     (70.1, 0.0, 100.0, False, False), (12.0, 0.0, 100.0, True, True), (12.1, 0.0, 100.0, True, False),
     (11.0, 1.95, 100.0, True, True), (11.0, 2.05, 100.0, True, False), (11.0, 0.24, 5.0, False, True),
     (11.0, 0.26, 5.0, False, False)],
)  # fmt: skip
@pytest.mark.parametrize("end", [0, 1])
def test_a_link_holds_for_a_while_and_for_small_motions(
    t: float, shift: float, way: float, crowded: bool, holds: bool, end: int
) -> None:
    """60 s, or 2 s where something may stand in; 2 % of the distance, or 25 cm, of either end."""
    before = np.array([[[1.0, 2.0, -3.0], [1.0, 2.0 - way, -3.0]]])
    now = before[0].copy()
    now[end, 2] += shift
    link = _Link(straight_paths(before[:, 0], before[:, 1]), before, 10.0, 0)
    assert _holds(link, now, t, crowded) == holds
    assert not _holds(None, now, t, crowded)


def test_a_modem_is_found_by_path_agent_or_address() -> None:
    ports = [modem_port("b.x", address=3), modem_port("b.y", address=0), modem_port("c.z", address=7)]
    medium = SharedMedium(modems={p.path: p for p in ports})
    assert [medium.find(name) for name in ("b.y", "c", "3", "7", "0")] == ["b.y", "c.z", "b.x", "c.z", "b.y"]
    with pytest.raises(pl.LookupFailed, match=r"^here: unknown modem 'b'"):
        medium.find("b", where="here")


def test_names_that_modems_send_to_by_themselves_are_looked_up() -> None:
    """Those of beacons where there are any, and all that are asked for their range."""
    good = modem_port("a.m", beacon_s=2.0, beacon_to="b", interrogate=("b.m", "b"))
    other = modem_port("b.m", address=1, beacon_to="nobody")  # without beacons
    for changed, where in ((good, ""), (replace(good, beacon_to="q"), "beacon_to"),
                           (replace(good, interrogate=("b", "q")), "interrogate")):  # fmt: skip
        medium = SharedMedium(modems={"a.m": changed, "b.m": other})
        if where:
            with pytest.raises(pl.LookupFailed, match=rf"agents\.a\.sensors\.m\.{where}: unknown modem 'q'"):
                medium.check_names()
        else:
            medium.check_names()


class Moored:
    """Straight rays from an instrument, of which those are blocked that are asked for; with what it was asked."""

    def __init__(self, blocked: Any = False) -> None:
        self.blocked, self.asked = blocked, []

    def trace(self, source: Any, receiver: Any, t: float, copy: Any, own: Any) -> Paths:
        """See `WaterPaths`; the speed of sound at the instrument is told by its depth."""
        self.asked.append((t, copy.tolist(), own.tolist()))
        found = straight_paths(source, receiver, blocked=np.resize(self.blocked, 2 * len(source)))
        return replace(found, speed=np.stack([1400.0 - source[:, 2], 1600.0 + source[:, 2]], axis=-1))


def transponders() -> Transponders:
    """Two that are moored, and between them one that a ship carries: in three copies it is elsewhere."""
    there = ModemPose(np.array([[50.0, 1, -2], [60.0, 2, -3], [70.0, 3, -4]]), np.zeros((3, 4)), np.zeros((3, 3)))
    medium = SimpleNamespace(agents=("ship", "own"), pose_of=lambda agent, mount: there)
    world = SimpleNamespace(height=lambda x, y: np.array([-90.0]))
    context: Any = SimpleNamespace(
        medium=medium, world=world, path="own.lbl", own_body=np.array([30, 31, 32], np.uint32)
    )
    configs = {"p": TransponderConfig(position_m=(100, -200, -50)),
               "s": TransponderConfig(position_m=(1, 2, 3), agent="ship"),
               "q": TransponderConfig(position_m=(-300, 40, -60))}  # fmt: skip
    return Transponders(configs, context, key="transponders")


def test_transponders_are_heard_by_each_lane_at_its_own_time_and_copy() -> None:
    """Four lanes of two moments: times, losses, directions and places of each by hand, the row of its own hull."""
    position = np.array([[0.0, 0, -10], [5.0, 6, -12], [-7.0, 8, -14], [9.0, -3, -16]])
    t, copy = np.array([3.0, 8.0, 3.0, 8.0]), np.array([2, 0, 1, 2])
    paths: Any = Moored()
    found = transponders().listen(paths, position, t, copy)
    moored = np.array([[100.0, -200, -50], [0, 0, 0], [-300, 40, -60]])
    places = np.repeat(moored[None], 4, axis=0)
    places[:, 1] = np.array([[50.0, 1, -2], [60.0, 2, -3], [70.0, 3, -4]])[copy]
    np.testing.assert_allclose(found.places, places)
    way = places - position[:, None]
    distance = np.linalg.norm(way, axis=-1)
    np.testing.assert_allclose(found.time, distance / C)
    np.testing.assert_allclose(found.loss_db, 20 * np.log10(distance))
    np.testing.assert_allclose(found.direction, way / distance[..., None])
    np.testing.assert_allclose(found.speed, np.repeat(1400.0 - position[:, 2:], 3, axis=1))
    assert paths.asked == [(3.0, [2] * 3 + [1] * 3, [32] * 3 + [31] * 3), (8.0, [0] * 3 + [2] * 3, [30] * 3 + [32] * 3)]
    np.testing.assert_allclose(transponders().fixed, np.where(np.arange(3)[:, None] == 1, np.nan, moored))


def test_the_first_path_that_is_not_blocked_counts_and_none_where_all_are() -> None:
    """Of each pair a direct ray and an echo of 3 % more: both free, the direct one blocked, both blocked."""
    paths: Any = Moored([False, False, True, False, True, True])
    found = transponders().listen(paths, np.array([[0.0, 0, -10]]), np.array([3.0]), np.array([0]))
    distance = np.linalg.norm(found.places[0] - [0, 0, -10], axis=-1)
    np.testing.assert_allclose(found.time[0], distance / C * [1.0, 1.03, np.nan])
    np.testing.assert_allclose(found.loss_db[0], 20 * np.log10(distance * [1.0, 2.0, np.nan]))
    assert np.isnan(found.direction[0]).all(axis=1).tolist() == [False, False, True]


def test_bottoms_go_on_behind_the_edge_as_the_nearest_node_that_met_ground() -> None:
    """Rows: ground in the middle, at the end, everywhere, nowhere; of two as near the first."""
    depth, material = np.arange(20.0).reshape(4, 5) ** 2, np.arange(20).reshape(4, 5) % 7
    met = np.array([[0, 1, 0, 1, 0], [0, 0, 0, 0, 1], [1, 1, 1, 1, 1], [0, 0, 0, 0, 0]], bool)
    nearest = np.array([[1, 1, 1, 3, 3], [4, 4, 4, 4, 4], [0, 1, 2, 3, 4], [0, 1, 2, 3, 4]])
    found = _continued(depth, material, met)
    np.testing.assert_array_equal(found[0], np.take_along_axis(depth, nearest, axis=1))
    np.testing.assert_array_equal(found[1], np.take_along_axis(material, nearest, axis=1))


def test_a_bottom_is_straight_within_a_millimetre_of_one_material() -> None:
    line = np.linspace(20.0, 35.0, 33)
    bent, rock = np.tile(line, (5, 1)), np.full((5, 33), 2)
    bent[1, 17] += 9e-4
    bent[2, 17] -= 1.1e-3
    bent[3, 4] += 1.1e-3
    rock[4, 30] = 3
    assert _straight(bent, rock).tolist() == [True, True, False, False, False]
