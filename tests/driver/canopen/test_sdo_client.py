"""The SDO client: late answers about another object are dropped, and no dialogue is without an end."""

from __future__ import annotations

import pytest

from omnimate.driver.canopen.sdo import TRIES
from omnimate.driver.canopen.sdo_client import MAX_RESPONSES
from omnimate.driver.errors import SdoSilent


def answer(kit, index, value, node=1):
    return kit.frame(
        0x580 + node, b"\x43" + index.to_bytes(2, "little") + b"\0" + value.to_bytes(4, "little")
    )


def test_a_late_answer_about_another_object_is_not_taken_for_this_one(kit):
    """canopen's own client takes any answer."""
    sdo, network = kit.sdo([kit.encoder_device(1)])
    late = answer(kit, 0x6004, 99)
    network.can_bus.change = lambda _message, answers: [late, *answers]
    assert sdo.read(0x1000) == 0x00020196


def test_answers_of_another_node_are_not_taken(kit):
    sdo, network = kit.sdo([kit.encoder_device(1)])
    foreign = answer(kit, 0x1000, 99, node=2)
    network.can_bus.change = lambda _message, answers: [foreign, *answers]
    assert sdo.read(0x1000) == 0x00020196


@pytest.mark.usefixtures("_impatient")
def test_an_endless_segmented_answer_is_given_up(kit):
    device = kit.encoder_device(1)
    sdo, network = kit.sdo([device])
    segments = 0

    def endless(message, _answers):
        nonlocal segments
        segments += 1
        command = message.data[0]
        if command == 0x80:  # the client gives up
            return []
        if command & 0xE0 == 0x40:  # initiate upload: a segmented transfer of unknown size
            return [kit.frame(0x581, b"\x40" + bytes(message.data[1:4]) + bytes(4))]
        return [kit.frame(0x581, bytes([command & 0x10]) + b"1234567")]

    network.can_bus.change = endless
    with pytest.raises(SdoSilent):
        sdo.read(0x1008)
    assert segments < (TRIES + 1) * MAX_RESPONSES
