"""Nanoseconds: no time is changed by being written as whole nanoseconds."""

from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.frames import NANOSECOND, nanoseconds


@given(st.floats(1e8, 4.2e9))
def test_nanoseconds_of_these_years_are_the_same_time_again(time):
    assert nanoseconds(time) / NANOSECOND == time


@given(st.integers(0, 4 * 10**15))
def test_what_a_log_with_microseconds_says_ends_in_three_zeros(micros):
    assert nanoseconds(float(f"{micros // 10**6}.{micros % 10**6:06d}")) == 1000 * micros
