"""Record of a program's laps and absolute fixes for the recording folder."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from omnimate.vehicle.recording import Lap, Poses, Run

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from omnimate.motion.program import Program
    from omnimate.motion.runner import Runner
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Direction


class LapRecorder(Protocol):
    """Interface to store laps and fixes; implemented by `omnimate.driver.robot.recorder.Recorder`."""

    def lap(self, direction: Direction, start: float, end: float) -> object:
        """Store a finished lap, with the times of its start and end [s]."""
        ...

    def pose(self, at: float, truck: TruckName, pose: Sequence[float], sigma: Sequence[float]) -> object:
        """Store a truck's absolute pose x, y, theta [m, m, rad] and its standard deviations."""
        ...


class Journal:
    """Records laps and fixes while a runner drives a program; call `observe` after each of its steps.

    `lap` is the one that is being driven, from 0; None between laps.
    """

    def __init__(self, program: Program, recorder: LapRecorder | None = None) -> None:
        """Begin the journal of a program; a recorder receives each lap and each fix at once."""
        self.program = program
        self.lap: int | None = None
        self._recorder = recorder
        self._laps: list[Lap] = []
        self._fixes: list[tuple[float, TruckName, ArrayLike, ArrayLike]] = []
        self._started = 0.0

    def observe(self, time: float, runner: Runner) -> None:
        """Record the start or the end of a lap at the time of the sample [s]."""
        if runner.lap == self.lap:
            return
        if self.lap is not None:
            lap = Lap(self.program.directions[self.lap], self._started, time)
            self._laps.append(lap)
            if self._recorder is not None:
                self._recorder.lap(lap.direction, lap.start, lap.end)
        self.lap, self._started = runner.lap, time

    def fix(self, time: float, truck: TruckName, pose: ArrayLike, sigma: ArrayLike) -> None:
        """Record an absolute pose `(3,)` of a truck and its standard deviations `(3,)`, nan where unknown."""
        self._fixes.append((time, truck, pose, sigma))
        if self._recorder is not None:
            numbers = np.array([pose, sigma], np.float64).tolist()
            self._recorder.pose(time, truck, *numbers)

    @property
    def run(self) -> Run:
        """The laps finished so far."""
        return Run(self.program.protocol, self.program.side, tuple(self._laps))

    @property
    def poses(self) -> Poses | None:
        """The fixes so far, in order; None where there are none."""
        if not self._fixes:
            return None
        times, trucks, poses, sigmas = zip(*self._fixes, strict=True)
        return Poses(
            np.array(times, np.float64),
            np.array(trucks),
            np.array(poses, np.float64).reshape(-1, 3),
            np.array(sigmas, np.float64).reshape(-1, 3),
        )
