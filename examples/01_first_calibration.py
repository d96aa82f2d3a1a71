"""Simulate a robot whose wheelbase is not as described, calibrate it from the recording, and track it.

Usage: python 01_first_calibration.py
"""

from pathlib import Path

import omnimate
from omnimate.effects.wheelbase import Wheelbase
from omnimate.motion import paths
from omnimate.vehicle.odometry import dead_reckon

# Three squares each way with the reference robot. In truth, truck a is 1.5 % narrower than described.
squares = paths.umbmark(2.0, 3, link_length=1.0)
recording = omnimate.simulate(program=squares, effects=[Wheelbase("a", ratio=0.985)], seed=1)
omnimate.save_recording(recording, Path("squares"))

# Calibrate: least squares over the whole path, held against the absolute poses at the stops.
calibrated = omnimate.calibrate([omnimate.load_recording("squares")])
for name, truck in calibrated.vehicle.trucks.items():
    print(f"truck {name}: wheelbase {1e3 * truck.wheelbase:.1f} mm")
omnimate.save_vehicle(calibrated.vehicle, Path("calibrated.toml"))

# Where does the drive end, by the wheels of truck a alone, and by the filter over all seven encoders?
by_wheels = dead_reckon(recording, "a")[-1]
by_filter = omnimate.track(recording).pose_a[-1]
assert recording.poses is not None
measured = recording.poses.of("a").pose[-1]
for name, pose in (("measured", measured), ("wheels alone", by_wheels), ("filter", by_filter)):
    print(f"{name:12}  x {pose[0]:+.3f} m, y {pose[1]:+.3f} m")
