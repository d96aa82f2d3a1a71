"""A bus on which fake devices answer inside `send`: nothing runs beside the test, nothing waits."""

import sys
import threading
from collections import deque
from types import SimpleNamespace

import can
import pytest
from canopen.objectdictionary import UNSIGNED32

from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.canopen.sdo import Sdo
from omnimate.driver.robot.configure import configure_node
from omnimate.driver.robot.driver import Driver
from omnimate.vehicle.parameters import Bus, Drive, Encoder, Linkage, Truck, VehicleParameters
from tests.foreign.devices import (
    SWITCH_ON_DISABLED,
    ForeignDrive,
    ForeignEncoder,
    ForeignNetwork,
    pdo_objects,
)

IDENTITY = {1: 0x123, 2: 0x456, 3: 1}  # vendor, product and revision
DEVICE_TYPE = """[1000]
ParameterName=Device type
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0x00020196
PDOMapping=0
"""  # of an EDS: a CiA 406 encoder


def frame(can_id, data=b"", **kwargs):
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=False, **kwargs)


def encoder_device(node, *more):
    """A CiA 406 encoder as it leaves its factory: TPDO1 cyclic, TPDO2 switched off, no heartbeat.

    `more` are further objects: index, sub-index, type, access and default.
    """
    identity = [(0x1018, sub, UNSIGNED32, "ro", value) for sub, value in IDENTITY.items()]
    serial = (0x1018, 4, UNSIGNED32, "ro", 1000 + node)
    device = ForeignEncoder(node, more=[*identity, serial, (0x6002, 0, UNSIGNED32, "ro", 2**32 - 1), *more])
    device.put(0x1800, 1, 0x40000180 + node)
    device.put(0x1801, 1, 0xC0000280 + node)
    device.put(0x1801, 2, 254)
    device.put(0x1A00, 0, 0)
    device.put(0x1A00, 1, 0)
    return device


def drive_device(node, state=SWITCH_ON_DISABLED, ignored=()):
    """A CiA 402 drive in a state, from which control words lead on that it does not ignore."""
    rpdo2 = pdo_objects(node, 0x1401, [(0x300 + node, 255, ())])
    device = ForeignDrive(node, None, "first", rpdo=(), more=rpdo2)
    device.put(0x1A00, 0, 1)  # the status word alone
    device.status = state
    control = device._control
    device._control = lambda word: word in ignored or control(word)
    return device


class FakeBus(can.BusABC):
    """Hands what is sent to the devices and queues what they answer."""

    def __init__(self, devices=()):
        self.channel_info = "fake"
        self.devices = {device.id: device for device in devices}
        for device in devices:
            if not device.has_network():
                ForeignNetwork()[device.id] = device
            device.network.bus = SimpleNamespace(send=self._take)
        self.sent = []
        self.queue = self._coming = deque()
        self.failing_sends = 0
        self.is_dead = False
        self.lock = threading.Lock()
        self.change = lambda _message, answers: answers
        super().__init__(channel="fake")

    def send(self, msg, timeout=None):
        with self.lock:
            if self.is_dead or self.failing_sends:
                self.failing_sends -= self.failing_sends > 0
                raise can.CanOperationError("no buffer space")
            self.sent.append((msg.arbitration_id, bytes(msg.data)))
            answers = self._coming = []
            for device in self.devices.values():
                device.network.notify(msg.arbitration_id, msg.data, 0.0)
            self._coming = self.queue
            self.queue.extend(self.change(msg, answers))

    def _take(self, message):
        """Take what a device sends, as an answer or by itself."""
        message.timestamp = 1.0
        self._coming.append(message)

    def _recv_internal(self, timeout):
        if self.is_dead:
            raise can.CanOperationError("interface is down")
        return (self.queue.popleft() if self.queue else None), False

    def recv(self, timeout=None):
        return self._recv_internal(timeout)[0]


