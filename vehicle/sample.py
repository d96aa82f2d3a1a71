"""One reading of all encoders in live use."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Sample:
    """The encoders' answers to one SYNC; tuples are in the order of `vehicle.channels`."""

    index: int  # number of the SYNC since the start of this run, from 0
    time: float  # when the SYNC was sent or seen, on the recording's clock [s]
    counts: tuple[int, ...]  # unwrapped raw counts; a channel that is not present repeats its last value
    present: tuple[bool, ...]  # False where the PDO was missing, late or not valid
    device_time: tuple[float, ...]  # frame timestamp by the adapter [s]; nan where not present
    # When the PDO was on the bus, by the adapter's stamps where it has them, else when it was read; on the
    # recording's clock [s]; nan where not present
    arrival_time: tuple[float, ...]
