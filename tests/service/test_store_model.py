"""The store agrees with a model in plain dictionaries after operations and jumps of the clock.

Two services work on one database; their routes are called as a client calls them, without a robot.
"""

import json
from types import SimpleNamespace
from unittest.mock import Mock

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    Bundle,
    RuleBasedStateMachine,
    initialize,
    invariant,
    multiple,
    precondition,
    rule,
    run_state_machine_as_test,
)
from sqlalchemy import select

from omnimate.service.access import LOCAL
from omnimate.service.calls import Call
from omnimate.service.errors import StateError
from omnimate.service.jobs import queue
from omnimate.service.robot.session_reporter import SessionReporter
from omnimate.service.routes import diagnoses, umbmark_sessions
from omnimate.service.store import tables, vehicles
from omnimate.service.store.tables import AnswerRow, JobRow, SampleRow, SessionRow, VehicleRow
from omnimate.service.umbmark import samples, sessions
from omnimate.service.umbmark.models import Accept, Coordinates, SampleOfFixes, SessionStart
from omnimate.vehicle.errors import OmnimateError
from tests.service.conftest import recording_row

LIFETIME = 100.0  # [s]
SERVICES = st.sampled_from(["this", "another"])
KEYS = st.sampled_from([None, None, None, None, "a", "b"])
DIRECTIONS = st.sampled_from([("cw",), ("ccw",), ("cw", "ccw")])
OUTCOMES = {
    "done": {"verdict": "agreement", "says": "fine", "result": "{}", "report": "<html>"},
    "failed": {"error": "too short"},
    "died": {"died": "its process ended with code -9"},
    "stopped": None,
}
TIMED = (queue, samples, sessions, tables, umbmark_sessions)  # read the clock
# The bounds themselves, what is within and beyond them, and a clock that is set back.
JUMPS = st.sampled_from(
    [1.0] * 6 + [sessions.LEASE, queue.LEASE] * 2 + [LIFETIME, queue.ANSWERS_KEPT, -3600.0]
)


def lease_is_over(lease, now, duration):
    return not now <= lease <= now + 2.0 * duration


