"""What `omnimate monitor` costs at 9,000 frames a second, and whether it loses a frame, on the virtual bus.

Peer: python-can's `Notifier` with a listener that counts, on the same bus with the same frames.

A simulated OmniMate's bus (SYNC, seven encoders, four drives) is sent 13 times as fast as it would be, so
that its odometry runs too; the screen of 80 x 24 characters is drawn without a terminal. Cores are the
processor time that all threads but the sender's took, in the seconds of the run. The sender counts what it
sent, the monitor what it received.

Usage: python -m studies.speed.monitor_load [seconds]
"""

from __future__ import annotations

import asyncio
import sys
import threading
import time

import can

from omnimate.cli.descriptions import descriptions
from omnimate.cli.monitor.app import MonitorApp
from omnimate.cli.monitor.lines import Wanted
from omnimate.driver.bus.bus import open_bus
from omnimate.driver.robot.bus_watch import BusWatch
from omnimate.files.logs.formats.python_can_logs import message_of_frame
from omnimate.files.logs.recording_to_frames import frames_of_recording
from omnimate.motion import paths
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.recording import Recording
from studies.benchmark import options

RATE = 9000  # frames per second
SECONDS = 20.0
BURST = 0.005  # [s] between two bursts of the sender
SETTLING = 1.0  # [s] in which the notifier receives the last frames
PATIENCE = 5.0  # [s] without another frame after which those that are missing count as lost
MOST_CORES = 1.0


class Sender(threading.Thread):
    """Sends frames onto a bus at a rate, in bursts."""

    def __init__(self, messages: list[can.Message], channel: str, seconds: float) -> None:
        super().__init__(daemon=True)
        self.sent, self.cpu, self.took = 0, 0.0, 0.0
        self._messages, self._seconds = messages, seconds
        self._bus = open_bus(f"virtual://{channel}")

    def run(self) -> None:
        began, count = time.monotonic(), int(RATE * self._seconds)
        while self.sent < count:
            due = min(count, int(RATE * (time.monotonic() - began)))
            for number in range(self.sent, due):
                self._bus.send(self._messages[number % len(self._messages)])
            self.sent = max(due, self.sent)
            time.sleep(BURST)
        self.took = time.monotonic() - began
        self.cpu = time.thread_time()
        self._bus.shutdown()


async def monitored(
    recording: Recording, messages: list[can.Message], seconds: float
) -> tuple[float, int, int]:
    """Return the cores that the monitor took, and how many frames were sent and received."""
    channel = "benchmark-monitor"
    vehicle = recording.vehicle
    with BusWatch(lambda: open_bus(f"virtual://{channel}"), vehicle) as watch:
        app = MonitorApp(
            watch, descriptions(vehicle, (), ()), name=channel, bitrate=1_000_000, wanted=Wanted.of("")
        )
        async with app.run_test(size=(80, 24)):
            sender = Sender(messages, channel, seconds)
            before = time.process_time()
            sender.start()
            while sender.is_alive():
                await asyncio.sleep(0.1)
            ended, progress = time.monotonic(), (time.monotonic(), -1)
            while watch.snapshot.frames < sender.sent and time.monotonic() < progress[0] + PATIENCE:
                if watch.snapshot.frames > progress[1]:
                    progress = (time.monotonic(), watch.snapshot.frames)
                await asyncio.sleep(0.1)
            behind = time.monotonic() - ended
            used = time.process_time() - before - sender.cpu
        samples = watch.snapshot.robot.samples if watch.snapshot.robot else 0
        rate = sender.sent / sender.took
        print(
            f"  monitor: {samples} samples, {rate:.0f} frames/s sent, the last one shown {behind:.1f} s later"
        )
        return used / sender.took, sender.sent, watch.snapshot.frames


class Counter(can.Listener):
    def __init__(self) -> None:
        self.count = 0

    def on_message_received(self, _msg: can.Message) -> None:
        self.count += 1


def notified(messages: list[can.Message], seconds: float) -> tuple[float, int, int]:
    """Return the same for python-can's notifier."""
    channel, counter = "benchmark-notifier", Counter()
    bus = open_bus(f"virtual://{channel}")
    notifier = can.Notifier(bus, [counter])
    sender = Sender(messages, channel, seconds)
    before = time.process_time()
    sender.start()
    sender.join()
    time.sleep(SETTLING)
    used = time.process_time() - before - sender.cpu
    notifier.stop()
    bus.shutdown()
    return used / sender.took, sender.sent, counter.count


def main() -> int:
    seconds = options(__doc__, {"seconds": SECONDS}).seconds
    vehicle = reference_vehicle()
    recording = simulate(vehicle, Truth(vehicle, seed=1), paths.umbmark(2.0, 1, link_length=1.0))
    messages = [message_of_frame(frame) for frame in frames_of_recording(recording)]
    peer, peer_sent, peer_received = notified(messages, seconds)
    cores, sent, received = asyncio.run(monitored(recording, messages, seconds))
    print(f"{RATE} frames/s for {seconds:g} s on the virtual bus")
    print(f"  python-can's notifier  {peer:5.2f} cores  {peer_received} of {peer_sent} frames")
    print(
        f"  omnimate monitor       {cores:5.2f} cores  {received} of {sent} frames   "
        f"(wanted: {MOST_CORES:g} or less, none lost)"
    )
    return 0 if cores <= MOST_CORES and received == sent else 1


if __name__ == "__main__":
    sys.exit(main())
