"""Calibration of the linkage between two trucks from the readings of its own encoders."""
