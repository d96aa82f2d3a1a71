"""Recordings as a linear model over short windows, about a trajectory that knows the past only."""
