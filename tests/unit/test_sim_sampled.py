"""Readings of a block, cut by agent, copy and tick: rows go tick by tick, agent by agent, and copy by copy."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.sensors.sensor import Measurement
from pelagos.sim.heard import heard_of, part_of, side_by_side
from pelagos.sim.sampled import Sampled, newest

TICKS, MEMBERS, N, DT_NS = range(6, 18, 4), ("a", "b", "c", "d"), 3, 5_000_000
SHAPE = (len(TICKS), len(MEMBERS), N)
NUMBERS = np.arange(2.0 * np.prod(SHAPE)).reshape(*SHAPE, 2)
MODEL: Any = SimpleNamespace(name="s", period=4, config=SimpleNamespace(type="kind"))
VALID = np.random.default_rng(6).random(SHAPE) < 0.6
VALID[2, 1], VALID[1, 1], VALID[:, 3] = False, [False, True, False], False


def flat(values: Any) -> Any:
    return values.reshape(-1, *values.shape[3:])


def sampled(valid: Any = VALID, ticks: range = TICKS, numbers: Any = NUMBERS) -> Sampled:
    m = Measurement(flat(numbers), flat(-numbers), None if valid is None else flat(valid), {"x": flat(numbers[..., 0])},
                    tables={"t": np.array([7.0])})  # fmt: skip
    return Sampled(MEMBERS, MODEL, ticks, m)


def compare(found: Sampled, members: list[int], valid: Any = VALID) -> None:
    m = found.measurement
    assert found.members == tuple(MEMBERS[i] for i in members)
    np.testing.assert_array_equal(m.data, flat(NUMBERS[:, members]))
    np.testing.assert_array_equal(m.truth, flat(-NUMBERS[:, members]))
    np.testing.assert_array_equal(m.extras["x"], flat(NUMBERS[:, members][..., 0]))
    np.testing.assert_array_equal(m.valid, flat(valid[:, members]))


def test_parts_are_those_of_their_agents() -> None:
    whole = sampled()
    for member, one in enumerate(whole.each(N)):
        compare(one, [member])
    compare(whole.of(2, N), [2])
    compare(whole.some([1, 3, 2], N), [1, 3, 2])
    assert whole.of(1, N).of(0, N).members == ("b",)
    assert sampled(None).of(1, N).measurement.valid is None


def test_counts_are_of_ticks_at_which_a_copy_has_a_reading() -> None:
    assert sampled().counts(N) == VALID.any(axis=2).sum(axis=0).tolist()
    assert sampled().counts(N)[3] == 0
    assert sampled(None).counts(N) == [3] * 4


def test_blocks_that_follow_one_another_are_one() -> None:
    first, parts = sampled(), [sampled(VALID[:1], TICKS[:1], NUMBERS[:1]), sampled(VALID[1:], TICKS[1:], NUMBERS[1:])]
    assert Sampled.join([first]) is first
    found = Sampled.join(parts)
    compare(found, [0, 1, 2, 3])
    assert list(found.ticks) == list(TICKS)


def test_a_copy_that_has_ended_is_not_valid_in_any_agent_from_then_on() -> None:
    ended = np.array([10**9, 10, 7])
    found = sampled().without(ended).measurement.valid
    alone = sampled(None).without(ended).measurement.valid
    goes_on = np.broadcast_to((np.array(TICKS)[:, None] < ended)[:, None], SHAPE)
    assert found is not None
    assert alone is not None
    np.testing.assert_array_equal(found.reshape(SHAPE), VALID & goes_on)
    np.testing.assert_array_equal(alone.reshape(SHAPE), goes_on)


def test_the_newest_reading_of_an_agent_is_of_the_last_tick_at_which_a_copy_has_one() -> None:
    one = sampled().of(1, N).newest(N, DT_NS)
    assert one is not None
    assert one.t_ns == TICKS[1] * DT_NS
    assert one.valid.tolist() == [False, True, False]
    np.testing.assert_array_equal(one.data, NUMBERS[1, 1])
    assert (one.frame, one.kind) == ("b/s", "kind")
    assert sampled().of(3, N).newest(N, DT_NS) is None
    every = list(sampled().of(1, N).readings(N, DT_NS, invalid=True))
    assert [r.t_ns for r in every] == [t * DT_NS for t in TICKS]
    heard = list(sampled().of(1, N).readings(N, DT_NS))
    assert [r.t_ns for r in heard] == [t * DT_NS for t, v in zip(TICKS, VALID[:, 1], strict=True) if v.any()]


@pytest.mark.parametrize("block", [slice(0, 4), slice(1, 2), slice(1, 4)])
def test_a_group_has_the_readings_of_the_last_tick_of_any_of_its_members(block: slice) -> None:
    found = sampled().newest_of(block, N, DT_NS, "g")
    assert found is not None
    last = np.flatnonzero(VALID[:, block].any(axis=(1, 2)))[-1]
    heard = VALID[last, block].any(axis=1)
    assert found.t_ns == TICKS[last] * DT_NS
    np.testing.assert_array_equal(found.valid, VALID[last, block].T)
    expected = NUMBERS[last, block] * heard[:, None, None]
    np.testing.assert_array_equal(found.data, expected.swapaxes(0, 1))
    np.testing.assert_array_equal(found.truth, -expected.swapaxes(0, 1))
    np.testing.assert_array_equal(found.extras["x"], expected[..., 0].T)
    assert found.extras["t"].tolist() == [7.0]
    assert found.frame == "g/s"
    assert sampled().newest_of(slice(3, 4), N, DT_NS, "g") is None


def test_of_many_blocks_those_are_kept_that_hold_the_newest_reading_of_an_agent() -> None:
    def block(*who: int) -> Sampled:
        valid = np.zeros((1, 4, N), dtype=bool)
        valid[0, list(who), 1] = True
        return sampled(valid, range(6, 7), NUMBERS[:1])

    parts = [block(3), block(0, 1), block(0), block(), block(1, 2)]
    found = newest(parts, N)
    assert [k for k, one in enumerate(parts) if any(one is other for other in found)] == [0, 2, 4]
    assert [one is other for one, other in zip(found, (parts[0], parts[2], parts[4]), strict=True)] == [True] * 3


def test_what_several_estimators_hear_is_side_by_side_and_comes_apart_again() -> None:
    """Lanes of the agents follow one another at every tick; those of one are as it would hear them alone."""
    heard = [heard_of(sampled().of(i, N), "depth") for i in range(4)]
    whole = side_by_side(heard)
    np.testing.assert_array_equal(whole["data"], NUMBERS.reshape(-1, 2))
    np.testing.assert_array_equal(whole["valid"], VALID.ravel())
    assert whole["ticks"] == list(TICKS)
    assert whole["extra"] is None
    for i, one in enumerate(heard):
        part = part_of(whole, slice(i * N, (i + 1) * N))
        for key in ("data", "valid"):
            np.testing.assert_array_equal(part[key], one[key])
    place, sigma = -NUMBERS[:, 1].reshape(-1, 2), NUMBERS[:, 1].reshape(-1, 2) + 0.5
    m = Measurement(flat(NUMBERS[:, 1:2]), flat(NUMBERS[:, 1:2]), None, {"position": place, "fix": place + 1,
                    "sigma": sigma})  # fmt: skip
    of = {kind: heard_of(Sampled(("b",), MODEL, TICKS, m), kind) for kind in ("gps", "usbl", "dvl")}
    np.testing.assert_array_equal(of["gps"]["data"], place)
    np.testing.assert_array_equal(of["usbl"]["data"], place + 1)
    np.testing.assert_array_equal(of["dvl"]["data"], NUMBERS[:, 1].reshape(-1, 2))
    np.testing.assert_array_equal(of["dvl"]["extra"], sigma)
    assert of["gps"]["valid"].all()
