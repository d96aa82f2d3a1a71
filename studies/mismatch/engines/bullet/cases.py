"""The cases of the world in PyBullet: robots in turn, courses, floors, measurements, and what is built in.

Changes by a fault are those of the true motion: the drive of the robot with the fault less that of its
healthy twin, both on a plane. They are measured in standard deviations of what floor and sensors add to the
recording (`engines.strength`), and compared with what each effect of the vocabulary would change.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from studies.mismatch.engines.bullet import faults
from studies.mismatch.engines.bullet.chassis import ROBOTS, Chassis
from studies.mismatch.engines.bullet.drive import Course, Floor, TippedError, drive
from studies.mismatch.engines.bullet.faults import Fault, Setting
from studies.mismatch.engines.laws import altered
from studies.mismatch.engines.programmes import PROGRAMMES, Lap, commands, eight
from studies.mismatch.engines.rivals import SEPARATE, rivals
from studies.mismatch.engines.scene import SEEDS, START
from studies.mismatch.engines.strength import Drive as Seen
from studies.mismatch.engines.strength import Noise, Ruler, left_of, residual
from studies.mismatch.engines.true_motion import Drive, Nominal, axle_ahead, calibrate
from studies.mismatch.engines.vocabulary import CLEAR, LINKAGE, WHEELS, Array, case_label, label
from studies.mismatch.engines.wide.robots import COUNTS, JOINTS, METRES, within
from studies.mismatch.engines.writing import Log, Measuring, Robot, measured, seen, seen_exactly, write
from studies.mismatch.engines.writing import encoders as drawn_encoders

Name = tuple[str, str]
Build = Callable[[Setting], Fault]

# Share of a change without a law that a name may leave; it then explains three quarters of its power.
MOST = 0.5
# What contacts do to every robot: tyres creep, skid and scrub.
BACKGROUND = ("lateral_slip", "traction_slip", "turn_scrub", "wheelbase")


def alike(
    change: Array, effect: str, component: str, more: Mapping[str, Any], healthy: Seen, ruler: Ruler
) -> tuple[bool, list[dict[str, Any]]]:
    """Return whether an effect's law explains its change, and the effects that count as right in its place.

    A law that leaves more than half of the whitened change `(K,)` does not explain it: the effect then is
    none of the vocabulary, whatever was built in. An effect whose law explains its change is matched by what
    explains it as well, up to 3 standard deviations; a change without a law by what explains most of it.
    `more` has the effect's parameters; of something unknown, the intervals in which it acts.
    """
    moments = "slip_patch" if effect == "unknown" and more.get("intervals") else effect
    columns = rivals(moments, more, [healthy], ruler)
    leaves = {name: left_of(change, change_of) for name, change_of in columns.items()}
    half = MOST * float(np.linalg.norm(change))
    change_of = leaves.get((effect, component), np.inf)
    named = change_of <= max(half, SEPARATE)
    most = np.hypot(change_of, SEPARATE) if named else max(half, SEPARATE)
    return named, [
        {"effect": name, "component": place, "leaves": round(left, 2)}
        for (name, place), left in leaves.items()
        if left < most and (name, place) != (effect, component)
    ]


def background(healthy: Seen, ruler: Ruler, missed: Array) -> list[dict[str, Any]]:
    """Return what is true of the healthy robot beside any fault: naming it is right, missing it no mistake.

    `missed` is what dead reckoning misses of it, whitened, shape `(K,)`.
    """
    columns = {
        name: change for name, change in rivals("", {}, [healthy], ruler).items() if name[0] in BACKGROUND
    }
    whole = float(np.linalg.norm(missed))
    present = [
        {"effect": name, "component": place, "explains": round(explained, 2)}
        for (name, place), change in columns.items()
        if (explained := float(np.sqrt(max(0.0, whole**2 - left_of(missed, change) ** 2)))) > SEPARATE
    ]
    left = left_of(missed, [column for change in columns.values() for column in change])
    if left > CLEAR:
        places = sorted({place for _, place in columns})  # trucks and wheels
        present += [
            {"effect": name, "component": place, "explains": round(left, 2)}
            for place in places
            for name in ("unknown", "law")
        ]
    return present


KINDS = {"null": 0.25, "single": 0.6, "multi": 0.15}  # shares of the cases; single ones may have no name
ROLLING: tuple[Build, ...] = (
    faults.wheel_diameter,
    faults.wheel_eccentricity,
    faults.wheelbase,
    faults.bump,
    faults.tyre_loses_air,
    faults.wheel_misalignment,
    faults.count_loss,
    faults.latency,
)
SKIDDING: tuple[Build, ...] = (
    faults.wheel_diameter,
    faults.one_tyre,
    faults.wheelbase,
    faults.payload_moves,
    faults.slippery,
    faults.tyre_loses_air,
    faults.count_loss,
)
LINKED: tuple[Build, ...] = (
    faults.joint_bias,
    faults.joint_eccentricity,
    faults.joint_backlash,
    faults.link_bias,
)
DRAGGED: tuple[Build, ...] = (faults.slippery, faults.dragging)  # of a tug whose tyres creep

SLOPES, SMOOTH = (5e-4, 6e-3), (2e-4, 1.5e-3)  # of floors; where wheels skid, rough ones lift them
SPEEDS, TALL = (0.12, 0.5), (0.1, 0.25)  # [m/s]; R2D2 falls over at more
SERVOS = (0.2, 0.6), (0.5, 1.5)  # [m/s^2], [rad/s^2]
PERIODS = (0.02, 0.025, 0.04, 0.05)  # [s]
DURATIONS = (40.0, 75.0)  # [s] of driving, without stops
EIGHT = 0.6  # [m], radius of the eight of a calibration
SKIDDING_BASE = 1.5  # wheelbase over distance of the wheels, before a robot that skids is calibrated
RUBBER = (0.03, 0.08)  # [m/s] of slip at which a tug's tyres have 0.7 of their grip, where they creep
BENT = 1.2  # [rad] of a joint beyond which a drive is drawn again
PLACES, HEADINGS = (1e-3, 3e-3), (1e-3, 5e-3)  # [m], [rad] of measured poses, as they are and as is stated
DENSE = 0.1  # [s] between poses that are not at stops
PLANE = Floor(0.0)


@dataclass(frozen=True, slots=True)
class _Case:
    """What is drawn before anything is built in."""

    setting: Setting
    robot: Robot
    course: Course
    measuring: Measuring | None
    floor: Floor
    ahead: Array

    def driven(self, chassis: Chassis, floor: Floor, hidden: Sequence[Fault]) -> Drive:
        """Return a drive with faults, its poses where the truck turns about its axle."""
        for fault in hidden:
            chassis = fault.build(chassis)
        floor = replace(floor, boxes=tuple(box for fault in hidden for box in fault.boxes))
        hooks = [hook for fault in hidden for hook in fault.hooks]
        return _at(drive(chassis, floor, self.course, self.setting.nominal, hooks), self.ahead)

    def log(self, driven: Drive, counts: NDArray[np.int64] | None = None) -> Log:
        """Return a drive as it is recorded; without counts, for what needs none."""
        counts = np.zeros((len(driven.time), 0), np.int64) if counts is None else counts
        start, period = self.setting.start, self.course.period
        laps = [
            (name, start + first * period, start + last * period) for name, first, last in self.course.laps
        ]
        return Log(driven.time + start, counts, driven.poses, laps)

    def seen(self, driven: Drive, hidden: Sequence[Fault]) -> Seen:
        """Return a drive as sensors with these faults, and no other error, see it; poses as they are."""
        linkage = driven.linkage[:, : 3 * (self.robot.trucks - 1)]
        log = self.log(driven)
        poses = measured(self.robot, log, self.measuring, None)
        view = seen_exactly(self.robot, log.time, driven.wheels, linkage, poses)
        for fault in hidden:
            if fault.sensed is not None:
                view = altered(view, fault.effect, fault.component, fault.sensed)
        return view

    def recorded(self, driven: Drive, hidden: Sequence[Fault], chance: Generator) -> Log:
        """Return a drive with faults as it is recorded, in counts; the linkage's readings scatter."""
        robot, view = self.robot, self.seen(driven, hidden)
        values = dict(zip(WHEELS, (view.way / view.radius).T, strict=False))
        values |= (
            dict(zip(LINKAGE, (view.reading - (0.0, 0.0, robot.length)).T, strict=True))
            if robot.length
            else {}
        )
        counts = [
            device.counted(
                values[device.channel],
                robot.jitter * chance.normal(size=len(view.time)) if device.channel in LINKAGE else 0.0,
            )
            for device in robot.devices
        ]
        return self.log(driven, np.stack(counts, axis=1))


