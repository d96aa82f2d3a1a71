"""Worlds: where recordings with a known truth come from, all of one form, and the tool's score in each."""
