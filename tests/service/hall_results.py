"""The results of a made-up hall: 40 robots on 30 days, one faulty, two that drift, two places."""

from dataclasses import replace
from datetime import date, timedelta

import numpy as np

from omnimate.fleet.batch.files import open_files
from omnimate.fleet.batch.tables import TABLES, encode_columns
from omnimate.fleet.model.histories import History
from omnimate.fleet.report import BadPlace, Change, DailyReport, FloorSummary, RepeatedMismatch
from omnimate.fleet.report_store import write_report

FIRST, DAYS = date(2026, 3, 2), 30
DATES = tuple((FIRST + timedelta(days=day)).isoformat() for day in range(DAYS))
FAULTY, DRIFTS, ASKED = "mule-0006", "tug-0004", "tug-0013"
NAMES = ("left wheel", "right wheel", "wheelbase")


def robots():
    return [f"{'tug' if number % 3 else 'mule'}-{number:04d}" for number in range(40)]


def history(robot, chance):
    value = 1e-4 * chance.standard_normal((DAYS, 3))
    value[:, 0] -= 2e-5 * np.arange(DAYS)
    if robot == FAULTY:
        value[21:, 2] -= 0.004 + 0.0004 * np.arange(DAYS - 21)
    covariance = np.broadcast_to(np.diag([1e-8, 1e-8, 4e-8]), (DAYS, 3, 3))
    return History(robot, "wheelbase 0.34 m", NAMES, DATES, np.arange(DAYS, dtype=float), value, covariance)


def change(robot):
    log_e = {FAULTY: 90.0, DRIFTS: 4.0}.get(robot, -2.0)
    return Change(
        robot, "wheelbase 0.34 m", log_e, "wheelbase", 0.98, DATES[21], DATES[20], DATES[22],
        "ramp" if robot == FAULTY else "step", -0.0076 if robot == FAULTY else 3e-4, 1e-4,
        -4e-4 if robot == FAULTY else 0.0,
    )  # fmt: skip


def place(effect, x, y, floor=""):
    covariance = np.array([[0.006, 0.002], [0.002, 0.003]])
    size = np.array([0.03]) if effect == "loss" else np.array([0.01, 0.02])
    return BadPlace(effect, x, y, 0.5, covariance, size, 0.1 * np.abs(size), 80.0, 62, floor)


def driven():
    cells = {}
    for aisle in range(6):
        for step in range(152):
            for point in ((1.0 + 0.25 * step, 2.0 + 5.0 * aisle), (2.0 + 7.0 * aisle, 1.0 + 0.18 * step)):
                cell = tuple(0.25 * np.round(np.array(point) / 0.25))
                cells[cell] = cells.get(cell, 0) + 3 + (step * aisle) % 17
    return np.array([(*cell, count) for cell, count in cells.items()])


def daily_report(day=DATES[-1], names=None, places=None):
    chance = np.random.default_rng(5)
    changes = tuple(change(robot) for robot in names or robots())
    faulty = tuple(some for some in changes if some.robot == FAULTY)
    bad = (place("loss", 16.0, 12.1), place("creep", 30.2, 7.0)) if places is None else places
    return DailyReport(
        day, 40, (("tug-0001", "060000", "can.log: no SYNC in it"),), changes, faulty,
        (RepeatedMismatch(ASKED, "gear_backlash", "a.left", DATES[26]),), bad, (FloorSummary("", 280, 6e-4),),
        tuple(history(robot, chance) for robot in names or robots()), {"": driven()},
    )  # fmt: skip


def report_of_two_floors():
    floors = (FloorSummary("north", 280, 6e-4), FloorSummary("south", 20, 8e-4))
    places = (place("loss", 16.0, 12.1, "north"), place("creep", 30.2, 7.0, "south"))
    over = {"north": driven(), "south": driven()[:9]}
    return replace(daily_report(), places=places, floors=floors, driven=over)


def write_recordings(files, robot, days):
    for day in days:
        row = dict.fromkeys(TABLES["recordings"])
        row |= {
            "recording": "060000",
            "key": "0" * 16,
            "kind": "wheelbase 0.34 m",
            "start": 0.0,
            "duration": 300.0,
            "way": 140.0,
            "triage": "mismatch" if robot == FAULTY and day >= DATES[21] else "agreement",
            "probability": 0.5,
            "says": "nothing that stands out",
        }
        content = encode_columns("recordings", {name: [value] for name, value in row.items()})
        files.write(f"recordings/robot={robot}/day={day}/060000-{'0' * 16}.parquet", content)


def write_results(url):
    """Write the results of all days' recordings, and the latest report."""
    files = open_files(url)
    for robot in robots():
        write_recordings(files, robot, DATES if robot == FAULTY else DATES[-1:])
    write_recordings(files, "tug-9999", DATES[-1:])
    write_report(files, daily_report())
    return files
