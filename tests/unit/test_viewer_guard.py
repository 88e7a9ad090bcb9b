"""Who may ask the view for what."""

from __future__ import annotations

import asyncio
import json
import urllib.error
import urllib.request
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.errors import InputError
from pelagos.viewer.guard import Guard, cookie_name
from pelagos.viewer.hub import packed
from pelagos.viewer.server import Server

PORT = 8123


def judged(path: str = "/", host: str = "127.0.0.1", **headers: str) -> str:
    guard = Guard(host, token="the-token")
    return guard.judge(path, {"Host": f"127.0.0.1:{PORT}", **headers}, port=PORT).answer


COOKIE = f"{cookie_name(PORT)}=the-token"
WEBSOCKET = {"Upgrade": "websocket"}


@pytest.mark.parametrize(
    ("path", "headers", "answer"),
    [
        ("/", {}, "refuse"),
        ("/?token=other", {}, "refuse"),
        ("/?token=the-token", {}, "enter"),
        ("/", {"Cookie": COOKIE}, "pass"),
        ("/", {"Cookie": "pelagos_view_1=the-token"}, "refuse"),
        ("/", {"Cookie": COOKIE, "Host": "evil.example"}, "refuse"),
        ("/?token=the-token", {"Host": "evil.example:8123"}, "refuse"),
        ("/live", {**WEBSOCKET, "Cookie": COOKIE, "Origin": "http://evil.example"}, "refuse"),
        ("/live", {**WEBSOCKET, "Cookie": COOKIE, "Origin": f"http://127.0.0.1:{PORT + 1}"}, "refuse"),
        ("/live", {**WEBSOCKET, "Cookie": COOKIE, "Origin": "null"}, "refuse"),
        ("/live", {**WEBSOCKET, "Origin": f"http://127.0.0.1:{PORT}"}, "refuse"),
        ("/live", {**WEBSOCKET, "Cookie": COOKIE, "Origin": f"http://127.0.0.1:{PORT}"}, "pass"),
        ("/live?token=the-token", WEBSOCKET, "pass"),
        ("/", {"Cookie": COOKIE, "Host": "localhost:9000"}, "pass"),  # a port that was forwarded
    ],
)
def test_requests_are_judged(path: str, headers: dict[str, str], answer: str) -> None:
    assert judged(path, **headers) == answer


def test_another_host_is_known_by_its_own_name_alone() -> None:
    assert judged(host="192.0.2.7", Cookie=COOKIE, Host="192.0.2.7:8123") == "pass"
    assert judged(host="192.0.2.7", Cookie=COOKIE, Host="192.0.2.8:8123") == "refuse"
    assert judged(host="0.0.0.0", Cookie=COOKIE, Host="anything.example") == "pass"  # all addresses: names are unknown


def test_tokens_are_long_and_never_the_same() -> None:
    tokens = {Guard("127.0.0.1").token for _ in range(50)}
    assert len(tokens) == 50
    assert min(map(len, tokens)) >= 22  # 128 bits and more
    assert all(token not in repr(Guard("127.0.0.1", token=token)) for token in tokens)


@pytest.fixture
def server() -> Any:
    made = Server(port=0)
    yield made
    made.close()


def fetch(url: str) -> tuple[int, str]:
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    try:
        with opener.open(url, timeout=10) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read().decode()


def test_page_is_served_with_the_token_alone(server: Any) -> None:
    base = f"http://127.0.0.1:{server.port}"
    assert fetch(base + "/")[0] == 403
    assert "address that the command printed" in fetch(base + "/")[1]
    status, page = fetch(server.url)
    assert status == 200
    assert "<title>Pelagos</title>" in page
    assert "http://" not in page  # nothing from the network
    assert "https://" not in page
    for path in ("/../pyproject.toml", "/%2e%2e/view.py", "/page/app.js", "/etc/passwd", "/data/", "/live"):
        assert fetch(f"{base}{path}?token={server.guard.token}")[0] in (403, 404)


def test_pages_are_only_got_and_the_server_keeps_its_name_to_itself(server: Any) -> None:
    with urllib.request.build_opener(urllib.request.HTTPCookieProcessor()).open(server.url, timeout=10) as answer:
        assert answer.headers["Server"] is None
    for method in ("POST", "PUT", "DELETE", "OPTIONS"):
        asked = urllib.request.Request(server.url, method=method)
        with pytest.raises(urllib.error.HTTPError) as refused, urllib.request.urlopen(asked, timeout=10):
            pass
        with refused.value as answer:
            assert (answer.code, answer.headers["Allow"]) == (405, "GET")


