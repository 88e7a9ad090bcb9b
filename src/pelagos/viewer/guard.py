"""The guard of the view's server: a token, the name it is asked by, and where a WebSocket comes from.

Pure decisions about the head of a request; `viewer/server.py` obeys them.
"""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Final, Literal
from urllib.parse import parse_qs, urlsplit

LOOPBACK: Final = frozenset({"127.0.0.1", "localhost", "::1"})
EVERYWHERE: Final = frozenset({"0.0.0.0", "::", ""})
"""Addresses to listen at that are all addresses of a machine: the name by which it is asked is then unknown."""

Answer = Literal["pass", "enter", "refuse"]


@dataclass(frozen=True)
class Verdict:
    """Answer of the guard to a request.

    Attributes:
        answer: "pass" it on; "enter": the token is right, so give the cookie and send to the page without the token;
            "refuse" it.
        reason: of a refusal, for who asks.
    """

    answer: Answer
    reason: str = ""


@dataclass(frozen=True)
class Guard:
    """Judges requests.

    Attributes:
        host: the address that is listened at.
        token: what a browser must know.
    """

    host: str
    token: str = field(default_factory=lambda: secrets.token_urlsafe(18), repr=False)

    def judge(self, path: str, headers: Mapping[str, str], *, port: int) -> Verdict:
        """A verdict on a request.

        Args:
            path: with its query.
            headers: of the request; names in any case, if the mapping sees to it.
            port: that the server listens at; names the cookie, which all ports of a host share.
        """
        asked = headers.get("Host", "")
        if not self._known(asked):
            return Verdict("refuse", "this name is not one of the view's")
        origin = headers.get("Origin")
        upgrade = headers.get("Upgrade", "").lower() == "websocket"
        if upgrade and origin is not None and urlsplit(origin).netloc.lower() != asked.lower():
            return Verdict("refuse", "another site's page may not open this")
        if self._equal(_cookie(headers.get("Cookie", ""), cookie_name(port))):
            return Verdict("pass")
        if self._equal(parse_qs(urlsplit(path).query).get("token", [""])[0]):
            return Verdict("pass" if upgrade else "enter")
        return Verdict("refuse", "open the address that the command printed: it has a token at its end")

    def cookie(self, port: int) -> str:
        """The value of `Set-Cookie`."""
        return f"{cookie_name(port)}={self.token}; HttpOnly; SameSite=Strict; Path=/"

    def _known(self, asked: str) -> bool:
        name = (urlsplit(f"//{asked}").hostname or "") if asked else ""
        return self.host in EVERYWHERE or name in LOOPBACK or name == self.host.lower()

    def _equal(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self.token.encode())


def cookie_name(port: int) -> str:
    """Cookies are shared by the ports of a host: each has its own."""
    return f"pelagos_view_{port}"


def _cookie(header: str, name: str) -> str:
    try:
        found = SimpleCookie(header).get(name)
    except CookieError:
        return ""
    return "" if found is None else found.value
