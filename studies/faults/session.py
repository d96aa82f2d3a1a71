"""One session: the driver on a world, an operator who drives, and the laws that are checked all the time."""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from random import Random
from tempfile import TemporaryDirectory

import numpy as np

from omnimate.driver.errors import DriverError, DrivesStopped
from omnimate.driver.robot.driver import Driver, open_driver
from omnimate.driver.robot.events import Event
from omnimate.driver.robot.recorder import Recorder
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.sample import Sample
from studies.faults.laws import PoseLaw, expectation, is_explained
from studies.faults.script import QUIET, ROBOTS, Fault, Script
from studies.faults.world import START, World, in_time_of

URL = "virtual://simulated"
PHASES = ("configuration", "running", "recovery", "stopping")
PAUSE = 1.0  # [s] until the operator tries again
REPORT_TIME = 3.0  # [s] after a fault until when it must be reported
STOP_TIME = 0.1  # [s] from a drive's fault until all wheels are commanded to stop
COAST_TIME = 1.5  # [s] without a command until all wheels stand: the drives' watchdog of 0.5 s and a ramp
RECORDED = 4  # sessions, of which one is recorded to the disk
WATCH = 1.0  # [s] between two looks at the reports
SETTLE = 10.0  # [s] at the end in which everything must work
STOPS = frozenset(
    {"emcy", "trip", "reboot", "silence", "nmt stop", "nmt pre-operational", "nmt reset", "nmt communication"}
)
SHORTEST_STOP = 0.15  # [s] of a silence that must stop the robot


@dataclass
class Outcome:
    """What has become of a session.

    Attributes:
        script: The session.
        violations: Laws that were broken, with the time [s].
        digest: SHA-256 of samples, reports and states.
        injected: Faults by kind and phase.
        expected: Those that must be reported, whatever else happens.
        reported: Those of them that were.
        worst: Largest error of a step of the pose without lost samples [m].
    """

    script: Script
    violations: list[str] = field(default_factory=list)
    digest: str = ""
    injected: Counter[tuple[str, str]] = field(default_factory=Counter)
    expected: Counter[tuple[str, str]] = field(default_factory=Counter)
    reported: Counter[tuple[str, str]] = field(default_factory=Counter)
    worst: float = 0.0


def run(script: Script) -> Outcome:
    """Run a session and return what has become of it."""
    return _Session(script).run()


