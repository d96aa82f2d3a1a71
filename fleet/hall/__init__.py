"""A simulated hall: many robots, day after day, on a floor with bad places; some robots become faulty."""
