"""Internal position error correction: live, sample by sample, or over a whole recording at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from ipec.health import check_linkage
from ipec.readings import SampleReader, scales_of, table_of
from ipec.records import CLAPPER, OMNIMATE, PLAIN, Settings, State
from ipec.stepping import advance_all, advance_one
from vehicle.compiled import Array, Record, record

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vehicle.parameters import VehicleParameters
    from vehicle.recording import Recording
    from vehicle.sample import Sample

Method = Literal[
    "plain",
    "clapper",
    "clapper-as-printed",
    "omnimate",
    "omnimate-previous-b",
    "omnimate-printed-sign",
    "omnimate-as-printed",
]
METHODS: tuple[Method, ...] = get_args(Method)

ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class IpecState:
    """Where both trucks are after a sample; never changed, each step returns another.

    Attributes:
        record: read-only, one `ipec.records.State`.
    """

    record: Record

    @property
    def pose_a(self) -> Array:
        """Pose `(3,)` of truck a."""
        return np.asarray(self.record["pose"][0, 0])

    @property
    def pose_b(self) -> Array:
        """Pose `(3,)` of truck b; nan until the linkage has been read."""
        return np.asarray(self.record["pose"][0, 1])

    @property
    def corrections(self) -> tuple[float, float]:
        """What the last sample added to the headings of truck a and b [rad]."""
        a, b = self.record["correction"][0].tolist()
        return a, b


@dataclass(frozen=True, slots=True)
class Trajectory:
    """The poses of both trucks at every sample of a recording.

    Attributes:
        time: (N,) [s].
        pose_a: (N, 3); headings are continuous.
        pose_b: (N, 3); nan until the linkage has been read.
        corrections: (N, 2) added to the headings of truck a and b in each sample [rad].
        taken_back: (N,) travel of truck a taken back in each sample, C (14) [m].
    """

    time: Array
    pose_a: Array
    pose_b: Array
    corrections: Array
    taken_back: Array


def settings_of(vehicle: VehicleParameters, method: Method) -> Record:
    """Return the settings record `(1,)` of a method.

    Raises:
        NoLinkageError: the robot has a single truck.
    """
    scales = scales_of(vehicle)
    settings = record(Settings)
    own = settings[0]
    for name in scales.dtype.names or ():
        own[name] = scales[name][0]
    laws = {"plain": PLAIN, "clapper": CLAPPER, "omnimate": OMNIMATE}
    own["law"] = laws[method.split("-", maxsplit=1)[0]]
    own["as_printed"] = method == "clapper-as-printed"
    own["previous_b"] = method in {"omnimate-previous-b", "omnimate-as-printed"}
    own["printed_sign"] = method in {"omnimate-printed-sign", "omnimate-as-printed"}
    if method in {"clapper", "omnimate"}:
        wheels = np.abs(own["scale"][:4]).reshape(2, 2).max(axis=1)
        own["tolerance"] = 0.5 * np.abs(own["scale"][4:6]) + wheels / own["wheelbase"]
    return settings


class Corrector:
    """One method for one robot.

    Args:
        vehicle: the robot.
        method: plain is dead reckoning alone; clapper C (9)-(16); omnimate O (1)-(6) with C (9) first;
            the others follow the print, in one of its slips or in all.

    Raises:
        NoLinkageError: the robot has a single truck.
    """

    def __init__(self, vehicle: VehicleParameters, method: Method = "clapper") -> None:
        self.settings = settings_of(vehicle, method)
        self._reader = SampleReader(vehicle)

    def start(self, pose_a: ArrayLike = ORIGIN) -> IpecState:
        """Return the state before the first sample, with truck a at a pose `(3,)`."""
        state = record(State)
        state["pose"] = np.nan
        state["pose"][0, 0] = pose_a
        return _frozen(state)

    def step(self, state: IpecState, sample: Sample) -> IpecState:
        """Return the state after a sample."""
        counts, present = self._reader.read(sample)
        following = state.record.copy()
        advance_one(self.settings, following, counts, present)
        return _frozen(following)


def correct(recording: Recording, start: ArrayLike = ORIGIN, *, method: Method = "clapper") -> Trajectory:
    """Return the poses of both trucks at every sample of a recording: what `Corrector` gives step by step.

    Args:
        recording: of a robot with two trucks.
        start: pose `(3,)` of truck a at the first sample; truck b is where the linkage says.
        method: as for `Corrector`.

    Raises:
        NoLinkageError: the robot has a single truck.
        LinkageChannelError: a channel of the linkage was never read, or was frozen; not for plain.
    """
    if method != "plain":
        check_linkage(recording)
    counts, present = table_of(recording)
    corrector = Corrector(recording.vehicle, method)
    state = corrector.start(start).record.copy()
    poses, corrections = np.empty((2, len(counts), 3)), np.empty((len(counts), 3))
    advance_all(corrector.settings, state, counts, present, poses, corrections)
    return Trajectory(recording.time, poses[0], poses[1], corrections[:, :2], corrections[:, 2])


def _frozen(state: Record) -> IpecState:
    state.flags.writeable = False
    return IpecState(state)
