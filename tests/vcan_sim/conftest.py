"""A bench for simulated devices: no thread, no clock but the number of SYNCs."""

from collections import deque
from dataclasses import replace

import can
import pytest

from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulated_vehicle import SimulatedVehicle
from omnimate.vehicle.file import parse_vehicle


class FakePlant:
    """Counts steps; the test sets the raw counts and sees the wheel speeds."""

    def __init__(self, vehicle):
        self.counts = tuple(encoder.zero for encoder in vehicle.encoders)
        self.speeds = None
        self.steps = []

    def step(self, wheel_speeds, dt):
        self.speeds = tuple(wheel_speeds)
        self.steps.append(dt)

    def raw_counts(self):
        return self.counts


class ListBus(can.BusABC):
    """A bus that keeps what is sent."""

    def __init__(self):
        self.sent = []
        self.waiting = deque()
        super().__init__(channel="list")
        self._is_shutdown = True  # there is nothing to shut down

    def send(self, msg, timeout=None):
        self.sent.append((msg.arbitration_id, bytes(msg.data)))

    def _recv_internal(self, timeout):
        return (self.waiting.popleft() if self.waiting else None), False


class SdoAbortedError(Exception):
    def __init__(self, code):
        super().__init__(f"{code:08X}h")
        self.code = code


class Bench:
    """Speaks to the devices as a master would, by raw frames."""

    def __init__(self, vehicle=None, clock="sync", faults=(), wheel_speeds=None):
        self.vehicle = vehicle or reference_vehicle()
        self.plant = FakePlant(self.vehicle)
        self.bus = ListBus()
        self.simulated = SimulatedVehicle(self.vehicle, self.plant, self.bus, clock, faults, wheel_speeds)
        self.boot_ups = self.take()

    def take(self):
        """Return what the devices have sent since the last time."""
        sent, self.bus.sent = self.bus.sent, []
        return sent

    def frame(self, can_id, data=b"", **flags):
        message = can.Message(arbitration_id=can_id, data=data, **{"is_extended_id": False, **flags})
        self.bus.waiting.append(message)
        self.simulated.poll()

    def sync(self, times=1, *, count=None):
        """Send SYNC while all encoders show a count."""
        if count is not None:
            self.plant.counts = (count,) * len(self.plant.counts)
        for _ in range(times):
            self.frame(0x080)

    def nmt(self, command, node=0):
        self.frame(0x000, bytes([command, node]))

    def request(self, node, request):
        """Return the one answer to an SDO request, None where there is none; other frames stay."""
        before = self.take()
        self.frame(0x600 + node, request)
        answers = [data for can_id, data in self.bus.sent if can_id == 0x580 + node]
        self.bus.sent = before + [frame for frame in self.bus.sent if frame[0] != 0x580 + node]
        assert len(answers) <= 1
        return answers[0] if answers else None

    def read(self, node, index, sub=0):
        """Return an object of at most 4 bytes, unsigned."""
        answer = self._checked(node, bytes([0x40, index & 0xFF, index >> 8, sub]) + bytes(4))
        return int.from_bytes(answer[4 : 8 - (answer[0] >> 2 & 3)], "little")

    def write(self, node, index, sub, value, size):
        head = bytes([0x23 | (4 - size) << 2, index & 0xFF, index >> 8, sub])
        self._checked(node, head + (value & 256**size - 1).to_bytes(size, "little").ljust(4, b"\0"))

    def aborts(self, node, index, sub, value, size):
        """Return the abort code of a write, None where it is accepted."""
        try:
            self.write(node, index, sub, value, size)
        except SdoAbortedError as aborted:
            return aborted.code
        return None

    def _checked(self, node, request):
        answer = self.request(node, request)
        assert answer is not None, "no answer"
        assert len(answer) == 8
        assert answer[1:4] == request[1:4]
        if answer[0] == 0x80:
            raise SdoAbortedError(int.from_bytes(answer[4:], "little"))
        return answer

    def answer_sync(self, node, tpdo=1, index=0x1800):
        """Have a TPDO answer every SYNC and switch the others off, then start the node."""
        self.nmt(0x80, node)
        for other in (0x1800, 0x1801):
            self.write(node, other, 1, 0xC000_0180 + (other & 1) * 0x100 + node, 4)
        self.write(node, index, 2, tpdo, 1)
        self.write(node, index, 1, 0x4000_0180 + (index & 1) * 0x100 + node, 4)
        self.nmt(0x01, node)
        self.take()

    def map_pdo(self, node, index, entries, cob_id, kind=None):
        """Map objects into a PDO, 1600h or 1A00h, in the order of CiA 301."""
        self.write(node, index - 0x200, 1, 0x8000_0000 | cob_id, 4)
        self.write(node, index, 0, 0, 1)
        for sub, entry in enumerate(entries, start=1):
            self.write(node, index, sub, entry, 4)
        self.write(node, index, 0, len(entries), 1)
        if kind is not None:
            self.write(node, index - 0x200, 2, kind, 1)
        self.write(node, index - 0x200, 1, cob_id, 4)

    def pdos(self, can_id):
        """Return the data of the frames of a COB-ID sent since the last time."""
        return [data for sent_id, data in self.take() if sent_id == can_id]


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def make_bench():
    return Bench


@pytest.fixture
def vehicle(robot_toml):
    """Return a robot of two equal trucks."""
    return parse_vehicle(robot_toml.replace("0.151", "0.150").replace("0.341", "0.340"), "robot")


@pytest.fixture
def alone(vehicle):
    """Return its front truck as a robot."""
    return replace(vehicle, trucks={"a": vehicle.trucks["a"]}, linkage=None, encoders=vehicle.encoders[:2])
