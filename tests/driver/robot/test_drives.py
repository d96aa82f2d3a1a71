import math

import pytest

from omnimate.driver.errors import BadCommand, DriveError, DrivesStopped, NodeMissing, NotEnabled
from omnimate.driver.robot import driver as module
from omnimate.driver.robot.driver import Driver
from omnimate.driver.robot.drives import MAX_TROUBLES, target_velocity
from omnimate.driver.robot.events import Trouble
from tests.driver.conftest import words

COUNTS = 40000 / (2 * math.pi)
HEARTBEAT = (0x77F, b"\x05")
QUICK_STOP = (0x6040, 0, 0x02)
EMERGENCY = b"\x10\x81\x11\0\0\0\0\0"


@pytest.fixture
def robot(kit):
    """A truck of which the right drive is mounted the other way round."""
    return kit.configured(kit.drive("a.left", 17), kit.drive("a.right", 18, sign=-1))


@pytest.fixture
def enabled(robot):
    robot[0].enable()
    return robot


def sends_at_writes(bus, node, indices, frame):
    """Let a frame come whenever certain objects of a device are written."""
    on_write = bus.devices[node].on_write

    def write(index, sub, value):
        if index in indices:
            bus.queue.append(frame)
        on_write(index, sub, value)

    bus.devices[node].on_write = write


def targets(bus, cob_id):
    return [int.from_bytes(data, "little", signed=True) for can_id, data in bus.sent if can_id == cob_id]


def test_nothing_is_commanded_before_enable(robot):
    driver, bus = robot
    with pytest.raises(NotEnabled, match="has not been called"):
        driver.command((1.0, 1.0))
    for _ in range(20):
        driver.cycle()
    assert targets(bus, 0x211) == []
    assert HEARTBEAT not in bus.sent
    assert driver.drives.speeds == (0.0, 0.0)


def test_drives_that_were_never_enabled_are_left_alone(robot):
    driver, bus = robot
    driver.close()
    assert bus.devices[17].writes == []


def test_enable_goes_through_the_states_in_order_at_speed_zero(robot):
    driver, bus = robot
    report = driver.enable()
    device = bus.devices[17]
    steps = [(index, value) for index, _, value in device.writes if index in {0x6040, 0x6060, 0x60FF}]
    assert steps == [(0x60FF, 0), (0x6060, 3), (0x6040, 0x06), (0x6040, 0x07), (0x6040, 0x0F)]
    assert device.state == 5
    assert device.number(0x1600, 1) == 0x60FF0020
    assert device.number(0x1400, 2) == 255
    assert device.number(0x1016, 1) == 127 << 16 | 500
    assert device.number(0x6007) == 3
    assert [node.names for node in report] == [("drive of a.left",), ("drive of a.right",)]
    assert (0x000, b"\x80\x11") in bus.sent, "its mapping changes in pre-operational only"
    assert targets(bus, 0x211) == targets(bus, 0x212) == [0]
    assert not [what for _, what in words(driver) if "answers for 6041h after" in what]


def test_our_heartbeat_begins_before_any_drive_is_configured_and_goes_on_with_each(robot):
    driver, bus = robot
    bus.sent.clear()
    driver.enable()
    assert bus.sent.index(HEARTBEAT) < bus.sent.index((0x000, b"\x80\x11"))
    assert bus.sent.count(HEARTBEAT) == 3


def test_our_heartbeat_has_the_highest_id_that_no_node_has(kit):
    driver, bus = kit.configured(kit.drive("a.left", 127), kit.drive("a.right", 18))
    driver.enable()
    assert (0x77E, b"\x05") in bus.sent


def test_a_control_word_in_the_pdo_gives_torque_only_while_the_drives_are_enabled(kit):
    left, right = kit.drive("a.left", 17, start_bit=16), kit.drive("a.right", 18, start_bit=16)
    driver, bus = kit.configured(left, right)
    driver.enable()
    driver.command((1.0, 1.0))
    controls = [data[0] for can_id, data in bus.sent if can_id == 0x211]
    assert controls == [0x0F] * len(controls)
    driver.drives.halt(Trouble(0.0, 17, "a trouble"))
    assert [data for can_id, data in bus.sent if can_id == 0x212][-1] == b"\x02" + bytes(5)
    driver.enable()
    driver.drives.disable()
    driver.cycle()
    assert [data for can_id, data in bus.sent if can_id == 0x211][-1] == b"\x06" + bytes(5)


