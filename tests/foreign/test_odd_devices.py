"""What devices and adapters do beside what the standards ask for: none of it stops or turns the robot."""

from __future__ import annotations

import errno

import can
import pytest

from omnimate.driver.errors import BusLost, DrivesStopped
from tests.foreign.robots import FIRST_DRIVE, devices, drive


@pytest.mark.usefixtures("family")
def test_heartbeats_with_the_toggle_bit_of_node_guarding_tell_the_same_state(enabled):
    driver, bus = enabled(seconds=0.3)
    for number in range(40):
        state = 0x05 | number % 2 << 7
        bus.at(0.01 * number, lambda state=state: bus.inject(0x700 + FIRST_DRIVE, bytes([state])))
    drive(driver, 1.0)
    assert driver.drives.troubles == ()


@pytest.mark.usefixtures("family")
def test_a_device_that_boots_twice_is_configured_and_drives_on(enabled):
    nodes = devices()
    driver, bus = enabled(nodes, seconds=0.3)
    nodes[0].reset()
    bus.at(0.05, nodes[0].reset)
    samples = drive(driver, 2.0)
    assert all(samples[-1].present)
    assert driver.drives.troubles == ()


@pytest.mark.usefixtures("family")
def test_a_storm_of_emergencies_of_an_encoder_stops_nothing_and_is_one_line_for_each_kind(enabled):
    driver, bus = enabled(seconds=0.3)
    for number in range(3000):
        data = bytes([number % 5, 0x81, 1, 0, 0, number % 256, number // 256, 0])
        bus.at(0.0003 * number, lambda data=data: bus.inject(0x081, data))
    samples = drive(driver, 1.5)
    assert all(samples[-1].present)
    assert driver.drives.troubles == ()
    storm = [event for event in driver.report().events if event.what.startswith("EMCY 81")]
    assert (len(storm), sum(event.count for event in storm)) == (5, 3000)


def test_a_device_that_fills_its_pdos_up_to_8_bytes_is_read_and_told(enabled):
    nodes = devices()
    pack = nodes[0]._pack
    nodes[0]._pack = lambda entries: pack(entries).ljust(8, b"\xaa")
    driver, _ = enabled(nodes, seconds=0.3)
    samples = drive(driver, 1.0)
    assert all(all(sample.present) for sample in samples)
    assert abs(samples[-1].counts[0] - samples[-1].counts[1]) < 100
    assert any("has 8 bytes and its mapping 4" in event.what for event in driver.report().events)


def full_queue(bus, until):
    """Let the interface refuse every frame until a time [s], as SocketCAN does with a full queue."""
    send = bus.send

    def refuse(message, timeout=None):
        if bus.now < until:
            raise can.CanOperationError("Failed to transmit: No buffer space available", errno.ENOBUFS)
        send(message, timeout)

    bus.send = refuse


@pytest.mark.usefixtures("family")
def test_a_queue_that_is_full_for_some_milliseconds_loses_no_frame(enabled):
    driver, bus = enabled(seconds=0.3)
    full_queue(bus, bus.now + 0.008)
    before = driver.report().syncs
    samples = drive(driver, 1.0)
    assert driver.drives.troubles == ()
    assert len(samples) == driver.report().syncs - before
    assert all(all(sample.present) for sample in samples)


@pytest.mark.usefixtures("family")
def test_a_queue_that_stays_full_is_a_lost_bus(enabled):
    driver, bus = enabled(seconds=0.3)
    full_queue(bus, bus.now + 10.0)
    with pytest.raises(BusLost, match="No buffer space"):
        drive(driver, 1.0)


@pytest.mark.usefixtures("family")
def test_error_frames_of_the_adapter_are_counted_and_change_no_sample(enabled):
    driver, bus = enabled(seconds=0.3)
    passive = can.Message(arbitration_id=0x24, data=bytes([0, 0x30, 0, 0, 0, 0, 0x60, 0x70]))
    passive.is_error_frame, passive.is_extended_id = True, False
    for number in range(200):
        bus.at(0.002 * number, lambda: bus.far.send(passive))
    samples = drive(driver, 1.0)
    assert all(all(sample.present) for sample in samples)
    assert [frame[-1] for frame in driver.report().unknown_frames if "error" in frame[0]] == [200]


@pytest.mark.parametrize("is_late", [False, True])
def test_an_emergency_of_an_enabled_drive_counts_also_while_the_others_are_enabled(begun, is_late):
    """One that came before a drive was enabled tells of what enabling has reset."""
    nodes = devices()
    first, last = nodes[-4], nodes[-1]
    driver, _ = begun(nodes)
    driver.configure()
    control = last._control
    sent = []

    def controlled(word):
        control(word)
        if is_late and word & 0x0F == 0x0F and not sent:
            sent.append(word)
            first.emergency(0x5000)

    last._control = controlled
    if not is_late:
        first.emergency(0x5000)
    driver.enable()
    if is_late:
        with pytest.raises(DrivesStopped, match="EMCY 5000h"):
            drive(driver, 0.3)
    else:
        drive(driver, 0.3)
        assert driver.drives.troubles == ()


@pytest.mark.parametrize("register", [0x00, 0x09])
def test_an_error_that_an_enabled_drive_still_has_is_told_and_it_drives(begun, register):
    """EMCY without "error gone": operation enabled says that there is no fault, 1001h what else there is."""
    nodes = devices()
    driver, _ = begun(nodes)
    driver.configure()
    nodes[-1].put(0x1001, 0, register)
    nodes[-1].emergency(0x4210)
    driver.enable()
    drive(driver, 0.3)
    assert driver.drives.troubles == ()
    said = [event.what for event in driver.report().events if "1001h" in event.what]
    expected = "is enabled, yet its error register 1001h = 09h says: generic, temperature"
    assert said == ([expected] if register else [])
