"""How long it takes from a drive's trouble until all wheels are commanded to stop, cause by cause.

Peer: the same causes with the status word 6041h of the drives in no TPDO, and in one.

The devices are `canopen.LocalNode` with a CiA 402 drive on it (`tests/foreign`), or such on CANopenNode where
CANOPENNODE names its sources (CONTRIBUTING.md), on a virtual bus whose time is simulated: the driver's own
work takes none. Each cause happens at many moments of SYNC and heartbeat. The time ends when zero velocity
has been sent to all four drives.

Where the driver is gone (its process, its machine, its cable), the drives have to stop by themselves. These
are simulated ones (`vcan_sim`), and SYNCs of another producer make their time pass.

Usage: python -m studies.speed.stopping_times [LocalNode | CANopenNode]
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import can

from omnimate.driver.bus.clock import SyncClock
from omnimate.driver.errors import DrivesStopped
from omnimate.driver.robot.driver import Driver
from omnimate.motion import drive as motion
from omnimate.motion.journal import Journal
from omnimate.motion.paths import out_and_back
from omnimate.motion.runner import Runner
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.nodes.device import SYNC_ID
from omnimate.vcan_sim.nodes.drive import DriveDevice
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.truth import Truth
from studies.benchmark import options
from tests.foreign import robots
from tests.foreign.bench import Bench, BenchClock
from tests.foreign.canopennode import nodes
from tests.foreign.devices import PRE_OPERATIONAL, STOPPED, SWITCH_ON_DISABLED, ForeignDrive
from tests.foreign.robots import FIRST_DRIVE, devices, two_trucks

TARGET = 100.0  # [ms]
MOMENTS = 30
SPAN = 0.075  # [s]: five SYNC periods are three heartbeats
SPEED = 4.0  # [rad/s]
MOVING = 10_000.0  # [counts/s] of a drive that has begun its program


def block(drive: ForeignDrive) -> None:
    drive.is_blocked = True


CAUSES: dict[str, Callable[[ForeignDrive], None]] = {
    "EMCY 5000h": lambda drive: drive.emergency(0x5000),
    "status word: fault, no EMCY": lambda drive: drive.fault(),
    "status word: switch on disabled": lambda drive: setattr(drive, "status", SWITCH_ON_DISABLED),
    "boot-up": lambda drive: drive.reset(),
    "NMT pre-operational": lambda drive: setattr(drive, "state", PRE_OPERATIONAL),
    "NMT stopped": lambda drive: setattr(drive, "state", STOPPED),
    "no power: heartbeat lost": lambda drive: drive.power_off(),
    "wheel commanded and stands": block,
}


def _enabled(status: str | None) -> tuple[Bench, Driver]:
    """Return a bench whose time is that of the process, and a driver that has enabled the drives on it."""
    bench = Bench(devices(status))
    time.monotonic, time.sleep = bench.monotonic, bench.sleep
    driver = Driver(vehicle := two_trucks(), bench, clock=BenchClock(vehicle.bus.sync_period))
    driver.configure()
    driver.enable()
    return bench, driver


def _until_zeros(frames: Sequence[tuple[float, int, bytes]], began: float) -> float:
    """Return the time from a moment until zero velocity was sent to all four drives, in some frames [ms]."""
    zeros = [at for at, can_id, data in frames if can_id >> 4 == 0x21 and not any(data)]
    return (zeros[3] - began) * 1e3


def stopping_time(happen: Callable[[ForeignDrive], None], status: str | None, phase: float) -> float:
    """Return the time until all drives are commanded to stop [ms] after something happens to one of them.

    They have their status word in no TPDO (None) or in one ("last"); `phase` is the time after a SYNC [s].
    """
    bench, driver = _enabled(status)
    for _ in range(20):
        driver.command((SPEED,) * 4)
        driver.cycle()
    began: float = bench.at(phase, lambda: happen(bench.nodes[FIRST_DRIVE]))
    sent = len(bench.sent)
    try:
        while bench.now < began + 2.0:
            driver.command((SPEED,) * 4)
            driver.cycle()
    except DrivesStopped:
        return _until_zeros(bench.sent[sent:], began)
    finally:
        bench.shutdown()
    raise AssertionError("the robot was not stopped")


def standing_time(status: str | None, phase: float) -> float:
    """Return the time from an encoder's last answer until all drives are commanded to stand [ms]."""
    (bench, driver), vehicle = _enabled(status), two_trucks()
    assert vehicle.linkage is not None  # two trucks
    program = out_and_back(20.0, 1, speed=0.3, link_length=vehicle.linkage.length)
    moments = motion.drive(driver, Runner(program, vehicle), vehicle, Journal(program))
    while bench.nodes[FIRST_DRIVE].velocity < MOVING:
        next(moments)
    began: float = bench.at(phase, bench.nodes[1].power_off)
    sent = len(bench.sent)
    while bench.now < began + 0.5:
        next(moments)
    bench.shutdown()
    return _until_zeros([frame for frame in bench.sent[sent:] if frame[0] >= began], began)


