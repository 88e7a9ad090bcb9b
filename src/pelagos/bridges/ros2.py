"""The door to ROS 2: topics, frames, clock, commands and services, with ROS installed or without."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final, Literal

from pydantic import Field

from pelagos.bridges.config import BridgeConfig
from pelagos.bridges.transport import BridgeError, BridgeMismatch, Stage

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange
    from pelagos.sim.simulation import Simulation

GID_BYTES: Final = {"humble": 24}
Distro = Literal["humble", "iron", "jazzy", "kilted", "lyrical"]


class Ros2Config(BridgeConfig):
    """ROS 2: every topic of a recording, /clock, /tf, commands and services."""

    type: Literal["ros2"]
    transport: Literal["auto", "dds", "zenoh", "rclpy"] = "auto"
    """How messages travel: `auto` takes rclpy where ROS is sourced, else DDS, else zenoh; a named one is never
    replaced."""
    domain_id: int | None = Field(default=None, ge=0, le=232)
    """ROS domain; ROS_DOMAIN_ID, or 0, where not given."""
    distro: Distro = "jazzy"
    """ROS distribution of the peers; only Humble differs (longer ids in its graph)."""
    network: Literal["loopback", "open"] = "loopback"
    """`loopback` stays on this machine. `open` uses the library's defaults, or opens zenoh's router to the network;
    neither knows passwords: whoever is on that network can read and command. rclpy is where the sourced ROS is."""
    node: str = Field(default="pelagos", pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")
    """Name of the node in ROS's graph, and of the services (`/pelagos/reset`)."""
    topics: tuple[str, ...] = ()
    """Beginnings of the topics that are published; all where empty."""
    tf: Literal["truth", "mounts", "none"] = "truth"
    """Which transforms are published: `map` to vehicles and mounts; mounts alone, where an estimator of your own
    publishes the vehicles; or none."""
    clock: bool = True
    """Publish /clock, for nodes with use_sim_time."""
    commands: bool = True
    """Obey commands."""
    services: bool = True
    """Offer services (pause, reset, step, spawn, state ...)."""
    holoocean: bool = False
    """Also take HoloOcean's topics and services, below /holoocean."""
    announce: bool = True
    """Tell ROS's graph about the node."""

    def check(self, sim: Simulation) -> None:
        """See `BridgeConfig`."""
        assert self.domain >= 0

    def attach(self, exchange: Exchange) -> str:
        """See `BridgeConfig`."""
        from pelagos.bridges.door import TopicDoor
        from pelagos.bridges.holoocean import listen_holoocean
        from pelagos.bridges.ros_commands import listen
        from pelagos.bridges.services import Services

        transport, why = make_transport(self)
        skip = {"truth": (), "mounts": ("/tf",), "none": ("/tf", "/tf_static")}[self.tf]
        exchange.add(TopicDoor(transport, clock=self.clock, only=self.topics, skip=skip))
        services = Services(exchange, prefix=f"/{self.node}")
        if self.commands:
            listen(transport, exchange.sim, exchange.inbox)
            services.listen(transport)
        served = self.services and services.offer(transport)
        if self.holoocean:
            listen_holoocean(transport, exchange.sim, exchange.inbox)
            if served:
                services.offer_holoocean(transport)
        return f"ROS 2 by {transport.name} ({why}), domain {self.domain}, {transport.reach}"

    @property
    def domain(self) -> int:
        """The domain in use.

        Raises:
            BridgeMismatch: ROS_DOMAIN_ID is no number.
        """
        if self.domain_id is not None:
            return self.domain_id
        given = os.environ.get("ROS_DOMAIN_ID", "0")
        if not given.isdecimal():
            raise BridgeMismatch(f"ROS_DOMAIN_ID is {given!r}, not a whole number")
        return int(given)


def make_transport(config: Ros2Config) -> tuple[Stage, str]:
    """The transport that a configuration asks for, and why it is this one."""
    if config.transport != "auto":
        return _MAKE[config.transport](config), "as asked"
    if os.environ.get("RMW_IMPLEMENTATION") == "rmw_zenoh_cpp" and find_spec("rclpy") is None:
        return _zenoh(config), "RMW_IMPLEMENTATION is rmw_zenoh_cpp"
    if find_spec("rclpy") is not None:
        return _rclpy(config), "ROS is sourced"
    if find_spec("cyclonedds") is not None:
        return _dds(config), "no ROS is sourced"
    if find_spec("zenoh") is not None:
        return _zenoh(config), "neither rclpy nor cyclonedds is installed"
    raise BridgeError("ROS 2 needs the extra 'ros2': pip install \"pelagos[ros2]\", or source a ROS 2 installation")


def _dds(config: Ros2Config) -> Stage:
    from pelagos.bridges.dds import DdsTransport

    return DdsTransport(
        domain=config.domain,
        node=config.node,
        loopback=config.network == "loopback",
        announce=config.announce,
        gid_bytes=GID_BYTES.get(config.distro, 16),
    )


def _zenoh(config: Ros2Config) -> Stage:
    from pelagos.bridges.zenoh_transport import ZenohTransport

    return ZenohTransport(
        domain=config.domain,
        node=config.node,
        hashes=config.distro != "humble",
        loopback=config.network == "loopback",
    )


def _rclpy(config: Ros2Config) -> Stage:
    from pelagos.bridges.rclpy_transport import RclpyTransport

    return RclpyTransport(domain=config.domain, node=config.node)


_MAKE: Final[dict[str, Callable[[Ros2Config], Stage]]] = {"dds": _dds, "zenoh": _zenoh, "rclpy": _rclpy}
