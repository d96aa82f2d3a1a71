"""Two devices on one node id, a second SYNC master, encoders that never answer, and CAN FD frames."""

from __future__ import annotations

import pytest

from omnimate.driver.errors import DrivesStopped, TwoDevices
from tests.driver.conftest import words
from tests.foreign.devices import ForeignEncoder
from tests.foreign.robots import cycles, devices, drive, foreign_encoder, rolling


def second_master(bus, period=0.02):
    """Have a device that is not of the vehicle send SYNC."""
    bus.at(period, lambda: (bus.inject(0x080, b""), second_master(bus, period)))


@pytest.mark.usefixtures("family")
def test_two_devices_on_one_node_id_are_found_before_anything_is_set(begun):
    driver, bus = begun()
    bus.add(foreign_encoder(3))
    with pytest.raises(TwoDevices, match="node 3: each SDO request is answered twice") as caught:
        driver.configure()
    assert caught.value.node == 3


def test_a_second_device_that_is_switched_on_later_is_found_by_its_pdos(enabled):
    driver, bus = enabled()
    cycles(driver, 0.5)
    twin = ForeignEncoder(3)
    bus.add(twin)
    twin.data_store = {index: dict(values) for index, values in bus.nodes[3].data_store.items()}
    twin.state = 5
    cycles(driver, 2.0)
    assert (3, "answers each SYNC twice: two devices have this node id; renumber one") in words(driver)
    with pytest.raises(DrivesStopped, match="two devices"):
        driver.command((0.0,) * 4)


@pytest.mark.usefixtures("family")
def test_a_second_sync_master_stops_the_robot_and_ends_with_code_1(bench, enabled, record):
    driver, bus = enabled()
    second_master(bus)
    with pytest.raises(DrivesStopped, match="another device produces SYNC"):
        drive(driver, 1.0)

    bus = bench(devices())
    second_master(bus)
    result = record(bus, "--seconds", "1")
    assert result.code == 1
    assert "another device produces SYNC" in result.err


@pytest.mark.parametrize("options", [("--seconds", "3"), ("--drive", "straight")])
def test_an_encoder_that_never_answers_sync_ends_with_code_1(bench, record, options):
    bus = bench(devices())
    bus.nodes[5].hears_sync = False
    result = record(bus, *options)
    assert result.code == 1
    assert "node 5: has never answered SYNC" in result.err


@pytest.mark.usefixtures("family")
def test_can_fd_frames_with_the_identifier_of_a_pdo_change_no_sample(begun):
    def run(is_forged):
        driver, bus = begun()
        rolling(bus)
        driver.configure()
        for number in range(40 if is_forged else 0):
            bus.at(0.0203 * number, lambda: bus.inject(0x181, bytes(4), is_fd=True))
        return driver, [(sample.counts, sample.present) for sample in cycles(driver, 1.0)]

    _, untouched = run(False)
    driver, samples = run(True)
    assert samples == untouched
    kinds = {key: (what, count) for key, what, count in driver.report().unknown_frames}
    assert kinds["181h CAN FD"] == ("a CAN FD frame, not CANopen", 40)


@pytest.mark.usefixtures("family")
def test_a_drive_does_not_wait_for_ever_for_an_encoder_that_is_gone(enabled):
    driver, bus = enabled()
    cycles(driver, 0.5)
    bus.nodes[5].power_off()
    cycles(driver, 9.0)
    driver.drives.require_enabled()
    cycles(driver, 2.0)
    with pytest.raises(DrivesStopped, match="has not answered SYNC for 10 s"):
        driver.drives.require_enabled()
    assert [event.node for event in driver.report().problems] == [5]
