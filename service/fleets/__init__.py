"""Fleets: their recordings by robot and day, batches, daily lists, findings and their webhooks."""
