"""Nodes and CANopen services on a bus: states, SYNC, TIME, NMT, SDO, EMCY."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.canopen_words import (
    EMCY,
    HEARTBEAT,
    NMT_COMMANDS,
    SDO_ANSWER,
    SDO_REQUEST,
    SYNC_ID,
    TIME_ID,
    emcy_in_words,
    nmt_state_in_words,
)
from omnimate.files.logs.frames import ERROR, EXTENDED, REMOTE
from omnimate.files.logs.seen_mapping import seen_objects

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frames

DRIVE_PROFILE = 402  # CiA 402: lower 16 bits of 1000h (device type)
MAX_STATES = 12  # changes of state of a node that are listed


@dataclass(frozen=True, slots=True)
class Node:
    """A node on the bus."""

    number: int  # its id
    # its first NMT states in words, in order, from heartbeats or answers to node guarding
    states: tuple[str, ...]
    heartbeat: float | None  # its heartbeat period [s]; None without heartbeat
    is_guarded: bool  # whether a master requests its state (node guarding)
    boot_ups: int  # number of its boot-up messages
    emergencies: Mapping[str, int]  # number of EMCY messages by code, in words
    asked: int  # number of SDO requests to it
    # number of its device profile (1000h), if it was read by SDO in the log; None otherwise
    profile: int | None


@dataclass(frozen=True, slots=True)
class Network:
    """Nodes and services of a CANopen bus."""

    nodes: Mapping[int, Node]  # the nodes by id
    sync_period: float | None  # median interval of SYNC [s]; None without SYNC
    sync_jitter: float  # standard deviation of its intervals, without lost SYNCs [s]
    sync_overflow: int  # highest value of its counter (1019h); 0 without a counter
    sync_times: NDArray[np.float64]  # times of the SYNCs [s], shape `(N,)`
    time_stamps: int  # number of TIME messages
    commands: Mapping[str, int]  # number of NMT commands by command, in words
    # values of PDO parameters in SDO traffic, by (node, index, sub-index)
    parameters: Mapping[tuple[int, int, int], int]


def find_network(frames: Frames) -> Network:
    """Return the nodes and services in a log; without nodes if it is no CANopen bus."""
    standard = frames.select(frames.flags & (EXTENDED | ERROR) == 0)
    plain = standard.select(standard.flags & REMOTE == 0)
    syncs = plain.select((plain.can_id == SYNC_ID) & (plain.length <= 1))
    interval = np.diff(syncs.time)
    median_interval = float(np.median(interval)) if len(interval) else None
    regular = interval[interval < 1.5 * median_interval] if median_interval else interval
    parameters = seen_objects(plain)
    numbers = _node_ids(standard, plain)
    return Network(
        {
            number: _node(number, standard, plain)
            for number in sorted(numbers | {key[0] for key in parameters})
        },
        median_interval,
        float(np.std(regular)) if len(regular) else 0.0,
        int(syncs.data[:, 0].max()) if len(syncs) and np.all(syncs.length == 1) else 0,
        syncs.time,
        int(np.count_nonzero((plain.can_id == TIME_ID) & (plain.length == 6))),
        Counter(_commands(plain)),
        parameters,
    )


def _node_ids(standard: Frames, plain: Frames) -> set[int]:
    """Return the ids of nodes with a heartbeat, a boot-up or an SDO answer."""
    beats = (plain.can_id > HEARTBEAT) & (plain.can_id < HEARTBEAT + 0x80) & (plain.length == 1)
    states = np.isin(plain.data[:, 0] & 0x7F, (0x00, 0x04, 0x05, 0x7F))
    answers = (plain.can_id > SDO_ANSWER) & (plain.can_id < SDO_REQUEST) & (plain.length == 8)
    asked = np.isin(plain.can_id[answers] + 0x80, standard.can_id)
    numbers = set((plain.can_id[beats & states] & 0x7F).tolist())
    return numbers | set((plain.can_id[answers][asked] & 0x7F).tolist())


def _node(number: int, standard: Frames, plain: Frames) -> Node:
    beats = plain.select((plain.can_id == HEARTBEAT + number) & (plain.length == 1))
    shown = beats.data[:, 0]
    running = beats.time[shown & 0x7F != 0]
    guarded = np.any((standard.can_id == HEARTBEAT + number) & (standard.flags & REMOTE > 0))
    changes = np.flatnonzero(np.diff(shown & 0x7F, prepend=0xFF))
    errors = plain.select((plain.can_id == EMCY + number) & (plain.length == 8))
    codes = errors.data[:, 0].astype(int) | errors.data[:, 1].astype(int) << 8
    device = _device_type(number, plain)
    return Node(
        number,
        tuple(nmt_state_in_words(int(shown[at])) for at in changes[:MAX_STATES].tolist()),
        float(np.median(np.diff(running))) if len(running) > 2 and not guarded else None,
        bool(guarded),
        int(np.count_nonzero(shown == 0)),
        Counter(f"{code:04X}h {emcy_in_words(code)}" for code in codes.tolist()),
        int(np.count_nonzero(plain.can_id == SDO_REQUEST + number)),
        device & 0xFFFF if device else None,
    )


def _device_type(number: int, plain: Frames) -> int | None:
    """Return the value of 1000h from the node's last expedited SDO answer; None if there is none."""
    rows = (plain.can_id == SDO_ANSWER + number) & (plain.length == 8) & (plain.data[:, 0] == 0x43)
    rows &= (plain.data[:, 1] == 0) & (plain.data[:, 2] == 0x10) & (plain.data[:, 3] == 0)
    device_types = plain.data[rows, 4:8]
    return int.from_bytes(device_types[-1].tobytes(), "little") if len(device_types) else None


def _commands(plain: Frames) -> Iterator[str]:
    rows = (plain.can_id == 0) & (plain.length == 2)
    for command, node in plain.data[rows, :2].tolist():
        words = NMT_COMMANDS.get(command, f"unknown command {command:02X}h")
        yield f"{words}, {f'node {node}' if node else 'all nodes'}"
