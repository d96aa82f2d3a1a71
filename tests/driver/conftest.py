"""A bus on which fake devices answer inside `send`: nothing runs beside the test, nothing waits."""

import sys
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace

import can
import canopen
import pytest

from omnimate.driver.canopen.dictionary import standard_dictionary
from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.canopen.sdo import Sdo
from omnimate.driver.robot.configure import configure_node
from omnimate.driver.robot.driver import Driver
from omnimate.vehicle.parameters import Bus, Drive, Encoder, Linkage, Truck, VehicleParameters
from tests.foreign.devices import ForeignNetwork

ABSENT, NO_SUB, READ_ONLY = 0x06020000, 0x06090011, 0x06010002
SWITCH_ON_DISABLED, READY, SWITCHED_ON, ENABLED, FAULT = 0x0240, 0x0221, 0x0223, 0x0227, 0x0208
QUICK_STOP_ACTIVE, FAULT_REACTION = 0x0207, 0x020F
DEVICE_TYPE = """[1000]
ParameterName=Device type
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0x00020196
PDOMapping=0
"""  # of an EDS: a CiA 406 encoder
# Control word by state, and the state that follows: CiA 402, transitions 2 to 8, 12, 15.
TRANSITIONS = {
    (SWITCH_ON_DISABLED, 0x06): READY,
    (READY, 0x07): SWITCHED_ON,
    (SWITCHED_ON, 0x0F): ENABLED,
    (SWITCHED_ON, 0x06): READY,
    (ENABLED, 0x06): READY,
    (ENABLED, 0x07): SWITCHED_ON,
    (FAULT, 0x80): SWITCH_ON_DISABLED,
    (QUICK_STOP_ACTIVE, 0x00): SWITCH_ON_DISABLED,
}


def frame(can_id, data=b"", **kwargs):
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=False, **kwargs)


