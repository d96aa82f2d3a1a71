"""Adapters and virtual buses: frames in and out, with their times."""
