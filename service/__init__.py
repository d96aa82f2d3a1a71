"""The calibration over REST: UMBmark, recordings, diagnoses, the robot live, and a page for people."""
