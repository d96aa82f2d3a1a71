import sys

import pytest
from canopen.objectdictionary import UNSIGNED32

from omnimate.driver.errors import BusError
from omnimate.driver.robot import driver as module
from omnimate.driver.robot.driver import Driver, open_driver
from tests.driver.conftest import words


def test_configured_nodes_answer_each_sync_with_a_sample(kit):
    driver, bus = kit.configured()
    for count in (10, 20):
        for device in bus.devices.values():
            device.position = count
        sample = driver.cycle()
        assert sample.counts == (count, count)
        assert sample.present == (True, True)
        assert sample.device_time == (1.0, 1.0)
    assert sample.index == 1
    assert sample.time == pytest.approx(100.02)
    assert driver.report().is_clean


def test_samples_yields_one_per_sync(kit):
    driver, _ = kit.configured()
    samples = driver.samples()
    assert [next(samples).index for _ in range(3)] == [0, 1, 2]


def test_a_muted_node_is_missing_and_said_to_be_silent(kit):
    driver, bus = kit.configured()
    driver.cycle()
    bus.devices[1].power_off()
    for _ in range(5):
        assert driver.cycle().present == (False, True)
    report = driver.report()
    assert report.node(1).missing == 5
    assert (1, "a.left: no valid answer to SYNC") in words(driver)
    assert [(gap.channel, gap.reason) for gap in report.gaps] == [("a.left", "missing")]


def test_answers_that_wait_in_the_queue_count_even_if_the_host_was_slow(kit):
    driver, _ = kit.configured()
    driver._clock.remaining = lambda: -1.0
    assert driver.cycle().present == (True, True)


def test_a_babbling_node_is_named_and_does_not_hold_the_samples_up(kit):
    driver, bus = kit.configured()
    noise = [kit.frame(0x381, b"\xff" * 8)] * 20
    bus.change = lambda message, answers: noise + answers if message.arbitration_id == 0x80 else answers
    for _ in range(200):
        assert driver.cycle().present == (True, True)
    report = driver.report()
    assert report.node(1).unknown == 4000
    assert (1, "babbles: floods the bus with frames 381h") in words(driver)


def test_an_endless_queue_does_not_stop_sync(kit, monkeypatch):
    monkeypatch.setattr(module, "MAX_DRAIN", 50)
    driver, bus = kit.configured()

    class Endless(list):
        def popleft(self):
            return kit.frame(0x381)

    bus.queue = Endless([1])
    assert driver.cycle().present == (False, False)


@pytest.fixture
def threads_take_turns():
    """Let threads take turns after 10 us instead of 5 ms, so that few cycles pass in each dialogue."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(interval)


@pytest.mark.usefixtures("threads_take_turns")
@pytest.mark.parametrize("inline", [True, False])
def test_a_rebooted_node_is_configured_again_and_its_wheel_goes_on(kit, inline):
    """In both clocks: held between two SYNCs, or in a thread that the driver's own reading feeds."""
    driver, bus = kit.configured(clock=kit.FakeClock(inline=inline))
    for device in bus.devices.values():
        device.position = 5000
    driver.cycle()
    bus.devices[1].reset()
    for _ in range(200_000):
        sample = driver.cycle()
        if sample.present == (True, True):
            break
    assert sample.counts == (5000, 5000)
    bus.devices[1].position = 30
    bus.devices[2].position = 5030
    assert driver.cycle().counts == (5030, 5030)
    driver.close()
    assert (1, "restarted (boot-up)") in words(driver)
    assert any(node == 1 and "configured again" in what for node, what in words(driver))
    assert ("a.left", "reboot") in [(gap.channel, gap.reason) for gap in driver.report().gaps]
    assert driver.report().node(1).restarts == 1


@pytest.mark.usefixtures("_impatient")
def test_sync_goes_on_while_a_node_is_configured_in_the_background(kit):
    driver, bus = kit.configured(clock=kit.FakeClock(inline=False))
    driver.cycle()
    bus.devices[1].reset()
    bus.devices[1].power_off()
    for _ in range(20):
        assert driver.cycle().present[1]
    driver.close()


@pytest.mark.usefixtures("_impatient")
def test_a_node_that_cannot_be_configured_is_tried_again_with_pauses(kit):
    driver, bus = kit.configured()
    driver.cycle()
    bus.devices[1].reset()
    bus.devices[1].power_off()
    for _ in range(100):
        driver.cycle()
    failed = [event for event in driver.report().events if "could not be configured" in event.what]
    assert [event.node for event in failed] == [1]
    assert failed[0].count == 3
    bus.devices[1].is_powered = True
    for _ in range(200):
        sample = driver.cycle()
    assert sample.present == (True, True)


def test_two_heartbeats_that_are_not_operational_mean_a_lost_configuration(kit):
    driver, bus = kit.configured()
    driver.cycle()
    bus.devices[1].state = 0x7F
    bus.queue.append(kit.frame(0x701, b"\x7f"))
    driver.cycle()
    assert not driver.report().node(1).restarts
    bus.queue.append(kit.frame(0x701, b"\x7f"))
    assert driver.cycle().present == (True, True)
    assert any("lost its configuration" in what for _, what in words(driver))


