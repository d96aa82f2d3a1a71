"""Export of the findings as a DBC file: signals in raw counts, with reasons as comments."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.files.logs.dbc import DbcMessage, format_dbc, heartbeat_message, node_name
from omnimate.files.logs.signals import EXTENDED_KEY, Signal

if TYPE_CHECKING:
    from omnimate.listen.learning import Findings, LearnedMessage
    from omnimate.listen.meanings import Meaning
    from omnimate.listen.signals import LearnedSignal

_NO_NODE = "Vector__XXX"  # DBC placeholder for an unknown node


def learned_dbc(findings: Findings, meanings: dict[str, Meaning]) -> str:
    """Return the text of a DBC file, with names of `meanings_of`; an unknown sign is written unsigned."""
    nodes = sorted(findings.network.nodes)
    messages = [_message(learned, meanings) for learned in findings.messages]
    heartbeats = [heartbeat_message(node, _NO_NODE) for node in nodes]
    return format_dbc([node_name(node) for node in nodes], [*messages, *heartbeats])


def _message(learned: LearnedMessage, meanings: dict[str, Meaning]) -> DbcMessage:
    message = learned.message
    sender = node_name(message.node) if message.node and message.direction == "sent" else _NO_NODE
    name = f"{'TPDO' if message.direction == 'sent' else 'RPDO'}{message.pdo_number}_node_{message.node}"
    name = name if message.pdo_number else f"message_{message.name}"
    key = message.can_id | (EXTENDED_KEY if message.is_extended else 0)
    multiplexor = next((signal for signal in learned.signals if signal.kind == "multiplexor"), None)
    switch = None if multiplexor is None else _signal(multiplexor, meanings, None)
    signals = tuple(_signal(signal, meanings, switch) for signal in learned.signals)
    comments = {}
    for signal in learned.signals:
        meaning = meanings[signal.label]
        words = "; ".join(word for word in (meaning.words, *signal.reasons) if word)
        if words:
            comments[meaning.name] = words
    return DbcMessage(key, name, message.data.shape[1], sender, _NO_NODE, signals, comments)


def _signal(signal: LearnedSignal, meanings: dict[str, Meaning], multiplexor: Signal | None) -> Signal:
    return Signal(
        meanings[signal.label].name,
        dbc_start(signal),
        signal.bits,
        signed=bool(signal.signed),
        is_big_endian=signal.is_big_endian,
        is_float=signal.kind == "float",
        switch=None
        if multiplexor is None or signal.multiplexor_value is None
        else (multiplexor, (signal.multiplexor_value,)),
    )


def dbc_start(signal: LearnedSignal) -> int:
    """Return the start bit in DBC numbering: the lowest bit, or the highest one of a big-endian signal."""
    if not signal.is_big_endian:
        return signal.start
    highest = signal.start + signal.bits - 1
    return 8 * (signal.length - 1 - highest // 8) + highest % 8
