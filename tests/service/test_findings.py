"""Findings of daily reports, and the messages about them: signed, sent until accepted, never lost."""

import base64
import hashlib
import hmac
import json
import socket
from contextlib import ExitStack
from dataclasses import replace
from functools import cache
from itertools import count, pairwise
from threading import Event

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.fleet.report import FloorSummary
from omnimate.service.fleets.findings import go_back, note_findings
from omnimate.service.fleets.webhooks import (
    LEASE,
    PAUSES,
    Deliverer,
    Message,
    add_webhook,
    claim_message,
    deliver,
    remove_webhook,
    send_message,
    settle,
    signed_headers,
)
from omnimate.service.store.database import Database
from omnimate.service.store.tables import DeliveryRow, FindingRow, FleetRow, WebhookRow
from tests.client.answering import answering
from tests.service.conftest import until
from tests.service.hall_results import DATES, FAULTY, daily_report, place


def delivery(database):
    """Return the only message."""
    with database.reading() as db:
        return db.query(DeliveryRow).one()


def deliver_next(database, now, send=send_message):
    """Send the message that has been due longest; return whether there was one."""
    with database.writing() as db:
        message = claim_message(db, now())
    if message is not None:
        deliver(database, message, now, send)
    return message is not None


BEGIN = 2e9  # [s] later than any message is made


def with_hook(database):
    """Return the database with nothing but a fleet that has one webhook."""
    with database.writing() as db:
        for table in (DeliveryRow, WebhookRow, FindingRow, FleetRow):
            db.query(table).delete()
        db.add(FleetRow(id="hall", created=0.0))
        db.flush()
        add_webhook(db, "hall", "http://127.0.0.1:9/hook")
    return database


@pytest.fixture
def fleet(database):
    return with_hook(database)


def note(database, judged):
    with database.writing() as db:
        note_findings(db, "hall", judged)


def findings(database):
    with database.reading() as db:
        rows = db.query(FindingRow).order_by(FindingRow.kind, FindingRow.what).all()
        return [(row.kind, row.robot, row.what, row.state, row.first, row.last) for row in rows]


def messages(database):
    with database.reading() as db:
        return [json.loads(row.body)["data"]["says"] for row in db.query(DeliveryRow)]


def message_types(database):
    """Return the type of each message, its state, and the day of its report."""
    with database.reading() as db:
        bodies = [json.loads(row.body) for row in db.query(DeliveryRow)]
        return sorted((body["type"], body["data"]["state"], body["timestamp"]) for body in bodies)


def test_a_finding_is_opened_once_prolonged_and_closed(fleet):
    healthy = replace(daily_report("2026-04-02"), faulty=(), places=())
    moved = (place("loss", 16.4, 12.3),)
    for judged in (
        daily_report("2026-03-30"),
        daily_report("2026-03-31", places=moved),
        daily_report("2026-03-31"),
    ):
        note(fleet, judged)
    assert [finding[3:] for finding in findings(fleet)] == [
        ("closed", "2026-03-30", "2026-03-30"),  # the creep was not named in the second report
        ("open", "2026-03-31", "2026-03-31"),
        ("open", "2026-03-30", "2026-03-31"),
        ("open", "2026-03-30", "2026-03-31"),
    ]
    opened = [("finding.opened", "open", f"2026-03-{day}") for day in (30, 30, 30, 31)]
    closed = [("finding.closed", "closed", "2026-03-31")]
    assert message_types(fleet) == closed + opened
    note(fleet, healthy)
    assert {finding[3] for finding in findings(fleet)} == {"closed"}
    note(fleet, daily_report("2026-03-30"))  # an earlier report that is written again says nothing new
    assert {finding[3] for finding in findings(fleet)} == {"closed"}
    assert message_types(fleet) == closed + [("finding.closed", "closed", "2026-04-02")] * 3 + opened


def test_a_report_closes_only_findings_of_robots_and_floors_that_it_judges(fleet):
    """A robot that does not drive, or a floor without recordings, was not repaired."""
    note(fleet, daily_report("2026-03-30"))
    of_another = daily_report("2026-03-31", names=["tug-0001"], places=())
    note(fleet, replace(of_another, floors=(FloorSummary("annex", 3, 6e-4),)))
    assert [finding[3] for finding in findings(fleet)] == ["open"] * 3
    note(fleet, daily_report("2026-04-01", places=()))
    assert [finding[:4:3] for finding in findings(fleet)] == [("place", "closed")] * 2 + [("robot", "open")]


def test_a_finding_that_no_report_has_judged_for_30_days_is_closed_and_says_so(fleet):
    """A robot that was scrapped, and a floor that is no longer used, would stay open for ever."""
    annex = (FloorSummary("annex", 3, 6e-4),)
    of_another = replace(daily_report(names=["tug-0001"], places=()), floors=annex)
    note(fleet, daily_report("2026-03-30"))
    note(fleet, replace(of_another, day="2026-04-28"))
    assert [finding[3] for finding in findings(fleet)] == ["open"] * 3
    note(fleet, replace(of_another, day="2026-04-29"))
    assert [finding[3] for finding in findings(fleet)] == ["closed"] * 3
    reason = "; closed, as no report has judged it for 30 days"
    assert [says.endswith(reason) for says in messages(fleet)].count(True) == 3
    note(fleet, daily_report("2026-04-30"))
    assert [finding[3] for finding in findings(fleet)].count("open") == 3


