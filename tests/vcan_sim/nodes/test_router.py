"""Which device gets which frame."""

from types import SimpleNamespace

import can
import pytest

from omnimate.vcan_sim.nodes.router import Router


class Device:
    """A device that keeps the calls that it gets."""

    def __init__(self, node, *rpdos):
        self.node, self.rpdos, self.calls = node, rpdos, []

    def __getattr__(self, name):
        return lambda *values: self.calls.append((name, *values))


def rpdo(cob_id, *, valid=True):
    return SimpleNamespace(cob_id=cob_id, valid=valid)


@pytest.fixture
def devices():
    return Device(1, rpdo(0x201)), Device(2, rpdo(0x201), rpdo(0x302)), Device(3, rpdo(0x302, valid=False))


def frame(can_id, data=b""):
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=False)


def test_a_pdo_goes_to_every_device_with_a_valid_rpdo_of_its_cob_id(devices):
    Router(devices).receive(frame(0x201, b"\x01\x02"), 5.0)
    first, second, third = (device.calls for device in devices)
    assert first == [("on_rpdo", devices[0].rpdos[0], b"\x01\x02", 5.0)]
    assert second == [("on_rpdo", devices[1].rpdos[0], b"\x01\x02", 5.0)]
    assert third == []


def test_a_pdo_is_looked_up_again_after_a_configuration_by_sdo(devices):
    router = Router(devices)
    router.receive(frame(0x302), 0.0)
    devices[2].rpdos[0].valid = True
    router.receive(frame(0x302), 1.0)
    assert devices[2].calls == []
    router.receive(frame(0x603, bytes(8)), 2.0)
    router.receive(frame(0x302), 3.0)
    assert devices[2].calls[-1][0] == "on_rpdo"
