"""A log written by columns is, byte for byte, the log written line by line."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from omnimate.files.logs.formats.candump_lines import format_lines
from omnimate.files.logs.formats.candump_text import BLOCK_FRAMES, candump_text
from omnimate.files.logs.frames import ERROR, EXTENDED, RECEIVED, REMOTE, SENT, Frame, frames_of

kinds = st.sampled_from([0, 0, EXTENDED, REMOTE, EXTENDED | REMOTE, ERROR])
times = st.one_of(st.floats(0, 4e9), st.integers(0, 4 * 10**15).map(lambda micros: micros / 1e6))


@st.composite
def frames(draw):
    kind = draw(kinds)
    can_id = draw(st.integers(0, 0x1FFFFFFF if kind & (EXTENDED | ERROR) else 0x7FF))
    data = b"" if kind & REMOTE else draw(st.binary(max_size=8))
    length = draw(st.integers(0, 8)) if kind & REMOTE else len(data)
    flags = kind | draw(st.sampled_from([0, SENT, RECEIVED]))
    return Frame(draw(times), can_id, data, flags, length, draw(st.sampled_from(["can0", "v(#[1]"])))


rows = st.lists(frames(), min_size=1, max_size=40)


@given(rows=rows, form=st.sampled_from(["log", "ta"]), stamp_width=st.sampled_from([8, 10, 17, 20]))
@example(rows=[Frame(0.0000005, 1), Frame(1.0000015, 1)], form="log", stamp_width=17)  # between two
def test_columns_give_the_bytes_of_lines(rows, form, stamp_width):
    log = frames_of(rows)
    lines = "".join(f"{line}\n" for line in format_lines(log, form, stamp_width))
    assert b"".join(candump_text(log, form, stamp_width)) == lines.encode()


@pytest.mark.parametrize("first_extended", [0, 5, BLOCK_FRAMES - 1, BLOCK_FRAMES, BLOCK_FRAMES + 1])
def test_identifiers_are_right_aligned_from_the_first_29_bit_one_on_over_blocks(first_extended):
    count = BLOCK_FRAMES + 20
    flags = np.zeros(count, np.uint8)
    flags[first_extended] = EXTENDED
    log = frames_of(
        Frame(number / 1e3, number % 0x700, bytes(2), int(flags[number])) for number in range(count)
    )
    lines = "".join(f"{line}\n" for line in format_lines(log, "ta"))
    assert b"".join(candump_text(log, "ta")) == lines.encode()
