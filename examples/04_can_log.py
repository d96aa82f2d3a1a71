"""Read a CAN log of a robot: what its frames hold, how many are missing, and where its odometry leads.

Usage: python 04_can_log.py LOG VEHICLE.toml
"""

import sys
from pathlib import Path

import omnimate
from omnimate.files.logs.assemble import assemble
from omnimate.files.logs.blocks import read_log
from omnimate.vehicle.odometry import dead_reckon


def main(log: Path, vehicle_file: Path) -> None:
    """Print what a log of any format that is read holds."""
    vehicle = omnimate.load_vehicle(vehicle_file)
    frames = read_log(log).frames
    print(f"{len(frames)} frames in {frames.time[-1] - frames.time[0]:.1f} s")

    # Frames become samples: one row for each SYNC, one column for each encoder.
    recording = assemble(frames, vehicle, str(log)).recording
    for column, channel in enumerate(vehicle.channels):
        missing = int((~recording.present[:, column]).sum())
        print(f"{channel:8} {len(recording)} samples, {missing} missing")

    # Counts become poses.
    for name in vehicle.trucks:
        x, y, theta = dead_reckon(recording, name)[-1]
        print(f"truck {name} ends at x {x:.3f} m, y {y:.3f} m, heading {theta:.3f} rad")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
