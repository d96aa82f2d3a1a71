"""The bus in one thread: answers are there when `send` returns, in the order of the bus."""

import can
import pytest

from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.faults import Silence
from omnimate.vcan_sim.reference import reference_vehicle


@pytest.fixture
def bus(bench):
    with CoupledBus(bench.vehicle, bench.plant, [Silence(node=2, at=0.015)]) as bus:
        yield bus


def received(bus):
    frames = []
    while (message := bus.recv(0.0)) is not None:
        assert message.timestamp > 0.0
        assert not message.is_extended_id
        frames.append((message.arbitration_id, bytes(message.data)))
    return frames


def send(bus, can_id, data=b""):
    bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))


def test_boot_ups_wait_and_answers_are_there_at_once(bus, bench):
    nodes = [encoder.node for encoder in reference_vehicle().encoders] + [11, 12, 13, 14]
    assert received(bus) == [(0x700 + node, b"\0") for node in nodes]
    send(bus, 0x601, b"\x40\x00\x10\x00" + bytes(4))
    assert received(bus) == [(0x581, b"\x43\x00\x10\x00\x96\x01\x02\x00")]
    send(bus, 0x000, b"\x01\x01")
    bench.plant.counts = (9,) * 7
    send(bus, 0x080)
    assert (0x281, b"\x09\0\0\0") in received(bus)


def test_faults_run_on_the_clock_of_syncs(bus):
    send(bus, 0x080)
    received(bus)
    send(bus, 0x602, b"\x40\x00\x10\x00" + bytes(4))
    assert received(bus) == []


def test_waiting_for_ever_where_nothing_can_come_is_an_error(bus):
    received(bus)
    assert bus.recv(0.001) is None
    with pytest.raises(can.CanOperationError, match="receive with a timeout"):
        bus.recv(None)
