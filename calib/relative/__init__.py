"""Calibration of robot and sensor pose by relative poses, such as from scan matching."""
