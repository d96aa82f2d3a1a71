"""Chooses the range by which a counter is unwrapped, from `vehicle.toml` and the device's object 6002h."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Encoder


def choose_range(encoder: Encoder, reported: int | None) -> tuple[int, str]:
    """Return the range by which a channel is unwrapped [counts], and the reason in words.

    6002h means N for some vendors, N - 1 for others, and 0 means 2**32 for one.

    Args:
        encoder: Encoder as `vehicle.toml` describes it.
        reported: Value of 6002h in the device; None where the device has no such object.
    """
    stated, full = encoder.wrap_range, 2**encoder.bits
    name = encoder.channel
    if reported is None:
        return stated, f"{name}: wraps at {stated}; the device has no 6002h"
    if reported == stated:
        return stated, f"{name}: wraps at {stated}; 6002h says so and means N"
    if reported == stated - 1:
        return stated, f"{name}: wraps at {stated}; 6002h says {reported} and means N - 1"
    if reported == 0 and full == 2**32 and encoder.range is None:
        return full, f"{name}: wraps at 2**32; 6002h says 0"
    guess = reported + reported % 2
    if encoder.range is not None or not 1 < guess <= full:
        return (
            stated,
            f"{name}: 6002h says {reported}, but vehicle.toml {stated}, which is used: check it",
        )
    means = "N - 1" if reported % 2 else "N"
    return (
        guess,
        f"{name}: wraps at {guess}; 6002h says {reported}, taken for {means}; vehicle.toml says nothing",
    )
