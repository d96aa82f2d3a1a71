"""Robots whose encoders and drives are foreign devices."""

from __future__ import annotations

from dataclasses import replace

from tests.driver import conftest as kit
from tests.foreign.devices import ForeignDrive, ForeignEncoder

FAMILY = {
    "encoder": ForeignEncoder,
    "drive": ForeignDrive,
}  # what makes devices; the fixture `family` sets it
WHEELS = ("a.left", "a.right", "b.left", "b.right")
FIRST_DRIVE = 17
PERIOD = 0.015  # [s] of SYNC


def foreign_encoder(node):
    """Return an encoder."""
    return FAMILY["encoder"](node)


def two_trucks(period=PERIOD):
    """Return a robot of seven encoders, nodes 1 to 7, and four drives, nodes 17 to 20."""
    drives = tuple(kit.drive(wheel, FIRST_DRIVE + number) for number, wheel in enumerate(WHEELS))
    return replace(kit.two_trucks(period), drives=drives)


def drive(driver, seconds, speed=4.0):
    """Drive straight on at a speed of the wheels [rad/s]; return the samples."""
    samples = []
    for _ in range(round(seconds / PERIOD)):
        driver.command((speed,) * 4)
        samples.append(driver.cycle())
    return [sample for sample in samples if sample is not None]


def devices(status=None, **habits):
    """Return the devices of `two_trucks`; `status` says where its drives have their status word."""
    encoders = [foreign_encoder(node) for node in range(1, 8)]
    return [
        *encoders,
        *(FAMILY["drive"](FIRST_DRIVE + number, encoders[number], status, **habits) for number in range(4)),
    ]


def rolling(bus, speed=0.3):
    """Have all wheels roll on by themselves [m/s], as with drives of another bus."""
    step = bus._step
    last = bus.now

    def stepped():
        nonlocal last
        for node in range(1, 5):
            if bus.nodes[node].is_powered:
                bus.nodes[node].position += speed * (bus.now - last) / 0.4712389 * 40000
        last = bus.now
        step()

    bus._step = stepped


def cycles(driver, seconds):
    """Let the driver read for a time [s]; return the samples, None where there is none."""
    return [driver.cycle() for _ in range(round(seconds / PERIOD))]
