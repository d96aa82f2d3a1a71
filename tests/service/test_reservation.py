"""The robot's reservation: one session at a time, and it stops when it is not wanted any more."""

from types import SimpleNamespace

import pytest

from omnimate.service.errors import StateError, UnavailableError
from omnimate.service.robot import reservation as module
from omnimate.service.robot.reservation import DriveOrder, Reservation, StoppedError

ORDER = DriveOrder("first", 4.0, 0.4, 30.0)


@pytest.fixture
def now(monkeypatch):
    """A clock that a test sets."""
    time = {"now": 100.0}
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: time["now"]))
    return time


@pytest.fixture
def reservation():
    free = Reservation()
    free.problem = None
    return free


def test_a_robot_that_cannot_be_read_is_not_reserved():
    with pytest.raises(UnavailableError, match="starting"):
        Reservation().reserve("first")


def test_a_second_session_is_refused_until_the_first_one_has_ended(reservation):
    reservation.reserve("first")
    with pytest.raises(StateError, match="drives for session first"):
        reservation.reserve("second")
    assert reservation.end() == "first"
    reservation.reserve("second")
    assert reservation.session == "second"


def test_a_released_robot_is_free_and_a_late_order_moves_nothing(reservation):
    reservation.reserve("first")
    reservation.release("first")
    reservation.begin(ORDER)
    assert (reservation.session, reservation.order) == (None, None)


def test_a_session_that_has_begun_is_not_released(reservation):
    reservation.reserve("first")
    reservation.begin(ORDER)
    reservation.release("first")
    assert reservation.order is ORDER


def test_a_stop_before_the_beginning_stops_the_drive_when_it_begins(reservation):
    reservation.reserve("first")
    reservation.stop("stopped by hand")
    reservation.begin(ORDER)
    with pytest.raises(StoppedError, match="stopped by hand"):
        reservation.require_wanted(ORDER)


@pytest.mark.parametrize("way_to_end", [Reservation.end, lambda taken: taken.release("first")])
def test_a_stop_concerns_no_later_session(reservation, way_to_end):
    reservation.reserve("first")
    reservation.stop("stopped by hand")
    way_to_end(reservation)
    reservation.reserve("first")
    reservation.begin(ORDER)
    reservation.require_wanted(ORDER)


def test_a_stop_is_the_reason_that_the_drive_ends_with(reservation):
    reservation.reserve("first")
    reservation.begin(ORDER)
    reservation.require_wanted(ORDER)
    reservation.stop("stopped by hand")
    with pytest.raises(StoppedError, match="stopped by hand"):
        reservation.require_wanted(ORDER)


def test_a_stop_of_a_free_robot_concerns_no_later_session(reservation):
    reservation.stop("long ago")
    reservation.reserve("first")
    reservation.begin(ORDER)
    reservation.require_wanted(ORDER)


@pytest.mark.parametrize(("session", "goes_on"), [("first", True), (None, True), ("another", False)])
def test_the_robot_goes_on_as_long_as_a_client_asks_for_its_session(reservation, now, session, goes_on):
    reservation.reserve("first")
    reservation.begin(ORDER)
    now["now"] += 29.0
    reservation.note_client(session)
    now["now"] += 2.0
    reservation.note_lease()
    if goes_on:
        reservation.require_wanted(ORDER)
    else:
        with pytest.raises(StoppedError, match="no client asked for the session for 30 s"):
            reservation.require_wanted(ORDER)


def test_without_a_lifeline_it_goes_on_for_ever(reservation, now):
    order = DriveOrder("first", 4.0, 0.4, None)
    reservation.reserve("first")
    reservation.begin(order)
    now["now"] += 1e9
    reservation.note_lease()
    reservation.require_wanted(order)


def test_it_stops_when_its_lease_is_not_renewed(reservation, now):
    reservation.reserve("first")
    reservation.begin(ORDER)
    now["now"] += 9.0
    reservation.note_lease()
    now["now"] += 9.0
    reservation.require_wanted(ORDER)
    now["now"] += 2.0
    with pytest.raises(StoppedError, match="no note of the session for 10 s"):
        reservation.require_wanted(ORDER)


@pytest.mark.parametrize(("session", "reason"), [("first", "aborted"), ("another", None)])
def test_a_stop_of_one_session_stops_no_other(reservation, session, reason):
    reservation.reserve("first")
    reservation.stop("aborted", session)
    assert reservation.stop_reason == reason


def test_a_new_reservation_is_of_no_session_and_in_no_lap():
    new = Reservation()
    assert (new.session, new.order, new.lap, new.stop_reason) == (None, None, None, None)


def test_a_release_by_another_session_leaves_the_reservation(reservation):
    reservation.reserve("first")
    reservation.release("another")
    assert reservation.session == "first"


@pytest.mark.parametrize(("session", "begins"), [("first", True), ("another", False)])
def test_only_an_order_of_the_reserved_session_begins(reservation, session, begins):
    reservation.reserve(session)
    assert reservation.begin(ORDER) is begins


@pytest.mark.parametrize("lifeline", [module.LEASE / 2, 2 * module.LEASE])
def test_it_goes_on_up_to_and_including_the_time_that_is_allowed(reservation, now, lifeline):
    order = DriveOrder("first", 4.0, 0.4, lifeline)
    reservation.reserve("first")
    reservation.begin(order)
    allowed = min(lifeline, module.LEASE)
    now["now"] += allowed
    reservation.require_wanted(order)
    now["now"] += 0.5
    with pytest.raises(StoppedError, match=f"for {allowed:g} s"):
        reservation.require_wanted(order)
