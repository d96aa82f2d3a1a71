"""Analysis of a log: network, messages, signals, shafts, wheels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.listen.messages import messages_of
from omnimate.listen.network import DRIVE_PROFILE, find_network
from omnimate.listen.profile_words import profile_reading
from omnimate.listen.sending import find_sending
from omnimate.listen.shafts import find_shafts, tracks_of
from omnimate.listen.signals import learn_signals
from omnimate.listen.wheels import find_wheels

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from omnimate.files.logs.frames import Frames
    from omnimate.files.logs.signals import Signal
    from omnimate.listen.messages import Message
    from omnimate.listen.network import Network
    from omnimate.listen.sending import Sending
    from omnimate.listen.shafts import Shaft
    from omnimate.listen.signals import LearnedSignal
    from omnimate.listen.wheels import Kinematics

MIN_DRIVE_PROBABILITY = 0.9  # probability from which a node is taken as a drive (assumption)
# Changes between the lowest and the highest quarter of the values; driving out and back makes two
MIN_SWINGS = 3


@dataclass(frozen=True)
class LearnedMessage:
    """A message, its trigger and timing, and its signals."""

    message: Message
    sending: Sending
    signals: tuple[LearnedSignal, ...]


@dataclass(frozen=True)
class Findings:
    """Results of the analysis of a bus."""

    start: float  # time of the first frame [s]
    seconds: float  # time from the first frame to the last [s]
    frames: int  # number of frames
    network: Network  # nodes and services
    messages: tuple[LearnedMessage, ...]  # messages in the order of their identifiers
    shafts: tuple[Shaft, ...]  # shafts whose movement is measured
    kinematics: Kinematics  # which of them are wheels, joints, sliders


def learn_bus(
    frames: Frames,
    known: Mapping[int, Sequence[Signal]] | None = None,
    progress: Callable[[int, int], None] = lambda _done, _of: None,
) -> Findings:
    """Return the analysis of a log.

    Args:
        frames: The frames of one interface, at least one, in the order of their times.
        known: Fields of PDOs by COB-ID, from the SDO traffic in the log.
        progress: Called with (messages done, number of messages).
    """
    known = known or {}
    network = find_network(frames)
    messages = list(messages_of(frames, frozenset(network.nodes), has_sync=network.sync_period is not None))
    learned = []
    for number, message in enumerate(messages):
        mapping = () if message.is_extended else known.get(message.can_id, ())
        sending = find_sending(message.time, message.data, network.sync_times, network.sync_period)
        learned.append(LearnedMessage(message, sending, learn_signals(message, mapping)))
        progress(number + 1, len(messages))
    drives = _drive_nodes(network, learned)
    tracks = tracks_of([signal for entry in learned for signal in entry.signals])
    rates = {signal.label for shaft in find_shafts(tracks, drives) for signal, _, _ in shaft.rates}
    learned = [
        replace(entry, signals=tuple(_with_sign(signal, drives, rates) for signal in entry.signals))
        for entry in learned
    ]
    shafts = find_shafts(tracks_of([signal for entry in learned for signal in entry.signals]), drives)
    return Findings(
        float(frames.time[0]),
        float(frames.time[-1] - frames.time[0]),
        len(frames),
        network,
        tuple(learned),
        tuple(shafts),
        find_wheels(shafts),
    )


def _drive_nodes(network: Network, learned: Sequence[LearnedMessage]) -> set[int]:
    """Return the ids of the nodes that are CiA 402 drives: by 1000h, or by a status or control word.

    No other profile has such words. The probability that a node is no drive is the product over its signals
    of the probability that the signal is no such word.
    """
    drives = {number for number, node in network.nodes.items() if node.profile == DRIVE_PROFILE}
    no_drive: dict[int, float] = {}
    for entry in learned:
        for signal in entry.signals:
            if signal.kind in {"status word", "control word"} and signal.node:
                no_word = 1.0 - signal.boundaries_probability * signal.kind_probability
                no_drive[signal.node] = no_drive.get(signal.node, 1.0) * no_word
    return drives | {
        node for node, probability in no_drive.items() if probability < 1.0 - MIN_DRIVE_PROBABILITY
    }


def _with_sign(signal: LearnedSignal, drives: set[int], rates: set[str]) -> LearnedSignal:
    """Return a signal with `signed` corrected if it is a number of 32 bits of unknown type.

    Of a drive, a speed (`rates` has their labels) and a number that oscillates are signed, as all such
    objects of CiA 402 are. Any other number, except a speed, may be a counter that passed 0 downwards, such
    as 6004h of CiA 406, which is unsigned: its sign is not identified.
    """
    is_described = " " in signal.name or profile_reading(signal.name, signal.bits) is not None
    if signal.kind != "number" or signal.bits != 32 or is_described or signal.counter_range:
        return signal
    if signal.node in drives and (signal.label in rates or (signal.signed and _oscillates(signal))):
        reason = "its node is a drive, and CiA 402's speeds, torques and errors of 32 bits are signed"
        return signal.with_reasons(reason, signed=True)
    if signal.label not in rates and signal.signed is not None:
        return signal.with_reasons(
            "it may be a counter, whose differences are the same with any sign", signed=None
        )
    return signal


def _oscillates(signal: LearnedSignal) -> bool:
    """Return whether a number changes at least `MIN_SWINGS` times between its lowest and highest quarter."""
    value = signal.unwrapped()
    low, high = np.quantile(value, [0.25, 0.75])
    is_high = (value >= high)[(value <= low) | (value >= high)]
    return int(np.count_nonzero(is_high[:-1] != is_high[1:])) >= MIN_SWINGS
