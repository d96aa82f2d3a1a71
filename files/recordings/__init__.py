"""The recording folder: a bus log, poses and laps on one clock."""
