"""Fleets over REST: uploads, batches, daily reports, robots, floors, histories, reports."""

import gzip
import shutil
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from sqlalchemy.orm import Session

from omnimate.fleet.batch.files import open_files
from omnimate.fleet.report_store import write_report
from omnimate.service.errors import InvalidValueError, TooLargeError
from omnimate.service.fleets.batches import add_batch
from omnimate.service.fleets.models import BatchStart
from omnimate.service.fleets.upload import store_day
from omnimate.service.jobs.queue import claim_job
from omnimate.service.store.recordings import find_unreadable
from omnimate.service.store.tables import BatchRow, FleetRow, JobRow
from tests.service.conftest import ZIP, day_zip, until
from tests.service.hall_results import (
    ASKED,
    DATES,
    DRIFTS,
    FAULTY,
    daily_report,
    report_of_two_floors,
    robots,
    write_recordings,
    write_results,
)
from tests.service.zips import zipped

pytest.importorskip("pyarrow")
PATH = "/v1/fleets"
LIMIT = 10**8  # [bytes]
ENDED = {"done", "failed", "cancelled"}


@pytest.fixture(scope="module")
def hall(client):
    """The path of a fleet that has the results of a hall's daily runs."""
    made = client.post(PATH, json={"name": "hall-3"})
    assert made.status_code == 201
    write_results(client.components.stores.results_of("hall-3").url)
    return made.headers["Location"]


def zip_of(recordings):
    """Return a zip of recordings, given as the folder and the files of each."""
    return zipped(
        (f"{folder}/{name}", content)
        for folder, files in recordings.items()
        for name, content in files.items()
    )


def sent(client, fleet, content):
    """Return the answer to an upload."""
    return client.post(f"{fleet}/recordings", content=content, headers=ZIP)


def ended(client, path):
    """Return a batch when it has ended."""
    return until(lambda: (now := client.get(path).json())["state"] in ENDED and now)


def listed(client, path, limit):
    """Yield the items of a list, page by page."""
    after = {}
    while after is not None:
        page = client.get(path, params={"limit": limit} | after).json()
        yield from page["items"]
        after = page["next"] and {"after": page["next"]}


def test_a_fleet_is_made_once_also_where_two_requests_make_it_at_once(client, monkeypatch):
    find = Session.get

    def get(db, table, *key, **options):
        return None if table is FleetRow else find(db, table, *key, **options)

    answers = [client.post(PATH, json={"name": "made-once"}) for _ in range(2)]
    monkeypatch.setattr(Session, "get", get)  # a transaction does not see what another has not committed yet
    answers.append(client.post(PATH, json={"name": "made-once"}))
    assert [answer.status_code for answer in answers] == [201, 409, 409]


@pytest.mark.slow
def test_a_days_recordings_are_uploaded_and_a_batch_makes_their_results(client):
    location = client.post(PATH, json={"name": "small"}).headers["Location"]
    for _ in range(2):  # the same files twice do no harm
        stored = sent(client, location, day_zip())
        assert stored.status_code == 201
        assert (stored.json()["recordings"], stored.json()["days"]) == (2, ["2026-03-02"])
    made = client.post(f"{location}/batches", json={"diagnose": False})
    assert made.status_code == 202
    path = made.headers["Location"]
    batch = ended(client, path)
    assert (batch["state"], batch["done"], batch["known"], batch["failures"]) == ("done", 2, 0, [])
    assert (batch["progress"], batch["night"]) == (1.0, "2026-03-02")
    known = {"day": "2026-03-02", "diagnose": False}
    again = client.post(f"{location}/batches", json=known).headers["Location"]
    assert ended(client, again)["known"] == 2
    assert [row["id"] for row in client.get(f"{location}/batches").json()["items"]] == [
        again.rpartition("/")[2],
        path.rpartition("/")[2],
    ]
    assert {robot["state"] for robot in client.get(f"{location}/robots").json()["items"]} == {"unjudged"}
    assert client.get("/v1/diagnoses").json()["items"] == []


def test_a_day_without_recordings_fails_with_its_reason(client):
    location = client.post(PATH, json={"name": "empty"}).headers["Location"]
    path = client.post(f"{location}/batches", json={}).headers["Location"]
    batch = ended(client, path)
    assert batch["state"] == "failed"
    assert "no recording; expected" in batch["error"]
    assert client.post(f"{path}/cancel").status_code == 409
    assert client.get(f"{location}/nights/latest").status_code == 404


