"""What happened during a program: its laps and the absolute fixes, as the recording folder keeps them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vehicle.recording import Lap, Poses, Run

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from motion.program import Program
    from motion.runner import Runner
    from vehicle.parameters import TruckName


class Journal:
    """Keeps laps and fixes while a runner works; call `observe` after each of its steps."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self._laps: list[Lap] = []
        self._fixes: list[tuple[float, TruckName, ArrayLike, ArrayLike]] = []
        self.lap: int | None = None
        self._started = 0.0

    def observe(self, time: float, runner: Runner) -> None:
        """Note the beginning and the end of a lap at the time of the sample [s]."""
        if runner.lap == self.lap:
            return
        if self.lap is not None:
            self._laps.append(Lap(self.program.directions[self.lap], self._started, time))
        self.lap, self._started = runner.lap, time

    def fix(self, time: float, truck: TruckName, pose: ArrayLike, sigma: ArrayLike) -> None:
        """Note an absolute pose `(3,)` of a truck and its standard deviations `(3,)`, nan where unknown."""
        self._fixes.append((time, truck, pose, sigma))

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
