"""One session: the driver on a world, an operator who drives, and the laws that are checked all the time."""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
from tempfile import TemporaryDirectory

import numpy as np

from omnimate.driver.errors import DriverError, DrivesStopped
from omnimate.driver.robot.driver import Driver, open_driver
from omnimate.driver.robot.events import Event
from omnimate.driver.robot.recorder import Recorder
from omnimate.files.recordings.folder import LOG, load_recording
from omnimate.vehicle.bridging import RATIO_WINDOW
from omnimate.vehicle.errors import OmnimateError, RecordingError
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.sample import Sample
from studies.faults.laws import ACKNOWLEDGED, AFTERMATH, PoseLaw, expectation, is_explained
from studies.faults.script import DISK_FAULTS, QUIET, ROBOTS, Fault, Script
from studies.faults.world import START, PowerCut, World, in_time_of

URL = "virtual://simulated"
PHASES = ("configuration", "running", "recovery", "stopping")
PAUSE = 1.0  # [s] until the operator tries again
REPORT_TIME = 3.0  # [s] after a fault until when it must be reported
STOP_TIME = 0.1  # [s] from a drive's fault until all wheels are commanded to stop
COAST_TIME = 1.5  # [s] without a command until all wheels stand: the drives' watchdog of 0.5 s and a ramp
BOOT = 3.0  # [s] after a power cut until the driver is started again
RECORDED = 4  # sessions without a fault of the disk, of which one is recorded
LOG_STEP = 1e-6  # [s], the last digit of a log: two SYNCs may be close together after a late one
WATCH = 1.0  # [s] between two looks at the reports
SETTLE = 10.0  # [s] at the end in which everything must work
STOPS = frozenset(
    {"emcy", "trip", "reboot", "silence", "nmt stop", "nmt pre-operational", "nmt reset", "nmt communication"}
)
SHORTEST_STOP = 0.15  # [s] of a silence that must stop the robot


