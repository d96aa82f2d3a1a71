"""Fleets: their recordings by robot and day, batches, what nights show, and who is told of findings."""
