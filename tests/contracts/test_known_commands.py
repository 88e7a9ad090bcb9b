"""What commands print: the words as they are, the numbers as they were when somebody last looked at them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

import made_up
from known import SINGLE, check
from pelagos.cli import console, listing, world
from pelagos.cli.check import describe, show_check
from pelagos.cli.doors import door_place
from pelagos.cli.main import main
from pelagos.cli.manoeuvre import show_manoeuvre
from pelagos.config import registry
from pelagos.config.loader import load_scenario
from pelagos.config.strict import Strict
from pelagos.errors import InputError, PelagosError
from pelagos.manoeuvres.orders import Orders
from shown import digest, parts

MISSION: list[dict[str, Any]] = [
    {"type": "dive", "depth_m": 3.5},
    {"type": "waypoints", "points": [[3, 4]], "altitude_m": 2.5, "speed_mps": 1.2},
    {"type": "goto", "points": [[3, 4, -5], [1, 2, -3]]},
    {"type": "lawnmower", "corner": [10, -9], "heading_deg": 40, "length_m": 30, "width_m": 30, "spacing_m": 15,
     "depth_m": 4},
    {"type": "lawnmower", "corner": [10, -9], "heading_deg": 40, "length_m": 30, "width_m": 0.7, "spacing_m": 0.1,
     "depth_m": 4},
    {"type": "lawnmower", "corner": [10, -9], "heading_deg": 40, "length_m": 30, "width_m": 29, "spacing_m": 15,
     "depth_m": 4},
    {"type": "survey", "area": [[10, -9], [51, -30], [30, 22]], "spacing_m": 12, "depth_m": 3},
    {"type": "orbit", "center": [24, 7], "radius_m": 21, "direction": "clockwise", "turns": 1.25, "depth_m": 6},
    {"type": "profile", "lower_depth_m": 20, "upper_depth_m": 2.5, "cycles": 2, "heading_deg": 55},
    {"type": "station_keeping", "point": [6, -4], "seconds": 60},
    {"type": "hold", "seconds": 7.5}, {"type": "drift", "seconds": 6, "until": {"sensor": "depth", "below": 3.25}},
    {"type": "surface"}, {"type": "gps_fix", "timeout_s": 31}, {"type": "repeat", "last": 2, "times": 3},
     {"type": "repeat", "times": 2},
]  # fmt: skip
SMALL: dict[str, Any] = {
    "name": "small one", "description": "Nobody   sails\n it.", "seed": 3, "duration_s": 1.25, "tick_rate_hz": 20,
    "origin": {"latitude_deg": 44.25, "longitude_deg": 13.5},
    "world": {"type": "flat", "depth_m": 20, "size_m": [60, 40],
              "things": [{"shape": "box", "at_m": [5, -4, -18], "size_m": [3, 2, 4]}]},
    "agents": {
        "auv0": {"vehicle": "remus100", "start": {"position_m": [1, -2], "depth_m": 5, "speed_mps": 1,
        "heading_deg": 30},
                 "mission": [{"type": "waypoints", "points": [[4.0, -3.0], [60.0, 3.0]], "depth_m": 5}],
                 "sensors": {"imu": {"type": "imu", "rate_hz": 20}, "depth": {"type": "depth", "rate_hz": 10,
                 "position_m": [0.2, 0.1, 0]}}},
        "rov": {"vehicle": "bluerov2_heavy", "count": 2, "start": {"position_m": [9, 4], "altitude_m": 8,
        "spacing_m": 5}, "control": "velocity",
                "command": [0.1, 0, 0.2, 0]},
    },
    "bridges": {"fox": {"type": "foxglove", "port": 0}},
}  # fmt: skip


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scenario file in the working folder; texts are as wide as they are."""
    monkeypatch.chdir(tmp_path)
    for one in (console.out, console.err):
        monkeypatch.setattr(one, "_width", 160)
    path = Path("small.yaml")
    path.write_text(yaml.safe_dump(SMALL, sort_keys=False))
    return path


