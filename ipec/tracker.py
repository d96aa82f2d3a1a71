"""Plain odometry, IPEC and the filter run in parallel, live or over a recording; output in rows.

Of a robot with a single truck there is no IPEC: its columns are nan.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.corrector import ORIGIN, Corrector, correct
from omnimate.ipec.errors import FixError
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.findings import MIN_LOST_TRAVEL, Disturbance, Findings, findings
from omnimate.ipec.filter.fixes import fix_sigma, motion_to_fixes, samples_at
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.prior import CALIBRATED, Prior
from omnimate.ipec.linkage_check import LINKAGE, FrozenChannel, frozen_channels
from omnimate.ipec.one_truck import OneTruckFilter, estimate_one_truck
from omnimate.vehicle.odometry import Odometer, check_pose_units, dead_reckon
from omnimate.vehicle.parameters import WHEELS
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import between, compose

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike, NDArray

    from omnimate.ipec.filter.estimate import Estimate
    from omnimate.ipec.filter.findings import SlowParameters
    from omnimate.vehicle.parameters import Channel, VehicleParameters
    from omnimate.vehicle.recording import Poses
    from omnimate.vehicle.sample import Sample
    from omnimate.vehicle.se2 import Array

    Learned = tuple[VehicleParameters, SlowParameters, Findings]

START_SIGMAS = 10.0  # of the start by a fix over those of the fix, which the filter applies as well
CHECKED_SAMPLES = 2000  # latest samples that are checked for frozen channels: half a minute at 15 ms


@dataclass(frozen=True, slots=True)
class Row:
    """Poses by all methods at one sample, and the corrections since the previous row."""

    time: float  # time of the last sample on the recording's clock [s]
    plain: Array  # pose of truck a by dead reckoning [m, m, rad], `(3,)`
    ipec: Array  # pose of truck a by the CLAPPER's correction [m, m, rad], `(3,)`
    filtered: Array  # pose of truck a by the filter [m, m, rad], `(3,)`
    sigma: Array  # standard deviations of `filtered` [m, m, rad], `(3,)`
    follower: Array  # pose of truck b by the filter [m, m, rad], `(3,)`
    corrections: Array  # corrections of both headings by IPEC since the previous row [rad], `(2,)`
    lost: Array  # travel that each of `WHEELS` lost since the previous row, by the filter [m], `(4,)`

    def as_dict(self) -> dict[str, float | None]:
        """Return the row as flat names and numbers; None for what is not known."""
        poses = {"plain": self.plain, "ipec": self.ipec, "filter": self.filtered}
        poses |= {"sigma": self.sigma, "b": self.follower}
        out = {"t": self.time}
        for name, pose in poses.items():
            out |= {
                f"{name}_{axis}": float(value) for axis, value in zip(("x", "y", "theta"), pose, strict=True)
            }
        out |= {f"ipec_d_theta_{truck}": float(d) for truck, d in zip("ab", self.corrections, strict=True)}
        out |= {f"lost_{w.replace('.', '_')}": float(d) for w, d in zip(WHEELS, self.lost, strict=True)}
        return {name: value if np.isfinite(value) else None for name, value in out.items()}


class Tracker:
    """Estimates the pose of a live robot with two trucks by all methods.

    `plain` is plain odometry of truck a, from whose pose the tracker starts, and which its owner steps before
    the tracker; None for one of its own, from the origin. `prior` says how well `vehicle` is known.

    Raises:
        NoLinkageError: The robot has a single truck.
    """

    def __init__(
        self, vehicle: VehicleParameters, plain: Odometer | None = None, *, prior: Prior = CALIBRATED
    ) -> None:
        self.vehicle = vehicle
        self._plain, self._steps_plain = plain or Odometer(vehicle), plain is None
        self._ipec, self._filter = Corrector(vehicle), Filter(vehicle, prior=prior)
        self._states = self._ipec.start(self._plain.pose), self._filter.start(self._plain.pose)
        self._corrections, self._lost = np.zeros(2), np.zeros(4)
        self._ended: list[Disturbance] = []
        self._open: dict[Channel, Disturbance] = {}
        self._samples: deque[Sample] = deque(maxlen=CHECKED_SAMPLES)

    def step(self, sample: Sample) -> None:
        """Update all methods with the next sample."""
        if self._steps_plain:
            self._plain.step(sample)
        ipec, filtered = self._states
        self._states = ipec, filtered = self._ipec.step(ipec, sample), self._filter.step(filtered, sample)
        self._corrections = self._corrections + ipec.corrections
        self._lost = self._lost + filtered.lost
        self._samples.append(sample)
        for wheel, disturbed, lost in zip(WHEELS, filtered.disturbed, filtered.lost, strict=True):
            self._note(wheel, sample.time, lost, disturbed=disturbed)

    def _note(self, wheel: Channel, time: float, lost: float, *, disturbed: bool) -> None:
        going_on = self._open.pop(wheel, None)
        if disturbed:
            start, before = (going_on.start, going_on.lost) if going_on else (time, 0.0)
            self._open[wheel] = Disturbance(wheel, start, time, before + lost)
        elif going_on and going_on.lost >= MIN_LOST_TRAVEL:
            self._ended.append(going_on)

    @property
    def started(self) -> bool:
        """Whether a sample has been processed."""
        return bool(self._samples)

    @property
    def learned(self) -> Learned:
        """The robot, the errors of its encoders as the filter estimates them, and what contradicts it."""
        state = self._states[1]
        return self.vehicle, state.slow, findings(self._filter.settings, state.record, state.filters)

    def take_disturbances(self) -> tuple[Disturbance, ...]:
        """Return the disturbances that have ended since the last call."""
        ended, self._ended = tuple(self._ended), []
        return ended

    def look(self) -> Row:
        """Return the poses after the last sample; at least one sample is required."""
        ipec, filtered = self._states
        return Row(
            self._samples[-1].time,
            np.array(self._plain.pose),
            ipec.pose_a,
            filtered.pose("a"),
            filtered.sigma("a"),
            filtered.pose("b"),
            self._corrections,
            self._lost,
        )

    def row(self) -> Row:
        """Return `look()` and reset the sums of corrections and lost travel."""
        row = self.look()
        self._corrections, self._lost = np.zeros(2), np.zeros(4)
        return row

    def frozen(self) -> tuple[FrozenChannel, ...]:
        """Return the intervals of the last samples in which linkage channels were frozen.

        A channel that was not read at all has an expected motion of 0.
        """
        samples = tuple(self._samples)
        recording = Recording(
            self.vehicle,
            np.array([sample.time for sample in samples]),
            np.array([sample.counts for sample in samples], np.int64),
            np.array([sample.present for sample in samples], np.bool_),
            source=self.vehicle.name,
        )
        first, last = float(recording.time[0]), float(recording.time[-1])
        missing = [channel for channel in LINKAGE if not recording.is_present(channel).any()]
        if missing or not recording.present.all(axis=1).any():
            return tuple(FrozenChannel(channel, first, last, 0.0) for channel in missing)
        return frozen_channels(recording)


def track_recording(
    recording: Recording,
    every: float,
    start: ArrayLike = ORIGIN,
    sigma: ArrayLike = (0.0, 0.0, 0.0),
    *,
    fixes: Poses | None = None,
    prior: Prior = CALIBRATED,
) -> tuple[Iterator[Row], Estimate]:
    """Return rows over a recording, one `every` so many seconds (0: each sample), and the estimate.

    The other arguments are those of `estimate`, whose result the estimate is.

    Raises:
        NoLinkageError: The robot has a single truck.
        LinkageChannelError: A channel of the linkage was never read, or was frozen while the robot moved.
    """
    plain, ipec = correct(recording, start, method="plain"), correct(recording, start)
    filtered = estimate(recording, start, sigma, fixes=fixes, prior=prior)
    ends = _ends(recording, every)
    corrections = np.diff(np.cumsum(ipec.corrections, axis=0)[ends], axis=0, prepend=0.0)
    lost = np.diff(np.cumsum(filtered.lost, axis=0)[ends], axis=0, prepend=0.0)
    rows = (
        Row(
            float(recording.time[end]),
            plain.pose_a[end],
            ipec.pose_a[end],
            filtered.pose_a[end],
            filtered.sigma_a[end],
            filtered.pose_b[end],
            corrections[number],
            lost[number],
        )
        for number, end in enumerate(ends.tolist())
    )
    return rows, filtered


class OneTruckTracker:
    """Estimates the pose of a live robot with a single truck; used as a `Tracker` is.

    `learned` is None: without absolute poses there is nothing to learn from.
    """

    learned = None

    def __init__(self, vehicle: VehicleParameters, *, prior: Prior = CALIBRATED) -> None:
        self.vehicle, self.started = vehicle, False
        self._plain, self._filter = Odometer(vehicle), OneTruckFilter(vehicle, prior=prior)
        self._state, self._time = self._filter.start(), 0.0

    def step(self, sample: Sample) -> None:
        """Update odometry and filter with the next sample."""
        self._plain.step(sample)
        self._state, self._time, self.started = self._filter.step(self._state, sample), sample.time, True

    def take_disturbances(self) -> tuple[Disturbance, ...]:
        """Return none: a single truck does not see them."""
        return ()

    def frozen(self) -> tuple[FrozenChannel, ...]:
        """Return none: there is no linkage."""
        return ()

    def look(self) -> Row:
        """Return the poses after the last sample."""
        return _one_truck_row(self._time, np.array(self._plain.pose), self._state.pose, self._state.sigma)

    row = look


def track_one_truck(
    recording: Recording,
    every: float,
    start: ArrayLike = ORIGIN,
    sigma: ArrayLike = (0.0, 0.0, 0.0),
    *,
    fixes: Poses | None = None,
    prior: Prior = CALIBRATED,
) -> Iterator[Row]:
    """Return rows at equal intervals over a recording of a robot with a single truck.

    Arguments are those of `track_recording`.
    """
    plain = dead_reckon(recording, "a", start)
    poses, sigmas = estimate_one_truck(recording, start, sigma, fixes=fixes, prior=prior)
    return (
        _one_truck_row(float(recording.time[end]), plain[end], poses[end], sigmas[end])
        for end in _ends(recording, every).tolist()
    )


def _one_truck_row(time: float, plain: Array, filtered: Array, sigma: Array) -> Row:
    unknown = np.full(4, np.nan)
    return Row(time, plain, unknown[:3], filtered, sigma, unknown[:3], unknown[:2], unknown)


def _ends(recording: Recording, every: float) -> NDArray[np.int_]:
    """Return the numbers of the last samples of equal intervals [s]; 0 for every sample."""
    turn = np.floor((recording.time - recording.time[0]) / every) if every else np.arange(len(recording))
    return np.append(np.flatnonzero(np.diff(turn)), len(recording) - 1)


def fixes_of(recording: Recording) -> Poses:
    """Return the absolute poses of a recording, with `UNSTATED_SIGMA` where they state none.

    Raises:
        FixError: It has none.
        RecordingError: They are in millimetres, or in degrees.
    """
    if recording.poses is None:
        raise FixError(recording.source)
    for truck in recording.vehicle.trucks:
        check_pose_units(recording, truck)
    return replace(recording.poses, sigma=fix_sigma(recording.poses.sigma))


def start_by_fixes(recording: Recording, fixes: Poses) -> tuple[Array, Array]:
    """Return pose and standard deviations `(3,)` of truck a at the first sample, by its first whole fix.

    The wheels' travel up to the fix is taken back.

    Raises:
        FixError: No fix of truck a has x, y and heading.
    """
    of_a = fixes.of("a")
    whole = np.flatnonzero(np.isfinite(of_a.pose).all(axis=1))
    if not len(whole):
        raise FixError(recording.source)
    first = whole[0]
    path = dead_reckon(recording, "a")
    place = samples_at(recording, of_a.time)[first]
    fixed = compose(path[place], motion_to_fixes(recording, "a", of_a.time[first : first + 1])[0])
    return compose(of_a.pose[first], between(fixed, path[0])), START_SIGMAS * of_a.sigma[first]
