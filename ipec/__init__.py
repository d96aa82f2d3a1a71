"""Each truck's heading corrected through the other: recordings or a live stream, as corrected trajectories."""
