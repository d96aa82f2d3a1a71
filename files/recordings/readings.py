"""Conversion of encoder answers to a recording: unwrapped counts, gaps, and lost travel."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.files.logs.recording_to_frames import encode
from omnimate.vehicle.assembly import NOTHING, REASONS, assemble_events, assembly_records
from omnimate.vehicle.recording import Gap, Recording

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from omnimate.vehicle.compiled import Record
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.se2 import Array

    _Samples = tuple[NDArray[np.int64], NDArray[np.bool_], NDArray[np.uint8]]


class Events(NamedTuple):
    """Events on a bus as input of `omnimate.vehicle.assembly.assemble_events`; all `(E,)`."""

    opens: NDArray[np.bool_]
    kinds: NDArray[np.int16]
    words: NDArray[np.uint64]
    lengths: NDArray[np.uint8]
    times: Array


def recording_of_events(
    vehicle: VehicleParameters,
    records: tuple[Record, Record, Record],
    events: Events,
    commands: Array | None,
    source: str,
) -> Recording:
    """Return the recording, without poses and run, of events from the first SYNC on; updates the records.

    The records are the robot's of the cycle, the PDOs and the channels; the first event opens a sample;
    commands are wheel speeds [rad/s], `(N, W)`. Messages name the source.
    """
    time = events.times[events.opens]
    shape = len(time), len(vehicle.channels)
    samples = np.zeros(shape, np.int64), np.zeros(shape, bool), np.zeros(shape, np.uint8)
    opens, kinds, words, lengths, times = events
    assemble_events(*records, opens, kinds, words, lengths, times, *samples)
    counts, present, _ = samples
    for column, first in enumerate(np.argmax(present, axis=0).tolist()):
        counts[:first, column] = counts[first, column]
    gaps = _gaps(time, vehicle, samples, records[2])
    in_order = tuple(sorted(gaps, key=lambda gap: (gap.start, gap.channel)))
    return Recording(vehicle, time, counts, present, None, None, in_order, commands, source)


def recording_of_readings(
    vehicle: VehicleParameters,
    time: Array,
    counts: NDArray[np.int64],
    received: NDArray[np.bool_],
    commands: Array | None,
    source: str,
) -> Recording:
    """Return the recording, without poses and run, of encoder readings at each SYNC.

    Encoders that share a PDO are present only if all of them were received.

    Times are `(N,)` [s]. The columns are the robot's `channels`: counts, wrapped or not, any number where
    none was received, and whether one was, both `(N, C)`. Commanded wheel speeds are `(N, W)` [rad/s], or
    None. Messages name the source.
    """
    records = assembly_records(vehicle)
    _, pdos, channels = records
    shape = len(time), 1 + len(pdos)  # in each sample SYNC, and then the PDOs
    words, opens = np.zeros(shape, np.uint64), np.zeros(shape, bool)
    opens[:, 0] = True
    kinds = np.tile(np.arange(shape[1], dtype=np.int16) - 1, (shape[0], 1))
    kinds[:, 0] = NOTHING
    for column, encoder in enumerate(vehicle.encoders):
        place = 1 + int(channels["pdo"][column])
        words[:, place] |= encode(counts[:, column], encoder)
        kinds[~received[:, column], place] = NOTHING
    lengths = np.tile(np.append(0, pdos["length"]).astype(np.uint8), shape[0])
    times = np.repeat(time, shape[1])
    events = Events(opens.ravel(), kinds.ravel(), words.ravel(), lengths, times)
    return recording_of_events(vehicle, records, events, commands, source)


def _gaps(
    time: NDArray[np.float64], vehicle: VehicleParameters, samples: _Samples, channels: Record
) -> Iterator[Gap]:
    """Yield the gaps of all channels; a gap at the end lasts until the last sample."""
    _, present, ended = samples
    for column, channel in enumerate(vehicle.channels):
        rows = np.flatnonzero(ended[:, column])
        good = np.flatnonzero(present[:, column])
        before = np.searchsorted(good, rows) - 1
        starts = np.where(before >= 0, time[good[before]] if len(good) else time[0], time[0])
        reasons = ended[rows, column].tolist()
        for start, row, reason in zip(starts.tolist(), rows.tolist(), reasons, strict=True):
            yield Gap(channel, start, float(time[row]), REASONS[reason])
        if channels["gap"][column]:
            last_good = float(channels["last_good"][column])
            yield Gap(channel, last_good, float(time[-1]), REASONS[channels["gap"][column]])
