"""Meaning and DBC name of each signal: position or speed of a wheel, a joint or a slider."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from omnimate.listen.learning import Findings
    from omnimate.listen.shafts import Shaft
    from omnimate.listen.signals import LearnedSignal
    from omnimate.listen.wheels import Wheel

MAX_NAME_LENGTH = 32  # characters of a DBC name


class Meaning(NamedTuple):
    """Name and meaning of a signal."""

    name: str  # its name, unique in its message
    words: str  # its meaning as a phrase, such as `position of wheel 1`; empty if it is not identified


def meanings_of(findings: Findings) -> dict[str, Meaning]:
    """Return the meanings of all signals by their labels (`LearnedSignal.label`)."""
    known = _of_wheels(findings) | _of_others(findings)
    meanings = {}
    for entry in findings.messages:
        for signal in entry.signals:
            meaning = known.get(signal.label, Meaning("", ""))
            meanings[signal.label] = meaning._replace(name=_name(signal, meaning.name))
    return meanings


def wheel_ratio(wheel: Wheel) -> str:
    """Return the ratio of a wheel's counts to those of wheel 1 as a phrase."""
    if wheel.has_exact_ratio:
        return f"{wheel.ratio:+.4f} counts for each of wheel 1"
    return f"{wheel.ratio:+.2f} counts for each of wheel 1, if that travel was straight"


def _of_wheels(findings: Findings) -> dict[str, Meaning]:
    meanings: dict[str, Meaning] = {}
    wheels = findings.kinematics.wheels
    for number, wheel in enumerate(wheels, start=1):
        assignment = "" if wheel.truck is None else f", truck {wheel.truck + 1}"
        assignment += "" if wheel.side is None else f", side {wheel.side + 1}"
        direction = {1: "counts up forward", -1: "counts down forward", 0: "its direction is not identified"}[
            wheel.forward
        ]
        ratio = f", {wheel_ratio(wheel)}" if number > 1 else ""
        meanings |= _of_shaft(
            wheel.shaft, f"wheel_{number}", f"wheel {number}{assignment}; {direction}{ratio}"
        )
    return meanings


def _of_others(findings: Findings) -> dict[str, Meaning]:
    meanings: dict[str, Meaning] = {}
    counts: dict[str, int] = {}
    wheel_labels = {wheel.shaft.position.signal.label for wheel in findings.kinematics.wheels}
    roles = {other.shaft.position.signal.label: other for other in findings.kinematics.others}
    for shaft in findings.shafts:
        label = shaft.position.signal.label
        if label in wheel_labels:
            continue
        other = roles.get(label)
        is_identified = other is not None and other.role != "cannot tell"
        role = other.role.partition(" ")[0] if other is not None and is_identified else "movement"
        counts[role] = counts.get(role, 0) + 1
        share = (
            f"; the wheels explain {other.share:.0%} of its rate" if other is not None and other.share else ""
        )
        if role == "movement" and not (shaft.rates or shaft.copies):
            continue
        meanings |= _of_shaft(shaft, f"{role}_{counts[role]}", f"{role} {counts[role]}{share}")
    return meanings


def _of_shaft(shaft: Shaft, name: str, words: str) -> dict[str, Meaning]:
    """Return the meanings of the signals of a shaft, called `name` in DBC files and `words` in reports."""
    short = words.partition(",")[0].partition(";")[0]
    meanings = {shaft.position.signal.label: Meaning(name, f"position of {words}")}
    for number, (signal, ratio) in enumerate(shaft.copies, start=2):
        meanings[signal.label] = Meaning(
            f"{name}_again_{number}", f"position of {short} once more, times {ratio:.5g}"
        )
    for number, (signal, factor, share) in enumerate(shaft.rates, start=1):
        speed = f"speed of {short}, or in proportion to it: {factor:.5g} for each count/s"
        meanings[signal.label] = Meaning(
            f"{name}_speed_{number}", f"{speed}; it explains {share:.1%} of the variance"
        )
    return meanings


def _name(signal: LearnedSignal, meaning: str) -> str:
    """Return the DBC name from the object, else from the meaning, else from the kind, with the start bit."""
    known = re.sub(r"\W+", "_", signal.name.partition(" ")[2] or signal.name.partition(".")[2]).strip("_")
    kind = signal.kind.replace(" ", "_") if signal.kind != "cannot tell" else "unknown"
    stem = known or meaning or kind
    end = f"_{signal.start}" + ("" if signal.multiplexor_value is None else f"_m{signal.multiplexor_value}")
    return stem[: MAX_NAME_LENGTH - len(end)] + end
