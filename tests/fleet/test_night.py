import json
from dataclasses import replace

import numpy as np
import pytest

from omnimate.fleet.batch.files import open_files
from omnimate.fleet.batch.run import run_batch
from omnimate.fleet.batch.tables import columns_of
from omnimate.fleet.errors import FleetError
from omnimate.fleet.hall.hall import draw_hall
from omnimate.fleet.hall.ills import Ill
from omnimate.fleet.hall.places import Place
from omnimate.fleet.hall.store import write_store
from omnimate.fleet.kept import (
    days_kept,
    keep_night,
    last_night,
    read_floor,
    read_history,
    read_judged,
    read_morning,
)
from omnimate.fleet.morning import Asked, FloorSummary
from omnimate.fleet.night import _asked, _judge, _result, judge_night

parquet = pytest.importorskip("pyarrow.parquet")
DAYS = 7


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    hall = draw_hall(6, 10, sick=0, places=0, docks=12, length=18.0, width=14.0, sync_period=0.04, seed=2)
    sick = replace(hall.robots[1], ills=(Ill("wheelbase", "a", 4, 0.03),))
    oil = Place("oil", 9.0, 7.0, reach=0.5, size=0.03)
    hall = replace(hall, places=(oil,), robots=(hall.robots[0], sick, *hall.robots[3:5]))
    folder = tmp_path_factory.mktemp("store")
    write_store(hall, folder, range(DAYS), 1, 4.0)
    run_batch(str(folder), str(folder / "results"), diagnosed=False)
    files = open_files(str(folder / "results"))
    return files, judge_night(files)


def test_the_sick_robot_and_the_bad_place_are_listed_and_nothing_else(night):
    _, found = night
    assert [(change.robot, change.name, change.since) for change in found.sick] == [
        ("mule-0001", "wheelbase", "2026-03-06")
    ]
    assert [place.effect for place in found.places] == ["loss"]
    assert np.hypot(found.places[0].x - 9.0, found.places[0].y - 7.0) < 0.3


def test_robots_and_places_stand_in_tables_from_which_the_next_night_begins(night):
    files, found = night
    robots = columns_of(files.read(f"robots/day={found.day}/night.parquet"))
    assert [robot for robot, listed in zip(robots["robot"], robots["listed"], strict=True) if listed] == [
        "mule-0001"
    ]
    again = judge_night(files, found.day)
    assert json.dumps([place.effect for place in again.places]) == '["loss"]'


def test_the_morning_that_is_read_is_the_night_that_was_judged(night):
    files, judged = night
    morning = read_morning(files)
    assert morning.sick == judged.sick
    assert sorted(morning.changes, key=lambda change: change.robot) == sorted(
        judged.changes, key=lambda change: change.robot
    )
    assert (morning.day, morning.recordings, morning.errors, morning.asked, morning.roughness) == (
        judged.day, judged.recordings, judged.errors, judged.asked, judged.roughness,
    )  # fmt: skip
    assert [(place.x, place.y, place.reach) for place in morning.places] == [
        (place.x, place.y, place.reach) for place in judged.places
    ]
    assert morning.floors == judged.floors
    assert np.array_equal(read_floor(files, judged.day, ""), judged.driven[""])
    states = {each.change.robot: each.state for each in morning.judged()}
    assert states["mule-0001"] == "sick"
    assert set(states.values()) <= {"sick", "drift", "fine"}


def test_what_a_night_says_of_a_robot_is_read_without_the_others(night, tmp_path):
    files, _ = night
    for each in read_morning(files).judged():
        assert read_judged(files, each.change.robot) == each
    assert read_judged(files, "none") is None
    assert read_judged(open_files(str(tmp_path)), "mule-0001") is None


def test_an_older_night_that_is_judged_again_is_not_the_last_one(night, tmp_path):
    _, judged = night
    files = open_files(str(tmp_path))
    for day in ("2026-05-07", judged.day):
        keep_night(files, replace(judged, day=day))
    assert last_night(files) == "2026-05-07"


