"""Maximum-likelihood estimation of a robot's parameters from chains of measured poses."""
