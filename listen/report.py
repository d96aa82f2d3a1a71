"""Report of the findings as text of 80 columns, and as JSON."""

from __future__ import annotations

import textwrap
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from omnimate.listen.dbc import dbc_start
from omnimate.listen.signals import SURE_PROBABILITY

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.listen.learning import Findings, LearnedMessage
    from omnimate.listen.meanings import Meaning
    from omnimate.listen.network import Network, Node
    from omnimate.listen.signals import LearnedSignal

WIDTH = 80  # [characters] of a line


def report_lines(findings: Findings, meanings: dict[str, Meaning], *, reasons: bool = True) -> Iterator[str]:
    """Yield the lines of the report, with the names of `meanings_of`, and `reasons` if wanted."""
    yield f"{findings.frames} frames in {findings.seconds:.1f} s; nothing was sent"
    yield from _network(findings.network)
    yield ""
    yield "Wheels"
    for reason in findings.kinematics.reasons:
        yield from _wrapped(reason, 2)
    if findings.kinematics.turn_starts:
        times = ", ".join(f"{turn - findings.start:.1f} s" for turn in findings.kinematics.turn_starts)
        yield from _wrapped(
            f"clear turns begin at {times}; --turn left or right gives the direction of the first", 2
        )
    for learned in findings.messages:
        yield ""
        yield from _message(learned, meanings, reasons=reasons)
    changing = [s for learned in findings.messages for s in learned.signals if s.kind != "constant"]
    sure = sum(signal.is_sure for signal in changing)
    yield ""
    limit = f"P of at least {SURE_PROBABILITY:g}"
    yield f"{len(changing)} signals that change, of which {sure} are sure ({limit})"


def _network(network: Network) -> Iterator[str]:
    if network.sync_period is not None:
        counter = f", counter up to {network.sync_overflow}" if network.sync_overflow else ""
        yield (
            f"SYNC every {1e3 * network.sync_period:.3f} ms, "
            f"jitter {1e3 * network.sync_jitter:.3f} ms{counter}"
        )
    else:
        yield "no SYNC"
    if network.time_stamps:
        yield f"TIME: {network.time_stamps} times"
    for words, count in network.commands.items():
        yield f"NMT {words}: {count} times"
    if not network.nodes:
        yield "no CANopen node: no heartbeat, no boot-up, no SDO answer"
    for node in network.nodes.values():
        yield from _wrapped(_node(node), 0)


def _node(node: Node) -> str:
    parts = []
    if node.profile:
        parts.append(f"CiA {node.profile}")
    if node.states:
        parts.append(", then ".join(node.states))
    if node.heartbeat is not None:
        parts.append(f"heartbeat every {1e3 * node.heartbeat:.0f} ms")
    if node.is_guarded:
        parts.append("guarded by a master")
    if node.asked:
        parts.append(f"{node.asked} SDO requests")
    parts += [f"EMCY {words}, {count} times" for words, count in node.emergencies.items()]
    return f"node {node.number}: {'; '.join(parts) or 'seen in SDO traffic only'}"


def _message(learned: LearnedMessage, meanings: dict[str, Meaning], *, reasons: bool) -> Iterator[str]:
    message = learned.message
    identifier = f"{message.can_id:08X}" if message.is_extended else f"{message.can_id:03X}"
    name = "" if message.name == identifier else f", {message.name}"
    yield f"{identifier}{name}: {message.data.shape[1]} bytes, {len(message.time)} frames"
    yield f"  {_sending(learned)}"
    if message.other_lengths:
        yield f"  {message.other_lengths} frames of another length are left out"
    yield f"  {'bits':<9}{'order':<8}{'kind':<14}{'sign':<13}{'P':>6}  name"
    shown: int | None = None
    for signal in learned.signals:
        if signal.multiplexor_value not in {shown, None}:
            yield f"  where the multiplexor is {signal.multiplexor_value}:"
        shown = signal.multiplexor_value
        meaning = meanings[signal.label]
        yield _row(signal, meaning)
        if meaning.words:
            yield from _wrapped(meaning.words, 6)
        if reasons:
            for reason in signal.reasons:
                yield from _wrapped(f"- {reason}", 6)


