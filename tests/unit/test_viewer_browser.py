"""The page in a real browser: headless Chromium with WebGL by software; skipped where there is none."""

from __future__ import annotations

import math
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.viewer.replay import replay_view
from pelagos.viewer.server import Server
from pelagos.viewer.session import Session

CHROMIUM = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None
)
playwright = pytest.importorskip("playwright.sync_api", reason="the test needs playwright")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="the test needs Chromium: sh scripts/chromium.sh"),
]
FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
PATIENCE_S = 90.0
SCENARIO: dict[str, Any] = {
    "name": "<b>bold</b> & small",
    "seed": 3,
    "world": {"type": "flat", "depth_m": 12.0},
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0, 0], "depth_m": 4.0, "heading_deg": 30, "speed_mps": 1.5},
            "control": "depth_heading_speed",
            "command": [5.0, 0.5, 1.5],
            "sensors": {
                "depth": {"type": "depth", "rate_hz": 10},
                "imaging": {"type": "imaging_sonar", "rate_hz": 2, "beams": 32, "bins": 64, "range_max_m": 15},
            },
        }
    },
}


def until(true: Callable[[], Any]) -> Any:
    """Wait for something that the page or the simulation will come to."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        found = true()
        if found:
            return found
        time.sleep(0.1)
    raise AssertionError("it did not come to that")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    root = ["--no-sandbox"] if os.geteuid() == 0 else []
    with playwright.sync_playwright() as p:
        made = p.chromium.launch(executable_path=CHROMIUM, headless=True, args=[*root, *FLAGS])
        yield made
        made.close()


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    sim = pl.Simulation.load(SCENARIO)
    with Session(sim, results=tmp_path_factory.mktemp("view"), server=Server(port=0)).start() as made:
        yield made


@pytest.fixture
def session(served: Session) -> Session:
    """A run from its start: where the test before has left the vehicle, there may be no ground any more."""
    begun = threading.Event()

    def begin() -> None:
        served.pilot.paused = False
        served.pilot.reset()
        begun.set()

    served.pilot.post(begin)
    assert begun.wait(PATIENCE_S)
    return served


class Watched:
    """A page, and what went wrong on it."""

    def __init__(
        self, browser: Any, url: str, *, size: tuple[int, int] = (1280, 720), script: str = "", **options: Any
    ) -> None:
        self.context = browser.new_context(viewport={"width": size[0], "height": size[1]}, **options)
        if script:
            self.context.add_init_script(script)
        self.page = self.context.new_page()
        self.page.set_default_timeout(1000 * PATIENCE_S)
        self.troubles: list[str] = []
        self.page.on("console", lambda m: self.troubles.append(m.text) if m.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda e: self.troubles.append(str(e)))
        self.page.on("request", lambda r: self._asked(r.url))
        self.page.goto(url, wait_until="commit")

    def _asked(self, url: str) -> None:
        if not url.startswith(("http://127.0.0.1:", "blob:", "data:")):
            self.troubles.append(f"asked for {url}")

    def time(self) -> float:
        return float(self.page.evaluate("document.getElementById('time').textContent").split()[0])

    def pictures(self) -> int:
        return int(self.page.evaluate("window.pelagos?.stage?.pictures || 0"))


def test_mission_is_seen_held_and_driven(browser: Any, session: Session) -> None:
    watched = Watched(browser, session.url)
    page, sim = watched.page, session.pilot.sim
    until(lambda: watched.pictures() >= 2)
    assert "token" not in page.url  # the cookie has it
    until(lambda: page.title() == "<b>bold</b> & small · Pelagos")
    assert page.evaluate("document.querySelectorAll('#title b').length") == 0  # a name is text

    def seen() -> np.ndarray[Any, Any]:  # what the scene's canvas shows, small
        numbers = page.evaluate("""() => { const s = pelagos.stage; s.draw(); 
            const c = document.createElement("canvas");
            c.width = 90; c.height = 60; const d = c.getContext("2d"); d.drawImage(s.canvas, 0, 0, 90, 60);
            return [...d.getImageData(0, 0, 90, 60).data]; }""")
        return np.array(numbers, dtype=float).reshape(60, 90, 4)[..., :3]

    page.click("[data-look='free']")
    where = page.evaluate("pelagos.stage.poses['/agents/auv0'][0]")
    first = seen()
    assert first.std() > 4.0  # something is drawn
    until(lambda: np.linalg.norm(np.subtract(page.evaluate("pelagos.stage.poses['/agents/auv0'][0]"), where)) > 1.0)
    assert np.abs(seen() - first).max() > 25.0  # a camera that stands still sees the vehicle move
    until(lambda: page.evaluate("document.querySelector('[data-sensor=\"auv0.imaging\"] img').naturalWidth") > 200)

    page.click("#pause")
    until(lambda: session.pilot.paused)
    until(lambda: page.inner_text("#pause") == "Run")
    held = sim.time_ns
    page.click("#tick")
    until(lambda: sim.time_ns == held + sim.dt_ns)
    page.keyboard.press("Space")
    until(lambda: sim.time_ns > held + 100 * sim.dt_ns)

    heading = sim.held_command("auv0")[0][1]
    page.click("#scene")
    page.keyboard.down("d")
    until(lambda: sim.held_command("auv0")[0][1] > heading + 0.1)  # to starboard: the compass grows
    page.keyboard.up("d")

    eye = np.array(page.evaluate("pelagos.stage.eye"))
    page.keyboard.press("Shift+ArrowLeft")
    assert np.linalg.norm(np.array(page.evaluate("pelagos.stage.eye")) - eye) > 0.1
    far = "Math.hypot(...pelagos.stage.eye.map((v, i) => v - pelagos.stage.target[i]))"
    before = page.evaluate(far)
    page.keyboard.press("+")
    assert page.evaluate(far) == pytest.approx(0.85 * before, rel=1e-6)
    assert page.evaluate("pelagos.plots.plots[0].own") == "depth"  # its line is the sensor's own truth
    numbers = page.evaluate("import('./plots.js').then((m) => m.graduations(-0.3, 3.3).map(([v, text]) => text))")
    assert numbers == ["0.1", "1.5", "2.9"]  # not 0, 2, 3 at equal distances
    session.view.hub.publish("waiting", {"type": "waiting", "s": 12}, keep=False)
    until(lambda: page.is_visible("#waiting"))
    assert "taken 12 s" in page.inner_text("#waiting")
    session.view.hub.publish("waiting", {"type": "waiting", "s": 0}, keep=False)
    until(lambda: not page.is_visible("#waiting"))

    box = page.locator("#map").bounding_box()
    under = "([x, y]) => pelagos.map.world({ clientX: x, clientY: y })"
    place = [round(box["x"] + 0.55 * box["width"]), round(box["y"] + 0.4 * box["height"])]  # wheels know whole pixels
    held = page.evaluate(under, place)
    page.mouse.move(*place)
    page.mouse.wheel(0, -600)
    until(lambda: page.evaluate("pelagos.map.near") > 2)
    until(lambda: np.allclose(page.evaluate(under, place), held, atol=4.0))  # nearer, about the pointer
    assert not session.pilot.goals.get("auv0")
    page.evaluate("pelagos.map.near = 10; pelagos.map.refine()")
    until(lambda: page.evaluate("pelagos.map.parts.some((p) => p.sharp > 3 * 520 / 1000)"))
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.3 * box["height"])
    goal = until(lambda: session.pilot.goals.get("auv0"))[0]
    asked = page.evaluate(
        "([x, y]) => pelagos.map.world({ clientX: x, clientY: y })",
        [box["x"] + 0.6 * box["width"], box["y"] + 0.3 * box["height"]],
    )
    assert goal[:2] == pytest.approx(asked, abs=0.5)
    until(lambda: sim.stepper.mode("auv0") == "line_of_sight")
    watched.context.close()
    assert watched.troubles == []
    moved = sim.time_ns
    until(lambda: sim.time_ns > moved)  # a browser that goes changes nothing


RAY = """([x, y]) => { const s = pelagos.stage, r = s.canvas.getBoundingClientRect();
    return [s.eye, s.ray(2 * (x - r.left) / r.width - 1, 1 - 2 * (y - r.top) / r.height)]; }"""
PAD = """window.pad = { connected: true, axes: [0, 0, 0, 0] }; navigator.getGamepads = () => [window.pad];"""


def test_tablet_props_by_mouse_section_and_gamepad(browser: Any, session: Session) -> None:
    """Way-points and props in the scene by the pointer, a gamepad's stick, and everything within a tablet's screen."""
    watched = Watched(browser, session.url, size=(1024, 768), script=PAD, has_touch=True)
    page, sim = watched.page, session.pilot.sim
    until(lambda: watched.pictures() >= 2 and page.evaluate("pelagos.stage.agent") == "auv0")
    outside = """() => [...document.querySelectorAll("header *, .looks *, .sticks *, #map-tools *")].filter((e) => {
        const { left, right, bottom, width } = e.getBoundingClientRect();
        return width && (left < -1 || right > innerWidth + 1 || bottom > innerHeight + 1); }).map((e) => e.id)"""
    assert page.evaluate(outside) == []
    assert page.evaluate("document.getElementById('pause').getBoundingClientRect().height") >= 38  # for fingers
    page.evaluate("window.pad.axes = [0.8, 0, 0, 0]")  # the left stick to the right
    until(lambda: sim.stepper.mode("auv0") == "depth_heading_speed")  # in other modes the second number is no heading
    heading = sim.held_command("auv0")[0][1]
    until(lambda: math.remainder(sim.held_command("auv0")[0][1] - heading, 2 * math.pi) > 0.1)
    page.evaluate("window.pad.axes = [0, 0, 0, 0]")
    page.evaluate("pelagos.stage.choose('free'); pelagos.stage.orbit(0, -0.4)")
    page.click("#pause")
    until(lambda: session.pilot.paused)
    page.click("#map-prop")
    box = page.locator("#scene").bounding_box()
    x, y = box["x"] + 0.55 * box["width"], box["y"] + 0.70 * box["height"]
    page.mouse.click(x, y)
    (body,) = until(lambda: sim.bodies.bodies)
    assert body.position[0, 2] == pytest.approx(-11.5, abs=0.02)  # half a metre over the ground at 12 m
    place = f"pelagos.stage.project(pelagos.stage.poses['/bodies/{body.name}'][0])"
    until(lambda: page.evaluate(f"pelagos.stage.props().includes('{body.name}') && !!{place}"))
    at = page.evaluate(place)
    assert (at[0] + box["x"], at[1] + box["y"]) == pytest.approx((x, y), abs=40)  # the ray met it there
    before = body.position[0].copy()
    page.mouse.move(box["x"] + at[0], box["y"] + at[1])
    page.mouse.down()
    end = [box["x"] + at[0] - 120, box["y"] + at[1] + 30]
    page.mouse.move(*end, steps=4)
    page.mouse.up()
    eye, way = np.array(page.evaluate(RAY, end))
    there = eye + way * (-12.0 - eye[2]) / way[2]
    assert np.linalg.norm(there[:2] - before[:2]) > 0.5
    until(lambda: np.linalg.norm(body.position[0, :2] - there[:2]) < 0.02)  # the last of the drag's messages
    assert body.position[0, 2] == pytest.approx(before[2], abs=0.02)
    held = body.position[0].copy()
    until(lambda: np.abs(np.array(page.evaluate(f"pelagos.stage.poses['/bodies/{body.name}'][0]")) - held).max() < 0.02)
    at = page.evaluate(place)
    page.mouse.dblclick(box["x"] + at[0], box["y"] + at[1])
    until(lambda: not sim.bodies.bodies)
    page.click("#map-way")
    page.mouse.dblclick(x, y)
    goal = until(lambda: session.pilot.goals.get("auv0"))[-1]
    assert goal[:2] == pytest.approx(before[:2], abs=0.1)  # the same ray
    page.click("#things-button")
    page.select_option("#section", "sound_speed")
    until(lambda: "speed of sound [m/s]" in page.inner_text("#legend"))
    page.select_option("#section", "off")
    until(lambda: not page.is_visible("#legend"))
    watched.context.close()
    assert watched.troubles == []


TICKS = 40
SHOWN = """() => { const image = document.querySelector("[data-sensor='auv0.imaging'] img");
    if (!image.complete || !image.naturalWidth || image.hidden) return null;
    const c = document.createElement("canvas"); c.width = image.naturalWidth; c.height = image.naturalHeight;
    const d = c.getContext("2d"); d.drawImage(image, 0, 0);
    const depth = document.querySelector("[data-sensor='auv0.depth'] .numbers b");
    if (!depth) return null;
    return { depth: depth.textContent, pixels: d.getImageData(0, 0, c.width, c.height).data.join(" ") }; }"""


def test_same_seed_from_the_page_gives_the_same_numbers(browser: Any, session: Session) -> None:
    """Two resets with one seed, one with another: what the page shows of a depth sensor and a sonar, noise and all."""
    watched = Watched(browser, session.url)
    page, sim = watched.page, session.pilot.sim
    fold = "[data-sensor='auv0.depth'] .fold"
    until(
        lambda: page.evaluate(
            f'!!document.querySelector("{fold}") && document.getElementById("time").textContent !== "0.0 s"'
        )
    )
    page.evaluate("document.getElementById('scene').style.display = 'none'")  # nothing here is about the picture
    press = partial(page.evaluate, "(what) => document.querySelector(what).click()")  # waits for no picture either
    press("#pause")
    until(lambda: session.pilot.paused)
    press(fold)  # numbers are folded away at first
    shown = []
    for seed in (41, 41, 42):
        page.evaluate(f"document.getElementById('seed').value = {seed}")
        press("#reset")
        until(lambda seed=seed: (sim.seed, sim.time_ns) == (seed, 0))
        until(lambda: watched.time() == 0.0)
        page.evaluate(f"for (let i = 0; i < {TICKS}; i++) document.getElementById('tick').click()")
        until(lambda: sim.time_ns == TICKS * sim.dt_ns)
        newest = f"pelagos.plots.plots[0].measured.at(-1)?.[0] > {TICKS * sim.dt_ns * 1e-9 - 0.1}"
        until(lambda newest=newest: page.evaluate(newest))  # the depth of now
        shown.append(until(lambda: page.evaluate(SHOWN)))
    first, again, other = shown
    assert first == again
    assert first["depth"] != other["depth"]
    assert first["pixels"] != other["pixels"]
    watched.context.close()
    assert watched.troubles == []


def test_page_offers_nothing_that_it_would_ignore(browser: Any) -> None:
    """A run that a program steps: to hold it and a section are all that the page can do."""
    sim = pl.Simulation.load(SCENARIO)
    with sim.view(port=0) as view:
        sim.step(ticks=20)
        watched = Watched(browser, view.url)
        page = watched.page
        until(lambda: page.inner_text("#kind").lower() == "live · looking on")
        offered = """() => [...document.querySelectorAll("button, select, input, .stick")].filter((e) =>
            e.checkVisibility() && !e.closest("#panels, .looks, .drawer")).map((e) => e.id)"""
        assert page.evaluate(offered) == ["pause", "things-button", "help-button", "agent", "map-in", "map-out"]
        for key in (".", "d"):
            page.keyboard.press(key)
        box = page.locator("#map").bounding_box()
        page.mouse.click(box["x"] + 0.4 * box["width"], box["y"] + 0.4 * box["height"])
        page.keyboard.press("Space")
        until(lambda: sim.paused)
        assert page.inner_text("#says") == ""  # none of them was sent, and refused
        sim.resume()
        watched.context.close()
        assert watched.troubles == []


def test_recording_is_scrubbed(browser: Any, tmp_path: Path) -> None:
    sim = pl.Simulation.load(SCENARIO)
    sim.run(6.0, record=tmp_path / "mission.mcap")
    true = sim.state["auv0"].position[0]
    with replay_view(tmp_path / "mission.mcap", server=Server(port=0), paused=True).start() as view:
        watched = Watched(browser, view.url)
        until(lambda: watched.pictures() >= 1 and watched.page.is_visible("#timeline"))
        assert watched.time() == 0.0
        watched.page.evaluate("""() => { const s = document.getElementById("scrub"); s.value = 6;
            s.dispatchEvent(new Event("input")); s.dispatchEvent(new Event("change")); }""")
        until(lambda: watched.time() == 6.0)
        until(lambda: abs(watched.page.evaluate("pelagos.map.agents.auv0.x") - true[0]) < 0.02)
        watched.page.keyboard.press("ArrowLeft")
        until(lambda: watched.time() == 5.0)
        watched.page.click("#pause")
        until(lambda: watched.time() > 5.0)
        watched.context.close()
        assert watched.troubles == []


def test_browser_without_webgl_is_told_so_in_one_sentence(browser: Any, session: Session) -> None:
    context = browser.new_context()
    context.add_init_script("HTMLCanvasElement.prototype.getContext = ((own) => function (kind, ...more) {"
                            "return kind.startsWith('webgl') ? null : own.call(this, kind, ...more); })"
                            "(HTMLCanvasElement.prototype.getContext);")  # fmt: skip
    page = context.new_page()
    page.goto(session.url, wait_until="commit")
    page.wait_for_selector(".no-gl", timeout=1000 * PATIENCE_S)
    assert "This browser has no WebGL 2" in page.inner_text(".no-gl")
    until(lambda: page.inner_text("#time") != "0.0 s")  # the rest works
    context.close()
