"""A node is the device that `vehicle.toml` means where everything that it states agrees."""

from itertools import product

import pytest
from canopen.objectdictionary import UNSIGNED32
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.canopen.node_setup import (
    DRIVE_HEARTBEAT_MS,
    HEARTBEAT_MS,
    LONGEST_MS,
    SHORTEST_MS,
    NodeConfiguration,
    check_identity,
    read_encoder,
    set_heartbeat,
)
from omnimate.driver.errors import NodeMissing, WrongDevice

RIGHT = {"vendor": 0x123, "product": 0x456, "serial": 1001}


def check(kit, device, **stated):
    configuration = NodeConfiguration(1, ("a.left",))
    sdo, _ = kit.sdo([device] if device else [])
    check_identity(sdo, kit.wheel_encoder("a.left", 1, **stated), configuration)
    return configuration


@pytest.mark.parametrize("stated", [*product([None, "right", "wrong"], repeat=3)])
def test_a_device_is_accepted_exactly_where_no_stated_value_differs(kit, stated):
    values = {
        key: None if kind is None else RIGHT[key] + (kind == "wrong")
        for key, kind in zip(RIGHT, stated, strict=True)
    }
    device = kit.encoder_device(1)
    if "wrong" in stated:
        with pytest.raises(WrongDevice) as caught:
            check(kit, device, **values)
        assert caught.value.key == list(RIGHT)[stated.index("wrong")]
    else:
        check(kit, device, **values)
    assert device.writes == []


@pytest.mark.parametrize("profile", ["cia406", "cia402"])
def test_the_profile_must_be_that_of_1000h(kit, profile):
    device = kit.encoder_device(1) if profile == "cia402" else kit.drive_device(1)
    with pytest.raises(WrongDevice) as caught:
        check(kit, device, profile=profile)
    assert (caught.value.key, caught.value.expected) == ("profile", profile)
    assert caught.value.actual != profile


def test_everything_that_was_read_is_noted_with_its_object(kit):
    text = "\n".join(check(kit, kit.encoder_device(1)).read)
    assert "device type 1000h = 00020196h" in text
    for place in ("vendor 1018h:01 = 291", "product 1018h:02 = 1110", "serial 1018h:04 = 1001"):
        assert place in text


@pytest.mark.usefixtures("_impatient")
def test_a_node_that_does_not_answer_is_missing(kit):
    with pytest.raises(NodeMissing) as caught:
        check(kit, None)
    assert (caught.value.node, caught.value.names) == (1, ("a.left",))


def test_of_a_drive_only_the_presence_is_checked(kit):
    configuration = NodeConfiguration(1, ("drive of a.left",))
    check_identity(kit.sdo([kit.drive_device(1)])[0], None, configuration)
    assert configuration.read == ["device type 1000h = 00020192h"]


def test_an_encoder_reports_the_optional_objects_that_it_has(kit):
    objects = [(0x6001, 0, UNSIGNED32, "ro", 3000), (0x6509, 0, UNSIGNED32, "ro", 12)]
    device, configuration = kit.encoder_device(1, *objects), NodeConfiguration(1, ("a.left",))
    wheel = kit.wheel_encoder("a.left", 1, counts_per_turn=40000)
    read_encoder(kit.sdo([device])[0], [wheel], configuration)
    assert configuration.encoder_objects == {0x6000: 0, 0x6001: 3000, 0x6500: 0, 0x6509: 12}
    assert any("preset" in remark for remark in configuration.remarks)
    assert any("offset 6509h = 12" in remark for remark in configuration.remarks)
    assert any("is no multiple of the 3000 units per turn" in remark for remark in configuration.remarks)


@pytest.mark.parametrize(
    ("wanted", "longest"), [(HEARTBEAT_MS, LONGEST_MS), (DRIVE_HEARTBEAT_MS, DRIVE_HEARTBEAT_MS)]
)
@given(before=st.integers(0, 0xFFFF))
def test_the_period_is_within_the_bounds_afterwards_and_only_changed_where_it_was_not(
    kit, before, wanted, longest
):
    device, configuration = kit.encoder_device(1), NodeConfiguration(1, ("a.left",))
    device.put(0x1017, 0, before)
    set_heartbeat(kit.sdo([device])[0], configuration, wanted, longest)
    after = device.number(0x1017)
    assert SHORTEST_MS <= after <= longest
    assert configuration.heartbeat == after / 1000.0
    assert (after == before) == (SHORTEST_MS <= before <= longest)
    assert bool(configuration.changed) == (after != before)


@pytest.mark.parametrize(("before", "period"), [(0, None), (5, 0.005), (5000, 5.0)])
def test_a_refusal_leaves_the_period_as_it_is_with_a_remark(device, sdo, before, period):
    configuration = NodeConfiguration(1, ("a.left",))
    device.put(0x1017, 0, before)
    device.refuse[0x1017, 0] = 0x06010002
    set_heartbeat(sdo, configuration)
    assert configuration.heartbeat == period
    assert "read-only" in configuration.remarks[0]


def test_a_device_without_a_heartbeat_is_remarked(device, sdo):
    configuration = NodeConfiguration(1, ("a.left",))
    del device.object_dictionary[0x1017]
    set_heartbeat(sdo, configuration)
    assert configuration.heartbeat is None
    assert "1017h" in configuration.remarks[0]