def _sending(learned: LearnedMessage) -> str:
    sending = learned.sending
    if len(learned.message.time) < 2:
        return "sent once; what triggers it is not identified"
    if sending.cause == "SYNC":
        syncs = "every SYNC" if sending.every == 1 else f"one of {sending.every} SYNCs"
        return (
            f"{1e3 * sending.delay:.2f} ms after {syncs}, "
            f"jitter {1e3 * sending.jitter:.2f} ms (P = {sending.probability:.3f})"
        )
    period = f"every {1e3 * sending.period:.1f} ms, jitter {1e3 * sending.jitter:.2f} ms"
    if sending.cause == "cannot tell":
        return f"{period}; what triggers it is not identified"
    cause = "by a timer" if sending.cause == "timer" else "when its data change, at most"
    return f"{cause} {period} (P = {sending.probability:.3f})"


def _row(signal: LearnedSignal, meaning: Meaning) -> str:
    bits = f"{signal.start}-{signal.start + signal.bits - 1}"
    order = (
        "-" if signal.bits <= 8 or signal.kind == "constant" else "big" if signal.is_big_endian else "little"
    )
    sign = "-"
    if signal.kind == "number":
        sign = {True: "signed", False: "unsigned", None: "cannot tell"}[signal.signed]
    if signal.counter_range:
        sign = f"mod {signal.counter_range}"
    probability = signal.boundaries_probability * signal.kind_probability
    sure = "-" if signal.kind == "constant" else "sure" if signal.is_sure else f"{probability:.2f}"
    return f"  {bits:<9}{order:<8}{signal.kind:<14}{sign:<13}{sure:>6}  {meaning.name}"[:WIDTH]


def _wrapped(text: str, indent: int) -> list[str]:
    return textwrap.wrap(
        text, WIDTH, initial_indent=" " * indent, subsequent_indent=" " * (indent + 2), break_long_words=False
    )


def findings_as_json(findings: Findings, meanings: dict[str, Meaning]) -> dict[str, Any]:
    """Return the findings as dictionaries and lists that can be written as JSON; times in seconds."""
    network = findings.network
    return {
        "frames": findings.frames,
        "seconds": findings.seconds,
        "sync": None
        if network.sync_period is None
        else {
            "period": network.sync_period,
            "jitter": network.sync_jitter,
            "overflow": network.sync_overflow,
        },
        "time_stamps": network.time_stamps,
        "nmt_commands": dict(network.commands),
        "nodes": [asdict(node) for node in network.nodes.values()],
        "messages": [_message_as_json(learned, meanings) for learned in findings.messages],
        "wheels": [
            {
                "signal": meanings[wheel.shaft.position.signal.label].name,
                "can_id": wheel.shaft.position.signal.can_id,
                "ratio": wheel.ratio,
                "ratio_spread": wheel.spread,
                "truck": wheel.truck,
                "side": wheel.side,
                "forward": wheel.forward or None,
            }
            for wheel in findings.kinematics.wheels
        ],
        "others": [
            {
                "signal": meanings[other.shaft.position.signal.label].name,
                "can_id": other.shaft.position.signal.can_id,
                "role": other.role,
                "explained": other.share,
            }
            for other in findings.kinematics.others
        ],
        "front_truck": findings.kinematics.front,
        "wheel_reasons": list(findings.kinematics.reasons),
        "turns": [turn - findings.start for turn in findings.kinematics.turn_starts],
    }


def _message_as_json(learned: LearnedMessage, meanings: dict[str, Meaning]) -> dict[str, Any]:
    message = learned.message
    return {
        "can_id": message.can_id,
        "extended": message.is_extended,
        "node": message.node or None,
        "name": message.name,
        "length": message.data.shape[1],
        "frames": len(message.time),
        "sending": asdict(learned.sending),
        "signals": [
            {
                "name": meanings[signal.label].name,
                "start_bit": dbc_start(signal),
                "bits": signal.bits,
                "byte_order": "big" if signal.is_big_endian else "little",
                "kind": signal.kind,
                "signed": signal.signed,
                "range": signal.counter_range or None,
                "multiplexor": signal.multiplexor_value,
                "sure": signal.is_sure,
                "boundaries_probability": signal.boundaries_probability,
                "kind_probability": signal.kind_probability,
                "meaning": meanings[signal.label].words,
                "reasons": list(signal.reasons),
            }
            for signal in learned.signals
        ],
    }