def test_a_batch_names_the_recordings_that_it_cannot_read_each_time(client):
    location = client.post(PATH, json={"name": "garbage"}).headers["Location"]
    where = "robot=r/day=2026-01-01/x"
    files = client.components.stores.recordings_of("garbage")  # as copied there by another program
    for name in ("vehicle.toml", "can.log"):
        files.write(f"{where}/{name}", b"garbage [")
    for counts in ((1, 0), (0, 1)):
        path = client.post(f"{location}/batches", json={}).headers["Location"]
        batch = ended(client, path)
        assert (batch["state"], (batch["done"], batch["known"])) == ("done", counts)
        (failure,) = batch["failures"]
        assert failure.pop("problem").startswith("x/vehicle.toml: ")
        assert failure == {"robot": "r", "day": "2026-01-01", "recording": "x"}


def test_a_batch_is_started_once_however_often_it_is_asked_for(client, hall):
    headers = {"Idempotency-Key": "night 1"}
    answers = [client.post(f"{hall}/batches", json={"day": "2031-01-01"}, headers=headers) for _ in range(2)]
    assert answers[0].json()["id"] == answers[1].json()["id"]
    assert answers[1].headers["Idempotency-Replayed"] == "true"
    ended(client, answers[0].headers["Location"])  # the fleet is that of other tests, too


def test_a_batch_is_neither_read_nor_cancelled_through_another_fleet(client, hall):
    client.post(PATH, json={"name": "other-hall"})
    own = client.post(f"{hall}/batches", json={"day": "2031-01-02"}).headers["Location"]
    foreign = own.replace("hall-3", "other-hall")
    answers = [client.get(foreign), client.post(f"{foreign}/cancel")]
    assert [answer.status_code for answer in answers] == [404, 404]
    assert ended(client, own)["state"] != "cancelled"


def test_the_more_urgent_batch_is_claimed_first_and_no_diagnosis_with_them(database):
    with database.writing() as db:
        db.query(JobRow).delete()
        db.add(FleetRow(id="a", created=0.0))
        late = add_batch(db, "a", BatchStart(priority=0)).id
        db.flush()
        early = add_batch(db, "a", BatchStart(priority=5)).id
        db.flush()
        assert claim_job(db, "this") is None
        assert [claim_job(db, "this", BatchRow) for _ in range(3)] == [early, late, None]


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({"robot=a/day=2026-03-02/x/vehicle.toml": b""}, "expected vehicle.toml and can.log"),
        ({"robot=a/day=2026-02-30/x/vehicle.toml": b""}, "YYYY-MM-DD"),
        ({"robot=a/day=2026-03-02/../vehicle.toml": b""}, "YYYY-MM-DD"),
        ({"../robot=a/day=2026-03-02/x/can.log": b""}, "YYYY-MM-DD"),
        ({"vehicle.toml": b"", "can.log": b""}, "YYYY-MM-DD"),
        ({"robot=a/day=2062-01-01/x/vehicle.toml": b""}, "this day has not come yet; expected one up to 20"),
        ({f"robot={'r' * 65}/day=2026-03-02/x/vehicle.toml": b""}, "names of 64 letters"),
        ({f"robot={'r' * 300}/day=2026-03-02/x/vehicle.toml": b""}, "names of 64 letters"),
        ({f"robot=a/day=2026-03-02/{'x' * 65}/vehicle.toml": b""}, "names of 64 letters"),
        ({}, "no recording in it"),
    ],
)
def test_a_zip_of_something_else_is_refused_and_nothing_of_it_is_kept(client, hall, members, words):
    answer = sent(client, hall, zipped(members))
    assert answer.status_code == 422
    assert words in answer.json()["detail"]
    assert client.components.stores.recordings_of("hall-3").glob("robot=*") == []


def test_names_of_64_characters_are_stored(tmp_path, recording_files):
    where = f"robot={'r' * 64}/day=2026-03-02/{'x' * 64}"
    files = open_files(str(tmp_path))
    assert store_day(files, zip_of({where: recording_files}), LIMIT, 1.8e9).robots == ["r" * 64]
    assert len(files.glob(f"{where}/*")) == len(recording_files)


