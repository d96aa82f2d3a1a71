"""The robot on the bus: nodes configured and supervised, PDOs to samples, wheel speeds to drives."""
