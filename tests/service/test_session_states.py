"""The states of a session: which calls each allows."""

from types import SimpleNamespace
from typing import get_args

import pytest

from omnimate.service.errors import ExpiredError, StateError
from omnimate.service.umbmark.models import Call, State
from omnimate.service.umbmark.sessions import (
    OPEN_STATES,
    possible_calls,
    require_call,
    state_of,
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
