"""Recordings, as better vehicle parameters."""
