"""Devices on CANopenNode: how they are configured, and what `omnimate conform` says of them.

The other cases run on them, too, wherever a test has the fixture `family`.
"""

from __future__ import annotations

import pytest

from omnimate.driver.conformance.probe import Probe
from omnimate.driver.conformance.run import conform
from omnimate.driver.errors import MappingImpossible, SdoRefused
from tests.foreign import robots
from tests.foreign.canopennode.nodes import CanOpenNodeDrive, CanOpenNodeEncoder, family, what_is_missing
from tests.foreign.robots import devices, drive, two_trucks
from tests.foreign.test_restarts import cycles
from tests.foreign.test_stopping import COUNTS, OUT, driving

if missing := what_is_missing():
    pytest.skip(missing, allow_module_level=True)

POSITION, OFF, PERIOD_US = 0x60040020, 0x80000000, 15_000
NODE = 1  # the encoder of a.left


@pytest.fixture
def encoder(canopennode):
    return CanOpenNodeEncoder(canopennode, NODE)


@pytest.fixture
def configure(bench, driver_on, encoder):
    """Return what configures a robot of which one encoder is on CANopenNode, and starts it."""

    def run():
        bus = bench([encoder, *devices()[1:]])
        driver = driver_on(two_trucks(), bus)
        report = driver.configure()
        return driver, report.nodes[0]

    return run


def test_an_encoder_that_sends_at_changes_answers_each_sync(configure, encoder):
    driver, configuration = configure()
    assert (encoder.number(0x1800, 1), encoder.number(0x1800, 2)) == (0x180 + NODE, 1)
    assert configuration.heartbeat == 0.5
    assert all(sample.present[0] for sample in cycles(driver, 1.0))


def test_a_mapping_that_is_wrong_is_written_in_the_order_that_cia_301_asks_for(configure, encoder):
    encoder.put(0x1800, 1, OFF | 0x180 + NODE)
    encoder.put(0x1A00, 0, 0)
    encoder.put(0x1A00, 1, 0x10010008)
    encoder.put(0x1A00, 0, 1)
    driver, _ = configure()
    assert [encoder.number(0x1A00, sub) for sub in (0, 1)] == [1, POSITION]
    assert all(sample.present[0] for sample in cycles(driver, 0.5))


def test_what_is_right_may_be_read_only(configure, encoder):
    encoder.put(0x1800, 2, 1)
    for index, subindexes in (
        (0x1800, range(1, 6)),
        (0x1801, range(1, 6)),
        (0x1A00, range(9)),
        (0x1017, (0,)),
    ):
        for subindex in subindexes:
            encoder.protect(index, subindex)
    driver, configuration = configure()
    assert configuration.heartbeat is None
    assert all(sample.present[0] for sample in cycles(driver, 0.5))


def test_a_read_only_cob_id_that_is_wrong_is_an_error_and_everything_is_put_back(configure, encoder):
    encoder.put(0x1800, 1, OFF | 0x1A1)
    encoder.put(0x1800, 1, 0x1A1)
    for index in (0x1800, 0x1801):
        encoder.protect(index, 1)
    with pytest.raises(MappingImpossible, match="expected 181h"):
        configure()
    assert (encoder.number(0x1800, 1), encoder.number(0x1800, 2)) == (0x1A1, 254)
    assert encoder.number(0x1017) == 0


def test_a_read_only_mapping_that_is_right_stays_while_the_rest_is_set(configure, encoder):
    encoder.put(0x1800, 1, OFF | 0x1A1)
    for subindex in range(9):
        encoder.protect(0x1A00, subindex)
    driver, _ = configure()
    assert (encoder.number(0x1800, 1), encoder.number(0x1800, 2)) == (0x180 + NODE, 1)
    assert all(sample.present[0] for sample in cycles(driver, 0.5))


