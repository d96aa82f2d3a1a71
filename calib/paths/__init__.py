"""Calibration from any path with absolute poses, and the design of such paths."""
