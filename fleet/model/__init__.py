"""The joint model: effects of robots and of places, from all ways of all robots."""
