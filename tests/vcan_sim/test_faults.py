"""Device faults: what each does to the bus, when it begins and ends, and how it is written."""

import math
from contextlib import suppress
from dataclasses import dataclass, fields
from typing import ClassVar

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.errors import FaultError
from omnimate.vcan_sim.faults import (
    FAULTS,
    Babbling,
    ClockJitter,
    DeviceFault,
    EmergencyMessage,
    FaultSchedule,
    FrozenCounter,
    Reboot,
    Silence,
    WrongLength,
    parse_fault,
)


def count_up(bench, syncs, node=1):
    """Count by one per SYNC on all channels; return the data of the node's PDOs after each SYNC."""
    answers = []
    for _ in range(syncs):
        bench.plant.counts = tuple(count + 1 for count in bench.plant.counts)
        bench.sync()
        answers.append(bench.pdos(0x180 + node))
    return answers


def values(answers):
    return [[int.from_bytes(data, "little") for data in sent] for sent in answers]


@pytest.mark.parametrize(
    ("kind", "answers"),
    [(Silence, [[1], [2], [], [], [5], [6]]), (FrozenCounter, [[1], [2], [2], [2], [5], [6]])],
    ids=["silence", "a frozen counter, which repeats its last value"],
)
def test_a_fault_begins_and_ends_at_its_times_of_the_devices_clock(make_bench, kind, answers):
    bench = make_bench(faults=[kind(node=1, at=0.045, duration=0.030)])
    bench.answer_sync(1)
    assert values(count_up(bench, 6)) == answers


def test_a_silent_node_answers_no_sdo_and_has_no_heartbeat(bench):
    bench.write(1, 0x1017, 0, 15, 2)
    bench.simulated.inject(Silence(node=1))
    bench.sync(5)
    assert bench.request(1, b"\x40\x00\x10\x00" + bytes(4)) is None
    assert bench.take() == []


def test_a_reboot_forgets_everything_and_counts_wheels_from_0(make_bench):
    bench = make_bench(faults=[Reboot(node=1, at=0.045, duration=0.030)])
    bench.write(1, 0x1017, 0, 1000, 2)
    bench.answer_sync(1)
    assert values(count_up(bench, 2)) == [[1], [2]]
    bench.sync(2)
    assert bench.take() == []
    assert bench.request(1, b"\x40\x00\x10\x00" + bytes(4)) is None
    bench.sync()
    assert bench.take() == [(0x701, b"\0")]
    assert bench.read(1, 0x1017) == 0
    bench.sync(5)
    assert bench.take() == []  # pre-operational until it is started
    bench.answer_sync(1)
    assert values(count_up(bench, 2)) == [[1], [2]]


def test_a_reboot_of_a_drive_stops_its_wheel(bench):
    drive = bench.simulated.devices[11]
    drive.velocity = drive._target = 1000.0
    bench.simulated.inject(Reboot(node=11))
    bench.sync(2)
    assert bench.plant.speeds[0] == 0.0


def test_an_emergency_is_reported_and_taken_back(make_bench):
    bench = make_bench(faults=[EmergencyMessage(node=2, at=0.015, duration=0.030, code=0x5000)])
    bench.sync()
    assert bench.take() == [(0x082, b"\x00\x50\x01" + bytes(5))]
    assert bench.read(2, 0x1001) == 1
    bench.sync(2)
    assert bench.take() == [(0x082, bytes(8))]
    assert bench.read(2, 0x1003, 1) == 0x5000


def test_babbling_floods_the_bus_with_the_nodes_own_pdo(bench):
    bench.answer_sync(1)
    count_up(bench, 1)
    bench.simulated.inject(Babbling(node=1, frames=5, duration=0.015))
    assert values(count_up(bench, 2)) == [[2, 2, 2, 2, 2, 2], [3]]


def test_babbling_floods_the_bus_with_a_foreign_cob_id(bench):
    bench.simulated.inject(Babbling(node=1, frames=3, cob_id=0x182, data="0102"))
    bench.sync()
    assert bench.take() == [(0x182, b"\x01\x02")] * 3


def test_jitter_sends_some_answers_after_the_next_sync_and_before_the_next_answer(bench):
    bench.answer_sync(1)
    bench.simulated.inject(ClockJitter(node=1, late_every=2))
    assert values(count_up(bench, 6)) == [[1], [], [2, 3], [], [4, 5], []]


def test_faults_of_one_node_leave_the_others_alone(bench):
    bench.answer_sync(2)
    bench.simulated.inject(Silence(node=1))
    bench.simulated.inject(FrozenCounter(node=1))
    assert values(count_up(bench, 2, node=2)) == [[1], [2]]


