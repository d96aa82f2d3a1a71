"""Every received frame goes to exactly one place: a sample, a node's service, or the unknown frames."""

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.monitor import Monitor
from omnimate.driver.robot.status_words import StatusSource


@pytest.fixture
def monitor(kit):
    return Monitor(kit.one_truck(), kit.FakeClock())


def unknown_count(monitor):
    return sum(monitor.unknown.kinds.values())


@pytest.mark.parametrize(
    ("can_id", "data", "counter"),
    [(0x701, b"\x05", "heartbeats"), (0x081, bytes(8), "emergencies"), (0x701, b"\0", "boots")],
)
def test_a_service_of_a_node_goes_to_the_supervision(kit, monitor, can_id, data, counter):
    monitor.take(kit.frame(can_id, data), 0.0)
    assert getattr(monitor.supervision.nodes[1], counter) == 1
    assert unknown_count(monitor) == 0


def test_an_sdo_answer_goes_to_the_client(kit, monitor):
    answers = []
    monitor.on_sdo = lambda can_id, data, _now: answers.append((can_id, bytes(data)))
    monitor.take(kit.frame(0x581, bytes(8)), 0.0)
    assert answers == [(0x581, bytes(8))]


def test_a_pdo_enters_the_open_sample(kit, monitor):
    monitor.assembler.begin(0, 0.0)
    monitor.take(kit.frame(0x181, b"\x07\0\0\0"), 0.0)
    assert monitor.assembler.close().present == (True, False)


@pytest.mark.parametrize(
    ("comes_late", "words"),
    [(False, "has never answered SYNC: check it"), (True, "answers SYNC too late for every sample")],
)
def test_a_node_of_which_no_answer_entered_a_sample_is_reported_by_its_cause(kit, monitor, comes_late, words):
    for number in range(3):
        monitor.assembler.begin(number, 0.015 * number)
        monitor.assembler.close()
        if comes_late:
            monitor.take(kit.frame(0x181, b"\x07\0\0\0"), 0.015 * number)
    assert monitor.assembler.never_answered(1)
    monitor.report_unanswered(1, "check it")
    assert words in monitor.supervision.troubles[-1].what


@pytest.mark.parametrize("can_id", [0x181, 0x701, 0x081, 0x581])
def test_a_service_of_impossible_length_is_counted_for_its_node(kit, monitor, can_id):
    monitor.assembler.begin(0, 0.0)
    monitor.take(kit.frame(can_id, b""), 0.0)
    assert monitor.counts[1].wrong_length == 1
    assert unknown_count(monitor) == 0


def test_what_another_master_may_send_is_not_unknown(kit, monitor):
    monitor.others = {0x601}.__contains__
    monitor.take(kit.frame(0x601, bytes(8)), 0.0)
    monitor.take(kit.frame(0x602, bytes(8)), 0.0)
    assert set(monitor.unknown.kinds) == {"602h"}


def test_a_drive_that_floods_the_bus_with_its_status_word_is_reported(kit):
    drives = (kit.drive("a.left", 17), kit.drive("a.right", 18))
    monitor = Monitor(kit.one_truck(drives=drives), kit.FakeClock())
    monitor.status_words.expect(StatusSource(17, ((0x191, 0),), is_timely=True))
    for number in range(100):
        monitor.synced(0.01 * number)
        for _ in range(10):
            monitor.take(kit.frame(0x191, b"\x37\x02"), 0.01 * number)
    assert [(event.node, event.what) for event in monitor.events.all()] == [
        (17, "babbles: floods the bus with frames 191h")
    ]


messages = st.builds(
    lambda can_id, data, kind: can.Message(
        arbitration_id=can_id,
        data=b"" if kind == "remote" else data,
        is_extended_id=kind == "extended",
        is_remote_frame=kind == "remote",
        is_error_frame=kind == "error",
    ),
    st.one_of(st.sampled_from([0x080, 0x081, 0x181, 0x182, 0x581, 0x701]), st.integers(0, 0x7FF)),
    st.binary(max_size=8),
    st.sampled_from(["data", "data", "data", "extended", "remote", "error"]),
)


@given(st.lists(messages, max_size=100))
def test_each_frame_is_counted_in_one_place_whatever_comes(kit, arriving):
    monitor, sdo_answers = Monitor(kit.one_truck(), kit.FakeClock()), []
    monitor.on_sdo = lambda *_answer: sdo_answers.append(1)
    monitor.assembler.begin(0, 0.0)
    for message in arriving:
        monitor.take(message, 0.0)
    monitor.assembler.close()
    nodes = monitor.supervision.nodes.values()
    services = sum(node.heartbeats + node.emergencies for node in nodes) + len(sdo_answers)
    counts = monitor.counts.values()
    pdos = sum(node.received + node.duplicate + node.late + node.wrong_length for node in counts)
    assert services + pdos + unknown_count(monitor) == len(arriving)


def test_after_the_ranges_are_known_the_counters_begin_again(kit, monitor):
    monitor.take(kit.frame(0x381), 0.0)
    assert monitor.counts[1].unknown == 1
    monitor.begin(kit.one_truck())
    assert monitor.counts[1].unknown == 0
