"""Opens a bus from its URL, with an answer within seconds where nothing is there."""

from __future__ import annotations

import importlib.util
import logging
import socket
from typing import TYPE_CHECKING
from urllib.parse import SplitResult, urlsplit

import can

from omnimate.driver.errors import BusError, in_one_line
from omnimate.driver.socketcand_bus import RobustSocketcandBus
from omnimate.driver.virtual_bus import FastVirtualBus

if TYPE_CHECKING:
    from collections.abc import Callable

PROBE_TIMEOUT = 2.0  # [s]
DEFAULT_PORT = 29536  # of socketcand
DEFAULT_BITRATE = 500_000
SCHEMES = "virtual://name, socketcan://can0, socketcand://host:port/can0, slcan:///dev/ttyACM0@500000"

# python-can writes every incomplete TCP segment as a warning; what matters is raised or counted here.
logging.getLogger("can").addHandler(logging.NullHandler())


def open_bus(url: str) -> can.BusABC:
    """Return the bus that a URL names.

    Args:
        url: One of `virtual://name`, `socketcan://can0`, `socketcand://host:port/can0`,
            `slcan:///dev/ttyACM0@500000`.

    Raises:
        BusError: The scheme is unknown, nothing answers, or the interface refuses.
    """
    try:
        parts = urlsplit(url)
        opener = _OPENERS.get(parts.scheme)
        if opener is None:
            raise BusError(url, f"unknown scheme {parts.scheme!r}; expected one of {SCHEMES}")
        return opener(url, parts)
    except (can.CanError, OSError, ValueError) as error:
        raise BusError(
            url, f"cannot be opened: {in_one_line(error)}; check the URL, and that the adapter is connected"
        ) from error


def _virtual(_url: str, parts: SplitResult) -> can.BusABC:
    return FastVirtualBus(channel=parts.netloc or parts.path.lstrip("/") or "omnimate")


def _socketcan(url: str, parts: SplitResult) -> can.BusABC:
    if parts.netloc not in {name for _, name in socket.if_nameindex()}:
        raise BusError(
            url,
            f"no network interface {parts.netloc!r}; expected a CAN interface that is up: "
            f"ip link set {parts.netloc or 'can0'} up type can bitrate {DEFAULT_BITRATE}",
        )
    return can.Bus(interface="socketcan", channel=parts.netloc)


def _slcan(url: str, parts: SplitResult) -> can.BusABC:
    if importlib.util.find_spec("serial") is None:
        raise BusError(url, "slcan needs pyserial: pip install 'omnimate[slcan]'")
    device, _, bitrate = (parts.netloc + parts.path).partition("@")
    return can.Bus(interface="slcan", channel=device, bitrate=int(bitrate or DEFAULT_BITRATE))


def _socketcand(url: str, parts: SplitResult) -> can.BusABC:
    host, port = parts.hostname, parts.port or DEFAULT_PORT
    if host is None:
        raise BusError(url, "no host; expected socketcand://host:port/can0")
    _probe(url, host, port)
    channel = parts.path.strip("/") or "can0"
    try:
        return RobustSocketcandBus(channel=channel, host=host, port=port, tcp_tune=True)  # type: ignore[no-untyped-call]  # python-can
    except can.CanError as error:
        raise BusError(
            url, f"the server refuses channel {channel!r} ({error}); expected a channel that it serves"
        ) from error


def _probe(url: str, host: str, port: int) -> None:
    """Check that a socketcand server greets; python-can would spin for ten seconds, or wait for ever."""
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


_OPENERS: dict[str, Callable[[str, SplitResult], can.BusABC]] = {
    "virtual": _virtual,
    "socketcan": _socketcan,
    "socketcand": _socketcand,
    "slcan": _slcan,
}
