"""Keeping DDS on this machine: its network, and its sockets, which the library opens to every network."""

from __future__ import annotations

import os
import socket
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final

LOOPBACK: Final = """<CycloneDDS><Domain>
<General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast><FragmentSize>60000B</FragmentSize><MaxMessageSize>65000B</MaxMessageSize></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers><SPDPInterval>1 s</SPDPInterval>
<InitialLocatorPruneDelay>inf</InitialLocatorPruneDelay></Discovery>
<Internal><HeartbeatInterval min="100 us" minsched="100 us" max="8 s">2 ms</HeartbeatInterval><AckDelay>0 s</AckDelay>
<NackDelay>2 ms</NackDelay><SocketReceiveBufferSize max="4 MB"/></Internal>
</Domain></CycloneDDS>"""
"""This machine alone, by unicast, which needs no multicast route. Other middleware announces itself by multicast only:
it finds us by our announcements, which therefore go on, every second, for as long as the node lives. A datagram of the
loopback may have 64 kB: large messages go in pieces of that size, not in the library's of 1344 bytes. A writer asks its
readers what they have every 2 ms, not every 100, so that large messages follow one another; readers answer at once, and
ask again for what they lost."""
FIRST_PORT: Final = 7400
PORTS: Final = 250
"""Ports of one domain, from `FIRST_PORT` + 250 times its number on (DDSI-RTPS 2.3, 9.6.1)."""
SO_BINDTODEVICE: Final = 25
LO: Final = b"lo\0"


def keep_to_loopback(domain: int) -> bool:
    """Let this process's sockets of a domain receive from the loopback alone; False where that cannot be had.

    Cyclone sends by the interface that it is given, but receives at 0.0.0.0: any machine could send to these ports.
    """
    if sys.platform != "linux":
        return False
    kept = 0
    for entry in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # the listing's own descriptor is gone; others are no sockets
            if not str(entry.readlink()).startswith("socket:"):
                continue
            with socket.socket(fileno=os.dup(int(entry.name))) as found:
                if found.family == socket.AF_INET and _of_domain(found.getsockname(), domain):
                    found.setsockopt(socket.SOL_SOCKET, SO_BINDTODEVICE, LO)
                    kept += 1
    return kept > 0


def _of_domain(address: tuple[str, int], domain: int) -> bool:
    first = FIRST_PORT + PORTS * domain
    return address[0] == "0.0.0.0" and first <= address[1] < first + PORTS
