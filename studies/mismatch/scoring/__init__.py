"""Scoring: what answers are worth, by labels that the tool has not seen. JSON in."""
