"""Where to go, as wheel speeds: programs of legs, turns and via-points, driven from odometry alone."""
