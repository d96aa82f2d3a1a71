"""Meaning and DBC name of each signal: position or speed of a wheel, a joint or a slider."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.listen.learning import Findings
    from omnimate.listen.shafts import Shaft
    from omnimate.listen.signals import LearnedSignal
    from omnimate.listen.wheels import Wheel

MAX_NAME_LENGTH = 32  # characters of a DBC name


class Meaning(NamedTuple):
    """Name and meaning of a signal.

    Attributes:
        name: Its name, unique in its message.
        words: Its meaning as a phrase; empty if it is not identified.
    """

    name: str
    words: str


def meanings_of(findings: Findings) -> dict[str, Meaning]:
    """Return the meanings of all signals by label."""
    words = dict(_of_wheels(findings)) | dict(_of_others(findings))
    return {
        signal.label: Meaning(
            _name(signal, words.get(signal.label, ("", ""))[0]), words.get(signal.label, ("", ""))[1]
        )
        for entry in findings.messages
        for signal in entry.signals
    }


def wheel_ratio(wheel: Wheel) -> str:
    """Return the ratio of a wheel's counts to those of wheel 1 in words."""
    if wheel.has_exact_ratio:
        return f"{wheel.ratio:+.4f} counts for each of wheel 1"
    return f"{wheel.ratio:+.2f} counts for each of wheel 1, if that travel was straight"


def _of_wheels(findings: Findings) -> Mapping[str, tuple[str, str]]:
    phrases: dict[str, tuple[str, str]] = {}
    wheels = findings.kinematics.wheels
    for number, wheel in enumerate(wheels, start=1):
        where = "" if wheel.truck is None else f", truck {wheel.truck + 1}"
        where += "" if wheel.side is None else f", side {wheel.side + 1}"
        direction = {1: "counts up forward", -1: "counts down forward", 0: "its direction is not identified"}[
            wheel.forward
        ]
        ratio = f", {wheel_ratio(wheel)}" if number > 1 else ""
        phrases |= _of_shaft(wheel.shaft, f"wheel_{number}", f"wheel {number}{where}; {direction}{ratio}")
    return phrases


def _of_others(findings: Findings) -> Mapping[str, tuple[str, str]]:
    phrases: dict[str, tuple[str, str]] = {}
    counts: dict[str, int] = {}
    wheel_labels = {wheel.shaft.position.signal.label for wheel in findings.kinematics.wheels}
    roles = {other.shaft.position.signal.label: other for other in findings.kinematics.others}
    for shaft in findings.shafts:
        label = shaft.position.signal.label
        if label in wheel_labels:
            continue
        other = roles.get(label)
        role = (
            other.role.partition(" ")[0] if other is not None and other.role != "cannot tell" else "movement"
        )
        counts[role] = counts.get(role, 0) + 1
        share = (
            f"; the wheels explain {other.share:.0%} of its rate" if other is not None and other.share else ""
        )
        if role == "movement" and not (shaft.rates or shaft.same):
            continue
        phrases |= _of_shaft(shaft, f"{role}_{counts[role]}", f"{role} {counts[role]}{share}")
    return phrases


def _of_shaft(shaft: Shaft, name: str, words: str) -> dict[str, tuple[str, str]]:
    plain = words.partition(",")[0].partition(";")[0]
    phrases = {shaft.position.signal.label: (name, f"position of {words}")}
    for number, (signal, ratio) in enumerate(shaft.same, start=2):
        phrases[signal.label] = (
            f"{name}_again_{number}",
            f"position of {plain} once more, times {ratio:.5g}",
        )
    for number, (signal, factor, share) in enumerate(shaft.rates, start=1):
        speed = f"speed of {plain}, or in proportion to it: {factor:.5g} for each count/s"
        phrases[signal.label] = (
            f"{name}_speed_{number}",
            f"{speed}; it explains {share:.1%} of the variance",
        )
    return phrases


def _name(signal: LearnedSignal, meaning: str) -> str:
    known = re.sub(r"\W+", "_", signal.name.partition(" ")[2] or signal.name.partition(".")[2]).strip("_")
    kind = signal.kind.replace(" ", "_") if signal.kind != "cannot tell" else "unknown"
    stem = known or meaning or kind
    end = f"_{signal.start}" + ("" if signal.switch is None else f"_m{signal.switch}")
    return stem[: MAX_NAME_LENGTH - len(end)] + end
