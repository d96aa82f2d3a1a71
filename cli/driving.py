"""Driving a program on a bus, recorded and shown while it happens."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from cli.console import err, out
from motion.drive import Moment, drive
from motion.journal import Journal
from motion.runner import Runner
from vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Callable

    from driver.driver import Driver
    from driver.recorder import Recorder
    from motion.drive import Fix
    from motion.program import Program
    from vehicle.parameters import TruckName

SHOWN_EVERY = 40  # samples between two looks at the progress bar


def drive_program(
    driver: Driver,
    program: Program,
    recorder: Recorder,
    fix: Fix | None = None,
    watch: Callable[[Moment], None] = lambda _moment: None,
) -> None:
    """Enable the drives, drive a program to its end, and stop; laps and fixes are recorded as they come.

    Args:
        driver: configured.
        program: what to drive.
        recorder: gets laps and fixes; the frames reach it through the driver.
        fix: measures absolute poses; None where nothing does.
        watch: is shown every moment.
    """
    journal, runner = Journal(program), Runner(program, driver.vehicle)
    kept = _Kept(journal, recorder)
    driver.enable()
    with _progress() as bar:
        task = bar.add_task(program.protocol, total=1.0, lap="", pace="")
        start = None
        for count, moment in enumerate(drive(driver, runner, driver.vehicle, journal, fix)):
            start = moment.sample.time if start is None else start
            if moment.fix is not None or moment.lap != kept.lap:
                kept.update(moment)
            if count % SHOWN_EVERY == 0:
                driven, passed = moment.sample.time - start, bar.tasks[task].elapsed or 0.0
                pace = f"{driven / passed:.0f} x real time" if passed > 1.0 else ""
                bar.update(task, completed=runner.progress, lap=kept.words, pace=pace)
            watch(moment)
        bar.update(task, completed=1.0, lap="done")
    driver.stop()


def _progress() -> Progress:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[lap]}"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[pace]}"),
    )
    return Progress(*columns, console=err, transient=True)


class _Kept:
    """What of a journal has reached the recorder, and the return errors on the screen."""

    def __init__(self, journal: Journal, recorder: Recorder) -> None:
        self.lap: int | None = None
        self.words = "getting ready"
        self._journal, self._recorder = journal, recorder
        self._laps = self._poses = 0
        self._returned: int | None = None

    def update(self, moment: Moment) -> None:
        """Record what is new after a lap began or ended, or after a fix."""
        directions = self._journal.program.directions
        if moment.lap is None and self.lap is not None:
            self._returned = self.lap
        self.lap = moment.lap
        if self.lap is not None:
            self.words = f"{directions[self.lap]}, lap {self.lap + 1} of {len(directions)}"
        for lap in self._journal.run.laps[self._laps :]:
            self._recorder.lap(lap.direction, lap.start, lap.end)
            self._laps += 1
        poses = self._journal.poses
        if moment.fix is None or poses is None:
            return
        for row in range(self._poses, len(poses.time)):
            truck: TruckName = "a" if poses.body[row] == "a" else "b"
            self._recorder.pose(float(poses.time[row]), truck, poses.pose[row], poses.sigma[row])
        self._poses = len(poses.time)
        if self._returned is not None:
            self._show_return(moment, directions[self._returned])
            self._returned = None

    @staticmethod
    def _show_return(moment: Moment, direction: str) -> None:
        """Print the return error of a lap, absolute minus calculated, U (3.1)."""
        assert moment.fix is not None
        x, y = 1e3 * (moment.fix[0] - moment.pose[0]), 1e3 * (moment.fix[1] - moment.pose[1])
        heading = math.degrees(float(wrap(moment.fix[2] - moment.pose[2])))
        out.print(
            f"  {direction:>4}  return error of a: x {x:+7.1f} mm  y {y:+7.1f} mm  "
            f"heading {heading:+6.2f} degrees"
        )
