"""The robot: parameters, counters, poses, odometry, recordings."""
