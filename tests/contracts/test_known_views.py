"""What the view says to browsers, and panels, films and worlds show, of a made-up mission."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw

import made_up
from known import DOUBLE, SINGLE, check
from pelagos.drawing.sample import sample_of
from pelagos.sim.replay import Recording
from pelagos.viewer import cloud, film, track
from pelagos.viewer.chart import Chart
from pelagos.viewer.chase import draw_chase
from pelagos.viewer.film import FilmOptions, _Artist
from pelagos.viewer.frame import Placed, ShownFrame, ShownPose
from pelagos.viewer.hub import packed, records
from pelagos.viewer.panels import Panel
from pelagos.viewer.replay import Replay, subject_of
from pelagos.viewer.scene import Scene
from pelagos.viewer.still import world_view
from pelagos.viewer.view import View
from shown import Ear, Nobody, parts, reduced, slow_clock

WAY = made_up.motion(made_up.SECONDS)


DRAW = ImageDraw.Draw


class Pen:
    """Keeps what is drawn by lines and shapes; letters have one width and leave no trace but their words."""

    strokes: list[Any] = []  # noqa: RUF012

    def __init__(self, sheet: Image.Image) -> None:
        self._pen = DRAW(sheet)

    def textlength(self, text: str, font: Any = None) -> float:
        return 7.0 * len(text)

    def text(self, at: Any, text: str, **how: Any) -> None:
        self.strokes.append([at, text, how["fill"]])

    def __getattr__(self, name: str) -> Any:
        def stroke(*args: Any, **how: Any) -> None:
            self.strokes.append([name, args, {k: v for k, v in how.items() if k != "font"}])
            getattr(self._pen, name)(*args, **how)

        return stroke


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_up.record(tmp_path_factory.mktemp("views") / "mission.mcap")


@pytest.fixture(scope="module")
def played(recording: Path) -> tuple[Recording, Any, Any]:
    found = Recording(recording)
    return found, *subject_of(found)


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> None:
    slow_clock(monkeypatch)


@pytest.mark.parametrize("kind", made_up.KEYS)
def test_samples_and_panels(kind: str) -> None:
    """A reading as a sample, a panel after three of them, and in the scene's own colours."""
    config = made_up.configs((kind,))[kind]
    panel, found = Panel(config), dict[str, Any]()
    for reading in made_up.readings(kind, config):
        sample = sample_of(config, reading, truth=True)
        panel.take(sample)
    for part in ("polar", "line", "swath", "points", "colours", "beams"):
        values = getattr(sample, part)
        if values is not None:
            found[part] = values
    if sample.sector is not None:
        found["sector"], found["angle"] = sample.sector
    if sample.numbers:
        found |= parts("numbers", [sample.numbers, sample.truth])
    picture = panel.picture()
    if isinstance(picture, np.ndarray):
        found["picture"] = reduced(picture)
    if panel.scale is not None:
        found["scale"] = panel.scale
    check("panels", kind, found, DOUBLE)


def shown_pose(t_s: float, apart: float, actuators: int) -> ShownPose:
    k = int(t_s * 20)
    _, p, q, v, _ = made_up.motion(made_up.SECONDS, apart=apart)
    return ShownPose(p[k], q[k], v[k], np.linspace(-0.21, 0.34, actuators) * (1 + k % 7))


