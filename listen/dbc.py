"""What was learned as a DBC file: every message, every signal in raw counts, and why as comments."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.files.logs.dbc import head_lines, heartbeat_message, node_name, state_names
from omnimate.files.logs.dbc_reading import EXTENDED_KEY

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.listen.learning import Findings, LearnedMessage
    from omnimate.listen.meanings import Meaning
    from omnimate.listen.signals import LearnedSignal

_NOBODY = "Vector__XXX"  # what DBC files write where no node is known


def learned_dbc(findings: Findings, meanings: dict[str, Meaning]) -> str:
    """Return the text of the DBC file; an unidentified sign is written as unsigned."""
    nodes = sorted(findings.network.nodes)
    lines = head_lines(map(node_name, nodes))
    for each in findings.messages:
        lines += _message(each, meanings)
    lines += [heartbeat_message(node, _NOBODY) for node in nodes]
    for each in findings.messages:
        lines += _comments(each, meanings)
    lines += map(state_names, nodes)
    for each in findings.messages:
        floats = [signal for signal in each.signals if signal.kind == "float"]
        lines += [f"SIG_VALTYPE_ {_key(each)} {meanings[signal.label].name} : 1;" for signal in floats]
    return "\n".join([*lines, ""])


def _message(each: LearnedMessage, meanings: dict[str, Meaning]) -> Iterator[str]:
    message = each.message
    sender = node_name(message.node) if message.node and message.direction == "sent" else _NOBODY
    name = f"{'TPDO' if message.direction == 'sent' else 'RPDO'}{message.number}_node_{message.node}"
    name = name if message.number else f"message_{message.name}"
    yield f"BO_ {_key(each)} {name}: {message.data.shape[1]} {sender}"
    for signal in each.signals:
        sign = "-" if signal.signed or signal.kind == "float" else "+"
        order = 0 if signal.is_big_endian else 1
        place = f"{dbc_start(signal)}|{signal.bits}@{order}{sign}"
        switch = "" if signal.switch is None else f" m{signal.switch}"
        switch = " M" if signal.kind == "multiplexor" else switch
        yield f' SG_ {meanings[signal.label].name}{switch} : {place} (1,0) [0|0] "" {_NOBODY}'
    yield ""


def _comments(each: LearnedMessage, meanings: dict[str, Meaning]) -> Iterator[str]:
    for signal in each.signals:
        meaning = meanings[signal.label]
        words = "; ".join(word for word in (meaning.words, *signal.reasons) if word).replace('"', "'")
        if words:
            yield f'CM_ SG_ {_key(each)} {meaning.name} "{words}";'


def _key(each: LearnedMessage) -> int:
    return each.message.can_id | (EXTENDED_KEY if each.message.is_extended else 0)


def dbc_start(signal: LearnedSignal) -> int:
    """Return the start bit as DBC files count: the lowest one, or big-endian the highest one's place."""
    if not signal.is_big_endian:
        return signal.start
    highest = signal.start + signal.bits - 1
    return 8 * (signal.length - 1 - highest // 8) + highest % 8
