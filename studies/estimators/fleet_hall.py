"""How well the joint model separates faulty robots and bad places in a simulated hall, day after day.

The first week finds the bad places; from then on all robots are judged every day from what is known by then.
No file is written or read on the way: the laps are simulated, and their numbers are those of `fleet run`.

Peer: the truth of the hall.

The joints are estimated from the first minute of each lap, because the filter takes most of the time; the
daily run uses the whole lap, and knows them better.

Usage: python -m studies.estimators.fleet_hall [--robots 1000] [--days 30] [--sick 30] [--places 20]

Further options: --minutes of a lap, --seed, --period of SYNC [s], --linkage [s] of each lap that the
filter of the joints sees, and --jobs, the processes that drive.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from multiprocessing.pool import Pool

import numpy as np

from omnimate.fleet.features import RecordingFeatures, estimate_joints, name_kind
from omnimate.fleet.hall.faults import Fault
from omnimate.fleet.hall.hall import Hall, date_of, draw_hall, hall_lap
from omnimate.fleet.hall.places import Place
from omnimate.fleet.hall.robots import HallRobot
from omnimate.fleet.model.changes import detect_changes, select_faulty
from omnimate.fleet.model.floor import Floor, estimate_floor
from omnimate.fleet.model.histories import (
    NominalVariation,
    RobotInformation,
    estimate_nominal_variation,
    make_histories,
)
from omnimate.fleet.model.places import MIN_CROSSINGS
from omnimate.fleet.report import BadPlace, Change
from omnimate.fleet.segments import CELL, JOINT_NUMBERS, PARAMETERS, cut_segments
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import Array
from studies.benchmark import options

WEEK = 7  # days that find the places
SEEN = {"wheel_diameter", "wheelbase", "joint_bias"}  # faults that poses at docks, or the linkage, show
SIGMAS = 10.0  # of a day, from which on an fault counts
SOON = 3  # days after that, within which it is to be found
NEAR = 0.3  # [m] that a place may be off
PART = 25  # robots that a process drives at once
SAME = 1.0  # [m] within which a found place is taken for a true one


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came out."""

    # places found, each with the distance to the true one that it is taken for [m]; inf for none
    places: list[tuple[BadPlace, float]]
    # true places with none found near, with the number of segments over each within the week
    missed: list[tuple[Place, int]]
    judged: int  # robot-days judged
    false: list[tuple[int, Change]]  # robots reported as faulty that are healthy, with the day
    # of each faulty robot whose fault is of a kind that is seen: days from its 10 sigma to its report; None
    # where it was not reported
    waits: dict[str, int | None]
    named: dict[str, bool]  # of the faulty ones reported: whether the right number is named
    unseen: dict[str, bool]  # faulty robots whose fault is of another kind, and whether they were reported

    @property
    def right(self) -> float:
        """Part of all true robots and places that were listed as what they are, and of all listed ones."""
        robots = sum(wait is not None for wait in self.waits.values())
        places = sum(distance < SAME for _, distance in self.places)
        wrong = len({change.robot for _, change in self.false}) + len(self.places) - places
        # where nobody drives, nothing shows
        often = sum(segments >= MIN_CROSSINGS for _, segments in self.missed)
        missed = len(self.waits) - robots + often
        return (robots + places) / max(1, robots + places + wrong + missed)


def lap_of(hall: Hall, robot: HallRobot, day: int, minutes: float, linkage: float) -> RecordingFeatures:
    recording = hall_lap(hall, robot, day, 0, minutes)
    cut = cut_segments(recording)
    assert cut is not None
    segments, crossings = cut
    crossings = replace(
        crossings, loss=crossings.loss.astype(np.float32), creep=crossings.creep.astype(np.float32)
    )
    kind = name_kind(robot.vehicle)
    joints = estimate_joints(beginning(recording, linkage))
    return RecordingFeatures(robot.vehicle.name, kind, date_of(day), segments, crossings, joints)


def beginning(recording: Recording, seconds: float) -> Recording:
    """Return the first seconds of a recording, without its poses."""
    rows = recording.between(float(recording.time[0]), float(recording.time[0]) + seconds)
    return replace(
        recording,
        time=recording.time[rows],
        counts=recording.counts[rows],
        present=recording.present[rows],
        poses=None,
    )


