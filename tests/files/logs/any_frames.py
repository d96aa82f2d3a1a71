"""Frames of every kind, for tests of laws that hold for all of them, and logs of them."""

from hypothesis import strategies as st

from omnimate.files.logs.formats.candump_lines import FD_LENGTHS
from omnimate.files.logs.frames import BRS, ERROR, ESI, EXTENDED, FD, REMOTE, SENT, Frame
from omnimate.files.logs.writing import open_writer

CLASSICAL = [0, EXTENDED, REMOTE, EXTENDED | REMOTE, ERROR]
KINDS = [*CLASSICAL, FD, FD | EXTENDED]
TIMES = st.integers(10**15, 2 * 10**15).map(lambda micros: micros / 1e6)
ANY_TIMES = st.integers(0, 4 * 10**15).map(lambda micros: micros / 1e6)


@st.composite
def any_frames(
    draw, kinds=KINDS, channels=("can0", "can1"), directions=(0, SENT), error_directions=(0,), times=TIMES
):
    """A frame of any kind, CAN FD with BRS and ESI included, at a whole microsecond of these years."""
    kind = draw(st.sampled_from(kinds))
    can_id = draw(st.integers(0, 0x1FFFFFFF if kind & (EXTENDED | ERROR) else 0x7FF))
    if kind & FD:
        size = draw(st.sampled_from(FD_LENGTHS))
        data = draw(st.binary(min_size=size, max_size=size))
        kind |= draw(st.sampled_from([0, BRS, ESI, BRS | ESI]))
    else:
        data = b"" if kind & REMOTE else draw(st.binary(max_size=8))
    length = draw(st.integers(0, 8)) if kind & REMOTE else len(data)
    direction = draw(st.sampled_from(error_directions if kind & ERROR else directions))
    return Frame(draw(times), can_id, data, kind | direction, length, draw(st.sampled_from(channels)))


def logs(**options):
    """Logs of such frames in order of time."""
    return st.lists(any_frames(**options), min_size=1, max_size=30).map(
        lambda rows: sorted(rows, key=lambda row: row.time)
    )


def write_log(rows, path, suffix):
    """Write frames as a log of a format; return the reasons of those that it refused."""
    writer = open_writer(path, suffix)
    refused = [writer.write_frame(row) for row in rows]
    writer.close()
    return [reason for reason in refused if reason]
