"""Where to go, as wheel speeds: squares, straights and rounded paths, driven from odometry alone."""
