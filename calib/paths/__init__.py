"""Calibration from any path with absolute poses, and the choice of a path that identifies the parameters."""