@dataclass
class FakeDevice:
    """SDO server (expedited), NMT slave and TPDOs on SYNC; `objects` maps (index, sub) to [value, size]."""

    node: int
    objects: dict = field(default_factory=dict)
    position: int = 0
    state: int = 0x7F
    refuse: dict = field(default_factory=dict)  # (index, sub) -> abort code on write
    refuse_read: dict = field(default_factory=dict)  # (index, sub) -> abort code on read
    mute: bool = False
    deaf_to_sync: bool = False
    writes: list = field(default_factory=list)
    on_write: Callable | None = None

    def put(self, index, sub, value, size):
        self.objects[index, sub] = [value, size]

    def boot(self):
        self.state = 0x7F
        return [frame(0x700 + self.node, b"\x00")]

    def handle(self, message):
        can_id, data = message.arbitration_id, bytes(message.data)
        if self.mute:
            return []
        if can_id == 0x000 and data[1] in {0, self.node}:
            self.state = {1: 5, 2: 4, 0x80: 0x7F}.get(data[0], self.state)
        if can_id == 0x600 + self.node:
            answer = self.sdo(data)
            return [frame(0x580 + self.node, answer)] if answer else []
        if can_id == 0x080 and not self.deaf_to_sync:
            return self.pdos()
        return []

    def sdo(self, request):
        index, sub = int.from_bytes(request[1:3], "little"), request[3]
        head = request[1:4]
        if request[0] & 0xE0 == 0x40:
            entry = self.objects.get((index, sub))
            if (index, sub) in self.refuse_read:
                return b"\x80" + head + self.refuse_read[index, sub].to_bytes(4, "little")
            if entry is None:
                known = any(known_index == index for known_index, _ in self.objects)
                return b"\x80" + head + (NO_SUB if known else ABSENT).to_bytes(4, "little")
            value, size = entry
            return (
                bytes([0x43 | (4 - size) << 2])
                + head
                + (value % 256**size).to_bytes(size, "little").ljust(4, b"\0")
            )
        if request[0] == 0x80:
            return b""
        size = 4 - (request[0] >> 2 & 3)
        value = int.from_bytes(request[4 : 4 + size], "little")
        self.writes.append((index, sub, value))
        code = self.refuse.get((index, sub)) or self.refuse.get((index, sub, value))
        entry = self.objects.get((index, sub))
        if code is None and entry is None:
            code = ABSENT
        if code is None and entry[1] != size:
            code = 0x06070010
        if code is not None:
            return b"\x80" + head + code.to_bytes(4, "little")
        entry[0] = value
        if self.on_write:
            self.on_write(index, sub, value)
        return b"\x60" + head + bytes(4)

    def pdos(self):
        frames = []
        for base in range(0x1800, 0x1804):
            raw = self.objects.get((base, 1))
            if self.state != 5 or raw is None or raw[0] >> 31 or self.objects[base, 2][0] != 1:
                continue
            word = bit = 0
            for number in range(1, self.objects[base + 0x200, 0][0] + 1):
                entry = self.objects[base + 0x200, number][0]
                word |= (self.value_of(entry >> 16, entry >> 8 & 0xFF) % (1 << (entry & 0xFF))) << bit
                bit += entry & 0xFF
            frames.append(frame(raw[0] & 0x7FF, word.to_bytes((bit + 7) // 8, "little"), timestamp=1.0))
        return frames

    def value_of(self, index, sub):
        if index in {0x6004, 0x6064}:
            return self.position
        return self.objects.get((index, sub), [0])[0]


def add_pdos(device, base, count, cob_ids, kind):
    for number in range(count):
        device.put(base + number, 0, 5, 1)
        device.put(base + number, 1, cob_ids[number], 4)
        device.put(base + number, 2, kind, 1)
        device.put(base + number, 3, 0, 2)
        device.put(base + number, 5, 0, 2)
        device.put(base + 0x200 + number, 0, 0, 1)
        for entry in range(1, 5):
            device.put(base + 0x200 + number, entry, 0, 4)


def encoder_device(node):
    """A CiA 406 encoder as it leaves its factory: TPDO1 cyclic, TPDO2 switched off, no heartbeat."""
    device = FakeDevice(node)
    device.put(0x1000, 0, 0x00020196, 4)
    device.put(0x1001, 0, 0, 1)
    device.put(0x1005, 0, 0x80, 4)
    device.put(0x1017, 0, 0, 2)
    device.put(0x1018, 0, 4, 1)
    for sub, value in ((1, 0x123), (2, 0x456), (3, 1), (4, 1000 + node)):
        device.put(0x1018, sub, value, 4)
    device.put(0x6002, 0, 2**32 - 1, 4)
    device.put(0x6004, 0, 0, 4)
    device.put(0x6500, 0, 0, 2)
    add_pdos(device, 0x1800, 2, [0x40000180 + node, 0xC0000280 + node], 254)
    return device


def drive_device(node, state=SWITCH_ON_DISABLED, ignored=()):
    """A CiA 402 drive in a state, from which control words lead on that it does not ignore."""
    device = FakeDevice(node)
    device.put(0x1000, 0, 0x00020192, 4)
    device.put(0x1016, 1, 0, 4)
    device.put(0x1017, 0, 0, 2)
    for index, size in ((0x6007, 2), (0x6040, 2), (0x6041, 2), (0x6060, 1), (0x6061, 1), (0x60FF, 4)):
        device.put(index, 0, 0, size)
    device.put(0x6041, 0, state, 2)
    add_pdos(device, 0x1400, 2, [0x200 + node, 0x300 + node], 255)
    add_pdos(device, 0x1800, 1, [0x180 + node], 255)
    device.put(0x1A00, 0, 1, 1)
    device.put(0x1A00, 1, 0x60410010, 4)
    device.refuse[0x6041, 0] = READ_ONLY

    def follow(index, _sub, value):
        status = device.objects[0x6041, 0]
        if index == 0x6040 and value not in ignored:
            status[0] = TRANSITIONS.get((status[0], value), status[0])
        if index == 0x6060:
            device.objects[0x6061, 0][0] = value

    device.on_write = follow
    return device


class FakeBus(can.BusABC):
    """Hands what is sent to the devices and queues what they answer."""

    def __init__(self, devices=()):
        self.channel_info = "fake"
        self.devices = {device.node: device for device in devices}
        self.sent = []
        self.queue = deque()
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
            answers = [answer for device in self.devices.values() for answer in device.handle(msg)]
            self.queue.extend(self.change(msg, answers))

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


class LocalDevice:
    """canopen's own SDO server, so that the driver is not only tested against this file's."""

    def __init__(self, node):
        self.node, self.sent = node, []
        self.network = ForeignNetwork(SimpleNamespace(send=self.sent.append))
        self.local = canopen.LocalNode(node, standard_dictionary())
        self.local.associate_network(self.network)

    def handle(self, message):
        self.sent.clear()
        self.network.notify(message.arbitration_id, bytearray(message.data), 0.0)
        return [*self.sent]


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
def _impatient(monkeypatch):
    """SDO time-outs that are over at once, for tests in which a node is silent."""
    timeout = property(lambda _client: 0.0, lambda _client, _seconds: None)  # whatever the vehicle says
    monkeypatch.setattr(Sdo, "RESPONSE_TIMEOUT", timeout)
