"""What waits for browsers: the newest of each key, in few messages; what late comers get, and what is forgotten."""

from __future__ import annotations

import asyncio
import json
from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.viewer import hub as module
from pelagos.viewer.hub import Hub, records
from pelagos.viewer.stage import Stage


class Line:
    """A browser's connection that takes messages while it is open, and says nothing."""

    def __init__(self) -> None:
        self.taken: list[list[tuple[str, Any]]] = []
        self.open = asyncio.Event()
        self.gone = asyncio.Event()

    async def send(self, data: bytes) -> None:
        await self.open.wait()
        self.taken.append([(header["key"], header.get("n")) for header, _ in records(data)])

    def __aiter__(self) -> Line:
        return self

    async def __anext__(self) -> str:
        await self.gone.wait()
        raise StopAsyncIteration


async def rest() -> None:
    for _ in range(5):
        await asyncio.sleep(0)


def test_a_slow_browser_gets_the_newest_of_each_key_and_what_was_kept() -> None:
    hub = Hub()

    async def look() -> None:
        hub.publish("a", {"n": 1})
        hub.publish("b", {"n": 1}, keep=False)  # before anybody looked on
        line = Line()
        serving = asyncio.create_task(hub.serve(line))
        await rest()
        assert hub.count == 1
        for key, n in (("c", 1), ("d", 1), ("c", 2), ("c", 3), ("c", 4)):  # the first message is under way
            hub.publish(key, {"n": n}, keep=key == "d")
        await rest()
        assert hub.dropped == 3
        line.open.set()
        await rest()
        assert line.taken == [[("a", 1)], [("c", 4), ("d", 1)]]
        assert hub.sent == 3
        line.gone.set()
        await serving
        assert hub.count == 0
        late = Line()
        late.open.set()
        serving = asyncio.create_task(hub.serve(late))
        await rest()
        assert late.taken == [[("a", 1), ("d", 1)]]
        late.gone.set()
        await serving

    asyncio.run(look())


def test_what_waits_is_bundled_up_to_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_BUNDLE", 150)  # a record of 64 bytes has 92
    hub = Hub()

    async def look() -> None:
        for k in range(5):
            hub.publish(f"k{k}", {"n": k}, bytes(64))
        line = Line()
        line.open.set()
        serving = asyncio.create_task(hub.serve(line))
        await rest()
        assert [[n for _, n in message] for message in line.taken] == [[0, 1], [2, 3], [4]]
        line.gone.set()
        await serving

    asyncio.run(look())


def test_the_server_is_woken_once_for_what_is_published_together() -> None:
    hub, woken = Hub(), list[Any]()
    hub._loop = SimpleNamespace(call_soon_threadsafe=woken.append)  # type: ignore[assignment]
    with hub.together():
        pass
    hub.publish("a", {})  # nobody looks on
    assert (woken, list(hub._outgoing)) == ([], [])
    hub._browsers.add(object())  # type: ignore[arg-type]
    with hub.together():
        hub.publish("a", {})
        hub.publish("b", {})
        assert woken == []
    assert len(woken) == 1
    hub.publish("c", {})
    assert len(woken) == 2
    assert [key for key, _ in hub._outgoing] == ["a", "b", "c"]


def test_what_is_forgotten_is_a_path_and_its_parts_or_all_that_begins_so() -> None:
    hub = Hub()
    for key in ("node/a", "node/a/fin", "node/ab", "part/a", "panel/x", "panel/y"):
        hub.publish(key, {})
    hub.forget("node/a", whole=True)
    assert list(hub._kept) == ["node/ab", "part/a", "panel/x", "panel/y"]
    hub.forget("panel/")
    assert list(hub._kept) == ["node/ab", "part/a"]


def test_a_node_that_is_removed_leaves_nothing_for_late_comers() -> None:
    stage = Stage(Hub())
    for name in ("/bodies/a", "/bodies/a/0", "/bodies/ab"):
        stage.add("frame", name, position=(1.0, -2.0, 3.0)).show(visible=False)
        stage.send_arrays(name, {})
    stage.remove("/bodies/a")
    assert list(stage.placed) == ["/bodies/ab"]
    assert list(stage.hub._kept) == [f"{kind}/bodies/ab" for kind in ("node", "seen", "part")]
    stage.send_poses(2.5)
    ((header, _),) = records(stage.hub._kept["poses"])
    assert header["poses"] == {"/bodies/ab": [1, -2, 3, 1, 0, 0, 0]}
    assert header["t"] == 2.5


def test_each_line_for_the_user_is_a_message_of_its_own() -> None:
    hub, told = Hub(), list[Any]()
    hub.publish = lambda key, header, *rest, **how: told.append((key, dict(header), how))  # type: ignore[method-assign]
    hub.say("recorded")
    hub.say("no such agent", kind="error")
    assert [h for _, h, _ in told] == [
        {"type": "say", "text": "recorded", "kind": "note"}, {"type": "say", "text": "no such agent", "kind": "error"},
    ]  # fmt: skip
    assert told[0][0] != told[1][0]
    assert [how for *_, how in told] == [{"keep": False}] * 2


def test_messages_that_are_no_orders_or_too_long_are_not_handed_on() -> None:
    hub, heard = Hub(), list[Any]()
    hub.heard = heard.append
    frame = len(json.dumps({"do": "x", "pad": ""}))
    for message in ("no json", "[1]", '{"do": 3}', '{"say": "x"}', b'{"do": "x"}',
                    json.dumps({"do": "x", "pad": "a" * (65537 - frame)})):  # fmt: skip
        hub._take(message)
    assert heard == []
    hub._take(json.dumps({"do": "x", "pad": "a" * (65536 - frame)}))
    assert [h["do"] for h in heard] == ["x"]