@dataclass
class Outcome:
    """What has become of a session."""

    script: Script  # the session
    violations: list[str] = field(default_factory=list)  # laws that were broken, with the time [s]
    digest: str = ""  # SHA-256 of samples, reports and states
    injected: Counter[tuple[str, str]] = field(default_factory=Counter)  # faults by kind and phase
    # those that must be reported, whatever else happens
    expected: Counter[tuple[str, str]] = field(default_factory=Counter)
    reported: Counter[tuple[str, str]] = field(default_factory=Counter)  # those of them that were
    worst: float = 0.0  # largest error of a step of the pose without lost samples [m]


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
        self._poses = [PoseLaw(self._world, truck) for truck in self._vehicle.trucks]
        self._driver: Driver | None = None
        self._is_configuring = True
        self._all_present = False
        self._errors: list[Event] = []
        self._samples: list[Sample] = []
        self._recorder: Recorder | None = None
        self._opened = START  # when the last recording began [s]
        self._restarts = [START + at for at in script.restarts]
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
        """Open a driver and drive, until the end or until the driver or its computer gives up."""
        self._is_configuring, self._samples, self._opened = True, [], self._world.now
        with TemporaryDirectory() as folder:
            try:
                self._recorder = self._new_recorder(folder)
                driver, _ = open_driver(self._vehicle, URL, self._recorder)
                self._run_driver(driver)
            except (DriverError, RecordingError) as error:
                self._note(error)
                self._world.sleep(PAUSE)
            except PowerCut:
                self._hash.update(self._world.torn)
            if self._recorder is not None:
                self._end_recording(self._recorder)
        if self._world.cut_at is not None:
            self._world.sleep(BOOT)
            self._world.cut_at = None

    def _new_recorder(self, folder: str) -> Recorder | None:
        """Return a recorder where the disk fails, and in one session of `RECORDED`; None where it is full."""
        if self._script.seed % RECORDED and all(
            fault.kind not in DISK_FAULTS for fault in self._script.faults
        ):
            return None
        try:
            return Recorder(folder, self._vehicle)
        except RecordingError as error:
            self._note(error)
            return None

    def _end_recording(self, recorder: Recorder) -> None:
        """Close a recording and check it; after a power cut, what is left of it."""
        self._recorder = None
        try:
            recorder.close()
        except RecordingError as error:
            self._note(error)
        if self._world.cut_at is not None:
            (recorder.folder / LOG).write_bytes(self._world.torn)
        acknowledged = self._acknowledged()
        if acknowledged and all(fault.kind != "sync" for fault in self._script.faults):
            try:
                self._check_recording(load_recording(recorder.folder), acknowledged)
            except OmnimateError as error:
                self._violate(f"the recording cannot be read: {error}")

    def _acknowledged(self) -> list[Sample]:
        """Return the samples that the recorder must have put on the disk."""
        cut = self._world.cut_at
        lost = [(START + at - ACKNOWLEDGED, START + end + ACKNOWLEDGED) for at, end in self._full()]
        if cut is not None:
            lost.append((cut - ACKNOWLEDGED, math.inf))
        return [
            sample for sample in self._samples if not any(start < sample.time < end for start, end in lost)
        ]

    def _full(self) -> list[tuple[float, float]]:
        """Return from when until when the disk is full [s]."""
        faults = self._script.faults
        return [(fault.at, fault.at + fault.duration) for fault in faults if fault.kind == "disk full"]

    def _run_driver(self, driver: Driver) -> None:
        self._driver, self._seen = driver, {}
        for pose in self._poses:
            pose.begin()
        try:
            with driver:
                self._drive(driver)
                self._is_configuring = False
        except DriverError as error:
            self._note(error)
        finally:
            self._watch(driver)
            self._errors += driver.report().events
            self._driver = None

    def _drive(self, driver: Driver) -> None:
        try_at, watch_at = self._world.now, self._world.now + WATCH
        settled = self._world.now
        while (now := self._world.now) < self._end:
            if self._is_restarted(driver, now):
                return
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
            for pose in self._poses:
                if broken := pose.check(sample, self._script.faults):
                    self._violate(broken)
            if not (self._all_present and driver.drives.is_enabled):
                settled = sample.time
            if now >= watch_at:
                watch_at = now + WATCH
                self._watch(driver)
        self.outcome.worst = max(self.outcome.worst, *(pose.worst for pose in self._poses))
        if settled > self._end - SETTLE and self._script.length >= QUIET:
            self._violate("not all nodes and drives work long after the last fault")

    def _is_restarted(self, driver: Driver, now: float) -> bool:
        """Disable the drives where the operator wants to; return whether another driver is wanted."""
        if not self._restarts or now < self._restarts[0]:
            return False
        self._restarts.pop(0)
        if self._random.random() < 0.5:
            return True
        driver.drives.disable()
        return False

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

    def _note(self, error: OmnimateError) -> None:
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
        end = fault.at + fault.duration + REPORT_TIME
        is_restarted = any(fault.at - PAUSE < at < end for at in self._script.restarts)
        is_unrecorded = fault.kind == "disk full" and self._recorder is None
        if awaited is None or is_restarted or is_unrecorded:
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

    def _check_recording(self, recording: Recording, samples: list[Sample]) -> None:
        """Compare a recording with samples that must be in it, where a channel is present in both.

        A log knows no window: an answer after the driver has closed a sample, as after a silence or while the
        drives are enabled, may be in time there. Next to a sample without a channel, the driver may therefore
        take an answer for that to the next SYNC. A SYNC of another device makes a sample in a log. What a
        channel has counted before the first sample is no travel: a log may hold frames of before the driver's
        first sample. Nor is what a restart is bridged with, if one of the two has had other readings.
        """
        full = min((START + at for at, _ in self._full() if START + at > self._opened), default=math.inf)
        rows = np.searchsorted(recording.time, [sample.time - LOG_STEP for sample in samples]).tolist()
        reboots = [gap for gap in recording.gaps if gap.reason == "reboot"]
        bridges = sorted(reboots, key=lambda gap: gap.end)
        window = (RATIO_WINDOW + 1) * self._vehicle.bus.sync_period
        present = np.array([sample.present for sample in samples])
        steady = present.copy()  # also in the samples before and after
        steady[1:] &= present[:-1]
        steady[:-1] &= present[1:]
        before: dict[int, int] = {}  # difference of a channel's counts
        unlike = -math.inf  # time of the last sample of which either has other channels [s]
        for row, sample, channels in zip(rows, samples, steady, strict=True):
            if row == len(recording.time) or recording.time[row] > sample.time + LOG_STEP:
                self._violate(f"the recording has no sample of {sample.time - START:.3f} s")
                return
            if sample.time > full:
                continue
            if tuple(recording.present[row]) != sample.present:
                unlike = sample.time
            while bridges and bridges[0].end < sample.time + LOG_STEP:
                bridge = bridges.pop(0)
                if unlike > bridge.start - window:
                    before.pop(self._vehicle.channels.index(bridge.channel), None)
            counts = recording.counts[row].tolist()
            for channel in np.flatnonzero(recording.present[row] & channels).tolist():
                difference = counts[channel] - sample.counts[channel]
                if before.setdefault(channel, difference) != difference:
                    here = f"{sample.counts}, {sample.present} at {sample.time - START:.3f} s"
                    self._violate(f"the recording differs from the sample: {counts}; {here}")
                    return

    def _watch(self, driver: Driver) -> None:
        """Look at what was reported since the last time."""
        for event in driver.report().events:
            if self._seen.get((event.node, event.what)) != event.count:
                self._seen[event.node, event.what] = event.count
                self._hash.update(repr(event).encode())
                if not (
                    self._is_of_restart(event) or is_explained(event, self._script.faults, self._vehicle)
                ):
                    self._violate(f"no fault explains the report {event}")

    def _is_of_restart(self, event: Event) -> bool:
        """Return whether drives report that the heartbeat of the driver before has ended, or is back.

        They report the end at once, and that it is back when the next driver enables them: a fault of another
        node may delay its configuration.
        """
        within = AFTERMATH if event.what.startswith("EMCY 0000h") else PAUSE
        return "EMCY" in event.what and any(
            START + at <= event.time <= event.last <= START + at + within for at in self._script.restarts
        )