def make(
    folder: Path, seed: int, number: int, measuring: Measuring | None = None, *, faultless: bool = False
) -> dict[str, Any]:
    """Write the recording of a case into a folder, and return its label."""
    chance = np.random.default_rng([seed, number, 8])
    kind = "null" if faultless else str(chance.choice(list(KINDS), p=list(KINDS.values())))
    while True:
        try:
            case = _case(chance, list(ROBOTS)[number % len(ROBOTS)], seed, number)
            hidden = _hidden(case.setting, kind)
            chassis, healthy = case.setting.chassis, case.setting.healthy
            alone = [healthy if fault.sensed else case.driven(chassis, PLANE, [fault]) for fault in hidden]
            driven = case.driven(chassis, case.floor, hidden)
        except TippedError:
            continue
        case = case if measuring is None else replace(case, measuring=measuring)
        return _written(folder / "1", case, hidden, alone, driven)


def _case(chance: Generator, name: str, seed: int, number: int) -> _Case:
    """Return a robot, calibrated, and its drive on a plane; TippedError where it fell over or folded."""
    chassis = ROBOTS[name](chance)
    if name == "tug" and chance.random() < 0.5:
        chassis = replace(chassis, creep=within(chance, RUBBER))
    course, calibrating = _courses(chance, chassis)
    first = Nominal(
        np.array([wheel.radius for wheel in chassis.wheels.values()]),
        np.array(chassis.tracks) * (SKIDDING_BASE if chassis.skids else 1.0),
        chassis.link,
    )
    known = drive(chassis, PLANE, calibrating, first)
    ahead = axle_ahead(known) if chassis.skids else np.zeros(chassis.trucks)
    nominal = calibrate(_at(known, ahead), chassis.link)
    start = START + 1000.0 * ((10_000 * seed + number) % SEEDS)
    healthy = _at(drive(chassis, PLANE, course, nominal), ahead)
    if np.abs(healthy.linkage[:, :2]).max() > BENT:
        raise TippedError("the trucks folded")
    floor = Floor(within(chance, SMOOTH if chassis.skids else SLOPES), number)
    return _Case(
        Setting(chance, nominal, healthy, start, chassis),
        _robot(chance, chassis, nominal, course.period),
        course,
        _measuring(chance, chassis.trucks),
        floor,
        ahead,
    )