def test_robots_go_from_floor_to_floor_and_each_floor_has_its_own_places(night, tmp_path):
    """The same laps as before on one floor, and again, on later days, on another that nobody knows yet."""
    files, judged = night
    paths = files.glob("recordings/robot=*/day=*/*.parquet")
    here = [replace(_result(files, path, columns_of(files.read(path))), floor="north") for path in paths]
    later = {day: f"2026-03-{int(day[-2:]) + DAYS:02d}" for day in {each.day for each in here}}
    there = [replace(each, floor="south", day=later[each.day]) for each in here if each.robot != "mule-0001"]
    known = [replace(place, floor="north") for place in judged.places]
    both = _judge([*here, *there], judged.day, known)
    assert list(both.floors) == ["north", "south"]
    for floor in both.floors.values():
        assert len(floor.places) == 1
        assert np.hypot(floor.places[0].x - 9.0, floor.places[0].y - 7.0) < 0.3
    assert {place.floor for floor in both.floors.values() for place in floor.places} == {"north", "south"}
    assert {len(history.dates) for history in both.histories} == {DAYS, 2 * DAYS}
    kept = replace(
        judged,
        places=tuple(place for floor in both.floors.values() for place in floor.places),
        floors=(FloorSummary("north", 28, 6e-4), FloorSummary("south", 21, 5e-4)),
        driven=both.driven,
    )
    other = open_files(str(tmp_path))
    keep_night(other, kept)
    read = read_morning(other)
    assert (read.floors, [place.floor for place in read.places]) == (kept.floors, ["north", "south"])
    assert np.array_equal(read_floor(other, judged.day, "north"), both.driven["north"])
    assert read.roughness == 6e-4


def test_a_robots_history_keeps_the_days_that_a_night_does_not_judge_anew(night, tmp_path):
    files, judged = night
    history = next(history for history in judged.histories if history.robot == "mule-0001")
    wheelbase = next(course for course in read_history(files, "mule-0001") if course.name == "wheelbase")
    assert wheelbase.days == history.dates
    assert np.array_equal(wheelbase.value, history.value[:, history.names.index("wheelbase")])
    other = open_files(str(tmp_path))
    later = replace(history, dates=tuple(f"2026-05-{day:02d}" for day in range(1, DAYS + 1)))
    for single, day in ((history, judged.day), (later, "2026-05-07"), (history, judged.day)):
        keep_night(other, replace(judged, histories=(single,), day=day))
    kept = read_history(other, "mule-0001")[0]
    assert kept.days == (*history.dates, *later.dates)
    assert days_kept(other) == ["2026-05-07", judged.day]
    assert read_history(other, "none") == []


def test_a_night_that_was_not_judged_cannot_be_read(night, tmp_path):
    with pytest.raises(FleetError, match="2026-03-08 to 2026-03-08"):
        read_morning(night[0], "2026-04-01")
    with pytest.raises(FleetError, match="no night was judged yet"):
        read_morning(open_files(str(tmp_path)))


def test_a_night_without_results_is_refused_with_those_that_there_are(night):
    with pytest.raises(FleetError, match="2026-03-02 to 2026-03-08"):
        judge_night(night[0], "2026-04-01")


def test_a_robot_is_named_where_triage_asks_for_the_same_three_times_in_a_row():
    def rows(robot, answers):
        return [
            (
                f"recordings/robot={robot}/day=2026-03-{day:02d}/060000-k.parquet",
                {"triage": [verdict], "effect": [effect], "component": ["a.left"]},
            )
            for day, (verdict, effect) in enumerate(answers, start=1)
        ]

    same, other, quiet = ("mismatch", "bump"), ("mismatch", "latency"), ("agreement", None)
    table = [
        *rows("x", [quiet, same, same, same]),
        *rows("y", [same, other, same]),
        *rows("z", [same, same, same, quiet]),
        *rows("listed", [same, same, same]),
    ]
    assert _asked(table, {"listed"}) == [Asked("x", "bump", "a.left", "2026-03-02")]
