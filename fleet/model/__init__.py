"""The joint model: effects of robots and of places, from all segments of all robots."""
