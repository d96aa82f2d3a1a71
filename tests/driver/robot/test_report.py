"""The report of a drive: every counter of every node, clean exactly where nothing happened."""

from dataclasses import fields

import pytest

from omnimate.driver.robot.events import NodeCounts
from omnimate.driver.robot.monitor import Monitor
from omnimate.driver.robot.report import make_report


@pytest.fixture
def vehicle(kit):
    return kit.one_truck(drives=(kit.drive("a.left", 1), kit.drive("a.right", 18)))


@pytest.fixture
def monitor(kit, vehicle):
    return Monitor(vehicle, kit.FakeClock())


def test_before_anything_happens_the_report_is_clean_and_has_every_node(vehicle, monitor):
    report = make_report(vehicle, monitor, 0)
    assert report.is_clean
    assert [node.node for node in report.nodes] == [1, 2, 18]
    assert report.node(1).names == ("a.left", "drive of a.left")
    assert report.node(18).names == ("drive of a.right",)


def test_an_unknown_node_is_a_key_error(vehicle, monitor):
    with pytest.raises(KeyError):
        make_report(vehicle, monitor, 0).node(99)


def test_every_counter_of_a_node_stands_in_its_report(vehicle, monitor):
    for number, field in enumerate(fields(NodeCounts), start=1):
        setattr(monitor.counts[18], field.name, number)
    node = make_report(vehicle, monitor, 0).node(18)
    assert [getattr(node, field.name) for field in fields(NodeCounts)] == list(
        range(1, len(fields(NodeCounts)) + 1)
    )


def an_event(monitor, _kit):
    monitor.events.add(1.0, None, "something")


def a_gap(monitor, kit):
    monitor.assembler.begin(0, 0.0)
    monitor.take(kit.frame(0x181, bytes(4)), 0.0)
    monitor.assembler.close()


def an_unknown_frame(monitor, kit):
    monitor.take(kit.frame(0x3FF), 0.0)


@pytest.mark.parametrize("happen", [an_event, a_gap, an_unknown_frame])
def test_whatever_happens_makes_the_report_unclean(kit, vehicle, monitor, happen):
    happen(monitor, kit)
    assert not make_report(vehicle, monitor, 1).is_clean


def test_a_skipped_period_makes_the_report_unclean(vehicle, monitor):
    assert not make_report(vehicle, monitor, 1, skipped=1).is_clean


@pytest.mark.parametrize(
    ("data", "state", "is_well"),
    [(None, "no heartbeat", False), (b"\x05", "operational", True), (b"\x04", "stopped", False)],
)
def test_an_encoder_is_well_where_its_last_heartbeat_says_operational(
    kit, vehicle, monitor, data, state, is_well
):
    if data is not None:
        monitor.take(kit.frame(0x702, data), 0.0)
    node = make_report(vehicle, monitor, 0).node(2)
    assert (node.state, node.is_well) == (state, is_well)


def test_a_node_whose_heartbeat_is_overdue_is_not_well(kit, vehicle, monitor):
    monitor.supervision.started(2, 0.5)
    monitor.take(kit.frame(0x702, b"\x05"), 0.0)
    monitor.supervision.check(1e6)
    assert not make_report(vehicle, monitor, 0).node(2).is_well


def test_a_drive_that_is_not_started_yet_is_well(kit, vehicle, monitor):
    monitor.take(kit.frame(0x712, b"\x7f"), 0.0)
    assert make_report(vehicle, monitor, 0).node(18).is_well
