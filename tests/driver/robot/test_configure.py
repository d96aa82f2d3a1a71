"""A node as it is configured: its PDO, its wrap range, and what is reported."""

from dataclasses import replace

import pytest
from canopen.objectdictionary import UNSIGNED32
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.errors import BusOverload, WrongDevice
from omnimate.driver.robot.configure import choose_range, with_ranges
from omnimate.driver.robot.driver import Driver
from omnimate.vehicle.parameters import Bus, Encoder


def test_a_factory_fresh_encoder_answers_sync_afterwards(kit, device):
    report, bus = kit.configure(device)
    assert device.number(0x1800, 1) == 0x40000181
    assert device.number(0x1800, 2) == 1
    assert device.number(0x1A00) == 1
    assert device.number(0x1A00, 1) == 0x60040020
    assert device.number(0x1017) == 500
    assert report.lengths == {0x181: 4}
    assert report.heartbeat == 0.5
    assert "TPDO1 181h type 1 maps 6004h:00 32 bits" in report.changed
    assert (0x000, b"\x80\x01") in bus.sent


def test_a_pdo_is_mapped_in_the_order_of_cia_301_and_keeps_bit_30(kit, device):
    kit.configure(device)
    mapping = [write for write in device.writes if write[0] in {0x1800, 0x1A00}]
    assert mapping == [
        (0x1800, 1, 0xC0000181),
        (0x1800, 2, 1),
        (0x1A00, 1, 0x60040020),
        (0x1A00, 0, 1),
        (0x1800, 1, 0x40000181),
    ]


@pytest.mark.parametrize("raw", [0x20000181, 0x38FF0181])
def test_a_pdo_with_29_bits_gets_the_11_bits_of_vehicle_toml(kit, device, raw):
    """Also where its lower bits are those of `vehicle.toml`: its frames would never be received."""
    kit.configure(device)
    device.put(0x1800, 1, raw)
    report, _ = kit.configure(device)
    assert device.number(0x1800, 1) == 0x181
    assert "TPDO1 181h type 1 maps 6004h:00 32 bits" in report.changed


def test_inhibit_time_and_event_timer_are_cleared(kit, device):
    device.put(0x1800, 3, 100)
    device.put(0x1800, 5, 50)
    kit.configure(device)
    assert device.number(0x1800, 3) == device.number(0x1800, 5) == 0


def test_a_device_that_is_right_already_is_left_alone(kit, device):
    kit.configure(device)
    device.writes.clear()
    report, bus = kit.configure(device)
    assert device.writes == []
    assert report.changed == []
    assert not [data for can_id, data in bus.sent if can_id == 0]


def test_a_tpdo_that_only_fills_the_bus_is_switched_off(kit, device):
    device.put(0x1801, 1, 0x281)
    report, _ = kit.configure(device)
    assert device.number(0x1801, 1) == 0x80000281
    assert "TPDO2 281h switched off" in report.changed


def test_tpdo2_is_used_where_no_tpdo_has_the_cob_id(kit, device):
    kit.configure(device, cob_id=0x1A1)
    assert device.number(0x1801, 1) & 0x800007FF == 0x1A1
    assert device.number(0x1800, 1) >> 31


@pytest.mark.parametrize("key", ["vendor", "product", "serial"])
def test_another_identity_is_refused_before_anything_is_written(kit, device, key):
    with pytest.raises(WrongDevice, match=key) as caught:
        kit.configure(device, **{key: 9})
    assert caught.value.key == key
    assert device.writes == []


def test_a_device_without_a_profile_is_taken_with_a_remark(kit, device):
    device.put(0x1000, 0, 0)
    report, _ = kit.configure(device)
    assert any("1000h states profile 0" in remark for remark in report.remarks)


def test_650bh_stands_in_for_a_missing_serial_number(kit):
    device = kit.encoder_device(1, (0x650B, 0, UNSIGNED32, "ro", 77))
    del device.object_dictionary[0x1018][4]
    report, _ = kit.configure(device, serial=77)
    assert any("650Bh" in remark for remark in report.remarks)


def test_a_device_that_produces_sync_itself_is_silenced(kit, device):
    device.put(0x1005, 0, 0x40000080)
    report, _ = kit.configure(device)
    assert device.number(0x1005) == 0x80
    assert any("1005h" in change for change in report.changed)


def two_on_one(kit, **changes):
    return kit.one_truck(
        (
            kit.wheel_encoder("a.left", 1, cob_id=0x181, start_bit=0, **changes),
            kit.wheel_encoder("a.right", 1, cob_id=0x181, start_bit=32, **changes),
        )
    )


