"""Faults on a simulated bus whose time is simulated too: what the driver does of each is checked."""
