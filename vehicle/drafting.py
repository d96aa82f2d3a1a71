"""Lines of a drafted `vehicle.toml`: values known from a bus, and instructions for the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

_COLUMN = 34  # where a comment begins


def known_line(key: str, value: str, comment: str = "") -> str:
    """Return the line of a key whose value is known."""
    line = f"{key} = {value}"
    return f"{line:<{_COLUMN}} # {comment}" if comment else line


def unknown_line(key: str, example: str, what: str) -> str:
    """Return the commented line of an unknown key, with instructions."""
    line = f"# {key} = {example}"
    return f"{line:<{_COLUMN}} # {what}"


def geometry_lines(*, has_two: bool) -> Iterator[str]:
    """Yield the tables of one truck, or of two and their linkage, to be measured."""
    for truck in ("a", "b") if has_two else ("a",):
        yield from ("", f"[truck.{truck}]")
        yield unknown_line(
            "wheelbase", "0.340", "[m] measure between the contact points of the two drive wheels"
        )
        yield unknown_line("wheel_diameter_left", "0.150", "[m] measure, or roll the wheel along a tape")
        yield unknown_line("wheel_diameter_right", "0.150", "[m] as above; UMBmark finds the difference")
    if has_two:
        yield from ("", "[linkage]")
        yield unknown_line("length", "1.000", "[m] measure between the trucks' centres")


def bus_lines(bitrate: int | None, sync_period: float | None) -> Iterator[str]:
    """Yield the table of the bus; bit rate [bit/s] and measured period of SYNC [s] are None where unknown."""
    yield from ("", "[bus]")
    if bitrate is None:
        yield unknown_line("bitrate", "500000", "[bit/s] that of the adapter: ip -details link show can0")
    else:
        yield known_line("bitrate", str(bitrate))
    if sync_period is None:
        yield unknown_line("sync_period", "0.015", "[s] choose: nobody sends SYNC, the driver will")
    else:
        yield known_line("sync_period", f"{sync_period:.4g}", "SYNC as it was heard")