def test_an_error_that_an_enabled_drive_still_has_is_logged(robot):
    driver, bus = robot
    bus.devices[18].put(0x1001, 0, 0x10)
    driver.enable()
    found = [(node, what) for node, what in words(driver) if "1001h = 10h" in what]
    assert [node for node, _ in found] == [18]


def test_how_long_a_drive_takes_to_answer_for_its_status_word_is_measured(robot):
    driver, bus = robot

    def slow(message, answers):
        if message.arbitration_id == 0x612 and bytes(message.data[:4]) == b"\x40\x41\x60\x00":
            driver._clock.time += 0.1
        return answers

    bus.change = slow
    bus.devices[18].put(0x1A00, 1, 0x60640020)  # no TPDO brings it
    driver.enable()
    found = [(node, what) for node, what in words(driver) if "answers for 6041h after 0.1 s" in what]
    assert [node for node, _ in found] == [18]


def test_an_answer_that_is_lost_right_after_enable_stops_nothing(enabled):
    driver, bus = enabled
    bus.queue.clear()
    driver.cycle()
    assert driver.command((1.0, 1.0)) == (1.0, 1.0)


def test_a_drive_that_stays_in_a_state_is_an_error_with_its_status(robot):
    driver, bus = robot
    bus.devices[17].on_write = lambda *_write: None
    with pytest.raises(DriveError, match="ready to switch on") as caught:
        driver.enable()
    assert (caught.value.node, caught.value.status) == (17, 0x0240)
    with pytest.raises(NotEnabled):
        driver.command((0.0, 0.0))


def test_a_restart_before_a_drive_is_configured_does_not_stop_what_is_enabled_then(kit, enabled):
    driver, bus = enabled
    driver.cycle()
    bus.queue.append(kit.frame(0x711, b"\0"))
    driver.enable()
    driver.cycle()
    assert driver.command((1.0, 1.0)) == (1.0, 1.0)
    assert (17, "restarted (boot-up)") in words(driver)


def test_a_drive_that_the_driver_makes_pre_operational_has_lost_nothing(kit, enabled):
    driver, bus = enabled
    bus.devices[17].put(0x1017, 0, 0)
    bus.devices[17].put(0x1016, 1, 0)
    sends_at_writes(bus, 17, range(0x1000, 0x2000), kit.frame(0x711, b"\x7f"))  # while it is configured
    driver.enable()
    driver.cycle()
    assert driver.command((1.0, 1.0)) == (1.0, 1.0)


@pytest.mark.parametrize(
    ("node", "written", "can_id", "data", "trouble"),
    [(17, 0x1016, 0x711, b"\0", "while it was configured"), (18, 0x6060, 0x091, EMERGENCY, "8110h")],
    ids=["a restart in its configuration", "an emergency of an enabled one while the next one is not yet"],
)
def test_trouble_of_a_drive_during_enable_stops_all(kit, robot, node, written, can_id, data, trouble):
    driver, bus = robot
    sends_at_writes(bus, node, {written}, kit.frame(can_id, data))
    driver.enable()
    driver.cycle()
    with pytest.raises(DrivesStopped, match=trouble):
        driver.command((1.0, 1.0))


def test_an_emergency_of_an_encoder_stops_nothing(kit, enabled):
    driver, bus = enabled
    bus.queue.append(kit.frame(0x081, EMERGENCY))
    driver.cycle()
    assert driver.command((1.0, 1.0)) == (1.0, 1.0)


@pytest.mark.usefixtures("_impatient")
def test_a_missing_drive_is_named(robot):
    driver, bus = robot
    bus.devices[18].power_off()
    with pytest.raises(NodeMissing, match=r"drive of a\.right"):
        driver.enable()


def test_speeds_are_sent_as_counts_with_the_drives_sign(enabled):
    driver, bus = enabled
    driver.command((1.0, 1.0))
    assert targets(bus, 0x211)[-1] == round(COUNTS)
    assert targets(bus, 0x212)[-1] == round(-COUNTS)


def test_an_unchanged_command_is_refreshed_every_100_ms_only(enabled):
    driver, bus = enabled
    driver.cycle()
    before = len(targets(bus, 0x211))
    for step in range(100):
        bus.devices[1].position = bus.devices[2].position = 60 * step
        driver.command((1.0, 1.0))
        driver.cycle()
    assert 9 <= len(targets(bus, 0x211)) - before <= 12


