"""From series on clocks of their own to a recording: one SYNC clock, and what a bus would have shown.

Where all channels share their times, these are the SYNCs and no count is touched. Otherwise the channel with
the fewest samples gives the clock, and the others are interpolated to it between their neighbours, to whole
counts. A pause in the clock is filled with SYNCs that no encoder answered, as on a real bus.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from imports.errors import SourceError
from imports.units import counts_of
from vehicle.assemble import assemble
from vehicle.bus_image import frames_of_recording
from vehicle.counters import counter_law, unwrap
from vehicle.parameters import ParameterError
from vehicle.recording import Recording

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from imports.series import Series
    from vehicle.parameters import Channel, VehicleParameters
    from vehicle.recording import Poses, Run
    from vehicle.se2 import Array

_PAUSE = 3.0  # periods after which a sample counts as missing
_LONGEST = 3600.0  # [s] of a pause; more is another drive


class _Column(NamedTuple):
    """The counts of one channel on the clock, and where they were read."""

    counts: NDArray[np.int64]
    present: NDArray[np.bool_]


def recording_of(
    vehicle: VehicleParameters,
    series: Mapping[Channel, Series],
    source: str,
    poses: Poses | None = None,
    run: Run | None = None,
    commands: Array | None = None,
) -> Recording:
    """Return the recording that series make, as it comes out of the folder that it is written to.

    Args:
        vehicle: its `sync_period` is replaced by the median one of the data.
        series: one for each channel of the vehicle.
        source: for messages.
        poses: absolute, on the same clock.
        run: what was driven.
        commands: `(N, W)` wheel speeds [rad/s] on the channels' common clock, or None.

    Raises:
        SourceError: a channel is missing, the clocks do not overlap, or a series is none of its channel.
    """
    for channel in vehicle.channels:
        if channel not in series:
            raise SourceError(
                source, f"nothing gives channel {channel}; the robot has it in its vehicle.toml"
            )
    clock = _clock([series[channel] for channel in vehicle.channels], source)
    vehicle = _with_period(vehicle, clock, source)
    columns = [_column(series[channel], vehicle, channel, clock) for channel in vehicle.channels]
    time, kept = _filled(clock, vehicle.bus.sync_period, source)
    counts = np.zeros((len(time), len(columns)), np.int64)
    present = np.zeros(counts.shape, np.bool_)
    for number, column in enumerate(columns):
        counts[kept, number], present[kept, number] = column.counts, column.present
    _check_poses(poses, time, source)
    spread = None if commands is None else _spread(commands, kept, len(time))
    raw = Recording(vehicle, time, counts, present, commands=spread, source=source)
    shown = assemble(frames_of_recording(raw), vehicle, source).recording
    return replace(shown, poses=poses, run=run)


def _clock(series: list[Series], source: str) -> Array:
    """Return the times `(N,)` of the SYNCs [s]."""
    first = series[0].time
    if all(np.array_equal(one.time, first) for one in series):
        return np.array(first, np.float64)
    start, end = max(one.time[0] for one in series), min(one.time[-1] for one in series)
    slowest: Array = min(series, key=lambda one: len(one.time)).time
    clock: Array = slowest[(slowest >= start) & (slowest <= end)]
    if len(clock) < 2:
        spans = "; ".join(f"{one.source}: {one.time[0]:.3f} to {one.time[-1]:.3f} s" for one in series)
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


def _column(series: Series, vehicle: VehicleParameters, channel: Channel, clock: Array) -> _Column:
    encoder = vehicle.encoder(channel)
    counts, known = counts_of(series, vehicle, encoder), np.isfinite(series.value)
    if np.array_equal(series.time, clock):
        return _Column(counts, known)
    time, own = series.time[known], float(np.median(np.diff(series.time)))
    slow = replace(vehicle, bus=replace(vehicle.bus, sync_period=max(own, vehicle.bus.sync_period)))
    continuous = unwrap(counts[known], counter_law(encoder, slow)).counts
    after = np.clip(np.searchsorted(time, clock), 1, max(1, len(time) - 1)) if len(time) > 1 else None
    if after is None:
        raise SourceError(series.source, "one value; a drive has two or more")
    near = time[after] - time[after - 1] <= _PAUSE * slow.bus.sync_period
    inside = (clock >= time[0]) & (clock <= time[-1])
    middle = np.rint(np.interp(clock, time, continuous - continuous[0])).astype(np.int64) + continuous[0]
    return _Column(middle, near & inside)


def _filled(clock: Array, period: float, source: str) -> tuple[Array, NDArray[np.intp]]:
    """Return the clock with SYNCs in its pauses, and where its own times are in it."""
    steps = np.diff(clock)
    longest = int(np.argmax(steps))
    if steps[longest] > _LONGEST:
        raise SourceError(
            source,
            f"nothing from {clock[longest]:.3f} s to {clock[longest + 1]:.3f} s; expected one drive on one "
            "clock: cut it in two",
        )
    more = np.where(steps > _PAUSE * period, np.rint(steps / period).astype(np.int64) - 1, 0)
    kept = np.concatenate(([0], np.cumsum(more + 1)))
    return np.interp(np.arange(kept[-1] + 1), kept, clock), kept


def _spread(commands: Array, kept: NDArray[np.intp], count: int) -> Array:
    """Return commands `(N, W)` on the filled clock: the last one holds."""
    return commands[np.searchsorted(kept, np.arange(count), side="right") - 1]


def _check_poses(poses: Poses | None, time: Array, source: str) -> None:
    """Refuse poses of another clock."""
    if poses is None or np.any((poses.time >= time[0]) & (poses.time <= time[-1])):
        return
    seen = f"{poses.time[0]:.3f} to {poses.time[-1]:.3f} s" if len(poses.time) else "nowhere"
    raise SourceError(
        source,
        f"the poses lie at {seen}, the counts at {time[0]:.3f} to {time[-1]:.3f} s; expected one clock: "
        "a time offset or another unit of time may put it right",
    )