def test_recordings_that_cannot_be_read_are_named_on_arrival_and_the_others_are_stored(
    client, hall, recording_files
):
    """A batch would name them in the night only, when nobody can send them again."""
    one, other, third = (f"robot={name}/day=2026-03-02/x" for name in "abc")
    files = client.components.stores.recordings_of("hall-3")
    broken = {
        one: recording_files,
        other: recording_files | {"vehicle.toml": b"garbage ["},
        third: recording_files | {"can.log": b"garbage", "can.log.gz": b""},
    }
    first = sent(client, hall, zip_of({third: recording_files})).json()
    assert first == {"recordings": 1, "robots": ["c"], "days": ["2026-03-02"], "refused": []}
    before = files.read(f"{third}/can.log")
    answer = sent(client, hall, zip_of(broken))
    assert answer.status_code == 201
    upload = answer.json()
    refused = upload.pop("refused")
    assert upload == {"recordings": 1, "robots": ["a"], "days": ["2026-03-02"]}
    assert [(row["robot"], row["day"], row["recording"]) for row in refused] == [
        ("b", "2026-03-02", "x"),
        ("c", "2026-03-02", "x"),
    ]
    assert f"{other}/vehicle.toml: " in refused[0]["problem"]
    assert f"{third}/can.log" in refused[1]["problem"]
    assert files.glob("robot=*") == ["robot=a", "robot=c"]
    assert files.read(f"{third}/can.log") == before
    assert {path.rpartition("/")[2] for path in files.glob(f"{one}/*")} == recording_files.keys()
    for stored in ("a", "c"):
        client.delete(f"{hall}/recordings/{stored}/2026-03-02/x").raise_for_status()


def test_an_upload_of_which_nothing_can_be_read_is_refused(client, hall, recording_files):
    broken = {f"robot={name}/day=2026-03-02/x": recording_files | {"can.log": b"garbage"} for name in "ab"}
    answer = sent(client, hall, zip_of(broken))
    assert answer.status_code == 422
    detail = answer.json()["detail"]
    assert detail.startswith(
        "zip: none of 2 recordings can be read, and none was stored; mend them: robot=a/"
    )
    assert "robot=b/day=2026-03-02/x/can.log" in detail
    assert client.components.stores.recordings_of("hall-3").glob("robot=*") == []


@pytest.mark.parametrize(
    ("limits", "words"),
    [({"memory": 50_000_000}, "takes more than 50 MB"), ({"timeout": 0.0}, "was not read within 0 s")],
)
def test_a_recording_that_takes_too_much_is_named(limits, words, tmp_path, recording_folder):
    where = "robot=a/day=2026-03-02/x"
    shutil.copytree(recording_folder, tmp_path / where)
    with pytest.raises(TooLargeError, match=f"{where}: this recording {words}"):
        find_unreadable(tmp_path, [where], **limits)


def test_a_recording_that_is_replaced_keeps_no_file_of_the_former_one(tmp_path, recording_files):
    where, files = "robot=a/day=2026-03-02/x", open_files(str(tmp_path))
    plain = {name: recording_files[name] for name in ("vehicle.toml", "can.log")}
    packed = {"vehicle.toml": plain["vehicle.toml"], "can.log.gz": gzip.compress(plain["can.log"])}
    for sent in (plain, packed):
        store_day(files, zip_of({where: sent}), LIMIT, 1.8e9)
        assert {path.rpartition("/")[2] for path in files.glob(f"{where}/*")} == sent.keys()


def test_a_day_with_a_log_that_unpacks_too_far_is_refused_whole(client, hall):
    one, other = "robot=a/day=2026-03-02/x", "robot=b/day=2026-03-02/x"
    bomb = gzip.compress(b"\n" * 6_000_000)
    members = {f"{one}/can.log": b"", f"{one}/vehicle.toml": b"", f"{other}/vehicle.toml": b""}
    answer = sent(client, hall, zipped(members | {f"{other}/can.log.gz": bomb}))
    assert (answer.status_code, answer.json()["title"]) == (413, "Too large")
    assert client.components.stores.recordings_of("hall-3").glob("robot=*") == []


@pytest.mark.parametrize(("ahead", "status"), [(0, 201), (1, 201), (2, 422), (30_000, 422)])
def test_recordings_are_of_days_up_to_tomorrow(ahead, status, tmp_path, recording_files):
    """Somewhere it is tomorrow already; a later date is wrong, and would end the fleet's alerting."""
    now = datetime(2026, 5, 31, 23, 59, tzinfo=UTC)
    content = zip_of({f"robot=a/day={(now + timedelta(days=ahead)).date()}/x": recording_files})
    files = open_files(str(tmp_path))
    if status == 201:
        assert store_day(files, content, LIMIT, now.timestamp()).recordings == 1
        return
    with pytest.raises(InvalidValueError, match="not come yet; expected one up to 2026-06-01") as caught:
        store_day(files, content, LIMIT, now.timestamp())
    assert (caught.value.status, files.glob("*")) == (422, [])


