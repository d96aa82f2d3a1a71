"""Gross errors of vehicle.toml, which are looked for before small effects."""
