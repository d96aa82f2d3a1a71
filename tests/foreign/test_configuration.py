"""Devices that are right are taken, and none is left broken.

The devices are canopen's `LocalNode` with the habits of real ones. Time passes only while the driver waits.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from types import SimpleNamespace

import can
import canopen
import pytest

from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.errors import MappingImpossible, NodeMissing, SdoRefused, WrongDevice
from omnimate.driver.robot.configure import configure_node
from omnimate.driver.robot.drive_configuration import configure_drive
from omnimate.driver.robot.driver import Driver
from omnimate.vehicle.parameters import Bus
from tests.driver.conftest import CaptureNetwork, drive, one_truck, wheel_encoder

EDS = Path(__file__).parents[2] / "vcan_sim" / "eds"
robot = partial(one_truck, period=0.015)
READ_ONLY, NOT_IN_THIS_STATE, OUT_OF_RANGE = 0x06010002, 0x08000022, 0x06090030
POSITION, NO_RTR, OFF = 0x60040020, 0x40000000, 0x80000000


@cache
def dictionary_of(eds):
    return canopen.import_od(str(EDS / eds), 1)


@dataclass
class Device:
    """A `LocalNode` that refuses to write or to read some objects, and answers after a time."""

    eds: str = "encoder_cia406.eds"
    latency: float = 0.0
    locked: dict = field(default_factory=dict)  # (index, subindex) -> abort code of writing
    hidden: dict = field(default_factory=dict)  # (index, subindex) -> abort code of reading
    allowed: dict = field(default_factory=dict)  # (index, subindex) -> the values that it takes

    def __post_init__(self):
        self.network = CaptureNetwork()
        self.local = canopen.LocalNode(1, dictionary_of(self.eds))
        self.local.associate_network(self.network)
        self.local.add_write_callback(self.check_write)
        self.local.add_read_callback(self.check_read)
        self.writes = []

    def check_write(self, index, subindex, od, data):
        value = int.from_bytes(data, "little")
        self.writes.append((index, subindex, value))
        code = self.locked.get((index, subindex))
        if code is None and value not in self.allowed.get((index, subindex), [value]):
            code = OUT_OF_RANGE
        if code is not None:
            raise canopen.SdoAbortedError(code)

    def check_read(self, index, subindex, od):
        if (index, subindex) in self.hidden:
            raise canopen.SdoAbortedError(self.hidden[index, subindex])

    def set(self, index, subindex, value):
        variable = self.local.object_dictionary.get_variable(index, subindex)
        data = (value % (1 << len(variable))).to_bytes(len(variable) // 8, "little")
        self.local.data_store.setdefault(index, {})[subindex] = data

    def get(self, index, subindex=0):
        return int.from_bytes(self.local.get_data(index, subindex), "little")

    def map_tpdo(self, number, cob_id, kind, *entries):
        self.set(0x1800 + number, 1, cob_id)
        self.set(0x1800 + number, 2, kind)
        self.set(0x1A00 + number, 0, len(entries))
        for subindex, entry in enumerate(entries, start=1):
            self.set(0x1A00 + number, subindex, entry)

    def lock(self, *objects, code=READ_ONLY):
        self.locked |= dict.fromkeys(objects, code)


class SlowBus(can.BusABC):
    """A bus whose devices answer after their latency; its time goes on while somebody waits."""

    def __init__(self, *devices):
        super().__init__(channel="slow")
        self.channel_info = "slow"
        self._is_shutdown = True  # there is nothing to shut down
        self.devices, self.time, self.sent, self.coming = devices, 100.0, [], deque()

    def send(self, msg, timeout=None):
        self.sent.append((msg.arbitration_id, bytes(msg.data)))
        for device in self.devices:
            device.network.notify(msg.arbitration_id, bytearray(msg.data), 0.0)
            answers, device.network.sent = device.network.sent, []
            self.coming.extend((self.time + device.latency, answer) for answer in answers)

    def recv(self, timeout=None):
        if self.coming and self.coming[0][0] <= self.time + (timeout or 0.0):
            due, message = self.coming.popleft()
            self.time = max(self.time, due)
            return message
        self.time += timeout or 0.0
        return None

    def clock(self):
        return SimpleNamespace(now=lambda: self.time, frame_time=lambda _stamp: self.time)


@pytest.fixture
def connect(monkeypatch):
    """Return the objects of node 1 on a bus with a device, and the bus."""

    def run(device):
        bus = SlowBus(device)
        monkeypatch.setattr("omnimate.driver.canopen.sdo.time", SimpleNamespace(monotonic=lambda: bus.time))
        network = BusNetwork(bus, bus.clock())
        network.handler = lambda message, _arrival: network.notify(message.arbitration_id, message.data, 0.0)
        return network.sdo(1), network

    return run


@pytest.fixture
def configure(connect):
    def run(device, **changes):
        sdo, network = connect(device)
        return configure_node(sdo, robot(**changes), network.nmt_command)

    return run


def right_device(**habits):
    """Return an encoder that already answers every SYNC as the robot's `vehicle.toml` says."""
    device = Device(**habits)
    device.map_tpdo(0, NO_RTR | 0x181, 1, POSITION)
    device.map_tpdo(1, OFF | 0x281, 1, POSITION)
    device.set(0x1017, 0, 500)
    return device