class _Session:
    def __init__(self, script: Script) -> None:
        self.outcome = Outcome(script)
        self._script, self._random = script, Random(script.seed)
        self._world = World(ROBOTS[script.robot](), script.faults, script.seed)
        self._world.on_fault, self._world.on_step = self._on_fault, self._on_step
        self._vehicle = self._world.vehicle
        self._drive_nodes = {drive.node for drive in self._vehicle.drives}
        self._hash = hashlib.sha256()
        self._driver: Driver | None = None
        self._is_configuring = True
        self._all_present = False
        self._errors: list[Event] = []
        self._samples: list[Sample] = []
        self._seen: dict[tuple[int | None, str], int] = {}
        self._commanded = -math.inf
        self._speeds, self._speeds_until = (0.0, 0.0), -math.inf
        self._end = START + script.length

    def run(self) -> Outcome:
        with in_time_of(self._world):
            self._world.start()
            while self._world.now < self._end:
                self._open()
        self.outcome.digest = self._hash.hexdigest()
        return self.outcome

    # The operator

    def _open(self) -> None:
        """Open a driver and drive, until the end or until the driver gives up."""
        self._is_configuring = True
        with TemporaryDirectory() as folder, self._recorder(folder) as recorder:
            try:
                driver, _ = open_driver(self._vehicle, URL, recorder)
            except DriverError as error:
                self._note(error)
                self._world.sleep(PAUSE)
                return
            self._run_driver(driver)
            if recorder is not None and all(fault.kind != "sync" for fault in self._script.faults):
                recorder.close()
                self._check_recording(load_recording(folder))

    def _recorder(self, folder: str) -> AbstractContextManager[Recorder | None]:
        """Return a recorder in one session of `RECORDED`."""
        return nullcontext() if self._script.seed % RECORDED else Recorder(folder, self._vehicle)

    def _run_driver(self, driver: Driver) -> None:
        self._driver, self._seen, self._samples = driver, {}, []
        try:
            with driver:
                self._drive(driver)
                self._is_configuring = False
        except DriverError as error:
            self._note(error)
        finally:
            self._watch(driver)
            self._driver = None

    def _drive(self, driver: Driver) -> None:
        poses = [PoseLaw(self._world, truck) for truck in self._vehicle.trucks]
        try_at, watch_at = self._world.now, self._world.now + WATCH
        settled = self._world.now
        while (now := self._world.now) < self._end:
            if not driver.drives.is_enabled and now >= try_at:
                try_at = now + PAUSE
                self._enable(driver)
            self._is_configuring = False
            sample = driver.cycle()
            if driver.drives.is_enabled:
                try_at = sample.time + PAUSE
                self._command(driver)
            self._samples.append(sample)
            self._hash.update(repr((sample.index, sample.time, sample.counts, sample.present)).encode())
            self._all_present = all(sample.present)
            for pose in poses:
                if broken := pose.check(sample, self._script.faults):
                    self._violate(broken)
            if not (self._all_present and driver.drives.is_enabled):
                settled = sample.time
            if now >= watch_at:
                watch_at = now + WATCH
                self._watch(driver)
        self.outcome.worst = max(self.outcome.worst, *(pose.worst for pose in poses))
        if settled > self._end - SETTLE and self._script.length >= QUIET:
            self._violate("not all nodes and drives work long after the last fault")

    def _enable(self, driver: Driver) -> None:
        self._is_configuring = True
        try:
            driver.enable()
        except DriverError as error:
            self._note(error)

    def _command(self, driver: Driver) -> None:
        now = self._world.now
        if now >= self._speeds_until:
            self._speeds_until = now + self._random.uniform(0.5, 4.0)
            left = self._random.choice((0.0, self._random.uniform(-5.0, 5.0), self._random.uniform(0.0, 5.0)))
            self._speeds = left, left and left + self._random.choice((0.0, self._random.uniform(-1.0, 1.0)))
        try:
            driver.command(self._speeds * len(self._vehicle.trucks))
        except DrivesStopped as error:
            self._note(error)
            return
        if any(self._speeds):
            self._commanded = now

    # The laws

    @property
    def _phase(self) -> str:
        if self._is_configuring or self._driver is None:
            return "configuration"
        if not self._driver.drives.is_enabled and any(self._world.speeds):
            return "stopping"
        return "running" if self._all_present and self._driver.drives.is_enabled else "recovery"

    def _violate(self, law: str) -> None:
        self.outcome.violations.append(f"{self._world.now - START:.3f} s: {law}")

    def _note(self, error: DriverError) -> None:
        self._hash.update(f"{self._world.now} {error}".encode())
        self._errors.append(
            Event(self._world.now, self._world.now, 1, getattr(error, "node", None), str(error))
        )

    def _on_step(self) -> None:
        if any(self._world.speeds) and self._world.now - self._commanded > COAST_TIME:
            self._violate(f"wheels turn at {self._world.speeds} rad/s without a command")
            self._commanded = math.inf  # reported once

    def _on_fault(self, fault: Fault) -> None:
        phase, driver = self._phase, self._driver
        self._hash.update(repr((self._world.now, fault, phase)).encode())
        self.outcome.injected[fault.kind, phase] += 1
        if driver is None or phase != "running":
            return
        is_drive = fault.node in self._drive_nodes
        awaited = expectation(fault, self._script.faults, is_drive=is_drive)
        if awaited is None:
            return
        self.outcome.expected[fault.kind, phase] += 1
        at = self._world.now
        self._world.at(at + fault.duration + REPORT_TIME, lambda: self._check_report(fault, phase, awaited))
        is_long = fault.kind != "silence" or fault.duration > SHORTEST_STOP
        if is_drive and fault.kind in STOPS and is_long:
            self._world.at(at + STOP_TIME, lambda: self._check_stop(fault, driver))

    def _check_report(self, fault: Fault, phase: str, awaited: Callable[[Event], bool]) -> None:
        events = (*self._errors, *(self._driver.report().events if self._driver else ()))
        if any(map(awaited, events)):
            self.outcome.reported[fault.kind, phase] += 1
        else:
            self._violate(f"{fault} is not reported")

    def _check_stop(self, fault: Fault, driver: Driver) -> None:
        if driver.drives.is_enabled:
            self._violate(f"wheels are not commanded to stop {STOP_TIME} s after {fault}")

    def _check_recording(self, recording: Recording) -> None:
        """Compare a recording with the samples that the driver gave, where a channel is present in both.

        A log knows no window: an answer after the driver has closed a sample, as after a silence or while the
        drives are enabled, may be in time there. A SYNC of another device makes a sample in a log.
        """
        if len(recording.time) < len(self._samples):
            self._violate(f"the recording has {len(recording.time)} samples of {len(self._samples)}")
        for row, sample in enumerate(self._samples[: len(recording.time)]):
            is_both = recording.present[row] & np.array(sample.present)
            if (recording.counts[row] != sample.counts)[is_both].any():
                counts = recording.counts[row].tolist()
                here = f"{sample.counts}, {sample.present} at {sample.time - START:.3f} s"
                self._violate(f"the recording differs from the sample: {counts}; {here}")
                return

    def _watch(self, driver: Driver) -> None:
        """Look at what was reported since the last time."""
        for event in driver.report().events:
            if self._seen.get((event.node, event.what)) != event.count:
                self._seen[event.node, event.what] = event.count
                self._hash.update(repr(event).encode())
                if not is_explained(event, self._script.faults, self._vehicle):
                    self._violate(f"no fault explains the report {event}")
