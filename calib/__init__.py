"""Calibration: better parameters of a robot from its recordings."""