def test_a_preset_during_the_drive_is_reported(kit):
    offset = (0x6509, 0, UNSIGNED32, "rw", 0)
    bus = kit.FakeBus([kit.encoder_device(1, offset), kit.encoder_device(2)])
    driver = Driver(kit.one_truck(), bus, clock=kit.FakeClock())
    driver.configure()
    driver.cycle()
    bus.devices[1].reset()
    bus.devices[1].put(0x6509, 0, 99)
    driver.cycle()
    assert (1, "6509h was 0, is 99: preset, or another device?") in words(driver)


def test_a_sync_that_fails_once_is_sent_again_and_reported(kit):
    driver, bus = kit.configured()
    bus.failing_sends = 1
    sample = driver.cycle()
    assert sample.present == (True, True)
    assert words(driver) == [(None, "SYNC could not be sent, tried again: no buffer space")]


class Opener:
    """Stands for `open_bus`: fails a number of times, then returns the bus."""

    def __init__(self, bus):
        self.bus, self.failures = bus, 0

    def __call__(self, url, bitrate=None):
        if self.failures:
            self.failures -= 1
            raise BusError(url, "nobody answers")
        return self.bus


def test_a_lost_bus_is_opened_again_with_longer_pauses(kit, monkeypatch):
    clock = kit.FakeClock()
    devices = [kit.encoder_device(1), kit.encoder_device(2)]
    opener = Opener(kit.FakeBus(devices))
    monkeypatch.setattr(module, "open_bus", opener)
    with Driver(kit.one_truck(), "virtual://fake", clock=clock) as driver:
        driver.configure()
        driver.cycle()
        opener.bus.is_dead = True
        opener.bus, opener.failures = kit.FakeBus(devices), 3
        sample = driver.cycle()
        assert clock.slept == [0.1, 0.2, 0.4, 0.8]
        for _ in range(3):
            sample = driver.cycle()
        assert sample.present == (True, True)
        assert any("bus opened again after 1.5 s" in what for _, what in words(driver))
        assert any("has not restarted" in what for _, what in words(driver))


@pytest.mark.parametrize(("seconds", "waited"), [(2.0, 2.0), (None, 5.0), (20.0, 5.0)])
def test_a_lost_bus_is_not_waited_for_beyond_the_end(kit, monkeypatch, seconds, waited):
    clock, opener = kit.FakeClock(), Opener(kit.FakeBus([kit.encoder_device(1), kit.encoder_device(2)]))
    monkeypatch.setattr(module, "open_bus", opener)
    driver = Driver(kit.one_truck(), "virtual://fake", clock=clock, patience=5.0)
    driver.configure()
    driver.end_after(seconds)
    opener.bus.is_dead = True
    opener.failures = 100
    with pytest.raises(BusError, match=f"not back within {waited:g} s"):
        driver.cycle()
    assert sum(clock.slept) == pytest.approx(waited)


def test_a_frozen_wheel_is_remarked_when_the_other_one_turns(kit):
    driver, bus = kit.configured()
    for step in range(200):
        bus.devices[2].position = 100 * step
        driver.cycle()
    assert [node for node, what in words(driver) if "stands still" in what] == [1]


def test_an_encoder_with_another_range_is_unwrapped_by_it(kit):
    driver, bus = kit.driver_and_bus()
    bus.devices[1].put(0x6002, 0, 4095)
    driver.configure()
    assert driver.vehicle.encoder("a.left").wrap_range == 4096
    bus.devices[1].position = 4090
    driver.cycle()
    bus.devices[1].position = 4
    assert driver.cycle().counts[0] == 4100


def test_reading_only_never_writes_a_control_word(kit):
    driver, bus = kit.driver_and_bus(kit.drive("a.left", 17), kit.drive("a.right", 18))
    with driver:
        driver.configure()
        driver.cycle()
        driver.stop()
    assert bus.devices[17].writes == []
    assert not [can_id for can_id, _ in bus.sent if can_id in {0x211, 0x212, 0x611, 0x612}]


@pytest.fixture
def closings(kit, monkeypatch):
    """How often the bus that a URL opens was closed."""
    bus, closed = kit.FakeBus([kit.encoder_device(1), kit.encoder_device(2)]), []
    monkeypatch.setattr(bus, "shutdown", lambda: closed.append(True))
    monkeypatch.setattr(module, "open_bus", Opener(bus))
    return closed


def test_it_hands_on_what_configuring_showed_and_leaves_the_bus_open(kit, closings):
    driver, report = open_driver(kit.one_truck(), "virtual://x")
    assert (driver.vehicle.name, [node.node for node in report.nodes]) == ("single", [1, 2])
    assert closings == []


@pytest.mark.parametrize("problem", [BusError("virtual://x", "no answer"), KeyboardInterrupt()])
def test_whatever_ends_configuring_closes_the_bus(kit, closings, monkeypatch, problem):
    def fail(_driver):
        raise problem

    monkeypatch.setattr(Driver, "configure", fail)
    with pytest.raises(type(problem)):
        open_driver(kit.one_truck(), "virtual://x")
    assert closings == [True]
