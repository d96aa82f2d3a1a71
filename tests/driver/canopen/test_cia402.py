"""The state machine of CiA 402: enabled from every state that a drive can start in, in the right order."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.canopen.cia402 import (
    CONTROL_WORD,
    FILLER,
    MODE,
    POLLS,
    QUICK_STOP,
    TARGET_VELOCITY,
    TargetPdo,
    disable_drive,
    enable_drive,
    planned_pdo,
    takes_target,
)
from omnimate.driver.canopen.pdo_mapping import Entry
from omnimate.driver.errors import DriveError, NotTaken, SdoRefused
from omnimate.vehicle.errors import TableError
from omnimate.vehicle.parameters import Drive
from tests.foreign.devices import (
    ENABLED,
    FAULT,
    FAULT_REACTION,
    QUICK_STOP_ACTIVE,
    READY,
    SWITCH_ON_DISABLED,
    SWITCHED_ON,
)

orders = st.permutations([CONTROL_WORD, TARGET_VELOCITY, FILLER])


@pytest.fixture
def drive(kit):
    """Return what makes a drive in a state of CiA 402, and its objects."""

    def make(state, ignored=()):
        device = kit.drive_device(1, state, ignored)
        return device, kit.sdo([device])[0]

    return make


def no_wait(_seconds):
    pass


@pytest.mark.parametrize("state", [SWITCH_ON_DISABLED, READY, SWITCHED_ON, ENABLED, FAULT, QUICK_STOP_ACTIVE])
def test_from_every_state_it_ends_enabled_in_profile_velocity_mode_at_speed_zero_before_the_torque(
    drive, state
):
    device, sdo = drive(state)
    device.put(0x60FF, 0, 12345)
    enable_drive(sdo, no_wait)
    assert device.status == ENABLED
    assert device.number(0x6061) == 3
    assert device.number(0x60FF) == 0
    order = [(index, value) for index, _, value in device.writes]
    assert order.index((0x60FF, 0)) < order.index((0x6040, 0x0F))
    assert {value for index, value in order if index == 0x60FF} == {0}


def test_a_drive_that_keeps_another_speed_gets_no_torque(drive):
    device, sdo = drive(SWITCH_ON_DISABLED)
    follow = device.on_write
    device.on_write = lambda index, sub, value: (
        device.put(0x60FF, 0, 500) if index == 0x60FF else follow(index, sub, value)
    )
    with pytest.raises(NotTaken):
        enable_drive(sdo, no_wait)
    assert device.status == SWITCH_ON_DISABLED


@pytest.mark.parametrize(
    ("state", "ignored", "expected"),
    [
        (SWITCH_ON_DISABLED, 0x06, "ready to switch on"),
        (SWITCH_ON_DISABLED, 0x07, "switched on"),
        (SWITCH_ON_DISABLED, 0x0F, "operation enabled"),
        (FAULT, 0x80, "no fault after a reset"),
        (QUICK_STOP_ACTIVE, 0x00, "the end of its quick stop"),
    ],
)
def test_a_transition_that_does_not_happen_is_named_after_two_seconds(drive, state, ignored, expected):
    device, sdo = drive(state, ignored={ignored})
    waits = []
    with pytest.raises(DriveError, match=expected) as caught:
        enable_drive(sdo, waits.append)
    assert caught.value.status == device.status
    assert sum(waits) == pytest.approx(2.0)
    assert min(waits) > 0.0


def test_a_fault_is_reset_once_the_reaction_to_it_is_over(drive):
    device, sdo = drive(FAULT_REACTION)
    enable_drive(sdo, lambda _seconds: setattr(device, "status", FAULT))
    assert device.status == ENABLED


def test_a_drive_that_is_slow_is_waited_for(drive):
    """A brake may take two seconds to open."""
    device, sdo = drive(SWITCH_ON_DISABLED, ignored={0x0F})
    waits = []

    def pump(seconds):
        waits.append(seconds)
        if len(waits) == POLLS // 2:
            device.status = ENABLED

    enable_drive(sdo, pump)
    assert device.status == ENABLED


def test_another_mode_of_operation_is_an_error(drive):
    device, sdo = drive(SWITCH_ON_DISABLED)
    device._read_callbacks.insert(0, lambda index, **_: 1 if index == 0x6061 else None)
    with pytest.raises(DriveError, match="6061h shows 1") as caught:
        enable_drive(sdo, no_wait)
    assert caught.value.status == ENABLED


def test_disabling_takes_the_torque_away(drive):
    device, sdo = drive(ENABLED)
    disable_drive(sdo)
    assert device.status == READY


def test_a_refused_control_word_is_an_error(drive):
    device, sdo = drive(SWITCH_ON_DISABLED)
    device.refuse[0x6040, 0] = 0x08000022
    with pytest.raises(SdoRefused):
        enable_drive(sdo, no_wait)


@given(orders, st.integers(-(2**31), 2**31 - 1), st.integers(0, 0xFFFF))
def test_target_and_control_word_stand_where_the_mapping_says_and_else_all_is_zero(entries, target, control):
    pdo = TargetPdo(0x201, tuple(entries))
    data = pdo.data(target, control)
    assert len(data) == 7
    word = int.from_bytes(data, "little")
    before = entries[: entries.index(CONTROL_WORD)]
    control <<= sum(entry.bits for entry in before)
    assert word == (target % 2**32 << pdo.start_bit) + control


@pytest.mark.parametrize("start_bit", [0, 8, 16, 24, 32])
def test_what_is_planned_has_the_target_where_vehicle_toml_says(start_bit):
    pdo = planned_pdo(Drive("a.left", 1, 0x201, 1, 4096, start_bit=start_bit))
    assert pdo.start_bit == start_bit
    assert takes_target(pdo.entries)
    assert (CONTROL_WORD in pdo.entries) == (start_bit >= 16)


def test_objects_have_the_mapping_values_of_cia_402():
    """As a device shows them in 1600h: index, sub-index and bits; the filler is an UNSIGNED8 of CiA 301."""
    values = [entry.value for entry in (TARGET_VELOCITY, CONTROL_WORD, MODE, FILLER)]
    assert values == [0x60FF0020, 0x60400010, 0x60600008, 0x00050008]


def test_a_quick_stop_keeps_the_voltage_and_clears_its_bit():
    """CiA 402-2, device control commands: bits 7, 2 and 1 are 0, 0 and 1."""
    assert QUICK_STOP & 0x86 == 0x02


@pytest.mark.parametrize("index", range(10))
def test_data_types_from_boolean_to_unsigned32_fill_a_gap(index):
    """CiA 301: 0001h to 0007h."""
    assert takes_target((TARGET_VELOCITY, Entry(index, 0, 8))) is (index in {1, 2, 3, 4, 5, 6, 7})


@pytest.mark.parametrize(
    ("entries", "taken"),
    [
        ((TARGET_VELOCITY,), True),
        ((CONTROL_WORD, MODE, TARGET_VELOCITY), True),
        ((CONTROL_WORD,), False),
        ((), False),
        ((TARGET_VELOCITY, TARGET_VELOCITY), False),
        ((TARGET_VELOCITY, Entry(0x6071, 0, 16)), False),
        ((Entry(0x60FF, 0, 16), CONTROL_WORD), False),
    ],
)
def test_a_mapping_is_taken_where_every_entry_can_be_sent(entries, taken):
    assert takes_target(entries) is taken


@pytest.mark.parametrize("start_bit", [4, 33, -8])
def test_a_target_begins_at_a_byte(start_bit):
    with pytest.raises(TableError, match="start_bit"):
        Drive("a.left", 1, 0x201, 1, 4096, start_bit=start_bit)
