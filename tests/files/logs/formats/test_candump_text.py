"""A log written by columns is, byte for byte, the log written line by line."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from omnimate.files.logs.formats.candump_lines import format_lines
from omnimate.files.logs.formats.candump_text import BLOCK_FRAMES, candump_text
from omnimate.files.logs.frames import EXTENDED, RECEIVED, SENT, Frame, frames_of
from tests.files.logs.any_frames import ANY_TIMES, CLASSICAL, any_frames

DIRECTIONS = (0, SENT, RECEIVED)
frames = any_frames(CLASSICAL, ("can0", "v(#[1]"), DIRECTIONS, DIRECTIONS, st.floats(0, 4e9) | ANY_TIMES)
rows = st.lists(frames, min_size=1, max_size=40)


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
