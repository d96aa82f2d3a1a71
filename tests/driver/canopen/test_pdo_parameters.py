"""A PDO that is written reads back as it was written, on canopen's own SDO server."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.canopen.pdo_mapping import Entry
from omnimate.driver.canopen.pdo_parameters import (
    RPDO,
    TPDO,
    PdoSetting,
    Transmission,
    read_pdo,
    read_pdos,
    switch_off,
    write_pdo,
)
from omnimate.driver.errors import MappingImpossible

entries = st.builds(Entry, st.integers(0x1000, 0x9FFF), st.integers(0, 8), st.sampled_from([8, 16, 32]))
slots = st.lists(entries, min_size=1, max_size=4)


@given(cob_id=st.integers(0x181, 0x57F), transmission=st.integers(0, 255), mapped=slots)
def test_what_is_written_is_read_back(kit, cob_id, transmission, mapped):
    sdo, _ = kit.sdo([kit.encoder_device(1)])
    old = read_pdo(sdo, TPDO)
    written = write_pdo(sdo, old, cob_id, [Transmission(transmission)], [[entry] for entry in mapped])
    assert written == PdoSetting(TPDO, cob_id | 1 << 30, transmission, 0, 0, tuple(mapped))
    assert read_pdo(sdo, TPDO) == written


def test_switched_off_and_on_it_keeps_its_parameters(sdo):
    before = read_pdo(sdo, TPDO)
    switch_off(sdo, before)
    off = read_pdo(sdo, TPDO)
    assert (before.is_valid, off.is_valid) == (True, False)
    assert (off.cob_id, off.entries) == (before.cob_id, before.entries)


def test_the_first_alternative_that_the_device_can_map_is_taken(device, sdo):
    best, second = Entry(0x6500, 0, 16), Entry(0x0006, 0, 16)
    device.refuse[0x1A00, 1, best.value] = 0x06040041
    assert write_pdo(sdo, read_pdo(sdo, TPDO), 0x181, [Transmission(1)], [[best, second]]).entries == (
        second,
    )


def test_a_refusal_for_another_reason_than_the_mapping_is_not_tried_again(device, sdo):
    device.refuse[0x1A00, 1] = 0x08000022
    with pytest.raises(MappingImpossible, match="present device state"):
        write_pdo(
            sdo, read_pdo(sdo, TPDO), 0x181, [Transmission(1)], [[Entry(0x6500, 0, 16), Entry(0x0006, 0, 16)]]
        )


def test_only_the_pdos_that_a_device_has_are_read(sdo):
    assert [setting.name for setting in read_pdos(sdo, TPDO)] == ["TPDO1", "TPDO2"]
    assert read_pdos(sdo, RPDO) == ()