def said(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """What a command says, its exit code first, its wall-clock times taken out."""
    with pytest.raises(SystemExit) as caught:
        main(words)
    captured = capsys.readouterr()
    text = f"exit {caught.value.code or 0}\n{captured.out}--\n{captured.err}"
    text = re.sub(
        r"in [\d.]+ s, [\d.]+ x real time|[\d.,]+ [kMGT]?i?B of memory are free|(?m:^.* a second, .* s left$)", "", text
    )
    text = re.sub(r"(?m)^(generated in|peak memory|memory).*$|; known: .*$", "", text)
    text = text.partition("One reading at")[2] if words[0] == "explain" and "One reading" in text else text
    return re.sub(r" +", " ", re.sub(r" +$", "", text, flags=re.M))


COMMANDS: dict[str, list[str]] = {
    "check": ["check", "--no-build", "small.yaml"],
    "check of changes": ["check", "small.yaml", "--no-build", "--set", "agents.auv0.start.altitude_m=2.5", "--set",
    "agents.auv0.start.depth_m=null"],
    "cost": ["check", "--cost", "small.yaml"], "cost of copies": ["check", "--cost", "small.yaml", "--n", "16"],
    "world": ["world", "small.yaml", "--out", "it.json"], 
    "explain": ["explain", "small.yaml", "auv0.depth"], "cite": ["cite", "small.yaml"],
    "run": ["run", "small.yaml", "--out", "it", "--no-report", "--set", "bridges={}"],
    "run in segments": ["run", "small.yaml", "--out", "seg", "--no-report", "--checkpoint-every", "0.5", "--set",
    "bridges={}"],
    "manoeuvre": ["manoeuvre", "otter", "bollard"],
    "manoeuvre as data": ["manoeuvre", "otter", "decay", "--angle", "8", "--seconds", "6", "--json"],
    "sweep": ["sweep", "small.yaml", "--vary", "agents.auv0.start.heading_deg=10,40", "--duration", "0.2", "--out",
    "sw", "--set", "bridges={}"],
    "channel": ["channel", "small.yaml", "auv0", "21,-13,-6.7", "--frequency", "18000"],
    "channel as data": ["channel", "small.yaml", "0,0,-4", "21,-13,-7.3", "--json"],
    "no agent": ["explain", "small.yaml", "auv9.depth"], "no option": ["manoeuvre", "otter", "bollard", "--rudder",
    "5"],
    "no file": ["run", "nothing.yaml"], "no vehicle": ["manoeuvre", "ottar", "bollard"],
    "twice": ["sweep", "small.yaml", "--vary", "seed=1,1"], "no place": ["channel", "small.yaml", "1,2,x", "auv0"],
    "no kind": ["world", "small.yaml", "--out", "it.jpg"], "no time": ["run", "small.yaml", "--duration", "-1"],
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::pelagos.errors.PelagosWarning")
@pytest.mark.parametrize("case", COMMANDS)
def test_commands(case: str, small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    check("commands", case, {"said": said(capsys, *COMMANDS[case])}, SINGLE)


class Table(Strict):
    """Keys of a component that nobody has."""

    type: str
    size_m: tuple[float, float] = (3.0, 4.0)
    """How wide [m]."""
    words: str = "a"


ENTRIES = {
    "one": SimpleNamespace(title="the first [m]", package="", config=Table),
    "the_second": SimpleNamespace(title="another", package="a-package", config=Table),
}


@pytest.mark.parametrize(
    "words",
    [
        ("vehicles",),
        ("worlds",),
        ("sensors", "one"),
        ("worlds", "the_second"),
        ("vehicles", "one"),
        ("devices",),
        ("tasks",),
    ],
)
def test_lists(words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Of components that are not those of today: a vehicle more changes nothing here."""
    monkeypatch.setattr(console.out, "_width", 160)
    monkeypatch.setattr(listing.registry, "entries", lambda kind: ENTRIES)
    monkeypatch.setattr(listing.registry, "find", lambda kind, name: ENTRIES[name])
    monkeypatch.setattr(
        listing,
        "DEVICES",
        {
            "dvl": {"a": SimpleNamespace(title="it [m]", source="a sheet")},
            "lidar": {"longer": SimpleNamespace(title="b", source="c")},
        },
    )
    monkeypatch.setattr("pelagos.envs.registry.task_names", lambda: ("pelagos/One-v0", "pelagos/Another-v0"))
    monkeypatch.setattr("pelagos.envs.registry.task_class", lambda name: Table)
    check("commands", f"list {' '.join(words)}", {"said": said(capsys, "list", *words)})


def test_legs_in_words() -> None:
    scenario = load_scenario({"world": {"type": "flat"}, "agents": {"a": {
        "vehicle": "remus100", "start": {"depth_m": 3}, "mission": MISSION, "sensors": {"depth": {"type": "depth",
        "rate_hz": 5}},
    }}})  # fmt: skip
    check("commands", "legs", {"said": "\n".join(describe(leg) for leg in scenario.agents["a"].mission)})


def test_many_agents(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(console.out, "_width", 160)
    agents = {f"v{k}": {"vehicle": "bluerov2", "start": {"position_m": [3.0 * k, -k], "depth_m": 3}} for k in range(23)}
    show_check(load_scenario({"world": {"type": "flat"}, "agents": agents}), "it", build=False)
    check("commands", "many agents", {"words": digest(capsys.readouterr().out)})


def test_places_of_bridges() -> None:
    found = []
    for name, entry in registry.entries("bridge", plugins=False).items():
        try:
            found.append(f"{name}: {door_place(entry.config.model_validate({'type': name}))}")
        except ValueError:
            found.append(f"{name}: needs keys")
    check("commands", "places of bridges", {"said": "\n".join(found).replace(" (taken at present)", "")})


def test_names_that_move_no_cursor() -> None:
    assert console.visible("a\x1b[2J\u202eb\tc\x7f") == "a\\x1b[2J\\u202eb\tc\\x7f"
    assert console.shown("/no/such/place") == "/no/such/place"
    assert console.shown(Path("it") / "b") == "it/b"
    assert world.SUFFIXES == (".png", ".html", ".glb", ".npz", ".json")


def test_a_picture_of_a_manoeuvre(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    show_manoeuvre("otter", "bollard", Orders(), out=tmp_path / "it.png", as_json=True)
    told = json.loads(capsys.readouterr().out)
    assert (tmp_path / "it.png").read_bytes().startswith(b"\x89PNG")
    check("commands", "bollard", parts("told", told))


def test_a_manoeuvre_of_another_parameter_set(capsys: pytest.CaptureFixture[str]) -> None:
    """By HMRI's drift tests the tanker turns wider: MARIN's model had 3.1 to 3.4 L."""
    widths, orders = [], Orders(rudder_deg=35.0, seconds=500.0)
    for variant in (None, "drift_tests"):
        show_manoeuvre("kvlcc2", "turning", orders, out=None, as_json=True, variant=variant)
        told = json.loads(capsys.readouterr().out)
        assert told["variant"] == variant
        widths.append(next(m["value"] for m in told["measures"] if m["name"] == "tactical diameter"))
    assert widths == pytest.approx([3.00, 3.22], abs=0.01)
    with pytest.raises(PelagosError, match=r"variant 'drift_test' is none of .*did you mean 'drift_tests'"):
        show_manoeuvre("kvlcc2", "turning", Orders(), out=None, as_json=True, variant="drift_test")
    with pytest.raises(InputError, match=r"--variant shallow: is for vehicles of the catalogue"):
        show_manoeuvre("ship.yaml", "turning", Orders(), out=None, as_json=True, variant="shallow")


def test_recordings(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A whole one, one that was cut off, and one as a folder of ROS 2."""
    path = made_up.record(Path("it.mcap"), ("depth", "imu"))
    texts = [
        said(capsys, "recover", "it.mcap"),
        said(capsys, "replay", "it.mcap", "--rosbag", "bag", "--from", "1", "--to", "3"),
    ]
    cut = Path("cut.mcap")
    cut.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    texts += [
        said(capsys, "recover", "cut.mcap"),
        said(capsys, "recover", "none.mcap"),
        said(capsys, "replay", "it.mcap"),
    ]
    check("commands", "recordings", {"said": "\n".join(re.sub(r"at byte \d+|\d+ bytes", "", t) for t in texts)})


@pytest.mark.filterwarnings("ignore:.*the Allan deviation at:pelagos.errors.PelagosWarning")  # it moves
def test_fits(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Noise of columns of a file, as a table and as data."""
    random = np.random.default_rng(4)
    v = np.stack([0.8 + 0.3 * np.sin(np.arange(600) / 50.0), 0.2 * np.cos(np.arange(600) / 31.0)])
    columns = [np.arange(600) / 20.0, *(np.cos(a) * v[0] + np.sin(a) * v[1] + 0.01 * random.normal(size=600)
               for a in np.radians([45.0, 135.0, 225.0, 315.0]))]  # fmt: skip
    rows = "\n".join(",".join(f"{x:.9g}" for x in row) for row in zip(*columns, strict=True))
    Path("it.csv").write_text(f"t,a,b,c,d\n{rows}\n")
    texts = [
        said(capsys, "fit-noise", "it.csv", "--columns", "a, b"),
        said(capsys, "fit-noise", "it.csv", "--beams", "a,b,c,d"),
        said(capsys, "fit-noise", "it.csv", "--beams", "a,b,c,d", "--json"),
        said(capsys, "fit-noise", "it.csv", "--columns", "q"),
    ]
    check("commands", "noise of a file", {"said": "\n".join(texts)})
