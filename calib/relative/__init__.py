"""Calibration by relative poses, as scan matching gives them: the robot, and where its sensor sits."""
