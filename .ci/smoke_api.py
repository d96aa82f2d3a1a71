"""The public Python interface, used on a recording folder by an installed package; see `.ci/smoke`."""

import sys

import omnimate

recording = omnimate.load_recording(sys.argv[1])
calibrated = omnimate.calibrate([recording])
omnimate.save_vehicle(calibrated.vehicle, "calibrated.toml")
assert omnimate.load_vehicle("calibrated.toml").trucks.keys() == recording.vehicle.trucks.keys()
assert omnimate.track(recording).pose_a.shape == (len(recording), 3)
again = omnimate.simulate(calibrated.vehicle)
assert omnimate.diagnose([recording]).verdict
omnimate.save_recording(again, "again")
print(f"API: {len(recording)} samples, {recording.vehicle.name}")
