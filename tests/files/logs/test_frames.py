"""Frames as arrays: what goes in comes out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.frames import (
    EXTENDED,
    NANOSECOND,
    REMOTE,
    Frame,
    Frames,
    concatenate,
    frames_of,
    nanoseconds,
)

classical = st.builds(
    Frame,
    time=st.floats(0, 4e9),
    can_id=st.integers(0, 0x7FF),
    data=st.binary(max_size=8),
    flags=st.just(0),
    length=st.none(),
    channel=st.sampled_from(["can0", "can1", "vcan7"]),
)


def completed(frame):
    """The same frame with its length said."""
    return frame._replace(length=len(frame.data) if frame.length is None else frame.length)


@given(st.lists(classical, max_size=20))
def test_frames_go_into_arrays_and_come_out_again(rows):
    assert list(frames_of(rows)) == [completed(row) for row in rows]


@given(st.lists(st.lists(classical, max_size=5), max_size=4))
def test_concatenation_matches_interfaces_by_their_names(parts):
    joined = concatenate([frames_of(part) for part in parts])
    assert list(joined) == [completed(row) for part in parts for row in part]


def test_a_remote_frame_has_a_length_and_no_data():
    (frame,) = frames_of([Frame(1.0, 0x701, b"", REMOTE, 1)])
    assert (frame.length, frame.data) == (1, b"")


def test_words_are_little_endian_as_cia_301_packs():
    assert frames_of([Frame(0.0, 1, b"\x01\x02")]).words().tolist() == [0x0201]


def test_arrays_are_frozen_and_of_one_length():
    frames = frames_of([Frame(1.0, 1, b"", EXTENDED)])
    with pytest.raises(ValueError, match="read-only"):
        frames.time[0] = 2.0
    with pytest.raises(ValueError, match="do not belong"):
        Frames(np.zeros(2), frames.can_id, frames.length, frames.data, frames.flags, frames.channel)


@given(st.floats(1e8, 4.2e9))
def test_nanoseconds_of_these_years_are_the_same_time_again(time):
    assert nanoseconds(time) / NANOSECOND == time


@given(st.integers(0, 4 * 10**15))
def test_what_a_log_with_microseconds_says_ends_in_three_zeros(micros):
    assert nanoseconds(float(f"{micros // 10**6}.{micros % 10**6:06d}")) == 1000 * micros