def test_a_device_that_is_right_is_taken_although_everything_in_it_is_read_only(configure):
    device = right_device()
    device.lock(*[(i, s) for i in (0x1005, 0x1017, 0x1800, 0x1801, 0x1A00, 0x1A01) for s in range(9)])
    configuration = configure(device)
    assert configuration.changed == []
    assert configuration.lengths == {0x181: 4}
    assert device.writes == []


@pytest.mark.parametrize("code", [READ_ONLY, NOT_IN_THIS_STATE, 0x06040043, 0xFFFFFFFF])
def test_a_read_only_mapping_that_is_right_stays_while_the_rest_is_set(configure, code):
    device = Device()
    device.map_tpdo(0, NO_RTR | OFF | 0x1A1, 254, POSITION)
    device.map_tpdo(1, NO_RTR | OFF | 0x281, 254)
    device.lock((0x1A00, 0), (0x1A00, 1), code=code)
    configure(device)
    assert (device.get(0x1800, 1), device.get(0x1800, 2)) == (NO_RTR | 0x181, 1)
    assert not [write for write in device.writes if write[0] == 0x1A00]


def test_a_read_only_cob_id_that_is_right_does_not_keep_the_mapping_from_being_set(configure):
    device = Device()
    device.map_tpdo(0, NO_RTR | 0x181, 254, 0x65000010)
    device.lock((0x1800, 1))
    configure(device)
    assert (device.get(0x1800, 2), device.get(0x1A00, 0), device.get(0x1A00, 1)) == (1, 1, POSITION)


def test_a_read_only_cob_id_that_is_wrong_is_an_error_that_names_the_one_of_the_device(configure):
    device = Device()
    device.map_tpdo(0, NO_RTR | 0x1A1, 254, POSITION)
    device.lock((0x1800, 1), (0x1801, 1))
    with pytest.raises(MappingImpossible, match=r"expected 181h; let cob_id .* follow the device"):
        configure(device)


def test_a_read_only_event_timer_or_inhibit_time_is_left_as_it_is(configure):
    device = Device()
    device.map_tpdo(0, NO_RTR | 0x181, 254, POSITION)
    device.set(0x1800, 3, 100)
    device.set(0x1800, 5, 50)
    device.lock((0x1800, 3), (0x1800, 5))
    configure(device)
    assert (device.get(0x1800, 2), device.get(0x1800, 3), device.get(0x1800, 5)) == (1, 100, 50)


def test_a_spare_tpdo_that_cannot_be_switched_off_stays_on_and_is_told(configure):
    device = right_device()
    device.map_tpdo(1, NO_RTR | 0x281, 1, POSITION)
    device.lock((0x1801, 1))
    configuration = configure(device)
    assert device.get(0x1801, 1) == NO_RTR | 0x281
    assert any("TPDO2 281h stays on" in remark for remark in configuration.remarks)


def test_a_spare_tpdo_that_cannot_be_switched_off_and_has_another_nodes_cob_id_is_an_error(configure):
    device = right_device()
    device.map_tpdo(1, NO_RTR | 0x182, 1, POSITION)
    device.lock((0x1801, 1))
    with pytest.raises(SdoRefused, match="1801h:01"):
        configure(device)


@pytest.mark.parametrize("taken", [255, 254])
def test_a_device_without_transmission_type_1_sends_by_its_event_timer_and_that_is_told(configure, taken):
    device = Device()
    device.map_tpdo(0, NO_RTR | 0x181, taken, POSITION)
    device.allowed[0x1800, 2] = [taken]
    configuration = configure(device)
    assert (device.get(0x1800, 2), device.get(0x1800, 3), device.get(0x1800, 5)) == (taken, 75, 7)
    assert (
        f"TPDO1 refuses transmission type 1 (an answer to each SYNC): type {taken} instead, "
        "event timer 7 ms; its counts are up to 15 ms younger than SYNC"
    ) in configuration.remarks


