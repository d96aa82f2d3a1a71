"""The states of a session: which calls each allows, and that no sequence of calls leaves the table."""

from types import SimpleNamespace
from typing import get_args

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule, run_state_machine_as_test

from omnimate.service.errors import ExpiredError, OmnimateError, StateError
from omnimate.service.store import vehicles
from omnimate.service.store.tables import SessionRow, find_row
from omnimate.service.umbmark.models import Call, Coordinates, SampleOfFixes, SessionStart, State
from omnimate.service.umbmark.result import make_result
from omnimate.service.umbmark.samples import add_measured_sample, remove_sample
from omnimate.service.umbmark.sessions import (
    OPEN_STATES,
    accept_result,
    drives_for,
    end_lease,
    interrupt_orphans,
    possible_calls,
    require_call,
    samples_of,
    session_for,
    session_with_samples,
    start_session,
    state_of,
    store_result,
    take_lease,
    vehicle_of,
)

CALLS, STATES = get_args(Call), get_args(State)
BY_HAND = {
    "collecting": {"sample", "remove", "solve", "abort"},
    "driving": {"abort"},
    "measuring": {"sample", "abort"},
    "interrupted": {"resume", "remove", "solve", "abort"},
    "solved": {"sample", "remove", "solve", "accept", "abort"},
}


def session(state, how="manual", expires=10.0):
    return SimpleNamespace(id="5e55", state=state, how=how, expires=expires)


@pytest.mark.parametrize("state", STATES)
def test_the_calls_that_a_state_allows(state):
    assert set(possible_calls(session(state), 0.0)) == BY_HAND.get(state, set())


@pytest.mark.parametrize("state", STATES)
def test_a_driven_session_takes_a_sample_only_where_a_person_has_to_measure(state):
    by_hand = set(possible_calls(session(state), 0.0))
    driven = set(possible_calls(session(state, how="drive"), 0.0))
    assert driven == (by_hand if state == "measuring" else by_hand - {"sample"})


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("call", CALLS)
def test_a_call_is_refused_exactly_where_it_is_not_listed_as_possible(state, call):
    row = session(state)
    if call in possible_calls(row, 0.0):
        require_call(row, call, 0.0)
        return
    with pytest.raises(ExpiredError if state == "expired" else StateError) as caught:
        require_call(row, call, 0.0)
    assert getattr(caught.value, "possible", ()) == possible_calls(row, 0.0)


@pytest.mark.parametrize("state", STATES)
def test_only_an_open_session_that_does_not_drive_expires(state):
    expires = state in OPEN_STATES and state != "driving"
    assert state_of(session(state), 10.1) == ("expired" if expires else state)
    assert state_of(session(state), 9.9) == state


class Session(RuleBasedStateMachine):
    """A session under any sequence of calls and of events of its robot."""

    database = None

    @initialize(how=st.sampled_from(["manual", "drive"]))
    def begin(self, how):
        with self.database.writing() as db:
            version = vehicles.newest(db, "omnimate").version
            self.id = start_session(db, SessionStart(how=how, runs=1), "omnimate", 1e6).id
        self.numbers, self.version, self.ended = [], version, False

    def call(self, name, act):
        """Make a call; return whether it was allowed, which must be what the session listed."""
        with self.database.reading() as db:
            possible = possible_calls(find_row(db, SessionRow, self.id), 0.0)
        try:
            with self.database.writing() as db:
                act(db, session_for(db, self.id, name, 1e6))
        except OmnimateError:
            return False
        assert name in possible
        return True

    @rule(direction=st.sampled_from(["cw", "ccw"]), x=st.sampled_from([0.1, 0.15]))
    def sample(self, direction, x):
        request = SampleOfFixes(
            direction=direction,
            after=Coordinates(x=x, y=0.02, theta=0.01),
            calculated=Coordinates(x=0.0, y=0.0, theta=0.0),
        )
        self.call("sample", lambda db, row: self.numbers.append(add_measured_sample(db, row, request).number))

    @rule(data=st.data())
    def remove(self, data):
        if self.numbers:
            number = data.draw(st.sampled_from(self.numbers))
            if self.call("remove", lambda db, row: remove_sample(db, row, number)):
                self.numbers.remove(number)

    @rule()
    def solve(self):
        def solve_session(db, row):
            samples = samples_of(db, row)
            store_result(db, row, samples, make_result(row, samples, vehicle_of(db, row), "exact"))

        self.call("solve", solve_session)

    @rule()
    def accept(self):
        self.ended |= self.call("accept", lambda db, row: accept_result(db, row, None, None, force=True))

    @rule()
    def abort(self):
        self.ended |= self.call("abort", lambda _db, row: end_lease(row, "aborted", "aborted"))

    @rule()
    def resume(self):
        self.call("resume", lambda _db, row: take_lease(row, "this"))

    @rule()
    def its_service_dies(self):
        with self.database.writing() as db:
            row = find_row(db, SessionRow, self.id)
            drove = drives_for(row, "this")
            if drove:
                row.lease = 0.0
            assert (self.id in interrupt_orphans(db)) == drove

    @rule()
    def its_robot_begins_to_drive(self):
        with self.database.writing() as db:
            row = find_row(db, SessionRow, self.id)
            if row.how == "drive" and row.state == "collecting":
                take_lease(row, "this")

    @invariant()
    def what_clients_see_is_consistent(self):
        with self.database.reading() as db:
            row = find_row(db, SessionRow, self.id)
            view = session_with_samples(db, row)
        assert view.state in STATES
        assert [sample.number for sample in view.samples] == sorted(self.numbers)
        assert view.counts.cw + view.counts.ccw == len(self.numbers)
        assert (row.result is not None) >= (view.state in {"solved", "accepted"})
        assert (row.owner is not None) == (view.state == "driving")
        assert (not view.possible) == self.ended


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_no_sequence_of_calls_brings_a_session_out_of_its_table(database):
    Session.database = database
    run_state_machine_as_test(Session, settings=settings(max_examples=15, stateful_step_count=15))