def test_faults_of_one_node_add_up_and_end_one_by_one(make_bench):
    faults = [FrozenCounter(node=1, at=0.030, duration=0.060), WrongLength(node=1, at=0.045, duration=0.015)]
    bench = make_bench(faults=faults)
    bench.answer_sync(1)
    assert [sent[0][:2] for sent in count_up(bench, 6)] == [bytes([n, 0]) for n in (1, 1, 1, 1, 1, 6)]


def test_a_fault_of_a_node_that_is_not_there_is_refused(make_bench):
    with pytest.raises(FaultError, match=r"silence:node=9.*: no node 9 on this bus; expected one of 1, 2"):
        make_bench(faults=[Silence(node=9)])
    with pytest.raises(FaultError, match="no node 9"):
        make_bench().simulated.inject(Silence(node=9))


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("reboot:node=2,at=30", Reboot(node=2, at=30.0)),
        ("silence:node=1,at=1.5,duration=2", Silence(node=1, at=1.5, duration=2.0)),
        ("emcy:node=3,code=0x8110", EmergencyMessage(node=3, code=0x8110)),
        ("length:node=4,length=2", WrongLength(node=4, length=2)),
        ("frozen:node=5", FrozenCounter(node=5)),
        ("babbling:node=6,cob_id=0x80,data=0011", Babbling(node=6, cob_id=0x80, data="0011")),
        ("jitter:node=7,late_by=0.02,late_every=1", ClockJitter(node=7, late_by=0.02, late_every=1)),
    ],
)
def test_a_fault_is_written_as_its_name_and_its_values(text, fault):
    assert parse_fault(text) == fault


@given(st.text(max_size=40))
def test_no_text_makes_the_parser_fail_otherwise_than_by_its_own_error(text):
    for kind in FAULTS:
        for attempt in (text, f"{kind.name}:{text}", f"{kind.name}:node={text}"):
            with suppress(FaultError):
                parse_fault(attempt)


def test_every_fault_has_a_name_of_its_own_and_needs_no_more_than_a_node():
    assert len({kind.name for kind in FAULTS}) == len(FAULTS)
    for kind in FAULTS:
        assert {"node", "at", "duration"} <= {field.name for field in fields(kind)}
        assert parse_fault(f"{kind.name}:node=1") == kind(node=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Noted(DeviceFault):
    """A fault that notes when it begins and ends."""

    name: ClassVar[str] = "noted"
    label: str = ""

    def begin(self, device, now):
        device.append(("begin", self.label, now))

    def end(self, device, now):
        device.append(("end", self.label, now))


def run(faults, times):
    device = []
    schedule = FaultSchedule({1: device}, faults)
    for now in times:
        schedule.run(now)
    return device, schedule


@given(st.floats(0.0, 20.0), st.floats(0.001, 20.0), st.floats(0.05, 5.0))
def test_a_fault_begins_at_its_time_and_ends_after_its_duration(at, duration, step):
    times = [step * number for number in range(int((at + duration) / step) + 3)]
    ((first, _, begins), (last, _, ends)), schedule = run([Noted(node=1, at=at, duration=duration)], times)
    assert (first, last) == ("begin", "end")
    assert at <= begins < at + step + 1e-9
    assert begins + duration <= ends < begins + duration + step + 1e-9
    assert schedule.due == math.inf


def test_faults_of_the_same_instant_keep_the_order_in_which_they_were_given():
    labels = ["c", "a", "b"]
    noted, _ = run([Noted(node=1, at=2.0, label=label) for label in labels], [1.0, 2.0])
    assert noted == [("begin", label, 2.0) for label in labels]


def test_the_next_event_is_due():
    _, schedule = run([Noted(node=1, at=3.0, duration=4.0), Noted(node=1, at=5.0)], [])
    dues = []
    for now in (3.0, 5.0):
        dues.append(schedule.due)
        schedule.run(now)
    assert [*dues, schedule.due] == [3.0, 5.0, 7.0]


def test_a_fault_that_begins_now_ends_after_its_duration_whatever_its_time():
    device = []
    schedule = FaultSchedule({1: device}, ())
    schedule.begin(Noted(node=1, at=99.0, duration=2.0), 10.0)
    schedule.run(12.0)
    assert device == [("begin", "", 10.0), ("end", "", 12.0)]


def test_a_fault_without_duration_does_not_end():
    noted, schedule = run([Noted(node=1, at=1.0)], [0.5, 1.5, 1e9])
    assert noted == [("begin", "", 1.5)]
    assert schedule.due == math.inf
