"""Calibration: parameters of a robot estimated from its recordings."""