def test_too_fast_slows_all_wheels_by_one_factor_and_counts(enabled):
    driver, _ = enabled
    limit = driver.vehicle.limits.speed / 0.075
    assert driver.command((1.5 * limit, limit)) == pytest.approx((limit, limit / 1.5))
    assert driver.drives.limited == 1
    assert any("slowed down" in event.what for event in driver.report().events)
    assert driver.command((limit, -limit)) == pytest.approx((limit, -limit))
    assert driver.drives.limited == 1


@pytest.mark.parametrize("speeds", [(math.nan, 0.0), (math.inf, 0.0), (0.0,), (0.0, 0.0, 0.0)])
def test_what_is_no_speed_is_refused(enabled, speeds):
    driver, _ = enabled
    with pytest.raises(BadCommand, match="2 finite wheel speeds"):
        driver.command(speeds)


def test_without_a_commander_the_wheels_stop_after_200_ms(enabled):
    driver, bus = enabled
    driver.command((1.0, 1.0))
    for _ in range(19):
        driver.cycle()
    assert targets(bus, 0x211)[-1] == round(COUNTS)
    for _ in range(3):
        driver.cycle()
    assert targets(bus, 0x211)[-1] == 0
    assert any("no command for 0.2 s" in event.what for event in driver.report().events)


def test_watchdog_refresh_and_heartbeat_are_due_at_their_times(kit):
    driver, bus = kit.configured(kit.drive("a.left", 17), kit.drive("a.right", 18), watchdog=0.25)
    driver._clock.now = lambda: driver._clock.time
    driver._clock.time = 0.0
    faults = []
    driver._events.listener = lambda _time, _node, what, *, is_fault: faults.append((what, is_fault))
    driver.enable()
    driver.command((1.0, 1.0))
    driver.drives.tick(0.0)
    bus.sent.clear()
    driver._clock.time = 0.1
    driver.drives.tick(0.1)
    assert bus.sent.count(HEARTBEAT) == 1
    assert len(targets(bus, 0x211)) == 1
    driver.drives.tick(0.25)
    assert any(driver.drives.speeds)
    driver.drives.tick(0.26)
    assert driver.drives.speeds == (0.0, 0.0)
    assert faults == [("no command for 0.25 s: wheels stopped", True)]


def test_our_heartbeat_goes_on_while_enabled(enabled):
    driver, bus = enabled
    before = bus.sent.count((0x77F, b"\x05"))
    for _ in range(100):
        driver.cycle()
    assert 9 <= bus.sent.count((0x77F, b"\x05")) - before <= 11


def test_our_heartbeat_goes_on_after_disable_and_no_torque_is_commanded(kit, enabled):
    driver, bus = enabled
    driver.drives.disable()
    bus.sent.clear()
    bus.queue.append(kit.frame(0x191, b"\x21\x02"))
    for _ in range(100):
        driver.cycle()
    assert 9 <= bus.sent.count((0x77F, b"\x05")) <= 11
    assert not driver.drives.is_enabled
    with pytest.raises(NotEnabled, match="they were disabled"):
        driver.command((1.0, 1.0))
    assert not [what for _, what in words(driver) if "has left operation enabled" in what]
    written = len(bus.devices[17].writes)
    driver.drives.disable()
    assert len(bus.devices[17].writes) == written


@pytest.mark.usefixtures("_impatient")
def test_a_drive_that_cannot_be_disabled_is_logged_and_the_other_one_is_disabled(enabled):
    driver, bus = enabled
    bus.devices[17].power_off()
    driver.drives.disable()
    assert [node for node, what in words(driver) if "could not be disabled" in what] == [17]
    assert bus.devices[18].number(0x6040) == 0x06


def test_our_heartbeat_goes_on_while_an_answer_is_awaited(enabled):
    driver, bus = enabled
    waits, recv = [], bus.recv
    bus.recv = lambda timeout: waits.append(timeout) or recv(timeout)
    bus.sent.clear()
    for _ in range(4):
        driver._clock.time += 0.06
        driver._network.pump(0.5)
    assert bus.sent == [(0x77F, b"\x05")] * 2
    assert max(waits) < 0.06


def test_stop_is_sent_at_once_and_on_a_dead_bus_noted(enabled):
    driver, bus = enabled
    driver.command((1.0, 1.0))
    driver.stop()
    assert targets(bus, 0x211)[-1] == targets(bus, 0x212)[-1] == 0
    bus.is_dead = True
    driver.stop()
    assert any("stop could not be sent" in event.what for event in driver.report().events)


def test_close_stops_and_takes_the_torque_away(enabled):
    driver, bus = enabled
    driver.command((1.0, 1.0))
    driver.close()
    assert targets(bus, 0x211)[-1] == 0
    assert bus.devices[17].number(0x6040) == 0x06


