"""Which fault begins and ends when."""

import math
from dataclasses import dataclass
from typing import ClassVar

from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.faults import DeviceFault, FaultSchedule


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
