"""ROS bags with a plan that says which topic holds which quantity."""
