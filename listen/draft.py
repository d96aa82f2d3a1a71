"""Draft of a `vehicle.toml` from the findings, with comments on what remains to be done."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from omnimate.listen.meanings import wheel_ratio
from omnimate.listen.signals import SURE_PROBABILITY
from omnimate.vehicle.drafting import bus_lines, geometry_lines, known_line, unknown_line

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.listen.learning import Findings
    from omnimate.listen.shafts import Shaft
    from omnimate.listen.wheels import Wheel

Turn = Literal["left", "right"]
HEAD = """\
# Drafted by `omnimate listen`. What the bus did not show is commented out: do what the comment says, and
# remove the #. `omnimate record --vehicle` names the first key that is missing."""


def draft_vehicle(findings: Findings, bitrate: int | None, turn: Turn | None) -> str:
    """Return the text of the draft.

    Args:
        findings: Results of the analysis.
        bitrate: Bit rate of the bus [bit/s]; None if not known.
        turn: Direction of the first clear turn in the log (`Kinematics.turn_starts`); None if not known.
    """
    wheels = findings.kinematics.wheels
    bus = bus_lines(bitrate, findings.network.sync_period)
    lines = [HEAD, "", 'name = "robot"', *geometry_lines(has_two=len(wheels) > 2), *bus]
    if not wheels:
        lines += ["", *(f"# {reason}" for reason in findings.kinematics.reasons)]
        lines += ["# Listen again while the robot drives straight on, turns in both directions, and stands."]
    for number, wheel in enumerate(wheels, start=1):
        lines += _wheel_lines(number, wheel, findings, turn)
    for other in findings.kinematics.others:
        if other.role != "cannot tell":
            lines += _joint_or_slider_lines(other.role, other.shaft, findings)
    return "\n".join([*lines, ""])


def _wheel_lines(number: int, wheel: Wheel, findings: Findings, turn: Turn | None) -> Iterator[str]:
    ratio = f": {wheel_ratio(wheel)}, driving straight" if number > 1 else ""
    yield from ("", f"# wheel {number}{ratio}")
    if wheel.shaft.position.signal.is_big_endian:
        can_id = wheel.shaft.position.signal.can_id
        yield f"# COB-ID {can_id:03X}h is big-endian, which an [[encoder]] cannot describe"
        return
    yield "[[encoder]]"
    yield _channel_line(wheel, findings, turn)
    yield from _signal_lines(wheel.shaft, findings)
    if wheel.forward:
        yield known_line("sign", str(wheel.forward), "the direction that the robot mostly drove is forward")
    else:
        yield unknown_line("sign", "1", "1 or -1, so that a wheel that rolls forward counts up")
    yield unknown_line(
        "counts_per_turn", "4096", "turn the wheel once by hand and see how far it counts, or its data sheet"
    )


def _channel_line(wheel: Wheel, findings: Findings, turn: Turn | None) -> str:
    kinematics = findings.kinematics
    trucks = "a" if len(kinematics.wheels) == 2 else "ab"
    if (
        turn is not None
        and wheel.side is not None
        and wheel.truck is not None
        and kinematics.outer_side is not None
    ):
        # In a turn to the left the right side is the outer one.
        side = "right" if (wheel.side == kinematics.outer_side) == (turn == "left") else "left"
        if trucks == "a" or kinematics.front is not None:
            trucks = trucks if kinematics.front != 1 else "ba"
            return known_line(
                "channel",
                f'"a.{side}"',
                f"the turn at {kinematics.turn_starts[0] - findings.start:.1f} s went {turn}",
            )
        return unknown_line(
            "channel",
            f'"{trucks[wheel.truck]}.{side}"',
            f"or {trucks[1 - wheel.truck]}.{side}: a is the truck in front",
        )
    what = "see which wheel counts when it is turned, or listen again with --turn"
    guess = "a.left" if wheel.side in {None, 0} else "a.right"
    return unknown_line("channel", f'"{guess}"', what)


def _joint_or_slider_lines(role: str, shaft: Shaft, findings: Findings) -> Iterator[str]:
    if shaft.position.signal.is_big_endian:
        return
    yield from ("", "[[encoder]]")
    if role == "slider":
        yield known_line("channel", '"link"', "it follows the difference of the trucks' speeds")
    elif (front := findings.kinematics.front) is not None:
        truck = "a" if role.endswith(str(front + 1)) else "b"
        yield known_line("channel", f'"joint_{truck}"', f"it follows the wheels of truck {role[-1]}")
    else:
        yield unknown_line("channel", '"joint_a"', f"or joint_b: {role}, whichever is in front")
    yield from _signal_lines(shaft, findings)
    what = "a longer linkage" if role == "slider" else "a truck that turns left"
    yield unknown_line("sign", "1", f"1 or -1, so that {what} counts up")
    scale = "counts_per_metre" if role == "slider" else "counts_per_turn"
    yield unknown_line(scale, "4096", "its data sheet")
    zero = "at linkage.length" if role == "slider" else "where truck and linkage are in line"
    yield unknown_line("zero", "0", f"the count {zero}")


def _signal_lines(shaft: Shaft, findings: Findings) -> Iterator[str]:
    signal = shaft.position.signal
    sending = next(entry.sending for entry in findings.messages if entry.message.can_id == signal.can_id)
    if signal.node:
        yield known_line("node", str(signal.node))
    else:
        yield unknown_line("node", "1", "no heartbeat shows the sender of this COB-ID")
    yield known_line(
        "cob_id", f"0x{signal.can_id:03X}", f"sent by {sending.cause}, every {1e3 * sending.period:.1f} ms"
    )
    sure = (
        ""
        if signal.boundaries_probability >= SURE_PROBABILITY
        else f"P = {signal.boundaries_probability:.2f}; see the report"
    )
    yield known_line("start_bit", str(signal.start), sure)
    yield known_line("bits", str(signal.bits), sure)
    if signal.signed is None:
        yield known_line("signed", "true", "not shown by the bus; differences are the same with both signs")
    else:
        yield known_line("signed", "true" if signal.signed else "false")
    if signal.counter_range:
        yield known_line("range", str(signal.counter_range), "it started again there")
