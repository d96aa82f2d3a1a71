"""The numbers of the three papers, recomputed: a row for each printed number."""