def test_two_channels_of_one_encoder_are_6020h_in_order(kit, device):
    report, _ = kit.configure(device, two_on_one(kit))
    assert [device.number(0x1A00, n) for n in (0, 1, 2)] == [2, 0x60200120, 0x60200220]
    assert report.lengths == {0x181: 8}


def test_two_axes_of_one_drive_are_6064h_and_6864h(kit):
    device = kit.drive_device(1)
    kit.configure(device, two_on_one(kit, profile="cia402"))
    assert [device.number(0x1A00, n) for n in (0, 1, 2)] == [2, 0x60640020, 0x68640020]


def test_a_gap_is_filled_with_the_status_word(kit, device):
    report, _ = kit.configure(device, start_bit=24)
    assert [device.number(0x1A00, n) for n in range(4)] == [3, 0x65000010, 0x10010008, 0x60040020]
    assert report.lengths == {0x181: 7}


def test_a_gap_is_filled_with_a_dummy_where_the_status_cannot_be_mapped(kit, device):
    device.refuse[0x1A00, 1, 0x65000010] = 0x06040041
    kit.configure(device, start_bit=16)
    assert [device.number(0x1A00, n) for n in range(3)] == [2, 0x00060010, 0x60040020]


@pytest.mark.parametrize(
    ("reported", "stated", "chosen", "words"),
    [
        (2**32 - 1, None, 2**32, "means N - 1"),
        (0, None, 2**32, "6002h says 0"),
        (4096, 4096, 4096, "means N"),
        (4095, 4096, 4096, "means N - 1"),
        (None, None, 2**32, "no 6002h"),
        (2**24 - 1, None, 2**24, "taken for N - 1"),
        (2**24, None, 2**24, "taken for N"),
        (8192, 4096, 4096, "vehicle.toml 4096"),
    ],
)
def test_the_wrap_range_is_chosen_per_node_and_stated(kit, device, reported, stated, chosen, words):
    if reported is None:
        del device.object_dictionary[0x6002]
    else:
        device.put(0x6002, 0, reported)
    vehicle = kit.one_truck(range=stated)
    report, _ = kit.configure(device, vehicle)
    assert report.ranges == {"a.left": chosen}
    assert any(words in remark for remark in report.remarks)
    assert with_ranges(vehicle, [report]).encoder("a.left").wrap_range == chosen


def test_an_overload_is_refused_before_anything_is_sent(kit):
    bus = kit.FakeBus([kit.encoder_device(1), kit.encoder_device(2)])
    vehicle = replace(kit.one_truck(), bus=Bus(10_000, 0.01))
    with pytest.raises(BusOverload):
        Driver(vehicle, bus, clock=kit.FakeClock()).configure()
    assert bus.sent == []


def test_the_report_has_the_load_and_a_line_for_everything(kit):
    report = kit.driver_and_bus()[0].configure()
    assert "bus load forecast" in report.load.in_words()
    assert [node.node for node in report.nodes] == [1, 2]
    assert report.nodes[0].names == ("a.left",)
    assert ("changed", "heartbeat 1017h: 0 ms to 500 ms") in report.nodes[0].lines()


widths = st.integers(8, 32)


def encoder(bits, **changes):
    return Encoder("a.left", 1, 0x181, 0, bits, signed=False, sign=1, counts_per_turn=4096.0, **changes)


@given(widths, st.one_of(st.none(), st.integers(0, 2**32 - 1)), st.booleans())
def test_the_chosen_range_never_exceeds_the_field_and_is_stated(bits, reported, is_stated):
    wheel = encoder(bits, **({"range": 2 ** (bits - 1)} if is_stated else {}))
    chosen, reason = choose_range(wheel, reported)
    assert 1 < chosen <= 2**bits
    assert reason.startswith("a.left: ")
    assert str(chosen) in reason or "2**32" in reason


@given(widths, st.integers(0, 2**32 - 1))
def test_a_range_in_vehicle_toml_always_wins(bits, reported):
    wheel = encoder(bits, range=2 ** (bits - 1))
    assert choose_range(wheel, reported)[0] == 2 ** (bits - 1)


@given(st.integers(2, 31))
def test_a_vendor_that_means_n_and_one_that_means_n_minus_1_give_the_same_range(exponent):
    wheel = encoder(32)
    assert choose_range(wheel, 2**exponent)[0] == choose_range(wheel, 2**exponent - 1)[0] == 2**exponent


@given(widths)
def test_a_device_that_reports_nothing_wraps_as_vehicle_toml_says(bits):
    wheel = encoder(bits)
    assert choose_range(wheel, None)[0] == wheel.wrap_range
