"""Any interface of python-can by its URL, with its bit timing: `pcan://PCAN_USBBUS1?bitrate=250000`."""

from __future__ import annotations

import importlib
import inspect
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qsl, unquote

import can
from can.interfaces import BACKENDS

from omnimate.driver.errors import BusError

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

CLOCK = 8_000_000  # [Hz] on which bit timing is given where the URL has no f_clock; python-can adjusts it
REGISTERS = ("brp", "tseg1", "tseg2", "sjw")  # of the controller, on f_clock
TIMING_KEYS = frozenset({*REGISTERS, "nof_samples", "f_clock", "sample_point"})
EXTRAS = {  # what installs the libraries of an interface
    "udp_multicast": "omnimate[multicast]",
    "slcan": "omnimate[slcan]",
    "gs_usb": "python-can[gs-usb]",
    "cantact": "python-can[cantact]",
}
_URL = re.compile(r"(?P<interface>\w+):(?://)?(?P<channel>[^?]*)(?:\?(?P<query>.*))?")
_DOCUMENTED = re.compile(r":param\s+(?:[^:\n]*?\s)?(\w+)\s*:")


@dataclass(frozen=True, slots=True)
class BusUrl:
    """The parts of a bus's URL."""

    text: str  # URL as it was given
    interface: str  # name of python-can's interface
    channel: str  # channel of the interface; empty for its default
    options: Mapping[str, Any]  # keys and values after the question mark; numbers and booleans are converted

    @property
    def bitrate(self) -> int | None:
        """Bit rate that the URL states [bit/s]; None where it states none."""
        stated = self.options.get("bitrate")
        return stated if type(stated) is int else None

    @classmethod
    def of(cls, text: str) -> BusUrl:
        """Return the parts of `interface:channel?key=value`, also with `//`; raises BusError for others."""
        match = _URL.fullmatch(text)
        if match is None:
            raise BusError(text, "no URL of a bus; expected interface://channel, such as socketcan://can0")
        pairs = parse_qsl(match["query"] or "", keep_blank_values=True)
        keys = [key for key, _ in pairs]
        repeated = next((key for key in keys if keys.count(key) > 1), None)
        if repeated is not None:
            raise BusError(text, f"{repeated} is given twice; expected each key once")
        options = {key: _value(value) for key, value in pairs}
        return cls(text, match["interface"], unquote(match["channel"]), options)


def open_adapter(url: BusUrl, bitrate: int | None) -> can.BusABC:
    """Return a bus of python-can's interface.

    Args:
        url: The interface, its channel, and its keys: those of python-can, and for the bit timing `bitrate`
            with or without `sample_point` [%], or `f_clock` [Hz], `brp`, `tseg1`, `tseg2`, `sjw`.
        bitrate: Bit rate where the URL has none [bit/s]; None for the default of the interface.

    Raises:
        BusError: There is no such interface or key, or what the interface needs is not installed.
        can.CanError: The interface refuses.
    """
    kind = _class_of(url)
    known = _keys_of(kind)
    options = dict(url.options)
    if bitrate is not None and "bitrate" in known and not TIMING_KEYS & options.keys():
        options.setdefault("bitrate", bitrate)
    if url.channel:
        options["channel"] = url.channel
    if TIMING_KEYS & (options.keys() - known):
        options = _with_timing(url, options, known)
    unknown = options.keys() - known
    if unknown:
        expected = ", ".join(sorted(known | (TIMING_KEYS if "timing" in known else set())))
        raise BusError(url.text, f"{url.interface} has no {', '.join(sorted(unknown))}; expected {expected}")
    try:
        return kind(**options)
    except (ImportError, NameError, AttributeError, can.CanInterfaceNotImplementedError) as error:
        # python-can looks for some libraries only now
        raise _not_here(url, error) from error


def _class_of(url: BusUrl) -> type[can.BusABC]:
    if url.interface not in BACKENDS:
        expected = ", ".join(f"{name}://" for name in sorted(BACKENDS))
        raise BusError(url.text, f"unknown interface {url.interface!r}; expected one of {expected}")
    module, name = BACKENDS[url.interface]
    try:
        kind: type[can.BusABC] = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, OSError) as error:
        raise _not_here(url, error) from error
    return kind


def _not_here(url: BusUrl, error: Exception) -> BusError:
    extra = EXTRAS.get(url.interface)
    remedy = f"pip install '{extra}'" if extra else "install the adapter's driver"
    return BusError(url.text, f"what {url.interface} needs is not installed ({error}): {remedy}")


def _keys_of(kind: type[can.BusABC]) -> frozenset[str]:
    """Return the keys that an interface takes: those of its signature, and those that it documents."""
    signature = set(inspect.signature(kind.__init__).parameters) - {"self", "args", "kwargs"}
    text = f"{kind.__doc__}\n{kind.__init__.__doc__}"
    return frozenset(signature | set(_DOCUMENTED.findall(text)) - {"kwargs"})


def _with_timing(url: BusUrl, options: Mapping[str, Any], known: Collection[str]) -> dict[str, Any]:
    """Return the options with one `timing` instead of the keys that describe it; raises BusError."""
    if "timing" not in known:
        raise BusError(
            url.text, f"{url.interface} takes no bit timing; expected bitrate alone, or another adapter"
        )
    given = {key: options[key] for key in options if key in TIMING_KEYS | {"bitrate"}}
    rest = {key: value for key, value in options.items() if key not in given}
    clock = given.pop("f_clock", CLOCK)
    try:
        if given.keys() == {"bitrate", "sample_point"}:
            timing = can.BitTiming.from_sample_point(clock, **given)
        elif set(REGISTERS) <= given.keys() <= {*REGISTERS, "nof_samples"}:
            timing = can.BitTiming(clock, **given)
        else:
            raise BusError(
                url.text,
                f"bit timing of {', '.join(sorted(given))}; expected bitrate and sample_point, or "
                f"{', '.join(REGISTERS)}",
            )
    except (ValueError, TypeError) as error:
        raise BusError(url.text, f"no controller with {clock} Hz has this bit timing: {error}") from error
    return {**rest, "timing": timing}


def _value(text: str) -> Any:  # noqa: ANN401  # a number, a boolean or a word
    if text.lower() in {"true", "false"}:
        return text.lower() == "true"
    for kind in (lambda word: int(word, 0), float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
