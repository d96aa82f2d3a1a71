"""Scans a bus: the objects of each node, the EDS that fits, and a `vehicle.toml` drafted from them."""
