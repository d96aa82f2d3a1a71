"""The network: what is sent and received is recorded in order, and an interface that fails is a lost bus."""

import pytest
from canopen.objectdictionary import ObjectDictionary, ODVariable
from canopen.objectdictionary.datatypes import UNSIGNED16

from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.errors import BusLost
from omnimate.files.logs.canopen_words import NMT_START


class Sink:
    def __init__(self):
        self.frames = []

    def use(self, vehicle):
        pass

    def frame(self, at, message):
        self.frames.append((at, message.arbitration_id, bytes(message.data), message.is_rx))


@pytest.fixture
def sink():
    return Sink()


@pytest.fixture
def network(kit, sink):
    return BusNetwork(kit.FakeBus([kit.encoder_device(1)]), kit.FakeClock(), sink)


def test_frames_are_recorded_in_the_order_of_the_bus_with_their_direction(network, sink):
    network.nmt_command(NMT_START, 1)
    network.send_message(0x601, b"\x40\x00\x10\0\0\0\0\0")
    network.pump(0.0)
    assert [(can_id, is_rx) for _, can_id, _, is_rx in sink.frames] == [
        (0x000, False),
        (0x601, False),
        (0x581, True),
    ]


def test_sync_is_recorded_at_the_time_of_the_sample(network, sink):
    network.send_sync(123.0)
    assert sink.frames == [(123.0, 0x080, b"", False)]


def test_pump_hands_each_frame_to_the_handler_with_its_arrival(kit, network):
    seen = []
    network.handler = lambda message, arrival: seen.append((message.arbitration_id, arrival))
    network.can_bus.queue.append(kit.frame(0x181))
    network.pump(0.0)
    network.pump(0.0)
    assert seen == [(0x181, network.arrival)]


def test_a_frame_that_could_not_be_sent_is_not_recorded(network, sink):
    network.can_bus.failing_sends = 1
    with pytest.raises(BusLost, match="no buffer space"):
        network.send_message(0x601, bytes(8))
    assert sink.frames == []


def test_after_the_bus_was_replaced_frames_go_to_the_new_one(kit, network):
    old, new = network.can_bus, kit.FakeBus()
    network.replace_bus(new)
    network.send_message(0x123, b"\x01")
    assert (len(old.sent), new.sent) == (0, [(0x123, b"\x01")])


def test_a_node_with_an_eds_is_read_with_the_sizes_of_its_eds(kit):
    """Without the file 2000h is written with 4 bytes, which is the standard size of an unknown object."""
    dictionary, variable = ObjectDictionary(), ODVariable("vendor's object", 0x2000, 0)
    variable.data_type = UNSIGNED16
    dictionary.add_object(variable)
    device = kit.encoder_device(1, (0x2000, 0, UNSIGNED16, "rw", 0))
    network = BusNetwork(kit.FakeBus([device]), kit.FakeClock())
    network.sdo(1, {1: dictionary}).put(0x2000, 0, 7)
    assert device.number(0x2000) == 7
    assert len([data for can_id, data in network.can_bus.sent if data[0] & 0xE0 == 0x20]) == 1
