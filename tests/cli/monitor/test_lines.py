"""The lines of the monitor: all that matters within 80 columns, and readable without colours."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.cli.descriptions import descriptions
from omnimate.cli.monitor.lines import (
    Wanted,
    event_lines,
    head_line,
    node_line,
    robot_lines,
    table_lines,
)
from omnimate.driver.robot.events import Event
from tests.cli.monitor.conftest import ROWS

DECODER = descriptions(None, (), ()).decoder({})


def table(width=80, rows=ROWS, **options):
    return [line.plain for line in table_lines(rows, DECODER, width, **options)]


def test_the_head_says_rate_load_and_what_is_wrong(snapshot):
    text = head_line(snapshot, "can0", 500_000).plain
    assert text == "1000 frames/s  load 22-26 %  1006 frames  2:05  2 left out  RECORDING recording-1  can0"
    assert "110-130 kbit/s" in head_line(snapshot, "can0", None).plain
    assert "BUS LOST" in head_line(replace(snapshot, lost="unplugged"), "can0", None).plain
    assert "the log has ended" in head_line(replace(snapshot, has_ended=True), "x", None).plain


def test_a_row_has_rate_jitter_data_and_meaning():
    _, sync, pdo, heartbeat, remote, fd, error = table(200)
    assert sync.split() == ["080", "66.7", "0.01", "SYNC"]
    assert pdo.split() == ["181", "66.7", "0.10", "10", "27", "00", "00", "TPDO1", "of", "node", "1"]
    assert heartbeat.split()[:4] == ["705", "3.0", "s", "ago"]
    assert "18FF0001" in remote
    assert "remote, 4 bytes" in remote
    assert "+5" in fd
    assert "CAN FD, 12 bytes" in fd
    assert error.split()[0] == "error"


def test_columns_stand_below_their_heads_for_every_kind_of_row():
    lines = table(200)
    place = lines[0].index("meaning")
    assert {line[place - 1] for line in lines} == {" "}
    assert [line[place:].split()[0] for line in lines[1:4]] == ["SYNC", "TPDO1", "heartbeat"]


def test_what_changed_is_bold_and_without_colours_has_a_star():
    assert "*10 27 00*00" in table(marks=True)[2]
    assert "*" not in table()[2]
    line = list(table_lines(ROWS, DECODER, 80))[2]
    assert [line.plain[span.start : span.end] for span in line.spans] == ["10", "00"]


def test_interfaces_are_shown_where_there_are_several():
    other = ROWS[0]._replace(frame=ROWS[0].frame._replace(channel="vcan1"))
    assert table(rows=[ROWS[0], other])[2].startswith("vcan1      080")


@given(st.integers(20, 200))
def test_no_line_is_wider_than_the_terminal(width):
    assert all(len(line) <= width for line in table(width))


def test_nodes_robot_and_events_are_in_words(snapshot):
    assert node_line(snapshot, 80).plain == "nodes: heartbeat lost 5, pre-operational 6"
    alive = replace(snapshot, rows=(ROWS[2]._replace(rate=2.0),))
    assert node_line(alive, 80).plain == "nodes: operational 5, pre-operational 6"
    assert "none has said" in node_line(replace(snapshot, nodes={}), 80).plain
    wheels, joints, poses = (line.plain for line in robot_lines(snapshot.robot, 120))
    assert wheels == "wheels [m/s]: a.left +0.200  a.right -0.210  b.left ?  b.right +0.200"
    assert joints == "joint_a +5.73 degrees  joint_b -11.46 degrees  link 1000.0 mm"
    assert poses.startswith("a: x 1.250 m  y -0.500 m  5.7 degrees  b: x 0.250 m")
    assert poses.endswith("missing: b.left")
    state, error = (line.plain for line in event_lines(snapshot, 4, 80))
    assert state == " 10.0 s ago  node 5   is operational, was pre-operational"
    assert error == "  1.0 s ago  bus      error frame of the adapter (12 times)"


def test_only_the_newest_events_are_shown(snapshot):
    many = tuple(Event(float(n), float(n), 1, None, f"event {n}") for n in range(10))
    lines = [line.plain for line in event_lines(replace(snapshot, events=many), 2, 80)]
    assert [line.split()[-1] for line in lines] == ["8", "9"]


@pytest.mark.parametrize(
    ("text", "identifiers"),
    [
        ("", [0x080, 0x181, 0x705, 0x18FF0001, 0x1F0, 0x004]),
        ("181", [0x181]),
        ("100-200", [0x181, 0x1F0]),
        ("~080 kind:heartbeat", [0x705]),
        ("node:5", [0x705]),
        ("HEARTbeat", [0x705]),
        ("tpdo node", [0x181]),
        ("nobody", []),
    ],
)
def test_the_filter_takes_identifiers_nodes_kinds_and_words(text, identifiers):
    assert [row.frame.can_id for row in Wanted.of(text).rows(ROWS, DECODER)] == identifiers


@given(st.text(max_size=20))
def test_no_filter_breaks_it(text):
    Wanted.of(text).rows(ROWS, DECODER)
