"""One reading of all encoders in live use."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Sample:
    """The encoders' answers to one SYNC; tuples are in the order of `vehicle.channels`.

    Attributes:
        index: Number of the SYNC since the start of this run, from 0.
        time: When the SYNC was sent or seen, on the recording's clock [s].
        counts: Unwrapped raw counts; a channel that is not present repeats its last value.
        present: False where the PDO was missing, late or not valid.
        device_time: Frame timestamp by the adapter [s]; nan where not present.
        arrival_time: When the PDO was on the bus, by the adapter's stamps where it has them, else when it was
            read; on the recording's clock [s]; nan where not present.
    """

    index: int
    time: float
    counts: tuple[int, ...]
    present: tuple[bool, ...]
    device_time: tuple[float, ...]
    arrival_time: tuple[float, ...]