@dataclass(frozen=True, slots=True)
class Laps:
    """Who drives: each robot one lap a day, in some processes."""

    hall: Hall  # the hall
    minutes: float  # time of a lap, about [min]
    linkage: float  # time of each lap that the filter of the joints sees [s]
    pool: Pool  # the processes

    def of_day(self, day: int) -> list[RecordingFeatures]:
        """Return the laps of all robots on a day."""
        laps = ((self.hall, robot, day, self.minutes, self.linkage) for robot in self.hall.robots)
        return self.pool.starmap(lap_of, laps, PART)

    def numbers_of_day(self, day: int, floor: Floor) -> list[RobotInformation]:
        """Return the information of the laps of all robots on a day, without the effect of a floor."""
        robots = self.hall.robots
        parts = (robots[first : first + PART] for first in range(0, len(robots), PART))
        more = day, self.minutes, self.linkage
        numbers = self.pool.starmap(numbers_of, ((floor, self.hall, part, *more) for part in parts))
        return [number for part in numbers for number in part]


def numbers_of(
    floor: Floor, hall: Hall, robots: Sequence[HallRobot], day: int, minutes: float, linkage: float
) -> list[RobotInformation]:
    return floor.robot_information([lap_of(hall, robot, day, minutes, linkage) for robot in robots])


def study(laps: Laps, days: int, say: Callable[[str], object]) -> Outcome:
    """Return what comes out of some days; `say` is called with a sentence after each."""
    hall = laps.hall
    driven, week = [], min(WEEK, days)
    for day in range(week):
        driven += laps.of_day(day)
        say(f"day {day}")
    floor = estimate_floor(driven)
    say(
        f"{len(floor.places)} places, roughness {1e3 * floor.roughness:.3f} mm/sqrt(m) "
        f"(true {1e3 * CONCRETE_ROUGHNESS:.3f})"
    )
    numbers = floor.robot_information(driven)
    crossed = np.array([segments_over(place, driven) for place in hall.places], int)
    del driven
    reports: dict[int, list[Change]] = {}
    nominal: dict[str, NominalVariation] = {}
    judged = 0
    for day in range(week - 1, days):
        if day >= week:
            numbers += laps.numbers_of_day(day, floor)
        histories = make_histories(numbers)
        nominal = {
            kind: estimate_nominal_variation([history for history in histories if history.kind == kind])
            for kind in {history.kind for history in histories}
        }
        changes = detect_changes(histories, nominal)
        judged += len(changes)
        reports[day] = select_faulty(changes)
        say(f"day {day}: {', '.join(change.robot for change in reports[day])}")
    return outcome(hall, floor.places, crossed, reports, nominal, judged)


def segments_over(place: Place, driven: Sequence[RecordingFeatures]) -> int:
    """Return how many segments lead over a true place."""
    count = 0
    for recording in driven:
        over = recording.crossings
        from_place = CELL * over.cell - np.array([place.x, place.y])
        count += len(np.unique(over.segment[np.hypot(from_place[:, 0], from_place[:, 1]) <= place.reach]))
    return count


def outcome(
    hall: Hall,
    places: Sequence[BadPlace],
    crossed: Array,
    reports: dict[int, list[Change]],
    nominal: dict[str, NominalVariation],
    judged: int,
) -> Outcome:
    distances = np.array([[np.hypot(a.x - b.x, a.y - b.y) for b in hall.places] for a in places])
    distances = distances.reshape(len(places), len(hall.places))
    first = {
        robot.vehicle.name: next(
            (day for day, listing in reports.items() if any(c.robot == robot.vehicle.name for c in listing)),
            None,
        )
        for robot in hall.robots
    }
    false, waits, named, unseen = [], {}, {}, {}
    for robot in hall.robots:
        name, day_found = robot.vehicle.name, first[robot.vehicle.name]
        change = None if day_found is None else next(c for c in reports[day_found] if c.robot == name)
        fault = robot.faults[0] if robot.faults else None
        if day_found is not None and change is not None and (fault is None or day_found < fault.day):
            false.append((day_found, change))
        elif fault is not None and fault.kind not in SEEN:
            unseen[f"{name} {fault.kind}"] = change is not None
        elif fault is not None:
            number = number_of(fault)
            sigma = nominal[name_kind(robot.vehicle)].sigma[number]
            strong = [day for day in reports if abs(fault.at(day)) >= SIGMAS * sigma]
            if strong and strong[0] + SOON <= max(reports):
                waits[name] = None if day_found is None else max(0, day_found - strong[0])
                if change is not None:
                    named[name] = change.name == (*PARAMETERS, *JOINT_NUMBERS)[number]
    far = distances.min(axis=0) >= SAME if len(places) else np.ones(len(hall.places), bool)
    pairs = zip(hall.places, crossed.tolist(), far.tolist(), strict=True)
    missed = [(place, segments) for place, segments, is_far in pairs if is_far]
    located = list(zip(places, taken(distances).tolist(), strict=True))
    return Outcome(located, missed, judged, false, waits, named, unseen)


