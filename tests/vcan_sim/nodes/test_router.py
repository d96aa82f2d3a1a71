"""Which device gets which frame."""

from types import SimpleNamespace

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


def calls_of(devices, can_id, data=b"\x01\x02"):
    router = Router(devices)
    router.receive(can_id, data, 5.0)
    return [device.calls for device in devices]


def test_a_pdo_goes_to_every_device_with_a_valid_rpdo_of_its_cob_id(devices):
    first, second, third = calls_of(devices, 0x201)
    assert first == [("on_rpdo", devices[0].rpdos[0], b"\x01\x02", 5.0)]
    assert second == [("on_rpdo", devices[1].rpdos[0], b"\x01\x02", 5.0)]
    assert third == []


def test_a_pdo_is_looked_up_again_after_a_configuration_by_sdo(devices):
    router = Router(devices)
    router.receive(0x302, b"", 0.0)
    devices[2].rpdos[0].valid = True
    router.receive(0x302, b"", 1.0)
    assert devices[2].calls == []
    router.receive(0x603, bytes(8), 2.0)
    router.receive(0x302, b"", 3.0)
    assert devices[2].calls[-1][0] == "on_rpdo"
