"""The live path: the time from SYNC to the assembled sample at 100 Hz, and its pace without waiting.

Peer: one message from one end of python-can's virtual bus to the other, in the same process.

The driver and the simulated vehicle share this process and a virtual bus. The latency is host time from
just before SYNC is sent until the sample is there. The pace is measured without waiting, at a SYNC period of
15 ms: on python-can's virtual bus with a thread for the vehicle, where it depends on how the machine switches
between the two threads, and on the bus in one thread, which the demo uses. The driver's share is measured on
a bus that costs nothing.

Usage: python -m studies.speed.live_latency
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import can

from omnimate.driver.bus.bus import open_bus
from omnimate.driver.bus.clock import Clock, SyncClock, WallClock
from omnimate.driver.robot.driver import Driver
from omnimate.driver.robot.recorder import Recorder
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulated_vehicle import SimulatedVehicle
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.parameters import VehicleParameters
from studies.benchmark import options

LATENCY_TARGET = 2.0  # [ms], 99th percentile
PACE_TARGET = 30.0  # times real time at 15 ms
LATENCY_SAMPLES, PACE_SAMPLES, ROUNDS = 2000, 3000, 3


@contextmanager
def robot(
    vehicle: VehicleParameters, clock: Clock, recorder: Recorder | None = None, *, one_thread: bool = False
) -> Iterator[Driver]:
    """Yield the driver of a simulated vehicle, configured and enabled, on their bus."""
    plant, notifier = Plant(Truth(vehicle), vehicle), None
    ours: can.BusABC
    theirs: can.BusABC
    if one_thread:
        ours = theirs = CoupledBus(vehicle, plant)
    else:
        channel = f"virtual://benchmark-{time.monotonic_ns()}"
        ours, theirs = open_bus(channel), open_bus(channel)
        simulated = SimulatedVehicle(vehicle, plant, theirs)
        notifier = can.Notifier(theirs, [simulated.receive], timeout=0.05)
    driver = Driver(vehicle, ours, clock=clock, recorder=recorder)
    driver.configure()
    driver.enable()
    try:
        yield driver
    finally:
        driver.close()
        if notifier is not None:
            notifier.stop()
        ours.shutdown()
        theirs.shutdown()


class StampedClock(WallClock):
    """The wall clock, which remembers when SYNC was sent."""

    sent = 0.0

    def sync(self) -> float:
        self.sent = time.perf_counter()
        return super().sync()


class InstantBus(can.BusABC):
    """Answers SYNC with the same PDOs at no cost, so that only the driver's work is left."""

    def __init__(self, vehicle: VehicleParameters) -> None:
        super().__init__(channel="instant")
        self._answers = [
            can.Message(arbitration_id=encoder.cob_id, data=bytes(4), is_extended_id=False)
            for encoder in vehicle.encoders
        ]
        self._queue: deque[can.Message] = deque()

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        del timeout
        if msg.arbitration_id == 0x080:
            self._queue.extend(self._answers)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        del timeout
        return self._queue.popleft() if self._queue else None


def latencies(vehicle: VehicleParameters) -> list[float]:
    """Return the time from SYNC to sample of each cycle [ms]."""
    clock = StampedClock(vehicle.bus.sync_period)
    spent = []
    with robot(vehicle, clock) as driver:
        for _ in range(LATENCY_SAMPLES):
            driver.cycle()  # where a PDO is missing, the whole window counts
            spent.append((time.perf_counter() - clock.sent) * 1e3)
    return spent


def bus_latencies() -> list[float]:
    """Return the times of single messages through python-can's virtual bus [us]."""
    channel, spent = f"virtual://benchmark-{time.monotonic_ns()}", []
    message = can.Message(arbitration_id=0x181, data=bytes(4), is_extended_id=False)
    with open_bus(channel) as sender, open_bus(channel) as receiver:
        for _ in range(LATENCY_SAMPLES):
            start = time.perf_counter()
            sender.send(message)
            receiver.recv(1.0)
            spent.append((time.perf_counter() - start) * 1e6)
    return spent


def pace(
    vehicle: VehicleParameters,
    recorder: Recorder | None = None,
    *,
    commands: bool = True,
    one_thread: bool = False,
) -> float:
    """Return how many times real time driver and vehicle go through the bus."""
    period = vehicle.bus.sync_period
    with robot(vehicle, SyncClock(period), recorder, one_thread=one_thread) as driver:
        start = time.perf_counter()
        for number in range(PACE_SAMPLES):
            if commands:
                driver.command([1.0 + 0.001 * (number % 7)] * len(vehicle.wheels))
            driver.cycle()
        return PACE_SAMPLES * period / (time.perf_counter() - start)


def recorded_pace(vehicle: VehicleParameters) -> float:
    """Return the same while every frame is recorded."""
    with tempfile.TemporaryDirectory() as folder, Recorder(folder, vehicle) as recorder:
        return pace(vehicle, recorder, one_thread=True)


def driver_work(vehicle: VehicleParameters) -> float:
    """Return the driver's work per cycle [us]."""
    driver = Driver(vehicle, InstantBus(vehicle), clock=SyncClock(vehicle.bus.sync_period))
    start = time.perf_counter()
    for _ in range(PACE_SAMPLES):
        driver.cycle()
    return (time.perf_counter() - start) / PACE_SAMPLES * 1e6


def main() -> int:
    options(__doc__)
    vehicle = reference_vehicle()
    fast = replace(vehicle, bus=replace(vehicle.bus, sync_period=0.010))
    spent = min((latencies(fast) for _ in range(ROUNDS)), key=p99)
    messages = min((bus_latencies() for _ in range(ROUNDS)), key=p99)
    reading = max(pace(vehicle, commands=False) for _ in range(ROUNDS))
    threaded = max(pace(vehicle) for _ in range(ROUNDS))
    plain = max(pace(vehicle, one_thread=True) for _ in range(ROUNDS))
    recorded = max(recorded_pace(vehicle) for _ in range(ROUNDS))
    work = min(driver_work(vehicle) for _ in range(ROUNDS))
    print(f"{len(vehicle.encoders)} encoders, {len(vehicle.drives)} drives; best of {ROUNDS} rounds")
    print(f"  one message on the bus, p50     {statistics.median(messages):8.2f} us")
    print(f"  one message on the bus, p99     {p99(messages):8.2f} us")
    print(f"  SYNC to sample at 100 Hz, p50   {statistics.median(spent):8.2f} ms")
    print(f"  SYNC to sample at 100 Hz, p99   {p99(spent):8.2f} ms   (wanted: below {LATENCY_TARGET:g})")
    print("  through the bus, times real time:")
    print(f"    two threads, reading          {reading:8.1f}")
    print(f"    two threads, commands too     {threaded:8.1f}")
    print(f"    one thread, commands too      {plain:8.1f}   (wanted: {PACE_TARGET:g})")
    print(f"    the same, recorded            {recorded:8.1f}")
    print(f"  the driver alone                {work:8.1f} us per cycle")
    return 0 if p99(spent) < LATENCY_TARGET and plain >= PACE_TARGET else 1


def p99(spent: list[float]) -> float:
    return statistics.quantiles(spent, n=100)[98]


if __name__ == "__main__":
    sys.exit(main())
