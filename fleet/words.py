"""What a night shows, in words: sizes in % and degrees, with their 95 % intervals."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from omnimate.fleet.joints import JOINT_NUMBERS

if TYPE_CHECKING:
    from omnimate.fleet.morning import BadPlace, Change


def since(change: Change) -> str:
    """Return since when, with the other days on which it may have begun."""
    if change.earliest == change.latest == change.since:
        return change.since
    return f"{change.since} ({change.earliest} to {change.latest})"


def size(change: Change) -> str:
    """Return by how much, with its 95 % interval, in % or degrees."""
    factor, unit = shown_unit(change.name)
    return f"{factor * change.size:+.3f} +- {1.96 * factor * change.sigma:.3f} {unit}"


def speed(change: Change) -> str:
    """Return how much worse it gets in a day."""
    factor, unit = shown_unit(change.name)
    return f"{factor * change.per_day:+.3f} {unit}" if change.shape == "ramp" else "no more"


def what(place: BadPlace) -> str:
    """Return what happens on a place, with the direction of a creep."""
    if place.effect == "loss":
        return "way is lost"
    return f"robots creep to {math.degrees(math.atan2(place.size[1], place.size[0])):.0f} degrees"


def of_robot(change: Change) -> str:
    """Return a robot's change as a sentence."""
    worse = f", {speed(change)} a day" if change.shape == "ramp" else ""
    return f"{change.robot}: {change.name} changed by {size(change)} since {since(change)}{worse}"


def of_place(place: BadPlace) -> str:
    """Return a bad place as a sentence."""
    on = f"floor {place.floor}, " if place.floor else ""
    return (
        f"{on}at x {place.x:.2f} m, y {place.y:.2f} m: {what(place)}, {1e3 * place.per_crossing:.1f} mm in a "
        f"crossing, {place.crossings} crossings"
    )


def shown_unit(name: str) -> tuple[float, str]:
    """Return by what a number is multiplied to be shown, and the unit in which it is shown then."""
    return (math.degrees(1.0), "degrees") if name in JOINT_NUMBERS else (100.0, "%")
