"""Who is on a bus: what each node says of itself, the EDS that fits, and a `vehicle.toml` drafted from it."""
