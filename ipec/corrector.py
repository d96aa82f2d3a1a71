"""Internal position error correction: live, sample by sample, or over a whole recording at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from omnimate.ipec.corrections import CLAPPER, OMNIMATE, PLAIN, Settings, State, advance_all, advance_one
from omnimate.ipec.linkage_check import check_linkage
from omnimate.ipec.readings import columns_of, ordered_counts, read_sample, scales_of
from omnimate.vehicle.compiled import Array, Record, record
from omnimate.vehicle.parameters import CHANNELS

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.sample import Sample

Method = Literal["plain", "clapper", "omnimate"]
METHODS: tuple[Method, ...] = get_args(Method)

ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class IpecState:
    """The poses of both trucks after a sample. Immutable: every step returns a new one."""

    record: Record  # the state as one read-only record `(1,)` of `omnimate.ipec.corrections.State`

    @property
    def pose_a(self) -> Array:
        """Pose of truck a [m, m, rad], shape `(3,)`."""
        return np.asarray(self.record["pose"][0, 0])

    @property
    def pose_b(self) -> Array:
        """Pose of truck b [m, m, rad], shape `(3,)`; nan until the linkage has been read."""
        return np.asarray(self.record["pose"][0, 1])

    @property
    def corrections(self) -> tuple[float, float]:
        """Corrections of the headings of truck a and b by the last sample [rad]."""
        a, b = self.record["correction"][0].tolist()
        return a, b


@dataclass(frozen=True, slots=True)
class Trajectory:
    """The poses of both trucks at every sample of a recording."""

    time: Array  # time of each sample on the recording's clock [s], `(N,)`
    pose_a: Array  # pose of truck a at each sample [m, m, rad], `(N, 3)`; headings are continuous
    pose_b: Array  # pose of truck b, `(N, 3)`; nan until the linkage has been read
    corrections: Array  # corrections of the headings of truck a and b in each sample [rad], `(N, 2)`
    taken_back: Array  # travel of truck a taken back in each sample, C (14) [m], `(N,)`


def settings_of(vehicle: VehicleParameters, method: Method) -> Record:
    """Return the constants of a method as one record `(1,)` of `omnimate.ipec.corrections.Settings`.

    Raises:
        NoLinkageError: The robot has a single truck.
    """
    records = scales_of(vehicle, Settings)
    settings = records[0]
    laws = {"plain": PLAIN, "clapper": CLAPPER, "omnimate": OMNIMATE}
    settings["law"] = laws[method]
    if method != "plain":
        wheels = np.abs(settings["scale"][:4]).reshape(2, 2).max(axis=1)
        settings["tolerance"] = 0.5 * np.abs(settings["scale"][4:6]) + wheels / settings["wheelbase"]
    return records


class Corrector:
    """One method of correction for one robot with two trucks.

    `plain` is dead reckoning alone; `clapper` is C (9)-(16); `omnimate` is O (1)-(6) with C (9) first.

    Raises:
        NoLinkageError: The robot has a single truck.
    """

    def __init__(self, vehicle: VehicleParameters, method: Method = "clapper") -> None:
        self.settings = settings_of(vehicle, method)
        self._columns = columns_of(vehicle, CHANNELS)

    def start(self, pose_a: ArrayLike = ORIGIN) -> IpecState:
        """Return the state before the first sample, with truck a at a pose [m, m, rad], shape `(3,)`."""
        state = record(State)
        state["pose"] = np.nan
        state["pose"][0, 0] = pose_a
        return _frozen(state)

    def step(self, state: IpecState, sample: Sample) -> IpecState:
        """Return the state after a sample; `state` is not changed."""
        following = state.record.copy()
        advance_one(self.settings, following, *read_sample(sample, self._columns))
        return _frozen(following)


def correct(recording: Recording, start: ArrayLike = ORIGIN, *, method: Method = "clapper") -> Trajectory:
    """Return the poses of both trucks at every sample of a recording: what `Corrector` gives step by step.

    `start` is the pose of truck a at the first sample [m, m, rad], shape `(3,)`; that of truck b follows from
    the linkage.

    Raises:
        NoLinkageError: The robot has a single truck.
        LinkageChannelError: A channel of the linkage was never read, or was frozen while the robot moved; not
            raised for `plain`.
    """
    if method != "plain":
        check_linkage(recording)
    counts, present = ordered_counts(recording)
    corrector = Corrector(recording.vehicle, method)
    state = corrector.start(start).record.copy()
    poses, corrections = np.empty((2, len(counts), 3)), np.empty((len(counts), 3))
    advance_all(corrector.settings, state, counts, present, poses, corrections)
    return Trajectory(recording.time, poses[0], poses[1], corrections[:, :2], corrections[:, 2])


def _frozen(state: Record) -> IpecState:
    state.flags.writeable = False
    return IpecState(state)