def test_after_a_wrong_day_was_deleted_reports_of_real_days_are_noted_again(fleet):
    note(fleet, replace(daily_report("2062-01-01"), faulty=(), places=()))
    note(fleet, daily_report("2026-03-30"))
    assert findings(fleet) == []
    with fleet.writing() as db:
        go_back(db, "hall", "2026-03-29")
    note(fleet, daily_report("2026-03-30"))
    with fleet.writing() as db:
        go_back(db, "hall", "2026-03-31")  # a report that was not noted yet
    note(fleet, daily_report("2026-03-30"))
    assert [finding[3] for finding in findings(fleet)] == ["open"] * 3


def test_places_at_the_same_point_of_two_floors_are_two_findings(fleet):
    floors = FloorSummary("north", 280, 6e-4), FloorSummary("south", 20, 8e-4)
    for day, floor in (("2026-03-30", "north"), ("2026-03-31", "south")):
        places = (place("loss", 16.0, 12.0, floor),)
        note(fleet, replace(daily_report(day), faulty=(), places=places, floors=floors))
    assert sorted(finding[3] for finding in findings(fleet)) == ["closed", "open"]
    assert any(says.startswith("floor south, at x 16.00 m") for says in messages(fleet))


def test_a_report_that_is_noted_twice_sends_once(fleet):
    note(fleet, daily_report())
    note(fleet, daily_report())
    assert len(messages(fleet)) == 3
    assert any(FAULTY in says for says in messages(fleet))
    assert {finding[4] for finding in findings(fleet)} == {DATES[-1]}


def test_what_is_not_accepted_is_sent_again_after_the_standards_pauses_and_given_up_at_the_end(fleet):
    note(fleet, replace(daily_report(), places=()))
    sent, now = [], [BEGIN]

    def refuse(message, at):
        sent.append((message.id, at))
        return 503, "503 busy"

    while len(sent) < len(PAUSES):
        assert deliver_next(fleet, lambda: now[0], refuse)
        assert not deliver_next(fleet, lambda: now[0], refuse)
        now[0] = delivery(fleet).due
    assert len({identity for identity, _ in sent}) == 1
    times = [at for _, at in sent]
    assert [later - earlier for earlier, later in pairwise(times)] == list(PAUSES[1:])
    row = delivery(fleet)
    assert (row.state, row.attempts, row.answer) == ("given up", len(PAUSES), "503 busy")


def test_a_receiver_that_wants_no_more_is_sent_no_more(fleet):
    note(fleet, replace(daily_report(), places=()))
    assert deliver_next(fleet, lambda: BEGIN, lambda _message, _now: (410, "410 Gone"))
    assert delivery(fleet).state == "given up"


def test_an_answer_that_postgresql_cannot_store_ends_an_attempt_as_any_other(postgresql_url):
    """A NUL in it: the attempt was not noted, and the message was sent again each minute, for ever."""
    fleet = with_hook(Database(postgresql_url))
    note(fleet, replace(daily_report(), places=()))
    assert deliver_next(fleet, lambda: BEGIN, lambda _message, _now: (200, "200 O\0K"))
    assert (delivery(fleet).state, delivery(fleet).answer) == ("accepted", "200 O K")
    fleet.close()


def test_messages_of_a_removed_webhook_do_not_wait(fleet):
    note(fleet, daily_report())
    with fleet.writing() as db:
        remove_webhook(db, db.query(WebhookRow).one())
    assert not deliver_next(fleet, lambda: BEGIN)
    with fleet.reading() as db:
        assert {row.state for row in db.query(DeliveryRow)} == {"given up"}


@settings(max_examples=40)
@given(dies=st.lists(st.sampled_from(["before", "after", "never", "refused"]), max_size=6))
def test_no_message_is_lost_when_services_die_while_they_send(database, dies):
    """A service may die before it sends or before it notes the answer; the message arrives once or more."""
    note(with_hook(database), replace(daily_report(), places=()))
    arrived, now = 0, BEGIN
    for death in [*dies, "never"]:
        with database.writing() as db:
            message = claim_message(db, now)
        if message is None:
            break
        arrived += death in {"after", "never"}
        if death in {"never", "refused"}:
            with database.writing() as db:
                settle(db, message, 200 if death == "never" else 500, death, now)
        now += max(LEASE, PAUSES[-1])
    assert arrived >= 1
    assert delivery(database).state == "accepted"