def test_a_read_only_event_timer_and_inhibit_time_are_left_and_each_sync_is_answered(configure, encoder):
    encoder.put(0x1800, 1, OFF | 0x180 + NODE)
    encoder.put(0x1800, 3, 100)
    encoder.put(0x1800, 5, 50)
    encoder.put(0x1800, 1, 0x180 + NODE)
    for subindex in (3, 5):
        encoder.protect(0x1800, subindex)
    driver, _ = configure()
    assert [encoder.number(0x1800, sub) for sub in (2, 3, 5)] == [1, 100, 50]
    assert all(sample.present[0] for sample in cycles(driver, 0.5))


@pytest.fixture
def spare_tpdo(encoder):
    """Return what has TPDO2 send the position by a COB-ID that cannot be changed."""

    def switch_on(cob_id):
        encoder.put(0x1A01, 1, POSITION)
        encoder.put(0x1A01, 0, 1)
        encoder.put(0x1801, 1, cob_id)
        encoder.protect(0x1801, 1)
        assert encoder.number(0x1801, 1) == cob_id

    return switch_on


def test_a_spare_tpdo_that_cannot_be_switched_off_stays_on_and_is_told(configure, spare_tpdo):
    spare_tpdo(0x280 + NODE)
    driver, configuration = configure()
    assert any("TPDO2 281h stays on" in remark for remark in configuration.remarks)
    assert all(sample.present[0] for sample in cycles(driver, 0.5))


def test_a_spare_tpdo_that_cannot_be_switched_off_and_has_another_nodes_cob_id_is_an_error(
    configure, spare_tpdo
):
    spare_tpdo(0x180 + NODE + 1)
    with pytest.raises(SdoRefused, match="1801h:01"):
        configure()


def test_a_counter_of_sync_and_its_period_are_set_in_the_order_that_the_device_takes(configure, encoder):
    """CANopenNode refuses 1019h while 1006h is not 0, as CiA 301 says."""
    encoder.put(0x1019, 0, 240)
    encoder.put(0x1006, 0, 20_000)
    driver, _ = configure()
    assert (encoder.number(0x1006), encoder.number(0x1019)) == (PERIOD_US, 0)
    assert all(sample.present[0] for sample in cycles(driver, 0.5))
    assert encoder.number(0x1001) == 0


def test_drives_stop_by_themselves_without_the_driver_and_the_next_driver_drives(
    bench, driver_on, canopennode, monkeypatch
):
    """1016h and 6007h as the driver sets them; EMCY 8130h from before does not stop the next one."""
    monkeypatch.setattr(robots, "FAMILY", family(canopennode))
    _, bus = driving(bench, driver_on)
    bus.sleep(0.35)  # the driver's heartbeat comes every 0.1 s, and is missed after 0.5 s
    assert bus.nodes[OUT].velocity > 0.9 * COUNTS
    bus.sleep(0.35)
    assert [bus.nodes[node].velocity for node in range(OUT, OUT + 4)] == [0.0] * 4
    assert bus.nodes[OUT].number(0x1001) != 0
    another = driver_on(two_trucks(), bus)
    another.configure()
    another.enable()
    drive(another, 1.0)
    assert another.drives.troubles == ()
    assert bus.nodes[OUT].number(0x1001) == 0
    assert bus.nodes[OUT].velocity > 0.9 * COUNTS


@pytest.mark.parametrize("kind", [CanOpenNodeEncoder, CanOpenNodeDrive])
def test_the_devices_do_all_that_conform_asks_for(bench, canopennode, kind):
    encoder = CanOpenNodeEncoder(canopennode, NODE)
    drive = CanOpenNodeDrive(canopennode, NODE + 1, encoder, "first")
    bus = bench([encoder, drive])
    node = NODE if kind is CanOpenNodeEncoder else NODE + 1
    results = list(conform(Probe(bus, node, 0.1)))
    assert [(result.check.subject, result.reason) for result in results if result.outcome == "failed"] == []
    assert sum(result.outcome == "passed" for result in results) > 40