def test_a_device_that_has_neither_type_1_nor_an_event_timer_sends_at_changes_and_that_is_told(configure):
    device = Device()
    device.map_tpdo(0, NO_RTR | 0x181, 255, POSITION)
    device.allowed[0x1800, 2] = [255]
    device.lock((0x1800, 5))
    device.set(0x1800, 5, 0)
    assert any("no event timer: sent at changes only" in remark for remark in configure(device).remarks)


@pytest.mark.parametrize("code", [0x06020000, 0x06090011, 0x08000000, 0x08000020, 0x05040001, 0x12345678])
def test_optional_objects_may_be_refused_with_any_abort_code(configure, code):
    device = right_device()
    optional = [0x1005, 0x1017, 0x6000, 0x6001, 0x6002, 0x6500, 0x6501, 0x6502, 0x6509, 0x650B]
    device.hidden = {(index, 0): code for index in optional} | {(0x1018, s): code for s in (1, 2, 4)}
    device.hidden |= {(0x1800, 3): code, (0x1800, 5): code, (0x1802, 1): code, (0x1803, 1): code}
    configuration = configure(device)
    assert configuration.heartbeat is None
    assert configuration.encoder_objects == {}
    with pytest.raises(WrongDevice, match="serial is missing"):
        configure(device, serial=77)


def test_a_device_that_answers_after_400_ms_is_configured_and_asked_nothing_twice(connect):
    device = Device(latency=0.4)
    sdo, network = connect(device)
    configure_node(sdo, robot(), network.nmt_command)
    asked = [data for can_id, data in network.can_bus.sent if can_id == 0x601]
    assert not [data for data in asked if data[0] == 0x80]
    assert device.get(0x1A00, 1) == POSITION


@pytest.mark.parametrize(("timeout", "is_in_time"), [(0.9, False), (1.1, True)])
def test_how_long_an_answer_is_awaited_stands_in_vehicle_toml(monkeypatch, timeout, is_in_time):
    bus = SlowBus(Device(latency=1.0))
    monkeypatch.setattr("omnimate.driver.canopen.sdo.time", SimpleNamespace(monotonic=lambda: bus.time))
    vehicle = replace(robot(), bus=Bus(500_000, 0.015, timeout))
    with pytest.raises(NodeMissing, match="node 2"):  # node 1 answers
        Driver(vehicle, bus).configure()
    given_up = [data for can_id, data in bus.sent if can_id == 0x601 and data[0] == 0x80]
    assert bool(given_up) != is_in_time


class TimedBus(SlowBus):
    """A bus on which a device, while operational, sends TPDO1 by its event timer on a clock of its own."""

    def __init__(self, phase, skew, device):
        super().__init__(device)
        self.device, self.due, self.skew = device, self.time + phase, skew

    def recv(self, timeout=None):
        operational = self.device.local.nmt.state == "OPERATIONAL"
        if operational and not self.coming and self.due <= self.time + (timeout or 0.0):
            data = self.device.get(0x6004).to_bytes(4, "little")
            message = can.Message(arbitration_id=0x181, data=data, is_extended_id=False)
            self.coming.append((max(self.due, self.time), message))
            self.due = max(self.due, self.time) + self.device.get(0x1800, 5) * 1e-3 * self.skew
        return super().recv(timeout)


class BusClock:
    """SYNC at equal intervals of the bus's own time."""

    inline, skipped = True, 0

    def __init__(self, bus, period):
        self.bus, self.period, self.deadline = bus, period, bus.time

    def due(self):
        return self.deadline - self.bus.time

    def sync(self):
        self.deadline = max(self.deadline, self.bus.time) + self.period
        return self.bus.time

    def remaining(self):
        return self.deadline - self.bus.time

    def now(self):
        return self.bus.time

    def frame_time(self, _stamp):
        return self.bus.time

    def sleep(self, seconds):
        self.bus.time += seconds


