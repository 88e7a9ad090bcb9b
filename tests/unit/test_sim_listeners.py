"""Callbacks, recordings around a step loop, and runs that are held, fed and ended from outside."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest

import pelagos as pl

SCENARIO: dict[str, Any] = {
    "seed": 5,
    "world": {"type": "flat", "depth_m": 20.0},
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0.0, 0.0], "depth_m": 5.0, "speed_mps": 1.0},
            "control": "depth_heading",
            "command": [6.0, 0.4, 900.0],
            "sensors": {
                "imu": {"type": "imu", "rate_hz": 50},
                "dvl": {"type": "dvl", "rate_hz": 10},
                "sonar": {"type": "imaging_sonar", "rate_hz": 5, "beams": 16, "bins": 32},
            },
        }
    },
}


@pytest.fixture(scope="module")
def loaded() -> pl.Simulation:
    return pl.Simulation.load(SCENARIO)


@pytest.fixture
def sim(loaded: pl.Simulation) -> pl.Simulation:
    loaded.reset()
    return loaded


def stepped(sim: pl.Simulation, ticks: int) -> None:
    for _ in range(ticks):
        sim.step()


def test_step_and_run_call_back_at_the_same_ticks(sim):
    """At tick 0 and every period after; 30 Hz in ticks of 5 ms is every seventh."""
    found: list[list[int]] = []
    for go in (lambda: stepped(sim, 40), lambda: sim.run(0.2), lambda: sim.step(ticks=40)):
        sim.reset()
        ticks: list[int] = []
        with sim.on_tick(lambda s, ticks=ticks: ticks.append(s.time_ns // s.dt_ns), rate_hz=30.0):
            go()
        found.append(ticks)
    assert found == [[0, 7, 14, 21, 28, 35]] * 3
    every: list[int] = []
    with sim.on_tick(lambda s: every.append(s.time_ns)):
        sim.run(0.05)
    assert len(every) == 10  # from where it stood: its own tick was told before


def test_subscribers_get_the_bytes_that_steps_return(sim):
    """Every reading once, tick 0 included, at its own time; by step, by run, and by steps of several ticks."""
    wanted: dict[str, list[bytes]] = {"dvl": [], "sonar": [], "imu": []}
    obs = sim.reset()
    for _ in range(81):
        for name, reading in obs["auv0"].items():
            wanted[name].append(reading.t_ns.to_bytes(8, "little") + reading.data.tobytes() + reading.truth.tobytes())
        obs = sim.step()
    end = None
    for go in (lambda: stepped(sim, 80), lambda: sim.run(0.4), lambda: [sim.step(ticks=16) for _ in range(5)]):
        sim.reset()
        got: dict[str, list[bytes]] = {name: [] for name in wanted}

        def keep(name: str, got: dict[str, list[bytes]] = got) -> Any:
            return lambda r: got[name].append(r.t_ns.to_bytes(8, "little") + r.data.tobytes() + r.truth.tobytes())

        handles = [sim.subscribe(f"auv0.{name}", keep(name)) for name in wanted]
        late: list[int] = []
        handles.append(sim.subscribe("auv0.dvl", lambda r, late=late: late.append(sim.time_ns - r.t_ns)))
        go()
        for handle in handles:
            handle.cancel()
        assert got == wanted
        assert len(late) == 5
        assert not any(late)
        end = end or sim.state["auv0"].position.tobytes()
        assert sim.state["auv0"].position.tobytes() == end


def test_readings_come_before_ticks_and_in_the_order_of_the_scenario(sim):
    order: list[str] = []
    handles = [sim.on_tick(lambda s: order.append("tick a"), rate_hz=5.0)]
    handles += [
        sim.subscribe(f"auv0.{name}", lambda r, name=name: order.append(name)) for name in ("sonar", "dvl", "imu")
    ]
    handles.append(sim.on_tick(lambda s: order.append("tick b"), rate_hz=5.0))
    sim.step()
    assert order == ["imu", "dvl", "sonar", "tick a", "tick b"]
    for handle in handles:
        handle.cancel()
        handle.cancel()
    assert not any(handle.active for handle in handles)
    assert not sim.listeners.any


def test_a_callback_may_cancel_another_and_what_it_raises_names_it(sim):
    called: list[str] = []
    second = sim.on_tick(lambda s: called.append("second"))
    second.cancel()

    def first(s: pl.Simulation) -> None:
        third.cancel()

    with sim.on_tick(first):
        third = sim.on_tick(lambda s: called.append("third"))
        sim.step()
    assert not called

    def broken(reading: pl.Reading) -> None:
        raise ValueError("no such colour")

    with sim.subscribe("auv0.dvl", broken), pytest.raises(ValueError, match="no such colour") as caught:
        sim.run(1.0)
    assert "broken" in caught.value.__notes__[0]
    assert "subscribe('auv0.dvl')" in caught.value.__notes__[0]
    assert "t = 0.100 s" in caught.value.__notes__[0]
    sim.run(0.1)  # it goes on from there


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_bad_callbacks_are_refused(sim, rate):
    with pytest.raises(pl.CommandError, match="rate_hz"):
        sim.on_tick(print, rate_hz=rate)
    with pytest.raises(pl.LookupFailed, match=r"did you mean 'auv0\.sonar'"):
        sim.subscribe("auv0.sona", print)


@pytest.mark.parametrize("verb", ["step", "run", "reset"])
def test_nobody_steps_within_a_step(sim, verb, tmp_path):
    with sim.on_tick(lambda s: getattr(s, verb)()), pytest.raises(pl.CommandError, match=f"sim.{verb} was called"):
        sim.step()
    with pytest.raises(pl.CommandError, match="turns time back"), sim.recording(tmp_path / "run.mcap"):
        sim.reset()


def messages(path: Any) -> list[tuple[str, int, bytes]]:
    from mcap.reader import make_reader

    with open(path, "rb") as file:
        found = [(c.topic, m.log_time, m.data) for _, c, m in make_reader(file).iter_messages()]
    return sorted(found)


def test_a_recording_around_steps_is_that_of_a_run(sim, tmp_path):
    sim.run(0.6, record=tmp_path / "run.mcap")
    sim.reset()
    with sim.recording(tmp_path / "steps.mcap"):
        stepped(sim, 60)
        sim.step(ticks=20)
        result = sim.run(0.2)
    assert result.recording == tmp_path / "steps.mcap"
    wanted = messages(tmp_path / "run.mcap")
    assert len(wanted) > 60
    assert messages(tmp_path / "steps.mcap") == wanted
    sim.step()  # the recording is closed, and steps go on without


def test_commands_enter_at_boundaries_from_any_thread(sim):
    held = threading.Event()

    def control() -> None:
        held.wait(20.0)
        sim.command({"auv0": (9.0, 1.0, 700.0)})
        sim.post(lambda: seen.append((sim.paused, sim.time_ns)))
        sim.post(sim.resume)

    seen: list[tuple[bool, int]] = []
    ticks: list[int] = []

    def watch(s: pl.Simulation) -> None:
        ticks.append(s.time_ns)
        if len(ticks) == 3:
            s.pause()
            held.set()
        if len(ticks) == 6:
            s.stop()

    thread = threading.Thread(target=control)
    thread.start()
    with sim.on_tick(watch, rate_hz=20.0):
        result = sim.run(60.0)
    thread.join()
    assert result.ended == "stopped"
    assert result.simulated_s == pytest.approx(0.25)
    assert ticks == [50_000_000 * k for k in range(6)]
    assert seen == [(True, 100_000_000)]  # done while the run was held
    assert np.array_equal(sim.stepper.runs["auv0"].command_values, [[9.0, 1.0, 700.0]])


def test_another_thread_is_told_at_once_what_is_wrong(sim):
    errors: list[Exception] = []

    def wrong(s: pl.Simulation) -> None:
        def send() -> None:
            for bad in ({"auv0": (1.0,)}, {"auv1": (1.0, 2.0, 3.0)}):
                try:
                    s.command(bad)
                except pl.InputError as error:
                    errors.append(error)

        thread = threading.Thread(target=send)
        thread.start()
        thread.join()

    with sim.on_tick(wrong):
        sim.step()
    assert len(errors) == 4  # at tick 0 and tick 1


def test_watchers_hear_the_start_once_and_within_the_reset(sim):
    """By step and by run; who comes after the reset hears it with the first tick; bytes are those that it gives."""

    def keep(times: list[tuple[int, bytes]]) -> Any:
        return lambda block: times.extend((r.t_ns, r.data.tobytes()) for r in block.get("auv0.dvl", ()))

    every = [0, 100_000_000, 200_000_000]
    for go in (lambda: stepped(sim, 40), lambda: sim.run(0.2), lambda: sim.step(ticks=40)):
        first: list[tuple[int, bytes]] = []
        late: list[tuple[int, bytes]] = []
        with sim.watch(keep(first)):
            given = sim.reset(seed=6)["auv0"]["dvl"]
            assert first == [(0, given.data.tobytes())]
            with sim.watch(keep(late)):
                go()
            assert [t for t, _ in first] == every
            assert late == first
            sim.reset(seed=5)
        assert [t for t, _ in first] == [*every, 0]
        assert first[-1][1] != first[0][1]
    with sim.watch(lambda block: sim.reset()), pytest.raises(pl.CommandError, match="while the simulation steps"):
        sim.reset()
    sim.step()  # the gate is open again


def test_real_time_is_kept(sim):
    result = sim.run(0.3, realtime=2.0)
    assert result.wall_s >= 0.14
    with pytest.raises(pl.CommandError, match="realtime"):
        sim.run(0.1, realtime=-1.0)