def test_websocket_takes_no_strangers_and_late_comers_get_what_is_kept(server: Any) -> None:
    import websockets

    heard: list[Any] = []
    server.hub.heard = heard.append
    server.hub.publish("a", {"type": "state", "t": 1.5}, b"abc")
    server.hub.publish("b", {"type": "note"}, keep=False)

    async def talk() -> bytes:
        base = f"ws://127.0.0.1:{server.port}/live"
        with pytest.raises(websockets.exceptions.InvalidStatus):
            await websockets.connect(base)
        with pytest.raises(websockets.exceptions.InvalidStatus):
            await websockets.connect(f"{base}?token={server.guard.token}", origin="http://evil.example")
        async with websockets.connect(f"{base}?token={server.guard.token}") as connection:
            first = await asyncio.wait_for(connection.recv(), 10)
            for message in ("no json", "[1]", json.dumps({"do": 3}), json.dumps({"do": "pause"})):
                await connection.send(message)
            while not heard:
                await asyncio.sleep(0.01)
        return bytes(first)

    first = asyncio.run(talk())
    assert first == packed({"key": "a", "type": "state", "t": 1.5}, b"abc")
    assert heard == [{"do": "pause"}]
    assert int(np.frombuffer(first[:4], "<u4")[0]) % 4 == 0  # arrays behind it are aligned


def test_port_that_is_taken_and_an_address_of_elsewhere_are_told(server: Any) -> None:
    with pytest.raises(InputError, match=f"port {server.port} is taken: give --port another number"):
        Server(port=server.port)
    with pytest.raises(InputError, match=r"192\.0\.2\.1: this is no address of this machine"):
        Server(host="192.0.2.1", port=0)
    with pytest.raises(InputError, match="0 to 65535"):
        Server(port=70000)


def test_a_notebook_shows_the_page_under_its_own_name() -> None:
    """Jupyter is at localhost: a page of 127.0.0.1 within it is another site's, and gets no cookie; and the reverse."""
    from pelagos.viewer.view import View

    url = "http://127.0.0.1:8123/?token=abc"
    view: Any = SimpleNamespace(url=url, server=SimpleNamespace(port=8123))
    shown = View._repr_html_(view)
    assert 'src="http://localhost:8123/?token=abc"' in shown
    assert f'location.hostname === "127.0.0.1") document.getElementById("pelagos-view-8123").src = "{url}"' in shown
    away: Any = SimpleNamespace(url="http://10.1.2.3:8123/?token=abc", server=view.server)
    assert 'src="http://10.1.2.3:8123/?token=abc"' in View._repr_html_(away)


def test_what_is_served_says_what_it_is_and_is_not_kept(server: Any) -> None:
    """The page and its parts, and bytes from memory; the policy goes with the page alone, the cookie with the token."""
    server.offer("map.png", "image/png", b"\x89PNG")
    cookie = server.guard.cookie(server.port)
    assert cookie == f"{cookie_name(server.port)}={server.guard.token}; HttpOnly; SameSite=Strict; Path=/"

    def ask(path: str, **headers: str) -> Any:
        host = {"Host": f"127.0.0.1:{server.port}", "Cookie": cookie.split(";")[0], **headers}
        return server._answer(None, SimpleNamespace(path=path, headers=host, method="GET"))

    for path, kind in (("/", "text/html; charset=utf-8"), ("/app.js", "text/javascript; charset=utf-8"),
                       ("/style.css", "text/css; charset=utf-8"), ("/data/map.png", "image/png")):  # fmt: skip
        answer = ask(path)
        assert (answer.status_code, answer.headers["Content-Type"]) == (200, kind)
        assert answer.headers["Cache-Control"] == "no-store"
        assert answer.headers["X-Content-Type-Options"] == "nosniff"
        assert int(answer.headers["Content-Length"]) == len(answer.body)
        assert ("Content-Security-Policy" in answer.headers) == (kind != "image/png")
    assert ask("/data/map.png").body == b"\x89PNG"
    websocket = {"Upgrade": "WebSocket", "Origin": f"http://127.0.0.1:{server.port}"}
    assert ask("/live", **websocket) is None
    for path in ("/", "/data/map.png", "/live/x"):
        assert ask(path, **websocket).status_code == 404
    assert ask("/live").status_code == 404
    entered = ask(f"/style.css?token={server.guard.token}", Cookie="")
    assert (entered.status_code, entered.headers["Location"]) == (303, "/style.css")
    assert entered.headers["Set-Cookie"] == cookie


@pytest.mark.parametrize(("host", "name"), [
    ("127.0.0.1", "127.0.0.1"), ("localhost", "127.0.0.1"), ("::1", "[::1]"), ("192.0.2.7", "192.0.2.7"),
    ("2001:db8::7", "[2001:db8::7]"),
])  # fmt: skip
def test_the_address_of_the_page_is_one_that_is_listened_at(host: str, name: str) -> None:
    server: Any = object.__new__(Server)
    server.guard, server.port = Guard(host, token="abc"), 8123
    assert server.url == f"http://{name}:8123/?token=abc"
    assert server.guard.judge("/?token=abc", {"Host": f"{name}:8123"}, port=8123).answer == "enter"