def test_a_recording_is_deleted_with_its_results_and_the_report_of_its_day(client, hall, recording_files):
    files, results = (
        of("hall-3") for of in (client.components.stores.recordings_of, client.components.stores.results_of)
    )
    where = "robot=wrong/day=2026-04-30/060000"
    sent(client, hall, zip_of({where: recording_files}))
    write_recordings(results, "wrong", ["2026-04-30"])
    write_report(results, daily_report("2026-04-30"))
    with client.components.database.writing() as db:
        db.get(FleetRow, "hall-3").night = "2026-04-30"
    path = f"{hall}/recordings/wrong/2026-04-30/060000"
    assert client.delete(path).json() == {"done": f"recording {where} is deleted"}
    assert client.get(f"{hall}/nights").json()["items"] == [DATES[-1]]
    assert client.get(f"{hall}/robots/wrong").status_code == 404
    assert files.glob("robot=*") == []
    with client.components.database.reading() as db:
        assert db.get(FleetRow, "hall-3").night == DATES[-1]
    assert client.delete(path).status_code == 404


def test_no_recording_is_deleted_while_a_batch_of_the_fleet_waits_or_runs(client, hall):
    with client.components.database.writing() as db:
        batch = add_batch(db, "hall-3", BatchStart())
        batch.state, batch.lease, batch.owner = "running", 2e10, "another"
        known = batch.id
    answer = client.delete(f"{hall}/recordings/tug-0001/{DATES[-1]}/060000")
    assert answer.status_code == 409
    assert f"batch {known} of this fleet is running; wait" in answer.json()["detail"]
    assert client.post(f"{hall}/batches/{known}/cancel").status_code == 200


def test_a_fleet_counts_its_robots_by_state(client, hall):
    fleet = client.get(hall).json()
    assert fleet["states"] == {"fine": 37, "drift": 2, "sick": 1, "unjudged": 1}
    assert (fleet["nights"], fleet["night"], fleet["places"]) == (1, DATES[-1], 2)
    assert fleet in client.get(PATH).json()["items"]


def test_the_daily_report_names_the_faulty_robot_the_places_and_what_failed(client, hall):
    report = client.get(f"{hall}/nights/latest").json()
    assert [robot["robot"] for robot in report["sick"]] == [FAULTY]
    assert "wheelbase changed by -0.760" in report["sick"][0]["says"]
    assert [place["effect"] for place in report["places"]] == ["loss", "creep"]
    assert report["failed"] == [
        {"robot": "tug-0001", "recording": "060000", "problem": "can.log: no SYNC in it"}
    ]
    assert report["asked"][0]["robot"] == ASKED
    assert client.get(f"{hall}/nights/{DATES[-1]}").json() == report
    assert client.get(f"{hall}/nights").json() == {"items": [DATES[-1]], "next": None}


def test_robots_are_listed_page_by_page_and_by_state(client, hall):
    names = [robot["robot"] for robot in listed(client, f"{hall}/robots", 15)]
    assert names == sorted([*robots(), "tug-9999"])
    drifting = client.get(f"{hall}/robots", params={"state": "drift"}).json()["items"]
    assert [robot["robot"] for robot in drifting] == sorted([DRIFTS, ASKED])


def test_a_robots_history_is_that_of_its_numbers_with_the_finding(client, hall):
    history = client.get(f"{hall}/robots/{FAULTY}/history").json()
    assert history["robot"]["state"] == "sick"
    assert [course["name"] for course in history["courses"]] == ["left wheel", "right wheel", "wheelbase"]
    assert history["courses"][2]["days"] == list(DATES)
    assert np.mean(history["courses"][2]["value"][21:]) < -0.004
    assert client.get(f"{hall}/robots/none/history").status_code == 404


def test_a_robots_recordings_are_listed_newest_first(client, hall):
    rows = listed(client, f"{hall}/robots/{FAULTY}/recordings", 7)
    assert [recording["day"] for recording in rows] == list(reversed(DATES))


def test_each_floor_has_its_map_and_that_with_most_recordings_comes_first(client, hall):
    files = client.components.stores.results_of("hall-3")
    write_report(files, report_of_two_floors())
    listed = client.get(f"{hall}/nights/latest").json()
    assert [floor["floor"] for floor in listed["floors"]] == ["north", "south"]
    first = client.get(f"{hall}/nights/latest/floor").json()
    south = client.get(f"{hall}/nights/latest/floor?floor=south").json()
    assert (first["floor"], south["floor"], len(south["driven"])) == ("north", "south", 9)
    assert (first["cell"], len(first["driven"]) > 500) == (0.25, True)
    assert [floor["places"][0]["effect"] for floor in (first, south)] == ["loss", "creep"]
    assert client.get(f"{hall}/nights/latest/floor?floor=none").status_code == 404
    write_report(files, daily_report())


def test_the_findings_report_is_a_page_that_needs_nothing_else(client, hall):
    report = client.get(f"{hall}/robots/{FAULTY}/report")
    assert "wheelbase changed by -0.760" in report.text
    assert report.text.count("<svg") == 3
    assert "sandbox" in report.headers["content-security-policy"]
    assert "http" not in report.text.replace("http://www.w3.org", "")
