"""The page itself: complete, offline, and whole with any set of sensors."""

from __future__ import annotations

import base64
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from report_mission import ALL, Seabed, record

from pelagos.report.page import Tile, page, table
from pelagos.report.report import render_report
from pelagos.sim.replay import Recording

RUN = {
    "simulated_s": 30.0, "wall_s": 10.0, "real_time_factor": 3.0, "ended": "missions", "seed": 7, "copies": 1,
    "device": "cpu", "processor": "a processor", "threads": 2, "memory_mb": 512.0, "triangles": 1000,
    "ms_per_call": {"auv0.imu": 0.5}, "seconds": {"auv0.imu": 3.0, "record": 1.0},
}  # fmt: skip


class Links(HTMLParser):
    """Collects addresses, titles and pictures, and complains about tags that are not closed."""

    VOID = ("meta", "img", "br", "link")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.titles: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        self.addresses += [v or "" for k, v in attrs if k in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "h2":
            self.titles.append(data)


def parsed(file: Path) -> Links:
    links = Links()
    links.feed(file.read_text(encoding="utf-8"))
    assert links.open == []
    return links


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("report")
    record(found / "mission.mcap", seconds=30.0, noise=1.0)
    render_report(found, found / "mission.mcap", Seabed(), RUN)
    return found


def test_every_section_is_there(folder: Path) -> None:
    assert parsed(folder / "report.html").titles == [
        "Track of auv0", "Multibeam map", "Imaging sonar: imaging_sonar", "Camera: camera",
        "Navigation sensors against the truth", "Sensors of auv0", "Where the time went", "Run",
    ]  # fmt: skip


def test_the_page_needs_nothing_else(folder: Path) -> None:
    links = parsed(folder / "report.html")
    assert len(links.addresses) >= 4 + 6
    assert all(a.startswith("data:image/") for a in links.addresses)
    assert not re.search(r"https?://|@import|url\(", (folder / "report.html").read_text(encoding="utf-8"))


def test_pictures_are_not_blank(folder: Path) -> None:
    for address in parsed(folder / "report.html").addresses:
        picture = Image.open(io.BytesIO(base64.b64decode(address.split(",", 1)[1])))
        assert min(picture.size) >= 40
        assert np.asarray(picture.convert("L")).std() > 5


def test_statistics_stand_beside_the_page(folder: Path) -> None:
    stats = json.loads((folder / "stats.json").read_text(encoding="utf-8"))
    assert stats["seed"] == 7
    assert stats["real_time_factor"] == 3.0
    assert stats["versions"]["drjit"]
    assert {row["sensor"] for row in stats["sensors"]["auv0"]} == set(ALL)
    assert stats["soundings"]["auv0"]["std_m"] == pytest.approx(0.017, rel=0.2)
    assert stats["dead_reckoning"]["auv0"]["way_m"] == pytest.approx(45, abs=1)
    text = (folder / "report.html").read_text(encoding="utf-8")
    for shown in ("a processor", "drjit", "512 MB", "3.00", "200", "sensor_msgs/msg/Imu"):
        assert shown in text


@pytest.mark.parametrize(
    ("kinds", "drawn"), [(("imu",), False), (("depth", "camera"), False), (("multibeam",), False), ((), True)]
)
def test_sensors_that_are_missing_have_no_section(
    tmp_path: Path, kinds: tuple[str, ...], drawn: bool, request: pytest.FixtureRequest
) -> None:
    if not drawn:
        request.getfixturevalue("no_pictures")
    record(tmp_path / "mission.mcap", kinds=kinds, seconds=4.0)
    render_report(tmp_path, tmp_path / "mission.mcap", Seabed(), {})
    titles = parsed(tmp_path / "report.html").titles
    assert ("Camera: camera" in titles) == ("camera" in kinds)
    assert ("Multibeam map" in titles) == ("multibeam" in kinds)
    assert "Track of auv0" in titles


def test_a_recording_that_was_cut_off_has_a_report(tmp_path: Path) -> None:
    file = record(tmp_path / "mission.mcap", kinds=("imu", "depth"), seconds=10.0)
    file.write_bytes(file.read_bytes()[: file.stat().st_size * 3 // 4])
    assert not Recording(file).complete
    render_report(tmp_path, file, Seabed(), {})
    assert "(cut off)" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_what_users_write_does_not_become_html() -> None:
    text = page(title="<b>x</b>", kind="k", text="a & b", tiles=[Tile("1", "m", "<i>")], sections=[], foot="f")
    assert "<b>x" not in text
    assert "a &amp; b" in text
    assert "<td>&lt;script&gt;</td>" in table(["h"], [["<script>"]])
