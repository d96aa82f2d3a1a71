"""Candidates that act at a place or time, proposed from what is left of the data given a set of effects."""
