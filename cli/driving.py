"""Driving a program on a bus, with a recording and a progress bar."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

from omnimate.cli.console import out, progress_bar
from omnimate.motion.drive import Moment, drive
from omnimate.motion.journal import Journal
from omnimate.motion.runner import Runner

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.driver.robot.driver import Driver
    from omnimate.driver.robot.recorder import Recorder
    from omnimate.motion.drive import Fix
    from omnimate.motion.program import Program
    from omnimate.vehicle.recording import Direction

SHOWN_EVERY = 40  # samples between two updates of the progress bar


def drive_program(
    driver: Driver,
    program: Program,
    recorder: Recorder,
    fix: Fix | None = None,
    watch: Callable[[Moment], None] = lambda _moment: None,
    seconds: float | None = None,
) -> None:
    """Enable the drives, drive a program to its end, and stop; laps and fixes are recorded.

    `fix` measures absolute poses, `watch` is called with every moment, and after `seconds` the drive ends
    early.

    Raises:
        DrivesStopped: A drive has stopped all wheels.
    """
    journal, runner = Journal(program, recorder), Runner(program, driver.vehicle)
    screen = _Screen(program.directions)
    driver.enable()
    driver.end_after(seconds)
    with progress_bar(program.protocol) as progress:
        start, began = None, time.monotonic()
        for count, moment in enumerate(drive(driver, runner, driver.vehicle, journal, fix)):
            start = moment.sample.time if start is None else start
            screen.update(moment)
            driven = moment.sample.time - start
            if count % SHOWN_EVERY == 0:
                passed = time.monotonic() - began
                pace = f", {driven / passed:.0f} x real time" if passed > 1.0 else ""
                progress(runner.progress, 1.0, f"{program.protocol}: {screen.words}{pace}")
            watch(moment)
            if seconds is not None and driven >= seconds:
                break
    driver.drives.require_enabled()
    driver.stop()


class _Screen:
    """Which lap is being driven, in words, and the return error of each lap that has ended."""

    def __init__(self, directions: Sequence[Direction]) -> None:
        self.words = "getting ready"
        self._directions = directions
        self._lap: int | None = None
        self._ended: int | None = None

    def update(self, moment: Moment) -> None:
        """Update from a moment of the drive; print a return error at the first fix after a lap."""
        if moment.lap != self._lap:
            self._ended = self._lap if moment.lap is None else self._ended
            self._lap = moment.lap
        if self._lap is not None:
            self.words = f"{self._directions[self._lap]}, lap {self._lap + 1} of {len(self._directions)}"
        if self._ended is not None and moment.error is not None:
            _show_return(self._directions[self._ended], *moment.error)
            self._ended = None


def _show_return(direction: str, x: float, y: float, heading: float) -> None:
    out.print(
        f"  {direction:>4}  return error of a: x {1e3 * x:+7.1f} mm  y {1e3 * y:+7.1f} mm  "
        f"heading {math.degrees(heading):+6.2f} degrees"
    )