def test_a_scene_of_three_vehicles(played: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    _, subject, configs = played
    monkeypatch.setattr(cloud, "_PIECE", 260)
    monkeypatch.setattr(track, "_PIECE", 7)
    monkeypatch.setattr(track, "_MOST", 2)
    ear, found = Ear(), dict[str, Any]()

    def keep(what: str) -> None:
        found.update({f"{what}: {name}": values for name, values in ear.told().items()})

    scene = Scene(ear, subject.world, subject.vehicles, configs)
    scene.look_at_ground(7.3, -11.2)
    keep("begin")
    found["material"] = scene._material
    scene._material = np.random.default_rng(3).random(scene._material.shape)  # of every cell another
    scene.colour_ground("material")
    scene.look_at_ground(-12.0, 9.0)
    scene.label_world()
    for name, geometry in subject.bodies.items():
        scene.add_body(name, geometry)
    scene.plan("auv0", WAY[1][::97])
    keep("more")
    every = {k: made_up.readings(k, c, 6) for k, c in made_up.configs().items()}
    for i in range(24):
        t_s = 1.4 * i
        poses = {
            name: shown_pose(t_s, 0.9 * k, len(v.actuator_names))
            for k, (name, v) in enumerate(subject.vehicles.items())
        }
        samples = [
            Placed(sample_of(made_up.configs((k,))[k], r[i % 6]), poses["auv0"]) for k, r in every.items() if i % 4 == 1
        ]
        movers = {name: shown_pose(t_s, 2.0 + k, 0) for k, name in enumerate(subject.bodies)}
        known = {"auv0": shown_pose(t_s + 0.7, 0.1, 0)} if i > 3 else {}
        scene.draw(ShownFrame(round(t_s * 1e9), poses, known, movers, samples, jump=i == 13))
        if i == 10:
            scene.show("points", visible=False)
            scene.show("auv0.imaging_sonar", visible=False)
            scene.show("currents", visible=False)
            scene.show_currents(np.arange(24, dtype=np.float32).reshape(4, 2, 3) ** 1.1)
        if i == 16:
            scene.show("currents", visible=True)
            scene.show_currents(np.zeros((0, 2, 3), dtype=np.float32))
            scene.remove_body("crate")
    keep("drawn")
    check("views", "a scene of three vehicles", found, DOUBLE)


def test_a_recording_in_a_view(played: Any) -> None:
    recording, subject, configs = played
    source = Replay(recording, configs, world=subject.world)
    view = View(subject, source, source, server=Nobody())  # type: ignore[arg-type]
    ear = view.hub
    assert isinstance(ear, Ear)
    found = {f"begin: {k}": v for k, v in ear.told().items() if not k.startswith("node")}
    found["map"] = reduced(Image.open(io.BytesIO(view.server.offered["map.png"])))  # type: ignore[attr-defined]
    before = None
    for t_s in (2.0, 2.6, 11.5, 14.0, 21.3, 35.0):
        frame = source.frame(round(t_s * 1e9), since_ns=before)
        before = round(t_s * 1e9)
        view._draw(frame)
        found |= parts(f"state at {t_s:g} s", frame.status)
        told = ear.told()
        found |= {f"{k} at {t_s:g} s": told[k] for k in ("state", "panel", "state, words", "panel, words") if k in told}
    found |= parts("marks", source.marks)
    steps = [{"do": "pause", "paused": True}, {"do": "seek", "t": 7.5}, {"do": "speed", "speed": 3},
             {"do": "speed", "speed": 0}, {"do": "pause"}, {"do": "seek", "t": 99.0}, {"do": "pause"},
             {"do": "pause", "paused": False}]  # fmt: skip
    played_to = []
    for step in steps:
        done = source.obey(step)
        frame = source.take(0.0)
        played_to.append([done, None if frame is None else [frame.t_ns * 1e-9, frame.jump, dict(frame.status)]])
    found |= parts("played", [played_to, source.obey({"do": "speed", "speed": 101}), source.obey({"do": "fly"})])
    for message in (
        {"do": "follow", "agent": "rov"}, {"do": "look_at", "x": 3.0, "y": -9.0}, {"do": "ground", "by": "material"},
        {"do": "chart", "bounds": [-3.0, -8.0, 9.0, 5.0]}, {"do": "panels", "names": ["auv0.sidescan"]},
        {"do": "show", "what": "points", "visible": False}, {"do": "fly"},
    ):  # fmt: skip
        view._heard(message)
        view._do_asked()
        found |= {f"{message['do']}: {name}": values for name, values in ear.told().items()}
    check("views", "a recording", found, DOUBLE)


def test_what_a_recording_tells_of_each_sensor(played: Any) -> None:
    recording, subject, configs = played
    found: dict[str, Any] = {}
    for placed in (
        Replay(recording, configs, world=subject.world).frame(17_350_000_000, since_ns=16_950_000_000).samples
    ):
        s = placed.sample
        numbers = [s.numbers, s.truth, placed.pose.position, placed.pose.attitude, s.t_ns * 1e-9]
        arrays = [s.polar, s.line, s.swath, s.sector, s.points, s.colours, s.beams]
        arrays += [reduced(s.picture)] if isinstance(s.picture, np.ndarray) else []
        found |= {s.name: parts("", numbers)[""]}
        found |= {f"{s.name} {k}": parts("", [a])[""] for k, a in enumerate(arrays) if a is not None}
    check("views", "each sensor of a recording", found, DOUBLE)


@pytest.mark.parametrize("kind", ["chase", "camera", "sonar", "panels"])
def test_films(kind: Any, recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(film.ImageDraw, "Draw", Pen)
    artist = _Artist(recording, FilmOptions(kind, "profiling_sonar" if kind == "sonar" else "", size=(480, 320)))
    found = {}
    for t_s in (1.0, 2.9):
        Pen.strokes = []
        found[f"picture at {t_s:g} s"] = reduced(artist.picture(round(t_s * 1e9)))
        found |= parts(f"strokes at {t_s:g} s", Pen.strokes)
    check("views", f"film of {kind}", found, DOUBLE if kind == "sonar" else SINGLE)  # JPEG decoders differ


def test_a_film_has_a_picture_for_each_step(recording: Path, tmp_path: Path) -> None:
    """36 s at 6 times the clock and 2 pictures a second: one each 3 s, the first at once, the last at 33 s or more."""
    told: list[tuple[int, int]] = []
    options = FilmOptions("camera", size=(96, 64), rate_hz=2, speed=6.0)
    count = film.make_film(recording, tmp_path / "it.mp4", options, progress=lambda done, of: told.append((done, of)))
    assert (count, told) == (12, [(k, 12) for k in range(1, 13)])


def test_records_of_a_message() -> None:
    """Headers and blobs come back, whatever their lengths, one behind the other."""
    said = [({"type": "a", "t": k * 0.5}, bytes(range(k))) for k in range(9)]
    assert list(records(b"".join(packed(*one) for one in said))) == said


def test_a_picture_from_behind(played: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Near, hulls hide one another and their own far sides."""
    _, subject, _ = played
    poses = {
        name: (ShownPose(np.array([2.0 + 1.1 * k, -3.0 - 0.4 * k * k, -4.0 + 0.3 * k]), shown_pose(5 + 4 * k, k,
        0).attitude),
               subject.vehicles[name])
        for k, name in enumerate(("rov", "auv0", "usv"))
    }  # fmt: skip
    sheet = Image.new("RGB", (320, 240))
    tracks = [(float(x), float(y)) for x, y, _ in WAY[1][::30]], [(i, 3.0 + 0.1 * i) for i in range(24)]
    draw_chase(sheet, subject.world, poses, "auv0", *tracks)
    check("views", "a picture from behind", {"picture": reduced(sheet)}, DOUBLE)


def test_a_world_alone() -> None:
    from pelagos.config.loader import load_scenario

    view = world_view(load_scenario(made_up.scenario(())[0]), server=Nobody())  # type: ignore[arg-type]
    frame = view._source.take(0.0)
    assert frame is not None
    assert view._source.take(0.0) is None
    view._draw(frame)
    ear = view.hub
    assert isinstance(ear, Ear)
    chart = Chart(view.subject.world)
    chart.ask({"bounds": [-20.0, -9.0, 14.0, 3.0]})
    chart.ask({"bounds": [0.0, 0.0, 0.5, 3.0]})
    near = chart.survey()
    assert near is not None
    assert chart.survey() is None
    found = ear.told() | {"relief": near.height, "structure": near.structure, "extent": near.extent}
    check("views", "a world alone", found | parts("legend", chart.legend), DOUBLE)
