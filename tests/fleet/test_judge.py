import shutil
from dataclasses import replace

import numpy as np
import pytest

from omnimate.fleet.batch.files import open_files
from omnimate.fleet.batch.run import run_batch
from omnimate.fleet.batch.tables import decode_rows
from omnimate.fleet.errors import FleetError
from omnimate.fleet.hall.faults import Fault
from omnimate.fleet.hall.hall import draw_hall, write_store
from omnimate.fleet.hall.places import Place
from omnimate.fleet.judge import find_repeated_mismatches, judge_day, make_report, read_results
from omnimate.fleet.report import RepeatedMismatch
from omnimate.fleet.report_store import (
    find_latest_day,
    list_days,
    read_floor,
    read_history,
    read_report,
    read_robot,
    write_report,
)

parquet = pytest.importorskip("pyarrow.parquet")
DAYS = 7


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    hall = draw_hall(6, 10, faulty=0, places=0, docks=12, length=18.0, width=14.0, sync_period=0.04, seed=2)
    faulty = replace(hall.robots[1], faults=(Fault("wheelbase", "a", 4, 0.03),))
    oil = Place("oil", 9.0, 7.0, reach=0.5, size=0.03)
    hall = replace(hall, places=(oil,), robots=(hall.robots[0], faulty, *hall.robots[3:5]))
    folder = tmp_path_factory.mktemp("store")
    write_store(hall, folder, range(DAYS), 1, 4.0)
    run_batch(str(folder), str(folder / "results"), diagnosed=False)
    files = open_files(str(folder / "results"))
    return files, judge_day(files)


def test_the_faulty_robot_and_the_bad_place_are_reported_and_nothing_else(results):
    _, found = results
    assert [(change.robot, change.name, change.since) for change in found.faulty] == [
        ("mule-0001", "wheelbase", "2026-03-06")
    ]
    assert [place.effect for place in found.places] == ["loss"]
    assert np.hypot(found.places[0].x - 9.0, found.places[0].y - 7.0) < 0.3


def test_the_report_that_is_read_is_the_one_that_was_written(results):
    files, judged = results
    read = read_report(files)
    assert read.faulty == judged.faulty
    assert sorted(read.changes, key=lambda change: change.robot) == sorted(
        judged.changes, key=lambda change: change.robot
    )
    assert (read.day, read.recordings, read.failed, read.repeated, read.roughness) == (
        judged.day, judged.recordings, judged.failed, judged.repeated, judged.roughness,
    )  # fmt: skip
    assert [(place.x, place.y, place.reach) for place in read.places] == [
        (place.x, place.y, place.reach) for place in judged.places
    ]
    assert read.floors == judged.floors
    assert np.array_equal(read_floor(files, judged.day, ""), judged.driven[""])
    rows = decode_rows(files.read(f"robots/day={judged.day}/night.parquet"))
    assert [row["robot"] for row in rows if row["listed"]] == ["mule-0001"]
    states = {robot.change.robot: robot.state for robot in read.judged()}
    assert states["mule-0001"] == "sick"
    assert set(states.values()) <= {"sick", "drift", "fine"}


def test_one_robot_is_read_without_the_others(results, tmp_path):
    files, _ = results
    for robot in read_report(files).judged():
        assert read_robot(files, robot.change.robot) == robot
    assert read_robot(files, "none") is None
    assert read_robot(open_files(str(tmp_path)), "mule-0001") is None


def test_an_older_report_that_is_written_again_is_not_the_latest_one(results, tmp_path):
    _, judged = results
    files = open_files(str(tmp_path))
    for day in ("2026-05-07", judged.day):
        write_report(files, replace(judged, day=day))
    assert find_latest_day(files) == "2026-05-07"


