"""Each truck's heading corrected through the other: recordings or live streams, as trajectories."""
