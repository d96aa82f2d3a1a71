"""A drive as it is configured: its RPDO, its status word, and heartbeats both ways."""

import pytest

from omnimate.driver.robot.drive_configuration import configure_drive
from omnimate.driver.robot.status_words import LONGEST_INHIBIT

REFUSED = 0x06090030  # value range of parameter exceeded
VELOCITY, CONTROL, POSITION = 0x60FF0020, 0x60400010, 0x60640020
FRESH = [
    "RPDO1 211h type 255 maps 60FFh:00 32 bits",
    "inhibit time of TPDO1: 0 to 200 x 100 us",
    "heartbeat 1017h: 0 ms to 25 ms",
    "1016h:01 = 7F01F4h",
    "6007h:00 = 3h",
]


@pytest.fixture
def device(kit):
    return kit.drive_device(17)


@pytest.fixture
def configured(kit, device):
    """Configure the device, and return what was read and changed, its status source, and its RPDO."""

    def configure(encoder_cob_ids=(), **drive):
        sdo, network = kit.sdo([device], 17)
        commands = []
        found = configure_drive(
            sdo,
            kit.drive("a.left", 17, **drive),
            127,
            encoder_cob_ids,
            0.01,
            lambda *command: commands.append(command),
        )
        network.can_bus.shutdown()
        assert commands == [(0x80, 17)], "pre-operational: PDOs are mapped there only (CiA 301)"
        return found

    return configure


def maps(device, number, *entries):
    """Let an RPDO of a device carry some objects."""
    device.put(0x1600 + number, 0, len(entries))
    for place, entry in enumerate(entries, 1):
        device.put(0x1600 + number, place, entry)


def test_what_was_read_and_changed_is_listed_and_a_second_time_nothing_is_written(device, configured):
    configuration, source, target = configured()
    assert configuration.changed == FRESH
    assert configuration.read[1:] == ["RPDO1 211h type 255 maps nothing", "RPDO2 311h type 255 maps nothing"]
    assert (source.fields, source.is_timely) == (((0x191, 0),), True)
    assert (target.cob_id, target.start_bit) == (0x211, 0)
    written = len(device.writes)
    again, _, _ = configured()
    assert (again.changed, again.remarks, len(device.writes)) == ([], [], written)


@pytest.mark.parametrize(("heartbeat", "is_timely"), [(None, False), (24, True), (25, True), (26, False)])
def test_a_status_word_at_changes_suffices_only_with_a_heartbeat_that_shows_that_the_drive_is_there(
    device, configured, heartbeat, is_timely
):
    if heartbeat is None:
        del device.object_dictionary[0x1017]
    else:
        device.put(0x1017, 0, heartbeat)
        device.refuse[0x1017, 0] = REFUSED
    configuration, source, _ = configured()
    assert source.is_timely is is_timely
    assert configuration.heartbeat == (None if heartbeat is None else heartbeat / 1000.0)


@pytest.mark.parametrize("kind", [254, 255])
def test_an_rpdo_that_counts_as_soon_as_it_comes_stays_as_it_is(device, configured, kind):
    maps(device, 0, VELOCITY)
    device.put(0x1400, 2, kind)
    configuration, _, _ = configured()
    assert configuration.changed == FRESH[1:]
    assert not any(0x1400 <= index < 0x1800 for index, _, _ in device.writes)


@pytest.mark.parametrize("kind", [1, 254])
def test_a_target_that_counts_from_sync_on_is_remarked(device, configured, kind):
    device.put(0x1400, 2, 1)
    device.refuse[0x1400, 2, 255] = REFUSED
    if kind == 1:
        device.refuse[0x1400, 2, 254] = REFUSED
    configuration, _, _ = configured()
    remarks = ["RPDO1 keeps transmission type 1: a target counts from SYNC on"] if kind == 1 else []
    assert configuration.remarks == remarks
    assert f"RPDO1 211h type {kind} maps 60FFh:00 32 bits" in configuration.changed


@pytest.mark.parametrize("start_bit", [0, 16])
def test_a_target_behind_a_control_word_stays_there_and_a_wrong_start_bit_is_remarked(
    device, configured, start_bit
):
    maps(device, 0, CONTROL, VELOCITY)
    configuration, _, target = configured(start_bit=start_bit)
    remark = "RPDO1 carries 60FFh from bit 16 on; say so by start_bit in vehicle.toml"
    assert configuration.remarks == ([] if start_bit == 16 else [remark])
    assert target.start_bit == 16
    assert configuration.changed == FRESH[1:]


