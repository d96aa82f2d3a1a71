"""A night's work on the recordings of many robots: which robot is sick, which place of the floor is bad."""