def _courses(chance: Generator, chassis: Chassis) -> tuple[Course, Course]:
    """Return a course, and one for the calibration of the robot: a lap of the first and an eight."""
    speed = within(chance, TALL if chassis.name == "r2d2" else SPEEDS)
    laps = _laps(chance, speed, chassis.trucks)
    period, angles = float(chance.choice(PERIODS)), chance.uniform(-3.0, 3.0, 2 * chassis.trucks)
    servo = within(chance, SERVOS[0]), within(chance, SERVOS[1])
    both = (
        commands(segments, period, servo) for segments in (laps, [laps[0], ("none", eight(speed, EIGHT))])
    )
    course, calibrating = (Course(wanted, spans, period, angles) for wanted, spans in both)
    return course, calibrating


def _laps(chance: Generator, speed: float, trucks: int) -> list[Lap]:
    """Return two laps or more of a programme that lasts about a minute."""
    while True:
        lap_of = PROGRAMMES[str(chance.choice(list(PROGRAMMES)))](chance, speed, trucks)
        laps: list[Lap] = []
        lasts = 0.0
        while len(laps) < 2 or lasts < DURATIONS[0]:
            laps.append(lap_of(len(laps)))
            lasts += sum(leg[2] for leg in laps[-1][1])
        if lasts < DURATIONS[1]:
            return laps


def _at(driven: Drive, ahead: Array) -> Drive:
    """Return a drive with the poses of places ahead of the trucks' origins [m]."""
    heading = driven.poses[:, :, 2]
    poses = driven.poses.copy()
    poses[:, :, 0] += ahead * np.cos(heading)
    poses[:, :, 1] += ahead * np.sin(heading)
    return replace(driven, poses=poses)


def _robot(chance: Generator, chassis: Chassis, nominal: Nominal, period: float) -> Robot:
    """Return the robot as its owner believes it to be, with random faults."""
    turn = round(2.0 * np.pi * float(nominal.radii[0]) / within(chance, COUNTS))
    resolutions = turn, int(chance.choice(JOINTS)), round(within(chance, METRES))
    nodes = chance.permutation(np.arange(2, 60))
    return Robot(
        chassis.name,
        chassis.trucks,
        tuple(map(float, nominal.tracks)),
        tuple(map(float, nominal.radii)),
        nominal.link,
        period,
        drawn_encoders(chance, nodes, chassis.trucks, resolutions),
    )