def watchdog_times(syncs: int) -> tuple[float, float]:
    """Return the times from the driver's end until no drive has a command, and until all wheels stand [ms].

    The driver commands the wheels for some SYNCs before it ends.
    """
    vehicle = reference_vehicle()
    period = vehicle.bus.sync_period
    bus = CoupledBus(vehicle, Plant(Truth(vehicle, seed=1), vehicle))
    driver = Driver(vehicle, bus, clock=SyncClock(period))
    driver.configure()
    driver.enable()
    for _ in range(syncs):
        driver.command((SPEED,) * 4)
        driver.cycle()
    drives = [device for device in bus.simulated.devices.values() if isinstance(device, DriveDevice)]
    began = bus.simulated.time
    sync, dropped = can.Message(arbitration_id=SYNC_ID, is_extended_id=False), None
    while any(drive.velocity for drive in drives):
        bus.send(sync)
        if dropped is None and not any(drive.objects[0x60FF, 0] for drive in drives):
            dropped = bus.simulated.time
    assert dropped is not None, "the wheels came to rest with a command"
    stood = bus.simulated.time
    bus.shutdown()
    return (dropped - began) * 1e3, (stood - began) * 1e3


def main() -> int:
    if options(__doc__, {"family": "LocalNode"}).family == "CANopenNode":
        if missing := nodes.what_is_missing():
            print(missing)
            return 1
        with tempfile.TemporaryDirectory() as folder:
            robots.FAMILY = nodes.family(nodes.build(Path(folder)))
    clocks = time.monotonic, time.sleep
    print(f"{'cause':34}{'6041h by SDO':>20}{'6041h in a TPDO':>20}   [ms], median and slowest")
    slowest = 0.0
    rows: dict[str, Callable[[str | None, float], float]]
    rows = {name: partial(stopping_time, happen) for name, happen in CAUSES.items()}
    rows["encoder silent, in a program"] = standing_time
    for name, time_of in rows.items():
        line = f"{name:34}"
        for status in (None, "last"):
            times = [time_of(status, SPAN * step / MOMENTS) for step in range(MOMENTS)]
            line += f"{statistics.median(times):>13.0f}{max(times):>7.0f}"
            if CAUSES.get(name) is not block:
                slowest = max(slowest, *times)
        print(line)
    time.monotonic, time.sleep = clocks
    dropped, stood = zip(*(watchdog_times(60 + syncs) for syncs in range(MOMENTS)), strict=True)
    print(f"{'driver gone: command dropped':34}{statistics.median(dropped):>13.0f}{max(dropped):>7.0f}")
    print(f"{'driver gone: all wheels stand':34}{statistics.median(stood):>13.0f}{max(stood):>7.0f}")
    print(f"slowest, without the declared time of a standing wheel: {slowest:.0f} ms (wanted: {TARGET:g})")
    return 0 if slowest <= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
