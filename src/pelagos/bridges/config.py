"""Configuration under `bridges:`; each kind of door has its own keys in its own file."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

from pydantic import ConfigDict

from pelagos.config.described import Described

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange
    from pelagos.sim.simulation import Simulation


class BridgeConfig(Described):
    """Settings that every door has."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    type: str
    """The kind of door: one of `pelagos list bridges`."""

    def check(self, sim: Simulation) -> None:
        """Refuse what does not fit the scenario, without opening anything.

        Raises:
            BridgeMismatch: an agent, a sensor or an address that cannot be.
        """

    def listens(self) -> str:
        """The place of its port ("tcp 127.0.0.1:9090"), so that no two doors share one; empty for none."""
        return ""

    @abstractmethod
    def attach(self, exchange: Exchange) -> str:
        """Open the door on a run; one line that says where it is.

        Raises:
            BridgeError: a package is missing, a port is taken, a peer does not answer.
        """


def listening(kind: str, host: str, port: int) -> str:
    """A port as `BridgeConfig.listens` says it; empty for port 0, which is any that is free."""
    return f"{kind} {LOOPBACK if host == 'localhost' else host}:{port}" if port else ""


LOOPBACK = "127.0.0.1"


def exposed(host: str) -> bool:
    """Whether a server at this address can be reached from other machines."""
    return not (host == "localhost" or host.startswith("127.") or host == "::1")
