"""What each signal is of: a wheel, its speed, a joint; and a name for it that DBC files take."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.listen.learning import Findings
    from omnimate.listen.shafts import Shaft
    from omnimate.listen.signals import LearnedSignal
    from omnimate.listen.wheels import Wheel

LONGEST = 32  # characters of a DBC name


class Meaning(NamedTuple):
    """What a signal is of.

    Attributes:
        name: Its name, which no other signal of its message has.
        words: What it is, as a sentence; empty where that is not identified.
    """

    name: str
    words: str


def meanings_of(findings: Findings) -> dict[str, Meaning]:
    """Return what each signal is of, by its label."""
    words = dict(_of_wheels(findings)) | dict(_of_others(findings))
    return {
        signal.label: Meaning(
            _name(signal, words.get(signal.label, ("", ""))[0]), words.get(signal.label, ("", ""))[1]
        )
        for each in findings.messages
        for signal in each.signals
    }


def wheel_ratio(wheel: Wheel) -> str:
    """Return the ratio of a wheel's counts to those of wheel 1 in words."""
    if wheel.has_exact_ratio:
        return f"{wheel.ratio:+.4f} counts for each of wheel 1"
    return f"{wheel.ratio:+.2f} counts for each of wheel 1, if that travel was straight"


def _of_wheels(findings: Findings) -> Mapping[str, tuple[str, str]]:
    found: dict[str, tuple[str, str]] = {}
    wheels = findings.kinematics.wheels
    for number, wheel in enumerate(wheels, start=1):
        where = "" if wheel.truck is None else f", truck {wheel.truck + 1}"
        where += "" if wheel.side is None else f", side {wheel.side + 1}"
        way = {1: "counts up forward", -1: "counts down forward", 0: "its direction is not identified"}[
            wheel.forward
        ]
        ratio = f", {wheel_ratio(wheel)}" if number > 1 else ""
        found |= _of_shaft(wheel.shaft, f"wheel_{number}", f"wheel {number}{where}; {way}{ratio}")
    return found


def _of_others(findings: Findings) -> Mapping[str, tuple[str, str]]:
    found: dict[str, tuple[str, str]] = {}
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
        found |= _of_shaft(shaft, f"{role}_{counts[role]}", f"{role} {counts[role]}{share}")
    return found


def _of_shaft(shaft: Shaft, name: str, words: str) -> dict[str, tuple[str, str]]:
    plain = words.partition(",")[0].partition(";")[0]
    found = {shaft.position.signal.label: (name, f"position of {words}")}
    for number, (signal, ratio) in enumerate(shaft.same, start=2):
        found[signal.label] = (f"{name}_again_{number}", f"position of {plain} once more, times {ratio:.5g}")
    for number, (signal, factor, share) in enumerate(shaft.rates, start=1):
        speed = f"speed of {plain}, or in proportion to it: {factor:.5g} for each count/s"
        found[signal.label] = (f"{name}_speed_{number}", f"{speed}; it explains {share:.1%} of the variance")
    return found


def _name(signal: LearnedSignal, meaning: str) -> str:
    known = re.sub(r"\W+", "_", signal.name.partition(" ")[2] or signal.name.partition(".")[2]).strip("_")
    kind = signal.kind.replace(" ", "_") if signal.kind != "cannot tell" else "unknown"
    stem = known or meaning or kind
    end = f"_{signal.start}" + ("" if signal.switch is None else f"_m{signal.switch}")
    return stem[: LONGEST - len(end)] + end
