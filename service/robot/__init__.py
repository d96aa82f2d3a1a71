"""The robot in its own process: samples, poses, and the squares that it drives for a session."""
