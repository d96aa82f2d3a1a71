"""Motion control: programs of legs, turns and via-points to wheel speeds, by odometry alone."""
