"""Every number of the three papers that can be recomputed, recomputed: one row a printed number."""
