"""What each command hands on of its options, all given and none, and what films and playings make of theirs."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.main import get_command

from pelagos.cli.dataset import DatasetOptions
from pelagos.cli.learn import Lesson
from pelagos.cli.main import _program_apart, app
from pelagos.cli.replay import ReplayOptions, replay
from pelagos.cli.run import Options
from pelagos.cli.video import VideoOptions, video
from pelagos.cli.view import ViewOptions
from pelagos.datasets.engine import Engine
from pelagos.manoeuvres.orders import Orders
from pelagos.viewer.film import FilmOptions

A, B, OUT = Path("a.yaml"), Path("b.csv"), Path("out")
BOTH = "--set x=1 --set y=2 --trust"
COMMANDS: list[tuple[str, str, tuple[Any, ...], dict[str, Any]]] = [
    ("run a.yaml", "run.run_scenario", (A, [], Options()), {}),
    ("run", "run.run_scenario", (None, [], Options()), {}),
    (
        "run a.yaml --duration 6.5 --seed 7 --n 3 --out out --record r.mcap --realtime --no-report --max-wall 8.5 "
        "--checkpoint-every 2.5 --resume res --ros2 --bridge moos --bridge px4 --rosbag --repeat old.mcap --view "
        f"--no-browser --memory-limit 8G {BOTH}",
        "run.run_scenario",
        (A, ["x=1", "y=2"], Options(
            6.5, 7, 3, OUT, Path("r.mcap"), realtime=True, report=False, max_wall_s=8.5, checkpoint_every_s=2.5,
            resume=Path("res"), bridges=("ros2", "moos", "px4"), repeat=Path("old.mcap"), rosbag=True, trust=True,
            memory_limit="8G", view=True, browser=False,
        )), {},
    ),
    ("run a.yaml --bridge ros2", "run.run_scenario", (A, [], Options(bridges=("ros2",))), {}),
    ("check a.yaml", "check.check_scenario", (A, []), {"resolved": False, "trust": False, "build": True}),
    (f"check a.yaml --resolved --no-build {BOTH}", "check.check_scenario", (A, ["x=1", "y=2"]),
     {"resolved": True, "trust": True, "build": False}),
    (f"check a.yaml --cost --n 5 {BOTH}", "cost.show_cost", (A, ["x=1", "y=2"]), {"copies": 5, "trust": True}),
    ("check a.yaml --cost", "cost.show_cost", (A, []), {"copies": 1, "trust": False}),
    ("channel a.yaml u v", "channel.show_channel", (A, [], ("u", "v")),
     {"frequency_hz": 25e3, "at_s": 0.0, "out": None, "as_json": False, "trust": False}),
    (f"channel a.yaml u v --frequency 9e3 --at 2.5 --out out --json {BOTH}", "channel.show_channel",
     (A, ["x=1", "y=2"], ("u", "v")), {"frequency_hz": 9e3, "at_s": 2.5, "out": OUT, "as_json": True, "trust": True}),
    ("explain a.yaml u.v", "explain.explain_sensor", (A, [], "u.v"), {"at_s": 0.0, "trust": False}),
    (f"explain a.yaml u.v --at 2.5 {BOTH}", "explain.explain_sensor", (A, ["x=1", "y=2"], "u.v"),
     {"at_s": 2.5, "trust": True}),
    (f"fit a.yaml b.csv --plan p.yaml --agent u --out out {BOTH}", "fit.fit_vehicle", (A, B, ["x=1", "y=2"]),
     {"plan": Path("p.yaml"), "agent": "u", "folder": OUT, "trust": True}),
    ("fit a.yaml b.csv --plan p.yaml", "fit.fit_vehicle", (A, B, []),
     {"plan": Path("p.yaml"), "agent": "", "folder": None, "trust": False}),
    ("manoeuvre ship zigzag --rudder 20 --angle 10 --speed 7 --seconds 300 --out out --depth 31 --variant v --json "
     "--trust", "manoeuvre.show_manoeuvre", ("ship", "zigzag", Orders(20.0, 10.0, 7.0, 300.0, 31.0)),
     {"out": OUT, "as_json": True, "variant": "v", "trust": True}),
    ("manoeuvre ship stop", "manoeuvre.show_manoeuvre", ("ship", "stop", Orders()),
     {"out": None, "as_json": False, "variant": None, "trust": False}),
    ("cite a.yaml --trust", "cite.print_sources", (A,), {"trust": True}),
    ("cite", "cite.print_sources", (None,), {"trust": False}),
    ("list sensors dvl", "listing.print_keys", ("sensors", "dvl"), {}),
    ("list tasks", "listing.print_list", ("tasks",), {}),
    ("world a.yaml", "world.show_world", (A, [], []), {"samples": 24, "at_s": 0.0, "trust": False}),
    (f"world a.yaml --out out --out b.csv --samples 5 --at 2.5 {BOTH}", "world.show_world",
     (A, ["x=1", "y=2"], [OUT, B]), {"samples": 5, "at_s": 2.5, "trust": True}),
    ("view a.yaml", "view.show", (A, [], ViewOptions()), {}),
    (f"view a.yaml --world --host h --port 0 --no-browser --seed 0 --speed 2.5 --paused --for 3.5 {BOTH}", "view.show",
     (A, ["x=1", "y=2"], ViewOptions(True, "h", 0, False, 0, 2.5, True, 3.5, True)), {}),
    ("video b.csv out", "video.video", (B, OUT, VideoOptions()), {}),
    ("video b.csv out --chase --camera c --sonar s --panels --speed 2.5 --rate 7", "video.video",
     (B, OUT, VideoOptions(True, "c", "s", True, 2.5, 7)), {}),
    ("recover b.csv", "recover.recover_file", (B, None), {"in_place": False}),
    ("recover b.csv --out out --in-place", "recover.recover_file", (B, OUT), {"in_place": True}),
    ("replay b.csv", "replay.replay", (B, ReplayOptions()), {}),
    ("replay b.csv --foxglove --port 0", "replay.replay", (B, ReplayOptions(foxglove=True, port=0)), {}),
    ("replay b.csv --ros2 --foxglove --rosbag out --rate 2.5 --from 1.5 --to 4.5 --topic /a --topic /b --loop --port 7 "
     "--wait 0.75", "replay.replay",
     (B, ReplayOptions(True, True, OUT, 2.5, 1.5, 4.5, ("/a", "/b"), True, 0.75, 7)), {}),
    ("dataset a.yaml", "dataset.make", (A, None, [], DatasetOptions()), {}),
    ("dataset a.yaml --verify", "dataset.make", (A, None, [], DatasetOptions(verify=True)), {}),
    (f"dataset a.yaml out --workers 3 --ray local --shard 2/5 --verify --plan {BOTH}", "dataset.make",
     (A, OUT, ["x=1", "y=2"], DatasetOptions(3, "local", "2/5", True, True, True)), {}),
    ("sweep a.yaml", "sweep.sweep", (A, [], None, []),
     {"duration": None, "engine": Engine(), "record": False, "trust": False}),
    (f"sweep a.yaml --vary k=1,2 --vary l=3,4 --out out --duration 2.5 --record --workers 3 {BOTH}", "sweep.sweep",
     (A, ["k=1,2", "l=3,4"], OUT, ["x=1", "y=2"]),
     {"duration": 2.5, "engine": Engine(3), "record": True, "trust": True}),
    ("train T", "learn.learn", ("T", Lesson(2_000_000, 0, 512, None, None, None, 0.98), []), {}),
    ("train T --steps 3e4 --seed 5 --n 7 --out out --until d=0.3 --max-s 9.5 --discount 0.9 --set x=1", "learn.learn",
     ("T", Lesson(30_000, 5, 7, OUT, "d=0.3", 9.5, 0.9), ["x=1"]), {}),
    ("evaluate T", "learn.score", ("T", "script"),
     {"episodes": 256, "seed": 0, "film": None, "as_json": False, "options": []}),
    ("evaluate T --policy zero --episodes 9 --seed 5 --film out --json --set x=1", "learn.score", ("T", "zero"),
     {"episodes": 9, "seed": 5, "film": OUT, "as_json": True, "options": ["x=1"]}),
    ("evaluate T --policy zero --episodes 9 --seed 5 --lerobot out --set x=1", "learn.keep", ("T", "zero"),
     {"minari": None, "lerobot": OUT, "episodes": 9, "seed": 5, "options": ["x=1"]}),
    ("evaluate T --minari m/n", "learn.keep", ("T", "script"),
     {"minari": "m/n", "lerobot": None, "episodes": 256, "seed": 0, "options": []}),
    ("holoocean a.py --n 3", "holoocean.run_program", (["a.py", "--n", "3"],),
     {"module": None, "legacy_dynamics": False, "seed": None, "strict": False}),
    ("holoocean --legacy-dynamics --seed 0 --strict -m pack.mod --n 3", "holoocean.run_program", (["--n", "3"],),
     {"module": "pack.mod", "legacy_dynamics": True, "seed": 0, "strict": True}),
    ("holoocean --convert a.json b.csv", "holoocean.convert", (Path("a.json"), ["b.csv"]), {}),
    ("bench", "bench.run_bench", ([],), {"as_json": False, "write": None}),
    ("bench p q --json --write out", "bench.run_bench", (["p", "q"],), {"as_json": True, "write": OUT}),
]  # fmt: skip
COMMAND = get_command(app)
CODES = {"run.run_scenario": 130, "view.show": 143, "recover.recover_file": 1, "sweep.sweep": 1, "bench.run_bench": 1}


@pytest.mark.parametrize(("words", "work", "given", "named"), COMMANDS, ids=[c[0][:40] for c in COMMANDS])
def test_options_are_handed_on(
    words: str, work: str, given: tuple[Any, ...], named: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []

    def take(*args: Any, **keys: Any) -> int | None:
        asked.append((args, keys))
        return CODES.get(work)

    if work == "learn.keep":
        monkeypatch.setattr("pelagos.cli.learn.score", lambda *args, **keys: None)
    monkeypatch.setattr(f"pelagos.cli.{work}", take)
    code = COMMAND(_program_apart(words.split()), prog_name="pelagos", standalone_mode=False)
    assert asked == [(given, named)]
    assert (code or 0) == CODES.get(work, 0)


@pytest.mark.parametrize(
    ("options", "film"),
    [
        (VideoOptions(), FilmOptions("panels")),
        (VideoOptions(panels=True, speed=2.5, rate_hz=7), FilmOptions("panels", "", 7, 2.5)),
        (VideoOptions(chase=True), FilmOptions("chase")),
        (VideoOptions(camera="auv0.eye"), FilmOptions("camera", "auv0.eye")),
        (VideoOptions(sonar="imaging"), FilmOptions("sonar", "imaging")),
        (VideoOptions(sonar=""), FilmOptions("sonar", "")),
    ],
)
def test_a_film_is_of_what_was_asked_for(
    options: VideoOptions, film: FilmOptions, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    (tmp_path / "it.mcap").touch()
    asked: list[Any] = []

    def make(recording: Path, target: Path, wanted: FilmOptions, *, progress: Any) -> int:
        progress(2, 5)
        asked.append((recording, target, wanted))
        return 5

    monkeypatch.setattr("pelagos.viewer.film.make_film", make)
    video(tmp_path / "it.mcap", tmp_path / "it.mp4", options)
    assert asked == [(tmp_path / "it.mcap", tmp_path / "it.mp4", film)]
    assert capsys.readouterr().out.startswith("5 pictures: ")


class Playing:
    """Plays twice, and is interrupted the third time."""

    def __init__(self, part: Any, *, rate: float) -> None:
        self.said = [("part", part), ("rate", rate)]
        self.topics, self.times, self.listening = ["/a", "/b"], 0, 0
        made.append(self)

    def add(self, stage: Any) -> None:
        self.said.append(("to", stage.port))

    def wait(self, most_s: float) -> int:
        self.said.append(("wait", most_s))
        return self.listening

    def play(self) -> int:
        self.times += 1
        if self.times == 3:
            raise KeyboardInterrupt
        return 7

    def close(self) -> dict[str, int]:
        return {"late": 3}


made: list[Playing] = []


@pytest.mark.parametrize(("port", "taken"), [(None, 8765), (77, 77), (0, 0)])
@pytest.mark.parametrize(("loop", "wait_s", "listening"), [(True, 0.75, 2), (False, 0.75, 0), (False, 0.0, 0)])
def test_a_recording_is_played_as_it_was_asked_for(
    port: int | None,
    taken: int,
    loop: bool,
    wait_s: float,
    listening: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Any,
) -> None:
    made.clear()
    monkeypatch.setattr("pelagos.bridges.part.Part", lambda path, **keys: (path, keys))
    monkeypatch.setattr("pelagos.bridges.playback.Playback", Playing)
    monkeypatch.setattr(Playing, "wait", lambda self, most_s: self.said.append(("wait", most_s)) or listening)
    monkeypatch.setattr(
        "pelagos.bridges.foxglove_transport.FoxgloveTransport", lambda port=8765: SimpleNamespace(port=port)
    )
    options = ReplayOptions(
        foxglove=True, rate=2.5, start_s=1.5, end_s=4.5, topics=("/a",), loop=loop, wait_s=wait_s, port=port
    )
    if loop:
        with pytest.raises(KeyboardInterrupt):
            replay(B, options)
    else:
        replay(B, options)
    (playing,) = made
    part = (B, {"start_s": 1.5, "end_s": 4.5, "only": ("/a",)})
    assert playing.said == [("part", part), ("rate", 2.5), ("to", taken), ("wait", wait_s)]
    told = capsys.readouterr().out.splitlines()
    assert told[0] == f"playing to Foxglove at ws://127.0.0.1:{taken}"
    assert (told[1].startswith("nobody listens yet")) == (listening == 0 and wait_s > 0)
    assert told.count("7 messages of 2 topics played") == (2 if loop else 1)
    assert told[-1] == "3 x late"
