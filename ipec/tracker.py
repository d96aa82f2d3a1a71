"""Plain odometry, IPEC and the filter side by side, live or over a recording, in rows."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ipec.corrector import ORIGIN, Corrector, correct
from ipec.estimate import NOTABLE, Disturbance, Estimate, estimate
from ipec.filter import CALIBRATED, Filter, Prior, SlowParameters
from ipec.health import LINKAGE, Frozen, frozen_channels
from vehicle.parameters import WHEELS
from vehicle.recording import Recording

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike

    from vehicle.parameters import Channel, VehicleParameters
    from vehicle.sample import Sample
    from vehicle.se2 import Array

REMEMBERED = 2000  # samples in which frozen channels are looked for


@dataclass(frozen=True, slots=True)
class Row:
    """Where the robot is by each method, and what was corrected since the row before.

    Attributes:
        time: [s].
        plain: pose `(3,)` of truck a by dead reckoning.
        ipec: by the CLAPPER's correction.
        filtered: by the filter.
        sigma: standard deviations `(3,)` of `filtered`.
        follower: pose `(3,)` of truck b by the filter.
        corrections: what IPEC added to the headings of truck a and b [rad].
        lost: travel that the filter found lost, of each of `WHEELS` [m].
    """

    time: float
    plain: Array
    ipec: Array
    filtered: Array
    sigma: Array
    follower: Array
    corrections: Array
    lost: Array

    def as_dict(self) -> dict[str, float | None]:
        """Return the row as flat names and numbers; what is not known is None."""
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
    """Follows a live robot.

    Args:
        vehicle: robot with two trucks.
        start: pose `(3,)` of truck a.
        prior: of what the vehicle's file says.

    Raises:
        NoLinkageError: the robot has a single truck.
    """

    def __init__(
        self, vehicle: VehicleParameters, start: ArrayLike = ORIGIN, *, prior: Prior = CALIBRATED
    ) -> None:
        self.vehicle = vehicle
        self._plain, self._ipec = Corrector(vehicle, "plain"), Corrector(vehicle)
        self._filter = Filter(vehicle, prior=prior)
        self._states = self._plain.start(start), self._ipec.start(start), self._filter.start(start)
        self._corrections, self._lost = np.zeros(2), np.zeros(4)
        self._ended: list[Disturbance] = []
        self._open: dict[Channel, Disturbance] = {}
        self._samples: deque[Sample] = deque(maxlen=REMEMBERED)

    def step(self, sample: Sample) -> None:
        """Take a sample."""
        plain, ipec, filtered = self._states
        filtered = self._filter.step(filtered, sample)
        ipec = self._ipec.step(ipec, sample)
        self._states = self._plain.step(plain, sample), ipec, filtered
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
        elif going_on and going_on.lost >= NOTABLE:
            self._ended.append(going_on)

    @property
    def started(self) -> bool:
        """Whether there was a sample."""
        return bool(self._samples)

    @property
    def slow(self) -> SlowParameters:
        """The filter's slow parameters."""
        return self._states[2].slow

    def take_disturbances(self) -> tuple[Disturbance, ...]:
        """Return the disturbances that have ended since the last call."""
        ended, self._ended = tuple(self._ended), []
        return ended

    def look(self) -> Row:
        """Return where the robot is after the last sample."""
        plain, ipec, filtered = self._states
        return Row(
            self._samples[-1].time,
            plain.pose_a,
            ipec.pose_a,
            filtered.pose("a"),
            filtered.sigma("a"),
            filtered.pose("b"),
            self._corrections,
            self._lost,
        )

    def row(self) -> Row:
        """Return the same, and begin a new row."""
        row = self.look()
        self._corrections, self._lost = np.zeros(2), np.zeros(4)
        return row

    def frozen(self) -> tuple[Frozen, ...]:
        """Return where channels of the linkage stood still in the last samples although they must have moved.

        A channel that was not read at all is told with nothing expected.
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
        missing = [one for one in LINKAGE if not recording.is_present(one).any()]
        if missing or not recording.present.all(axis=1).any():
            return tuple(Frozen(channel, first, last, 0.0) for channel in missing)
        return frozen_channels(recording)


def track_recording(
    recording: Recording, every: float, start: ArrayLike = ORIGIN, *, prior: Prior = CALIBRATED
) -> tuple[Iterator[Row], Estimate]:
    """Return rows every so many seconds (0 for every sample), and the filter's estimate.

    Raises:
        NoLinkageError: the robot has a single truck.
        LinkageChannelError: a channel of the linkage was never read, or was frozen.
    """
    plain, ipec = correct(recording, start, method="plain"), correct(recording, start)
    filtered = estimate(recording, start, prior=prior)
    turn = np.floor((recording.time - recording.time[0]) / every) if every else np.arange(len(recording))
    ends = np.append(np.flatnonzero(np.diff(turn)), len(recording) - 1)
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