def _measuring(chance: Generator, trucks: int) -> Measuring | None:
    """Return how poses are measured; not at all only where a linkage tells something."""
    kind = str(chance.choice(["none", "stops", "dense"] if trucks == 2 else ["stops", "dense", "dense"]))
    place, heading = within(chance, PLACES), within(chance, HEADINGS)
    both = trucks == 2 and bool(chance.random() < 0.5)
    if kind == "none":
        return None
    return Measuring((place, place, heading), 0.0 if kind == "stops" else DENSE, both)


def _hidden(at: Setting, kind: str) -> list[Fault]:
    """Return faults, drawn at random, on different components."""
    count = {"null": 0, "single": 1, "multi": 2}[kind]
    hidden: dict[str, Fault] = {}
    while len(hidden) < count:
        fault = _builds(at.chassis)[int(at.chance.integers(len(_builds(at.chassis))))](at)
        if fault.effect not in {other.effect for other in hidden.values()}:
            hidden[fault.component] = fault
    return list(hidden.values())


def _builds(chassis: Chassis) -> tuple[Build, ...]:
    if chassis.skids:
        return SKIDDING
    if chassis.link:
        return (*ROLLING, *LINKED)
    return (*ROLLING, *DRAGGED) if chassis.creep else ROLLING


def _written(
    folder: Path, case: _Case, hidden: Sequence[Fault], alone: Sequence[Drive], driven: Drive
) -> dict[str, Any]:
    """Write the recording of a drive, and return its label.

    `alone` has a drive on a plane with each of the faults alone.
    """
    chance, robot, measuring = case.setting.chance, case.robot, case.measuring
    log = case.recorded(driven, hidden, chance)
    write(folder, robot, log, measuring, 0.0, chance)
    healthy = case.seen(case.setting.healthy, [])
    untouched = residual(healthy)
    changed = [residual(case.seen(one, [fault])) for one, fault in zip(alone, hidden, strict=True)]
    noisy = residual(seen(robot, log, measuring, chance))
    smooth = {part: sum((each[part] - own for each in changed), own) for part, own in untouched.items()}
    ruler = Ruler(Noise.of([{part: noisy[part] - smooth[part] for part in noisy}]), (untouched,))
    labels = [
        _label(case, fault, one, driven, healthy, ruler) for fault, one in zip(hidden, alone, strict=True)
    ]
    unnamed = any(each["effect"] == "unknown" for each in labels)
    kind = "null" if not labels else "multi" if len(labels) > 1 else "unknown" if unnamed else "single"
    chassis = case.setting.chassis
    return {
        **case_label(kind, labels, weak=any(each["sigmas_above_noise"] < CLEAR for each in labels)),
        "secondary": background(healthy, ruler, ruler.noise.whitened([untouched])),
        "engine": "pybullet",
        "robot": chassis.name,
        "creep": chassis.creep,
        "poses": "none" if measuring is None else f"{measuring.period:g} s",
        "period": robot.period,
        "slope": case.floor.slope,
        "seconds_of_driving": round(float(driven.time[-1]), 1),
    }


def _label(
    case: _Case, fault: Fault, alone: Drive, driven: Drive, healthy: Seen, ruler: Ruler
) -> dict[str, Any]:
    """Return the label of a fault: its size and what looks like it as a drive with it alone shows them."""
    size = fault.measure(alone)
    when = [] if fault.intervals is None else fault.intervals(alone)
    change = ruler.change([case.seen(alone, [fault])])
    labelled = label(fault.effect, fault.component, size) | {"built": f"{fault.effect} {fault.component}"}
    if fault.effect == "bump":  # when and how much is a matter of the drive that is recorded
        labelled |= label(fault.effect, fault.component, fault.measure(driven))
    labelled["intervals"] = [] if fault.intervals is None else fault.intervals(driven)
    more: Mapping[str, Any] = {**size, "intervals": when} if when else size
    named, labelled["acceptable"] = alike(change, fault.effect, fault.component, more, healthy, ruler)
    if not named and fault.effect != "unknown":
        labelled |= {"effect": "unknown", "component": fault.component[0], "parameters": {}}
    labelled["sigmas_above_noise"] = round(float(np.linalg.norm(change)), 2)
    return labelled
