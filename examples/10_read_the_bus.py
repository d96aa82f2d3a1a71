"""Read a robot's encoders from its bus for two seconds, and print where it is.

Usage: python 10_read_the_bus.py VEHICLE.toml BUS, such as socketcan://can0 or socketcand://127.0.0.1:29536/can0
"""

import sys
from itertools import islice
from pathlib import Path

import omnimate
from omnimate.vehicle.odometry import Odometer


def main(vehicle_file: Path, bus: str) -> None:
    """Configure the encoders, read two seconds, and report."""
    vehicle = omnimate.load_vehicle(vehicle_file)
    count = round(2.0 / vehicle.bus.sync_period)
    odometer = Odometer(vehicle, "a")
    with omnimate.open_driver(vehicle, bus) as driver:
        for sample in islice(driver.samples(), count):
            x, y, theta = odometer.step(sample)
    print(f"{count} samples; truck a is at x {x:.2f} m, y {y:.2f} m, heading {theta:.2f} rad")
    for node in driver.report().nodes:
        print(f"node {node.node}: {node.state}, {node.missing} missing")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