def test_all_drives_get_a_quick_stop_and_those_in_nmt_state_stopped_are_brought_back_for_it(kit, enabled):
    """A drive that is stopped has no SDO; what is seen of the drives afterwards is no news."""
    driver, bus = enabled
    faults = []
    driver._events.listener = lambda _time, _node, what, *, is_fault: faults.append((what, is_fault))
    bus.sent.clear()
    bus.queue.extend([kit.frame(0x711, b"\x04")] * 2)
    for _ in range(2):
        driver.cycle()
    assert not driver.drives.is_enabled
    assert bus.devices[17].writes[-1] == bus.devices[18].writes[-1] == QUICK_STOP
    assert [data for can_id, data in bus.sent if can_id == 0x000] == [b"\x80\x11"]
    assert ("all wheels stopped; enable() is needed", True) in faults
    bus.queue.append(kit.frame(0x192, b"\x07\x02"))
    driver.cycle()
    assert not [what for _, what in words(driver) if "has left operation enabled" in what]


def test_a_quick_stop_that_cannot_be_sent_is_logged(enabled):
    driver, bus = enabled
    bus.is_dead = True
    driver.drives.halt(Trouble(0.0, 17, "a trouble"))
    assert not driver.drives.is_enabled
    assert [what for _, what in words(driver) if "quick stop could not be sent" in what]


def test_the_first_troubles_are_kept(enabled):
    driver, _ = enabled
    for number in range(2 * MAX_TROUBLES):
        driver.drives.halt(Trouble(0.0, 17, str(number)))
    assert [trouble.what for trouble in driver.drives.troubles] == list("01234567")


@pytest.mark.parametrize(
    ("can_id", "data"),
    [(0x711, b"\0"), (0x191, b"\x18\x02"), (0x711, b"\x05")],
    ids=["by a restart", "by a fault", "by silence after a heartbeat"],
)
def test_a_drive_that_drops_out_stops_all_wheels_until_enable(kit, enabled, can_id, data):
    driver, bus = enabled
    driver.command((1.0, 1.0))
    bus.queue.append(kit.frame(can_id, data))
    for _ in range(200):
        driver.cycle()
    assert targets(bus, 0x212)[-1] == 0
    with pytest.raises(DrivesStopped, match="node 17"):
        driver.command((1.0, 1.0))
    driver.enable()
    driver.command((1.0, 1.0))
    assert targets(bus, 0x212)[-1] == round(-COUNTS)


def test_a_bus_that_was_lost_leaves_the_drives_disabled(kit, monkeypatch):
    """They have missed our heartbeat and stopped by themselves; only `enable` starts them again."""
    drives = (kit.drive("a.left", 17), kit.drive("a.right", 18))
    devices = [kit.encoder_device(1), kit.encoder_device(2), kit.drive_device(17), kit.drive_device(18)]
    monkeypatch.setattr(module, "open_bus", lambda *_arguments: kit.FakeBus(devices))
    with Driver(kit.one_truck(drives=drives), "virtual://fake", clock=kit.FakeClock()) as driver:
        driver.configure()
        driver.enable()
        driver.cycle()
        driver._network.can_bus.is_dead = True
        driver.cycle()
        with pytest.raises(DrivesStopped, match="the bus was lost"):
            driver.command((1.0, 1.0))
        driver.enable()
        driver.command((1.0, 1.0))


def test_a_target_saturates_at_32_bits(kit):
    assert target_velocity(kit.drive("a.left", 17), 1e12) == 2**31 - 1
    assert target_velocity(kit.drive("a.left", 17), -1e12) == -(2**31 - 1)


def stand_still(driver):
    for _ in range(150):
        driver.command((4.0, 4.0))
        driver.cycle()


def test_a_wheel_that_stands_against_its_command_stops_all(enabled):
    driver, bus = enabled
    with pytest.raises(DrivesStopped, match=r"a\.left is commanded and stands"):
        stand_still(driver)
    assert targets(bus, 0x212)[-1] == 0
    assert {event.node for event in driver.report().events if "stands still" in event.what} == {1, 2}


def test_a_wheel_that_is_commanded_to_stand_is_not_frozen(enabled):
    driver, bus = enabled
    for step in range(150):
        bus.devices[2].position = 100 * step
        driver.command((0.0, 4.0))
        driver.cycle()
    assert not [event for event in driver.report().events if "stands still" in event.what]
