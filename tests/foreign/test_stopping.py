"""Whatever shows that a drive does not do as commanded stops both trucks within 100 ms, and is told."""

from __future__ import annotations

import pytest

from omnimate.driver.errors import DrivesStopped
from omnimate.motion import drive as motion
from omnimate.motion.journal import Journal
from omnimate.motion.paths import out_and_back
from omnimate.motion.runner import Runner
from tests.foreign.devices import FAULT, PRE_OPERATIONAL, STOPPED, SWITCH_ON_DISABLED
from tests.foreign.robots import devices as robot_devices
from tests.foreign.robots import drive, two_trucks

pytestmark = pytest.mark.usefixtures("family")
SPEED = 4.0  # [rad/s], 0.3 m/s
COUNTS = SPEED / 6.2832 * 40000  # [1/s]
OUT = 17  # the drive that something happens to


def fault_without_emcy(drive):
    drive.fault()


def emcy_alone(drive):
    drive.emergency(0x5000)


def leaves_operation_enabled(drive):
    drive.status = SWITCH_ON_DISABLED


def loses_power(drive):
    drive.power_off()


def restarts(drive):
    drive.reset()


def is_set_pre_operational(drive):
    drive.state = PRE_OPERATIONAL


def is_set_stopped(drive):
    drive.state = STOPPED


CAUSES = {
    fault_without_emcy: "reports a fault",
    emcy_alone: "EMCY 5000h: device hardware",
    leaves_operation_enabled: "has left operation enabled",
    loses_power: "heartbeat lost",
    restarts: "restarted",
    is_set_pre_operational: "is pre-operational",
    is_set_stopped: "",
}


def driving(bench, driver_on, status=None, seconds=0.3):
    """Return a robot that drives straight on."""
    bus = bench(robot_devices(status))
    driver = driver_on(two_trucks(), bus)
    driver.configure()
    driver.enable()
    drive(driver, seconds)
    return driver, bus


def until_stopped(driver, bus, at_most=2.0):
    """Drive on until the driver refuses; return its error and when it sent the last stop, from now on [s]."""
    began, first = bus.now, len(bus.sent)
    with pytest.raises(DrivesStopped) as caught:
        drive(driver, at_most)
    zeros = [at for at, can_id, data in bus.sent[first:] if 0x211 <= can_id <= 0x214 and not any(data)]
    return caught.value, zeros[3] - began


@pytest.mark.parametrize("status", [None, "first", "last"])
@pytest.mark.parametrize(("happen", "words"), CAUSES.items(), ids=[cause.__name__ for cause in CAUSES])
def test_both_trucks_are_commanded_to_stop_within_100_ms_and_told_why(
    bench, driver_on, status, happen, words
):
    driver, bus = driving(bench, driver_on, status)
    happen(bus.nodes[OUT])
    stopped, after = until_stopped(driver, bus)
    assert after <= 0.1
    assert stopped.troubles[0].node == OUT
    assert words in str(stopped)
    assert "node 17 (drive of a.left)" in str(stopped)
    drives = [bus.nodes[node] for node in (18, 19, 20)]
    bus.sleep(0.2)
    assert [node.velocity for node in drives] == [0.0, 0.0, 0.0]
    assert [node.status for node in drives] == [0x0207] * 3


@pytest.mark.parametrize(
    ("happen", "status", "emergency"),
    [(leaves_operation_enabled, SWITCH_ON_DISABLED, None), (emcy_alone, None, 0x5000)],
)
def test_the_report_has_the_status_word_or_the_emergency_code_of_what_stopped_all(
    bench, driver_on, happen, status, emergency
):
    driver, bus = driving(bench, driver_on, "first")
    assert driver.report().troubles == ()
    happen(bus.nodes[OUT])
    until_stopped(driver, bus)
    trouble = driver.report().troubles[0]
    assert (trouble.status, trouble.emergency) == (status, emergency)