class FakeClock:
    """Time that moves by one period per SYNC; answers are awaited for sixty reads."""

    skipped = 0

    def __init__(self, period=0.01, inline=True):
        self.period = period
        self.inline = inline
        self.time = 100.0
        self.slept = []
        self.reads = 0

    def due(self):
        return 0.0

    def sync(self):
        self.time += self.period
        self.reads = 60
        return self.time

    def remaining(self):
        self.reads -= 1
        return float(self.reads > 0)

    def now(self):
        return self.time + 0.001

    def frame_time(self, _stamp):
        return self.now()

    def sleep(self, seconds):
        self.slept.append(seconds)
        self.time += seconds


def sdo(devices, node=1):
    """Return the objects of a node on a bus with these devices, and the network that reaches them."""
    network = BusNetwork(FakeBus(devices), FakeClock())
    return network.sdo(node), network


def wheel_encoder(channel, node, **changes):
    values = {
        "cob_id": 0x180 + node,
        "start_bit": 0,
        "bits": 32,
        "signed": False,
        "sign": 1,
        "counts_per_turn": 40000,
    }
    return Encoder(channel=channel, node=node, **(values | changes))


def one_truck(encoders=None, drives=(), period=0.01, **left):
    """Return a robot of one truck, of which the left encoder may differ."""
    encoders = encoders or (wheel_encoder("a.left", 1, **left), wheel_encoder("a.right", 2))
    return VehicleParameters(
        "single", {"a": Truck(0.34, 0.15, 0.15)}, None, Bus(500_000, period), encoders, drives
    )


def two_trucks(period=0.01, **changes):
    """Return a robot of two trucks, all encoders of which are changed alike."""
    names = ("a.left", "a.right", "b.left", "b.right", "joint_a", "joint_b")
    turning = [wheel_encoder(name, node, **changes) for node, name in enumerate(names, 1)]
    link = wheel_encoder("link", 7, counts_per_turn=None, counts_per_metre=10000, **changes)
    trucks = {"a": Truck(0.34, 0.15, 0.15), "b": Truck(0.34, 0.15, 0.15)}
    return VehicleParameters("two", trucks, Linkage(1.0), Bus(500_000, period), (*turning, link))


def drive(wheel, node, sign=1, **changes):
    return Drive(wheel, node, 0x200 + node, sign, 40000, **changes)


def driver_and_bus(*drives, **options):
    """Return a driver of one truck, not configured, and its bus with two encoders and these drives."""
    bus = FakeBus([encoder_device(1), encoder_device(2), *(drive_device(drive.node) for drive in drives)])
    return Driver(one_truck(drives=drives), bus, **({"clock": FakeClock()} | options)), bus


def configured(*drives, **options):
    """Return a driver as `driver_and_bus`, configured, and its bus."""
    driver, bus = driver_and_bus(*drives, **options)
    driver.configure()
    return driver, bus


def configure(device, vehicle=None, **left):
    """Configure node 1, of which the encoder in the vehicle may differ; return the report and the bus."""
    objects, network = sdo([device] if device else [])
    return configure_node(objects, vehicle or one_truck(**left), network.nmt_command), network.can_bus


def words(driver):
    """Return node and words of each event."""
    return [(event.node, event.what) for event in driver.report().events]


@pytest.fixture
def kit():
    """This module: fakes to build with."""
    return sys.modules[__name__]


@pytest.fixture
def device():
    """An encoder, node 1."""
    return encoder_device(1)


@pytest.fixture(name="sdo")
def sdo_of_device(device):
    """The objects of the encoder."""
    return sdo([device])[0]


@pytest.fixture
def _impatient(monkeypatch):
    """SDO time-outs that are over at once, for tests in which a node is silent."""
    timeout = property(lambda _client: 0.0, lambda _client, _seconds: None)  # whatever the vehicle says
    monkeypatch.setattr(Sdo, "RESPONSE_TIMEOUT", timeout)
