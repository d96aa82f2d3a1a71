"""Does a device do what CiA 301, 305, 402 and 406 ask for? Checks by raw frames, against any node."""
