"""Opens a bus from its URL; where no server answers, that is an error within seconds."""

from __future__ import annotations

import logging
import socket
from dataclasses import replace
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import can
from can.interfaces.socketcan import SocketcanBus

from omnimate.driver.bus.adapters import BusUrl, open_adapter
from omnimate.driver.bus.interfaces import FastVirtualBus, RobustSocketcandBus, StampedSocket
from omnimate.driver.errors import BusError, BusLost, in_one_line

if TYPE_CHECKING:
    from collections.abc import Callable

PROBE_TIMEOUT = 2.0  # [s] to wait for a server's greeting
DEFAULT_PORT = 29536  # of socketcand, by its README
DEFAULT_BITRATE = 500_000  # [bit/s] in the advice for an interface that is down

# python-can writes every incomplete TCP segment as a warning; what matters is raised or counted here.
logging.getLogger("can").addHandler(logging.NullHandler())


def open_bus(url: str, bitrate: int | None = None) -> can.BusABC:
    """Return the bus that a URL names.

    Args:
        url: `interface://channel?key=value` with any interface of python-can and its keys, such as
            `socketcan://can0`, `socketcand://host:port/can0`, `slcan:///dev/ttyACM0@500000`,
            `virtual://name`, `pcan://PCAN_USBBUS1?bitrate=250000&sample_point=87.5`.
        bitrate: Bit rate where the URL has none and the interface needs one [bit/s].

    Raises:
        BusError: There is no such interface or key, nothing answers, or the interface refuses.
    """
    try:
        parts = BusUrl.of(url)
        opener = _OPENERS.get(parts.interface)
        return open_adapter(parts, bitrate) if opener is None else opener(parts, bitrate)
    except (can.CanError, OSError, ValueError, TypeError) as error:
        raise BusError(
            url, f"cannot be opened: {in_one_line(error)}; check the URL, and that the adapter is connected"
        ) from error


def receive(bus: can.BusABC, timeout: float) -> can.Message | None:
    """Return the next frame of a bus, None after `timeout` [s]; raises BusLost where the interface fails."""
    try:
        return bus.recv(timeout)
    except (can.CanError, OSError) as error:
        raise BusLost(error) from error


def _virtual(url: BusUrl, _bitrate: int | None) -> can.BusABC:
    if url.options:
        return open_adapter(url, None)
    return FastVirtualBus(channel=url.channel or "omnimate")


def _socketcan(url: BusUrl, _bitrate: int | None) -> can.BusABC:
    rate = url.options.get("bitrate", DEFAULT_BITRATE)
    up = f"ip link set {url.channel or 'can0'} up type can bitrate {rate}"
    if url.channel not in {name for _, name in socket.if_nameindex()}:
        raise BusError(
            url.text,
            f"no network interface {url.channel!r}; expected a CAN interface that is up: {up}",
        )
    if "bitrate" in url.options:
        raise BusError(url.text, f"Linux sets the bit rate of socketcan, not this URL; use {up}")
    bus = open_adapter(url, None)
    if isinstance(bus, SocketcanBus):
        bus.socket = StampedSocket.take_over(bus.socket)
    return bus


def _slcan(url: BusUrl, bitrate: int | None) -> can.BusABC:
    device, _, rate = url.channel.partition("@")
    options = {"bitrate": int(rate)} if rate else {}
    return open_adapter(replace(url, channel=device, options=options | dict(url.options)), bitrate)


def _socketcand(url: BusUrl, _bitrate: int | None) -> can.BusABC:
    parts = urlsplit(f"//{url.channel}")
    host, port = parts.hostname, parts.port or DEFAULT_PORT
    if host is None:
        raise BusError(url.text, "no host; expected socketcand://host:port/can0")
    _probe(url.text, host, port)
    channel = parts.path.strip("/") or "can0"
    try:
        return RobustSocketcandBus(channel=channel, host=host, port=port, tcp_tune=True)  # type: ignore[no-untyped-call]  # python-can
    except can.CanError as error:
        raise BusError(
            url.text, f"the server refuses channel {channel!r} ({error}); expected a channel that it serves"
        ) from error


def _probe(url: str, host: str, port: int) -> None:
    """Check that a socketcand server greets; python-can would spin for ten seconds, or wait without end."""
    try:
        with socket.create_connection((host, port), timeout=PROBE_TIMEOUT) as probe:
            probe.settimeout(PROBE_TIMEOUT)
            greeting = probe.recv(16)
    except OSError as error:
        raise BusError(
            url, f"no answer from {host} port {port} ({error}); is the socketcand server running there?"
        ) from error
    if not greeting.startswith(b"< hi"):
        raise BusError(
            url,
            f"{host} port {port} does not speak socketcand; expected '< hi', got {greeting!r}: "
            "check host and port",
        )


_OPENERS: dict[str, Callable[[BusUrl, int | None], can.BusABC]] = {
    "virtual": _virtual,
    "socketcan": _socketcan,
    "socketcand": _socketcand,
    "slcan": _slcan,
}