def test_the_signature_is_that_of_the_standards_example():
    """Standard Webhooks' reference libraries test this message: id, timestamp, payload, secret, signature."""
    message = Message(
        "msg_p5jXN8AQM9LWM0D4loKWxJek", "", 1, "http://x", "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw",
        '{"test": 2432232314}',
    )  # fmt: skip
    headers = signed_headers(message, 1614265330)
    assert headers["webhook-signature"] == "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="


def test_a_message_arrives_signed_at_a_server_and_follows_no_redirect(fleet):
    with answering() as server:
        server.answers = [(302, {"Location": "/elsewhere"}, ""), (204, {}, "")]
        with fleet.writing() as db:
            webhook = db.query(WebhookRow).one()
            webhook.url = f"{server.url}/hook"
            key = base64.b64decode(webhook.secret.removeprefix("whsec_"))
        note(fleet, replace(daily_report(), places=()))
        assert deliver_next(fleet, lambda: BEGIN, send_message)
        assert deliver_next(fleet, lambda: BEGIN + PAUSES[1], send_message)
    for command, path, headers, body in server.requests:
        signed = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
        expected = base64.b64encode(hmac.new(key, signed, hashlib.sha256).digest()).decode()
        assert (command, path, headers["webhook-signature"]) == ("POST", "/hook", f"v1,{expected}")
        assert json.loads(body)["type"] == "finding.opened"
    row = delivery(fleet)
    assert (len(server.requests), row.state, row.answer) == (2, "accepted", "204 No Content")


def test_a_receiver_that_is_not_there_is_tried_again(fleet):
    note(fleet, replace(daily_report(), places=()))
    assert deliver_next(fleet, lambda: BEGIN, send_message)
    row = delivery(fleet)
    assert (row.state, row.attempts) == ("waiting", 1)
    assert "no answer" in row.answer


def test_a_receiver_that_answers_byte_by_byte_is_left_when_the_time_of_an_attempt_is_over():
    looks = count()
    with socket.create_server(("127.0.0.1", 0)) as listener, ExitStack() as opened:

        @cache
        def receiver():
            return opened.enter_context(listener.accept()[0])

        def clock():
            """At each look at the clock five seconds have passed, and one byte of the answer has come."""
            look = next(looks)
            if look:
                receiver().sendall(b"HTTP/1.1 200 OK"[look - 1 : look])
            return 5.0 * look

        message = Message("msg_1", "", 1, f"http://127.0.0.1:{listener.getsockname()[1]}/", "whsec_", "{}")
        assert send_message(message, 0.0, clock) == (None, "no answer: not within 15 s")
    assert next(looks) == 4


def test_a_slow_receiver_delays_no_other_one_and_gets_one_message_at_a_time(fleet):
    with fleet.writing() as db:
        slow = add_webhook(db, "hall", "http://127.0.0.1:9/slow").id
    note(fleet, daily_report())
    answered, sent = Event(), []

    def send(message, _now):
        sent.append(message.webhook)
        if message.webhook == slow:
            answered.wait()
        return 200, "200 OK"

    def waiting():
        with fleet.reading() as db:
            return [row.webhook for row in db.query(DeliveryRow).filter_by(state="waiting")]

    deliverer = Deliverer(fleet, send)
    deliverer.start()
    until(lambda: waiting() == [slow] * 3)
    assert sent.count(slow) == 1
    answered.set()
    until(lambda: waiting() == [])
    deliverer.close()
    assert sent.count(slow) == 3


def test_webhooks_are_made_listed_and_removed_and_show_their_secret_once(client):
    client.post("/v1/fleets", json={"name": "hooked"})
    made = client.post("/v1/fleets/hooked/webhooks", json={"url": "https://fleet.example/hook"})
    assert made.status_code == 201
    assert made.json()["secret"].startswith("whsec_")
    location = made.headers["Location"]
    assert client.get(location).json()["secret"] is None
    assert client.get(f"{location}/deliveries").json() == {"items": [], "next": None}
    assert client.delete(location).status_code == 200
    assert client.get("/v1/fleets/hooked/webhooks").json()["items"] == []
    assert client.get("/v1/fleets/hooked/findings").json()["items"] == []


@pytest.mark.parametrize(
    ("url", "status"),
    [
        ("https://fleet.example/hook", 201),
        ("http://[::1]:8080/hook?a=%C3%A9", 201),
        ("file:///etc/passwd", 422),
        ("http://127.0.0.1:99999/", 422),
        ("http://127.0.0.1:0/", 422),
        ("http://127.0.0.1:port/", 422),
        ("http://[::1/", 422),
        ("http://:80/", 422),
        ("http://fleet.example/\u00e9", 422),
        ("http://fleet.example/\0", 422),
        ("http://user:hunter2@fleet.example/", 422),
    ],
)
def test_a_webhook_has_a_url_to_which_a_message_can_be_sent(client, url, status):
    client.post("/v1/fleets", json={"name": "reached"})
    answer = client.post("/v1/fleets/reached/webhooks", json={"url": url})
    assert answer.status_code == status
    assert "hunter2" not in answer.text