class Store(RuleBasedStateMachine):
    """Sessions, samples, leases, jobs and answers, each with what the model expects of it."""

    database = None
    session_ids, job_ids = Bundle("session_ids"), Bundle("job_ids")

    @initialize(target=session_ids)
    def begin(self):
        with self.database.writing() as db:
            for table in (SampleRow, SessionRow, JobRow, AnswerRow):
                db.query(table).delete()
            db.query(VehicleRow).where(VehicleRow.version > 1).delete()
        self.newest_version = 1
        self.now = 1e9
        self.sessions, self.jobs, self.answers = {}, {}, {}
        self.patch = pytest.MonkeyPatch()
        for module in TIMED:
            self.patch.setattr(module, "time", SimpleNamespace(time=lambda: self.now))
        self.components = {
            instance: SimpleNamespace(
                database=self.database,
                vehicle="omnimate",
                settings=SimpleNamespace(instance=instance, lifetime=LIFETIME),
                robot=Mock(),
                reporter=SessionReporter(self.database, lambda *_: None, "omnimate", instance, None),
                worker=Mock(),
            )
            for instance in ("this", "another")
        }
        measured, driven = (self.start(how, "this", None) for how in ("manual", "drive"))
        self.samples(measured, ("cw", "ccw"), "this", None)  # so that it can be solved at once
        return multiple(measured, driven)

    def teardown(self):
        self.patch.undo()

    def send(self, instance, key, name, route, *arguments, allowed=True):
        """Send a request; return its content if it was carried out, None if it was refused or repeated."""
        call = Call(self.components[instance], LOCAL, key, name)
        request = name, repr(arguments)
        if key in self.answers:
            first = self.answers[key]
            if first["request"] != request:
                with pytest.raises(StateError, match="used for another request"):
                    route(*arguments, call)
                return None
            repeated = route(*arguments, call)
            assert repeated.body == first["body"]
            assert "Idempotency-Replayed" in repeated.headers
            return None
        if not allowed:
            with pytest.raises(OmnimateError):
                route(*arguments, call)
            return None
        response = route(*arguments, call)
        assert "Idempotency-Replayed" not in response.headers
        if key is not None:
            self.answers[key] = {"request": request, "body": response.body, "created": self.now}
        return json.loads(response.body)

    def is_in(self, session, *states):
        """Return whether a session is in one of some states, and has not expired."""
        expired = session["state"] != "driving" and self.now > session["expires"]
        return session["state"] in states and not expired

    def used(self, session, **changes):
        session.update(changes, expires=self.now + LIFETIME)

    def driven(self, session, instance):
        self.used(session, state="driving", owner=instance, lease=self.now + sessions.LEASE)

    @rule(seconds=JUMPS)
    def time_passes(self, seconds):
        self.now += seconds

    @rule()
    def a_service_keeps_house(self):
        interrupted = queue.expire_sessions_and_requeue_jobs(self.database)
        expected = []
        for number, session in self.sessions.items():
            drives = session["state"] == "driving"
            if drives and lease_is_over(session["lease"], self.now, sessions.LEASE):
                session.update(state="interrupted", owner=None, lease=None)
                expected.append(number)
            if session["state"] in sessions.OPEN_STATES and not self.is_in(session, *sessions.OPEN_STATES):
                session["state"] = "expired"
        assert sorted(interrupted) == sorted(expected)
        for job in self.jobs.values():
            if job["state"] == "running" and lease_is_over(job["lease"], self.now, queue.LEASE):
                self.given_back(job)
        oldest = self.now - queue.ANSWERS_KEPT
        self.answers = {key: answer for key, answer in self.answers.items() if answer["created"] >= oldest}

    @precondition(lambda self: len(self.sessions) < 5)
    @rule(target=session_ids, how=st.sampled_from(["manual", "drive"]), instance=SERVICES, key=KEYS)
    def start(self, how, instance, key):
        body = SessionStart(how=how, runs=1)
        content = self.send(instance, key, "start", umbmark_sessions.start_session, body)
        if content is None:
            return multiple()
        session = self.sessions[content["id"]] = {
            "how": how, "version": self.newest_version, "samples": {}, "solved": False,
        }  # fmt: skip
        self.used(session, state="collecting", owner=None, lease=None)
        if how == "drive":
            self.driven(session, instance)
        return content["id"]

    @rule(number=session_ids, directions=DIRECTIONS, instance=SERVICES, key=KEYS)
    def samples(self, number, directions, instance, key):
        for direction in directions:
            self.sample(number, direction, instance, key)

    def sample(self, number, direction, instance, key):
        session = self.sessions[number]
        body = SampleOfFixes(
            direction=direction,
            after=Coordinates(x=0.1 if direction == "cw" else 0.15, y=0.02, theta=0.01),
            calculated=Coordinates(x=0.0, y=0.0, theta=0.0),
        )
        by_hand = self.is_in(session, "collecting", "solved") and session["how"] == "manual"
        measured = self.is_in(session, "measuring")
        content = self.send(
            instance,
            key,
            f"sample {number}",
            umbmark_sessions.add_sample,
            number,
            body,
            allowed=by_hand or measured,
        )
        if content is None:
            return
        session["samples"][max(session["samples"], default=0) + 1] = direction
        assert content["number"] == max(session["samples"])
        self.used(session, state="collecting", solved=False)
        if measured and len(set(session["samples"].values())) == 1:
            self.driven(session, instance)

    @rule(number=session_ids, run=st.integers(1, 3), instance=SERVICES, key=KEYS)
    def remove(self, number, run, instance, key):
        session = self.sessions[number]
        allowed = self.is_in(session, "collecting", "interrupted", "solved") and run in session["samples"]
        route = umbmark_sessions.remove_sample
        if self.send(instance, key, f"remove {number} {run}", route, number, run, allowed=allowed) is None:
            return
        del session["samples"][run]
        state = "collecting" if session["state"] == "solved" else session["state"]
        if session["how"] == "drive" and len(set(session["samples"].values())) < 2:
            state = "interrupted"
        self.used(session, state=state, solved=False)

    @rule(number=session_ids, instance=SERVICES, key=KEYS)
    def solve(self, number, instance, key):
        session = self.sessions[number]
        both = len(set(session["samples"].values())) == 2
        allowed = both and self.is_in(session, "collecting", "interrupted", "solved")

        def route(number, call):
            return umbmark_sessions.solve_session(number, call, None)

        if self.send(instance, key, f"solve {number}", route, number, allowed=allowed) is not None:
            self.used(session, state="solved", solved=True)

    @rule(number=session_ids, instance=SERVICES, key=KEYS)
    def accept(self, number, instance, key):
        session = self.sessions[number]
        allowed = self.is_in(session, "solved") and session["version"] == self.newest_version

        def route(number, call):
            return umbmark_sessions.accept_result(number, call, "*", Accept(force=True))

        if self.send(instance, key, f"accept {number}", route, number, allowed=allowed) is not None:
            self.newest_version += 1
            self.used(session, state="accepted")

    @rule(number=session_ids, instance=SERVICES, key=KEYS)
    def abort(self, number, instance, key):
        session = self.sessions[number]
        allowed = self.is_in(session, *sessions.OPEN_STATES)
        route = umbmark_sessions.abort_session
        if self.send(instance, key, f"abort {number}", route, number, allowed=allowed) is not None:
            self.used(session, state="aborted", owner=None, lease=None)

    @rule(number=session_ids, instance=SERVICES, key=KEYS)
    def resume(self, number, instance, key):
        session = self.sessions[number]
        allowed = self.is_in(session, "interrupted")
        route = umbmark_sessions.resume_session
        if self.send(instance, key, f"resume {number}", route, number, allowed=allowed) is not None:
            self.driven(session, instance)

    @rule(number=session_ids, instance=SERVICES)
    def a_service_renews_the_lease_of_a_session(self, number, instance):
        session = self.sessions[number]
        is_owner = session["owner"] == instance
        assert self.components[instance].reporter.renew(number) == is_owner
        if is_owner:
            session["lease"] = self.now + sessions.LEASE

    @rule(number=session_ids, instance=SERVICES)
    def a_lap_has_to_be_measured(self, number, instance):
        session = self.sessions[number]
        if session["owner"] == instance:
            with self.database.writing() as db:
                sessions.end_lease(db.get(SessionRow, number), "measuring", "measure")
            session.update(state="measuring", owner=None, lease=None)

    @rule(number=session_ids, instance=SERVICES)
    def a_robot_is_lost(self, number, instance):
        session = self.sessions[number]
        self.components[instance].reporter.interrupted(number, "the robot was lost")
        if session["owner"] == instance:
            session.update(state="interrupted", owner=None, lease=None)

    @precondition(lambda self: len(self.jobs) < 5)
    @rule(target=job_ids, instance=SERVICES, key=KEYS)
    def queue_a_job(self, instance, key):
        body = queue.DiagnosisStart(recordings=["rec"])
        content = self.send(instance, key, "diagnose", diagnoses.start_diagnosis, body)
        if content is None:
            return multiple()
        self.jobs[content["id"]] = {"attempts": 0, "created": self.now}
        self.jobs[content["id"]].update(state="queued", owner=None, lease=None)
        return content["id"]

    @rule(instance=SERVICES)
    def claim_a_job(self, instance):
        with self.database.writing() as db:
            number = queue.claim_job(db, instance)
        waiting = {number: job for number, job in self.jobs.items() if job["state"] == "queued"}
        if number is None:
            assert not waiting
            return
        assert waiting[number]["created"] == min(job["created"] for job in waiting.values())
        attempts = waiting[number]["attempts"] + 1
        lease = self.now + queue.LEASE
        waiting[number].update(state="running", owner=instance, lease=lease, attempts=attempts)

    def given_back(self, job):
        is_last = job["attempts"] == queue.MAX_ATTEMPTS
        job.update(state="failed" if is_last else "queued", owner=None, lease=None)

    @rule(number=job_ids, instance=SERVICES, outcome=st.sampled_from(sorted(OUTCOMES)))
    def finish_a_job(self, number, instance, outcome):
        job = self.jobs[number]
        is_owner = job["state"] == "running" and job["owner"] == instance
        with self.database.writing() as db:
            row = queue.job_of(db, number, instance)
            assert (row is not None) == is_owner
            if row is None:
                return
            assert queue.finish_job(row, OUTCOMES[outcome]) == (outcome == "done")
        job["attempts"] -= outcome == "stopped"
        if outcome in {"done", "failed"}:
            job["state"] = outcome
        else:
            self.given_back(job)

    @rule(number=job_ids, instance=SERVICES, key=KEYS)
    def cancel_a_job(self, number, instance, key):
        job = self.jobs[number]
        allowed = job["state"] in {"queued", "running"}
        route = diagnoses.cancel_diagnosis
        if self.send(instance, key, f"cancel {number}", route, number, allowed=allowed) is not None:
            job["state"] = "cancelled"

    @invariant()
    def store_and_model_agree(self):
        with self.database.reading() as db:
            stored = {row.id: row for row in db.scalars(select(SessionRow))}
            runs = {(row.session, row.number): row.direction for row in db.scalars(select(SampleRow))}
            jobs = {row.id: row for row in db.scalars(select(JobRow))}
            answers = {row.key: (row.body.encode(), row.created) for row in db.scalars(select(AnswerRow))}
            newest = vehicles.newest(db, "omnimate").version
            counts = sessions.count_samples(db, stored)
        for number, session in self.sessions.items():
            directions = list(session["samples"].values())
            assert (counts[number].cw, counts[number].ccw) == (
                directions.count("cw"),
                directions.count("ccw"),
            )
            is_open = self.is_in(session, *sessions.OPEN_STATES)
            assert bool(sessions.possible_calls(stored[number], self.now)) == is_open
        assert all((row.error is not None) == (row.state == "failed") for row in jobs.values())
        assert {
            number: (row.state, row.owner, row.lease, row.expires, row.result is not None)
            for number, row in stored.items()
        } == {
            number: (*(session[name] for name in ("state", "owner", "lease", "expires")), session["solved"])
            for number, session in self.sessions.items()
        }
        assert runs == {
            (session, number): direction
            for session, model in self.sessions.items()
            for number, direction in model["samples"].items()
        }
        assert {number: (row.state, row.owner, row.lease, row.attempts) for number, row in jobs.items()} == {
            number: tuple(job[name] for name in ("state", "owner", "lease", "attempts"))
            for number, job in self.jobs.items()
        }
        assert answers == {key: (first["body"], first["created"]) for key, first in self.answers.items()}
        assert newest == self.newest_version


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_after_any_sequence_of_operations_store_and_model_agree(database):
    with database.writing() as db:
        db.add(recording_row())
    Store.database = database
    run_state_machine_as_test(Store, settings=settings(stateful_step_count=40))
