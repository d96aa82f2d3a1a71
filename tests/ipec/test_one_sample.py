"""The equations in one sample, C (9)-(16) and O (1)-(6), against a motion whose poses are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.ipec.corrections import CLAPPER, OMNIMATE, PLAIN, Settings, State, advance_all, advance_one
from omnimate.vehicle.arcs import advance
from omnimate.vehicle.compiled import record
from omnimate.vehicle.linkage import follower, linkage_of
from omnimate.vehicle.se2 import wrap

SCALE = 1e-10  # [m or rad per count], so small that no reading is rounded
WHEELBASE = np.array([0.3, 0.5])
ZERO = np.array([0, 0, 0, 0, 7, -5, 11])
PRESENT = np.ones(7, bool)
# [m] that a truck moves aside on 11 mm while it seems to turn by 1 mm / 0.3 m; [rad] as a turn of the link.
ACROSS = 2e-5
START = np.array([2.0, -3.0, 0.4])
LAWS = [CLAPPER, OMNIMATE]

joints = st.floats(-1.0, 1.0)
headings = st.floats(-20.0, 20.0)
steps = st.tuples(*[st.floats(-0.02, 0.02)] * 4)


def settings(law, tolerance=(0.0, 0.0)):
    """Return the constants of a robot with unlike trucks and a link of a metre."""
    constants = record(Settings)
    constants["scale"], constants["zero"], constants["length"] = SCALE, ZERO, 1.0
    constants["wheelbase"], constants["law"], constants["tolerance"] = WHEELBASE, law, tolerance
    return constants


def begin(start=START):
    state = record(State)
    state["pose"] = np.nan
    state["pose"][0, 0] = start
    return state


def counts_of(travel, joint_a, joint_b, length):
    """Return the counts `(7,)` after the travel of each wheel [m] and for the readings of the linkage."""
    values = np.array([*travel, wrap(joint_a), wrap(joint_b), length - 1.0])
    return np.rint(values / SCALE).astype(np.int64) + ZERO


def moved(poses, travel):
    """Return the true poses `(2, 3)` after the travel of each wheel [m]."""
    return np.array(
        [
            advance(tuple(pose), *travel[2 * truck : 2 * truck + 2], WHEELBASE[truck])
            for truck, pose in enumerate(poses)
        ]
    )


def drive(law, travel, slip=(0.0,) * 4, tolerance=(0.0, 0.0), start=START, joints=(0.0, 0.0), length=1.0):
    """Return the state after two samples and the true poses.

    Between the samples, each wheel travels [m] on the floor and rolls further by its slip [m].
    """
    constants, state = settings(law, tolerance), begin(start)
    true = np.array([start, follower(start, *joints, length)])
    advance_one(constants, state, counts_of(np.zeros(4), *joints, length), PRESENT)
    true = moved(true, travel)
    advance_one(constants, state, counts_of(np.add(travel, slip), *linkage_of(*true)), PRESENT)
    return state.view(np.recarray)[0], true


@given(headings, joints, joints, st.floats(0.9, 1.1))
def test_the_first_reading_places_truck_b_as_the_linkage_says_and_leaves_truck_a(
    heading, joint_a, joint_b, length
):
    start, state = np.array([2.0, -3.0, heading]), begin()
    state["pose"][0, 0] = start
    advance_one(settings(CLAPPER), state, counts_of(np.full(4, 9.0), joint_a, joint_b, length), PRESENT)
    pose = state["pose"][0]
    assert np.array_equal(pose[0], start)
    assert linkage_of(*pose) == pytest.approx([joint_a, joint_b, length], abs=1e-9)
    assert pose[1, 2] - pose[0, 2] == pytest.approx(joint_b - joint_a, abs=1e-9)


@pytest.mark.parametrize("law", [PLAIN, *LAWS])
@given(steps, headings, joints, joints)
def test_where_wheels_and_linkage_agree_the_poses_are_true_and_nothing_is_corrected(
    law, travel, heading, joint_a, joint_b
):
    state, true = drive(law, travel, start=(2.0, -3.0, heading), joints=(joint_a, joint_b))
    assert state.pose == pytest.approx(true, abs=1e-8)
    assert state.correction == pytest.approx([0.0, 0.0], abs=1e-8)
    assert state.taken_back == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("law", LAWS)
@given(steps, steps, st.tuples(joints, joints))
def test_without_tolerance_the_poses_fulfil_the_readings_of_the_linkage_whatever_slips(
    law, travel, slip, joints
):
    state, true = drive(law, travel, slip, joints=joints)
    assert linkage_of(*state.pose) == pytest.approx(linkage_of(*true), abs=1e-8)


@pytest.mark.parametrize("law", LAWS)
@given(steps, steps, st.tuples(joints, joints))
def test_a_heading_is_corrected_to_the_edge_of_its_tolerance_and_not_further(law, travel, slip, joints):
    """Either the heading was within its tolerance and stays, or it ends at the tolerance, on its side."""
    tolerance = np.array([0.02, 0.03])
    exact, _ = drive(law, travel, slip, joints=joints)
    state, true = drive(law, travel, slip, tolerance, joints=joints)
    left = np.array(linkage_of(*true)[:2]) - linkage_of(*state.pose)[:2]
    assert (np.abs(left) <= tolerance + 1e-8).all()
    corrected = np.abs(state.correction) > 1e-12
    assert np.abs(left[corrected]) == pytest.approx(tolerance[corrected], abs=1e-8)
    assert (left * state.correction >= -1e-8).all()
    first = exact.correction[0]  # that of truck a depends on no other correction
    assert state.correction[0] == pytest.approx(np.sign(first) * max(abs(first) - 0.02, 0.0), abs=1e-8)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("wheel", range(4))
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_travel_that_a_wheel_loses_turns_no_truck(law, wheel, direction):
    """On a straight drive the error lies along the link: the heading is true, and its correction -delta."""
    slip = np.zeros(4)
    slip[wheel] = direction * 0.001
    state, true = drive(law, np.full(4, direction * 0.01), slip)
    truck, side = divmod(wheel, 2)
    delta = (2 * side - 1) * slip[wheel] / WHEELBASE[truck]
    assert state.correction[truck] == pytest.approx(-delta, abs=ACROSS)
    assert state.correction[1 - truck] == pytest.approx(0.0, abs=ACROSS)
    assert state.pose[:, 2] == pytest.approx(true[:, 2], abs=ACROSS)


@pytest.mark.parametrize("wheel", range(2))
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_the_clapper_takes_back_what_a_wheel_of_truck_a_lost(wheel, direction):
    """Half of the wheel's lost travel is the truck's, C (14)-(15): nothing along the path is left, to 1 %."""
    slip = np.zeros(4)
    slip[wheel] = direction * 0.001
    travel = np.full(4, direction * 0.01)
    state, true = drive(CLAPPER, travel, slip)
    assert state.taken_back == pytest.approx(direction * 0.0005, rel=0.01)
    # Across the path stays what the truck has travelled at the wrong heading.
    along = [np.cos(START[2]), np.sin(START[2])]
    assert (state.pose[:, :2] - true[:, :2]) @ along == pytest.approx([0.0, 0.0], abs=ACROSS)
    without, _ = drive(OMNIMATE, travel, slip)
    assert without.taken_back == 0.0
    error = (without.pose[:, :2] - true[:, :2]) @ along
    assert error == pytest.approx([direction * 0.0005] * 2, abs=ACROSS)


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("wheels", [(0.012, -0.004), (-0.004, 0.012)])
def test_travel_is_taken_back_against_the_motion_of_truck_a_along_its_heading(wheels, direction):
    """Also where a wheel or truck b rolls otherwise; the OmniMate corrects the same heading alone."""
    travel = direction * np.array([*wheels, -0.02, -0.02])
    slip = [direction * 0.001, 0.0, 0.0, 0.0]
    state, _ = drive(CLAPPER, travel, slip, joints=(0.1, 0.5))
    without, _ = drive(OMNIMATE, travel, slip, joints=(0.1, 0.5))
    assert state.pose[0, 2] == without.pose[0, 2]
    assert state.taken_back * direction > 0.0
    back = without.pose[0, :2] - state.pose[0, :2]
    heading = state.pose[0, 2]
    assert back == pytest.approx(state.taken_back * np.array([np.cos(heading), np.sin(heading)]), abs=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_what_truck_b_loses_takes_nothing_back(law):
    state, true = drive(law, np.full(4, 0.01), [0.0, 0.0, 0.001, 0.0])
    assert state.taken_back == pytest.approx(0.0, abs=WHEELBASE[0] / 2 * ACROSS)
    assert state.pose[:, :2] == pytest.approx(true[:, :2], abs=ACROSS)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("missing", range(7))
def test_nothing_is_corrected_where_an_encoder_was_not_read(law, missing):
    """Both trucks are then dead-reckoned; one with a missing wheel stays until its wheels are read again."""
    constants, state = settings(law), begin()
    places = np.array([START, follower(START, 0.0, 0.0, 1.0)])
    advance_one(constants, state, counts_of(np.zeros(4), 0.0, 0.0, 1.0), PRESENT)
    slipped = counts_of([0.01, 0.012, 0.01, 0.013], 0.0, 0.0, 1.0)
    advance_one(constants, state, slipped, PRESENT)
    assert state["correction"][0].all()
    before = state["pose"][0].copy()
    advance_one(constants, state, 2 * slipped - ZERO, np.arange(7) != missing)
    assert not state["correction"][0].any()
    assert state["taken_back"][0] == 0.0
    places = moved(before, [0.01, 0.012, 0.01, 0.013])
    if missing < 4:
        places[missing // 2] = before[missing // 2]
    assert state["pose"][0] == pytest.approx(places, abs=1e-8)


@pytest.mark.parametrize("law", LAWS)
def test_truck_b_is_placed_at_the_first_whole_reading_of_the_linkage_and_never_again(law):
    """A later reading corrects its heading within the tolerance; the first one sets it."""
    constants, state = settings(law, (0.5, 0.5)), begin()
    counts = counts_of(np.zeros(4), 0.1, 0.2, 1.0)
    advance_one(constants, state, counts, np.arange(7) != 5)
    assert state["placed"][0] == 0
    assert np.isnan(state["pose"][0, 1]).all()
    advance_one(constants, state, counts, PRESENT)
    assert state["placed"][0] == 1
    placed = state["pose"][0, 1].copy()
    assert placed == pytest.approx(follower(START, 0.1, 0.2, 1.0), abs=1e-9)
    advance_one(constants, state, counts_of(np.zeros(4), 0.1, 0.4, 1.0), PRESENT)
    assert state["pose"][0, 1] == pytest.approx(placed, abs=1e-9)


@pytest.mark.parametrize("law", [PLAIN, *LAWS])
def test_a_recording_has_the_poses_and_corrections_of_its_samples_one_by_one(law):
    chance = np.random.default_rng(4)
    counts = np.array(
        [
            counts_of(travel, *joints, 1.0)
            for travel, joints in zip(
                chance.normal(0.0, 0.01, (20, 4)).cumsum(axis=0),
                chance.normal(0.0, 0.1, (20, 2)),
                strict=True,
            )
        ]
    )
    present = chance.random((20, 7)) < 0.95
    constants, state, at_once = settings(law, (0.01, 0.01)), begin(), begin()
    poses, corrections = np.full((2, 20, 3), np.inf), np.full((20, 3), np.inf)
    advance_all(constants, at_once, counts, present, poses, corrections)
    for row in range(20):
        advance_one(constants, state, counts[row], present[row])
        assert np.array_equal(poses[:, row], state["pose"][0], equal_nan=True)
        assert np.array_equal(corrections[row], [*state["correction"][0], state["taken_back"][0]])
    assert at_once.tobytes() == state.tobytes()
    assert corrections.any() == (law != PLAIN)
