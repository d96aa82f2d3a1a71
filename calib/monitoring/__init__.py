"""Signs that a calibrated robot has changed: drift of what it repeats, and encoders that stand still."""
