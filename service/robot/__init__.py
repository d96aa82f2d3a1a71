"""The robot on its bus, in a thread of its own: samples, poses, squares driven for a session."""
