"""What commands ask of the parts that do their work: fits, runs and runs that go on, copies of recordings, views."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.cli import fit, run, view
from pelagos.cli.replay import ReplayOptions, replay
from pelagos.cli.run import Options
from pelagos.cli.segments import Plan
from pelagos.errors import InputError


class Enough(Exception):
    """What is asked has been seen."""


@pytest.mark.parametrize(
    ("data", "agent", "folder", "written"),
    [("run.csv.gz", "b", None, Path("results/fit-run")), ("it.mcap", "a", Path("out"), Path("out"))],
)
def test_a_fit_is_of_the_agent_that_is_named_and_goes_where_it_is_told(
    data: str, agent: str, folder: Path | None, written: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:  # fmt: skip
    asked: dict[str, Any] = {}
    vehicles = {name: SimpleNamespace(type=f"boat {name}") for name in "ab"}
    scenario = SimpleNamespace(members={name: SimpleNamespace(vehicle=v) for name, v in vehicles.items()})
    plan = SimpleNamespace(segment_s=12.5)
    estimate = SimpleNamespace(
        parameter=SimpleNamespace(name="mass", prior=2.25), value=3.5, low=3.25, high=4.125, said="well"
    )
    made = SimpleNamespace(
        estimates=[estimate], certainty=SimpleNamespace(alike=[("p", "q", -0.9876)]),
        train=SimpleNamespace(r2={"u": 0.91, "r": 0.82}), test=None if folder else SimpleNamespace(r2={"u": 0.73}),
    )  # fmt: skip

    def kept(name: str, answer: Any) -> Any:
        return lambda *args, **keys: asked.update({name: (args, keys)}) or answer

    monkeypatch.setattr(fit, "load_scenario", kept("scenario", scenario))
    monkeypatch.setattr("pelagos.identification.load_plan", kept("plan", plan))
    monkeypatch.setattr("pelagos.identification.read_record", kept("record", "a record"))
    monkeypatch.setattr("pelagos.identification.fit", kept("fit", made))
    monkeypatch.setattr("pelagos.identification.output.write_fit", kept("write", [Path("x/a.yaml"), Path("x/b.html")]))
    monkeypatch.setattr("pelagos.vehicles.vehicle.Vehicle", lambda v: SimpleNamespace(actuator_names=(v.type, "other")))
    path, source = Path("a.yaml"), Path(data)
    fit.fit_vehicle(path, source, ["x=1"], plan=Path("p.yaml"), agent=agent, folder=folder, trust=True)
    vehicle, title = vehicles[agent], f"boat {agent}: {data}"
    tell = asked["fit"][1].pop("tell")
    assert callable(tell)
    assert asked == {
        "scenario": ((path,), {"changes": ["x=1"], "trust": True}),
        "plan": ((Path("p.yaml"),), {"recording": source if data == "it.mcap" else None, "agent": agent}),
        "record": ((source, plan, (vehicle.type, "other")), {}),
        "fit": ((vehicle, "a record", plan), {"scenario": scenario}),
        "write": ((made, written), {"data": data, "title": title}),
    }
    told = " ".join(capsys.readouterr().out.split())
    assert "mass 2.25 3.5 3.25 .. 4.125 well" in told
    assert "p and q (correlation -0.988)" in told
    assert "open loop 12.5 s, fitted part, R2: u 0.910, r 0.820" in told
    assert ("unseen part, R2: u 0.730" in told) == (folder is None)
    assert told.endswith(f"wrote a.yaml, b.html in {written}")


@pytest.mark.parametrize(("given", "limit"), [("8G", 8e9), (None, None)])
def test_copies_are_weighed_before_they_are_built(
    given: str | None, limit: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    monkeypatch.setattr("pelagos.sim.cost.check_memory", lambda *args, **keys: asked.append((args, keys)))
    monkeypatch.setattr(
        "pelagos.sim.simulation.Simulation.load", lambda *args, **keys: asked.append((args, keys)) or "sim"
    )
    assert run._load("scenario", 3, given) == "sim"  # type: ignore[arg-type]
    ((weighed, keys), built) = asked
    assert (weighed, keys["block_s"] > 0) == (("scenario", 3, limit), True)
    assert built == (("scenario",), {"n": 3, "memory_limit": limit})


def test_a_run_has_the_seed_and_the_length_that_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def load(path: Path, changes: Any, **keys: Any) -> None:
        asked.append((path, changes, keys))
        raise Enough

    monkeypatch.setattr(run, "load", load)
    for options, told in (
        (Options(duration_s=6.5, seed=0, trust=True), {"seed": 0, "duration_s": 6.5}),
        (Options(seed=7), {"seed": 7}), (Options(), {}),
    ):  # fmt: skip
        with pytest.raises(Enough):
            run.run_scenario(Path("a.yaml"), ["x=1"], options)
        assert asked.pop() == (Path("a.yaml"), ["x=1"], {"overrides": told, "trust": options.trust})
    for options, text in (
        (Options(seed=-1), "--seed must be a whole number from 0 on, not -1"), (Options(seed=2**63), "--seed must be"),
        (Options(duration_s=0.0), "--duration must be a positive number of seconds, not 0"),
        (Options(duration_s=float("inf")), "--duration must be"),
        (Options(max_wall_s=0.0), "--max-wall must be a positive number of seconds, not 0"),
        (Options(checkpoint_every_s=-1.5), "--checkpoint-every must be a positive number of seconds, not -1.5"),
        (Options(browser=False), "--no-browser is about the page of --view"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=text):
            run.run_scenario(Path("a.yaml"), [], options)
    assert not asked


@pytest.mark.parametrize(("every_s", "expected"), [(None, 2.5), (0.75, 0.75)])
def test_a_run_goes_on_with_the_copies_and_the_plan_that_it_had(
    every_s: float | None, expected: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: dict[str, Any] = {}
    Plan(60.0, True, 2.5, "tapes/it.mcap", realtime=True).save(tmp_path)
    kept = SimpleNamespace(n=3, time_ns=5_000_000_000)
    sim = SimpleNamespace(restore=lambda checkpoint: asked.update(restored=checkpoint), stop=lambda: None)
    monkeypatch.setattr("pelagos.sim.resume.last_checkpoint", lambda folder: kept)
    monkeypatch.setattr(run, "load", lambda path, trust: asked.update(read=(path, trust)) or "scenario")
    monkeypatch.setattr(run, "_load", lambda *args: asked.update(built=args) or sim)

    def resumed(recording: Path, sim: Any) -> Any:
        asked.update(recording=recording)
        raise Enough

    monkeypatch.setattr("pelagos.sim.resume.resumed_recorder", resumed)
    plans: list[Plan] = []
    monkeypatch.setattr(run, "replace", lambda plan, **keys: plans.append(keys) or plan)
    options = Options(resume=tmp_path, trust=True, memory_limit="8G", checkpoint_every_s=every_s)
    with pytest.raises(Enough):
        run.run_scenario(None, [], options)
    assert asked == {
        "read": (tmp_path / "scenario.yaml", True), "built": ("scenario", 3, "8G"), "restored": kept,
        "recording": tmp_path / "tapes/it.mcap",
    }  # fmt: skip
    assert plans == ([] if every_s is None else [{"every_s": expected}])


def test_a_copy_of_a_recording_is_of_the_part_that_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[Any] = []
    monkeypatch.setattr("pelagos.bridges.rosbag.write_rosbag", lambda *args, **keys: asked.append((args, keys)) or 41)
    replay(Path("it.mcap"), ReplayOptions(rosbag=Path("bag"), start_s=1.5, end_s=4.5, topics=("/a", "/b")))
    part = {"start_s": 1.5, "end_s": 4.5, "only": ("/a", "/b")}
    assert asked == [((Path("it.mcap"), Path("bag")), part)]
    assert capsys.readouterr().out.split() == ["41", "messages", "written", "to", "bag"]


def test_a_view_is_served_where_it_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "a.yaml"
    file.touch()
    asked: list[Any] = []

    class Server:
        def __init__(self, **keys: Any) -> None:
            asked.append(keys)

        def close(self) -> None:
            asked.append("closed")

    monkeypatch.setattr("pelagos.viewer.server.Server", Server)
    monkeypatch.setattr(view, "_show", lambda path, changes, options, server: asked.append((path, changes)) or 7)
    assert view.show(file, ["x=1"], view.ViewOptions(host="h", port=77)) == 7
    assert asked == [{"host": "h", "port": 77}, (file, ["x=1"]), "closed"]
