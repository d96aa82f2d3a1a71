"""A quick answer for every night and every robot: is there anything at all in recordings, and where."""
