"""Lines read by machine code, in threads, give the same frames and complaints as lines read one by one."""

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from omnimate.files.logs.formats.candump_blocks import BlockParser, SkippedLine, parse_in_parallel
from omnimate.files.logs.formats.candump_lines import ONLY_CLASSICAL, parse_line
from omnimate.files.logs.frames import FD, frames_of

FIELDS = ("can_id", "length", "data", "flags")

digits = st.text("0123456789", min_size=1, max_size=11)
stamps = st.builds("({}.{})".format, digits, digits)
hexadecimal = st.text("0123456789ABCDEFabcdef", max_size=9)
names = st.sampled_from(["can0", "can1", "vcan0", "a", "a name", "x" * 40, "ü", ""])
tails = st.sampled_from(["", " R", " T", " X", "R", "R8", "#0", " ", "\r", "_9", "  R"])
lines = st.one_of(
    st.builds(
        "{}{}{}{}{}#{}{}".format,
        stamps,
        st.sampled_from([" ", "   ", ""]),
        names,
        st.sampled_from([" ", "  ", ""]),
        st.one_of(hexadecimal, st.sampled_from(["181", "7FF", "800", "1FFFFFFF", "20000000"])),
        st.one_of(hexadecimal, st.sampled_from(["", "00", "0011223344556677", "001122334455667788"])),
        tails,
    ),
    st.builds(
        "({}.{:06d}) can0 {:03X}#{}".format,
        st.integers(0, 10**10 - 1),
        st.integers(0, 999_999),
        st.integers(0, 0x7FF),
        st.binary(max_size=8).map(bytes.hex),
    ),
    st.text(max_size=30).map(lambda text: text.replace("\n", "").replace("\r", "")),
)


def block_of(rows):
    return "".join(f"{row}\n" for row in rows).encode()


def assert_same(one, other):
    names = [[log.channels[number] for number in log.channel] for log in (one, other)]
    assert names[0] == names[1]
    np.testing.assert_array_max_ulp(one.time, other.time, 1)  # of times with more than 15 digits
    for field in FIELDS:
        assert np.array_equal(getattr(one, field), getattr(other, field)), field


@given(st.lists(lines, min_size=1, max_size=20))
@example(["(1.000000) can0 181#" + "0" * 40, ")" * 18 + "."])
@example(["(", "(1", "(1.", "(1.0", "(1.0)", "(1.0) ", "(1.0) can0", "(1.0) can0 1", "(1.0) can0 181#"])
@example([".......... ....... )", "(1234567890.123456) can0 181#00"])
@example(["\x85", "\u2003", "\U0001f916" * 30])  # blank to Python's text, not to bytes; cut in a character
@settings(deadline=None)
def test_a_block_gives_what_it_gives_line_by_line(rows):
    parser = BlockParser()
    found = parser.parse(block_of(rows))
    encoded = [(number, row.encode()) for number, row in enumerate(rows, 1)]
    read = [(number, line, parse_line(line)) for number, line in encoded if line.strip()]
    frames = [frame for _, _, frame in read if not isinstance(frame, str) and not frame.flags & FD]
    assert_same(found, frames_of(frames))
    assert parser.skipped == [
        SkippedLine(
            number,
            line[:80].decode(errors="replace").rstrip(),
            frame if isinstance(frame, str) else ONLY_CLASSICAL,
        )
        for number, line, frame in read
        if isinstance(frame, str) or frame.flags & FD
    ]
    assert parser.lines == len(rows)


@given(st.lists(st.lists(lines, min_size=1, max_size=8), min_size=1, max_size=12), st.integers(1, 4))
@settings(deadline=None, max_examples=40)
def test_threads_give_the_blocks_in_order_with_their_line_numbers(blocks, workers):
    texts = [block_of(rows) for rows in blocks]
    careful, quick = BlockParser(), BlockParser()
    wanted = [careful.parse(text) for text in texts]
    for one, other in zip(parse_in_parallel(texts, quick, workers), wanted, strict=True):
        assert_same(one, other)
    assert sorted(quick.skipped) == sorted(careful.skipped)


def test_what_is_in_flight_does_not_grow_with_the_log():
    """Few blocks are taken before the first ones are handed on."""
    taken = []

    def blocks():
        for number in range(200):
            taken.append(number)
            yield b"(1.000000) can0 181#00\n"

    parsed = parse_in_parallel(blocks(), BlockParser(), 2)
    for done, frames in enumerate(parsed):
        assert len(frames) == 1
        assert len(taken) <= done + 8
