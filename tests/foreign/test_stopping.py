"""Whatever shows that a drive does not do as commanded stops both trucks within 100 ms, and is told."""

from __future__ import annotations

import pytest

from omnimate.driver.errors import DrivesStopped
from omnimate.motion import drive as motion
from omnimate.motion.journal import Journal
from omnimate.motion.paths import out_and_back
from omnimate.motion.runner import Runner
from tests.foreign.devices import FAULT, PRE_OPERATIONAL, STOPPED, SWITCH_ON_DISABLED
from tests.foreign.robots import devices, drive, two_trucks

pytestmark = pytest.mark.usefixtures("family")
SPEED = 4.0  # [rad/s], 0.3 m/s
COUNTS = SPEED / 6.2832 * 40000  # [1/s]
OUT = 17  # the drive that something happens to


CAUSES = {
    "fault without EMCY": (lambda drive: drive.fault(), "reports a fault"),
    "EMCY alone": (lambda drive: drive.emergency(0x5000), "EMCY 5000h: device hardware"),
    "leaves operation enabled": (
        lambda drive: setattr(drive, "status", SWITCH_ON_DISABLED),
        "has left operation enabled",
    ),
    "loses power": (lambda drive: drive.power_off(), "heartbeat lost"),
    "restarts": (lambda drive: drive.reset(), "restarted"),
    "is set pre-operational": (lambda drive: setattr(drive, "state", PRE_OPERATIONAL), "is pre-operational"),
    "is set stopped": (lambda drive: setattr(drive, "state", STOPPED), ""),
}


@pytest.fixture
def driving(enabled):
    """Return what makes a robot that drives straight on, its status words in a TPDO as `devices` says."""
    return lambda status=None, seconds=0.3: enabled(devices(status), seconds)


def until_stopped(driver, bus, at_most=2.0):
    """Drive on until the driver refuses; return its error and when it sent the last stop, from now on [s]."""
    began, first = bus.now, len(bus.sent)
    with pytest.raises(DrivesStopped) as caught:
        drive(driver, at_most)
    zeros = [at for at, can_id, data in bus.sent[first:] if 0x211 <= can_id <= 0x214 and not any(data)]
    return caught.value, zeros[3] - began


@pytest.mark.parametrize("status", [None, "first", "last"])
@pytest.mark.parametrize(("happen", "words"), CAUSES.values(), ids=CAUSES)
def test_both_trucks_are_commanded_to_stop_within_100_ms_and_told_why(driving, status, happen, words):
    driver, bus = driving(status)
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
    ("cause", "status", "emergency"),
    [("leaves operation enabled", SWITCH_ON_DISABLED, None), ("EMCY alone", None, 0x5000)],
)
def test_the_report_has_the_status_word_or_the_emergency_code_of_what_stopped_all(
    driving, cause, status, emergency
):
    driver, bus = driving("first")
    assert driver.report().troubles == ()
    CAUSES[cause][0](bus.nodes[OUT])
    until_stopped(driver, bus)
    trouble = driver.report().troubles[0]
    assert (trouble.status, trouble.emergency) == (status, emergency)


def test_the_robot_of_the_report_turns_by_a_few_degrees_and_not_by_550(driving):
    """A drive without a status word in any TPDO goes to fault: 6041h = 0008h, EMCY 5000h."""
    driver, bus = driving()
    bus.nodes[OUT].fault(0x5000)
    left, right = bus.nodes[1].position, bus.nodes[2].position
    until_stopped(driver, bus)
    bus.sleep(5.0)
    turned = (bus.nodes[2].position - right - bus.nodes[1].position + left) / 40000 * 0.4712 / 0.34
    assert abs(turned) < 0.05


def test_a_wheel_that_is_commanded_and_stands_stops_all_half_a_second_after_its_last_count(driving):
    driver, bus = driving("first")
    bus.nodes[OUT].is_blocked = True
    stopped, after = until_stopped(driver, bus)
    assert 0.5 <= after <= 0.6
    assert "a.left is commanded and stands" in str(stopped)


def test_enable_is_all_that_it_takes_to_go_on_once_the_cause_has_gone(driving):
    driver, bus = driving()
    bus.nodes[OUT].fault(0x5000)
    until_stopped(driver, bus)
    assert bus.nodes[OUT].status == FAULT
    driver.enable()
    before = bus.nodes[1].position
    drive(driver, 1.0)
    assert bus.nodes[1].position - before == pytest.approx(SPEED / 6.2832 * 40000, rel=0.05)


def test_a_robot_without_troubles_is_not_stopped(driving):
    for status in (None, "first", "last"):
        driver, _ = driving(status, seconds=5.0)
        assert driver.drives.troubles == ()
        assert [event.what for event in driver.report().events] == []


def until_standing(begun, phase, period):
    """Return the time from an encoder's last breath to the last of four commands to stand [s]."""
    robot = two_trucks(period)
    driver, bus = begun(robot=robot)
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
def test_both_trucks_stand_within_100_ms_of_the_last_answer_of_an_encoder(begun, phase, period):
    assert until_standing(begun, phase, period) <= 0.1


def test_an_emergency_that_says_that_an_error_has_gone_stops_nothing(driving):
    driver, bus = driving()
    bus.nodes[OUT].emergency(0x0000)
    drive(driver, 0.5)
    assert driver.drives.troubles == ()


def test_a_drive_that_does_not_take_a_short_heartbeat_is_still_watched_by_its_status_word(enabled):
    nodes = devices()
    for node in nodes[-4:]:
        node.protect(0x1017)
    driver, bus = enabled(nodes, seconds=1.0)
    bus.nodes[OUT].power_off()
    stopped, after = until_stopped(driver, bus)
    assert after <= 0.1 + 0.015
    assert "no answer for its status word" in str(stopped)


@pytest.mark.parametrize("status", [None, "first"])
@pytest.mark.parametrize("is_heard", [True, False])
def test_a_host_that_was_busy_for_a_fifth_of_a_second_stops_nothing(driving, status, is_heard):
    """What the nodes sent meanwhile waits in the adapter, or is lost there."""
    driver, bus = driving(status)
    bus.sleep(0.19)
    if not is_heard:
        bus.forget()
    drive(driver, 0.5)
    assert driver.drives.troubles == ()


@pytest.mark.parametrize("length", [0, 1])
def test_a_drive_whose_tpdo_is_too_short_for_its_status_word_is_asked_for_it_by_sdo(driving, length):
    driver, bus = driving("first")
    device = bus.nodes[OUT]
    send, tpdo = device.send, 0x180 + OUT
    device.send = lambda can_id, data: send(can_id, data[:length] if can_id == tpdo else data)
    device.fault()
    with pytest.raises(DrivesStopped, match="the drive reports a fault"):
        drive(driver, 0.1)
    assert driver.report().node(OUT).wrong_length == 1