@pytest.mark.parametrize("skew", [0.99, 1.0, 1.01])
@pytest.mark.parametrize("phase", [0.0, 0.002, 0.0045, 0.0069])
@pytest.mark.parametrize("period", [0.010, 0.015, 0.040])
def test_an_encoder_without_transmission_type_1_is_in_every_sample(monkeypatch, phase, skew, period):
    device = Device()
    device.map_tpdo(0, NO_RTR | 0x181, 255, POSITION)
    device.allowed[0x1800, 2] = [255]
    device.local.data_store.setdefault(0x6004, {})[0] = bytes(4)
    bus = TimedBus(phase, skew, device)
    for module in ("canopen.sdo", "robot.driver"):
        monkeypatch.setattr(f"omnimate.driver.{module}.time", SimpleNamespace(monotonic=lambda: bus.time))
    encoders = (
        wheel_encoder("a.left", 1, bits=16),
        wheel_encoder("a.right", 1, cob_id=0x181, start_bit=16, bits=16),
    )
    vehicle = one_truck(encoders, period=period)
    device.map_tpdo(0, NO_RTR | 0x181, 255, 0x60200110, 0x60200210)
    driver = Driver(vehicle, bus, clock=BusClock(bus, period))
    driver.configure()
    samples = [driver.cycle() for _ in range(400)]
    assert all(all(sample.present) for sample in samples)
    assert driver.report().node(1).missing == 0


# --- a configuration that fails ---

PDO_OBJECTS = [
    *[(0x1800 + n, s) for n in range(2) for s in (1, 2, 3, 5)],
    *[(0x1A00 + n, s) for n in range(2) for s in (0, 1, 2)],
    (0x1005, 0),
    (0x1017, 0),
]


def contents(device):
    return {key: device.get(*key) for key in PDO_OBJECTS}


def wrong_device():
    """Return an encoder that sends something else, by its event timer, in both TPDOs."""
    device = Device()
    device.map_tpdo(0, NO_RTR | 0x181, 254, 0x65000010, 0x65040010)
    device.map_tpdo(1, NO_RTR | 0x281, 254, 0x65000010)
    for base in (0x1800, 0x1801):
        device.set(base, 3, 20)
        device.set(base, 5, 100)
    return device


@pytest.mark.parametrize(
    "broken", [(0x1A00, 0), (0x1A00, 1), (0x1A00, 2), (0x1A01, 0), (0x1A01, 1), (0x1801, 1)]
)
def test_a_configuration_that_fails_anywhere_puts_back_what_it_had_changed(connect, broken):
    device = wrong_device()
    device.lock(broken)
    before = contents(device)
    sdo, network = connect(device)
    vehicle = robot((wheel_encoder("a.left", 1), wheel_encoder("a.right", 1, cob_id=0x2A1)))
    try:
        configure_node(sdo, vehicle, network.nmt_command)
    except (MappingImpossible, SdoRefused):
        assert contents(device) == before
    else:
        assert broken == (0x1A00, 2)  # is not needed for one entry


def test_an_encoder_that_was_operational_is_operational_again_when_its_configuration_fails():
    device = wrong_device()
    device.lock((0x1A00, 1))
    device.local.nmt.state = "OPERATIONAL"
    bus = SlowBus(device)
    driver = Driver(robot(), bus)
    bus.coming.append((bus.time, can.Message(arbitration_id=0x701, data=b"\x05", is_extended_id=False)))
    with pytest.raises(MappingImpossible):
        driver.configure()
    assert device.local.nmt.state == "OPERATIONAL"


# --- drives ---


def drive_device(**habits):
    return Device("drive_cia402.eds", **habits)


def set_up_drive(connect, device):
    sdo, network = connect(device)
    return configure_drive(sdo, drive("a.left", 1), 127, (), 0.01, network.nmt_command)[0]


def map_rpdo(device, cob_id, kind, *entries):
    device.set(0x1400, 1, cob_id)
    device.set(0x1400, 2, kind)
    device.set(0x1600, 0, len(entries))
    for subindex, entry in enumerate(entries, start=1):
        device.set(0x1600, subindex, entry)


@pytest.mark.parametrize("kind", [255, 254, 1])
def test_a_drive_whose_read_only_rpdo_takes_the_target_velocity_is_taken(connect, kind):
    device = drive_device()
    map_rpdo(device, 0x201, kind, 0x60FF0020)
    device.lock(*[(index, subindex) for index in (0x1400, 0x1600, 0x1800) for subindex in range(9)])
    configuration = set_up_drive(connect, device)
    waits_for_sync = any("a target counts from SYNC on" in remark for remark in configuration.remarks)
    assert waits_for_sync == (kind == 1)


def test_a_drive_that_cannot_map_the_target_velocity_keeps_its_rpdo(connect):
    device = drive_device()
    map_rpdo(device, 0x201, 1, 0x60400010)
    device.lock((0x1600, 1))
    with pytest.raises(MappingImpossible):
        set_up_drive(connect, device)
    assert [device.get(0x1400, 1), device.get(0x1400, 2)] == [0x201, 1]
    assert [device.get(0x1600, 0), device.get(0x1600, 1)] == [1, 0x60400010]
