"""Devices that are right are taken, and none is left broken.

The devices are those of both families, and canopen's `LocalNode` with the habits of real ones.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from omnimate.driver.bus.clock import WallClock
from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.errors import MappingImpossible, NodeMissing, SdoRefused, WrongDevice
from omnimate.driver.robot.configure import configure_node
from omnimate.driver.robot.drive_configuration import configure_drive
from omnimate.vehicle.parameters import Bus
from tests.driver.conftest import drive, one_truck, wheel_encoder
from tests.foreign.bench import STEP
from tests.foreign.devices import OPERATIONAL, DescribedNode
from tests.foreign.robots import cycles, devices, foreign_encoder

EDS = Path(__file__).parents[2] / "vcan_sim" / "eds"
robot = partial(one_truck, period=0.015)
READ_ONLY, NOT_IN_THIS_STATE, OUT_OF_RANGE = 0x06010002, 0x08000022, 0x06090030
POSITION, NO_RTR, OFF = 0x60040020, 0x40000000, 0x80000000
DOWNLOAD = 1  # upper three bits of the first byte of an SDO request
PERIOD_US = 15_000

# --- devices of both families ---


@pytest.fixture
def encoder(family):
    return foreign_encoder(1)


@pytest.fixture
def start(begun, encoder):
    """Return what configures a robot with this encoder, and starts it; it gives what was written to it."""

    def run():
        driver, bus = begun([encoder, *devices()[1:]])
        report = driver.configure()
        requests = [data for _, can_id, data in bus.sent if can_id == 0x601 and data[0] >> 5 == DOWNLOAD]
        return driver, report.nodes[0], requests

    return run


def test_an_encoder_that_sends_at_changes_answers_each_sync(start, encoder):
    driver, configuration, _ = start()
    assert (encoder.number(0x1800, 1), encoder.number(0x1800, 2)) == (0x181, 1)
    assert configuration.heartbeat == 0.5
    assert all(sample.present[0] for sample in cycles(driver, 1.0))


def test_a_mapping_that_is_wrong_is_written_in_the_order_that_cia_301_asks_for(start, encoder):
    encoder.put(0x1800, 1, OFF | 0x181)
    encoder.put(0x1A00, 0, 0)
    encoder.put(0x1A00, 1, 0x10010008)
    encoder.put(0x1A00, 0, 1)
    driver, _, _ = start()
    assert [encoder.number(0x1A00, sub) for sub in (0, 1)] == [1, POSITION]
    assert all(sample.present[0] for sample in cycles(driver, 0.5))


def test_a_device_that_is_right_is_taken_although_everything_in_it_is_read_only(start, encoder):
    encoder.put(0x1800, 2, 1)
    encoder.put(0x1017, 0, 500)
    for index, subindexes in (
        *((index, (0,)) for index in (0x1005, 0x1017)),
        *((index, (1, 2, 3, 5)) for index in (0x1800, 0x1801)),
        (0x1A00, range(5)),
    ):
        for subindex in subindexes:
            encoder.protect(index, subindex)
    driver, configuration, written = start()
    assert (configuration.changed, configuration.lengths, written) == ([], {0x181: 4}, [])
    assert all(sample.present[0] for sample in cycles(driver, 0.5))


def test_a_read_only_cob_id_that_is_wrong_is_an_error_and_everything_is_put_back(start, encoder):
    encoder.put(0x1800, 1, OFF | 0x1A1)
    encoder.put(0x1800, 1, 0x1A1)
    for index in (0x1800, 0x1801):
        encoder.protect(index, 1)
    with pytest.raises(MappingImpossible, match=r"expected 181h; let cob_id .* follow the device"):
        start()
    assert (encoder.number(0x1800, 1), encoder.number(0x1800, 2)) == (0x1A1, 254)
    assert encoder.number(0x1017) == 0


def test_a_read_only_event_timer_and_inhibit_time_are_left_and_each_sync_is_answered(start, encoder):
    encoder.put(0x1800, 1, OFF | 0x181)
    encoder.put(0x1800, 3, 100)
    encoder.put(0x1800, 5, 50)
    encoder.put(0x1800, 1, 0x181)
    for subindex in (3, 5):
        encoder.protect(0x1800, subindex)
    driver, _, _ = start()
    assert [encoder.number(0x1800, sub) for sub in (2, 3, 5)] == [1, 100, 50]
    assert all(sample.present[0] for sample in cycles(driver, 0.5))


@pytest.fixture
def spare_tpdo(encoder):
    """Return what has TPDO2 send the position by a COB-ID that cannot be changed."""

    def switch_on(cob_id):
        encoder.put(0x1A01, 1, POSITION)
        encoder.put(0x1A01, 0, 1)
        encoder.put(0x1801, 1, cob_id)
        encoder.protect(0x1801, 1)
        assert encoder.number(0x1801, 1) == cob_id

    return switch_on


def test_a_spare_tpdo_that_cannot_be_switched_off_stays_on_and_is_told(start, spare_tpdo):
    spare_tpdo(0x281)
    driver, configuration, _ = start()
    assert any("TPDO2 281h stays on" in remark for remark in configuration.remarks)
    assert all(sample.present[0] for sample in cycles(driver, 0.5))


def test_a_spare_tpdo_that_cannot_be_switched_off_and_has_another_nodes_cob_id_is_an_error(start, spare_tpdo):
    spare_tpdo(0x182)
    with pytest.raises(SdoRefused, match="1801h:01"):
        start()


def test_a_counter_of_sync_and_its_period_are_set_in_the_order_that_the_device_takes(start, encoder):
    """CANopenNode refuses 1019h while 1006h is not 0, as CiA 301 says."""
    encoder.put(0x1019, 0, 240)
    encoder.put(0x1006, 0, 20_000)
    driver, configuration, written = start()
    values = [(int.from_bytes(data[1:3], "little"), int.from_bytes(data[4:], "little")) for data in written]
    assert [write for write in values if write[0] in {0x1006, 0x1019}] == [
        (0x1006, 0),
        (0x1019, 0),
        (0x1006, PERIOD_US),
    ]
    assert (encoder.number(0x1006), encoder.number(0x1019)) == (PERIOD_US, 0)
    assert any("SYNC counter 1019h: 240 to 0" in line for line in configuration.changed)
    assert any("SYNC period 1006h: 20000 to 15000 us" in line for line in configuration.changed)
    assert all(sample.present[0] for sample in cycles(driver, 0.5))
    assert encoder.number(0x1001) == 0


# --- devices with the habits of real ones ---


class Device(DescribedNode):
    """A device of which objects can be locked, and PDOs mapped beforehand."""

    def __init__(self, eds="encoder_cia406.eds"):
        super().__init__(1, EDS / eds)

    def map_pdo(self, base, cob_id, kind, *entries):
        self.put(base, 1, cob_id)
        self.put(base, 2, kind)
        self.put(base + 0x200, 0, len(entries))
        for subindex, entry in enumerate(entries, start=1):
            self.put(base + 0x200, subindex, entry)

    def lock(self, *objects, code=READ_ONLY):
        self.refuse |= dict.fromkeys(objects, code)

    def take_only(self, kind):
        """Refuse transmission types of TPDO1 but one."""
        self.refuse |= {(0x1800, 2, other): OUT_OF_RANGE for other in {1, 254, 255} - {kind}}


@pytest.fixture
def connect(bench):
    """Return what puts a device on a bench, and gives its objects and the network."""

    def run(device):
        network = BusNetwork(bench([device]), WallClock(1.0))
        return network.sdo(1), network

    return run


@pytest.fixture
def configure(connect):
    def run(device):
        sdo, network = connect(device)
        return configure_node(sdo, robot(), network.nmt_command)

    return run


def answer_late(bus, seconds):
    """Have all frames of the devices come so much later [s]."""
    send = bus.far.send
    bus.far.send = lambda message: bus.at(seconds, lambda: send(message))


@pytest.mark.parametrize("code", [READ_ONLY, NOT_IN_THIS_STATE, 0x06040043, 0xFFFFFFFF])
def test_a_read_only_mapping_that_is_right_stays_while_the_rest_is_set(configure, code):
    device = Device()
    device.map_pdo(0x1800, NO_RTR | OFF | 0x1A1, 254, POSITION)
    device.map_pdo(0x1801, NO_RTR | OFF | 0x281, 254)
    device.lock((0x1A00, 0), (0x1A00, 1), code=code)
    configure(device)
    assert (device.number(0x1800, 1), device.number(0x1800, 2)) == (NO_RTR | 0x181, 1)
    assert not [write for write in device.writes if write[0] == 0x1A00]


def test_a_read_only_cob_id_that_is_right_does_not_keep_the_mapping_from_being_set(configure):
    device = Device()
    device.map_pdo(0x1800, NO_RTR | 0x181, 254, 0x65000010)
    device.lock((0x1800, 1))
    configure(device)
    assert (device.number(0x1800, 2), device.number(0x1A00, 0), device.number(0x1A00, 1)) == (1, 1, POSITION)


@pytest.mark.parametrize("taken", [255, 254])
def test_a_device_without_transmission_type_1_sends_by_its_event_timer_and_that_is_told(configure, taken):
    device = Device()
    device.map_pdo(0x1800, NO_RTR | 0x181, taken, POSITION)
    device.take_only(taken)
    configuration = configure(device)
    assert (device.number(0x1800, 2), device.number(0x1800, 3), device.number(0x1800, 5)) == (taken, 75, 7)
    assert (
        f"TPDO1 refuses transmission type 1 (an answer to each SYNC): type {taken} instead, "
        "event timer 7 ms; its counts are up to 15 ms younger than SYNC"
    ) in configuration.remarks


def test_a_device_that_has_neither_type_1_nor_an_event_timer_sends_at_changes_and_that_is_told(configure):
    device = Device()
    device.map_pdo(0x1800, NO_RTR | 0x181, 255, POSITION)
    device.take_only(255)
    device.lock((0x1800, 5))
    device.put(0x1800, 5, 0)
    assert any("no event timer: sent at changes only" in remark for remark in configure(device).remarks)


@pytest.mark.parametrize("code", [0x06020000, 0x06090011, 0x08000000, 0x08000020, 0x05040001, 0x12345678])
def test_optional_objects_may_be_refused_with_any_abort_code(connect, code):
    device = Device()
    device.map_pdo(0x1800, NO_RTR | 0x181, 1, POSITION)
    optional = [0x1005, 0x1017, 0x6000, 0x6001, 0x6002, 0x6500, 0x6501, 0x6502, 0x6509, 0x650B]
    device.refuse_read = {(index, 0): code for index in optional} | {(0x1018, s): code for s in (1, 2, 4)}
    device.refuse_read |= {(0x1800, 3): code, (0x1800, 5): code, (0x1802, 1): code, (0x1803, 1): code}
    sdo, network = connect(device)
    configuration = configure_node(sdo, robot(), network.nmt_command)
    assert configuration.heartbeat is None
    assert configuration.encoder_objects == {}
    with pytest.raises(WrongDevice, match="serial is missing"):
        configure_node(sdo, robot(serial=77), network.nmt_command)


def test_a_device_that_answers_after_400_ms_is_configured_and_asked_nothing_twice(connect):
    device = Device()
    sdo, network = connect(device)
    answer_late(network.can_bus, 0.4)
    configure_node(sdo, robot(), network.nmt_command)
    asked = [data for _, can_id, data in network.can_bus.sent if can_id == 0x601]
    assert not [data for data in asked if data[0] == 0x80]
    assert device.number(0x1A00, 1) == POSITION


@pytest.mark.parametrize(("timeout", "is_in_time"), [(0.9, False), (1.1, True)])
def test_how_long_an_answer_is_awaited_stands_in_vehicle_toml(begun, timeout, is_in_time):
    driver, bus = begun([Device()], replace(robot(), bus=Bus(500_000, 0.015, timeout)))
    answer_late(bus, 1.0)
    with pytest.raises(NodeMissing, match="node 2"):  # node 1 answers
        driver.configure()
    given_up = [data for _, can_id, data in bus.sent if can_id == 0x601 and data[0] == 0x80]
    assert bool(given_up) != is_in_time


class TimedDevice(Device):
    """A device that, while operational, sends TPDO1 by its event timer, on a clock of its own."""

    def __init__(self, phase, skew):
        super().__init__()
        self.phase, self.skew, self.due = phase, skew, None

    def tick(self, now):
        super().tick(now)
        if self.state != OPERATIONAL:
            return
        self.due = now + self.phase if self.due is None else self.due
        if now >= self.due:
            self.send(0x181, bytes(4))
            self.due = max(self.due, now - STEP) + self.number(0x1800, 5) * 1e-3 * self.skew


@pytest.mark.parametrize("skew", [0.99, 1.0, 1.01])
@pytest.mark.parametrize("phase", [0.0, 0.002, 0.0045, 0.0069])
@pytest.mark.parametrize("period", [0.010, 0.015, 0.040])
def test_an_encoder_without_transmission_type_1_is_in_every_sample(begun, phase, skew, period):
    device = TimedDevice(phase, skew)
    device.take_only(255)
    encoders = (
        wheel_encoder("a.left", 1, bits=16),
        wheel_encoder("a.right", 1, cob_id=0x181, start_bit=16, bits=16),
    )
    device.map_pdo(0x1800, NO_RTR | 0x181, 255, 0x60200110, 0x60200210)
    driver, _ = begun([device], one_truck(encoders, period=period))
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
    return {key: device.number(*key) for key in PDO_OBJECTS}


def wrong_device():
    """Return an encoder that sends something else, by its event timer, in both TPDOs."""
    device = Device()
    device.map_pdo(0x1800, NO_RTR | 0x181, 254, 0x65000010, 0x65040010)
    device.map_pdo(0x1801, NO_RTR | 0x281, 254, 0x65000010)
    for base in (0x1800, 0x1801):
        device.put(base, 3, 20)
        device.put(base, 5, 100)
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


def test_an_encoder_that_was_operational_is_operational_again_when_its_configuration_fails(begun):
    device = wrong_device()
    device.lock((0x1A00, 1))
    device.state = OPERATIONAL
    driver, bus = begun([device], robot())
    bus.inject(0x701, b"\x05")
    with pytest.raises(MappingImpossible):
        driver.configure()
    assert device.state == OPERATIONAL


# --- drives ---


def set_up_drive(connect, device):
    sdo, network = connect(device)
    return configure_drive(sdo, drive("a.left", 1), 127, (), 0.01, network.nmt_command)[0]


@pytest.mark.parametrize("kind", [255, 254, 1])
def test_a_drive_whose_read_only_rpdo_takes_the_target_velocity_is_taken(connect, kind):
    device = Device("drive_cia402.eds")
    device.map_pdo(0x1400, 0x201, kind, 0x60FF0020)
    device.lock(*[(index, subindex) for index in (0x1400, 0x1600, 0x1800) for subindex in range(9)])
    configuration = set_up_drive(connect, device)
    waits_for_sync = any("a target counts from SYNC on" in remark for remark in configuration.remarks)
    assert waits_for_sync == (kind == 1)


def test_a_drive_that_cannot_map_the_target_velocity_keeps_its_rpdo(connect):
    device = Device("drive_cia402.eds")
    device.map_pdo(0x1400, 0x201, 1, 0x60400010)
    device.lock((0x1600, 1))
    with pytest.raises(MappingImpossible):
        set_up_drive(connect, device)
    assert [device.number(0x1400, 1), device.number(0x1400, 2)] == [0x201, 1]
    assert [device.number(0x1600, 0), device.number(0x1600, 1)] == [1, 0x60400010]
