"""A quick test of recordings for any mismatch, and where it is."""