@pytest.mark.parametrize(("owner", "chosen"), [(0, 0x1400), (1, 0x1401), (None, 0x1400)])
def test_the_rpdo_that_has_the_cob_id_is_taken_else_the_first(device, configured, owner, chosen):
    for number in range(2):
        device.put(0x1400 + number, 1, 0x211 if number == owner else 0x351 + number)
    configuration, _, _ = configured()
    assert configuration.changed[0] == f"RPDO{chosen - 0x13FF} 211h type 255 maps 60FFh:00 32 bits"


@pytest.mark.parametrize(
    ("kind", "inhibit", "becomes"),
    [
        (255, 0, LONGEST_INHIBIT),
        (254, 0, LONGEST_INHIBIT),
        (255, LONGEST_INHIBIT + 1, LONGEST_INHIBIT),
        (255, 1, 1),
        (255, LONGEST_INHIBIT, LONGEST_INHIBIT),
        (1, 0, 0),
    ],
)
def test_a_status_word_at_every_change_gets_an_inhibit_time(device, configured, kind, inhibit, becomes):
    device.put(0x1800, 2, kind)
    device.put(0x1800, 3, inhibit)
    configuration, source, _ = configured()
    assert source.is_timely
    assert device.number(0x1800, 3) == becomes
    assert device.number(0x1800, 1) == 0x191
    words = f"inhibit time of TPDO1: {inhibit} to {LONGEST_INHIBIT} x 100 us"
    assert (words in configuration.changed) == (inhibit != becomes)


def test_a_tpdo_without_inhibit_time_one_that_is_off_and_an_encoders_stay_as_they_are(device, configured):
    configured(encoder_cob_ids={0x191})
    device.put(0x1800, 1, 0x80000191)
    configured()
    device.put(0x1800, 1, 0x191)
    del device.object_dictionary[0x1800][3]
    configured()
    assert not any(index == 0x1800 for index, _, _ in device.writes)


def test_a_status_word_in_a_tpdo_with_29_bits_is_asked_for_by_sdo(device, configured):
    """The driver receives no such PDO, so that a fault of the drive would not be seen."""
    device.put(0x1800, 1, 0x38FF0191)
    _, source, _ = configured()
    assert (source.fields, source.is_timely) == ((), False)


def test_a_tpdo_without_status_word_is_remarked_and_stays_as_it_is(device, configured):
    device.put(0x1A00, 1, POSITION)
    configuration, source, _ = configured()
    assert configuration.remarks == ["TPDO1 191h type 255 maps 6064h:00 32 bits; its frames count as unknown"]
    assert (source.fields, source.is_timely) == ((), False)
    assert not any(index == 0x1800 for index, _, _ in device.writes)


def test_a_status_word_is_switched_off_for_its_inhibit_time_and_on_again(device, configured):
    """As CiA 301 asks for; also where the device refuses the inhibit time."""
    device.refuse[0x1800, 3] = REFUSED
    configuration, _, _ = configured()
    assert configuration.remarks[0].startswith("inhibit time of TPDO1 stays: ")
    assert device.number(0x1800, 1) == 0x191
    device.refuse.clear()
    configured()
    off, on = (0x1800, 1, 0x80000191), (0x1800, 1, 0x191)
    assert [write for write in device.writes if write[0] == 0x1800] == [off, (0x1800, 3, 200), on] * 2


def test_a_status_word_that_cannot_be_switched_off_stays_as_it_is(device, configured):
    device.refuse[0x1800, 1] = REFUSED
    configuration, _, _ = configured()
    assert configuration.remarks[0].startswith("inhibit time of TPDO1 stays: ")
    assert [write for write in device.writes if write[0] == 0x1800] == [(0x1800, 1, 0x80000191)]


def test_a_watchdog_that_the_drive_lacks_is_remarked(device, configured):
    del device.object_dictionary[0x1016]
    configuration, _, _ = configured()
    assert configuration.remarks[0].startswith("the drive's own watchdog is incomplete: ")
    assert configuration.changed == [*FRESH[:3], FRESH[4]]
