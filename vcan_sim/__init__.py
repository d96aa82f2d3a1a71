"""A simulated vehicle: its plant, floor and sonar, and the CANopen nodes that answer for it on a bus."""
