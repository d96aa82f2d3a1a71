"""Conversion of series with different sampling times to a recording with a common SYNC clock.

Where all channels have the same times, these are the SYNCs and the counts stay as they are. Otherwise the
channel with the fewest samples gives the clock, and the others are interpolated to it between their
neighbours, to whole counts. A pause in the clock is filled with SYNCs that no encoder answered, as on a real
bus.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.errors import SourceError
from omnimate.files.importers.units import counts_of
from omnimate.files.logs.decoding import drive_conversion
from omnimate.files.recordings.readings import recording_of_readings
from omnimate.vehicle.counters import counter_law, unwrap
from omnimate.vehicle.parameters import ParameterError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from omnimate.files.importers.series import Series
    from omnimate.vehicle.parameters import Channel, Encoder, VehicleParameters
    from omnimate.vehicle.recording import Poses, Recording, Run
    from omnimate.vehicle.se2 import Array

_PAUSE_PERIODS = 3.0  # [periods] interval above which samples are missing (assumption)
_MAX_PAUSE = 3600.0  # [s] longest pause within a drive (assumption)


def recording_of(
    vehicle: VehicleParameters,
    series: Mapping[Channel, Series],
    source: str,
    poses: Poses | None = None,
    run: Run | None = None,
    commands: Array | None = None,
) -> Recording:
    """Return a recording made of series, equal to that read back from the folder that it is written to.

    The robot's `sync_period` is replaced by the median one of the data; poses are on the channels' clock, and
    so are commanded wheel speeds [rad/s], shape `(N, W)`. Messages name the source.

    Raises:
        SourceError: A channel is missing, the clocks do not overlap, or a series does not fit its channel.
    """
    for channel in vehicle.channels:
        if channel not in series:
            raise SourceError(
                source, f"nothing gives channel {channel}; the robot has it in its vehicle.toml"
            )
    clock = _clock([series[channel] for channel in vehicle.channels], source)
    vehicle = _with_period(vehicle, clock, source)
    time, kept = _filled(clock, vehicle.bus.sync_period, source)
    counts = np.zeros((len(time), len(vehicle.channels)), np.int64)
    received = np.zeros(counts.shape, np.bool_)
    for number, encoder in enumerate(vehicle.encoders):
        column = _on_clock(series[encoder.channel], vehicle, encoder, clock)
        counts[kept, number], received[kept, number] = column
    _check_poses(poses, time, source)
    speeds = None if commands is None else _commands(commands, vehicle, kept, len(time))
    recording = recording_of_readings(vehicle, time, counts, received, speeds, source)
    return replace(recording, poses=poses, run=run)


def _clock(series: list[Series], source: str) -> Array:
    """Return the times `(N,)` of the SYNCs [s]."""
    first = series[0].time
    if all(np.array_equal(other.time, first) for other in series):
        return np.array(first, np.float64)
    start, end = max(other.time[0] for other in series), min(other.time[-1] for other in series)
    slowest: Array = min((other.time for other in series), key=len)
    clock: Array = slowest[(slowest >= start) & (slowest <= end)]
    if len(clock) < 2:
        spans = "; ".join(
            f"{other.source}: {other.time[0]:.3f} to {other.time[-1]:.3f} s" for other in series
        )
        raise SourceError(source, f"the channels have no time in common ({spans}); expected one clock")
    return clock


def _with_period(vehicle: VehicleParameters, clock: Array, source: str) -> VehicleParameters:
    if len(clock) < 2:
        raise SourceError(source, f"{len(clock)} sample; a drive has two or more")
    period = round(float(np.median(np.diff(clock))), 6)
    try:
        return replace(vehicle, bus=replace(vehicle.bus, sync_period=period))
    except ParameterError as error:
        raise SourceError(source, f"time between samples: {error.problem}; check the unit of time") from error


def _on_clock(
    series: Series, vehicle: VehicleParameters, encoder: Encoder, clock: Array
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the counts of a channel at the times of a clock, and whether each was measured, `(N,)`."""
    counts, known = counts_of(series, vehicle, encoder), np.isfinite(series.value)
    if np.array_equal(series.time, clock):
        return counts, known
    time, counts = series.time[known], counts[known]
    if len(time) < 2:
        raise SourceError(series.source, "one value; a drive has two or more")
    period = max(float(np.median(np.diff(series.time))), vehicle.bus.sync_period)
    slow = replace(vehicle, bus=replace(vehicle.bus, sync_period=period))
    continuous = unwrap(counts, counter_law(encoder, slow))
    after = np.clip(np.searchsorted(time, clock), 1, len(time) - 1)
    near = time[after] - time[after - 1] <= _PAUSE_PERIODS * period
    inside = (clock >= time[0]) & (clock <= time[-1])
    travel = np.rint(np.interp(clock, time, continuous - continuous[0])).astype(np.int64)
    return travel + continuous[0], near & inside


def _filled(clock: Array, period: float, source: str) -> tuple[Array, NDArray[np.intp]]:
    """Return the clock with SYNCs added in its pauses, and the index of each original time in it."""
    steps = np.diff(clock)
    longest = int(np.argmax(steps))
    if steps[longest] > _MAX_PAUSE:
        raise SourceError(
            source,
            f"nothing from {clock[longest]:.3f} s to {clock[longest + 1]:.3f} s; expected one drive on one "
            "clock: cut it in two",
        )
    more = np.where(steps > _PAUSE_PERIODS * period, np.rint(steps / period).astype(np.int64) - 1, 0)
    kept = np.concatenate(([0], np.cumsum(more + 1)))
    return np.interp(np.arange(kept[-1] + 1), kept, clock), kept


def _commands(
    commands: Array, vehicle: VehicleParameters, kept: NDArray[np.intp], count: int
) -> Array | None:
    """Return commands `(N, W)` on the filled clock, each until the next, to the resolution of the drives."""
    held = np.maximum.accumulate(np.where(np.isnan(commands), -1, np.arange(len(commands))[:, None]), axis=0)
    row = held[np.searchsorted(kept, np.arange(count), side="right") - 1]
    speeds = np.full(row.shape, np.nan)
    for drive in vehicle.drives:
        wheel, factor = vehicle.wheels.index(drive.wheel), drive_conversion(drive).factor
        given = row[:, wheel] >= 0
        speeds[given, wheel] = np.rint(commands[row[given, wheel], wheel] / factor) * factor
    return None if np.isnan(speeds).all() else speeds


def _check_poses(poses: Poses | None, time: Array, source: str) -> None:
    """Raise an error for poses of another clock."""
    if poses is None or np.any((poses.time >= time[0]) & (poses.time <= time[-1])):
        return
    seen = f"{poses.time[0]:.3f} to {poses.time[-1]:.3f} s" if len(poses.time) else "nowhere"
    raise SourceError(
        source,
        f"the poses lie at {seen}, the counts at {time[0]:.3f} to {time[-1]:.3f} s; expected one clock: "
        "a time offset or another unit of time may put it right",
    )
