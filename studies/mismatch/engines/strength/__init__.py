"""Strength: by how many standard deviations an effect shows in a recording, and what else looks like it."""
