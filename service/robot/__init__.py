"""The robot on its bus, in its own thread: samples, poses, and the squares that it drives for a session."""
