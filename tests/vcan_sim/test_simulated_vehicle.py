"""The simulated vehicle: one step per SYNC, all devices on one clock, and stock clients on its bus."""

import threading
from dataclasses import replace
from itertools import count

import can
import canopen
import pytest

from omnimate.vcan_sim.nodes.objects import EDS_FOLDER
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulated_vehicle import SimulatedVehicle

PATIENCE = 120.0  # [s]; an upper bound, never waited for
CHANNELS = count()


def test_the_plant_moves_one_sync_period_per_sync(bench):
    bench.sync(3)
    assert bench.plant.steps == [0.015] * 3
    assert bench.plant.speeds == (0.0,) * 4
    assert bench.simulated.syncs == 3


def test_the_devices_clock_is_the_number_of_syncs_times_the_period(bench):
    bench.sync(200)
    assert bench.simulated.time == pytest.approx(3.0)
    assert bench.simulated.wait() is None


def test_two_vehicles_that_see_the_same_frames_send_the_same_frames(make_bench):
    def drive():
        bench = make_bench()
        bench.write(1, 0x1017, 0, 40, 2)
        bench.nmt(0x01)
        for number in range(100):
            bench.sync(count=number)
        return bench.take()

    assert drive() == drive()


def test_a_wheel_speed_hook_takes_the_drives_place(make_bench):
    bench = make_bench(wheel_speeds=lambda: (0.1 * bench.simulated.syncs, 0.0, 0.0, 0.0))
    bench.sync(2)
    assert bench.plant.speeds == (0.2, 0.0, 0.0, 0.0)


def test_a_vehicle_of_one_truck_has_two_wheels(make_bench):
    bench = make_bench(reference_single())
    bench.sync()
    assert bench.plant.speeds == (0.0, 0.0)
    assert sorted(bench.simulated.devices) == [1, 2, 11, 12]


def test_a_vehicle_without_drives_stands_still(make_bench):
    bench = make_bench(replace(reference_vehicle(), drives=()))
    bench.sync()
    assert bench.plant.speeds == (0.0,) * 4


def test_on_the_wall_clock_timers_run_without_sync(make_bench, monkeypatch):
    now = [100.0]
    monkeypatch.setattr("omnimate.vcan_sim.simulated_vehicle.time.monotonic", lambda: now[0])
    bench = make_bench(clock="wall")
    bench.write(1, 0x1017, 0, 50, 2)
    assert bench.simulated.wait() == pytest.approx(0.050)
    now[0] += 0.051
    bench.simulated.poll()
    assert bench.take() == [(0x701, b"\x7f")]
    assert bench.simulated.syncs == 0


class Channel:
    """A virtual bus with a simulated vehicle in a thread of python-can, and a stock client."""

    def __init__(self, plant):
        name = f"simulated-vehicle-{next(CHANNELS)}"
        self.theirs = can.Bus(name, interface="virtual")
        self.master = can.Bus(name, interface="virtual")
        self.simulated = SimulatedVehicle(reference_vehicle(), plant, self.theirs)
        self.network = canopen.Network(self.master)

    def __enter__(self):
        self.vehicles = can.Notifier(self.theirs, [self.simulated.receive], timeout=0.02)
        self.network.notifier = can.Notifier(self.master, self.network.listeners, timeout=0.02)
        return self

    def __exit__(self, *_):
        self.vehicles.stop()
        self.network.disconnect()
        self.theirs.shutdown()


@pytest.fixture
def channel(bench, monkeypatch):
    monkeypatch.setattr(canopen.sdo.SdoClient, "RESPONSE_TIMEOUT", PATIENCE)
    with Channel(bench.plant) as channel:
        yield channel


def test_a_stock_canopen_master_reads_configures_and_receives(channel, bench):
    node = channel.network.add_node(3, str(EDS_FOLDER / "encoder_cia406.eds"))
    assert node.sdo["Manufacturer device name"].raw == "OmniMate multi-turn encoder"
    node.tpdo.read()
    pdo = node.tpdo[1]
    pdo.clear()
    pdo.add_variable(0x6004)
    pdo.add_variable(0x6500)
    pdo.trans_type = 1
    pdo.save()
    node.nmt.state = "OPERATIONAL"
    received = threading.Event()
    pdo.add_callback(lambda _pdo: received.set())
    bench.plant.counts = (77,) * 7
    channel.network.sync.transmit()
    assert received.wait(PATIENCE)
    assert (pdo[0].raw, pdo[1].raw, pdo.is_periodic) == (77, 0, True)


def test_a_stock_canopen_master_sees_aborts_boot_ups_and_emergencies(channel):
    node = channel.network.add_node(3, str(EDS_FOLDER / "encoder_cia406.eds"))
    with pytest.raises(canopen.SdoAbortedError) as aborted:
        node.sdo.download(0x1000, 0, bytes(4))
    assert aborted.value.code == 0x06010002
    booted = threading.Event()
    node.nmt.add_heartbeat_callback(lambda state: booted.set() if state == 0 else None)
    node.nmt.send_command(0x81)
    assert booted.wait(PATIENCE)
    reported = threading.Event()
    node.emcy.add_callback(lambda _error: reported.set())
    channel.simulated.devices[3].emergency.set(0x5000)
    assert reported.wait(PATIENCE)
    assert node.emcy.active[0].code == 0x5000