def test_robots_go_from_floor_to_floor_and_each_floor_has_its_own_places(results, tmp_path):
    """The same laps as before on one floor, and again, on later days, on another that nobody knows yet."""
    files, judged = results
    paths = files.glob("recordings/robot=*/day=*/*.parquet")
    here = [replace(read_results(files, path)[1], floor="north") for path in paths]
    later = {day: f"2026-03-{int(day[-2:]) + DAYS:02d}" for day in {lap.day for lap in here}}
    there = [replace(lap, floor="south", day=later[lap.day]) for lap in here if lap.robot != "mule-0001"]
    known = [replace(place, floor="north") for place in judged.places]
    both = make_report(judged.day, [], [*here, *there], known)
    assert [floor.floor for floor in both.floors] == ["north", "south"]
    assert [place.floor for place in both.places] == ["north", "south"]
    for place in both.places:
        assert np.hypot(place.x - 9.0, place.y - 7.0) < 0.3
    assert {len(history.dates) for history in both.histories} == {DAYS, 2 * DAYS}
    other = open_files(str(tmp_path))
    write_report(other, both)
    read = read_report(other)
    assert (read.floors, [place.floor for place in read.places]) == (both.floors, ["north", "south"])
    assert np.array_equal(read_floor(other, judged.day, "north"), both.driven["north"])
    assert read.roughness == both.floors[0].roughness


def test_a_robots_history_keeps_the_days_that_a_daily_run_does_not_judge_anew(results, tmp_path):
    files, judged = results
    history = next(history for history in judged.histories if history.robot == "mule-0001")
    wheelbase = next(course for course in read_history(files, "mule-0001") if course.name == "wheelbase")
    assert wheelbase.days == history.dates
    assert np.array_equal(wheelbase.value, history.value[:, history.names.index("wheelbase")])
    other = open_files(str(tmp_path))
    later = replace(history, dates=tuple(f"2026-05-{day:02d}" for day in range(1, DAYS + 1)))
    for some, day in ((history, judged.day), (later, "2026-05-07"), (history, judged.day)):
        write_report(other, replace(judged, histories=(some,), day=day))
    course = read_history(other, "mule-0001")[0]
    assert course.days == (*history.dates, *later.dates)
    assert list_days(other) == ["2026-05-07", judged.day]
    assert read_history(other, "none") == []


def test_a_report_that_is_not_there_cannot_be_read(results, tmp_path):
    with pytest.raises(FleetError, match="2026-03-08 to 2026-03-08"):
        read_report(results[0], "2026-04-01")
    with pytest.raises(FleetError, match="no daily report yet"):
        read_report(open_files(str(tmp_path)))


def test_results_whose_day_is_no_date_are_left_out_and_named(results, tmp_path):
    files, judged = results
    folder = shutil.copytree(files.root, tmp_path / "results")
    for table in ("recordings", "ways", "crossings", "numbers"):
        day = next(folder.glob(f"{table}/robot=mule-0001/day=*"))
        day.rename(day.with_name("day=2026-99-99"))
    report = judge_day(open_files(str(folder)))
    assert report.day == judged.day
    assert all(row[0] == "mule-0001" and "2026-99-99 is no date" in row[2] for row in report.failed)
    assert report.failed
    assert read_report(open_files(str(folder))).failed == report.failed


def test_a_day_without_results_is_refused_with_those_that_there_are(results):
    with pytest.raises(FleetError, match="2026-03-02 to 2026-03-08"):
        judge_day(results[0], "2026-04-01")


def test_a_robot_is_named_where_triage_asks_for_the_same_three_times_in_a_row():
    def rows(robot, answers):
        return [
            {
                "robot": robot,
                "day": f"2026-03-{day:02d}",
                "triage": verdict,
                "effect": effect,
                "component": "a.left",
            }
            for day, (verdict, effect) in enumerate(answers, start=1)
        ]

    same, other, quiet = ("mismatch", "bump"), ("mismatch", "latency"), ("agreement", None)
    table = [
        *rows("x", [quiet, same, same, same]),
        *rows("y", [same, other, same]),
        *rows("z", [same, same, same, quiet]),
        *rows("faulty", [same, same, same]),
    ]
    assert find_repeated_mismatches(table, {"faulty"}) == [
        RepeatedMismatch("x", "bump", "a.left", "2026-03-02")
    ]
