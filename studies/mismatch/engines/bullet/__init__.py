"""Robots of `pybullet_data` and others in PyBullet: faults of geometry and friction, measured labels."""
