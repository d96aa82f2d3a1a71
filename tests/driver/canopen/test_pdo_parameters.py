"""A PDO that is written reads back as it was written, on two independent SDO servers."""

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


def devices(kit):
    """Return an encoder of the tests, and one behind canopen's own SDO server."""
    local = kit.LocalDevice(1)
    for sub, value, size in ((1, 0x40000181, 4), (2, 254, 1), (3, 0, 2), (5, 0, 2)):
        local.local.set_data(0x1800, sub, value.to_bytes(size, "little"))
    local.local.set_data(0x1A00, 0, b"\0")
    return kit.encoder_device(1), local


@given(cob_id=st.integers(0x181, 0x57F), transmission=st.integers(0, 255), mapped=slots)
def test_what_is_written_is_read_back(kit, cob_id, transmission, mapped):
    for device in devices(kit):
        sdo, _ = kit.sdo([device])
        old = read_pdo(sdo, TPDO)
        written = write_pdo(sdo, old, cob_id, [Transmission(transmission)], [[entry] for entry in mapped])
        assert written == PdoSetting(TPDO, cob_id | 1 << 30, transmission, 0, 0, tuple(mapped))
        assert read_pdo(sdo, TPDO) == written


def test_switched_off_and_on_it_keeps_its_parameters(kit):
    for device in devices(kit):
        sdo, _ = kit.sdo([device])
        before = read_pdo(sdo, TPDO)
        switch_off(sdo, before)
        off = read_pdo(sdo, TPDO)
        assert (before.is_valid, off.is_valid) == (True, False)
        assert (off.cob_id, off.entries) == (before.cob_id, before.entries)


def test_the_first_alternative_that_the_device_can_map_is_taken(kit):
    device = kit.encoder_device(1)
    best, second = Entry(0x6500, 0, 16), Entry(0x0006, 0, 16)
    device.refuse[0x1A00, 1, best.value] = 0x06040041
    sdo, _ = kit.sdo([device])
    assert write_pdo(sdo, read_pdo(sdo, TPDO), 0x181, [Transmission(1)], [[best, second]]).entries == (
        second,
    )


def test_a_refusal_for_another_reason_than_the_mapping_is_not_tried_again(kit):
    device = kit.encoder_device(1)
    device.refuse[0x1A00, 1] = 0x08000022
    sdo, _ = kit.sdo([device])
    with pytest.raises(MappingImpossible, match="present device state"):
        write_pdo(
            sdo, read_pdo(sdo, TPDO), 0x181, [Transmission(1)], [[Entry(0x6500, 0, 16), Entry(0x0006, 0, 16)]]
        )


def test_only_the_pdos_that_a_device_has_are_read(kit):
    sdo, _ = kit.sdo([kit.encoder_device(1)])
    assert [setting.name for setting in read_pdos(sdo, TPDO)] == ["TPDO1", "TPDO2"]
    assert read_pdos(sdo, RPDO) == ()