def number_of(fault: Fault) -> int:
    """Return the place of the number that a fault changes in a history."""
    return ["a.left", "a.right", "a", "joint_a", "joint_b"].index(fault.component)


def main() -> int:
    given = options(
        __doc__,
        robots=1000,
        days=30,
        sick=30,
        places=20,
        minutes=5.0,
        seed=0,
        period=0.04,
        linkage=60.0,
        jobs=2,
    )
    hall = draw_hall(
        given.robots,
        given.days,
        faulty=given.sick,
        places=given.places,
        seed=given.seed,
        sync_period=given.period,
    )
    with multiprocessing.Pool(given.jobs) as pool:
        laps = Laps(hall, given.minutes, given.linkage, pool)
        result = study(laps, given.days, lambda text: print(text, file=sys.stderr, flush=True))
        pool.close()
        pool.join()
    spent = sum(os.times()[:4])  # of this process and of those that it waited for
    print(
        f"{given.robots} robots, {given.days} days, {given.minutes:g} minutes each: "
        f"{spent:.0f} s of processor time, simulation included"
    )
    return report(result, hall)


def taken(distances: Array) -> Array:
    """Return how far each found place is from the true one that it is taken for, `(F,)`; inf for none.

    A true place is taken once, by the nearest one found; `distances` [m] has shape `(F, T)`.
    """
    left, away = distances.copy(), np.full(len(distances), np.inf)
    while left.size and left.min() < SAME:
        found, true = np.unravel_index(int(np.argmin(left)), left.shape)
        away[found] = left[found, true]
        left[found], left[:, true] = np.inf, np.inf
    return away


def report(result: Outcome, hall: Hall) -> int:
    right = [distance for _, distance in result.places if distance < SAME]
    near = sum(distance <= NEAR for distance in right)
    print(
        f"places: {len(right)} of {len(hall.places)} found, {len(result.places) - len(right)} that are none; "
        f"{near} within {NEAR} m, the farthest {max(right, default=0.0):.2f} m"
    )
    for place, distance in result.places:
        spread = float(np.sqrt(np.trace(place.covariance) / 2.0))
        off = f"off by {distance:.2f}" if distance < SAME else "where none is"
        print(
            f"  {place.effect:5} at {place.x:6.2f} {place.y:6.2f} +- {spread:.2f} m, {off}, "
            f"{1e3 * place.per_crossing:5.1f} mm a crossing, {place.crossings} crossings"
        )
    for missed, segments in result.missed:
        unseen = f", which does not count: {MIN_CROSSINGS} segments or more would"
        counts = "" if segments >= MIN_CROSSINGS else unseen
        where = f"{missed.kind} at {missed.x:6.2f} {missed.y:6.2f}"
        print(f"  missed: {where}, size {missed.size:.4f}, {segments} segments over it{counts}")
    robot_days = result.judged
    print(
        f"healthy robots reported as faulty: {len(result.false)} in {robot_days} robot-days "
        f"(wanted: at most {robot_days // 1000})"
    )
    for day, change in result.false:
        print(f"  day {day}: {change}")
    waits = list(result.waits.values())
    soon = sum(wait is not None and wait <= SOON for wait in waits)
    print(
        f"faulty robots of {SIGMAS:.0f} sigma of a day: {soon} of {len(waits)} reported within {SOON} days; "
        f"{sum(result.named.values())} of {len(result.named)} with the right number named"
    )
    print(f"  days waited: {result.waits}")
    print(f"  of faults that neither docks nor the joints' means show: {result.unseen}")
    print(f"robot or floor right: {100.0 * result.right:.1f} % (wanted: 95 %)")
    is_reached = len(result.false) <= robot_days / 1000 and soon == len(waits) and near == len(right)
    return 0 if is_reached and result.right >= 0.95 else 1


if __name__ == "__main__":
    sys.exit(main())
