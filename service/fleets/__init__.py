"""Fleets: their recordings by robot and day, batches, daily reports, findings and their webhooks."""
