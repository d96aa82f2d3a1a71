"""Everything that a log tells about its bus."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from omnimate.listen.messages import messages_of
from omnimate.listen.network import DRIVE_PROFILE, find_network
from omnimate.listen.sending import find_sending
from omnimate.listen.shafts import find_shafts, tracks_of
from omnimate.listen.signals import learn_signals
from omnimate.listen.wheels import find_wheels

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from omnimate.listen.messages import Message
    from omnimate.listen.network import Network
    from omnimate.listen.sending import Sending
    from omnimate.listen.shafts import Shaft
    from omnimate.listen.signals import LearnedSignal
    from omnimate.listen.wheels import Kinematics
    from omnimate.logs.frames import Frames
    from omnimate.logs.signals import Signal


@dataclass(frozen=True)
class LearnedMessage:
    """A message, when it is sent, and its signals."""

    message: Message
    sending: Sending
    signals: tuple[LearnedSignal, ...]


@dataclass(frozen=True)
class Findings:
    """What a bus is.

    Attributes:
        start: Time of the first frame [s].
        seconds: Length of the log [s].
        frames: Number of frames.
        network: Nodes and services.
        messages: Messages by identifier.
        shafts: Movements that are measured.
        kinematics: Which of them are wheels, joints, sliders.
    """

    start: float
    seconds: float
    frames: int
    network: Network
    messages: tuple[LearnedMessage, ...]
    shafts: tuple[Shaft, ...]
    kinematics: Kinematics


def learn_bus(
    frames: Frames,
    known: Mapping[int, Sequence[Signal]] | None = None,
    progress: Callable[[int, int], None] = lambda _done, _of: None,
) -> Findings:
    """Return what a log tells about its bus.

    Args:
        frames: The log, of one interface.
        known: Fields of PDOs by COB-ID, as the SDO traffic in the log shows them.
        progress: Is told how many messages are done, and of how many.
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
    drives = _drives(network, learned)
    tracks = tracks_of([signal for each in learned for signal in each.signals])
    rates = {signal.label for shaft in find_shafts(tracks, drives) for signal, _, _ in shaft.rates}
    learned = [
        replace(each, signals=tuple(_with_sign(signal, drives, rates) for signal in each.signals))
        for each in learned
    ]
    shafts = find_shafts(tracks_of([signal for each in learned for signal in each.signals]), drives)
    return Findings(
        float(frames.time[0]),
        float(frames.time[-1] - frames.time[0]),
        len(frames),
        network,
        tuple(learned),
        tuple(shafts),
        find_wheels(shafts),
    )


def _drives(network: Network, learned: Sequence[LearnedMessage]) -> set[int]:
    """Return the nodes that are drives of CiA 402: they say so, or they send a status word."""
    said = {number for number, node in network.nodes.items() if node.profile == DRIVE_PROFILE}
    return said | {
        signal.node
        for each in learned
        for signal in each.signals
        if signal.kind == "status word" and signal.is_sure
    } - {0}


def _with_sign(signal: LearnedSignal, drives: set[int], rates: set[str]) -> LearnedSignal:
    """Return a number with the sign that its profile says, and without one where a counter hides it.

    CiA 402's speeds of 32 bits are signed. A counter that passes 0 downwards looks signed and may be 6004h of
    CiA 406 or a vendor's, which are not; no position of a profile has 16 bits.
    """
    if signal.kind != "number" or signal.bits != 32 or " " in signal.name or signal.turn:
        return signal
    if signal.label in rates:
        said = "its node is a drive, and CiA 402's speeds of 32 bits are signed"
        return signal.says(said, signed=True) if signal.node in drives else signal
    if signal.signed is not None:
        return signal.says("it may be a counter, whose differences are the same with any sign", signed=None)
    return signal
