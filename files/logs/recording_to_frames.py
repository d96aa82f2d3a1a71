"""Conversion of a recording to the frames of a bus: the inverse of `omnimate.files.logs.assemble`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.canopen_words import SYNC_ID
from omnimate.files.logs.decoding import drive_conversion
from omnimate.files.logs.frames import Frames, concatenate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Drive, Encoder
    from omnimate.vehicle.recording import Recording

_LATENCY = 200e-6  # [s] answer time of a device after SYNC (assumption)
_MAX_ANSWER_SHARE = 0.8  # [SYNC periods] latest answer
_COMMAND_LEAD, _BOOT_UP_LEAD = 0.05, 0.10  # [SYNC periods] before SYNC


def frames_of_recording(recording: Recording) -> Frames:
    """Return SYNC, the encoders' TPDOs, boot-up messages at restarts, and the drives' RPDOs on change.

    Counters wrap at their range; a PDO that several channels share is there where all of them are present.
    """
    vehicle, period = recording.vehicle, _shortest_period(recording)
    samples = np.arange(len(recording))
    frames = [_frames(recording.time, SYNC_ID, np.zeros(len(samples), np.uint64), 0)]
    order = [samples + 0.5]
    cob_ids = sorted({encoder.cob_id for encoder in vehicle.encoders})
    shared = [[encoder for encoder in vehicle.encoders if encoder.cob_id == cob_id] for cob_id in cob_ids]
    offsets = _offsets([_size(encoders) for encoders in shared], vehicle.bus.bitrate, period)
    for place, (cob_id, encoders) in enumerate(zip(cob_ids, shared, strict=True)):
        present, words = _words(recording, encoders)
        time = recording.time[present] + offsets[place]
        frames.append(_frames(time, cob_id, words[present], _size(encoders)))
        order.append(samples[present] + 0.6 + 0.3 * place / len(shared))
    for node, sample in sorted(_restarts(recording)):
        time = recording.time[[sample]] - _BOOT_UP_LEAD * period
        frames.append(_frames(time, 0x700 + node, np.zeros(1, np.uint64), 1))
        order.append(np.array([sample + 0.1]))
    for drive, speeds in _commanded(recording):
        changes, words = _changes(speeds, drive)
        time, size = recording.time[changes] - _COMMAND_LEAD * period, drive.start_bit // 8 + 4
        frames.append(_frames(time, drive.cob_id, words, size))
        order.append(changes + 0.2)
    return concatenate(frames).select(np.argsort(np.concatenate(order), kind="stable"))


def _shortest_period(recording: Recording) -> float:
    """Return the shortest time between two SYNC [s], so that no answer comes after the next one."""
    steps = np.diff(recording.time)
    return float(np.min(steps[steps > 0], initial=recording.vehicle.bus.sync_period))


def _offsets(sizes: list[int], bitrate: int, period: float) -> NDArray[np.float64]:
    """Return when after SYNC each PDO is on the bus [s]: one after the other, by priority."""
    bits = np.array(
        [47 + 8 * size + (33 + 8 * size) // 8 for size in sizes]
    )  # with typical stuffing: one bit in 8
    offsets = _LATENCY + np.cumsum(bits) / bitrate
    return np.asarray(offsets * min(1.0, _MAX_ANSWER_SHARE * period / float(offsets[-1])), np.float64)


def _words(recording: Recording, encoders: list[Encoder]) -> tuple[NDArray[np.bool_], NDArray[np.uint64]]:
    """Return where a PDO is there, `(N,)`, and its data as little-endian numbers, `(N,)`."""
    present = np.ones(len(recording), bool)
    words = np.zeros(len(recording), np.uint64)
    for encoder in encoders:
        present &= recording.is_present(encoder.channel)
        words |= encode(recording.channel_counts(encoder.channel), encoder)
    return present, words


def encode(counts: NDArray[np.int64], encoder: Encoder) -> NDArray[np.uint64]:
    """Return the bits of PDOs, `(N,)`, whose field shows the counts as the wrapping counter would."""
    raw = counts % encoder.wrap_range if encoder.wrap_range < 2**63 else counts
    if encoder.signed and encoder.wrap_range < 2**encoder.bits:
        raw = raw - encoder.wrap_range * (raw >= (encoder.wrap_range + 1) // 2)
    mask = np.uint64(2**encoder.bits - 1)
    return (raw.astype(np.int64).view(np.uint64) & mask) << np.uint64(encoder.start_bit)


def _restarts(recording: Recording) -> set[tuple[int, int]]:
    """Return the nodes that restarted and the samples before which they did."""
    gaps = [gap for gap in recording.gaps if gap.reason == "reboot"]
    return {
        (recording.vehicle.encoder(gap.channel).node, int(np.searchsorted(recording.time, gap.end)))
        for gap in gaps
    }


def _commanded(recording: Recording) -> list[tuple[Drive, NDArray[np.float64]]]:
    """Return the drives and the wheel speeds commanded to them, `(N,)` [rad/s]."""
    if recording.commands is None:
        return []
    vehicle, commands = recording.vehicle, recording.commands
    return [(drive, commands[:, vehicle.wheels.index(drive.wheel)]) for drive in vehicle.drives]


def _changes(speeds: NDArray[np.float64], drive: Drive) -> tuple[NDArray[np.intp], NDArray[np.uint64]]:
    """Return before which samples a command changes, and the RPDO's data."""
    known = np.flatnonzero(~np.isnan(speeds))
    counts = np.rint(speeds[known] / drive_conversion(drive).factor).astype(np.int64)
    changes = np.flatnonzero(np.concatenate(([True], np.diff(counts) != 0))) if len(known) else known
    words = counts[changes].view(np.uint64) & np.uint64(0xFFFFFFFF)
    return known[changes], words << np.uint64(drive.start_bit)


def _size(encoders: list[Encoder]) -> int:
    return max((encoder.start_bit + encoder.bits + 7) // 8 for encoder in encoders)


def _frames(time: NDArray[np.float64], can_id: int, words: NDArray[np.uint64], size: int) -> Frames:
    count = len(time)
    return Frames(
        np.maximum(np.asarray(time, np.float64), 0.0),  # what comes before the first SYNC, on a clock from 0
        np.full(count, can_id, np.uint32),
        np.full(count, size, np.uint8),
        words.astype("<u8").view(np.uint8).reshape(count, 8),
        np.zeros(count, np.uint8),
        np.zeros(count, np.uint8),
    )
