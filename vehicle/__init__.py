"""What is true of the robot, wherever its data come from: parameters, counts, poses, recordings."""