def test_the_robot_of_the_report_turns_by_a_few_degrees_and_not_by_550(bench, driver_on):
    """A drive without a status word in any TPDO goes to fault: 6041h = 0008h, EMCY 5000h."""
    driver, bus = driving(bench, driver_on)
    bus.nodes[OUT].fault(0x5000)
    left, right = bus.nodes[1].position, bus.nodes[2].position
    until_stopped(driver, bus)
    bus.sleep(5.0)
    turned = (bus.nodes[2].position - right - bus.nodes[1].position + left) / 40000 * 0.4712 / 0.34
    assert abs(turned) < 0.05


def test_a_wheel_that_is_commanded_and_stands_stops_all_half_a_second_after_its_last_count(bench, driver_on):
    driver, bus = driving(bench, driver_on, "first")
    bus.nodes[OUT].is_blocked = True
    stopped, after = until_stopped(driver, bus)
    assert 0.5 <= after <= 0.6
    assert "a.left is commanded and stands" in str(stopped)


def test_enable_is_all_that_it_takes_to_go_on_once_the_cause_has_gone(bench, driver_on):
    driver, bus = driving(bench, driver_on)
    bus.nodes[OUT].fault(0x5000)
    until_stopped(driver, bus)
    assert bus.nodes[OUT].status == FAULT
    driver.enable()
    before = bus.nodes[1].position
    drive(driver, 1.0)
    assert bus.nodes[1].position - before == pytest.approx(SPEED / 6.2832 * 40000, rel=0.05)


def test_a_robot_without_troubles_is_not_stopped(bench, driver_on):
    for status in (None, "first", "last"):
        driver, _ = driving(bench, driver_on, status, seconds=5.0)
        assert driver.drives.troubles == ()
        assert [event.what for event in driver.report().events] == []


def until_standing(bench, driver_on, phase, period):
    """Return the time from an encoder's last breath to the last of four commands to stand [s]."""
    bus, robot = bench(robot_devices()), two_trucks(period)
    driver = driver_on(robot, bus)
    driver.configure()
    driver.enable()
    program = out_and_back(20.0, 1, speed=0.3, link_length=robot.linkage.length)
    moments = motion.drive(driver, Runner(program, robot), robot, Journal(program))
    while bus.nodes[OUT].velocity < 0.5 * COUNTS:
        next(moments)
    began = bus.at(phase, bus.nodes[1].power_off)
    first = len(bus.sent)
    while bus.now < began + 0.5:
        next(moments)
    zeros = [
        at
        for at, can_id, data in bus.sent[first:]
        if 0x211 <= can_id <= 0x214 and at >= began and not any(data)
    ]
    return zeros[3] - began


@pytest.mark.parametrize("phase", [0.0, 0.001, 0.008])
@pytest.mark.parametrize("period", [0.01, 0.015, 0.02, 0.05])
def test_both_trucks_stand_within_100_ms_of_the_last_answer_of_an_encoder(bench, driver_on, phase, period):
    assert until_standing(bench, driver_on, phase, period) <= 0.1


def test_an_emergency_that_says_that_an_error_has_gone_stops_nothing(bench, driver_on):
    driver, bus = driving(bench, driver_on)
    bus.nodes[OUT].emergency(0x0000)
    drive(driver, 0.5)
    assert driver.drives.troubles == ()


def test_a_drive_that_does_not_take_a_short_heartbeat_is_still_watched_by_its_status_word(bench, driver_on):
    bus = bench(robot_devices())
    for node in range(17, 21):
        bus.nodes[node].protect(0x1017)
    driver = driver_on(two_trucks(), bus)
    driver.configure()
    driver.enable()
    drive(driver, 1.0)
    bus.nodes[OUT].power_off()
    stopped, after = until_stopped(driver, bus)
    assert after <= 0.1 + 0.015
    assert "no answer for its status word" in str(stopped)


@pytest.mark.parametrize("status", [None, "first"])
@pytest.mark.parametrize("is_heard", [True, False])
def test_a_host_that_was_busy_for_a_fifth_of_a_second_stops_nothing(bench, driver_on, status, is_heard):
    """What the nodes sent meanwhile waits in the adapter, or is lost there."""
    driver, bus = driving(bench, driver_on, status)
    bus.sleep(0.19)
    if not is_heard:
        bus.forget()
    drive(driver, 0.5)
    assert driver.drives.troubles == ()
